//! Keys, and the pointer over the picture.

use super::changes::Step;
use super::compare::Compare;
use super::model::{Model, SaveAs};
use super::orbit::{self, Drag};
use egui::{Key, Modifiers, MouseWheelUnit, PointerButton, Rect, Sense, Ui};
use glam::Vec2;

/// Every key and gesture with its meaning, as F1 lists them.
pub const KEYS: [(&str, &str); 19] = [
    ("left drag", "orbit"),
    ("wheel", "zoom"),
    ("middle or Shift + left drag", "pan"),
    ("right or Ctrl + left drag", "move the first light over the hemisphere"),
    ("double click", "look at the point under the pointer"),
    ("F", "show the whole mesh"),
    ("Ctrl + Z, Ctrl + Y", "undo and redo the last change"),
    ("R", "reset all settings"),
    ("S", "save the picture as PNG; Shift + S: as EXR too"),
    ("C", "compare: off, split, error in false colour"),
    ("drag the line", "move the split"),
    ("E", "measure the error against the f64 reference"),
    ("B", "show or hide the BRDF hemisphere"),
    ("I", "inspect the pixel under the pointer; a click holds it"),
    ("space", "draw continuously, or only on changes"),
    ("+ and −", "exposure"),
    ("P", "show or hide the panel"),
    ("F1", "show or hide this list"),
    ("Esc", "close a list, this list, the window"),
];

/// Applies key presses to `model`.
pub fn keys(ui: &Ui, model: &mut Model) {
    if model.visible.typing || ui.ctx().text_edit_focused() {
        return;
    }
    let list_is_open = egui::Popup::is_any_open(ui.ctx());
    let mut step = None;
    ui.input(|i| {
        // Repeats of a held key are ignored: none of these actions should be repeated.
        let pressed = |wanted: Key| {
            i.events.iter().any(
                |e| matches!(e, egui::Event::Key { key, pressed: true, repeat: false, .. } if *key == wanted),
            )
        };
        if i.modifiers.command && pressed(Key::Z) {
            step = Some(if i.modifiers.shift { Step::Forward } else { Step::Back });
        }
        if i.modifiers.command && pressed(Key::Y) {
            step = Some(Step::Forward);
        }
        model.actions.reset |= pressed(Key::R);
        model.actions.frame |= pressed(Key::F);
        if pressed(Key::S) {
            model.actions.save = Some(if i.modifiers.shift { SaveAs::PngAndExr } else { SaveAs::Png });
        }
        if pressed(Key::C) {
            model.comparison.mode = model.comparison.mode.next();
        }
        model.actions.measure |= pressed(Key::E);
        model.visible.inset ^= pressed(Key::B);
        if pressed(Key::I) {
            if model.inspector.open { model.inspector.close() } else { model.inspector.open = true }
        }
        model.pacing.continuous ^= pressed(Key::Space);
        model.visible.panel ^= pressed(Key::P);
        model.visible.help ^= pressed(Key::F1);
        // Esc closes what is innermost. An open list and an edited text close themselves.
        if pressed(Key::Escape) && !list_is_open {
            if model.visible.help {
                model.visible.help = false;
            } else if model.inspector.open {
                model.inspector.close();
            } else {
                model.actions.close = true;
            }
        }
        for (key, step) in [(Key::Plus, 0.5), (Key::Equals, 0.5), (Key::Minus, -0.5)] {
            if i.key_pressed(key) {
                model.settings.exposure = (model.settings.exposure + step).clamp(-20.0, 20.0);
            }
        }
    });
    if let Some(settings) = step.and_then(|step| model.changes.step(step)) {
        model.settings = settings;
    }
}

/// Applies the pointer over the picture in `rect` to `model`, where it is within `touched`.
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
                    *light = orbit::light_dragged(*light, settings.camera, delta, rect.height());
                }
                (drag, _) => settings.camera = orbit::dragged(settings.camera, drag, delta, rect.height()),
            }
        }
    }
    if picture.hovered() {
        let steps = ui.input(wheel_steps);
        if steps != 0.0 {
            let radius = model.loaded.scene.mesh.bounds().radius;
            model.settings.camera = orbit::zoomed(model.settings.camera, steps, radius);
        }
    }
    if model.comparison.mode != Compare::Alone {
        split(ui, rect, model);
    }
}

/// Lets the inspector follow the pointer over the picture in `rect`, and a click hold its pixel.
fn inspect(ui: &Ui, picture: &egui::Response, rect: Rect, model: &mut Model) {
    /// A click so near a held pixel lets it go [points].
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

/// Steps that the wheel has turned since the last pass. The toolkit's smoothed scrolling would go on after the hand has stopped, so that a
/// picture saved then is not the one that is shown at last.
fn wheel_steps(input: &egui::InputState) -> f32 {
    /// Points of a touchpad per step of a wheel, as the toolkit counts them.
    const STEP: f32 = 40.0;
    /// Steps of a page.
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

/// The kind of a drag over the picture.
fn drag(picture: &egui::Response, modifiers: Modifiers) -> Option<Drag> {
    let by = |button| picture.dragged_by(button);
    if by(PointerButton::Secondary) || by(PointerButton::Primary) && modifiers.ctrl {
        Some(Drag::Light)
    } else if by(PointerButton::Middle) || by(PointerButton::Primary) && modifiers.shift {
        Some(Drag::Pan)
    } else {
        by(PointerButton::Primary).then_some(Drag::Orbit)
    }
}

/// Lets the split between the two pictures be dragged.
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
