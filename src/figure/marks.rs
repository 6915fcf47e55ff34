//! Draws the marks of a panel and their samples in the legend.

use super::layout::{Area, GAP, SAMPLE, TICK, letters};
use super::palette::{Color, PAPER};
use super::panel::{Mark, MarkShape, Panel};
use super::svg::{Anchor, Stroke, Svg};

/// Draws the sample of `mark` in the legend.
pub(super) fn sample(svg: &mut Svg, mark: &Mark, centre: [f64; 2]) {
    let [x, y] = centre;
    match mark {
        Mark::Line { color, width, dashed, .. } => {
            svg.line([x - SAMPLE, y], [x + SAMPLE, y], stroke_of(*color, *width, *dashed));
        }
        Mark::Points { color, shape, radius, .. } => point(svg, centre, *shape, *radius, *color),
        Mark::Band { color, .. } => {
            let [l, r, t, b] = [x - SAMPLE, x + SAMPLE, y - 5.0, y + 5.0];
            svg.polygon(&[[l, t], [r, t], [r, b], [l, b]], *color, 0.25);
        }
        Mark::Note { .. } => {}
    }
}

fn stroke_of(color: Color, width: f64, dashed: bool) -> Stroke {
    Stroke { dash: dashed.then_some([6.0, 4.0]), ..Stroke::new(color, width) }
}

/// Draws `mark` in the coordinates of `panel`, whose plot is `plot`. Lines and areas are clipped; points and notes outside are
/// left out, as is everything that is not finite.
pub(super) fn draw(svg: &mut Svg, mark: &Mark, panel: &Panel, plot: Area) {
    let place = |[x, y]: [f64; 2]| {
        [plot.at[0] + panel.x.share(x) * plot.size[0], plot.bottom() - panel.y.share(y) * plot.size[1]]
    };
    let within = |[x, y]: [f64; 2]| {
        const EDGE: f64 = 1e-9;
        let on = |share: f64| (-EDGE..=1.0 + EDGE).contains(&share);
        on(panel.x.share(x)) && on(panel.y.share(y))
    };
    match mark {
        Mark::Line { points, color, width, dashed } => {
            let points: Vec<_> = points.iter().map(|p| place(*p)).collect();
            svg.clipped(plot.at, plot.size, |svg| svg.polyline(&points, stroke_of(*color, *width, *dashed)));
        }
        Mark::Points { points, color, shape, radius } => {
            for at in points.iter().filter(|p| within(**p)) {
                point(svg, place(*at), *shape, *radius, *color);
            }
        }
        Mark::Band { points, color } => {
            let upper = points.iter().map(|[x, _, high]| place([*x, *high]));
            let lower = points.iter().rev().map(|[x, low, _]| place([*x, *low]));
            let corners: Vec<_> = upper.chain(lower).collect();
            svg.clipped(plot.at, plot.size, |svg| svg.polygon(&corners, *color, 0.25));
        }
        Mark::Note { at, text, color, anchor } if within(*at) => {
            let [x, y] = place(*at);
            let aside = match anchor {
                Anchor::Start => GAP,
                Anchor::Middle => 0.0,
                Anchor::End => -GAP,
            };
            svg.text([x + aside, y + 0.36 * TICK], text, letters(TICK, *color, *anchor), Some(PAPER));
        }
        Mark::Note { .. } => {}
    }
}

fn point(svg: &mut Svg, at: [f64; 2], shape: MarkShape, r: f64, color: Color) {
    let [x, y] = at;
    let edge = Stroke::new(PAPER, 0.8);
    match shape {
        MarkShape::Disc => svg.circle(at, r, Some(color), edge),
        MarkShape::Chip => svg.chip(at, r, color),
        MarkShape::Ring => svg.circle(at, r, None, Stroke::new(color, 1.6)),
        MarkShape::Square => {
            svg.polygon(&[[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]], color, 1.0)
        }
        MarkShape::Triangle => {
            svg.polygon(&[[x, y - 1.2 * r], [x + 1.1 * r, y + r], [x - 1.1 * r, y + r]], color, 1.0)
        }
        MarkShape::Diamond => {
            let d = 1.3 * r;
            svg.polygon(&[[x, y - d], [x + d, y], [x, y + d], [x - d, y]], color, 1.0);
        }
        MarkShape::Cross => {
            svg.line([x - r, y - r], [x + r, y + r], Stroke::new(color, 1.8));
            svg.line([x - r, y + r], [x + r, y - r], Stroke::new(color, 1.8));
        }
    }
}
