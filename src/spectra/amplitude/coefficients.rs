//! Coefficients c_n(z) in shaders: by the recurrence of the Taylor series, or from a table.

use crate::spectra::amplitude::expansion::{Basis, Expansion};
use rustfft::num_complex::Complex64;

/// Coefficients c_n(z) on a uniform grid of z; linear between its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// True if shaders compute them: c_0 = 1, c_n = c_{n−1} i z a/n. Then the table has only its end points.
    pub taylor: bool,
    /// Half the range of heights, a \[µm\].
    pub half_range: f64,
    /// Points over 0 … z_max, its ends included.
    pub columns: usize,
    /// Values pair by pair of terms, point by point: (Re, Im) of term 2p, (Re, Im) of term 2p + 1.
    pub values: Vec<[f32; 4]>,
}

/// Share of the tolerance for interpolation between the points.
const SHARE: f64 = 0.03;
/// Bounds on the number of intervals: the larger keeps a row within the 4096 texels that every Vulkan device supports.
const INTERVALS: (f64, f64) = (64.0, 4094.0);

impl Coefficients {
    /// Tabulates `terms` coefficients of `family`, which is of `basis`, over 0 … `z_max` for heights of half range `half_range` \[µm\].
    ///
    /// Interpolating all coefficients alike interpolates e^{izh} itself, with an error of (Δz·a)²/8; intensities err by twice that. Nothing
    /// cancels.
    pub(super) fn new(
        basis: Basis,
        family: &dyn Expansion,
        terms: usize,
        z_max: f64,
        half_range: f64,
        tolerance: f64,
    ) -> Self {
        let taylor = basis == Basis::Taylor;
        let needed = (z_max * half_range / (4.0 * SHARE * tolerance).sqrt()).ceil();
        let intervals = if taylor { 1.0 } else { needed.clamp(INTERVALS.0, INTERVALS.1) };
        let columns = intervals as usize + 1;
        let mut values = vec![[0.0f32; 4]; terms.div_ceil(2) * columns];
        let mut c = vec![Complex64::ZERO; terms];
        for column in 0..columns {
            family.coefficients(z_max * column as f64 / intervals, &mut c);
            for (n, c) in c.iter().enumerate() {
                let texel = &mut values[n / 2 * columns + column];
                texel[n % 2 * 2..][..2].copy_from_slice(&[c.re as f32, c.im as f32]);
            }
        }
        Self { taylor, half_range, columns, values }
    }
}
