//! Handles of the lights of the scene, drawn and dragged in the picture.

use super::model::Model;
use super::{orbit, style};
use crate::scene::lamp::LampShape;
use crate::scene::{Camera, Emitter, FarLight, Lamp, LensProjection, Room};
use egui::{Align2, Color32, CursorIcon, FontId, Painter, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2};
use glam::{DVec2, DVec3, Vec3};

/// Radius of a handle, and distance at which it can be grabbed \[points\].
const RADIUS: f32 = 5.0;
const REACH: f32 = 9.0;
/// Diameter of the sphere of distant lights as a fraction of the picture's height.
const SPHERE: f32 = 0.8;
/// Colour of a light.
const GLOW: Color32 = Color32::from_rgb(255, 236, 170);

/// Camera and picture in which lights are drawn.
#[derive(Clone, Copy)]
struct Frame {
    camera: Camera,
    /// Size of the picture, one pixel per point here.
    size: [u32; 2],
    corner: Pos2,
}

/// Draws a handle for each light over the picture and handles drags within `touched`.
pub fn show(ui: &mut Ui, touched: Rect, picture: Rect, model: &mut Model) {
    let size = [picture.width(), picture.height()].map(|n| n as u32);
    if !model.visible.lights || size.contains(&0) {
        return;
    }
    // The handles move with the picture, which may be a frame behind the settings.
    let seen = model.frame.as_ref().map(|frame| &frame.view);
    let camera = seen.map_or_else(|| model.settings.shown_camera(&model.loaded.scene), |view| view.camera);
    let frame = Frame { camera, size, corner: picture.min };
    let bounds = model.loaded.scene.bounds();
    let room = Room { centre: bounds.centre.as_dvec3(), unit: model.loaded.scene.unit };
    let painter = ui.painter_at(picture);
    for (number, light) in model.settings.lights.iter_mut().enumerate() {
        let drawn = seen.and_then(|view| view.lights.get(number));
        let shown = drawn.map_or(light.emitter, |drawn| placed_as(light.emitter, drawn.emitter));
        let Some(at) = frame.place(&shown).filter(|at| touched.contains(*at)) else { continue };
        let around = Rect::from_center_size(at, vec2(2.0 * REACH, 2.0 * REACH));
        let handle = ui.interact(around, ui.id().with(("light handle", number)), Sense::drag());
        let is_held = handle.dragged();
        if handle.hovered() || is_held {
            ui.ctx().set_cursor_icon(if is_held { CursorIcon::Grabbing } else { CursorIcon::Grab });
            frame.name(&painter, at, number, &shown);
        }
        if let Some(to) = handle.interact_pointer_pos().filter(|to| is_held && *to != at) {
            light.emitter = frame.moved(light.emitter, to);
        }
        frame.draw(&painter, at, &shown, &room);
    }
}

/// Returns `light` at the position of `drawn`, if both are of one kind.
fn placed_as(light: Emitter, drawn: Emitter) -> Emitter {
    match (light, drawn) {
        (Emitter::Far(light), Emitter::Far(drawn)) => {
            FarLight { theta: drawn.theta, phi: drawn.phi, ..light }.into()
        }
        (Emitter::Lamp(light), Emitter::Lamp(drawn)) => Lamp { middle: drawn.middle, ..light }.into(),
        (light, _) => light,
    }
}

impl Frame {
    /// Returns the position of `light` in the picture.
    fn place(&self, light: &Emitter) -> Option<Pos2> {
        let point = match light {
            Emitter::Far(light) => self.camera.target + light.direction() * self.sphere(),
            Emitter::Lamp(lamp) => lamp.middle.as_vec3(),
        };
        self.point(point)
    }

    fn point(&self, point: Vec3) -> Option<Pos2> {
        orbit::pixel_of(&self.camera, point, self.size).map(|at| self.corner + vec2(at.x, at.y))
    }

    /// Returns a point on the line of sight through `at`, and its unit vector away from the viewer.
    fn sight(&self, at: Pos2) -> [Vec3; 2] {
        let from_corner = at - self.corner;
        let sight = self.camera.sight(DVec2::new(from_corner.x.into(), from_corner.y.into()), self.size);
        [sight.origin, sight.direction.normalize()].map(|v| v.as_vec3())
    }

    /// Returns the radius of the sphere of distant lights around the camera's target, which fits into the picture.
    fn sphere(&self) -> f32 {
        let half = match self.camera.lens.projection {
            LensProjection::Perspective { field_of_view } => {
                self.camera.distance * (field_of_view / 2.0).sin()
            }
            LensProjection::Orthographic { height } => height / 2.0,
        };
        let across = self.size[0].min(self.size[1]) as f32 / self.size[1] as f32;
        SPHERE * half * across
    }

    /// Returns true if a distant light shines from the viewer's side.
    fn is_in_front(&self, light: &FarLight) -> bool {
        light.direction().dot(self.camera.eye() - self.camera.target) >= 0.0
    }

    fn moved(&self, light: Emitter, to: Pos2) -> Emitter {
        match light {
            Emitter::Far(light) => self.far_light_moved(light, to).into(),
            Emitter::Lamp(lamp) => self.lamp_moved(lamp, to).into(),
        }
    }

    /// Moves `light` to the point of the sphere under `to`, on its present side; outside the sphere's outline, to the
    /// outline.
    fn far_light_moved(&self, light: FarLight, to: Pos2) -> FarLight {
        let ([origin, ray], radius) = (self.sight(to), self.sphere());
        let from_eye = self.camera.target - origin;
        let along = from_eye.dot(ray);
        let missed = ray * along - from_eye; // from the target to the ray, across it
        let half_chord = (radius.powi(2) - missed.length_squared()).max(0.0).sqrt();
        let side = if self.is_in_front(&light) { -half_chord } else { half_chord };
        let point = if half_chord > 0.0 { missed + ray * side } else { missed.reject_from(from_eye) };
        let direction = point.normalize_or(light.direction());
        // Just above the horizon, so that light still reaches a plane.
        let theta = f64::from(direction.z.clamp(-1.0, 1.0).acos().to_degrees()).min(89.0);
        let phi = f64::from(direction.y.atan2(direction.x).to_degrees());
        // Rounded to a tenth of a degree, to keep command lines short.
        let tenth = |x: f64| (x * 10.0).round() / 10.0;
        FarLight { theta: tenth(theta), phi: tenth(phi), ..light }
    }

    /// Moves `lamp` under `to` at its present depth.
    fn lamp_moved(&self, lamp: Lamp, to: Pos2) -> Lamp {
        let [origin, ray] = self.sight(to);
        let forward = self.camera.forward().as_vec3();
        let depth = (lamp.middle.as_vec3() - origin).dot(forward);
        let moved = (origin + ray * (depth / ray.dot(forward))).as_dvec3();
        // Rounded to a thousandth of the visible width, to keep command lines short.
        let across = f64::from(self.camera.height_at(self.camera.distance));
        let digits = 10f64.powf((1e3 / across).log10().ceil());
        Lamp { middle: (moved * digits).round() / digits, ..lamp }
    }

    /// Draws `light` at `at`: a disc, or for a light behind the scene a ring, and the outline of a lamp.
    fn draw(&self, painter: &Painter, at: Pos2, light: &Emitter, room: &Room) {
        let is_hollow = match light {
            Emitter::Far(light) => !self.is_in_front(light),
            Emitter::Lamp(lamp) => {
                let outline = self.outline(lamp, room);
                painter.add(egui::Shape::closed_line(outline, Stroke::new(1.0, GLOW.gamma_multiply(0.6))));
                false
            }
        };
        painter.circle_filled(at, RADIUS + 1.5, style::GLASS);
        if is_hollow {
            painter.circle_stroke(at, RADIUS - 0.5, Stroke::new(1.5, GLOW));
        } else {
            painter.circle_filled(at, RADIUS, GLOW);
        }
    }

    /// Returns the outline of `lamp` in the picture; empty if a part of it is behind the eye.
    fn outline(&self, lamp: &Lamp, room: &Room) -> Vec<Pos2> {
        const SIDES: usize = 48;
        let corners: Vec<DVec3> = match lamp.shape {
            LampShape::Sphere { diameter } => {
                let toward = self.camera.toward_viewer(lamp.middle).normalize_or(DVec3::Z);
                let (across, along) = toward.any_orthonormal_pair();
                let angle = |i: usize| std::f64::consts::TAU * i as f64 / SIDES as f64;
                let point = |i: usize| across * angle(i).cos() + along * angle(i).sin();
                (0..SIDES).map(|i| lamp.middle + point(i) * (0.5 * diameter)).collect()
            }
            LampShape::Rectangle { .. } => lamp.corners(room).to_vec(),
        };
        corners
            .into_iter()
            .map(|corner| self.point(corner.as_vec3()))
            .collect::<Option<_>>()
            .unwrap_or_default()
    }

    /// Writes number and position of a light beside its handle.
    fn name(&self, painter: &Painter, at: Pos2, number: usize, light: &Emitter) {
        let place = match light {
            Emitter::Far(FarLight { theta, phi, .. }) => format!("θ {theta:.1}°  φ {phi:.1}°"),
            Emitter::Lamp(Lamp { middle, .. }) => format!("{}, {}, {}", middle.x, middle.y, middle.z),
        };
        if matches!(light, Emitter::Far(_))
            && let Some(target) = self.point(self.camera.target)
        {
            painter.line_segment([target, at], Stroke::new(1.0, GLOW.gamma_multiply(0.5)));
        }
        let text = format!("light {}  {place}", number + 1);
        let galley = painter.layout_no_wrap(text, FontId::proportional(12.0), style::TEXT);
        let clip = painter.clip_rect();
        let size = galley.size() + vec2(12.0, 6.0);
        let left = (at.x + 12.0).min(clip.right() - size.x - 20.0);
        let ground = Align2::LEFT_CENTER.anchor_size(pos2(left, (at.y - 20.0).max(clip.top() + 14.0)), size);
        painter.rect_filled(ground, 4.0, style::GLASS);
        painter.galley(ground.min + vec2(6.0, 3.0), galley, style::TEXT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Lens;
    use crate::scene::Light;
    use crate::viewer::hand::Hand;
    use egui::Key;

    fn frame() -> Frame {
        let camera =
            Camera::looking(Vec3::new(1.0, -3.0, 2.0), Vec3::new(0.1, 0.0, 0.2), Lens::perspective(0.6))
                .unwrap();
        Frame { camera, size: [640, 480], corner: pos2(10.0, 20.0) }
    }

    #[test]
    fn a_light_that_is_dragged_stands_below_the_pointer() {
        let frame = frame();
        // Above the horizon and on the viewer's side of the sphere.
        let light = Light::point(20.0, -60.0, 2.0);
        let lamp = Light::parse("sphere:0.1:0.2,0.3,1").unwrap();
        for to in [pos2(330.0, 130.0), pos2(400.0, 200.0)] {
            for light in [&light, &lamp].map(|light| light.emitter) {
                let moved = frame.moved(light, to);
                let at = frame.place(&moved).unwrap();
                assert!((at - to).length() < 1.5, "{light}: {at} where {to} was meant");
                assert!(moved != light);
            }
        }
    }

    #[test]
    fn a_light_stays_on_its_side_above_the_horizon_and_on_the_sphere() {
        let frame = frame();
        for (theta, phi) in [(30.0, -70.0), (60.0, 110.0), (5.0, 0.0)] {
            let light = FarLight { theta, phi, intensity: 3.0, size: 0.5 };
            let front = frame.is_in_front(&light);
            let at = frame.place(&light.into()).unwrap();
            let same = frame.far_light_moved(light, at);
            assert!(
                (same.theta - theta).abs() < 0.2 && same.intensity == 3.0 && same.size == 0.5,
                "{same:?}"
            );
            let near = frame.far_light_moved(light, at + vec2(5.0, 0.0));
            assert_eq!(frame.is_in_front(&near), front);
            let low = frame.far_light_moved(light, pos2(330.0, 5000.0));
            assert_eq!(low.theta, 89.0);
            let beyond = frame.far_light_moved(light, pos2(330.0, -5000.0));
            let up = frame.camera.eye() - frame.camera.target;
            assert!(beyond.direction().dot(up).abs() < 0.35 * up.length(), "on the edge: {beyond:?}");
        }
    }

    #[test]
    fn the_hand_drags_a_light_and_the_camera_stays() {
        let mut hand = Hand::new([900.0, 700.0], 1.0);
        let before = hand.model.settings.clone();
        let size = [hand.picture.width(), hand.picture.height()].map(|n| n as u32);
        let camera = before.camera;
        let at = Frame { camera, size, corner: Pos2::ZERO }.place(&before.lights[0].emitter).unwrap();
        hand.point(at);
        assert!(hand.says("light 1  θ"));
        hand.drag(at, at + vec2(30.0, 12.0));
        assert!(hand.model.settings.lights != before.lights && hand.model.settings.camera == before.camera);
        hand.key(Key::L);
        let moved = hand.model.settings.clone();
        let at = Frame { camera, size, corner: Pos2::ZERO }.place(&moved.lights[0].emitter).unwrap();
        hand.drag(at, at + vec2(30.0, 12.0));
        assert!(hand.model.settings.lights == moved.lights && hand.model.settings.camera != moved.camera);
    }
}
