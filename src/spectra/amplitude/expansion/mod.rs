//! Separable expansions e^{izh} ≈ Σ_n c_n(z) b_n(h) with z = k·w: the one idea behind every fast path.
//!
//! Heights are centred on the middle of their range first, which changes only the phase of P and halves the argument:
//! t = (h − mid)/a ∈ \[−1, 1\] with a half the range, and b_n is a function of t. Where every b_n is real, the spectra
//! F{g·b_n} are Hermitian and half of each is enough.

pub mod heights;
pub mod optimal;
pub mod taylor;

use crate::surface::HeightField;
use rustfft::num_complex::Complex64;
use serde::Serialize;

/// Which family of functions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
pub enum Basis {
    /// Powers of the height (\[Single 2014\] C.1).
    #[default]
    Taylor,
    /// Singular functions of e^{izh} on the heights that the surface really has.
    Optimal,
}

impl Basis {
    /// Every basis that a user chooses from.
    pub const ALL: [Self; 2] = [Self::Taylor, Self::Optimal];

    /// The word for it on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Taylor => "taylor",
            Self::Optimal => "optimal",
        }
    }

    /// Whether every b_n is real, so that half of each spectrum is enough.
    pub fn is_real(self) -> bool {
        self != Self::Optimal
    }
}

/// Where the heights lie: t = (h − `mid`)/`half_range`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightScale {
    /// Middle of the range \[µm\].
    pub mid: f64,
    /// Half of the range \[µm\]; 0 for a flat surface.
    pub half_range: f64,
}

impl HeightScale {
    /// The scale of a field's own range.
    pub fn of(field: &HeightField) -> Self {
        let (low, high) = field.range();
        Self { mid: (low + high) / 2.0, half_range: (high - low) / 2.0 }
    }

    /// t of a height \[µm\]; 0 on a flat surface.
    pub fn normalise(&self, height: f64) -> f64 {
        if self.half_range > 0.0 { (height - self.mid) / self.half_range } else { 0.0 }
    }
}

/// A family of b_n and c_n. The precompute stores spectra of b_n; the shader reads c_n from a table over z, or computes it.
pub trait Expansion: Send + Sync {
    /// b_n at t ∈ \[−1, 1\].
    fn basis(&self, n: usize, t: f64) -> Complex64;

    /// c_0 … c_{len−1} at z \[rad/µm\] into `out`.
    fn coefficients(&self, z: f64, out: &mut [Complex64]);

    /// The largest number of terms that there is.
    fn most_terms(&self) -> usize;

    /// A bound on |e^{izh} − Σ_{n<terms} c_n b_n| that holds for every height in range and every z of the
    /// family's range up to `z`.
    fn truncation_bound(&self, z: f64, terms: usize) -> f64;

    /// A bound on what storing and summing with unit roundoff `roundoff` adds, for |z| up to `z`.
    fn rounding_bound(&self, z: f64, roundoff: f64) -> f64;
}
