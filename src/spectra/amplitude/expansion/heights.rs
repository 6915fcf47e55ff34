//! Distribution of a surface's heights, and the light that they scatter.

use super::HeightScale;
use crate::surface::HeightField;
use rustfft::num_complex::Complex64;

/// Bins of the histogram: the phase in a bin changes by less than a hundredth for every surface that the Taylor expansion can represent,
/// and the functions themselves are smooth in it.
const BINS: usize = 512;
/// Part of the weight that every height gets, whether it occurs or not: keeps functions bounded in empty parts of the histogram.
const UNSEEN: f64 = 1e-3;

/// Histogram of the heights of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightHistogram {
    /// a: half of the range \[µm\].
    pub half_range: f64,
    /// t of each bin's centre, and its weight; the weights add up to 1.
    pub bins: Vec<(f64, f64)>,
}

impl HeightHistogram {
    /// Counts the heights of `field`.
    pub fn of(field: &HeightField) -> Self {
        let scale = HeightScale::of(field);
        let mut counts = [0.0f64; BINS];
        for &h in field.heights() {
            let bin = ((scale.normalise(h) + 1.0) / 2.0 * BINS as f64) as usize;
            counts[bin.min(BINS - 1)] += 1.0;
        }
        let samples = field.heights().len() as f64;
        let weight = |count: f64| (1.0 - UNSEEN) * count / samples + UNSEEN / BINS as f64;
        let bins = counts
            .iter()
            .enumerate()
            .map(|(i, &count)| (2.0 * (i as f64 + 0.5) / BINS as f64 - 1.0, weight(count)))
            .collect();
        Self { half_range: scale.half_range, bins }
    }

    /// Returns the part of the light outside the specular direction at `z` \[rad/µm\].
    pub fn scattered(&self, z: f64) -> f64 {
        /// A flat surface scatters nothing; then every z counts alike.
        const LEAST: f64 = 1e-12;
        let x = z * self.half_range;
        let mean: Complex64 = self.bins.iter().map(|&(t, w)| Complex64::cis(x * t) * w).sum();
        (1.0 - mean.norm_sqr()).max(LEAST)
    }

    /// Returns points of z from `from` to `to`: several times the degrees of freedom of e^{izh} there. They are denser toward the ends,
    /// like Chebyshev nodes, because functions that are best in the mean err most there.
    pub fn points(&self, [from, to]: [f64; 2]) -> Vec<f64> {
        /// Largest number of points: sufficient for heights of 12 µm in visible light; no expansion in layers follows higher ones.
        const MOST: usize = 1024;
        let points = (24 + (2.5 * (to - from) * self.half_range) as usize).min(MOST);
        let angle = |q: usize| (q as f64 + 0.5) / points as f64 * std::f64::consts::PI;
        (0..points).map(|q| from + (1.0 - angle(q).cos()) / 2.0 * (to - from)).collect()
    }
}
