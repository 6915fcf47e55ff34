//! Analysis of a height field for the surface pane, computed in the background.

use crate::error::Result;
use crate::optics::spectrum::SHORTEST;
use crate::surface::HeightField;
use crate::surface::statistics::height_spectrum::{SurfaceSpectrum, analysed_part};
use crate::surface::statistics::periods::{Period, dominant_periods};
use crate::surface::statistics::plot_grid::{PlotGrid, histogram, side_of_power};
use std::sync::Arc;

/// Longest side of the plots \[pixels\]; more is not visible.
const MOST_PIXELS: usize = 512;
/// Bins of the histogram.
const BINS: usize = 90;
/// RMS slope of the exaggerated heights in the relief: steep enough to be visible, without black facets.
const RELIEF_SLOPE: f64 = 0.6;

/// Analysis of a height field for the pane.
pub struct Analysis {
    /// Height field.
    pub field: Arc<HeightField>,
    /// Heights \[nm\].
    pub heights: PlotGrid,
    /// Range of almost all heights \[nm\].
    pub range: [f64; 2],
    /// Brightness of a relief, 0 to 1, in the grid of the heights.
    pub relief: Vec<f64>,
    /// Factor on the heights in the relief.
    pub exaggeration: f64,
    /// Standard deviation of the heights \[nm\].
    pub rms: f64,
    /// Distribution of heights: x \[nm\], 0, density \[1/nm\], as the outline of a band.
    pub histogram: Vec<[f64; 3]>,
    /// Power density \[nm² µm²\].
    pub power: PlotGrid,
    /// Largest frequency of `power` along each axis \[1/µm\].
    pub side: f64,
    /// Dominant periods.
    pub periods: Vec<Period>,
}

impl Analysis {
    /// Analyses `field`.
    ///
    /// # Errors
    /// Fails if there is not enough memory for the spectrum.
    pub fn of(field: &Arc<HeightField>) -> Result<Self> {
        let heights = PlotGrid::of_heights(field, MOST_PIXELS);
        let spacing = [0, 1].map(|axis| field.patch_size()[axis] / heights.size[axis] as f64);
        let (relief, exaggeration) = relief(&heights, spacing);
        let (low, high) = field.range();
        let [low, high] = [low, high].map(|h| h * 1e3);
        let values = field.heights().iter().map(|h| h * 1e3);
        let count = field.heights().len() as f64;
        let mean = values.clone().sum::<f64>() / count;
        let rms = (values.clone().map(|h| (h - mean).powi(2)).sum::<f64>() / count).sqrt();
        let spectrum = SurfaceSpectrum::windowed(&analysed_part(field))?;
        let side = side_of_power(&spectrum, SHORTEST);
        Ok(Self {
            field: field.clone(),
            range: heights.core(),
            relief,
            exaggeration,
            rms,
            histogram: histogram(values, [low, high], (high - low) / BINS as f64, BINS),
            power: PlotGrid::of_power(&spectrum, side, MOST_PIXELS),
            side,
            periods: dominant_periods(field, &spectrum)?,
            heights,
        })
    }
}

/// Returns the brightness of `heights` \[nm\] on a grid of this `spacing` \[µm\], lit from the upper left, 45° above
/// the plane, by Lambert's law; and the factor by which the heights are exaggerated.
fn relief(heights: &PlotGrid, spacing: [f64; 2]) -> (Vec<f64>, f64) {
    let [columns, rows] = heights.size;
    let at = |column: usize, row: usize| heights.values[row * columns + column] * 1e-3;
    // Central differences, one-sided at the edges.
    let slope = |i: usize| {
        let (column, row) = (i % columns, i / columns);
        let [left, right] = [column.saturating_sub(1), (column + 1).min(columns - 1)];
        let [upper, lower] = [row.saturating_sub(1), (row + 1).min(rows - 1)];
        let along = (at(right, row) - at(left, row)) / (spacing[0] * (right - left).max(1) as f64);
        let up = (at(column, upper) - at(column, lower)) / (spacing[1] * (lower - upper).max(1) as f64);
        [along, up]
    };
    let slopes: Vec<[f64; 2]> = (0..columns * rows).map(slope).collect();
    let square: f64 = slopes.iter().map(|[x, y]| x * x + y * y).sum();
    let rms = (square / slopes.len() as f64).sqrt();
    let factor = if rms > 0.0 { RELIEF_SLOPE / rms } else { 1.0 };
    (slopes.into_iter().map(|slope| brightness(slope.map(|s| s * factor))).collect(), factor)
}

/// Returns Lambert's cosine of a facet with this slope along x and y, lit along (−1, 1, √2)/2.
fn brightness([along, up]: [f64; 2]) -> f64 {
    let toward_light = 0.5 * (along - up) + 0.5 * std::f64::consts::SQRT_2;
    (toward_light / (1.0 + along * along + up * up).sqrt()).max(0.0)
}

/// Returns the profile of `field` along the straight line between two points \[µm, from the centre, y up\]: distance
/// from the first point \[µm\] and height \[nm\], bilinear between samples.
pub fn profile(field: &HeightField, [from, to]: [[f64; 2]; 2], points: usize) -> Vec<[f64; 2]> {
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    let point = |i: usize| {
        let part = i as f64 / (points.max(2) - 1) as f64;
        let place = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
        [part * length, height_at(field, place)]
    };
    (0..points.max(2)).map(point).collect()
}

/// Returns the height of `field` \[nm\] at `place` \[µm, from the centre, y up\], bilinear between samples and constant
/// beyond the outer ones.
pub fn height_at(field: &HeightField, place: [f64; 2]) -> f64 {
    let pixel = field.pixel_size();
    let along = |position: f64, count: usize| {
        let position = position.clamp(0.0, (count - 1) as f64);
        let first = (position as usize).min(count.saturating_sub(2));
        (first, (first + 1).min(count - 1), position - first as f64)
    };
    let (left, right, x) = along((place[0] - field.x(0)) / pixel[0], field.columns());
    let (upper, lower, y) = along((field.y(0) - place[1]) / pixel[1], field.rows());
    let row = |row: usize| field.row(row)[left] * (1.0 - x) + field.row(row)[right] * x;
    (row(upper) * (1.0 - y) + row(lower) * y) * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane() -> HeightField {
        HeightField::from_fn(40, 30, [0.1, 0.2], |x, y| 0.03 * x - 0.05 * y + 0.2).unwrap()
    }

    #[test]
    fn a_profile_of_a_plane_is_a_straight_line_of_its_slope() {
        let field = plane();
        let line = [[-1.2, -1.0], [1.1, 1.7]];
        let points = profile(&field, line, 17);
        let length = (2.3f64).hypot(2.7);
        assert_eq!(points.len(), 17);
        for [distance, height] in points {
            let part = distance / length;
            let [x, y] = [0, 1].map(|axis| line[0][axis] + part * (line[1][axis] - line[0][axis]));
            assert!((height - 1e3 * (0.03 * x - 0.05 * y + 0.2)).abs() < 1e-9, "{height} at {x} {y}");
        }
    }

    #[test]
    fn a_relief_is_lit_by_lambert_s_law_from_the_upper_left() {
        assert!((brightness([0.0, 0.0]) - 0.5f64.sqrt()).abs() < 1e-12);
        // A facet that faces the light, whose slope along (−1, 1)/√2 is −1.
        let slope = 0.5f64.sqrt();
        assert!((brightness([slope, -slope]) - 1.0).abs() < 1e-12);
        assert_eq!(brightness([-5.0, 5.0]), 0.0);
        let field = Arc::new(plane());
        let analysis = Analysis::of(&field).unwrap();
        let rms = 0.03f64.hypot(0.05);
        assert!((analysis.exaggeration - RELIEF_SLOPE / rms).abs() < 1e-6 * analysis.exaggeration);
        let factor = analysis.exaggeration;
        let expected = brightness([0.03 * factor, -0.05 * factor]);
        for shade in &analysis.relief {
            assert!((shade - expected).abs() < 1e-9, "{shade} {expected}");
        }
    }

    #[test]
    fn the_numbers_of_a_sinusoid_are_those_of_its_amplitude_and_period() {
        let wave = |x: f64, _: f64| 0.1 * (std::f64::consts::TAU * x / 1.25).sin();
        let field = Arc::new(HeightField::from_fn(200, 100, [0.05; 2], wave).unwrap());
        let analysis = Analysis::of(&field).unwrap();
        assert!((analysis.rms - 100.0 / 2f64.sqrt()).abs() < 0.01, "{}", analysis.rms);
        assert!((analysis.periods[0].length - 1.25).abs() < 1e-3, "{:?}", analysis.periods);
        let [columns, rows] = analysis.power.size;
        let place = (0..columns * rows)
            .max_by(|a, b| analysis.power.values[*a].total_cmp(&analysis.power.values[*b]));
        let place = place.unwrap();
        let frequency =
            ((place % columns) as f64 - (columns / 2) as f64) / columns as f64 * 2.0 * analysis.side;
        assert!((frequency.abs() - 0.8).abs() < 0.06 && place / columns == rows / 2, "{frequency}");
    }
}
