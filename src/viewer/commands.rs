//! Commands of the window, by key or by name. The keys, their list and the palette read the same rows.

use super::changes::StepDirection;
use super::model::{Model, SaveAs};
use egui::{InputState, Key, Modifiers};

/// Command of the user.
pub struct ViewerCommand {
    /// Description in the list of keys and in the palette.
    pub name: &'static str,
    /// Keys of the command.
    pub shortcuts: &'static [Shortcut],
    /// Action of the command.
    pub run: fn(&mut Model),
}

/// Key with its modifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortcut {
    key: Key,
    // True if Ctrl is held; on a Mac the command key.
    control: bool,
    // True if Shift is held. Ignored for keys other than letters, because typing some of them needs Shift.
    shift: bool,
}

const fn key(key: Key) -> Shortcut {
    Shortcut { key, control: false, shift: false }
}

const fn shift(key: Key) -> Shortcut {
    Shortcut { key, control: false, shift: true }
}

const fn control(key: Key) -> Shortcut {
    Shortcut { key, control: true, shift: false }
}

/// All commands.
pub const COMMANDS: &[ViewerCommand] = &[
    ViewerCommand {
        name: "open a scene, a mesh or a height field",
        shortcuts: &[control(Key::O)],
        run: |model| model.file_choice.open(),
    },
    ViewerCommand {
        name: "save the scene with all settings",
        shortcuts: &[control(Key::S)],
        run: |model| model.file_choice.save_scene(),
    },
    ViewerCommand {
        name: "next surface of the folder",
        shortcuts: &[key(Key::PageDown)],
        run: |model| model.actions.step_surface = Some(StepDirection::Forward),
    },
    ViewerCommand {
        name: "surface before it in the folder",
        shortcuts: &[key(Key::PageUp)],
        run: |model| model.actions.step_surface = Some(StepDirection::Back),
    },
    ViewerCommand {
        name: "show the whole mesh",
        shortcuts: &[key(Key::F)],
        run: |model| model.actions.frame = true,
    },
    ViewerCommand {
        name: "undo the last change",
        shortcuts: &[control(Key::Z)],
        run: |model| step(model, StepDirection::Back),
    },
    ViewerCommand {
        name: "redo what was undone",
        shortcuts: &[control(Key::Y), Shortcut { key: Key::Z, control: true, shift: true }],
        run: |model| step(model, StepDirection::Forward),
    },
    ViewerCommand {
        name: "reset all settings",
        shortcuts: &[key(Key::R)],
        run: |model| model.actions.reset = true,
    },
    ViewerCommand {
        name: "save the picture as PNG",
        shortcuts: &[key(Key::S)],
        run: |model| model.actions.save = Some(SaveAs::Png),
    },
    ViewerCommand {
        name: "save the picture as PNG and EXR",
        shortcuts: &[shift(Key::S)],
        run: |model| model.actions.save = Some(SaveAs::PngAndExr),
    },
    ViewerCommand {
        name: "compare: off, split, or the difference in false colour",
        shortcuts: &[key(Key::C)],
        run: |model| model.comparison.step(),
    },
    ViewerCommand {
        name: "swap the picture and what it is compared with",
        shortcuts: &[key(Key::X)],
        run: |model| model.comparison.swap(),
    },
    ViewerCommand {
        name: "measure the error against the f64 reference",
        shortcuts: &[key(Key::E)],
        run: |model| model.actions.measure = true,
    },
    ViewerCommand {
        name: "show or hide the BRDF hemisphere",
        shortcuts: &[key(Key::B)],
        run: |model| model.visible.inset ^= true,
    },
    ViewerCommand {
        name: "show or hide the lights in the picture",
        shortcuts: &[key(Key::L)],
        run: |model| model.visible.lights ^= true,
    },
    ViewerCommand {
        name: "inspect the pixel under the pointer; a click holds it",
        shortcuts: &[key(Key::I)],
        run: |model| {
            if model.inspector.open { model.inspector.close() } else { model.inspector.open = true }
        },
    },
    ViewerCommand {
        name: "show or hide the height field",
        shortcuts: &[key(Key::H)],
        run: |model| model.surface_pane.open ^= true,
    },
    ViewerCommand {
        name: "draw continuously, or only on changes",
        shortcuts: &[key(Key::Space)],
        run: |model| model.pacing.continuous ^= true,
    },
    ViewerCommand {
        name: "brighter by half a stop",
        shortcuts: &[key(Key::Plus), key(Key::Equals)],
        run: |model| expose(model, 0.5),
    },
    ViewerCommand {
        name: "darker by half a stop",
        shortcuts: &[key(Key::Minus)],
        run: |model| expose(model, -0.5),
    },
    ViewerCommand {
        name: "record a turntable, or stop recording",
        shortcuts: &[key(Key::T)],
        run: |model| model.actions.record = true,
    },
    ViewerCommand {
        name: "copy the command that draws this picture",
        shortcuts: &[key(Key::K)],
        run: |model| model.actions.copy_command = true,
    },
    ViewerCommand {
        name: "find a command by its name",
        shortcuts: &[control(Key::P)],
        run: |model| model.palette.open = true,
    },
    ViewerCommand {
        name: "show or hide the panel",
        shortcuts: &[key(Key::P)],
        run: |model| model.visible.panel ^= true,
    },
    ViewerCommand {
        name: "show or hide the list of keys",
        shortcuts: &[key(Key::F1)],
        run: |model| model.visible.help ^= true,
    },
];

fn step(model: &mut Model, step: StepDirection) {
    if let Some(settings) = model.changes.step(step) {
        model.settings = settings;
    }
}

fn expose(model: &mut Model, stops: f64) {
    model.settings.exposure = (model.settings.exposure + stops).clamp(-20.0, 20.0);
}

impl ViewerCommand {
    /// Returns the keys as listed for the user.
    pub fn keys(&self) -> String {
        let named: Vec<String> = self.shortcuts.iter().map(Shortcut::name).collect();
        named.join(", ")
    }

    /// Returns true if one of the keys was pressed since the last pass. Repeats of a held key are ignored, so that a
    /// command runs once.
    pub fn is_pressed(&self, input: &InputState) -> bool {
        input.events.iter().any(|event| match event {
            egui::Event::Key { key, pressed: true, repeat: false, modifiers, .. } => {
                self.shortcuts.iter().any(|shortcut| shortcut.is(*key, *modifiers))
            }
            _ => false,
        })
    }
}

impl Shortcut {
    fn is(&self, key: Key, modifiers: Modifiers) -> bool {
        let is_letter = key.name().len() == 1 && key.name().chars().all(char::is_alphabetic);
        let shift = modifiers.shift == self.shift || !is_letter;
        key == self.key && shift && modifiers.command == self.control && !modifiers.alt
    }

    /// Returns the name as printed on a keyboard.
    fn name(&self) -> String {
        let key = match self.key {
            Key::Space => "space",
            Key::Plus => "+",
            Key::Minus => "−",
            Key::Equals => "=",
            Key::PageUp => "page up",
            Key::PageDown => "page down",
            other => other.name(),
        };
        let held = [(self.control, "Ctrl + "), (self.shift, "Shift + ")];
        let held: String = held.iter().filter(|(held, _)| *held).map(|(_, name)| *name).collect();
        held + key
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn no_key_does_two_things_and_no_name_stands_twice() {
        let mut shortcuts = Vec::new();
        let mut names = HashSet::new();
        for command in COMMANDS {
            assert!(names.insert(command.name), "{}", command.name);
            for shortcut in command.shortcuts {
                assert!(!shortcuts.contains(shortcut), "{}", shortcut.name());
                shortcuts.push(*shortcut);
            }
        }
    }

    #[test]
    fn what_is_held_beside_a_letter_counts_and_beside_a_sign_does_not() {
        let shifted = Modifiers::SHIFT;
        assert!(key(Key::S).is(Key::S, Modifiers::NONE) && !key(Key::S).is(Key::S, shifted));
        assert!(shift(Key::S).is(Key::S, shifted) && !key(Key::S).is(Key::S, Modifiers::COMMAND));
        assert!(key(Key::Plus).is(Key::Plus, shifted));
        assert!(control(Key::Z).is(Key::Z, Modifiers::COMMAND));
        let redo = Shortcut { key: Key::Z, control: true, shift: true };
        assert!(
            redo.is(Key::Z, Modifiers::COMMAND | shifted)
                && !control(Key::Z).is(Key::Z, Modifiers::COMMAND | shifted)
        );
        assert_eq!([redo.name(), key(Key::Minus).name()], ["Ctrl + Shift + Z", "−"]);
    }
}
