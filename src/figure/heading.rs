//! Title and legend of a panel.

use super::layout::{GAP, SAMPLE, TICK, TITLE, letters};
use super::marks;
use super::palette::INK;
use super::panel::{Mark, Panel};
use super::svg::{Anchor, Letters, Svg};
use super::text::{Weight, width, wrap};

/// Letters of semibold weight are this much wider than regular ones, by which lines are broken.
const STRONG: f64 = 1.06;
/// Distance of the lines of a title or of a name relative to their letters.
const LEADING: f64 = 1.3;

/// Name of a mark in the legend.
struct LegendEntry<'a> {
    mark: &'a Mark,
    /// Upper left corner, from that of the heading \[px\].
    at: [f64; 2],
    lines: Vec<String>,
}

/// Title and legend, laid out for the width of a panel.
pub(super) struct Heading<'a> {
    title: Vec<String>,
    legend: Vec<LegendEntry<'a>>,
    /// Height with the space below \[px\].
    pub(super) height: f64,
}

impl<'a> Heading<'a> {
    /// Lays out the heading of a panel that is `room` \[px\] wide: names that do not fit beside each other stand in the next row, and longer
    /// ones have several lines.
    pub(super) fn new(panel: &'a Panel, room: f64) -> Self {
        let title =
            if panel.title.is_empty() { Vec::new() } else { wrap(&panel.title, TITLE, room / STRONG) };
        let mut y = if title.is_empty() {
            0.0
        } else {
            TITLE * (1.0 + LEADING * (title.len() - 1) as f64) + 1.5 * GAP
        };
        let (mut x, mut row) = (0.0, 0.0f64);
        let mut legend = Vec::new();
        for (mark, name) in &panel.marks {
            let Some(name) = name else { continue };
            let lines = wrap(name, TICK, room - 2.0 * SAMPLE - GAP);
            let widest = lines.iter().map(|line| width(line, TICK, Weight::Regular)).fold(0.0, f64::max);
            let needed = 2.0 * SAMPLE + GAP + widest;
            if x > 0.0 && x + needed > room {
                (x, y, row) = (0.0, y + row + GAP, 0.0);
            }
            row = row.max(TICK * (1.0 + LEADING * lines.len().saturating_sub(1) as f64));
            legend.push(LegendEntry { mark, at: [x, y], lines });
            x += needed + 2.5 * GAP;
        }
        let below = if legend.is_empty() { 0.0 } else { row + 1.5 * GAP };
        Self { title, legend, height: y + below }
    }

    /// Draws the heading with its upper left corner at `at`.
    pub(super) fn draw(&self, svg: &mut Svg, at: [f64; 2]) {
        let strong = Letters { weight: Weight::Strong, ..letters(TITLE, INK, Anchor::Start) };
        for (number, line) in self.title.iter().enumerate() {
            svg.text([at[0], at[1] + TITLE * (1.0 + LEADING * number as f64)], line, strong, None);
        }
        for LegendEntry { mark, at: [x, y], lines } in &self.legend {
            let [x, y] = [at[0] + x, at[1] + y];
            marks::sample(svg, mark, [x + SAMPLE, y + TICK * 0.6]);
            for (number, line) in lines.iter().enumerate() {
                let place = [x + 2.0 * SAMPLE + GAP, y + TICK * (1.0 + LEADING * number as f64)];
                svg.text(place, line, letters(TICK, INK, Anchor::Start), None);
            }
        }
    }
}
