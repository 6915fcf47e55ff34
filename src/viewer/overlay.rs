//! Overlays of the picture: state, messages, split, error scale, list of keys.

use super::compare::{Compare, Metric, Side};
use super::file_pane;
use super::hemisphere;
use super::input;
use super::inspector_pane;
use super::model::{Comparison, Model, SavingProgress, TaskProgress};
use super::palette_pane;
use super::quality::Quality;
use super::style;
use super::surface_window;
use super::view_settings::ViewSettings;
use crate::figure::palette::ColorMap;
use crate::settings::{Method, Optics};
use crate::surface::{SurfaceSource, prepare};
use egui::{
    Align2, Color32, FontId, Label, Mesh, Painter, Rect, RichText, ScrollArea, Sense, Stroke, Ui, pos2, vec2,
};
use std::path::Path;

/// Distance to the edge [points].
pub const MARGIN: f32 = 12.0;
/// Width of the panel's handle at the right edge [points].
pub const HANDLE: f32 = 16.0;

/// Draws everything over the picture in `rect`.
pub fn show(ui: &mut Ui, rect: Rect, model: &mut Model) {
    let painter = ui.painter_at(rect);
    if model.comparison.mode != Compare::Alone {
        split(&painter, rect, model);
    }
    let inset = model.frame.as_ref().and_then(|frame| frame.inset.clone()).filter(|_| model.visible.inset);
    if let Some(inset) = inset {
        hemisphere::show(ui, rect, &inset, model);
    }
    inspector_pane::mark(&painter, rect, ui.ctx().pixels_per_point(), model);
    state(ui, &painter, rect, model);
    inspector_pane::show(ui, rect, model);
    surface_window::show(ui, rect, model);
    if model.visible.help {
        help(ui, model);
    }
    palette_pane::show(ui, rect, model);
    file_pane::show(ui, model);
}

/// Draws text on a dark background, anchored at `at` and at most `width` wide; returns the background's rectangle.
fn note(painter: &Painter, at: egui::Pos2, anchor: Align2, width: f32, text: &str, color: Color32) -> Rect {
    let galley = painter.layout(text.to_owned(), FontId::proportional(12.0), color, width);
    let size = galley.size() + vec2(14.0, 8.0);
    let rect = anchor.anchor_size(at, size);
    painter.rect_filled(rect, 4.0, style::GLASS);
    painter.galley(rect.min + vec2(7.0, 4.0), galley, color);
    rect
}

/// Shows the running computation, the picture that is saved, the last notice and the last error, from the bottom up.
fn state(ui: &Ui, painter: &Painter, rect: Rect, model: &mut Model) {
    let mut at = rect.left_bottom() + vec2(MARGIN, -MARGIN);
    let width = (rect.width() - 4.0 * MARGIN - HANDLE).max(60.0);
    if let Some((what, part)) = model.sources.in_progress() {
        at.y = progress(painter, at, width, what, part).top() - 6.0;
    } else if let Some((drawing, part)) = model.drawing {
        let what = match drawing {
            Side::Own => "drawing",
            Side::Other => "drawing the comparison",
        };
        at.y = progress(painter, at, width, what, part).top() - 6.0;
    } else if let Some(frame) = &model.frame {
        let is_own = model.sources.full.as_ref().is_some_and(|full| full.number == frame.number);
        let text = match (model.pacing.moving, frame.quality) {
            (true, quality) => format!("{quality}, {:.0} ms", frame.wall_ms),
            (false, Quality::WHOLE) if is_own && frame.samples > 1 => {
                format!("{}, {} of {} samples", Quality::WHOLE, frame.samples, model.settings.samples)
            }
            (false, Quality::WHOLE) if is_own => Quality::WHOLE.to_string(),
            (false, Quality::WHOLE) => "refining".to_owned(),
            (false, quality) => format!("{quality}, refining"),
        };
        at.y = note(painter, at, Align2::LEFT_BOTTOM, width, &text, style::FAINT).top() - 6.0;
    }
    if let Some(TaskProgress { done, of }) = model.recording {
        let what = format!("recording a turntable, {done} of {of} pictures; Esc stops");
        at.y = progress(painter, at, width, &what, done as f32 / of.max(1) as f32).top() - 6.0;
    }
    if let Some(SavingProgress { text, part }) = &model.saving {
        at.y = progress(painter, at, width, text, *part).top() - 6.0;
    }
    for text in [&model.saved, &model.notice].into_iter().flatten() {
        at.y = note(painter, at, Align2::LEFT_BOTTOM, width, text, style::TEXT).top() - 6.0;
    }
    if let Some(failure) = &model.failure {
        let text = format!("{}  (click to dismiss)", failure.text);
        let rect = note(painter, at, Align2::LEFT_BOTTOM, width, &text, style::POOR);
        if ui.interact(rect, ui.id().with("failure"), Sense::click()).clicked() {
            model.failure = None;
        }
    }
}

/// Draws a progress bar above `at`, at most `width` wide; returns its rectangle.
fn progress(painter: &Painter, at: egui::Pos2, width: f32, what: &str, part: f32) -> Rect {
    let text = format!("{what}: {:.0} %", part * 1e2);
    let galley = painter.layout(text, FontId::proportional(12.0), style::TEXT, (width - 16.0).min(320.0));
    let size = vec2(width.min(galley.size().x.max(244.0) + 16.0), galley.size().y + 20.0);
    let ground = Align2::LEFT_BOTTOM.anchor_size(at, size);
    painter.rect_filled(ground, 4.0, style::GLASS);
    let bar =
        Rect::from_min_max(ground.left_bottom() + vec2(8.0, -10.0), ground.right_bottom() - vec2(8.0, 6.0));
    painter.galley(ground.min + vec2(8.0, 5.0), galley, style::TEXT);
    painter.rect_filled(bar, 2.0, style::GRID);
    let done = Rect::from_min_size(bar.min, vec2(bar.width() * part.clamp(0.0, 1.0), bar.height()));
    painter.rect_filled(done, 2.0, style::ACCENT);
    ground
}

/// Names a side of the comparison by its settings, and by its surface if the two sides differ in it.
fn named(surface: Option<&SurfaceSource>, settings: &ViewSettings, optics: &Optics) -> String {
    let settled = settings.optics.as_accurate_as(optics).settled();
    let by = if settled.method == Method::Table { Method::Table.name() } else { optics.basis.name() };
    let mut text = String::new();
    if let Some(surface) = surface {
        let name = Path::new(&surface.name).file_name().unwrap_or_default();
        text += &format!("{}, ", name.to_string_lossy());
        if !surface.prepare.is_empty() {
            text += &format!("{}, ", prepare::describe(&surface.prepare));
        }
    }
    text += &format!("{by}, {} %", (optics.tolerance * 1e6).round() / 1e4);
    for (number, name) in [(settled.terms, "terms"), (optics.wavelengths, "wavelengths")] {
        if let Some(n) = number {
            text += &format!(", {n} {name}");
        }
    }
    text
}

/// Returns the labels left and right of the split.
fn sides(model: &Model) -> [String; 2] {
    let Comparison { mode, optics, surface, prepared, .. } = &model.comparison;
    let own_surface = surface.as_ref().map(|_| &model.applied.surface);
    let other = match mode {
        _ if prepared.is_none() => "not ready yet".to_owned(),
        Compare::Difference(metric) => {
            let total = model.frame.as_ref().and_then(|frame| frame.difference);
            let total = total.map_or(String::new(), |total| format!("{} ", metric.describe(total)));
            format!("{total}against {}", named(surface.as_ref(), &model.applied, optics))
        }
        _ => named(surface.as_ref(), &model.applied, optics),
    };
    [named(own_surface, &model.applied, &model.applied.optics), other]
}

/// Draws the line between the pictures with the name of each setting beside it, or the name of the side that is shown
/// alone.
fn split(painter: &Painter, rect: Rect, model: &Model) {
    let x = rect.left() + model.comparison.own_part() * rect.width();
    let top = rect.top() + MARGIN;
    let [full, other] = sides(model);
    if let Some(side) = model.comparison.whole {
        let text = match side {
            Side::Own => format!("A: {full}"),
            Side::Other => format!("B: {other}"),
        };
        note(painter, pos2(rect.center().x, top), Align2::CENTER_TOP, rect.width(), &text, style::TEXT);
    } else {
        line(painter, rect, x);
        let left = painter.with_clip_rect(Rect::from_min_max(rect.min, pos2(x, rect.bottom())));
        // Names that are too long are cut off instead of wrapped.
        let wide = f32::INFINITY;
        note(&left, pos2(x - MARGIN, top), Align2::RIGHT_TOP, wide, &full, style::TEXT);
        let right = painter.with_clip_rect(Rect::from_min_max(pos2(x, rect.top()), rect.max));
        note(&right, pos2(x + MARGIN, top), Align2::LEFT_TOP, wide, &other, style::TEXT);
    }
    if let Compare::Difference(metric) = model.comparison.mode
        && model.comparison.whole != Some(Side::Own)
    {
        scale(painter, rect, metric);
    }
}

/// Draws the line at `x` between the pictures, with its grip.
fn line(painter: &Painter, rect: Rect, x: f32) {
    painter.line_segment([pos2(x, rect.top()), pos2(x, rect.bottom())], Stroke::new(3.0, style::GLASS));
    painter.line_segment([pos2(x, rect.top()), pos2(x, rect.bottom())], Stroke::new(1.0, Color32::WHITE));
    let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(9.0, 30.0));
    painter.rect_filled(grip, 4.0, Color32::WHITE);
    for dx in [-1.5, 1.5] {
        let y = grip.center().y;
        let line = [pos2(x + dx, y - 7.0), pos2(x + dx, y + 7.0)];
        painter.line_segment(line, Stroke::new(1.0, Color32::from_gray(110)));
    }
}

/// Draws the colour scale of a difference.
fn scale(painter: &Painter, rect: Rect, metric: Metric) {
    const SIZE: egui::Vec2 = vec2(220.0, 10.0);
    /// Steps of the scale; colours are interpolated between them.
    const STEPS: u32 = 20;
    let ground = Rect::from_min_size(
        rect.right_bottom() - vec2(264.0 + MARGIN + HANDLE, 44.0 + MARGIN),
        vec2(264.0, 44.0),
    );
    painter.rect_filled(ground, 4.0, style::GLASS);
    let bar = Rect::from_min_size(ground.min + vec2(22.0, 8.0), SIZE);
    let mut mesh = Mesh::default();
    for i in 0..=STEPS {
        let share = i as f32 / STEPS as f32;
        let x = bar.left() + bar.width() * share;
        let [r, g, b] = ColorMap::Viridis.at(share.into()).0;
        for y in [bar.top(), bar.bottom()] {
            mesh.colored_vertex(pos2(x, y), Color32::from_rgb(r, g, b));
        }
        if i > 0 {
            let n = 2 * i;
            mesh.add_triangle(n - 2, n - 1, n);
            mesh.add_triangle(n - 1, n, n + 1);
        }
    }
    painter.add(mesh);
    let ticks = metric.ticks();
    for (i, name) in ticks.iter().enumerate() {
        let x = bar.left() + bar.width() * i as f32 / (ticks.len() - 1) as f32;
        let at = pos2(x, bar.bottom() + 5.0);
        painter.text(at, Align2::CENTER_TOP, name, FontId::proportional(11.0), style::TEXT);
    }
}

/// Lists the keys and gestures over the width of the window, in two columns if they fit side by side.
fn help(ui: &mut Ui, model: &mut Model) {
    /// Size of the frame and title of the list of keys.
    const FRAME: egui::Vec2 = vec2(40.0, 70.0);
    /// Width of the keys, and the least width of their descriptions in two columns.
    const WIDTHS: [f32; 2] = [160.0, 230.0];
    /// Spaces and the scroll bar.
    const SPACES: f32 = 24.0;
    let room = ui.ctx().content_rect().size() - FRAME;
    let is_wide = room.x > 2.0 * (WIDTHS[0] + WIDTHS[1] + SPACES);
    let count = if is_wide { 2 } else { 1 };
    let whats = (room.x / count as f32 - WIDTHS[0] - SPACES).max(60.0);
    let rows: Vec<(String, &str)> = input::list().collect();
    let columns = rows.chunks(rows.len().div_ceil(count));
    egui::Window::new("Keys")
        .open(&mut model.visible.help)
        .collapsible(false)
        .resizable(false)
        .anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0))
        .default_size(room)
        .show(ui.ctx(), |ui| {
            ScrollArea::vertical().max_height(room.y).show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    for column in columns {
                        ui.vertical(|ui| keys(ui, column, [WIDTHS[0], whats]));
                    }
                });
            });
        });
}

/// Shows keys and their descriptions in two columns with these `widths`.
fn keys(ui: &mut Ui, rows: &[(String, &str)], widths: [f32; 2]) {
    for (key, what) in rows {
        ui.horizontal_top(|ui| {
            let cell = |ui: &mut Ui, width: f32, text: RichText| {
                ui.scope(|ui| {
                    ui.set_width(width);
                    ui.add(Label::new(text).wrap());
                });
            };
            cell(ui, widths[0], RichText::new(key).color(style::ACCENT));
            cell(ui, widths[1], RichText::new(*what));
        });
    }
}
