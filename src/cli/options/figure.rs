//! Options of labelled figures.

use super::real;
use crate::error::{Error, Result};
use crate::figure::{FigureStyle, PX_PER_INCH, Theme};
use crate::units;
use clap::{Args, ValueEnum};

/// Widths of figures \[mm\]: from a stamp to a poster.
const WIDTHS: (f64, f64) = (10.0, 2000.0);
/// Sizes of letters \[pt\].
const FONT_SIZES: (f64, f64) = (2.0, 100.0);
/// Pixels per inch.
const DPI: (f64, f64) = (10.0, 4800.0);

/// Options of a figure's style.
#[derive(Args, Clone, Debug)]
pub struct FigureOptions {
    /// Width of the figure, as in 85mm, 18cm, 7in or 1200px; pixels are those of a PNG, or 1/96 in with --dpi [default: that of the panels at their usual size]
    #[arg(long, value_name = "LENGTH", value_parser = PageWidth::parse, allow_hyphen_values = true)]
    width: Option<PageWidth>,
    /// Size of the letters of ticks and legends of the figure [default: 7pt with --width, else 9pt]
    #[arg(long, value_name = "SIZE", value_parser = font_size, allow_hyphen_values = true, hide_short_help = true)]
    font_size: Option<f64>,
    /// Pixels per inch of a figure as PNG [default: 192]
    #[arg(long, value_name = "N", value_parser = dpi, allow_hyphen_values = true, hide_short_help = true)]
    dpi: Option<f64>,
    /// Ground and letters of the figure [default: light]
    #[arg(long, value_enum, value_name = "THEME", hide_short_help = true)]
    theme: Option<Theme>,
    /// Panels of the figure, in this order [default: all]
    #[arg(long, value_name = "NAME[,NAME...]", value_delimiter = ',', hide_short_help = true)]
    panels: Option<Vec<String>>,
    /// Leave out the title above and the caption below the figure
    #[arg(long, hide_short_help = true)]
    no_caption: bool,
}

impl ValueEnum for Theme {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Light, Self::Dark]
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        Some(clap::builder::PossibleValue::new(match self {
            Self::Light => "light",
            Self::Dark => "dark",
        }))
    }
}

/// Width of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PageWidth {
    millimetres: f64,
    /// True for a width in pixels.
    is_pixels: bool,
}

impl PageWidth {
    fn parse(text: &str) -> Result<Self> {
        let millimetres = units::page_length(text)?;
        if !(WIDTHS.0..=WIDTHS.1).contains(&millimetres) {
            return Err(Error::usage(
                format!("`{text}` is no width of a figure"),
                format!("give {} to {} mm, as in 85mm", WIDTHS.0, WIDTHS.1),
            ));
        }
        Ok(Self { millimetres, is_pixels: text.trim_end().ends_with("px") })
    }
}

fn font_size(text: &str) -> Result<f64> {
    let number = text
        .trim()
        .strip_suffix("pt")
        .ok_or_else(|| Error::usage(format!("`{text}` is no size of letters"), "give points, as in 7pt"))?;
    real(number, FONT_SIZES, "size of letters in points")
}

fn dpi(text: &str) -> Result<f64> {
    real(text, DPI, "number of pixels per inch")
}

impl FigureOptions {
    /// Returns the style of a figure that has panels of these `names`, and is drawn if `is_drawn`.
    ///
    /// # Errors
    /// A style of no figure; a panel that the figure does not have.
    pub fn style(&self, is_drawn: bool, names: &[&str]) -> Result<FigureStyle> {
        if !is_drawn && self.is_any() {
            return Err(Error::usage(
                "--width, --font-size, --dpi, --theme, --panels and --no-caption are of a figure",
                "add --plot, or leave them out",
            ));
        }
        if let Some(unknown) = self.panels.iter().flatten().find(|name| !names.contains(&name.as_str())) {
            return Err(Error::usage(
                format!("the figure has no panel `{unknown}`"),
                format!("give some of {}", names.join(", ")),
            ));
        }
        let usual = FigureStyle::default();
        let in_pixels = self.width.is_some_and(|width| width.is_pixels);
        let dpi = self.dpi.unwrap_or(if in_pixels { PX_PER_INCH } else { usual.dpi });
        Ok(FigureStyle {
            width: self.width.map(|width| width.millimetres),
            font_size: self.font_size,
            dpi,
            theme: self.theme.unwrap_or_default(),
            panels: self.panels.clone(),
            has_caption: !self.no_caption,
        })
    }

    /// Returns true if any of the options is given.
    fn is_any(&self) -> bool {
        let Self { width, font_size, dpi, theme, panels, no_caption } = self;
        width.is_some()
            || font_size.is_some()
            || dpi.is_some()
            || theme.is_some()
            || panels.is_some()
            || *no_caption
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::MM_PER_INCH;

    #[test]
    fn widths_are_lengths_on_paper_or_pixels() {
        let width = |text| PageWidth::parse(text).map(|width| width.millimetres);
        for (text, millimetres) in [("85mm", 85.0), ("8.5cm", 85.0), ("2in", 50.8), ("96px", MM_PER_INCH)] {
            assert!((width(text).unwrap() - millimetres).abs() < 1e-9, "{text}");
        }
        assert!(PageWidth::parse("960px").unwrap().is_pixels && !PageWidth::parse("9cm").unwrap().is_pixels);
        for bad in ["", "85", "-85mm", "1mm", "3000mm", "85um", "nanmm"] {
            let e = width(bad).unwrap_err();
            assert!(e.kind() == crate::error::ErrorKind::Usage && e.to_string().contains("; "), "{bad}: {e}");
        }
        assert_eq!(font_size("7pt").unwrap(), 7.0);
        assert!(font_size("7").is_err() && font_size("0pt").is_err() && dpi("0").is_err());
    }
}
