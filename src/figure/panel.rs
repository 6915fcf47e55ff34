//! Panel: one coordinate system and its marks.

use super::axis::Axis;
use super::palette::{Color, INK};
use super::raster::Raster;
use super::svg::Anchor;

/// Shape of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkShape {
    /// A disc.
    Disc,
    /// A disc that shows a colour, which is the same on every ground.
    Chip,
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

/// Mark in a panel's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// Straight lines from point to point; a point that is not finite breaks the line.
    Line {
        /// x, y.
        points: Vec<[f64; 2]>,
        /// Colour.
        color: Color,
        /// Width \[px\].
        width: f64,
        /// True for a dashed line.
        dashed: bool,
    },
    /// Single points.
    Points {
        /// x, y.
        points: Vec<[f64; 2]>,
        /// Colour.
        color: Color,
        /// Shape of the points.
        shape: MarkShape,
        /// Half the width of a point \[px\].
        radius: f64,
    },
    /// Area between two values of y.
    Band {
        /// x, lower y, upper y.
        points: Vec<[f64; 3]>,
        /// Colour.
        color: Color,
    },
    /// Text beside a point.
    Note {
        /// x, y.
        at: [f64; 2],
        /// Text of one line.
        text: String,
        /// Colour.
        color: Color,
        /// Part of the text at the point: the start for a text to the right of the point.
        anchor: Anchor,
    },
}

/// Frame around the coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum PlotFrame {
    /// Box with ticks on its left and lower sides.
    Box {
        /// True if a length of x is as long as one of y.
        equal: bool,
    },
    /// Hemisphere from above: x and y are direction cosines (sin θ cos φ, sin θ sin φ), the rim is the horizon. Rings of polar angle and
    /// spokes of azimuth.
    Hemisphere,
}

/// Coordinate system and its marks, in drawing order.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Name by which a style chooses the panel; empty if it is always drawn.
    pub name: &'static str,
    /// Title above the panel; empty for none.
    pub title: String,
    /// Axis to the right.
    pub x: Axis,
    /// Axis upward.
    pub y: Axis,
    /// Frame around the plot.
    pub frame: PlotFrame,
    /// Picture under all marks.
    pub raster: Option<Raster>,
    /// Length of the scale bar in units of x, and its label.
    pub scale_bar: Option<(f64, String)>,
    pub(super) marks: Vec<(Mark, Option<String>)>,
}

impl Panel {
    /// Returns an empty panel with a box around.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            name: "",
            title: String::new(),
            x,
            y,
            frame: PlotFrame::Box { equal: false },
            raster: None,
            scale_bar: None,
            marks: Vec::new(),
        }
    }

    /// Returns the hemisphere of directions from above, filled by `raster`.
    pub fn hemisphere(raster: Raster) -> Self {
        let axis = |label: &str| Axis::linear(label, -1.0, 1.0);
        Self { frame: PlotFrame::Hemisphere, raster: Some(raster), ..Self::new(axis("x"), axis("y")) }
    }

    /// Makes a length of x as long as one of y.
    #[must_use]
    pub fn to_scale(mut self) -> Self {
        self.frame = PlotFrame::Box { equal: true };
        self
    }

    /// Gives the panel the name by which a style chooses it.
    #[must_use]
    pub fn called(mut self, name: &'static str) -> Self {
        self.name = name;
        self
    }

    /// Adds a title.
    #[must_use]
    pub fn titled(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Adds a picture under all marks.
    #[must_use]
    pub fn over(mut self, raster: Raster) -> Self {
        self.raster = Some(raster);
        self
    }

    /// Adds `mark` without an entry in the legend.
    #[must_use]
    pub fn mark(mut self, mark: Mark) -> Self {
        self.marks.push((mark, None));
        self
    }

    /// Adds `mark`, called `name` in the legend.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>, mark: Mark) -> Self {
        self.marks.push((mark, Some(name.into())));
        self
    }

    /// Adds a scale bar, a length of x, in a corner.
    #[must_use]
    pub fn with_scale_bar(mut self, length: f64, label: impl Into<String>) -> Self {
        self.scale_bar = Some((length, label.into()));
        self
    }
}

impl Mark {
    /// Returns a full line.
    pub fn line(points: Vec<[f64; 2]>, color: Color) -> Self {
        Self::Line { points, color, width: 1.8, dashed: false }
    }

    /// Returns a dashed line.
    pub fn dashed(points: Vec<[f64; 2]>, color: Color) -> Self {
        Self::Line { points, color, width: 1.6, dashed: true }
    }

    /// Returns points of ordinary size.
    pub fn points(points: Vec<[f64; 2]>, color: Color, shape: MarkShape) -> Self {
        Self::Points { points, color, shape, radius: 4.0 }
    }

    /// Returns a text to the right of a point.
    pub fn note(at: [f64; 2], text: impl Into<String>) -> Self {
        Self::Note { at, text: text.into(), color: INK, anchor: Anchor::Start }
    }
}
