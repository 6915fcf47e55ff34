//! Labelled figures, as SVG and, from the same SVG, as PNG.
//!
//! A [`Figure`] is rows of [`Panel`]s under a title and over a caption; a panel has two [`Axis`], perhaps a [`Raster`] with a
//! colour bar, and [`Mark`]s: lines, points, bands, notes. The font is embedded, so a figure is the same on every machine.
//!
//! ```
//! use diffract::figure::{Axis, Figure, Mark, Panel, palette};
//! use diffract::notes::Notes;
//! let line = Mark::line(vec![[1.0, 0.1], [10.0, 0.01]], palette::BLUE);
//! let panel = Panel::new(Axis::log("frame time [ms]", 1.0, 10.0), Axis::log("error", 1e-2, 1e-1)).named("optimal", line);
//! let figure = Figure::new("Speed against error").row(vec![panel]).caption("Measured on one machine.");
//! assert!(figure.svg(&Notes::default())?.contains("frame time"));
//! # Ok::<(), diffract::error::Error>(())
//! ```

mod axis;
mod draw;
mod layout;
mod marks;
pub mod palette;
mod panel;
mod raster;
mod svg;
mod text;

pub use axis::{Axis, AxisScale, Tick, number};
pub use palette::{Color, ColorMap};
pub use panel::{Mark, MarkShape, Panel, PlotFrame};
pub use raster::{ColorScale, Raster};
pub use svg::Anchor;

use crate::error::{Error, Result};
use crate::notes::Notes;
use crate::output;
use layout::{Area, TITLE, letters};
use palette::{INK, PAPER, QUIET};
use resvg::{tiny_skia, usvg};
use std::io::Write;
use std::path::Path;
use svg::{Letters, Svg};
use text::Weight;

/// Pixels of a PNG for one of the SVG: sharp on today's screens and in print at the width of a column.
const PNG_SCALE: f64 = 2.0;
/// Margin around everything and between panels \[px\].
const MARGIN: f64 = 24.0;
/// Size of the letters of the figure's title and of captions \[px\].
const HEADLINE: f64 = 18.0;
const CAPTION: f64 = 12.5;
/// Height of a caption's line relative to its letters.
const LEADING: f64 = 1.45;

/// Figure: panels in rows, with a title and a caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    title: String,
    caption: String,
    rows: Vec<Vec<Panel>>,
    panel: [f64; 2],
}

impl Figure {
    /// Returns an empty figure called `title`; an empty title takes no room.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), caption: String::new(), rows: Vec::new(), panel: [640.0, 440.0] }
    }

    /// Adds a row of panels below the others.
    #[must_use]
    pub fn row(mut self, panels: Vec<Panel>) -> Self {
        self.rows.push(panels);
        self
    }

    /// Adds `text` below the panels, wrapped; a line break begins a new line.
    #[must_use]
    pub fn caption(mut self, text: impl Into<String>) -> Self {
        self.caption = text.into();
        self
    }

    /// Sets the size of the panels to `width` × `height` \[px\], labels included.
    #[must_use]
    pub fn panel_size(mut self, width: f64, height: f64) -> Self {
        self.panel = [width, height];
        self
    }

    /// Returns the figure as SVG, with `notes` as its metadata.
    ///
    /// # Errors
    /// A raster that is empty or too large.
    pub fn svg(&self, notes: &Notes) -> Result<String> {
        self.drawn(notes).map(|(svg, _)| svg)
    }

    fn drawn(&self, notes: &Notes) -> Result<(String, [f64; 2])> {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(1).max(1) as f64;
        let width = columns * (self.panel[0] + MARGIN) + MARGIN;
        let mut svg = Svg::default();
        let mut y = MARGIN;
        if !self.title.is_empty() {
            for line in text::wrap(&self.title, HEADLINE, 0.94 * (width - 2.0 * MARGIN)) {
                let headline = Letters { weight: Weight::Strong, ..letters(HEADLINE, INK, Anchor::Start) };
                svg.text([MARGIN, y + HEADLINE * 0.8], &line, headline, None);
                y += HEADLINE * LEADING;
            }
            y += 0.5 * TITLE;
        }
        for row in &self.rows {
            for (column, panel) in row.iter().enumerate() {
                let at = [MARGIN + column as f64 * (self.panel[0] + MARGIN), y];
                draw::panel(&mut svg, panel, Area { at, size: self.panel })?;
            }
            y += self.panel[1] + MARGIN;
        }
        for line in text::wrap(&self.caption, CAPTION, width - 2.0 * MARGIN) {
            svg.text([MARGIN, y + CAPTION * 0.8], &line, letters(CAPTION, QUIET, Anchor::Start), None);
            y += CAPTION * LEADING;
        }
        let size = [width, (y + 0.5 * MARGIN).ceil()];
        Ok((svg.finish(size, PAPER, notes), size))
    }

    /// Returns the figure as PNG, with `notes` as chunks of text.
    ///
    /// # Errors
    /// Those of [`Self::svg`]; a picture that is too large.
    pub fn png(&self, notes: &Notes) -> Result<Vec<u8>> {
        let bug = |what: String| Error::failed(what, "report this as a bug of diffract");
        let (svg, size) = self.drawn(notes)?;
        let tree = usvg::Tree::from_str(&svg, &text::options())
            .map_err(|e| bug(format!("the figure is no sound SVG ({e})")))?;
        let [width, height] = size.map(|x| (x * PNG_SCALE) as u32);
        let mut pixels = tiny_skia::Pixmap::new(width, height).ok_or_else(|| {
            Error::failed(format!("a figure of {width}x{height} is too large"), "ask for fewer panels")
        })?;
        let scale = PNG_SCALE as f32;
        resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut pixels.as_mut());
        encoded(&pixels, notes).map_err(|e| bug(format!("the figure is no PNG ({e})")))
    }

    /// Writes the figure with `notes` to `path`, whole or not at all, in the format of its extension: .svg or .png.
    ///
    /// # Errors
    /// Another extension; a file that cannot be written.
    pub fn save(&self, path: &Path, notes: &Notes) -> Result<()> {
        let bytes = match FigureFormat::of(path)? {
            FigureFormat::Svg => self.svg(notes)?.into_bytes(),
            FigureFormat::Png => self.png(notes)?,
        };
        output::write_atomically(path, |file| {
            file.write_all(&bytes).map_err(|e| output::write_failed(path, &e))
        })
    }
}

/// Encodes opaque `pixels` as PNG.
fn encoded(pixels: &tiny_skia::Pixmap, notes: &Notes) -> std::result::Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    notes.add_to_png(&mut encoder)?;
    let rgb: Vec<u8> = pixels.data().chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    Ok(bytes)
}

/// File format of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FigureFormat {
    /// Vector graphics.
    Svg,
    /// Pixels.
    Png,
}

impl FigureFormat {
    /// Returns the format of a file name's extension.
    ///
    /// # Errors
    /// Neither .svg nor .png.
    pub fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("png") => Ok(Self::Png),
            _ => Err(Error::usage(
                format!("{}: the format of the figure is not clear", path.display()),
                "name it .svg or .png",
            )),
        }
    }
}

#[cfg(test)]
mod tests;
