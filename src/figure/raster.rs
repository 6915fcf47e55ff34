//! Values or colours on a grid, and their colour scale.

use super::axis::{Axis, AxisScale};
use super::palette::{Color, ColorMap};
use crate::error::{Error, Result};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use image::{ExtendedColorType, ImageEncoder};

/// Map from values to colours, with the axis of its colour bar.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorScale {
    /// Name, unit, range and scale of the values.
    pub axis: Axis,
    /// Colours from the low end to the high one.
    pub map: ColorMap,
}

impl ColorScale {
    /// Returns the colour of `value`. A value that the scale cannot show (0 on a logarithmic one) has the colour of the low end.
    pub fn color(&self, value: f64) -> Color {
        let share = self.axis.share(value);
        self.map.at(if share.is_nan() { 0.0 } else { share })
    }

    /// Returns a scale of differences, symmetric about 0.
    pub fn differences(label: impl Into<String>, largest: f64) -> Self {
        let largest = if largest > 0.0 { largest } else { 1.0 };
        Self { axis: Axis::linear(label, -largest, largest), map: ColorMap::Difference }
    }

    /// Returns a logarithmic scale of `decades` decades below the largest of `values`.
    pub fn decades(label: impl Into<String>, decades: f64, values: &[f64]) -> Self {
        let largest = values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
        Self { axis: Axis::log(label, largest * 10f64.powf(-decades), largest), map: ColorMap::Magma }
    }
}

/// Picture that fills a panel: row 0 at the top, columns from the low end of the panel's x axis to its high end, in equal steps of the
/// axis' length.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Columns and rows.
    pub size: [usize; 2],
    /// sRGB and opacity, row by row.
    pub pixels: Vec<[u8; 4]>,
    /// Colour scale of the values; `None` for a picture of colours.
    pub scale: Option<ColorScale>,
}

impl Raster {
    /// Returns `values`, row by row from the top, in false colour; a NaN is not drawn.
    pub fn values(columns: usize, values: &[f64], scale: ColorScale) -> Self {
        let pixel = |value: &f64| {
            let [r, g, b] = scale.color(*value).0;
            [r, g, b, if value.is_nan() { 0 } else { 255 }]
        };
        let pixels: Vec<_> = values.iter().map(pixel).collect();
        Self { size: [columns, pixels.len() / columns.max(1)], pixels, scale: Some(scale) }
    }

    /// Returns a raster of the given colours.
    pub fn colors(columns: usize, pixels: Vec<[u8; 4]>) -> Self {
        Self { size: [columns, pixels.len() / columns.max(1)], pixels, scale: None }
    }

    /// Returns the raster of a hemisphere with its colours at the rim continued outward, so that the circle of the rim cuts pixels that have
    /// a colour. A pixel whose middle is outside gets the colour of the nearest one on its way to the middle of the disc.
    pub(super) fn beyond_rim(&self) -> Self {
        /// Distance beyond the rim that is filled, and longest way to a pixel inside \[pixels\].
        const FILLED: f64 = 3.0;
        let [columns, rows] = self.size.map(|n| n as f64);
        let mut pixels = self.pixels.clone();
        for (place, pixel) in pixels.iter_mut().enumerate() {
            let [i, j] = [place % self.size[0], place / self.size[0]].map(|n| n as f64 + 0.5);
            let (x, y) = (i - columns / 2.0, j - rows / 2.0);
            let from_middle = x.hypot(y);
            let outside = from_middle - columns / 2.0;
            if pixel[3] > 0 || !(0.0..FILLED).contains(&outside) {
                continue;
            }
            let inward = |step: usize| {
                let share = 1.0 - step as f64 / from_middle;
                let at = [(columns / 2.0 + x * share) as usize, (rows / 2.0 + y * share) as usize];
                self.pixels.get(at[1] * self.size[0] + at[0]).copied().filter(|pixel| pixel[3] > 0)
            };
            *pixel = (1..=2 * FILLED as usize).find_map(inward).unwrap_or(*pixel);
        }
        Self { pixels, ..self.clone() }
    }

    /// Encodes the raster as PNG in base64.
    ///
    /// # Errors
    /// Fails for more pixels than a PNG holds.
    pub fn png(&self) -> Result<String> {
        Ok(BASE64_STANDARD.encode(self.png_bytes()?))
    }

    /// Encodes the raster as PNG.
    ///
    /// # Errors
    /// Fails for more pixels than a PNG holds.
    pub fn png_bytes(&self) -> Result<Vec<u8>> {
        let [columns, rows] = self.size;
        let bytes = &bytemuck::cast_slice::<[u8; 4], u8>(&self.pixels)[..columns * rows * 4];
        let mut png = Vec::new();
        image::codecs::png::PngEncoder::new(&mut png)
            .write_image(bytes, columns as u32, rows as u32, ExtendedColorType::Rgba8)
            .map_err(|e| {
                Error::limit(format!("the raster of the figure is no PNG ({e})"), "ask for a smaller one")
                    .caused_by(e)
            })?;
        Ok(png)
    }
}

/// Returns the colours of a bar from its low end to its high one, bottom up.
pub(super) fn bar(scale: &ColorScale) -> Raster {
    /// Number of steps, above the number of distinguishable colours.
    const STEPS: usize = 256;
    let at = |i: usize| {
        let [r, g, b] = scale.map.at(1.0 - (i as f64 + 0.5) / STEPS as f64).0;
        [r, g, b, 255]
    };
    Raster::colors(1, (0..STEPS).map(at).collect())
}

/// Returns true if the values of a bar go by decades, so that ticks between them need no label.
pub(super) fn is_log(scale: &ColorScale) -> bool {
    scale.axis.scale == AxisScale::Log
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rim_of_a_hemisphere_has_colours_on_both_sides() {
        let side = 40;
        let inside = |i: usize| {
            let [x, y] = [i % side, i / side].map(|n| (n as f64 + 0.5) / side as f64 * 2.0 - 1.0);
            x.hypot(y) < 1.0
        };
        let pixels = (0..side * side).map(|i| if inside(i) { [9, 8, 7, 255] } else { [0; 4] }).collect();
        let raster = Raster::colors(side, pixels).beyond_rim();
        let touches = |i: usize| {
            let [x, y] = [i % side, i / side].map(|n| (n as f64 - 19.5).abs() - 0.5);
            x.max(0.0).hypot(y.max(0.0)) < 20.0
        };
        assert!((0..side * side).filter(|i| touches(*i)).all(|i| raster.pixels[i] == [9, 8, 7, 255]));
        assert_eq!(raster.pixels[0], [0; 4], "corners stay empty");
    }

    #[test]
    fn values_have_the_colours_of_their_scale_and_holes_none() {
        let scale = ColorScale { axis: Axis::linear("", 0.0, 2.0), map: ColorMap::Viridis };
        let raster = Raster::values(2, &[0.0, 2.0, f64::NAN, 1.0], scale.clone());
        assert_eq!((raster.size, raster.pixels[2][3]), ([2, 2], 0));
        assert_eq!(raster.pixels[1], [0xfd, 0xe7, 0x25, 255]);
        assert_eq!(raster.pixels[3][..3], scale.color(1.0).0);
        let log = ColorScale::decades("", 3.0, &[5.0, 50.0]);
        assert!((log.axis.low - 0.05).abs() < 1e-12 && log.color(0.0) == log.color(1e-9));
    }
}
