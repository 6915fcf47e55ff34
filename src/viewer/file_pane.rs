//! File dialog.

use super::files::{Chosen, DialogPurpose};
use super::model::Model;
use egui::{Key, Popup, Ui};

/// Shows the dialog if it is open, and opens or writes the chosen file.
pub fn show(ui: &Ui, model: &mut Model) {
    if ui.input(|input| input.key_pressed(Key::Escape)) && !Popup::is_any_open(ui.ctx()) {
        model.file_choice.close();
    }
    let Some(Chosen { purpose, path }) = model.file_choice.update(ui.ctx()) else { return };
    match purpose {
        DialogPurpose::Open => model.actions.open = Some(path.to_string_lossy().into_owned()),
        DialogPurpose::SaveScene => model.actions.save_scene = Some(path),
    }
}

#[cfg(test)]
mod tests {
    use crate::viewer::hand::Hand;
    use egui::{Key, Modifiers};

    #[test]
    fn a_dialog_opens_takes_the_keys_and_escape_closes_it_alone() {
        for (size, scale) in [([1000.0, 800.0], 1.0), ([640.0, 480.0], 1.5)] {
            let mut hand = Hand::new(size, scale);
            for (key, title) in [
                (Key::O, "Open a scene, a mesh or a height field"),
                (Key::S, "Save the scene with all settings"),
            ] {
                hand.key_held(key, Modifiers::COMMAND);
                assert!(hand.model.file_choice.is_open() && hand.says(title), "{title} in {size:?}");
                let inset = hand.model.visible.inset;
                hand.key(Key::B);
                assert_eq!(hand.model.visible.inset, inset, "keys belong to the dialog");
                hand.key(Key::Escape);
                assert!(!hand.model.file_choice.is_open() && !hand.model.actions.close);
                assert!(hand.model.actions.open.is_none() && hand.model.actions.save_scene.is_none());
            }
            assert!(hand.model.actions.save.is_none(), "Ctrl + S is not S");
        }
    }
}
