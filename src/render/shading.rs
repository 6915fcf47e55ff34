//! What is asked of the optics, whichever way it is computed.

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

    /// Returns the shares of the tolerance, for pixels whose footprints are long beside what a table is blurred by, or not.
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

    /// The expansion for single directions of `field` where none is named: the thesis' own, which is exact at grazing angles, as long as
    /// what 32-bit floats lose of its large terms is far below the budget; else the optimal one, which loses nothing.
    pub fn suited_basis(&self, field: &HeightField) -> Basis {
        /// Rounding is bounded relative to the mirror's peak, while directions are judged relative to their own, fainter value.
        const FAR_BELOW: f64 = 0.02;
        let x = largest_z(SHORTEST) * HeightScale::of(field).half_range;
        let holds = rounding_bound(x, F32_ROUNDOFF) <= FAR_BELOW * self.budget().window.expansion;
        if holds { Basis::Taylor } else { Basis::Optimal }
    }

    /// Returns the relative L2 error that one sample of a picture keeps: the tolerance, or what taps over footprints of the mean leave to further
    /// samples. `None` where numbers of terms or wavelengths are set by hand.
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

    /// Returns the settings of layers for wavelengths from `shortest` \[µm\] on `device`, through a Gaussian of standard deviation `sigma` \[µm\], or
    /// of one period alone if that is infinite.
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
            budget: self.budget().window,
            basis: self.basis,
            terms: self.terms,
            memory_limit: (device.memory as f64 * DEVICE_SHARE) as usize,
            side_limit: device.max_side as usize,
        })
    }
}
