//! The mean over coherence areas, seen by a pixel that covers many of them.
//!
//! Averaging |P|²/A over all positions of a Gaussian window leaves the power of each order m of the patch, blurred by the
//! transform of the light's mutual coherence γ(Δ) = exp(−Δ²/4σ²) (Gaussian Schell model; Mandel and Wolf, *Optical Coherence
//! and Quantum Optics*, chapter 5):
//!
//! ```text
//! ⟨|P|²⟩/A = Σ_m |c_m(z)|² γ̂(f − m/T),   γ̂(f) = 4πσ² exp(−(2πσ)²|f|²),   c_m(z) = mean over the patch of e^{izh} e^{2πi m·x/T}
//! ```
//!
//! There is no phase between orders, and every term is at least 0. As everywhere in the program, z = k|w| is positive and
//! frequencies are those of ω_i + ω_r = −(u, v), which is the same point reflection of both signs.

pub mod chebyshev;
mod orders;
mod pyramid;
mod read;
mod series;

pub use crate::optics::coherence::Beyond;
pub use orders::{OrderGrid, OrderPowers, Transform};
pub use pyramid::{Downsampling, Pyramid, PyramidLevel};
pub use read::{OrderReader, ReadScratch, Square};
pub use series::{EVEN, Estimate, OrderSeries, PowerSettings, TERMS_AT_ONCE};

use std::f64::consts::PI;

/// Standard deviation of the lag window of [`Beyond::Alike`] over the side of the patch. The autocorrelation of the taper falls to a
/// few percent at half a side; beyond it the patch says nothing about the surface.
pub const LAG_WINDOW: f64 = 0.18;

/// Gaussian that blurs each order, by axis.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Blur {
    /// Variance along f_x and f_y \[µm⁻²\].
    pub variance: [f64; 2],
}

impl Blur {
    /// Returns γ̂ of a Gaussian coherence window of standard deviation `sigma` \[µm\].
    pub fn of_coherence(sigma: f64) -> Self {
        Self { variance: [1.0 / (8.0 * (PI * sigma).powi(2)); 2] }
    }

    /// Returns the blur of the orders of a patch of side lengths `patch` \[µm\] in light of coherence `sigma` \[µm\]: with
    /// [`Beyond::Alike`] the lag window's transform widens it.
    pub fn of_orders(sigma: f64, patch: [f64; 2], beyond: Beyond) -> Self {
        let mut blur = Self::of_coherence(sigma);
        if beyond == Beyond::Alike {
            for (variance, side) in blur.variance.iter_mut().zip(patch) {
                *variance += 1.0 / (2.0 * PI * LAG_WINDOW * side).powi(2);
            }
        }
        blur
    }
}
