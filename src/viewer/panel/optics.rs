//! Rows of the optics.

use super::number_field::number;
use super::rows::{self, SettingRow};
use super::section;
use crate::optics::coherence::{Coherence, Windows};
use crate::optics::spectrum::{self, Illuminant};
use crate::settings::{LEAST_TABLE_TOLERANCE, Optics};
use crate::spectra::amplitude::expansion::Basis;
use crate::viewer::model::Model;
use crate::viewer::style;
use egui::{ComboBox, RichText, Ui};

/// Shows the main setting and the spectrum of the light.
pub fn show(ui: &mut Ui, model: &mut Model) {
    section(ui, "Optics", |ui| {
        let optics = &mut model.settings.optics;
        let coherence = optics.coherence;
        setting(ui, "own", optics, coherence);
        rows::show(ui, &rows::ILLUMINANT, |ui| {
            for name in spectrum::BUILT_IN {
                let known = Illuminant::built_in(name).unwrap_or_default();
                if ui.selectable_label(optics.illuminant == known, name.to_uppercase()).clicked() {
                    optics.illuminant = known;
                }
            }
        });
    });
}

/// Shows the rows of one setting; they depend on its method.
pub fn setting(ui: &mut Ui, id: &str, optics: &mut Optics, coherence: Coherence) {
    let finite = matches!(coherence, Coherence::Repeats(_));
    if !finite {
        rows::show(ui, &rows::WINDOWS, |ui| {
            ui.selectable_value(&mut optics.windows, Windows::All, "mean");
            ui.selectable_value(&mut optics.windows, Windows::ONE, "one");
        });
    }
    if finite || optics.windows != Windows::All {
        rows::show(ui, &rows::BASIS, |ui| {
            let all = Basis::ALL.map(|b| (b, b.name()));
            let shown = optics.basis.name();
            choice(ui, &format!("{id} basis"), &mut optics.basis, &all, shown);
        });
    }
    rows::show(ui, &rows::TOLERANCE, |ui| {
        let least = if finite || optics.windows != Windows::All { 0.0 } else { LEAST_TABLE_TOLERANCE };
        let all = [1e-1, 5e-2, 2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 1e-4].map(|t| (t, percent(t)));
        let kept = all.iter().filter(|(t, _)| *t >= least);
        let all: Vec<(f64, &str)> = kept.map(|(t, name)| (*t, name.as_str())).collect();
        let shown = percent(optics.tolerance);
        choice(ui, &format!("{id} tolerance"), &mut optics.tolerance, &all, &shown);
    });
    if finite || optics.windows != Windows::All {
        count(ui, &rows::TERMS, &mut optics.terms, 10, 1..=64);
    }
    match coherence {
        Coherence::Gaussian { .. } => count(ui, &rows::WAVELENGTHS, &mut optics.wavelengths, 32, 4..=512),
        Coherence::Repeats(_) => {
            rows::show(ui, &rows::WAVELENGTHS, |ui| {
                ui.label(RichText::new("those of the grating's orders").color(style::FAINT));
            });
        }
    }
}

fn choice<T: PartialEq + Copy>(ui: &mut Ui, id: &str, now: &mut T, all: &[(T, &str)], shown: &str) {
    let list = ComboBox::from_id_salt(id).selected_text(shown).width(ui.available_width());
    list.show_ui(ui, |ui| {
        for (item, name) in all {
            ui.selectable_value(now, *item, *name);
        }
    });
}

/// Shows a number that follows from the tolerance unless the user sets it; `first` is the value to start with.
fn count(
    ui: &mut Ui,
    row: &SettingRow,
    number_set: &mut Option<usize>,
    first: usize,
    range: std::ops::RangeInclusive<usize>,
) {
    rows::show(ui, row, |ui| {
        let mut automatic = number_set.is_none();
        if ui.checkbox(&mut automatic, "automatic").changed() {
            *number_set = (!automatic).then_some(first);
        }
        if let Some(n) = number_set {
            ui.add(number(n).speed(0.2).range(range));
        }
    });
}

/// Formats a fraction in percent.
pub fn percent(part: f64) -> String {
    format!("{} %", (part * 1e6).round() / 1e4)
}
