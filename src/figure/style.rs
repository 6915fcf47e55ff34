//! Style of a figure for its place in print or on a screen: width, letters, colours, parts.

use super::layout::{MARGIN, TICK};
use super::palette::Theme;
use crate::error::{Error, Result};

/// Millimetres of an inch.
pub const MM_PER_INCH: f64 = 25.4;
/// Points of an inch.
const PT_PER_INCH: f64 = 72.0;
/// Pixels of an inch in SVG.
pub const PX_PER_INCH: f64 = 96.0;
/// Size of letters in a figure of a given width [pt]: that of the figures of most journals.
const PRINT_LETTERS: f64 = 7.0;
/// Pixels of a PNG per inch: two for one of the SVG, sharp on today's screens and in print at the width of a column.
const DPI: f64 = 2.0 * PX_PER_INCH;
/// Narrowest figure [px]: a plot of some use beside its labels.
const NARROWEST: f64 = 240.0;
/// Narrowest panel beside others [px]; below it, panels stand below each other.
const NARROWEST_PANEL: f64 = 330.0;

/// Style of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureStyle {
    /// Width \[mm\]; `None`: that of the panels at their usual size.
    pub width: Option<f64>,
    /// Size of the letters of ticks and legends \[pt\], to which all others are in proportion; `None`: 7 pt if the width is given, else 9 pt.
    pub font_size: Option<f64>,
    /// Pixels of a PNG per inch.
    pub dpi: f64,
    /// Colours of paper and letters.
    pub theme: Theme,
    /// Names of the panels that are drawn, in their order; `None`: all.
    pub panels: Option<Vec<String>>,
    /// True for a title above and a caption below the panels.
    pub has_caption: bool,
}

impl Default for FigureStyle {
    fn default() -> Self {
        Self { width: None, font_size: None, dpi: DPI, theme: Theme::Light, panels: None, has_caption: true }
    }
}

/// Size of the page of a figure, whose lengths are pixels in which all letters have their usual sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PageScale {
    /// Width \[px\].
    pub(super) width: f64,
    /// Length of a pixel \[mm\].
    pub(super) mm_per_px: f64,
}

impl FigureStyle {
    /// Returns the page of a figure that is `usual` \[px\] wide unless the style has another width.
    ///
    /// # Errors
    /// A page too narrow for its letters.
    pub(super) fn page(&self, usual: f64) -> Result<PageScale> {
        let usual_mm_per_px = MM_PER_INCH / PX_PER_INCH;
        let points = self.font_size.or(self.width.map(|_| PRINT_LETTERS));
        let mm_per_px = points.map_or(usual_mm_per_px, |points| points / PT_PER_INCH * MM_PER_INCH / TICK);
        let width = self.width.unwrap_or(usual * usual_mm_per_px) / mm_per_px;
        if width < NARROWEST {
            return Err(Error::usage(
                format!("letters of {:.1} pt leave a figure of this width no room", points.unwrap_or(TICK)),
                "make the figure wider or the letters smaller",
            ));
        }
        Ok(PageScale { width, mm_per_px })
    }
}

impl PageScale {
    /// Returns the number of panels that stand beside each other, at most `most`, and their width \[px\], which is `usual` in a figure without a
    /// width.
    pub(super) fn columns(&self, most: usize, usual: f64) -> (usize, f64) {
        /// Rounding of the widths.
        const ROUNDING: f64 = 1e-6;
        let narrowest = NARROWEST_PANEL.min(usual) + MARGIN;
        let fitting = ((self.width - MARGIN) / narrowest + ROUNDING) as usize;
        let columns = fitting.clamp(1, most.max(1));
        (columns, (self.width - MARGIN) / columns as f64 - MARGIN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn style(width: f64, points: f64) -> FigureStyle {
        FigureStyle { width: Some(width), font_size: Some(points), ..FigureStyle::default() }
    }

    #[test]
    fn letters_have_their_size_at_every_width() {
        for (width, points) in [(85.0, 7.0), (180.0, 7.0), (180.0, 9.0)] {
            let page = style(width, points).page(1e3).unwrap();
            assert!((page.width * page.mm_per_px - width).abs() < 1e-9);
            assert!((TICK * page.mm_per_px / MM_PER_INCH * 72.0 - points).abs() < 1e-9);
        }
        let usual = FigureStyle::default().page(1000.0).unwrap();
        assert!((usual.width - 1000.0).abs() < 1e-9);
        assert_eq!(style(20.0, 12.0).page(1e3).unwrap_err().kind(), crate::error::ErrorKind::Usage);
    }

    #[test]
    fn a_column_of_a_journal_has_one_panel_and_a_page_two() {
        let columns = |width| style(width, 7.0).page(1e3).unwrap().columns(3, 600.0).0;
        assert_eq!([85.0, 180.0, 300.0].map(columns), [1, 2, 3]);
    }
}
