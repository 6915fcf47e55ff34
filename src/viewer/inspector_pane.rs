//! Pane of the inspector: the numbers of a pixel and its spectrum.

use super::inspector::reading::{LightAt, Reading};
use super::inspector::reference::{Answer, LightAnswer, WAVELENGTHS, wavelength};
use super::model::Model;
use super::panel::rows::{SettingRow, inspected as rows};
use super::style;
use crate::optics::color::{display, xyz_to_linear_srgb};
use crate::optics::spectrum::{LONGEST, SHORTEST, observer};
use egui::{
    Align2, Button, Color32, FontId, Grid, Mesh, Painter, Rect, RichText, ScrollArea, Shape, Stroke, Ui,
    pos2, vec2,
};
use glam::DVec3;

/// Width of the pane's contents [points].
const WIDTH: f32 = 264.0;
/// Width of the picture from which the pane opens over the picture [points].
const LEAST_PICTURE: f32 = 2.0 * WIDTH;
/// Height of the spectrum [points].
const PLOT: f32 = 84.0;
/// Width of a wavelength label below the spectrum [points].
const NAME: f32 = 38.0;
/// Wavelengths whose periods are listed \[µm\].
const LISTED: [f64; 3] = [0.45, 0.55, 0.65];

/// Shows the pane over the picture in `rect`, if it is open.
pub fn show(ui: &Ui, rect: Rect, model: &mut Model) {
    if !model.inspector.open {
        return;
    }
    let mut open = true;
    // In a small window it opens over the panel, and leaves the picture visible.
    let area = if rect.width() < LEAST_PICTURE { ui.ctx().content_rect() } else { rect };
    let inward = if area == rect { 56.0 } else { 22.0 };
    let corner = pos2((area.right() - WIDTH - inward).max(area.left()), area.top() + 12.0);
    egui::Window::new("Inspector")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .default_pos(corner)
        .default_size([WIDTH, (rect.height() - 70.0).max(80.0)])
        .constrain_to(area)
        .show(ui.ctx(), |ui| {
            ScrollArea::vertical().max_height((rect.height() - 70.0).max(80.0)).show(ui, |ui| {
                ui.set_width(WIDTH);
                contents(ui, model);
            });
        });
    if !open {
        model.inspector.close();
    }
}

/// Marks the pinned pixel in the picture in `rect`.
pub fn mark(painter: &Painter, rect: Rect, scale: f32, model: &Model) {
    let inspector = &model.inspector;
    if let Some([x, y]) = inspector.at.filter(|_| inspector.open && inspector.pinned) {
        let at = rect.min + vec2(x as f32 + 0.5, y as f32 + 0.5) / scale;
        painter.circle_stroke(at, 6.0, Stroke::new(3.0, style::GLASS));
        painter.circle_stroke(at, 6.0, Stroke::new(1.0, Color32::WHITE));
    }
}

fn contents(ui: &mut Ui, model: &mut Model) {
    let inspector = &mut model.inspector;
    let how = if inspector.pinned { "held; click it to let go" } else { "click to hold" };
    let Some([x, y]) = inspector.at else {
        ui.label("Point at the picture.");
        return;
    };
    ui.horizontal(|ui| {
        ui.label(format!("pixel {x}, {y}"));
        ui.label(RichText::new(how).color(style::FAINT));
    });
    let Some(reading) = &inspector.reading else {
        ui.label(RichText::new("Nothing of the surface is there.").color(style::FAINT));
        return;
    };
    if reading.lights.len() > 1 {
        ui.horizontal(|ui| {
            for light in 0..reading.lights.len() {
                ui.selectable_value(&mut inspector.light, light, reading.light_name(light));
            }
        });
    }
    let Some(light) = reading.lights.get(inspector.light) else { return };
    let answer = inspector.answer.as_ref();
    let of_light = match answer {
        Some(Answer::Done { lights, .. }) => lights.get(inspector.light),
        _ => None,
    };
    Grid::new("inspector").num_columns(2).spacing(vec2(10.0, 3.0)).show(ui, |ui| {
        if !light.is_dark() {
            directions(ui, light);
        }
        colours(ui, reading, answer, of_light);
    });
    match (answer, of_light) {
        _ if light.is_dark() => {
            ui.label(RichText::new("This light does not reach the pixel.").color(style::FAINT));
        }
        (_, Some(of_light)) => spectrum(ui, &of_light.spectrum),
        (Some(Answer::Preparing(part)), _) => {
            ui.label(format!("preparing the f64 reference, {:.0} %", part * 1e2));
        }
        _ => {
            ui.label("asking the f64 reference");
        }
    }
    let copy = ui.add_enabled(!light.is_dark(), Button::new(rows::COPY.label));
    if copy.on_hover_text(rows::COPY.tip).clicked() {
        ui.ctx().copy_text(light.query());
    }
}

fn row(ui: &mut Ui, row: &SettingRow, value: impl Into<String>) {
    ui.label(RichText::new(row.label).color(style::FAINT)).on_hover_text(row.tip);
    ui.label(value.into()).on_hover_text(row.tip);
    ui.end_row();
}

fn directions(ui: &mut Ui, light: &LightAt) {
    let [to_light, to_viewer] = light.angles().map(|[theta, phi]| format!("θ {theta:.2}°  φ {phi:.2}°"));
    row(ui, &rows::TO_LIGHT, to_light);
    row(ui, &rows::TO_VIEWER, to_viewer);
    let [u, v, w] = light.pair.uvw().to_array();
    row(ui, &rows::UVW, format!("{u:.4}  {v:.4}  {w:.4}"));
    let [longer, shorter] = light.footprint;
    row(ui, &rows::FOOTPRINT, format!("{} × {}", digits(longer), digits(shorter)));
    row(ui, &rows::PERIOD, LISTED.map(|wavelength| length(light.period(wavelength))).join("  "));
    row(ui, &rows::AZIMUTH, format!("{:.1}°", light.azimuth()));
}

fn colours(ui: &mut Ui, reading: &Reading, answer: Option<&Answer>, of_light: Option<&LightAnswer>) {
    let three = |v: DVec3| v.to_array().map(digits).join("  ");
    if let Some(LightAnswer { xyz, .. }) = of_light.filter(|of_light| of_light.xyz != DVec3::ZERO) {
        row(ui, &rows::BRDF, three(*xyz));
    }
    row(ui, &rows::RADIANCE, three(reading.radiance));
    if let Some(Answer::Done { radiance, .. }) = answer {
        row(ui, &rows::REFERENCE, three(*radiance));
        row(ui, &rows::ERROR, error(reading.radiance, *radiance));
    }
}

/// Returns the relative difference of `shown` from `exact` as text.
fn error(shown: DVec3, exact: DVec3) -> String {
    let relative = (shown - exact).length() / exact.length();
    if relative.is_finite() {
        format!("{} %", digits(relative * 1e2))
    } else {
        "none: both are dark".to_owned()
    }
}

/// Formats `x` with three significant digits.
fn digits(x: f64) -> String {
    match x.abs() {
        a if a == 0.0 || (1e-3..1e4).contains(&a) => {
            let before = a.max(1e-3).log10().floor() as i32;
            format!("{x:.*}", (2 - before).clamp(0, 5) as usize)
        }
        _ => format!("{x:.2e}"),
    }
}

/// Formats a length of `micrometres`.
fn length(micrometres: f64) -> String {
    match micrometres {
        l if l < 1.0 => format!("{:.0} nm", l * 1e3),
        l if l < 1e3 => format!("{} µm", digits(l)),
        _ => "∞".to_owned(),
    }
}

/// Draws f over the wavelength, filled with the colours of the wavelengths.
fn spectrum(ui: &mut Ui, values: &[f64]) {
    let (whole, response) = ui.allocate_exact_size(vec2(WIDTH, PLOT), egui::Sense::hover());
    let painter = ui.painter_at(whole);
    let rect = Rect::from_min_max(whole.min + vec2(0.0, 14.0), whole.max - vec2(0.0, 14.0));
    painter.rect_filled(rect, 3.0, style::WELL);
    let most = values.iter().fold(0.0f64, |most, f| most.max(*f));
    let place = |i: usize| {
        let part = (values[i] / most.max(f64::MIN_POSITIVE)) as f32;
        let across = i as f32 / (WAVELENGTHS - 1) as f32;
        pos2(rect.left() + across * rect.width(), rect.bottom() - part * (rect.height() - 4.0))
    };
    let mut under = Mesh::default();
    for i in 0..values.len() {
        let (top, color) = (place(i), color_of(wavelength(i)));
        under.colored_vertex(top, color);
        under.colored_vertex(pos2(top.x, rect.bottom()), color);
        if i > 0 {
            let n = 2 * i as u32;
            under.add_triangle(n - 2, n - 1, n);
            under.add_triangle(n - 1, n, n + 1);
        }
    }
    painter.add(under);
    painter.add(Shape::line((0..values.len()).map(place).collect(), Stroke::new(1.5, style::TEXT)));
    let small = FontId::proportional(10.0);
    let caption = format!("{}, up to {}", rows::SPECTRUM.label, digits(most));
    painter.text(whole.left_top(), Align2::LEFT_TOP, caption, small.clone(), style::FAINT);
    for nanometres in [400, 500, 600, 700] {
        let across = (f64::from(nanometres) / 1e3 - SHORTEST) / (LONGEST - SHORTEST);
        // The first label would begin outside the edge.
        let x = (across as f32 * rect.width()).max(0.5 * NAME);
        let at = pos2(rect.left() + x, whole.bottom());
        let name = format!("{nanometres} nm");
        painter.text(at, Align2::CENTER_BOTTOM, name, small.clone(), style::FAINT);
    }
    response.on_hover_text(rows::SPECTRUM.tip);
}

/// Returns a dim colour for light of `wavelength` \[µm\].
fn color_of(wavelength: f64) -> Color32 {
    let rgb = xyz_to_linear_srgb(observer(wavelength * 1e3)).max(DVec3::ZERO);
    let [r, g, b] = display(rgb * 0.35, 0.0);
    Color32::from_rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::geometry::{Pair, direction};
    use crate::render::frame::View;
    use crate::viewer::hand::Hand;
    use crate::viewer::prepared::Prepared;
    use egui::Key;
    use std::sync::Arc;

    fn reading() -> Reading {
        let (_, scene) = crate::viewer::settings_of_a_plate();
        let pair = Pair::new(direction(0.0, 0.0), direction(30.0, 0.0));
        Reading {
            number: 1,
            prepared: Arc::new(Prepared::pigment_alone().unwrap()),
            view: View::of(&scene, scene.lights.clone()),
            radiance: DVec3::new(0.5, 0.25, 0.125),
            lights: vec![LightAt { pair, footprint: [2e-2, 1e-3] }],
            directions: Vec::new(),
        }
    }

    #[test]
    fn digits_are_three_at_any_size() {
        for (x, text) in [
            (0.0, "0.00000"),
            (1.2345, "1.23"),
            (-0.012345, "-0.0123"),
            (1234.5, "1234"),
            (1.2e-7, "1.20e-7"),
        ] {
            assert_eq!(digits(x), text);
        }
        assert_eq!([length(0.55), length(1.234), length(f64::INFINITY)], ["550 nm", "1.23 µm", "∞"]);
    }

    #[test]
    fn the_pane_opens_follows_the_pointer_is_held_and_closes() {
        for (size, scale) in [([900.0, 700.0], 1.0), ([640.0, 480.0], 2.0)] {
            let mut hand = Hand::new(size, scale);
            hand.key(Key::I);
            assert!(hand.model.inspector.open && hand.says("Point at the picture"));
            let at = pos2(40.0, 300.0);
            hand.point(at);
            let pixel = [at.x, at.y].map(|x| (x * scale) as u32);
            assert_eq!(hand.model.inspector.at, Some(pixel));
            hand.click(at);
            assert!(hand.model.inspector.pinned);
            hand.point(pos2(60.0, 200.0));
            assert_eq!(hand.model.inspector.at, Some(pixel), "held");
            hand.model.inspector.show(Some(reading()));
            let lights =
                vec![LightAnswer { spectrum: vec![0.25; WAVELENGTHS], xyz: DVec3::new(1.0, 2.0, 3.0) }];
            let answer = Answer::Done { radiance: DVec3::new(0.5, 0.25, 0.126), lights };
            hand.model.inspector.take(1, Ok(answer)).unwrap();
            hand.rest();
            for text in ["θ 30.00°  φ 0.00°", "900 nm  1.10 µm  1.30 µm", "1.00  2.00  3.00", "Copy for eval"]
            {
                assert!(hand.says(text), "{text} in {size:?}");
            }
            hand.key(Key::Escape);
            assert!(!hand.model.inspector.open && !hand.model.actions.close);
        }
    }
}
