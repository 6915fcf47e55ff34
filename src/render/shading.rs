//! What is asked of the optics, whichever way it is computed.

use crate::error::{Error, Remedy, Result};
use crate::expansion::taylor::{F32_ROUNDOFF, rounding_bound};
use crate::expansion::{Basis, HeightScale};
use crate::filter::ERROR_OF_ONE_SAMPLE;
use crate::optics::coherence::{Beyond, Coherence, Windows};
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::{Illuminant, MIDDLE, SHORTEST};
use crate::precompute::kernel::SPECKLE;
use crate::precompute::layers::largest_z;
use crate::precompute::{Budget, LayerSettings};
use crate::spectra::power::Blur;
use crate::surface::HeightField;
use crate::vk::selection::Candidate;

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

/// How much more linear interpolation errs midway between texels than on average (RMS): (1/8)/√(1/120). The one bright pixel
/// of a picture may stand there.
const MIDWAY: f64 = 1.369;

/// Shares of a tolerance; their squares add up to 1 at the most, because the errors are independent. Reading between texels
/// costs the most to lower and gets the largest, in pictures all the more: wavelengths cost the logarithm of their share.
struct Shares {
    interpolation: f64,
    expansion: f64,
    quadrature: f64,
}

/// Settings of the optics, validated.
#[derive(Clone, Debug, PartialEq)]
pub struct Shading {
    /// What surrounds the patch.
    pub coherence: Coherence,
    /// Positions of the window to average over.
    pub windows: Windows,
    /// How the surface goes on beyond the patch, for the mean over all windows.
    pub beyond: Beyond,
    /// What the surface reflects.
    pub reflectance: Reflectance,
    /// The light's spectrum.
    pub illuminant: Illuminant,
    /// Relative error that the user accepts.
    pub tolerance: f64,
    /// What the tolerance is promised for.
    pub purpose: Purpose,
    /// By how much more than its share the sum over wavelengths may err: 1, or more for a glance.
    pub looser_colours: f64,
    /// Which expansion the layers hold.
    pub basis: Basis,
    /// Terms of the expansion, where the user names them.
    pub terms: Option<usize>,
    /// Wavelengths of the colour integral, where the user names them.
    pub wavelengths: Option<usize>,
}

impl Shading {
    /// The same for the colours of a picture.
    pub fn for_pictures(self) -> Self {
        Self { purpose: Purpose::Picture, ..self }
    }

    /// Variance of (u, v) over which coherence spreads the specular order in the middle of the spectrum; `None` for a finite grating.
    pub fn specular_spread(&self) -> Option<f64> {
        self.coherence.sigma().map(|sigma| Blur::of_coherence(sigma).variance[0] * MIDDLE.powi(2))
    }

    /// How much more a single wavelength of a single direction may err than what the tolerance is promised for. Through repeats
    /// a few orders may be all that a colour is made of.
    pub fn gain(&self) -> f64 {
        match (self.purpose, self.coherence) {
            (Purpose::Picture, Coherence::Gaussian { .. }) => PICTURE_GAIN,
            _ => 1.0,
        }
    }

    /// What the layers may err by.
    pub fn budget(&self) -> Budget {
        let shares = self.shares();
        let place = match self.purpose {
            Purpose::Directions => 1.0,
            Purpose::Picture => MIDWAY,
        };
        Budget {
            interpolation: self.gain() * shares.interpolation * self.tolerance / place,
            expansion: self.gain() * shares.expansion * self.tolerance,
        }
    }

    /// The expansion for single directions of `field` where none is named: the thesis' own, which is exact at grazing angles, as long as
    /// what 32-bit floats lose of its large terms is far below the budget; else the optimal one, which loses nothing.
    pub fn suited_basis(&self, field: &HeightField) -> Basis {
        /// Rounding is bounded relative to the mirror's peak, while directions are judged relative to their own, fainter value.
        const FAR_BELOW: f64 = 0.02;
        let x = largest_z(SHORTEST) * HeightScale::of(field).half_range;
        let holds = rounding_bound(x, F32_ROUNDOFF) <= FAR_BELOW * self.budget().expansion;
        if holds { Basis::Taylor } else { Basis::Optimal }
    }

    /// Returns the relative L2 error that one sample of a picture keeps: the tolerance, or what taps over footprints of the mean leave to further
    /// samples. `None` where numbers of terms or wavelengths are set by hand.
    pub fn promised_of_one_sample(&self) -> Option<f64> {
        let by_hand = self.terms.is_some() || self.wavelengths.is_some();
        let promised = match self.windows {
            Windows::All => self.tolerance.max(ERROR_OF_ONE_SAMPLE),
            Windows::Grid(_) => self.tolerance,
        };
        (!by_hand).then_some(promised)
    }

    /// What the sum over wavelengths may err by, relative to the colour.
    pub fn quadrature(&self) -> f64 {
        self.shares().quadrature * self.tolerance * self.looser_colours
    }

    fn shares(&self) -> Shares {
        match self.purpose {
            Purpose::Directions => Shares { interpolation: 0.7, expansion: 0.35, quadrature: 0.6 },
            // Near the specular direction the error of reading is common to all directions.
            Purpose::Picture => Shares { interpolation: 0.5, expansion: 0.5, quadrature: 0.48 },
        }
    }
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            coherence: Coherence::SUNLIGHT,
            windows: Windows::All,
            beyond: Beyond::Copies,
            reflectance: Reflectance::default(),
            illuminant: Illuminant::D65,
            tolerance: 1e-2,
            purpose: Purpose::Directions,
            looser_colours: 1.0,
            basis: Basis::default(),
            terms: None,
            wavelengths: None,
        }
    }
}

/// Share of the device's memory that the layers may take; pictures and the rest need some.
const DEVICE_SHARE: f64 = 0.75;

impl Shading {
    /// Fails where wavelengths are named that repeats would not take.
    ///
    /// # Errors
    /// With what to do.
    pub fn check_wavelengths(&self) -> Result<()> {
        if self.wavelengths.is_none() || self.coherence.sigma().is_some() {
            return Ok(());
        }
        Err(Error::usage(
            "a finite grating takes its wavelengths where the orders are",
            [Remedy::AutomaticWavelengths, Remedy::GaussianCoherence],
        ))
    }

    /// What layers have to be made for, for wavelengths from `shortest` \[µm\] on `device`.
    ///
    /// # Errors
    /// For settings that layers cannot do.
    pub fn layer_settings(&self, shortest: f64, device: &Candidate) -> Result<LayerSettings> {
        let Coherence::Gaussian { length } = self.coherence else {
            return Err(Error::usage(
                "a window is Gaussian, and a finite grating has none",
                Remedy::GaussianCoherence,
            ));
        };
        self.windowed_settings(length / 4.0, shortest, device)
    }

    /// The same through a Gaussian of standard deviation `sigma` \[µm\], or, where that is infinite, of one period alone.
    ///
    /// # Errors
    /// For what layers cannot do.
    pub fn windowed_settings(&self, sigma: f64, shortest: f64, device: &Candidate) -> Result<LayerSettings> {
        if self.windows != Windows::ONE {
            return Err(Error::usage(
                "spectra through a window are of one window",
                [Remedy::AllWindows, Remedy::OneWindow, Remedy::ReferenceMethod],
            ));
        }
        Ok(LayerSettings {
            sigma,
            shortest_wavelength: shortest,
            budget: self.budget(),
            basis: self.basis,
            terms: self.terms,
            memory_limit: (device.memory as f64 * DEVICE_SHARE) as usize,
            side_limit: device.max_side as usize,
        })
    }
}
