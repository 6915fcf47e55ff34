//! Settings of the optics, independent of the method.

use crate::budget::{ErrorBudget, Purpose, Question};
use crate::error::{Error, Remedy, Result};
use crate::optics::coherence::{Beyond, Coherence, Windows};
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::{Illuminant, MIDDLE, SHORTEST};
use crate::spectra::amplitude::LayerSettings;
use crate::spectra::amplitude::expansion::taylor::{F32_ROUNDOFF, rounding_bound};
use crate::spectra::amplitude::expansion::{Basis, HeightScale};
use crate::spectra::amplitude::layers::largest_z;
use crate::spectra::power::Blur;
use crate::surface::HeightField;
use crate::vk::selection::Candidate;

/// Settings of the optics, validated.
#[derive(Clone, Debug, PartialEq)]
pub struct Shading {
    /// Coherence of the light on the surface.
    pub coherence: Coherence,
    /// Positions of the window to average over.
    pub windows: Windows,
    /// Continuation of the surface beyond the patch, for the mean over all windows.
    pub beyond: Beyond,
    /// Reflectance of the surface.
    pub reflectance: Reflectance,
    /// Spectrum of the light.
    pub illuminant: Illuminant,
    /// Relative error that the user accepts.
    pub tolerance: f64,
    /// Quantity that the tolerance limits: pictures or single directions.
    pub purpose: Purpose,
    /// Factor by which the sum over wavelengths may exceed its share of the tolerance: 1, or more for previews.
    pub looser_colours: f64,
    /// Expansion of the layers.
    pub basis: Basis,
    /// Terms of the expansion, if the user sets them.
    pub terms: Option<usize>,
    /// Wavelengths of the colour integral, if the user sets them.
    pub wavelengths: Option<usize>,
}

impl Shading {
    /// Returns these settings for the colours of a picture.
    pub fn for_pictures(self) -> Self {
        Self { purpose: Purpose::Picture, ..self }
    }

    /// Returns the variance of (u, v) of the specular order due to coherence, at the middle of the spectrum; `None` for
    /// a finite grating.
    pub fn specular_spread(&self) -> Option<f64> {
        self.coherence.sigma().map(|sigma| Blur::of_coherence(sigma).variance[0] * MIDDLE.powi(2))
    }

    /// Returns the shares of the tolerance. `has_long_footprints`: the footprints of pixels are long compared with the
    /// blur of a table.
    pub fn budget_of_footprints(&self, has_long_footprints: bool) -> ErrorBudget {
        let is_grating = self.coherence.sigma().is_none();
        let (purpose, looser_colours) = (self.purpose, self.looser_colours);
        ErrorBudget::new(
            self.tolerance,
            Question { purpose, is_grating, has_long_footprints, looser_colours },
        )
    }

    /// Returns the shares of the tolerance that do not depend on footprints.
    pub fn budget(&self) -> ErrorBudget {
        self.budget_of_footprints(false)
    }

    /// Returns the default expansion for single directions of `field`: the Taylor series of the thesis, which is exact
    /// at grazing angles, if the 32-bit rounding of its large terms is far below the budget, and otherwise the optimal
    /// basis, which loses no digits.
    pub fn suited_basis(&self, field: &HeightField) -> Basis {
        /// The rounding bound is relative to the mirror peak, but errors of directions are relative to the
        /// value itself, which is fainter.
        const FAR_BELOW: f64 = 0.02;
        let x = largest_z(SHORTEST) * HeightScale::of(field).half_range;
        let holds = rounding_bound(x, F32_ROUNDOFF) <= FAR_BELOW * self.budget().window.expansion;
        if holds { Basis::Taylor } else { Basis::Optimal }
    }

    /// Returns the relative L2 error bound of one sample of a picture: the tolerance, or for the mean over footprints
    /// the error that remains before further samples are averaged. `None` if the user sets the terms or wavelengths.
    pub fn promised_of_one_sample(&self) -> Option<f64> {
        let by_hand = self.terms.is_some() || self.wavelengths.is_some();
        let promised = match self.windows {
            Windows::All => self.budget().mean.one_sample,
            Windows::Grid(_) => self.tolerance,
        };
        (!by_hand).then_some(promised)
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

/// Fraction of the device's memory for the layers; pictures and the rest share the remainder.
const DEVICE_SHARE: f64 = 0.75;

impl Shading {
    /// Checks that no number of wavelengths is set for a finite grating, whose wavelengths follow from its orders.
    ///
    /// # Errors
    /// Fails with a remedy.
    pub fn check_wavelengths(&self) -> Result<()> {
        if self.wavelengths.is_none() || self.coherence.sigma().is_some() {
            return Ok(());
        }
        Err(Error::usage(
            "a finite grating takes its wavelengths where the orders are",
            [Remedy::AutomaticWavelengths, Remedy::GaussianCoherence],
        ))
    }

    /// Returns the settings of layers for wavelengths from `shortest` \[µm\] on `device`, for a Gaussian window of
    /// standard deviation `sigma` \[µm\], or for one period if `sigma` is infinite.
    ///
    /// # Errors
    /// Fails if more than one window is to be averaged over.
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
            budget: self.budget().window,
            basis: self.basis,
            terms: self.terms,
            memory_limit: (device.memory as f64 * DEVICE_SHARE) as usize,
            side_limit: device.max_side as usize,
        })
    }
}
