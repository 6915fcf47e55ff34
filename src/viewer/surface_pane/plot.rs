//! Pictures and curves with axes.

use crate::viewer::style;
use egui::{Align2, Color32, FontId, Mesh, Painter, Pos2, Rect, Shape, Stroke, TextureHandle, pos2, vec2};

/// Space for the labels of the vertical and of the horizontal axis \[points\].
pub const LEFT: f32 = 40.0;
pub const BELOW: f32 = 28.0;

/// Rectangle with coordinate axes.
#[derive(Clone, Copy)]
pub struct Axes {
    /// Position in the window.
    pub rect: Rect,
    /// Coordinates of the left and right edge.
    pub x: [f64; 2],
    /// Coordinates of the lower and upper edge.
    pub y: [f64; 2],
}

impl Axes {
    /// Returns the position of a point in the window.
    pub fn place(&self, [x, y]: [f64; 2]) -> Pos2 {
        let part = |value: f64, [low, high]: [f64; 2]| ((value - low) / (high - low)) as f32;
        pos2(
            self.rect.left() + part(x, self.x) * self.rect.width(),
            self.rect.bottom() - part(y, self.y) * self.rect.height(),
        )
    }

    /// Returns the point at the position `place` in the window.
    pub fn point(&self, place: Pos2) -> [f64; 2] {
        let at = |part: f32, [low, high]: [f64; 2]| low + f64::from(part) * (high - low);
        let across = (place.x - self.rect.left()) / self.rect.width();
        let up = (self.rect.bottom() - place.y) / self.rect.height();
        [at(across, self.x), at(up, self.y)]
    }

    /// Draws the background, grid lines and labels at round values, and the `units` of both axes.
    pub fn draw(&self, painter: &Painter, units: [&str; 2]) {
        let small = FontId::proportional(10.0);
        let rect = self.rect;
        painter.rect_filled(rect, 0.0, style::WELL);
        for x in round_values(self.x, (rect.width() / 50.0) as usize) {
            let at = self.place([x, self.y[0]]);
            painter.line_segment([at, pos2(at.x, rect.top())], Stroke::new(1.0, style::GRID));
            painter.text(at + vec2(0.0, 2.0), Align2::CENTER_TOP, number(x), small.clone(), style::FAINT);
        }
        for y in round_values(self.y, (rect.height() / 30.0) as usize) {
            let at = self.place([self.x[0], y]);
            painter.line_segment([at, pos2(rect.right(), at.y)], Stroke::new(1.0, style::GRID));
            painter.text(at - vec2(4.0, 0.0), Align2::RIGHT_CENTER, number(y), small.clone(), style::FAINT);
        }
        let below = pos2(rect.right(), rect.bottom() + 14.0);
        painter.text(below, Align2::RIGHT_TOP, units[0], small.clone(), style::FAINT);
        let beside = pos2(rect.left() + 4.0, rect.top() + 2.0);
        painter.text(beside, Align2::LEFT_TOP, units[1], small, style::FAINT);
    }

    /// Draws `texture` over the whole rectangle.
    pub fn picture(&self, painter: &Painter, texture: &TextureHandle) {
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        painter.image(texture.id(), self.rect, whole, Color32::WHITE);
    }

    /// Draws a curve through `points`.
    pub fn curve(&self, painter: &Painter, points: &[[f64; 2]], color: Color32) {
        let places = points.iter().map(|point| self.place(*point)).collect();
        painter.add(Shape::line(places, Stroke::new(1.5, color)));
    }

    /// Draws bars from the outline of a band: x, lower and upper value.
    pub fn bars(&self, painter: &Painter, outline: &[[f64; 3]], color: Color32) {
        let mut mesh = Mesh::default();
        for step in outline.chunks_exact(2) {
            let (left, right) = (self.place([step[0][0], step[0][2]]), self.place([step[1][0], step[0][1]]));
            mesh.add_colored_rect(Rect::from_two_pos(left, right), color);
        }
        painter.add(mesh);
    }
}

/// Returns up to about `most` round values within a range.
pub fn round_values([low, high]: [f64; 2], most: usize) -> Vec<f64> {
    let span = high - low;
    if !(span.is_finite() && span > 0.0) {
        return Vec::new();
    }
    let least = span / most.max(3) as f64;
    let power = 10f64.powf(least.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].into_iter().map(|d| d * power).find(|step| *step >= least).unwrap_or(least);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

/// Formats a round value without trailing digits.
fn number(x: f64) -> String {
    let rounded = (x * 1e6).round() / 1e6;
    format!("{}", if rounded == 0.0 { 0.0 } else { rounded })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_round_and_within_the_range() {
        assert_eq!(round_values([-10.0, 10.0], 5), [-10.0, -5.0, 0.0, 5.0, 10.0]);
        assert_eq!(round_values([0.13, 0.47], 4), [2.0, 3.0, 4.0].map(|tenths| tenths * 0.1));
        assert!(round_values([1.0, 1.0], 4).is_empty() && round_values([0.0, f64::NAN], 4).is_empty());
        assert_eq!([number(0.30000000000000004), number(-0.0), number(25.0)], ["0.3", "0", "25"]);
    }

    #[test]
    fn a_point_and_its_place_are_each_other_s() {
        let rect = Rect::from_min_max(pos2(10.0, 20.0), pos2(110.0, 70.0));
        let axes = Axes { rect, x: [-2.0, 2.0], y: [0.0, 5.0] };
        assert_eq!(axes.place([-2.0, 5.0]), rect.left_top());
        let [x, y] = axes.point(axes.place([0.7, 3.1]));
        assert!((x - 0.7).abs() < 1e-5 && (y - 3.1).abs() < 1e-5);
    }
}
