//! The distribution of slopes.

use crate::sums;
use crate::surface::HeightField;
use rayon::prelude::*;
use serde::Serialize;

/// Slopes of the facets between neighbouring samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Slopes {
    /// RMS gradient Sdq (ISO 25178-2:2021, 4.4.1), from differences of neighbouring samples along each axis: √(x² + y²) of `rms`.
    pub sdq: f64,
    /// RMS slope along `x` and along `y`. Limits of scalar theory are about these, not about Sdq.
    pub rms: [f64; 2],
    /// The slope angle that 95 % of the facets are below \[degrees\].
    #[serde(rename = "angle_95_deg")]
    pub angle_95: f64,
    /// The steepest facet \[degrees\].
    #[serde(rename = "angle_max_deg")]
    pub angle_max: f64,
}

/// Facets that the distribution is taken from, evenly spread over larger fields.
const MOST_FACETS: usize = 1 << 22;

impl Slopes {
    /// Measures the slopes of `field`.
    pub fn of(field: &HeightField) -> Self {
        let rms = rms_slopes(field);
        let mut gradients = gradients(field);
        let place = (gradients.len() - 1) * 95 / 100;
        let largest = gradients.iter().copied().fold(0.0, f64::max);
        let angle = |gradient: f64| gradient.atan().to_degrees();
        Self {
            sdq: rms[0].hypot(rms[1]),
            rms,
            angle_95: angle(*gradients.select_nth_unstable_by(place, f64::total_cmp).1),
            angle_max: angle(largest),
        }
    }
}

/// Returns the RMS slopes along `x` and `y`; 0 along an axis of a single sample.
pub fn rms_slopes(field: &HeightField) -> [f64; 2] {
    let (columns, rows) = (field.columns(), field.rows());
    let [dx, dy] = field.pixel_size();
    let squares = |row: usize| {
        let here = field.row(row);
        let along: f64 = here.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
        let next = if row + 1 < rows { field.row(row + 1) } else { here };
        let down: f64 = here.iter().zip(next).map(|(a, b)| (a - b).powi(2)).sum();
        [along, down]
    };
    let [along, down] =
        sums::in_order((0..rows).into_par_iter().map(squares), [0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    let mean = |sum: f64, pairs: usize, spacing: f64| (sum / pairs.max(1) as f64).sqrt() / spacing;
    [mean(along, (columns - 1) * rows, dx), mean(down, columns * (rows - 1), dy)]
}

/// Returns the absolute gradient at each sample, or at some of them, from the differences to the next sample to the right and below.
pub fn gradients(field: &HeightField) -> Vec<f64> {
    let (columns, rows) = (field.columns(), field.rows());
    let [dx, dy] = field.pixel_size();
    let (across, down) = ((columns - 1).max(1), (rows - 1).max(1));
    let step = (across * down).div_ceil(MOST_FACETS);
    let gradient = |i: usize| {
        let (column, row) = (i % across, i / across);
        let here = field.row(row)[column];
        let right = field.row(row)[(column + 1).min(columns - 1)];
        let below = field.row((row + 1).min(rows - 1))[column];
        ((right - here) / dx).hypot((below - here) / dy)
    };
    (0..across * down).into_par_iter().step_by(step).map(gradient).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::statistics::tests::field;
    use std::f64::consts::TAU;

    #[test]
    fn a_plane_has_one_slope() {
        let s = Slopes::of(&field(30, 20, |x, y| 0.3 * x - 0.4 * y));
        assert!(
            (s.sdq - 0.5).abs() < 1e-12 && (s.rms[0] - 0.3).abs() < 1e-12 && (s.rms[1] - 0.4).abs() < 1e-12
        );
        let angle = 0.5_f64.atan().to_degrees();
        assert!((s.angle_95 - angle).abs() < 1e-9 && (s.angle_max - angle).abs() < 1e-9);
    }

    #[test]
    fn a_sinusoid_of_many_samples_has_the_rms_slope_of_its_derivative() {
        let s = Slopes::of(&field(401, 10, |x, _| 0.2 * (TAU * x / 40.0).sin()));
        let expected = 0.2 * TAU / 40.0 / 2_f64.sqrt();
        assert!((s.sdq / expected - 1.0).abs() < 1e-4, "{}", s.sdq);
        // |cos| is below cos(π/40) for 95 % of a period.
        let largest = (0.2 * TAU / 40.0 * (TAU / 80.0).cos()).atan().to_degrees();
        assert!((s.angle_95 / largest - 1.0).abs() < 1e-3, "{}", s.angle_95);
    }

    #[test]
    fn a_single_sample_and_a_line_have_slopes_along_what_they_have() {
        assert_eq!(Slopes::of(&field(1, 1, |_, _| 3.0)).sdq, 0.0);
        let line = Slopes::of(&field(1, 9, |_, y| 2.0 * y));
        assert!((line.rms[1] - 2.0).abs() < 1e-12 && line.rms[0] == 0.0);
    }
}
