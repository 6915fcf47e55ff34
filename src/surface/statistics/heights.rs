//! The distribution of heights.

use crate::sums;
use crate::surface::HeightField;
use crate::surface::si::{metres, metres_of_both, metres_of_option};
use rayon::prelude::*;
use serde::Serialize;

/// Height parameters of ISO 25178-2:2021, section 4.2, about the mean height, and the defects of the data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeightParameters {
    /// Lowest and highest height \[µm\].
    #[serde(rename = "range_m", serialize_with = "metres_of_both")]
    pub range: [f64; 2],
    /// Mean height \[µm\].
    #[serde(rename = "mean_m", serialize_with = "metres")]
    pub mean: f64,
    /// Arithmetic mean deviation Sa \[µm\].
    #[serde(rename = "sa_m", serialize_with = "metres")]
    pub sa: f64,
    /// Root mean square deviation Sq, the standard deviation \[µm\].
    #[serde(rename = "sq_m", serialize_with = "metres")]
    pub sq: f64,
    /// Skewness Ssk: below 0 for pits in a plane, above 0 for hills on one. 0 for a flat field.
    pub ssk: f64,
    /// Kurtosis Sku: 3 for normally distributed heights, more for rare high ones, 1.5 for a sinusoid. 0 for a flat field.
    pub sku: f64,
    /// Number of different heights.
    pub levels: usize,
    /// Step of which all heights are multiples, apart from an offset \[µm\]; `None` if there is no such step.
    #[serde(rename = "quantisation_m", serialize_with = "metres_of_option")]
    pub quantisation: Option<f64>,
    /// Share of the samples beyond three standard deviations: 0.0027 for normally distributed heights, more with dust.
    pub outliers: f64,
    /// Height range of all samples but the 0.05 % highest and the 0.05 % lowest \[µm\]. Where it is much smaller than the whole range,
    /// a few samples set the range, and with it the cost of the optics.
    #[serde(rename = "core_range_m", serialize_with = "metres")]
    pub core_range: f64,
}

/// Standard deviations from the mean beyond which a sample counts as an outlier.
const OUTLIER: f64 = 3.0;
/// Share of the samples that is left out at each end of [`HeightParameters::core_range`].
pub(super) const CORE: f64 = 5e-4;

impl HeightParameters {
    /// Measures the heights of `field`.
    pub fn of(field: &HeightField) -> Self {
        let heights = field.heights();
        let count = heights.len() as f64;
        let mean = mean(field);
        let moments = |row: &[f64]| {
            row.iter().map(|h| h - mean).fold([0.0; 4], |[a, s, c, q], d| {
                let square = d * d;
                [a + d.abs(), s + square, c + square * d, q + square * square]
            })
        };
        let add = |a: [f64; 4], b: [f64; 4]| [0, 1, 2, 3].map(|i| a[i] + b[i]);
        let sums = sums::in_order(heights.par_chunks(field.columns()).map(moments), [0.0; 4], add);
        let [sa, variance, third, fourth] = sums.map(|sum| sum / count);
        let sq = variance.sqrt();
        let (low, high) = field.range();
        // Equal heights have an `sq` of at most this by rounding.
        let flat = sq <= 1e-15 * low.abs().max(high.abs());
        let beyond = heights.par_iter().filter(|h| (*h - mean).abs() > OUTLIER * sq).count();
        let levels = distinct(heights);
        Self {
            range: [low, high],
            mean,
            sa,
            sq,
            ssk: if flat { 0.0 } else { third / (variance * sq) },
            sku: if flat { 0.0 } else { fourth / (variance * variance) },
            quantisation: quantisation(&levels),
            levels: levels.len(),
            outliers: if flat { 0.0 } else { beyond as f64 / count },
            core_range: core_range(heights),
        }
    }
}

/// Returns the mean height \[µm\], from sums of rows, which lose fewer digits than one long sum.
pub fn mean(field: &HeightField) -> f64 {
    let total: f64 = (0..field.rows()).map(|row| field.row(row).iter().sum::<f64>()).sum();
    total / field.heights().len() as f64
}

/// Returns the root mean square deviation Sq \[µm\] alone.
pub fn deviation(field: &HeightField) -> f64 {
    let mean = mean(field);
    let squares = |row: &[f64]| row.iter().map(|h| (h - mean).powi(2)).sum::<f64>();
    let rows = field.heights().par_chunks(field.columns()).map(squares);
    let total = sums::in_order(rows, 0.0, |a, b| a + b);
    (total / field.heights().len() as f64).sqrt()
}

/// Returns the different heights, lowest first.
fn distinct(heights: &[f64]) -> Vec<f64> {
    /// Heights that are copied at once: an image has few different ones, and a copy of all may be gigabytes.
    const AT_ONCE: usize = 1 << 20;
    let sorted = |mut some: Vec<f64>| {
        some.par_sort_unstable_by(f64::total_cmp);
        some.dedup_by(|a, b| *a == *b); // 0 and −0 are one height
        some.shrink_to_fit(); // otherwise each keeps its former capacity
        some
    };
    let parts: Vec<Vec<f64>> = heights.par_chunks(AT_ONCE).map(|part| sorted(part.to_vec())).collect();
    sorted(parts.concat())
}

/// Returns the step between `levels` (lowest first); `None` unless all distances are multiples of the smallest one.
fn quantisation(levels: &[f64]) -> Option<f64> {
    /// Number of codes of 16 bits; more different heights count as numbers without a step.
    const MOST: usize = 1 << 16;
    /// A distance may be off by this share of the step: rounding, and steps written in decimal.
    const OFF: f64 = 1e-3;
    if !(2..=MOST).contains(&levels.len()) {
        return None;
    }
    let distances = levels.windows(2).map(|pair| pair[1] - pair[0]);
    let step = distances.clone().fold(f64::INFINITY, f64::min);
    let first = levels[0];
    let span = levels[levels.len() - 1] - first;
    // The mean step over the whole span is more precise than a single one.
    let step = span / (span / step).round();
    let whole = |h: &f64| (((h - first) / step).round() * step - (h - first)).abs() <= OFF * step;
    (span / step <= MOST as f64 && levels.iter().all(whole)).then_some(step)
}

/// Returns the height range \[µm\] without [`CORE`] of the samples at each end.
pub(super) fn core_range(heights: &[f64]) -> f64 {
    /// Largest number of heights, evenly spread over larger fields.
    const MOST: usize = 1 << 22;
    let mut some: Vec<f64> = heights.iter().copied().step_by(heights.len().div_ceil(MOST)).collect();
    let place = (some.len() as f64 * CORE) as usize;
    let last = some.len() - 1;
    let low = *some.select_nth_unstable_by(place, f64::total_cmp).1;
    let high = *some.select_nth_unstable_by(last - place, f64::total_cmp).1;
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::statistics::tests::field;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn a_sinusoid_has_its_closed_form_parameters() {
        let h = HeightParameters::of(&field(200, 40, |x, _| 3.0 + 0.2 * (TAU * x / 20.0).sin()));
        assert!((h.mean - 3.0).abs() < 1e-12);
        assert!((h.sq - 0.2 / 2_f64.sqrt()).abs() < 1e-12);
        assert!((h.sa - 0.2 * 2.0 / PI).abs() < 1e-4, "200 samples a period: {}", h.sa);
        assert!(h.ssk.abs() < 1e-10 && (h.sku - 1.5).abs() < 1e-10);
        assert!((h.range[1] - 3.2).abs() < 1e-12 && (h.range[0] - 2.8).abs() < 1e-12);
        assert_eq!(h.outliers, 0.0);
    }

    #[test]
    fn a_pillar_on_a_plane_has_the_moments_of_two_heights() {
        // A share p at height 1, the rest at 0: Sq² = p(1 − p), Ssk = (1 − 2p)/Sq, Sku = 1/(p(1 − p)) − 3.
        let h = HeightParameters::of(&field(100, 10, |x, _| f64::from(u8::from(x < 0.95))));
        let p: f64 = 0.1;
        let variance = p * (1.0 - p);
        assert!((h.sq - variance.sqrt()).abs() < 1e-12);
        assert!((h.ssk - (1.0 - 2.0 * p) / variance.sqrt()).abs() < 1e-10);
        assert!((h.sku - (1.0 / variance - 3.0)).abs() < 1e-9);
        assert!((h.sa - 2.0 * variance).abs() < 1e-12);
    }

    #[test]
    fn levels_and_outliers_are_counted() {
        let steps = HeightParameters::of(&field(100, 10, |x, _| (x / 2.5 + 1e-9).floor()));
        assert_eq!((steps.levels, steps.quantisation), (4, Some(1.0)));
        let dusty =
            HeightParameters::of(&field(100, 40, |x, y| if x == 0.0 && y == 0.0 { 9.0 } else { 0.0 }));
        assert_eq!((dusty.outliers, dusty.core_range), (2.5e-4, 0.0));
        let flat = HeightParameters::of(&field(30, 30, |_, _| 0.3));
        assert_eq!((flat.levels, flat.outliers, flat.ssk, flat.sku), (1, 0.0, 0.0, 0.0));
    }

    #[test]
    fn a_step_of_quantisation_is_found_where_there_is_one() {
        let codes = |step: f64| field(64, 64, |x, y| 5.0 + step * (40.0 * (x + 2.0 * y).sin()).round());
        for step in [0.43472 / 255.0, 1e-4, 3.0] {
            let found = HeightParameters::of(&codes(step)).quantisation.unwrap();
            assert!((found / step - 1.0).abs() < 1e-9, "{found} and not {step}");
        }
        assert_eq!(HeightParameters::of(&field(64, 64, |x, y| (x + 2.0 * y).sin())).quantisation, None);
    }
}
