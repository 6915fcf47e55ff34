//! What is asked of the optics, whichever way it is computed.

use crate::expansion::Basis;
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::Illuminant;
use crate::precompute::Budget;
use crate::precompute::kernel::SPECKLE;

/// What a tolerance is promised for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// Single directions, each relative to its own value, at single wavelengths too (RMS over directions).
    #[default]
    Directions,
    /// The colours of a picture: relative L2 of linear RGB over the covered pixels, and RMS of each pixel's own error.
    Picture,
}

/// A picture's colours average the errors of many wavelengths; what remains coherent in the brightest pixels, which decide
/// the L2 error, is an intensity error of twice the amplitude error, where single dark directions err [`SPECKLE`] times as
/// much as it.
const PICTURE_GAIN: f64 = SPECKLE / 2.0;

/// Settings of the optics, validated.
#[derive(Clone, Debug, PartialEq)]
pub struct Shading {
    /// What surrounds the patch.
    pub coherence: Coherence,
    /// Window centres to average over.
    pub windows: [u32; 2],
    /// Refractive index of the surface.
    pub ior: f64,
    /// The light's spectrum.
    pub illuminant: Illuminant,
    /// Relative error that the user accepts.
    pub tolerance: f64,
    /// What the tolerance is promised for.
    pub purpose: Purpose,
    /// Which expansion the layers hold.
    pub basis: Basis,
    /// Terms of the expansion, where the user names them.
    pub terms: Option<usize>,
    /// Wavelengths of the colour integral, where the user names them.
    pub wavelengths: Option<usize>,
}

impl Shading {
    /// What the layers may err by. Shares of the tolerance add up as squares; reading between texels costs the most to
    /// lower and gets the largest.
    pub fn budget(&self) -> Budget {
        let (gain, interpolation, expansion) = match self.purpose {
            Purpose::Directions => (1.0, 0.7, 0.35),
            Purpose::Picture => (PICTURE_GAIN, 0.9, 0.35),
        };
        Budget {
            interpolation: gain * interpolation * self.tolerance,
            expansion: gain * expansion * self.tolerance,
        }
    }

    /// What the sum over wavelengths may err by, relative to the colour.
    pub fn quadrature(&self) -> f64 {
        const SHARE: f64 = 0.6;
        SHARE * self.tolerance
    }
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            coherence: Coherence::SUNLIGHT,
            windows: [1, 1],
            ior: 1.5,
            illuminant: Illuminant::D65,
            tolerance: 1e-2,
            purpose: Purpose::Directions,
            basis: Basis::default(),
            terms: None,
            wavelengths: None,
        }
    }
}
