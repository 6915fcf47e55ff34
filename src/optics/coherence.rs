//! Coherence: the part of the surface over which the light is coherent.
//!
//! Along one axis the window and the copies of the patch fold into one complex weight per sample, W_u(x) = Σ_m g₁(x + mT) e^{iku(x + mT)},
//! so the exact sum costs one patch for any number of copies in the window.

use crate::surface::HeightField;
use crate::surface::statistics::joining;
use crate::surface::tiling::{Tiling, Verdict, tiles};
use rustfft::num_complex::Complex64;
use serde::Serialize;
use std::f64::consts::PI;

/// Cut-off of the Gaussian window in standard deviations: g = e^(−24.5) = 2e-11 there.
pub const GAUSSIAN_CUT: f64 = 7.0;

/// Coherence length of sunlight \[µm\] (\[Dhillon 2014\]).
pub const SUNLIGHT_LENGTH: f64 = 65.0;

/// Positions of the coherence window on the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Windows {
    /// All positions: the mean over them, seen by a pixel that covers many coherence areas.
    #[default]
    All,
    /// n × m positions, (i T_x/n, j T_y/m) from the patch centre; 1 × 1 is the thesis' single window.
    Grid([u32; 2]),
}

impl Windows {
    /// Single window in the middle of the patch.
    pub const ONE: Self = Self::Grid([1, 1]);

    /// Returns the number of positions along each axis; `None` for all positions.
    pub fn grid(self) -> Option<[u32; 2]> {
        match self {
            Self::All => None,
            Self::Grid(counts) => Some(counts),
        }
    }
}

impl std::fmt::Display for Windows {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::All => write!(f, "all"),
            Self::Grid([n, m]) => write!(f, "{n}x{m}"),
        }
    }
}

/// Continuation of the surface beyond the measured patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Beyond {
    /// Periodic extension of the patch, with the orders of the tiling.
    #[default]
    Copies,
    /// Surface with the same statistics: the patch is tapered by a Hann window in each axis, and a Gaussian lag window multiplies its
    /// autocorrelation (Blackman and Tukey, *The Measurement of Power Spectra*, 1958).
    Alike,
}

#[doc(hidden)]
impl Beyond {
    /// Returns the name in options and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Copies => "copies",
            Self::Alike => "alike",
        }
    }

    /// Returns the default continuation of the surface beyond a patch like `field`: copies if they join without visible steps and without a
    /// jump of phase. Where there is too little memory for the spectrum, the steps decide.
    pub fn suited_to(field: &HeightField) -> Self {
        // The only error of `joining` is too little memory.
        Self::across(&joining(field).unwrap_or_else(|_| tiles(field)))
    }

    /// Returns the default continuation of a surface whose seams are `tiling`.
    pub fn across(tiling: &Tiling) -> Self {
        match tiling.verdict {
            Verdict::Tiles => Self::Copies,
            _ => Self::Alike,
        }
    }
}

/// Coherence of the light at the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Coherence {
    /// Periodic patch seen through g = exp(−(x² + y²)/(2σ²)), σ = `length`/4 \[µm\].
    Gaussian {
        /// Coherence length ℓ \[µm\]; sunlight: 65 µm.
        length: f64,
    },
    /// Finite grating of exactly `[n, m]` copies of the patch, without another window (\[Single 2014\] C.2).
    Repeats([u32; 2]),
}

impl Coherence {
    /// Sunlight: a Gaussian of 65 µm (\[Dhillon 2014\]).
    pub const SUNLIGHT: Self = Self::Gaussian { length: SUNLIGHT_LENGTH };

    /// Returns σ of the Gaussian window \[µm\]; `None` for a finite grating.
    pub fn sigma(&self) -> Option<f64> {
        match self {
            Self::Gaussian { length } => Some(length / 4.0),
            Self::Repeats(_) => None,
        }
    }

    /// Returns the window's effective area A = ∬ g² dx dy \[µm²\] over patches of side `patch` \[µm\].
    pub fn area(&self, patch: [f64; 2]) -> f64 {
        match *self {
            Self::Gaussian { length } => PI * (length / 4.0).powi(2),
            Self::Repeats([n, m]) => f64::from(n) * f64::from(m) * patch[0] * patch[1],
        }
    }

    /// Returns the displacement along `axis` \[µm\] beyond which the window's autocorrelation is below `level`. It limits how fast the
    /// response varies with spatial frequency.
    pub fn correlation_extent(&self, patch: [f64; 2], axis: usize, level: f64) -> f64 {
        match *self {
            // The autocorrelation of g is exp(−x²/(4σ²)).
            Self::Gaussian { length } => 2.0 * (length / 4.0) * (1.0 / level).ln().sqrt(),
            Self::Repeats(n) => f64::from(n[axis]) * patch[axis],
        }
    }

    /// Returns the extent of the window's autocorrelation along a ray, from its parts along x and y: an ellipse for a Gaussian, a rectangle
    /// for repeats.
    pub fn path(&self, x: f64, y: f64) -> f64 {
        match self {
            Self::Gaussian { .. } => x.hypot(y),
            Self::Repeats(_) => x + y,
        }
    }
}

/// One axis of a patch seen through a window: positions of the samples and of the window.
#[derive(Clone, Copy, Debug)]
pub struct WindowedAxis {
    /// Number of samples.
    pub samples: usize,
    /// Sample spacing \[µm\].
    pub spacing: f64,
    /// Shift of the window from the patch centre \[µm\], at least 0 and below one period.
    pub shift: f64,
}

impl WindowedAxis {
    /// Returns the period of the patch along this axis \[µm\].
    pub fn period(&self) -> f64 {
        self.samples as f64 * self.spacing
    }

    /// Returns the position of sample `i` from the patch centre \[µm\].
    pub fn position(&self, i: usize) -> f64 {
        (i as f64 - (self.samples as f64 - 1.0) / 2.0) * self.spacing
    }

    /// Returns the Gaussian window of standard deviation `sigma` \[µm\] over all copies of the patch with |x + mT − shift| ≤ 7σ.
    pub fn gaussian(&self, sigma: f64) -> GaussianWindow {
        let (period, cut) = (self.period(), GAUSSIAN_CUT * sigma);
        let place = |i: usize| self.position(i) - self.shift;
        let first = ((-cut - place(self.samples.saturating_sub(1))) / period).ceil();
        let last = ((cut - place(0)) / period).floor();
        let copies: Vec<f64> = (first as i64..=last as i64).map(|m| m as f64 * period).collect();
        let value = |x: f64| if x.abs() <= cut { (-0.5 * (x / sigma).powi(2)).exp() } else { 0.0 };
        let values =
            (0..self.samples).flat_map(|i| copies.iter().map(move |copy| place(i) + copy)).map(value);
        GaussianWindow { axis: *self, values: values.collect(), copies }
    }

    /// Returns W_u(x_i) for `copies` copies side by side: e^{iκx} Σ_{m<n} e^{iκmT}. With a shifted window the copies begin at the shift, so
    /// samples before it come from the copy after the last.
    pub fn repeat_weights(&self, copies: u32, kappa: f64) -> Vec<Complex64> {
        let period = self.period();
        let factor = periodic_factor(copies, kappa * period);
        let begin = self.position(0) - self.spacing / 2.0 + self.shift;
        (0..self.samples)
            .map(|i| {
                let x = self.position(i);
                let wrapped = if x < begin { period } else { 0.0 };
                factor * Complex64::cis(kappa * (x + wrapped))
            })
            .collect()
    }
}

/// Gaussian window at every sample of an axis.
#[derive(Clone, Debug)]
pub struct GaussianWindow {
    axis: WindowedAxis,
    /// Offsets of the copies of the patch within the window \[µm\].
    copies: Vec<f64>,
    /// Window at each copy, sample by sample.
    values: Vec<f64>,
}

impl GaussianWindow {
    /// Returns W_u(x_i) for every sample, for `kappa` = k·u \[rad/µm\].
    pub fn weights(&self, kappa: f64) -> Vec<Complex64> {
        let turns: Vec<Complex64> = self.copies.iter().map(|copy| Complex64::cis(kappa * copy)).collect();
        let weight = |i: usize| -> Complex64 {
            let values = &self.values[i * turns.len()..][..turns.len()];
            let sum: Complex64 = turns.iter().zip(values).map(|(turn, value)| turn * value).sum();
            sum * Complex64::cis(kappa * (self.axis.position(i) - self.axis.shift))
        };
        (0..self.axis.samples).map(weight).collect()
    }
}

/// Returns Σ_{m<n} e^{imφ}, finite and exact for sin(φ/2) → 0. \[Single 2014\] C.15 is 0/0 there; this form reduces φ to the nearest
/// multiple of 2π first and returns the value of the sum, n, at the peak.
pub fn periodic_factor(copies: u32, phase: f64) -> Complex64 {
    let n = f64::from(copies);
    // The remainder of the division by 2π, within ±π: as good as the argument itself, which is known to 2⁻⁵³ of its size.
    let phase = phase - 2.0 * PI * (phase / (2.0 * PI)).round();
    let half = phase / 2.0;
    // Dirichlet kernel sin(nφ/2)/sin(φ/2) → n; below this the first dropped term, (nφ)²/24, is under the rounding.
    let magnitude = if (n * half).abs() < 1e-8 { n } else { (n * half).sin() / half.sin() };
    Complex64::from_polar(1.0, (n - 1.0) * half) * magnitude
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_periodic_factor_is_the_sum_it_stands_for_even_at_its_peaks() {
        for copies in [1u32, 2, 3, 7, 40, 1000] {
            for centre in [0.0, 2.0 * PI, 80.0 * PI, -4.0 * PI] {
                for offset in [0.0, 1e-10, -1e-10, 1e-4, 1e-3, 0.1, 1.0, PI] {
                    let phase = centre + offset;
                    let sum: Complex64 = (0..copies).map(|m| Complex64::cis(f64::from(m) * phase)).sum();
                    let factor = periodic_factor(copies, phase);
                    // The argument itself is only known to centre·2⁻⁵³; the sum amplifies that by n²/2.
                    let conditioning = 1e-15 * (1.0 + centre.abs()) * f64::from(copies).powi(2);
                    assert!((sum - factor).norm() < 1e-12 + conditioning, "{copies} copies at {phase}");
                }
            }
        }
    }

    #[test]
    fn the_folded_window_is_the_sum_over_all_copies() {
        let axis = WindowedAxis { samples: 6, spacing: 0.25, shift: 0.5 };
        let (sigma, kappa) = (2.0, 3.7);
        let folded: Complex64 = axis.gaussian(sigma).weights(kappa).iter().sum();
        // Direct sum over every sample of the periodic surface.
        let direct: Complex64 = (-400..400)
            .map(|j| (f64::from(j) + 0.5) * 0.25 - 0.5)
            .filter(|x: &f64| x.abs() <= GAUSSIAN_CUT * sigma)
            .map(|x| Complex64::from_polar((-0.5 * (x / sigma).powi(2)).exp(), kappa * x))
            .sum();
        assert!((folded - direct).norm() < 1e-12);
    }
}
