//! Keys, and the pointer over the picture.

use super::commands::{COMMANDS, ViewerCommand};
use super::compare::Compare;
use super::model::Model;
use super::orbit::{self, Drag};
use egui::{Key, Modifiers, MouseWheelUnit, PointerButton, Rect, Sense, Ui};
use glam::Vec2;

/// All pointer gestures with their meanings.
const GESTURES: [(&str, &str); 9] = [
    ("left drag", "orbit"),
    ("wheel", "zoom"),
    ("middle or Shift + left drag", "pan"),
    ("right or Ctrl + left drag", "move the first light over the hemisphere"),
    ("drag a light", "move it: a far one over the sky, a lamp in the scene"),
    ("Shift + right drag", "turn the surroundings"),
    ("double click", "look at the point under the pointer"),
    ("drag the line", "move the split"),
    ("Esc", "close a list or a pane, end a comparison or a recording, close the window"),
];

/// Iterates over all keys and gestures with their meanings, as F1 lists them.
pub fn list() -> impl Iterator<Item = (String, &'static str)> {
    let gestures = GESTURES.iter().map(|(gesture, what)| ((*gesture).to_owned(), *what));
    let commands = COMMANDS.iter().filter(|command| !command.shortcuts.is_empty());
    gestures.chain(commands.map(|command| (command.keys(), command.name)))
}

/// Applies key presses to `model`.
pub fn keys(ui: &Ui, model: &mut Model) {
    if model.visible.typing || ui.ctx().text_edit_focused() || model.file_choice.is_open() {
        return;
    }
    let pressed: Vec<&ViewerCommand> =
        ui.input(|i| COMMANDS.iter().filter(|command| command.is_pressed(i)).collect());
    for command in pressed {
        (command.run)(model);
    }
    // An open list and an edited text close by themselves.
    if ui.input(|i| i.key_pressed(Key::Escape)) && !egui::Popup::is_any_open(ui.ctx()) {
        close_innermost(model);
    }
}

/// Closes the topmost pane, then the comparison, then the recording, then the window.
fn close_innermost(model: &mut Model) {
    if model.visible.help {
        model.visible.help = false;
    } else if model.inspector.open {
        model.inspector.close();
    } else if model.surface_pane.open {
        model.surface_pane.open = false;
    } else if model.comparison.mode != Compare::Alone {
        (model.comparison.mode, model.comparison.whole) = (Compare::Alone, None);
    } else if model.recording.is_some() {
        model.actions.record = true;
    } else {
        model.actions.close = true;
    }
}

/// Applies pointer input on the picture in `rect` to `model`, within `touched`.
pub fn pointer(ui: &mut Ui, touched: Rect, rect: Rect, model: &mut Model) {
    let picture = ui.interact(touched, ui.id().with("picture"), Sense::click_and_drag());
    if picture.double_clicked()
        && let Some(at) = picture.interact_pointer_pos()
    {
        let at = (at - rect.min) * ui.ctx().pixels_per_point();
        model.actions.focus = Some([at.x, at.y]);
    }
    inspect(ui, &picture, rect, model);
    let modifiers = ui.input(|i| i.modifiers);
    if let Some(drag) = drag(&picture, modifiers) {
        let delta = Vec2::new(picture.drag_delta().x, picture.drag_delta().y);
        if delta != Vec2::ZERO {
            let settings = &mut model.settings;
            match (drag, settings.lights.first_mut()) {
                (Drag::Light, Some(light)) => {
                    light.emitter =
                        orbit::light_dragged(light.emitter, settings.camera, delta, rect.height());
                }
                (Drag::Surroundings, _) => {
                    settings.surroundings =
                        orbit::surroundings_dragged(settings.surroundings, delta, rect.height());
                }
                (drag, _) => settings.camera = orbit::dragged(settings.camera, drag, delta, rect.height()),
            }
        }
    }
    if picture.hovered() {
        let steps = ui.input(wheel_steps);
        if steps != 0.0 {
            let radius = model.loaded.scene.bounds().radius;
            model.settings.camera = orbit::zoomed(model.settings.camera, steps, radius);
        }
    }
    if model.comparison.mode != Compare::Alone && model.comparison.whole.is_none() {
        split(ui, rect, model);
    }
}

/// Lets the inspector follow the pointer over the picture in `rect`; a click pins its pixel.
fn inspect(ui: &Ui, picture: &egui::Response, rect: Rect, model: &mut Model) {
    /// Distance from the pinned pixel at which a click releases it [points].
    const REACH: f32 = 6.0;
    let scale = ui.ctx().pixels_per_point();
    let pixel = |at: egui::Pos2| {
        let from_corner = (at - rect.min) * scale;
        [from_corner.x as u32, from_corner.y as u32]
    };
    let inspector = &mut model.inspector;
    inspector.follow(picture.hover_pos().map(pixel));
    if let Some(at) = picture.interact_pointer_pos().filter(|_| inspector.open && picture.clicked()) {
        inspector.click(pixel(at), (REACH * scale) as u32);
    }
}

/// Returns the wheel steps since the last pass. The toolkit's smoothed scrolling would continue after the last event,
/// so that a picture saved in between differs from the final one.
fn wheel_steps(input: &egui::InputState) -> f32 {
    /// Points of a touchpad per step of a wheel, as defined by the toolkit.
    const STEP: f32 = 40.0;
    /// Steps per page.
    const PAGE: f32 = 10.0;
    let steps = input.events.iter().map(|event| match event {
        egui::Event::MouseWheel { unit, delta, .. } => match unit {
            MouseWheelUnit::Point => delta.y / STEP,
            MouseWheelUnit::Line => delta.y,
            MouseWheelUnit::Page => PAGE * delta.y,
        },
        _ => 0.0,
    });
    steps.sum()
}

/// Returns the kind of a drag over the picture.
fn drag(picture: &egui::Response, modifiers: Modifiers) -> Option<Drag> {
    let by = |button| picture.dragged_by(button);
    if by(PointerButton::Secondary) && modifiers.shift {
        Some(Drag::Surroundings)
    } else if by(PointerButton::Secondary) || by(PointerButton::Primary) && modifiers.ctrl {
        Some(Drag::Light)
    } else if by(PointerButton::Middle) || by(PointerButton::Primary) && modifiers.shift {
        Some(Drag::Pan)
    } else {
        by(PointerButton::Primary).then_some(Drag::Orbit)
    }
}

/// Handles drags of the split between the two pictures.
fn split(ui: &mut Ui, rect: Rect, model: &mut Model) {
    /// Distance from the line at which it can be grabbed [points].
    const REACH: f32 = 7.0;
    let x = rect.left() + model.comparison.split * rect.width();
    let line = Rect::from_x_y_ranges(x - REACH..=x + REACH, rect.y_range());
    let handle = ui.interact(line, ui.id().with("split"), Sense::drag());
    if handle.hovered() || handle.dragged() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
    }
    if handle.dragged()
        && let Some(at) = handle.interact_pointer_pos()
    {
        model.comparison.split = ((at.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
    }
}
