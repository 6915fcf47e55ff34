//! Window of the surface pane.

use super::surface_pane::analysis::{Analysis, height_at, profile};
use super::surface_pane::directions::{direction, period, visible};
use super::surface_pane::plot::{Axes, BELOW, LEFT};
use super::surface_pane::{Pointed, ShownPane, SurfacePane, SurfacePictures};
use crate::figure::palette::ColorMap;
use crate::optics::spectrum::{LONGEST, SHORTEST};
use crate::viewer::model::Model;
use crate::viewer::panel::rows::surface_pane as tips;
use crate::viewer::style;
use egui::{
    Align2, Color32, ColorImage, Painter, Pos2, Rect, Response, RichText, ScrollArea, Sense, Slider, Stroke,
    TextureHandle, TextureOptions, Ui, pos2, vec2,
};
use glam::DVec2;
use std::sync::Arc;

/// Width of a column, and height of curves \[points\].
const COLUMN: f32 = 300.0;
const CURVE: f32 = 96.0;
/// Height at which a wide pane is visible as a whole \[points\].
const TALL: f32 = 520.0;
/// Displayed decades of power below its peak.
const DECADES: f64 = 7.0;
/// Colour of the profile line and of marks.
const LINE: Color32 = Color32::from_rgb(255, 140, 90);
/// Distance within which a mark belongs to the line \[points\].
const NEAR: f32 = 8.0;

/// Data of the light and of the inspected pixel for the plots.
#[derive(Clone, Copy)]
struct LightOverSurface {
    /// Horizontal part of the direction to the light.
    toward: DVec2,
    /// (u, v) of the inspected pixel.
    inspected: Option<DVec2>,
}

/// Shows the pane over the picture in `rect` if it is open.
pub fn show(ui: &Ui, rect: Rect, model: &mut Model) {
    if !model.surface_pane.open {
        return;
    }
    let inspected = model.inspector.light().filter(|light| !light.is_dark());
    let light = LightOverSurface {
        toward: model.shown_light().map_or(DVec2::ZERO, |light| light.direction().truncate().as_dvec2()),
        inspected: inspected.map(|light| light.pair.uvw().truncate()),
    };
    let is_wide = rect.width() > 2.0 * COLUMN + 60.0;
    let width = if is_wide { 2.0 * COLUMN + 12.0 } else { COLUMN.min(rect.width() - 40.0) };
    let mut open = true;
    egui::Window::new("Surface")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .default_size([width, TALL])
        .default_pos(pos2(rect.left() + 40.0, (rect.bottom() - TALL - 70.0).max(rect.top())))
        .constrain_to(rect)
        .show(ui.ctx(), |ui| {
            ScrollArea::vertical().max_height((rect.height() - 70.0).max(80.0)).show(ui, |ui| {
                ui.set_width(width);
                contents(ui, &mut model.surface_pane, light, is_wide);
            });
        });
    model.surface_pane.open = open;
}

fn contents(ui: &mut Ui, pane: &mut SurfacePane, light: LightOverSurface, is_wide: bool) {
    let is_new = pane.missing().is_some();
    let Some(analysis) = pane.analysis.clone().filter(|_| !is_new) else {
        ui.label(if pane.field.is_some() {
            "analysing the heights"
        } else {
            "The height field is not read yet."
        });
        return;
    };
    let mut pointed = None;
    if is_wide {
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| {
                ui.set_width(COLUMN);
                surface(ui, pane, &analysis, &mut pointed);
            });
            ui.vertical(|ui| {
                ui.set_width(COLUMN);
                spectrum(ui, pane, &analysis, light, &mut pointed);
            });
        });
    } else {
        surface(ui, pane, &analysis, &mut pointed);
        spectrum(ui, pane, &analysis, light, &mut pointed);
    }
    if pane.pointed != pointed {
        pane.pointed = pointed;
        // Plots drawn before the pointer was found show the mark at the next pass.
        ui.ctx().request_repaint();
    }
}

/// Shows the heights and the profile below them.
fn surface(ui: &mut Ui, pane: &mut SurfacePane, analysis: &Arc<Analysis>, pointed: &mut Option<Pointed>) {
    ui.horizontal(|ui| {
        for (shown, name) in [(ShownPane::Heights, "heights"), (ShownPane::Relief, "relief")] {
            ui.selectable_value(&mut pane.shown, shown, name).on_hover_text(tips::SHOWN.tip);
        }
        let text = match pane.shown {
            ShownPane::Heights => {
                let [low, high] = analysis.range;
                format!("{low:.0} to {high:.0} nm")
            }
            ShownPane::Relief => format!("heights × {:.3}", analysis.exaggeration),
        };
        ui.label(RichText::new(text).color(style::FAINT)).on_hover_text(tips::HEIGHTS.tip);
    });
    let pictures = pictures(ui, pane, analysis);
    let heights = heights(ui, pane, analysis, &pictures, pointed);
    let line = pane.line.unwrap_or_else(|| middle(analysis));
    let points = profile(&analysis.field, line, 240);
    let length = points.last().map_or(0.0, |point| point[0]);
    let all = points.iter().map(|point| point[1]);
    let [low, high] = [all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max)];
    let margin = (0.05 * (high - low)).max(1e-3);
    let (axes, response, painter) = plot(ui, CURVE, [0.0, length], [low - margin, high + margin]);
    axes.draw(&painter, ["µm along the line", "nm"]);
    axes.curve(&painter, &points, LINE);
    let at = match *pointed {
        Some(Pointed::Place(place)) => along(&heights, line, place),
        _ => None,
    };
    let hovered = response.hover_pos().map(|at| axes.point(at)[0].clamp(0.0, length));
    if let Some(distance) = hovered {
        let part = distance / length;
        *pointed =
            Some(Pointed::Place([0, 1].map(|axis| line[0][axis] + part * (line[1][axis] - line[0][axis]))));
    }
    let text = match hovered.or(at) {
        Some(distance) => {
            let part = distance / length;
            let place = [0, 1].map(|axis| line[0][axis] + part * (line[1][axis] - line[0][axis]));
            let height = height_at(&analysis.field, place);
            painter.circle_filled(axes.place([distance, height]), 3.0, Color32::WHITE);
            format!("{distance:.3} µm: {height:.1} nm, {:+.1} nm from the start", height - points[0][1])
        }
        None => format!("profile over {length:.2} µm, {:.1} nm from lowest to highest", high - low),
    };
    ui.label(RichText::new(text).color(style::FAINT)).on_hover_text(tips::PROFILE.tip);
}

/// Returns the ends of the middle row, from left to right.
fn middle(analysis: &Analysis) -> [[f64; 2]; 2] {
    let half = analysis.field.patch_size()[0] / 2.0;
    [[-half, 0.0], [half, 0.0]]
}

/// Shows the picture of the heights, in which the profile line is drawn.
fn heights(
    ui: &mut Ui,
    pane: &mut SurfacePane,
    analysis: &Analysis,
    pictures: &[TextureHandle; 2],
    pointed: &mut Option<Pointed>,
) -> Axes {
    let [width, height] = analysis.field.patch_size();
    // Height from the aspect ratio, within a square.
    let across = COLUMN.min(ui.available_width()) - LEFT;
    let tall = (across * (height / width) as f32).clamp(40.0, across);
    let (mut axes, response, painter) =
        plot(ui, tall + BELOW, [-width / 2.0, width / 2.0], [-height / 2.0, height / 2.0]);
    let shape = (tall * (width / height) as f32).min(across);
    axes.rect = Rect::from_min_size(axes.rect.min, vec2(shape, tall));
    axes.draw(&painter, ["µm", ""]);
    axes.picture(&painter, &pictures[0]);
    let place = |at: Pos2| {
        let [x, y] = axes.point(at);
        [x.clamp(axes.x[0], axes.x[1]), y.clamp(axes.y[0], axes.y[1])]
    };
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        let from = if response.drag_started() || pane.line.is_none() {
            place(ui.input(|i| i.pointer.press_origin()).unwrap_or(at))
        } else {
            pane.line.map_or([0.0; 2], |line| line[0])
        };
        let to = place(at);
        if (to[0] - from[0]).hypot(to[1] - from[1]) > 1e-3 * width {
            pane.line = Some([from, to]);
        }
    }
    if response.double_clicked() {
        pane.line = None;
    }
    let [from, to] = pane.line.unwrap_or_else(|| middle(analysis)).map(|point| axes.place(point));
    painter.line_segment([from, to], Stroke::new(1.5, LINE));
    painter.circle_filled(from, 3.0, LINE);
    if let Some(at) = response.hover_pos().filter(|at| axes.rect.contains(*at)) {
        let [x, y] = place(at);
        *pointed = Some(Pointed::Place([x, y]));
        let text = format!("x {x:.3} µm, y {y:.3} µm: {:.1} nm", height_at(&analysis.field, [x, y]));
        readout(&painter, axes.rect, &text);
    }
    match pane.pointed {
        Some(Pointed::Frequency(frequency)) => stripes(&painter, axes, DVec2::from(frequency)),
        Some(Pointed::Place(place)) => {
            painter.circle_stroke(axes.place(place), 4.0, Stroke::new(1.5, Color32::WHITE));
        }
        None => {}
    }
    axes
}

/// Returns the distance along `line` of a `place` near it.
fn along(axes: &Axes, line: [[f64; 2]; 2], place: [f64; 2]) -> Option<f64> {
    let [from, to, at] = [line[0], line[1], place].map(DVec2::from);
    let axis = (to - from).normalize_or_zero();
    let distance = (at - from).dot(axis).clamp(0.0, (to - from).length());
    let foot = (from + axis * distance).to_array();
    ((axes.place(foot) - axes.place(place)).length() < NEAR).then_some(distance)
}

/// Draws the crests of a wave of this frequency if they are far enough apart to be visible.
fn stripes(painter: &Painter, axes: Axes, frequency: DVec2) {
    const CLOSEST: f32 = 4.0;
    let painter = painter.with_clip_rect(axes.rect.intersect(painter.clip_rect()));
    let length = frequency.length();
    let apart = axes.rect.width() as f64 / (axes.x[1] - axes.x[0]) / length;
    if length == 0.0 || (apart as f32) < CLOSEST {
        return;
    }
    let (across, along) = (frequency / length, frequency.perp() / length);
    let reach = (axes.x[1] - axes.x[0]).hypot(axes.y[1] - axes.y[0]) / 2.0;
    let most = (reach * length).floor() as i32;
    for n in -most..=most {
        let crest = across * (f64::from(n) / length);
        let ends = [crest - along * reach, crest + along * reach].map(|end| axes.place(end.to_array()));
        painter.line_segment(ends, Stroke::new(1.0, Color32::from_white_alpha(120)));
    }
}

/// Shows the power spectrum and the distribution of heights below it.
fn spectrum(
    ui: &mut Ui,
    pane: &mut SurfacePane,
    analysis: &Arc<Analysis>,
    light: LightOverSurface,
    pointed: &mut Option<Pointed>,
) {
    ui.horizontal(|ui| {
        ui.spacing_mut().slider_width = 110.0;
        let mut nanometres = pane.wavelength() * 1e3;
        let slider = Slider::new(&mut nanometres, SHORTEST * 1e3..=LONGEST * 1e3)
            .suffix(" nm")
            .fixed_decimals(0)
            .text("orders of");
        if ui.add(slider).on_hover_text(tips::WAVELENGTH.tip).changed() {
            pane.wavelength = Some(nanometres * 1e-3);
        }
        ui.label(RichText::new("(?)").color(style::FAINT)).on_hover_text(tips::POWER.tip);
    });
    let pictures = pictures(ui, pane, analysis);
    let side = analysis.side;
    let (axes, response, painter) =
        plot(ui, COLUMN.min(ui.available_width()) - LEFT + BELOW, [-side, side], [-side, side]);
    axes.draw(&painter, ["1/µm", ""]);
    axes.picture(&painter, &pictures[1]);
    let inside = painter.with_clip_rect(axes.rect.intersect(painter.clip_rect()));
    let (middle, radius) = visible(pane.wavelength(), light.toward);
    let pixels = (radius / (2.0 * side)) as f32 * axes.rect.width();
    inside.circle_stroke(axes.place(middle.to_array()), pixels, Stroke::new(1.5, style::ACCENT));
    for found in &analysis.periods {
        let f = DVec2::from_angle(found.direction.to_radians()) / found.length;
        for f in [f, -f] {
            inside.circle_stroke(axes.place(f.to_array()), 5.0, Stroke::new(1.0, LINE));
        }
    }
    if let Some(uv) = light.inspected {
        let at = axes.place((uv / pane.wavelength()).to_array());
        inside.circle_stroke(at, 6.0, Stroke::new(2.0, Color32::WHITE));
    }
    let text = match response.hover_pos().filter(|at| axes.rect.contains(*at)) {
        Some(at) => {
            let f = DVec2::from(axes.point(at));
            *pointed = Some(Pointed::Frequency(f.to_array()));
            let [length, azimuth] = period(f);
            let toward = match direction(f, pane.wavelength(), light.toward) {
                Some(d) => format!("seen at θ {:.1}°", d.length().min(1.0).asin().to_degrees()),
                None => "not seen".to_owned(),
            };
            format!("period {length:.3} µm, azimuth {azimuth:.1}°, {toward}")
        }
        None => analysis.periods.first().map_or("no period stands out".to_owned(), |strongest| {
            format!(
                "strongest period {:.3} µm, azimuth {:.1}°",
                strongest.length,
                strongest.direction.rem_euclid(180.0)
            )
        }),
    };
    readout(&painter, axes.rect, &text);
    distribution(ui, analysis);
}

fn distribution(ui: &mut Ui, analysis: &Analysis) {
    let most = analysis.histogram.iter().map(|bar| bar[2]).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let ends =
        [analysis.histogram.first(), analysis.histogram.last()].map(|bar| bar.map_or(0.0, |bar| bar[0]));
    let [low, high] = if ends[1] > ends[0] { ends } else { [ends[0] - 1.0, ends[0] + 1.0] };
    let (axes, _, painter) = plot(ui, CURVE, [low, high], [0.0, 1.05 * most]);
    axes.draw(&painter, ["nm", "1/nm"]);
    axes.bars(&painter, &analysis.histogram, style::ACCENT);
    let (low, high) = analysis.field.range();
    let text = format!("RMS {:.2} nm, range {:.1} nm", analysis.rms, (high - low) * 1e3);
    ui.label(RichText::new(text).color(style::FAINT)).on_hover_text(tips::HISTOGRAM.tip);
}

/// Allocates a plot `height` points high with its axes.
fn plot(ui: &mut Ui, height: f32, x: [f64; 2], y: [f64; 2]) -> (Axes, Response, Painter) {
    let size = vec2(COLUMN.min(ui.available_width()), height);
    let (whole, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let rect = Rect::from_min_max(pos2(whole.left() + LEFT, whole.top()), whole.max - vec2(0.0, BELOW));
    (Axes { rect, x, y }, response, ui.painter_at(whole))
}

/// Writes `text` at the lower edge of a picture.
fn readout(painter: &Painter, rect: Rect, text: &str) {
    let galley =
        painter.layout(text.to_owned(), egui::FontId::proportional(11.0), style::TEXT, rect.width() - 8.0);
    let ground = Align2::LEFT_BOTTOM.anchor_size(rect.left_bottom(), galley.size() + vec2(8.0, 4.0));
    painter.rect_filled(ground, 0.0, style::GLASS);
    painter.galley(ground.min + vec2(4.0, 2.0), galley, style::TEXT);
}

/// Returns the textures of the heights and of the power spectrum.
fn pictures(ui: &Ui, pane: &mut SurfacePane, analysis: &Arc<Analysis>) -> [TextureHandle; 2] {
    let is_known =
        |known: &&SurfacePictures| Arc::ptr_eq(&known.analysis, analysis) && known.shown == pane.shown;
    if let Some(known) = pane.pictures.as_ref().filter(is_known) {
        return [known.heights.clone(), known.power.clone()];
    }
    let load = |name: &str, size: [usize; 2], colors: Vec<Color32>| {
        ui.ctx().load_texture(name, ColorImage::new(size, colors), TextureOptions::LINEAR)
    };
    let color = |map: ColorMap, share: f64| {
        let [r, g, b] = map.at(share).0;
        Color32::from_rgb(r, g, b)
    };
    let [low, high] = analysis.range;
    let heights: Vec<Color32> = match pane.shown {
        ShownPane::Heights => {
            let share = |h: &f64| (h - low) / (high - low).max(f64::MIN_POSITIVE);
            analysis.heights.values.iter().map(|h| color(ColorMap::Viridis, share(h))).collect()
        }
        ShownPane::Relief => {
            analysis.relief.iter().map(|shade| Color32::from_gray((shade * 255.0).round() as u8)).collect()
        }
    };
    let peak = analysis.power.values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let share = |power: &f64| 1.0 + (power.max(1e-300) / peak).log10() / DECADES;
    let power = analysis.power.values.iter().map(|power| color(ColorMap::Magma, share(power))).collect();
    let pictures = SurfacePictures {
        analysis: analysis.clone(),
        shown: pane.shown,
        heights: load("heights", analysis.heights.size, heights),
        power: load("power", analysis.power.size, power),
    };
    let handles = [pictures.heights.clone(), pictures.power.clone()];
    pane.pictures = Some(pictures);
    handles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::HeightField;
    use crate::viewer::hand::Hand;
    use egui::Key;

    /// Makes a sinusoid along x of 1.25 µm and 100 nm, on 10 µm × 5 µm.
    fn hand(size: [f32; 2], scale: f32) -> Hand {
        let wave = |x: f64, _: f64| 0.1 * (std::f64::consts::TAU * x / 1.25).sin();
        let field = Arc::new(HeightField::from_fn(200, 100, [0.05; 2], wave).unwrap());
        let mut hand = Hand::new(size, scale);
        hand.key(Key::H);
        assert!(hand.says("not read yet"));
        hand.model.surface_pane.take_field(field.clone());
        hand.rest();
        assert!(hand.says("analysing") && hand.model.surface_pane.missing().is_some());
        hand.model.surface_pane.take(Arc::new(Analysis::of(&field).unwrap()));
        hand.rest();
        hand
    }

    #[test]
    fn the_pane_tells_the_numbers_of_the_heights_and_closes_in_its_turn() {
        for (size, scale) in [([1300.0, 850.0], 1.0), ([640.0, 480.0], 2.0)] {
            let mut hand = hand(size, scale);
            let at = hand.position_of("heights");
            let reached = hand.sweep(at);
            let says = |part: &str| reached.iter().any(|text| text.contains(part));
            for part in [
                "-100 to 100 nm",
                "profile over 10.00 µm",
                "strongest period 1.250 µm, azimuth 0.0°",
                "RMS 70.7",
            ] {
                assert!(says(part), "{part} in {size:?}: {reached:?}");
            }
            hand.scroll_to("relief", at);
            hand.press("relief");
            assert!(hand.says("heights × "));
            hand.key(Key::Escape);
            assert!(!hand.model.surface_pane.open && !hand.model.actions.close);
        }
    }

    #[test]
    fn a_line_is_drawn_and_what_is_pointed_at_in_one_is_marked_in_the_others() {
        let mut hand = hand([1300.0, 850.0], 1.0);
        // The picture of the heights is below the row that begins with its name, right of the axis.
        let corner = hand.position_of("heights") + vec2(LEFT - 20.0, 14.0);
        let (from, to) = (corner + vec2(60.0, 30.0), corner + vec2(160.0, 70.0));
        hand.drag(from, to);
        let line = hand.model.surface_pane.line.unwrap();
        assert!(line[1][0] > line[0][0] && line[1][1] < line[0][1], "to the right and down: {line:?}");
        let length = (line[1][0] - line[0][0]).hypot(line[1][1] - line[0][1]);
        assert!(hand.says(&format!("profile over {length:.2} µm")) || hand.says("µm: "));
        hand.point(from.lerp(to, 0.5));
        assert!(matches!(hand.model.surface_pane.pointed, Some(Pointed::Place(_))));
        assert!(hand.says("x ") && hand.says("from the start"), "the profile tells the place");
        // In the spectrum: a period and its direction.
        let spectrum = hand.position_of("orders of") + vec2(-60.0, 120.0);
        hand.point(spectrum);
        let frequency = hand.model.surface_pane.pointed_frequency().expect("a frequency");
        let [length, azimuth] = period(frequency.into());
        assert!(hand.says(&format!("period {length:.3} µm, azimuth {azimuth:.1}°")));
        assert_eq!(hand.model.settings.camera, crate::viewer::settings_of_a_plate().0.camera);
    }
}
