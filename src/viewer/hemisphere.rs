//! Inset of the BRDF of a light over the hemisphere. The light can be dragged, directions can be read, and the corner
//! resizes the inset.

use super::inset::Inset;
use super::model::Model;
use super::style;
use super::surface_pane::directions::direction;
use crate::scene::{Emitter, FarLight};
use egui::{Align2, Color32, CursorIcon, FontId, Mesh, Painter, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2};
use glam::Vec2;

/// Distance to the edge of the picture, and from the disc to the edge of its background \[points\].
const MARGIN: f32 = 12.0;
const PADDING: f32 = 8.0;
/// Height of the line below the disc \[points\].
const CAPTION: f32 = 20.0;
/// Smallest side of the disc \[points\].
const LEAST: f32 = 100.0;
/// Side from which circles of equal θ are labelled \[points\].
const NAMED: f32 = 240.0;

/// Disc of directions seen from above, x to the right and y up.
#[derive(Clone, Copy)]
struct Disc {
    centre: Pos2,
    radius: f32,
}

impl Disc {
    /// Returns the position of the direction with the horizontal part `flat`.
    fn place(&self, flat: Vec2) -> Pos2 {
        self.centre + vec2(flat.x, -flat.y) * self.radius
    }

    /// Returns the horizontal part of the direction at `at`, which may be beyond the horizon.
    fn flat(&self, at: Pos2) -> Vec2 {
        let from_centre = (at - self.centre) / self.radius;
        Vec2::new(from_centre.x, -from_centre.y)
    }
}

/// Returns θ and φ \[degrees\] of the direction with the horizontal part `flat`, to a tenth; directions beyond the
/// horizon are moved to it.
fn angles(flat: Vec2) -> [f64; 2] {
    let theta = f64::from(flat.length().min(1.0).asin().to_degrees());
    let phi = if flat == Vec2::ZERO { 0.0 } else { f64::from(flat.to_angle().to_degrees()) };
    // Adding 0 turns −0 into 0.
    [theta, phi].map(|angle| (angle * 10.0).round() / 10.0 + 0.0)
}

/// Shows `inset` over the picture in `rect`.
pub fn show(ui: &Ui, rect: Rect, inset: &Inset, model: &mut Model) {
    let most = (rect.height().min(rect.width()) - 2.0 * (MARGIN + PADDING) - CAPTION).max(LEAST);
    let side = model.inset_side.clamp(LEAST, most);
    let ground = Rect::from_min_size(
        rect.min + vec2(MARGIN, MARGIN),
        vec2(side + 2.0 * PADDING, side + PADDING + CAPTION + PADDING),
    );
    let disc = Disc { centre: ground.min + vec2(1.0, 1.0) * (PADDING + 0.5 * side), radius: 0.5 * side };
    let painter = ui.painter_at(rect);
    // Keeps drags on the inset from turning the camera.
    let whole = ui.interact(ground, ui.id().with("hemisphere"), Sense::click_and_drag());
    draw(&painter, ground, disc, inset);
    if let Some(seen) = model.inspector.light().map(|light| light.pair.view) {
        let at = disc.place(seen.truncate().as_vec2());
        painter.circle_stroke(at, 5.0, Stroke::new(3.0, style::GLASS));
        painter.circle_stroke(at, 5.0, Stroke::new(1.5, style::ACCENT));
    }
    if let Some(toward) = pointed_at(inset, model) {
        painter.circle_stroke(disc.place(toward), 5.0, Stroke::new(2.0, Color32::WHITE));
    }
    light(ui, &painter, disc, inset, model);
    let [theta, phi] = [inset.request.light.theta, inset.request.light.phi];
    let pointed = whole.hover_pos().map(|at| disc.flat(at)).filter(|flat| flat.length() <= 1.0);
    let caption = match pointed.map(angles) {
        Some([theta, phi]) => format!("toward θ {theta:.1}° φ {phi:.1}°"),
        None => format!("BRDF, light θ {theta:.1}° φ {phi:.1}°"),
    };
    let at = pos2(ground.center().x, ground.bottom() - 6.0);
    painter.text(at, Align2::CENTER_BOTTOM, caption, FontId::proportional(11.0), style::TEXT);
    corner(ui, &painter, ground, model);
}

/// Returns the horizontal part of the direction to which the frequency under the pointer in the surface pane diffracts
/// the displayed light.
fn pointed_at(inset: &Inset, model: &Model) -> Option<Vec2> {
    let frequency = model.surface_pane.pointed_frequency()?;
    let light = inset.request.light.direction().truncate().as_dvec2();
    let toward = direction(frequency.into(), model.surface_pane.wavelength(), light)?;
    Some(toward.as_vec2())
}

/// Draws the disc as a mesh of coloured squares, which needs no texture upload when it changes.
fn draw(painter: &Painter, ground: Rect, disc: Disc, inset: &Inset) {
    painter.rect_filled(ground, 6.0, style::GLASS);
    let Disc { centre, radius } = disc;
    painter.circle_filled(centre, radius, Color32::BLACK);
    let mut mesh = Mesh::default();
    let step = 2.0 * radius / inset.side as f32;
    let first = centre - vec2(radius, radius);
    for (index, point) in inset.points.iter().enumerate() {
        let Some([r, g, b]) = *point else { continue };
        let min = first + vec2((index % inset.side) as f32, (index / inset.side) as f32) * step;
        mesh.add_colored_rect(Rect::from_min_size(min, vec2(step, step)), Color32::from_rgb(r, g, b));
    }
    painter.add(mesh);
    painter.circle_stroke(centre, radius, Stroke::new(1.5, style::GRID));
    if 2.0 * radius >= NAMED {
        let faint = Color32::from_white_alpha(40);
        for theta in [30.0f32, 60.0] {
            let around = radius * theta.to_radians().sin();
            painter.circle_stroke(centre, around, Stroke::new(1.0, faint));
            let at = centre + vec2(0.0, -around - 1.0);
            let name = format!("{theta}°");
            painter.text(at, Align2::CENTER_BOTTOM, name, FontId::proportional(10.0), style::FAINT);
        }
    }
}

/// Draws the light and its specular direction. The light can be dragged if it is one of the scene's.
fn light(ui: &Ui, painter: &Painter, disc: Disc, inset: &Inset, model: &mut Model) {
    /// Distance from the light at which it can be grabbed \[points\].
    const REACH: f32 = 9.0;
    let toward = inset.request.light.direction().truncate();
    let (at, specular) = (disc.place(toward), disc.place(-toward));
    painter.circle_filled(at, 3.5, Color32::from_rgb(255, 236, 170));
    painter.circle_stroke(at, 4.5, Stroke::new(1.0, Color32::BLACK));
    painter.circle_stroke(specular, 4.0, Stroke::new(1.0, Color32::from_gray(200)));
    // The light of an inspected pixel is given in the pixel's tangent frame.
    let is_inspected = model.inspector.light().is_some();
    let first = model.settings.lights.first_mut().filter(|_| !is_inspected);
    let Some(Emitter::Far(first)) = first.map(|light| &mut light.emitter) else { return };
    let around = Rect::from_center_size(at, vec2(2.0 * REACH, 2.0 * REACH));
    let handle = ui.interact(around, ui.id().with("light of the hemisphere"), Sense::drag());
    if handle.hovered() || handle.dragged() {
        ui.ctx().set_cursor_icon(CursorIcon::Grab);
        painter.circle_stroke(at, 6.0, Stroke::new(1.0, Color32::WHITE));
    }
    if let Some(to) = handle.interact_pointer_pos().filter(|_| handle.dragged()) {
        let [theta, phi] = angles(disc.flat(to));
        // Just above the horizon, so that light still reaches a plane.
        *first = FarLight { theta: theta.min(89.0), phi, ..*first };
    }
}

/// Shows the corner that resizes the hemisphere; a double click switches between small and large.
fn corner(ui: &Ui, painter: &Painter, ground: Rect, model: &mut Model) {
    /// Side of the corner, and sides that a double click switches between \[points\].
    const GRIP: f32 = 14.0;
    const SIDES: [f32; 2] = [132.0, 420.0];
    let grip = Rect::from_min_max(ground.max - vec2(GRIP, GRIP), ground.max);
    let handle = ui.interact(grip, ui.id().with("corner of the hemisphere"), Sense::click_and_drag());
    let color = if handle.hovered() || handle.dragged() { style::ACCENT } else { style::FAINT };
    for inward in [4.0, 8.0] {
        let line = [ground.max - vec2(inward, 2.0), ground.max - vec2(2.0, inward)];
        painter.line_segment(line, Stroke::new(1.0, color));
    }
    if handle.hovered() || handle.dragged() {
        ui.ctx().set_cursor_icon(CursorIcon::ResizeNwSe);
    }
    if let Some(to) = handle.interact_pointer_pos().filter(|_| handle.dragged()) {
        model.inset_side = (to.x - ground.left() - 2.0 * PADDING).max(LEAST);
    }
    if handle.double_clicked() {
        model.inset_side = if model.inset_side > NAMED { SIDES[0] } else { SIDES[1] };
    }
    handle.on_hover_text("Drag to make the hemisphere larger.\nDouble-click: large or small.");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::geometry::direction as unit;
    use crate::viewer::hand::Hand;
    use crate::viewer::inset::InsetRequest;

    #[test]
    fn the_light_is_dragged_and_the_corner_makes_it_larger() {
        let light = FarLight { theta: 40.0, phi: 90.0, intensity: 1.0, size: 0.0 };
        let request = InsetRequest { light, fine: false };
        let mut hand = Hand::new([900.0, 700.0], 1.0);
        hand.model.settings.lights = vec![light.into()];
        hand.inset = Some(Inset { request, side: 2, points: vec![Some([200, 40, 40]); 4] });
        hand.rest();
        let camera = hand.model.settings.camera;
        let disc = Disc { centre: pos2(12.0 + 8.0 + 66.0, 12.0 + 8.0 + 66.0), radius: 66.0 };
        let to = unit(60.0, 0.0).truncate().as_vec2();
        hand.drag(disc.place(light.direction().truncate()), disc.place(to));
        let Emitter::Far(moved) = hand.model.settings.lights[0].emitter else { panic!("a lamp") };
        assert!((moved.theta - 60.0).abs() < 1.0 && moved.phi.abs() < 1.0, "{moved:?}");
        hand.point(disc.place(Vec2::new(0.5, 0.0)));
        assert!(hand.says("toward θ 30.0° φ 0.0°"));
        let corner = pos2(12.0 + 148.0 - 4.0, 12.0 + 168.0 - 4.0);
        hand.drag(corner, corner + vec2(200.0, 200.0));
        assert!((hand.model.inset_side - 330.0).abs() < 12.0, "{}", hand.model.inset_side);
        assert!(hand.reads("30°") && hand.model.hemisphere().is_some_and(|asked| asked.fine));
        assert_eq!(hand.model.settings.camera, camera);
    }

    #[test]
    fn a_place_on_the_disc_is_its_direction() {
        let disc = Disc { centre: pos2(100.0, 80.0), radius: 60.0 };
        for (theta, phi) in [(30.0, 45.0), (72.5, -120.0), (10.0, 180.0)] {
            let flat = unit(theta, phi).truncate().as_vec2();
            let [t, p] = angles(disc.flat(disc.place(flat)));
            assert!((t - theta).abs() < 0.06 && (p - phi).abs().rem_euclid(360.0) < 0.06, "{t} {p}");
        }
        // y points up, and positions beyond the horizon are moved to it.
        assert_eq!(angles(disc.flat(pos2(100.0, 10.0))), [90.0, 90.0]);
    }
}
