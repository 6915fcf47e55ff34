//! What is asked of the optics, whichever way it is computed.

use crate::error::{Error, Result};
use crate::expansion::Basis;
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::Illuminant;
use crate::precompute::Settings;
use crate::vk::selection::Candidate;

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

/// Share of the device's memory that the layers may take; pictures and the rest need some.
const DEVICE_SHARE: f64 = 0.75;

impl Shading {
    /// What layers have to be made for, for wavelengths from `shortest` \[µm\] on `device`.
    ///
    /// # Errors
    /// For settings that layers cannot do.
    pub fn layer_settings(&self, shortest: f64, device: &Candidate) -> Result<Settings> {
        let Coherence::Gaussian { length } = self.coherence else {
            return Err(Error::usage(
                "pictures by --method spectral do not do --coherence repeats",
                "use --coherence gaussian:LENGTH or --method reference",
            ));
        };
        self.windowed_settings(length / 4.0, shortest, device)
    }

    /// The same through a Gaussian of standard deviation `sigma` \[µm\], or, where that is infinite, of one period alone.
    ///
    /// # Errors
    /// For what layers cannot do.
    pub fn windowed_settings(&self, sigma: f64, shortest: f64, device: &Candidate) -> Result<Settings> {
        if self.windows != [1, 1] {
            return Err(Error::usage(
                "--method spectral does one window only",
                "leave --windows away or use --method reference",
            ));
        }
        Ok(Settings {
            sigma,
            shortest_wavelength: shortest,
            tolerance: self.tolerance,
            basis: self.basis,
            terms: self.terms,
            memory_limit: (device.memory as f64 * DEVICE_SHARE) as usize,
            side_limit: device.max_side as usize,
        })
    }
}
