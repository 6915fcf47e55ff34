//! Labelled figures, as SVG and, from the same SVG, as PNG.
//!
//! A [`Figure`] is rows of [`Panel`]s under a title and over a caption; a panel has two [`Axis`], perhaps a [`Raster`] with a
//! colour bar, and [`Mark`]s: lines, points, bands, notes. The font is embedded, so a figure is the same on every machine.
//!
//! ```
//! use diffract::internals::figure::{Axis, Figure, FigureStyle, Mark, Panel, palette};
//! use diffract::internals::notes::Notes;
//! let line = Mark::line(vec![[1.0, 0.1], [10.0, 0.01]], palette::BLUE);
//! let panel = Panel::new(Axis::log("frame time [ms]", 1.0, 10.0), Axis::log("error", 1e-2, 1e-1)).named("optimal", line);
//! let figure = Figure::new("Speed against error").row(vec![panel]).caption("Measured on one machine.");
//! assert!(figure.svg(&FigureStyle::default(), &Notes::default())?.contains("frame time"));
//! # Ok::<(), diffract::internals::error::Error>(())
//! ```

mod axis;
mod draw;
mod heading;
mod layout;
mod marks;
pub mod palette;
mod panel;
mod raster;
mod style;
mod svg;
mod text;

pub use axis::{Axis, AxisScale, Tick, number};
pub use palette::{Color, ColorMap, Theme};
pub use panel::{Mark, MarkShape, Panel, PlotFrame};
pub use raster::{ColorScale, Raster};
pub use style::{FigureStyle, MM_PER_INCH, PX_PER_INCH};
pub use svg::Anchor;

use crate::error::{Error, Result};
use crate::notes::Notes;
use crate::output;
use draw::PanelLayout;
use layout::{Area, MARGIN, TITLE, letters};
use palette::{INK, QUIET};
use resvg::{tiny_skia, usvg};
use std::io::Write;
use std::path::Path;
use style::PageScale;
use svg::{Letters, Svg};
use text::Weight;

/// Size of the letters of the figure's title and of captions \[px\].
const HEADLINE: f64 = 18.0;
const CAPTION: f64 = 12.5;
/// Height of a title with a legend of one row, for which the size of panels is chosen \[px\].
const USUAL_HEADING: f64 = 50.0;
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

    /// Returns the figure as SVG in this `style`, with `notes` as its metadata.
    ///
    /// # Errors
    /// A raster that is empty or too large; a page too narrow for its letters.
    pub fn svg(&self, style: &FigureStyle, notes: &Notes) -> Result<String> {
        self.drawn(style, notes).map(|(svg, _)| svg)
    }

    /// Returns the figure as SVG, and its width \[mm\].
    fn drawn(&self, style: &FigureStyle, notes: &Notes) -> Result<(String, f64)> {
        let rows = self.rows_of(style);
        let most = rows.iter().map(Vec::len).max().unwrap_or(1).max(1);
        let scale = style.page(most as f64 * (self.panel[0] + MARGIN) + MARGIN)?;
        let mut svg = Svg::new(style.theme);
        let mut y = MARGIN;
        if style.has_caption && !self.title.is_empty() {
            y = self.headline(&mut svg, y, scale.width);
        }
        let (columns, width) = scale.columns(most, self.panel[0]);
        for row in rows.iter().flat_map(|row| row.chunks(columns)) {
            y = self.panels(&mut svg, row, y, width)? + MARGIN;
        }
        if style.has_caption {
            for line in text::wrap(&self.caption, CAPTION, scale.width - 2.0 * MARGIN) {
                let quiet = letters(CAPTION, QUIET, Anchor::Start);
                svg.text([MARGIN, y + CAPTION * 0.8], &line, quiet, None);
                y += CAPTION * LEADING;
            }
        }
        let PageScale { width, mm_per_px } = scale;
        Ok((svg.finish([width, (y + 0.5 * MARGIN).ceil()], mm_per_px, notes), width * mm_per_px))
    }

    /// Returns the panels that `style` chooses, in its order and in rows as long as the figure's; all rows if it chooses none.
    fn rows_of(&self, style: &FigureStyle) -> Vec<Vec<&Panel>> {
        let Some(chosen) = &style.panels else {
            return self.rows.iter().map(|row| row.iter().collect()).collect();
        };
        let all = || self.rows.iter().flatten();
        let found: Vec<&Panel> =
            chosen.iter().filter_map(|name| all().find(|panel| panel.name == name.as_str())).collect();
        let most = self.rows.iter().map(Vec::len).max().unwrap_or(1).max(1);
        found.chunks(most).map(<[&Panel]>::to_vec).collect()
    }

    /// Draws the title below `y`; returns the y below the title.
    fn headline(&self, svg: &mut Svg, mut y: f64, width: f64) -> f64 {
        for line in text::wrap(&self.title, HEADLINE, 0.94 * (width - 2.0 * MARGIN)) {
            let headline = Letters { weight: Weight::Strong, ..letters(HEADLINE, INK, Anchor::Start) };
            svg.text([MARGIN, y + HEADLINE * 0.8], &line, headline, None);
            y += HEADLINE * LEADING;
        }
        y + 0.5 * TITLE
    }

    /// Draws `row` of panels of this `width` below `y`; returns the y below the row.
    fn panels(&self, svg: &mut Svg, row: &[&Panel], y: f64, width: f64) -> Result<f64> {
        let layouts: Vec<PanelLayout<'_>> = row.iter().map(|panel| PanelLayout::new(panel, width)).collect();
        let aspect = (self.panel[1] - USUAL_HEADING) / self.panel[0];
        let height = layouts.iter().map(|layout| layout.height(aspect)).fold(0.0, f64::max);
        for (column, layout) in layouts.iter().enumerate() {
            let at = [MARGIN + column as f64 * (width + MARGIN), y];
            layout.draw(svg, Area { at, size: [width, height] })?;
        }
        Ok(y + height)
    }

    /// Returns the figure as PNG in this `style`, with `notes` as chunks of text.
    ///
    /// # Errors
    /// Those of [`Self::svg`]; a picture that is too large.
    pub fn png(&self, style: &FigureStyle, notes: &Notes) -> Result<Vec<u8>> {
        let bug = |what: String| Error::bug(what);
        let (svg, millimetres) = self.drawn(style, notes)?;
        let tree = usvg::Tree::from_str(&svg, &text::options())
            .map_err(|e| bug(format!("the figure is no sound SVG ({e})")).caused_by(e))?;
        let size = tree.size();
        let width = (millimetres / MM_PER_INCH * style.dpi).round();
        let scale = width as f32 / size.width();
        // Whole pixels alone: one that the page covers in part would be dark.
        let height = (size.height() * scale).floor();
        let mut pixels = tiny_skia::Pixmap::new(width as u32, height as u32).ok_or_else(|| {
            Error::limit(
                format!("a figure of {width}x{height} pixels is too large"),
                "make it smaller, or ask for fewer pixels per inch or fewer panels",
            )
        })?;
        resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut pixels.as_mut());
        encoded(&pixels, style.dpi, notes)
            .map_err(|e| bug(format!("the figure is no PNG ({e})")).caused_by(e))
    }

    /// Writes the figure in this `style` and with `notes` to `path`, whole or not at all, in the format of its extension: .svg or .png.
    ///
    /// # Errors
    /// Another extension; a file that cannot be written.
    pub fn save(&self, path: &Path, style: &FigureStyle, notes: &Notes) -> Result<()> {
        let bytes = match FigureFormat::of(path)? {
            FigureFormat::Svg => self.svg(style, notes)?.into_bytes(),
            FigureFormat::Png => self.png(style, notes)?,
        };
        output::write_atomically(path, |file| {
            file.write_all(&bytes).map_err(|e| output::write_failed(path, e))
        })
    }
}

/// Encodes opaque `pixels`, of which `dpi` are an inch, as PNG.
fn encoded(
    pixels: &tiny_skia::Pixmap,
    dpi: f64,
    notes: &Notes,
) -> std::result::Result<Vec<u8>, png::EncodingError> {
    let per_metre = (dpi * 1e3 / MM_PER_INCH).round() as u32;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: per_metre,
        yppu: per_metre,
        unit: png::Unit::Meter,
    }));
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
