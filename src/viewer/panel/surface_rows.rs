//! Rows of the height field.

use super::number_field::{MICROMETRES, NANOMETRES, number, quantity};
use super::{rows, section_opened, short};
use crate::optics::coherence::Coherence;
use crate::optics::reflectance::Reflectance;
use crate::surface::synth::SurfaceKind;
use crate::surface::{Levelling, SurfaceSource};
use crate::viewer::guesses::{Guesses, Scale};
use crate::viewer::model::{LastCoherence, Model};
use crate::viewer::style;
use egui::{ComboBox, Key, Response, RichText, Ui};
use std::ffi::OsStr;

/// Shows the rows of height field, coherence and refractive index.
pub fn show(ui: &mut Ui, model: &mut Model) {
    section_opened(ui, "Surface", model.guesses.are_sought, |ui| {
        rows::show(ui, &rows::SURFACE, |ui| name(ui, &mut model.settings.surface, &model.files));
        let source = &mut model.settings.surface;
        let kind = source.kind();
        if kind.is_none() {
            units(ui, source, &mut model.guesses);
        } else if kind.is_some_and(SurfaceKind::is_random) {
            rows::show(ui, &rows::SEED, |ui| {
                ui.add(number(&mut source.seed).range(0..=9999));
            });
        }
        rows::show(ui, &rows::LEVEL, |ui| level(ui, source));
        coherence(ui, &mut model.settings.optics.coherence, &mut model.last_coherence);
        rows::show(ui, &rows::INDEX, |ui| index(ui, &mut model.settings.optics.reflectance));
        let hint = "Drop a surface, a mesh or a scene on the window.";
        ui.label(RichText::new(hint).small().color(style::FAINT));
    });
}

/// Shows the refractive index, which can be changed, or the name of a material with a spectrum.
fn index(ui: &mut Ui, reflectance: &mut Reflectance) {
    let Some(mut ior) = reflectance.index() else {
        ui.label(reflectance.to_string());
        return;
    };
    if ui.add(number(&mut ior).speed(0.01).range(1.0..=4.0).fixed_decimals(2)).changed() {
        *reflectance = reflectance
            .law()
            .of_index(ior)
            .by(reflectance.stated_theory())
            .polarised(reflectance.polarisation());
    }
}

/// Shows the list of surfaces: opened files, then the generated surfaces.
fn name(ui: &mut Ui, source: &mut SurfaceSource, files: &[SurfaceSource]) {
    let text = source.name.to_string_lossy().into_owned();
    let list = ComboBox::from_id_salt("surface name").selected_text(short(&text)).truncate();
    list.width(ui.available_width()).show_ui(ui, |ui| {
        if let Some(chosen) = choice(ui, Some(source), files) {
            *source = chosen;
        }
    });
}

/// Shows the same list for the comparison, with an entry for the same surface.
pub fn other(ui: &mut Ui, other: &mut Option<SurfaceSource>, files: &[SurfaceSource]) {
    const SAME: &str = "same";
    let text = other.as_ref().map_or(SAME.to_owned(), |other| other.name.to_string_lossy().into_owned());
    let list = ComboBox::from_id_salt("other surface name").selected_text(short(&text)).truncate();
    list.width(ui.available_width()).show_ui(ui, |ui| {
        if ui.selectable_label(other.is_none(), SAME).clicked() {
            *other = None;
        }
        if let Some(chosen) = choice(ui, other.as_ref(), files) {
            *other = Some(chosen);
        }
    });
}

/// Shows the entries of a list of surfaces, with `now` selected. Returns a newly chosen surface.
fn choice(ui: &mut Ui, now: Option<&SurfaceSource>, files: &[SurfaceSource]) -> Option<SurfaceSource> {
    let mut chosen = None;
    for file in files {
        let path = file.name.to_string_lossy();
        let is_now = now.is_some_and(|now| now.name == file.name);
        if ui.selectable_label(is_now, short(&path)).on_hover_text(&*path).clicked() && !is_now {
            chosen = Some(file.clone());
        }
    }
    for kind in SurfaceKind::ALL {
        let is_now = now.is_some_and(|now| now.kind() == Some(kind));
        if ui.selectable_label(is_now, kind.name()).clicked() && !is_now {
            chosen = Some(SurfaceSource::built_in(kind));
        }
    }
    chosen
}

/// Shows the kinds of levelling of the heights of `source`.
pub fn level(ui: &mut Ui, source: &mut SurfaceSource) {
    for level in [Levelling::None, Levelling::Mean, Levelling::Plane] {
        if ui.selectable_label(source.level() == level, level.to_string()).clicked() {
            source.set_level(level);
        }
    }
}

/// Shows the coherence: a Gaussian window of some length, or a number of copies. `last` remembers both.
fn coherence(ui: &mut Ui, coherence: &mut Coherence, last: &mut LastCoherence) {
    rows::show(ui, &rows::COHERENCE, |ui| {
        for (of, name) in [
            (Coherence::Gaussian { length: last.length }, "gaussian"),
            (Coherence::Repeats(last.copies), "repeats"),
        ] {
            let now = std::mem::discriminant(&of) == std::mem::discriminant(coherence);
            if ui.selectable_label(now, name).clicked() && !now {
                *coherence = of;
            }
        }
    });
    match coherence {
        Coherence::Gaussian { length } => {
            rows::show(ui, &rows::LENGTH, |ui| {
                ui.add(quantity(length, &MICROMETRES).speed(0.5).range(1.0..=200.0).fixed_decimals(1));
            });
            last.length = *length;
        }
        Coherence::Repeats(copies) => {
            rows::show(ui, &rows::COPIES, |ui| {
                ui.add(number(&mut copies[0]).speed(0.1).range(1..=1000).suffix(" in x"));
                ui.add(number(&mut copies[1]).speed(0.1).range(1..=1000).suffix(" in y"));
            });
            last.copies = *copies;
        }
    }
}

/// Shows the scales of a height image, which has none in the file, and marks those of `guesses`.
fn units(ui: &mut Ui, source: &mut SurfaceSource, guesses: &mut Guesses) {
    let first = rows::show(ui, &rows::SPACING, |ui| {
        let mut nm = source.pixel_size.unwrap_or([0.1; 2]).map(|um| um * 1e3);
        let mut changed = false;
        let mut is_finished = false;
        for n in &mut nm {
            let field = quantity(n, &NANOMETRES).speed(0.1).range(1.0..=10_000.0).max_decimals(4);
            let field = ui.add(field);
            changed |= field.changed();
            is_finished |= is_entered(ui, &field);
        }
        if changed {
            source.pixel_size = Some(nm.map(|nm| nm * 1e-3));
        }
        guess(ui, guesses, &source.name, Scale::Spacing, changed || is_finished);
    });
    let second = rows::show(ui, &rows::HEIGHT, |ui| {
        let mut nm = source.height.unwrap_or(0.5) * 1e3;
        let field = quantity(&mut nm, &NANOMETRES).speed(1.0).range(0.1..=100_000.0).max_decimals(4);
        let field = ui.add(field);
        if field.changed() {
            source.height = Some(nm * 1e-3);
        }
        let is_set = field.changed() || is_entered(ui, &field);
        guess(ui, guesses, &source.name, Scale::Height, is_set);
    });
    if std::mem::take(&mut guesses.are_sought) {
        ui.scroll_to_rect(first.union(second), Some(egui::Align::Center));
    }
}

/// Returns true if the number in `field` was just entered, even as it was.
fn is_entered(ui: &Ui, field: &Response) -> bool {
    field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter))
}

/// Marks the `scale` of `file` if it is a guess, until the user sets it (`is_set`) or presses the mark.
fn guess(ui: &mut Ui, guesses: &mut Guesses, file: &OsStr, scale: Scale, is_set: bool) {
    const TIP: &str = "The file does not tell it: this is the value of a typical scan. Set the right one, or click to keep it.";
    if !guesses.has(file, scale) {
        return;
    }
    let mark = ui.small_button(RichText::new("a guess: keep?").color(style::FAIR)).on_hover_text(TIP);
    if is_set || mark.clicked() {
        guesses.confirm(file, scale);
    }
}

#[cfg(test)]
mod tests {
    use crate::viewer::guesses::Scale;
    use crate::viewer::hand::Hand;
    use egui::{Key, vec2};

    #[test]
    fn scales_that_are_assumed_come_into_view_and_are_marked_until_they_are_confirmed() {
        for size in [[640.0, 480.0], [900.0, 1400.0]] {
            let mut hand = Hand::new(size, 1.0);
            hand.model.settings.surface.name = "scan.png".into();
            hand.rest();
            assert!(!hand.says("a guess"));
            for scale in [Scale::Spacing, Scale::Height] {
                hand.model.guesses.assume("scan.png".as_ref(), scale);
            }
            hand.rest();
            assert!(hand.reads("sample spacing") && hand.reads("full height"), "in {size:?}");
            assert_eq!(hand.all("a guess: keep?").len(), 2);
            // A number that is entered is none, even the same.
            let field = hand.position_of("sample spacing") + vec2(85.0, 0.0);
            hand.click(field);
            hand.key(Key::Enter);
            assert_eq!(hand.all("a guess: keep?").len(), 1);
            hand.press("a guess: keep?");
            assert!(!hand.says("a guess"));
            // Other files are not concerned.
            hand.model.guesses.assume("other.png".as_ref(), Scale::Height);
            hand.rest();
            assert!(!hand.says("a guess"));
        }
    }
}
