//! Sizes and rectangles that the parts of a figure share.

use super::palette::Color;
use super::svg::{Anchor, Letters};
use super::text::Weight;

/// Size of the letters of titles \[px\].
pub(super) const TITLE: f64 = 15.0;
/// Size of the letters of ticks, legends and notes \[px\].
pub(super) const TICK: f64 = 12.0;
/// Space between neighbouring elements \[px\].
pub(super) const GAP: f64 = 8.0;
/// Margin around everything and between panels \[px\].
pub(super) const MARGIN: f64 = 24.0;
/// Half the width of a legend's sample \[px\].
pub(super) const SAMPLE: f64 = 11.0;

/// Returns upright letters of regular weight.
pub(super) fn letters(size: f64, color: Color, anchor: Anchor) -> Letters {
    Letters { size, weight: Weight::Regular, color, anchor, upward: false }
}

/// Rectangle of the page.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    /// Upper left corner \[px\].
    pub(super) at: [f64; 2],
    /// Width and height \[px\].
    pub(super) size: [f64; 2],
}

impl Area {
    pub(super) fn right(&self) -> f64 {
        self.at[0] + self.size[0]
    }

    pub(super) fn bottom(&self) -> f64 {
        self.at[1] + self.size[1]
    }

    /// Returns the largest area of this aspect ratio within the area, centred along x.
    pub(super) fn shaped(&self, height_per_width: f64) -> Self {
        let width = self.size[0].min(self.size[1] / height_per_width);
        let size = [width, width * height_per_width];
        Self { at: [self.at[0] + (self.size[0] - size[0]) / 2.0, self.at[1]], size }
    }
}
