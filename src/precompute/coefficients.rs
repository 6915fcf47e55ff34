//! c_n(z) as a table: what the shader reads instead of computing.

use crate::expansion::Expansion;
use rustfft::num_complex::Complex64;

/// c_n(z) on a uniform grid of z, fine enough to be linear between its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// Distance of neighbouring points \[rad/µm\]; the first stands at 0, the last at or beyond z_max.
    pub step: f64,
    /// Points.
    pub columns: usize,
    /// `[term][point]`: real and imaginary part.
    pub values: Vec<[f32; 2]>,
}

impl Coefficients {
    /// The table of `terms` coefficients of `expansion` up to `z_max` over heights of half range `half_range` \[µm\].
    /// Interpolating all coefficients alike interpolates e^{izh} itself, with an error of (Δz·a)²/8.
    pub(super) fn new(
        expansion: &dyn Expansion,
        terms: usize,
        z_max: f64,
        half_range: f64,
        tolerance: f64,
    ) -> Self {
        /// Share of the tolerance that this interpolation may take.
        const SHARE: f64 = 1e-3;
        /// Bounds on the number of intervals: the larger keeps a row within the 4096 texels that every Vulkan device holds.
        const INTERVALS: (f64, f64) = (64.0, 4094.0);
        let intervals = (z_max * half_range / (8.0 * SHARE * tolerance).sqrt()).ceil();
        let intervals = intervals.clamp(INTERVALS.0, INTERVALS.1);
        let step = z_max / intervals;
        let columns = intervals as usize + 2;
        let mut values = vec![[0.0; 2]; columns * terms];
        let mut c = vec![Complex64::ZERO; terms];
        for column in 0..columns {
            expansion.coefficients(column as f64 * step, &mut c);
            for (n, c) in c.iter().enumerate() {
                values[n * columns + column] = [c.re as f32, c.im as f32];
            }
        }
        Self { step, columns, values }
    }
}
