//! One coordinate system and what stands in it.

use super::axis::Axis;
use super::palette::{Color, INK};
use super::raster::Raster;
use super::svg::Anchor;

/// What a point looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkShape {
    /// A disc.
    Disc,
    /// A ring.
    Ring,
    /// A square.
    Square,
    /// A triangle that stands on its base.
    Triangle,
    /// A square that stands on a corner.
    Diamond,
    /// A cross of two diagonals.
    Cross,
}

/// Something drawn in a panel's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// Straight from point to point; a point that is not finite breaks it.
    Line {
        /// x, y.
        points: Vec<[f64; 2]>,
        /// Its colour.
        color: Color,
        /// Its width \[px\].
        width: f64,
        /// Dashed.
        dashed: bool,
    },
    /// Single points.
    Points {
        /// x, y.
        points: Vec<[f64; 2]>,
        /// Their colour.
        color: Color,
        /// What they look like.
        shape: MarkShape,
        /// Half their width \[px\].
        radius: f64,
    },
    /// An area between two values of y.
    Band {
        /// x, lower y, upper y.
        points: Vec<[f64; 3]>,
        /// Its colour.
        color: Color,
    },
    /// Words beside a point.
    Note {
        /// x, y.
        at: [f64; 2],
        /// Words of one line.
        text: String,
        /// Their colour.
        color: Color,
        /// Which side of the point they are on: a start is to its right.
        anchor: Anchor,
    },
}

/// What is around the coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum PlotFrame {
    /// A box with ticks on its left and lower sides.
    Box {
        /// Whether a length of x is as long as one of y.
        equal: bool,
    },
    /// The hemisphere from above: x and y are direction cosines (sin θ cos φ, sin θ sin φ), the rim is the horizon. Rings
    /// of polar angle and spokes of azimuth.
    Hemisphere,
}

/// A coordinate system and what stands in it, in the order that it is drawn in.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// What stands above; empty for nothing.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Upward.
    pub y: Axis,
    /// What is around.
    pub frame: PlotFrame,
    /// The picture under all marks.
    pub raster: Option<Raster>,
    /// A length in units of x, and what is written beside it.
    pub scale_bar: Option<(f64, String)>,
    pub(super) marks: Vec<(Mark, Option<String>)>,
}

impl Panel {
    /// An empty panel with a box around.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            title: String::new(),
            x,
            y,
            frame: PlotFrame::Box { equal: false },
            raster: None,
            scale_bar: None,
            marks: Vec::new(),
        }
    }

    /// The hemisphere of directions from above, filled by `raster`.
    pub fn hemisphere(raster: Raster) -> Self {
        let axis = |label: &str| Axis::linear(label, -1.0, 1.0);
        Self { frame: PlotFrame::Hemisphere, raster: Some(raster), ..Self::new(axis("x"), axis("y")) }
    }

    /// With a length of x as long as one of y.
    #[must_use]
    pub fn to_scale(mut self) -> Self {
        self.frame = PlotFrame::Box { equal: true };
        self
    }

    /// With words above.
    #[must_use]
    pub fn titled(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// With a picture under all marks.
    #[must_use]
    pub fn over(mut self, raster: Raster) -> Self {
        self.raster = Some(raster);
        self
    }

    /// With `mark`, which the legend does not name.
    #[must_use]
    pub fn mark(mut self, mark: Mark) -> Self {
        self.marks.push((mark, None));
        self
    }

    /// With `mark`, which the legend calls `name`.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>, mark: Mark) -> Self {
        self.marks.push((mark, Some(name.into())));
        self
    }

    /// With a length of x drawn in a corner.
    #[must_use]
    pub fn with_scale_bar(mut self, length: f64, label: impl Into<String>) -> Self {
        self.scale_bar = Some((length, label.into()));
        self
    }
}

impl Mark {
    /// A full line.
    pub fn line(points: Vec<[f64; 2]>, color: Color) -> Self {
        Self::Line { points, color, width: 1.8, dashed: false }
    }

    /// A dashed line.
    pub fn dashed(points: Vec<[f64; 2]>, color: Color) -> Self {
        Self::Line { points, color, width: 1.6, dashed: true }
    }

    /// Points of ordinary size.
    pub fn points(points: Vec<[f64; 2]>, color: Color, shape: MarkShape) -> Self {
        Self::Points { points, color, shape, radius: 4.0 }
    }

    /// Words to the right of a point.
    pub fn note(at: [f64; 2], text: impl Into<String>) -> Self {
        Self::Note { at, text: text.into(), color: INK, anchor: Anchor::Start }
    }
}
