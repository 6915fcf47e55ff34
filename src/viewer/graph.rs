//! Graph of frame times.

use super::frame::Pace;
use super::style;
use crate::measure::profile::TimeSummary;
use egui::{Align2, Color32, FontId, Rect, Stroke, Ui, pos2, vec2};
use std::collections::VecDeque;

/// Number of frames in the graph.
const FRAMES: usize = 120;
/// Frame times of the thesis' shader on a GPU of its time \[ms\], from 15 to 5 frames a second.
const THESIS: [f64; 2] = [1e3 / 15.0, 1e3 / 5.0];
/// Opacity of the bars of frames at rest, which have no time budget.
const AT_REST: f32 = 0.45;
/// Ends of the logarithmic axis \[ms\].
const AXIS: [f64; 2] = [4.0, 20_000.0];

/// Times of the most recent frames.
#[derive(Clone, Debug, Default)]
pub struct History {
    frames: VecDeque<(f64, Pace)>,
}

impl History {
    /// Adds a frame that took `milliseconds`.
    pub fn push(&mut self, milliseconds: f64, pace: Pace) {
        if self.frames.len() == FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back((milliseconds, pace));
    }

    /// Returns median and 95th percentile \[ms\] of the frames of `pace`; `None` before the first one.
    pub fn summary(&self, pace: Pace) -> Option<TimeSummary> {
        let times: Vec<f64> =
            self.frames.iter().filter(|frame| frame.1 == pace).map(|frame| frame.0).collect();
        (!times.is_empty()).then(|| TimeSummary::of(&times))
    }
}

/// Returns the position of `milliseconds` on the axis, 0 … 1 from the bottom.
fn height(milliseconds: f64) -> f32 {
    let [low, high] = AXIS.map(f64::ln);
    (((milliseconds.max(1e-9).ln() - low) / (high - low)) as f32).clamp(0.0, 1.0)
}

/// Draws the graph, with the thesis' frame rates as a band and `budget` \[ms\] as a dashed line.
pub fn show(ui: &mut Ui, history: &History, budget: f64) {
    const HEIGHT: f32 = 68.0;
    let (whole, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), egui::Sense::hover());
    let painter = ui.painter_at(whole);
    // Space for the labels of the axis.
    let rect = Rect::from_min_max(whole.min + vec2(40.0, 0.0), whole.max);
    painter.rect_filled(rect, 3.0, style::WELL);
    let y = |ms: f64| rect.bottom() - height(ms) * rect.height();
    let band = Rect::from_x_y_ranges(rect.x_range(), y(THESIS[1])..=y(THESIS[0]));
    painter.rect_filled(band, 0.0, style::BAND);
    let small = FontId::proportional(10.0);
    for ms in [10.0, 100.0, 1000.0, 10_000.0] {
        let line = [pos2(rect.left(), y(ms)), pos2(rect.right(), y(ms))];
        painter.line_segment(line, Stroke::new(1.0, style::GRID));
        let name = if ms < 1000.0 { format!("{ms} ms") } else { format!("{} s", ms * 1e-3) };
        let at = pos2(rect.left() - 5.0, y(ms).clamp(rect.top() + 5.0, rect.bottom() - 5.0));
        painter.text(at, Align2::RIGHT_CENTER, name, small.clone(), style::FAINT);
    }
    let budget_line = [pos2(rect.left(), y(budget)), pos2(rect.right(), y(budget))];
    painter.extend(egui::Shape::dashed_line(&budget_line, Stroke::new(1.0, style::FAINT), 3.0, 3.0));
    let step = rect.width() / FRAMES as f32;
    let first = FRAMES - history.frames.len();
    for (index, &(ms, pace)) in history.frames.iter().enumerate() {
        let x = rect.left() + (first + index) as f32 * step;
        let bar = Rect::from_min_max(pos2(x, y(ms)), pos2(x + (step - 0.5).max(1.0), rect.bottom()));
        let strength = if pace == Pace::Moving { 1.0 } else { AT_REST };
        painter.rect_filled(bar, 0.0, color(ms).gamma_multiply(strength));
    }
    let caption = "band: 5 to 15 fps as in the thesis; dashes: budget; pale: at rest";
    ui.label(egui::RichText::new(caption).size(10.0).color(style::BAND_TEXT));
}

/// Returns green above the thesis' frame rates, amber within and red below.
fn color(milliseconds: f64) -> Color32 {
    match milliseconds {
        ms if ms < THESIS[0] => style::GOOD,
        ms if ms <= THESIS[1] => style::FAIR,
        _ => style::POOR,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_history_forgets_and_the_axis_is_logarithmic() {
        let mut history = History::default();
        assert!(history.summary(Pace::Moving).is_none());
        (0..500).for_each(|i| history.push(f64::from(i), Pace::Moving));
        assert_eq!((history.frames.len(), history.frames[0].0), (FRAMES, 380.0));
        history.push(2000.0, Pace::AtRest);
        let p50 = |pace| history.summary(pace).unwrap().p50;
        assert!(p50(Pace::Moving) < 500.0 && p50(Pace::AtRest) == 2000.0);
        let steps = [height(100.0) - height(10.0), height(1000.0) - height(100.0)];
        assert!((steps[0] - steps[1]).abs() < 1e-6 && height(0.0) == 0.0 && height(1e9) == 1.0);
        assert!(color(50.0) != color(100.0) && color(100.0) != color(300.0));
    }
}
