//! What is asked of the optics, whichever way it is computed.

use crate::expansion::Basis;
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::Illuminant;

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
    /// Which expansion the layers hold.
    pub basis: Basis,
    /// Terms of the expansion, where the user names them.
    pub terms: Option<usize>,
    /// Wavelengths of the colour integral, where the user names them.
    pub wavelengths: Option<usize>,
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            coherence: Coherence::SUNLIGHT,
            windows: [1, 1],
            ior: 1.5,
            illuminant: Illuminant::D65,
            tolerance: 1e-2,
            basis: Basis::default(),
            terms: None,
            wavelengths: None,
        }
    }
}
