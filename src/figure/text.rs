//! Text in the figure's embedded font: its width, its line breaks and its SVG.

use crate::notes::xml;
use resvg::usvg::{self, fontdb};
use std::sync::{Arc, OnceLock};

/// Font of figures, and substitutes for programs that open an SVG without the font.
pub const FAMILY: &str = "Inter, Helvetica, Arial, sans-serif";

/// Weight of letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// Running text.
    Regular,
    /// Titles.
    Strong,
}

impl Weight {
    /// Returns SVG's `font-weight`.
    pub fn number(self) -> u16 {
        match self {
            Self::Regular => 400,
            Self::Strong => 600,
        }
    }
}

/// Returns the options for reading an SVG: with the embedded fonts alone, so that every machine draws the same.
pub fn options() -> usvg::Options<'static> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(include_bytes!("../../assets/fonts/Inter-Regular.otf").to_vec());
        fonts.load_font_data(include_bytes!("../../assets/fonts/Inter-SemiBold.otf").to_vec());
        Arc::new(fonts)
    });
    usvg::Options { fontdb: Arc::clone(fonts), font_family: "Inter".to_owned(), ..usvg::Options::default() }
}

/// Returns the width of `text` in a line of `size` \[px\].
pub fn width(text: &str, size: f64, weight: Weight) -> f64 {
    if text.trim().is_empty() {
        return 0.0;
    }
    let svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='1' height='1'>\
         <text font-family='Inter' font-size='{size}' font-weight='{}'>{}</text></svg>",
        weight.number(),
        xml(text)
    );
    usvg::Tree::from_str(&svg, &options()).map_or(0.0, |tree| f64::from(tree.root().bounding_box().width()))
}

/// Breaks `text` at blanks into lines of at most `most` \[px\]; a longer word has a separate line. A line break stays.
pub fn wrap(text: &str, size: f64, most: f64) -> Vec<String> {
    let mut lines = Vec::new();
    for paragraph in text.lines() {
        let mut line = String::new();
        for word in paragraph.split(' ').filter(|word| !word.is_empty()) {
            let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
            if line.is_empty() || width(&longer, size, Weight::Regular) <= most {
                line = longer;
            } else {
                lines.push(std::mem::replace(&mut line, word.to_owned()));
            }
        }
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_grow_with_text_size_and_weight() {
        let one = width("wavelength", 12.0, Weight::Regular);
        assert!(one > 50.0 && one < 80.0, "{one}");
        assert!((width("wavelength", 24.0, Weight::Regular) / one - 2.0).abs() < 0.01);
        assert!(width("wavelength", 12.0, Weight::Strong) > one);
        assert_eq!(width("", 12.0, Weight::Regular), 0.0);
        assert!(
            width("λ θ φ 10⁻¹² µm · ± × → ‖", 12.0, Weight::Regular) > 100.0,
            "the font has what physics writes"
        );
    }

    #[test]
    fn lines_are_no_wider_than_asked_and_hold_every_word() {
        let text = "the grating equation says where each order of each wavelength goes\nand this is a second paragraph";
        let lines = wrap(text, 12.0, 120.0);
        assert!(
            lines.len() > 3 && lines.iter().all(|l| width(l, 12.0, Weight::Regular) <= 120.0),
            "{lines:?}"
        );
        assert_eq!(lines.join(" "), text.replace('\n', " "));
        assert_eq!(wrap("a\n\nb", 12.0, 100.0), ["a", "", "b"]);
    }
}
