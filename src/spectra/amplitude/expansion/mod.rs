//! Separable expansions e^{izh} ≈ Σ_n c_n(z) b_n(h) with z = k·w: the common basis of every fast path.
//!
//! Heights are centred on the middle of their range first, which changes only the phase of P and halves the argument: t = (h − mid)/a ∈
//! \[−1, 1\] with a half the range, and b_n is a function of t. If every b_n is real, the spectra F{g·b_n} are Hermitian and half of each
//! is enough.

pub mod heights;
pub mod optimal;
pub mod taylor;

use crate::surface::HeightField;
use rustfft::num_complex::Complex64;
use serde::Serialize;

/// Family of functions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
pub enum Basis {
    /// Powers of the height (\[Single 2014\] C.1).
    #[default]
    Taylor,
    /// Singular functions of e^{izh} on the heights that occur in the surface.
    Optimal,
}

impl Basis {
    /// All bases.
    pub const ALL: [Self; 2] = [Self::Taylor, Self::Optimal];

    /// Returns the name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Taylor => "taylor",
            Self::Optimal => "optimal",
        }
    }

    /// Returns true if every b_n is real, so that half of each spectrum is enough.
    pub fn is_real(self) -> bool {
        self != Self::Optimal
    }
}

/// Normalisation of heights: t = (h − `mid`)/`half_range`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightScale {
    /// Middle of the range \[µm\].
    pub mid: f64,
    /// Half of the range \[µm\]; 0 for a flat surface.
    pub half_range: f64,
}

impl HeightScale {
    /// Returns the normalisation to the range of a field.
    pub fn of(field: &HeightField) -> Self {
        let (low, high) = field.range();
        Self { mid: (low + high) / 2.0, half_range: (high - low) / 2.0 }
    }

    /// Returns t of a height \[µm\]; 0 on a flat surface.
    pub fn normalise(&self, height: f64) -> f64 {
        if self.half_range > 0.0 { (height - self.mid) / self.half_range } else { 0.0 }
    }
}

/// Family of b_n and c_n. The layers are spectra of b_n; the shader reads c_n from a table over z, or computes it.
pub trait Expansion: Send + Sync {
    /// Returns b_n at t ∈ \[−1, 1\].
    fn basis(&self, n: usize, t: f64) -> Complex64;

    /// Writes c_0 … c_{len−1} at z \[rad/µm\] into `out`.
    fn coefficients(&self, z: f64, out: &mut [Complex64]);

    /// Returns the largest number of terms.
    fn most_terms(&self) -> usize;

    /// Returns a bound on |e^{izh} − Σ_{n<terms} c_n b_n| for every height in range and every z of the family's range up to `z`.
    fn truncation_bound(&self, z: f64, terms: usize) -> f64;

    /// Returns a bound on the error of storage and summation with unit roundoff `roundoff`, for |z| up to `z`.
    fn rounding_bound(&self, z: f64, roundoff: f64) -> f64;
}
