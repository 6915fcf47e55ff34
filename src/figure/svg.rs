//! The SVG elements of figures. Lengths are pixels, y grows downward. Writing to a `String` cannot fail.

use super::palette::{Color, PAPER, QUIET, Theme};
use super::text::Weight;
use crate::notes::{Notes, xml};
use std::fmt::Write;

/// Horizontal anchor of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Left end.
    Start,
    /// Middle.
    Middle,
    /// Right end.
    End,
}

/// Style of a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Letters {
    /// Height of a line's letters \[px\].
    pub size: f64,
    /// Weight of the letters.
    pub weight: Weight,
    /// Colour.
    pub color: Color,
    /// Part of the text at its position.
    pub anchor: Anchor,
    /// True for a text that is turned counter-clockwise by a right angle.
    pub upward: bool,
}

/// Style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Colour.
    pub color: Color,
    /// Width \[px\].
    pub width: f64,
    /// Lengths of dashes and gaps \[px\]; `None` for a full line.
    pub dash: Option<[f64; 2]>,
    /// Opacity, from 0 (invisible) to 1.
    pub opacity: f64,
}

impl Stroke {
    /// Returns a full line.
    pub fn new(color: Color, width: f64) -> Self {
        Self { color, width, dash: None, opacity: 1.0 }
    }
}

/// SVG under construction.
#[derive(Clone, Debug)]
pub struct Svg {
    body: String,
    clips: usize,
    theme: Theme,
}

impl Svg {
    // Writing to a string cannot fail, so its results are ignored below.

    /// Returns an empty SVG, whose colours are those of the palette as `theme` shows them.
    pub fn new(theme: Theme) -> Self {
        Self { body: String::new(), clips: 0, theme }
    }

    /// Returns `color` as the theme shows it, in the form of SVG.
    fn hex(&self, color: Color) -> String {
        self.theme.shown(color).hex()
    }

    /// Returns the whole file, for a page of this `size` \[px\], of which a pixel is `mm_per_px` \[mm\], with `notes` as its metadata.
    pub fn finish(self, size: [f64; 2], mm_per_px: f64, notes: &Notes) -> String {
        let [width, height] = size;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
             width=\"{:.3}mm\" height=\"{:.3}mm\" viewBox=\"0 0 {width:.3} {height:.3}\" font-family=\"{}\">\n\
             <metadata>{}</metadata>\n\
             <rect width=\"{width:.3}\" height=\"{height:.3}\" fill=\"{}\"/>\n{}</svg>\n",
            width * mm_per_px,
            height * mm_per_px,
            super::text::FAMILY,
            xml(&notes.text()),
            self.hex(PAPER),
            self.body
        )
    }

    /// Draws a straight line.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], stroke: Stroke) {
        self.path(&format!("M{:.2} {:.2}L{:.2} {:.2}", from[0], from[1], to[0], to[1]), stroke);
    }

    /// Draws a line through `points`, broken at points that are not finite.
    pub fn polyline(&mut self, points: &[[f64; 2]], stroke: Stroke) {
        let mut path = String::new();
        let mut pen_down = false;
        for [x, y] in points {
            let finite = x.is_finite() && y.is_finite();
            if finite {
                let _ = write!(path, "{}{x:.2} {y:.2}", if pen_down { 'L' } else { 'M' });
            }
            pen_down = finite;
        }
        if !path.is_empty() {
            self.path(&path, stroke);
        }
    }

    /// Draws the outline of a path in SVG's syntax.
    pub fn path(&mut self, path: &str, stroke: Stroke) {
        let dash =
            stroke.dash.map_or_else(String::new, |[on, off]| format!(" stroke-dasharray=\"{on} {off}\""));
        let _ = writeln!(
            self.body,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-opacity=\"{}\" \
             stroke-linejoin=\"round\"{dash}/>",
            self.theme.shown(stroke.color).hex(),
            stroke.width,
            stroke.opacity
        );
    }

    /// Draws a filled polygon; nothing if a corner is not finite.
    pub fn polygon(&mut self, corners: &[[f64; 2]], fill: Color, opacity: f64) {
        if corners.is_empty() || corners.iter().flatten().any(|x| !x.is_finite()) {
            return;
        }
        let points: Vec<String> = corners.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
        let _ = writeln!(
            self.body,
            "<polygon points=\"{}\" fill=\"{}\" fill-opacity=\"{opacity}\"/>",
            points.join(" "),
            self.theme.shown(fill).hex()
        );
    }

    /// Draws the outline of a rectangle of `size` at its upper left corner `at`.
    pub fn frame(&mut self, at: [f64; 2], size: [f64; 2], stroke: Stroke) {
        let _ = writeln!(
            self.body,
            "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" fill=\"none\" stroke=\"{}\" \
             stroke-width=\"{}\"/>",
            at[0],
            at[1],
            size[0],
            size[1],
            self.theme.shown(stroke.color).hex(),
            stroke.width
        );
    }

    /// Draws a circle, filled or not.
    pub fn circle(&mut self, centre: [f64; 2], radius: f64, fill: Option<Color>, stroke: Stroke) {
        let _ = writeln!(
            self.body,
            "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"{radius:.2}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{}\" \
             stroke-opacity=\"{}\"/>",
            centre[0],
            centre[1],
            fill.map_or_else(|| "none".to_owned(), |fill| self.theme.shown(fill).hex()),
            self.theme.shown(stroke.color).hex(),
            stroke.width,
            stroke.opacity
        );
    }

    /// Draws a disc of this `color` on any ground, with a rim that sets it off.
    pub fn chip(&mut self, centre: [f64; 2], radius: f64, color: Color) {
        let _ = writeln!(
            self.body,
            "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"{radius:.2}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"1\"/>",
            centre[0],
            centre[1],
            color.hex(),
            self.theme.shown(QUIET).hex()
        );
    }

    /// Draws a line of text whose baseline is at `at`. A `halo` makes the text legible on any ground.
    pub fn text(&mut self, at: [f64; 2], text: &str, letters: Letters, halo: Option<Color>) {
        let anchor = match letters.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let [x, y] = at.map(|x| format!("{x:.2}"));
        let turn = if letters.upward { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        let theme = self.theme;
        let mut put = |paint: &str| {
            let _ = writeln!(
                self.body,
                "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" font-weight=\"{}\" text-anchor=\"{anchor}\"{turn} \
                 {paint}>{}</text>",
                letters.size,
                letters.weight.number(),
                xml(text)
            );
        };
        if let Some(halo) = halo {
            let hex = theme.shown(halo).hex();
            put(&format!(
                "fill=\"{hex}\" stroke=\"{hex}\" stroke-width=\"3\" stroke-linejoin=\"round\" stroke-opacity=\"0.75\""
            ));
        }
        put(&format!("fill=\"{}\"", theme.shown(letters.color).hex()));
    }

    /// Draws a PNG (as base64) stretched over a rectangle; `smooth` or with each pixel a square.
    pub fn image(&mut self, at: [f64; 2], size: [f64; 2], png_base64: &str, smooth: bool) {
        let rendering = if smooth { "optimizeQuality" } else { "optimizeSpeed" };
        let _ = writeln!(
            self.body,
            "<image x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" preserveAspectRatio=\"none\" \
             image-rendering=\"{rendering}\" xlink:href=\"data:image/png;base64,{png_base64}\"/>",
            at[0], at[1], size[0], size[1]
        );
    }

    /// Clips everything that `draw` draws to a rectangle.
    pub fn clipped(&mut self, at: [f64; 2], size: [f64; 2], draw: impl FnOnce(&mut Self)) {
        let [[x, y], [width, height]] = [at, size];
        let shape = format!("<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\"/>");
        self.clipped_to(&shape, draw);
    }

    /// Clips everything that `draw` draws to a circle.
    pub fn clipped_to_circle(&mut self, centre: [f64; 2], radius: f64, draw: impl FnOnce(&mut Self)) {
        let [x, y] = centre;
        self.clipped_to(&format!("<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\"/>"), draw);
    }

    fn clipped_to(&mut self, shape: &str, draw: impl FnOnce(&mut Self)) {
        let id = self.clips;
        self.clips += 1;
        let _ =
            writeln!(self.body, "<clipPath id=\"c{id}\">{shape}</clipPath>\n<g clip-path=\"url(#c{id})\">");
        draw(self);
        self.body.push_str("</g>\n");
    }
}
