//! Palette: finds commands, scenes and surfaces by a part of the name.

use super::commands::{COMMANDS, ViewerCommand};
use super::model::{Model, Palette};
use super::style;
use crate::scene::scene_file::BUILT_IN;
use crate::surface::SurfaceSource;
use crate::surface::synth::SurfaceKind;
use egui::{
    Align2, Color32, FontId, Key, Modifiers, Rect, RichText, ScrollArea, Sense, TextEdit, Ui, pos2, vec2,
};

/// Entry of the palette.
#[derive(Clone)]
enum PaletteEntry {
    Command(&'static ViewerCommand),
    Scene(&'static str),
    Surface(SurfaceSource),
}

impl PaletteEntry {
    fn all(model: &Model) -> Vec<Self> {
        let scenes = BUILT_IN.iter().map(|(name, _)| Self::Scene(name));
        let files = model.files.iter().cloned();
        let surfaces =
            files.chain(SurfaceKind::ALL.into_iter().map(SurfaceSource::built_in)).map(Self::Surface);
        COMMANDS.iter().map(Self::Command).chain(scenes).chain(surfaces).collect()
    }

    fn name(&self) -> String {
        match self {
            Self::Command(command) => command.name.to_owned(),
            Self::Scene(name) => format!("scene: {name}"),
            Self::Surface(surface) => format!("height field: {}", surface.name.to_string_lossy()),
        }
    }

    fn keys(&self) -> String {
        match self {
            Self::Command(command) => command.keys(),
            Self::Scene(_) | Self::Surface(_) => String::new(),
        }
    }

    /// Returns true if the name contains every word of `text`.
    fn fits(&self, text: &str) -> bool {
        let name = self.name().to_lowercase();
        text.to_lowercase().split_whitespace().all(|word| name.contains(word))
    }

    fn run(&self, model: &mut Model) {
        match self {
            Self::Command(command) => (command.run)(model),
            Self::Scene(name) => model.actions.open = Some((*name).to_owned()),
            Self::Surface(surface) => model.settings.surface.clone_from(surface),
        }
    }
}

/// Shows the palette over the picture in `rect` if it is open, and runs the chosen entry.
pub fn show(ui: &Ui, rect: Rect, model: &mut Model) {
    const WIDTH: f32 = 420.0;
    if !model.palette.open {
        return;
    }
    let entries: Vec<PaletteEntry> =
        PaletteEntry::all(model).into_iter().filter(|entry| entry.fits(&model.palette.text)).collect();
    let palette = &mut model.palette;
    let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    let last = entries.len().saturating_sub(1);
    if pressed(Key::ArrowDown) {
        palette.chosen += 1;
    }
    if pressed(Key::ArrowUp) {
        palette.chosen = palette.chosen.saturating_sub(1);
    }
    palette.chosen = palette.chosen.min(last);
    let mut run = pressed(Key::Enter).then(|| entries.get(palette.chosen)).flatten();
    if pressed(Key::Escape) {
        palette.open = false;
    }
    egui::Window::new("Commands")
        .title_bar(false)
        .resizable(false)
        .anchor(Align2::CENTER_TOP, vec2(0.0, 24.0))
        .default_height((rect.height() - 80.0).max(80.0))
        .constrain_to(rect)
        .show(ui.ctx(), |ui| {
            ui.set_width(WIDTH.min(rect.width() - 40.0));
            let hint = "part of a command's name; arrow keys choose, Enter runs";
            let text = TextEdit::singleline(&mut palette.text).hint_text(hint).desired_width(f32::INFINITY);
            let edited = ui.add(text);
            edited.request_focus();
            if edited.changed() {
                palette.chosen = 0;
            }
            ScrollArea::vertical().max_height((rect.height() - 110.0).max(80.0)).show(ui, |ui| {
                for (place, entry) in entries.iter().enumerate() {
                    if line(ui, entry, place == palette.chosen) {
                        run = Some(entry);
                    }
                }
                if entries.is_empty() {
                    ui.label(RichText::new("No command has these words.").color(style::FAINT));
                }
            });
        });
    let run = run.cloned();
    if run.is_some() || !model.palette.open {
        model.palette = Palette::default();
    }
    if let Some(entry) = run {
        entry.run(model);
    }
}

/// Shows an entry with its keys. Returns true if it is clicked.
fn line(ui: &mut Ui, entry: &PaletteEntry, is_chosen: bool) -> bool {
    /// Height of a line \[points\].
    const HEIGHT: f32 = 22.0;
    let (rect, line) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click());
    let ground = match (is_chosen, line.hovered()) {
        (true, _) => ui.visuals().selection.bg_fill,
        (false, true) => ui.visuals().widgets.hovered.weak_bg_fill,
        (false, false) => Color32::TRANSPARENT,
    };
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 4.0, ground);
    let font = FontId::proportional(13.0);
    let inner = rect.shrink2(vec2(8.0, 0.0));
    let keys =
        painter.text(inner.right_center(), Align2::RIGHT_CENTER, entry.keys(), font.clone(), style::FAINT);
    // A name that is too long is cut off before the keys.
    let before = Rect::from_min_max(rect.min, pos2(keys.left() - 8.0, rect.bottom()));
    painter.with_clip_rect(before).text(
        inner.left_center(),
        Align2::LEFT_CENTER,
        entry.name(),
        font,
        style::TEXT,
    );
    if is_chosen {
        line.scroll_to_me(None);
    }
    line.clicked()
}

#[cfg(test)]
mod tests {
    use crate::viewer::hand::Hand;
    use egui::{Key, Modifiers};

    #[test]
    fn a_command_runs_by_a_part_of_its_name() {
        for (size, scale) in [([900.0, 1400.0], 1.0), ([640.0, 480.0], 1.5)] {
            let mut hand = Hand::new(size, scale);
            hand.key_held(Key::P, Modifiers::COMMAND);
            assert!(hand.model.palette.open && hand.model.visible.panel);
            hand.write("mesh whole");
            assert!(hand.reads("show the whole mesh") && !hand.says("undo the last change"));
            hand.key(Key::Enter);
            assert!(hand.model.actions.frame && !hand.model.palette.open);
            // Typed text does not trigger keys.
            hand.key_held(Key::P, Modifiers::COMMAND);
            hand.write("field: b");
            hand.key(Key::B);
            assert!(hand.model.visible.inset);
            hand.key(Key::ArrowDown);
            let second = hand.model.files.len() + 1;
            hand.key(Key::Enter);
            let with_b =
                crate::surface::synth::SurfaceKind::ALL.into_iter().filter(|kind| kind.name().contains('b'));
            let named: Vec<&str> = with_b.map(crate::surface::synth::SurfaceKind::name).collect();
            assert_eq!(hand.model.settings.surface.name, named[second]);
        }
    }

    #[test]
    fn the_palette_closes_first_and_says_where_nothing_fits() {
        let mut hand = Hand::new([640.0, 480.0], 2.0);
        hand.key_held(Key::P, Modifiers::COMMAND);
        hand.write("no such thing");
        assert!(hand.says("No command has these words."));
        hand.key(Key::Enter);
        assert!(hand.model.palette.open);
        hand.key(Key::Escape);
        assert!(!hand.model.palette.open && !hand.model.actions.close);
        hand.key_held(Key::P, Modifiers::COMMAND);
        hand.write("disc");
        hand.press("scene: disc");
        assert_eq!(hand.model.actions.open.as_deref(), Some("disc"));
    }
}
