//! Settings of the optics, checked in one place.

use crate::budget::{ErrorBudget, Purpose, Question};
use crate::error::{Error, Remedy, Result};
use crate::optics::coherence::{Beyond, Coherence, Windows};
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::{Illuminant, MIDDLE, SHORTEST};
use crate::spectra::amplitude::expansion::taylor::{F32_ROUNDOFF, rounding_bound};
use crate::spectra::amplitude::expansion::{Basis, HeightScale};
use crate::spectra::amplitude::layers::largest_z;
use crate::spectra::power::Blur;
use crate::surface::HeightField;

pub use crate::table::LEAST_TOLERANCE as LEAST_TABLE_TOLERANCE;

/// Method of computing the optics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Sum over wavelengths: of one window or a finite grating on the device, of the mean for single directions on the
    /// CPU.
    #[default]
    Spectral,
    /// Colour table of the mean, read on the device.
    Table,
    /// F64 reference, on the CPU.
    Reference,
}

impl Method {
    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spectral => "spectral",
            Self::Table => "table",
            Self::Reference => "reference",
        }
    }

    /// Returns the method of pictures on the device: the mean over all windows is read from a table, one window is
    /// summed over wavelengths.
    pub fn of_pictures(windows: Windows) -> Self {
        if windows == Windows::All { Self::Table } else { Self::Spectral }
    }
}

/// Settings of the optics. Whatever takes them refuses those that do not go together.
#[derive(Clone, Debug, PartialEq)]
pub struct Optics {
    /// Method.
    #[doc(hidden)]
    pub method: Method,
    /// Coherence of the light on the surface.
    #[doc(hidden)]
    pub coherence: Coherence,
    /// Positions of the window to average over.
    #[doc(hidden)]
    pub windows: Windows,
    /// Continuation of the surface beyond the patch, for the mean over all windows.
    #[doc(hidden)]
    pub beyond: Beyond,
    /// Reflectance of the surface.
    #[doc(hidden)]
    pub reflectance: Reflectance,
    /// Spectrum of the light.
    #[doc(hidden)]
    pub illuminant: Illuminant,
    /// Relative error that the user accepts.
    #[doc(hidden)]
    pub tolerance: f64,
    /// Quantity that the tolerance limits: pictures or single directions.
    #[doc(hidden)]
    pub purpose: Purpose,
    /// Expansion of the layers.
    #[doc(hidden)]
    pub basis: Basis,
    /// Terms of the expansion, if the user sets them.
    #[doc(hidden)]
    pub terms: Option<usize>,
    /// Wavelengths of the colour integral, if the user sets them.
    #[doc(hidden)]
    pub wavelengths: Option<usize>,
}

#[doc(hidden)]
impl Optics {
    /// Returns these settings if they go together.
    ///
    /// # Errors
    /// Fails with a remedy.
    pub fn checked(self) -> Result<Self> {
        self.check()?;
        Ok(self)
    }

    /// Checks that these settings go together.
    ///
    /// # Errors
    /// Fails with a remedy.
    pub fn check(&self) -> Result<()> {
        let is_grating = self.coherence.sigma().is_none();
        let least = Remedy::Tolerance(LEAST_TABLE_TOLERANCE);
        match (self.method, self.windows) {
            (_, Windows::All) if is_grating => Err(Error::usage(
                "a finite grating stands at one place, and a mean over all windows is of Gaussian coherence",
                [Remedy::OneWindow, Remedy::GaussianCoherence],
            )),
            (Method::Spectral, Windows::All) if self.purpose == Purpose::Picture => Err(Error::usage(
                "pictures of the mean over all windows are read from a colour table",
                [Remedy::TableMethod, Remedy::OneWindow],
            )),
            (Method::Table, Windows::Grid(_)) => Err(Error::usage(
                "a colour table holds the mean over all windows",
                [Remedy::AllWindows, Remedy::SpectralMethod],
            )),
            (Method::Table, Windows::All) if self.tolerance < LEAST_TABLE_TOLERANCE => Err(Error::usage(
                format!(
                    "a table has 16-bit floats: the least tolerance that it keeps is {:e}",
                    LEAST_TABLE_TOLERANCE
                ),
                match self.purpose {
                    Purpose::Directions => [least, Remedy::SpectralMethod],
                    Purpose::Picture => [least, Remedy::OneWindow],
                },
            )),
            (_, Windows::All) if self.terms.is_some() => Err(Error::usage(
                "the number of terms is that of the expansion for one window",
                [Remedy::OneWindow, Remedy::AutomaticTerms],
            )),
            (Method::Spectral, _) if is_grating && self.wavelengths.is_some() => Err(Error::usage(
                "a finite grating takes its wavelengths where the orders are",
                [Remedy::AutomaticWavelengths, Remedy::GaussianCoherence],
            )),
            _ => Ok(()),
        }
    }

    /// Returns these settings of a picture on the device with all that does not go together replaced: a finite grating
    /// has one window and the wavelengths of its orders, the mean over all windows has no terms, and the method follows
    /// from the windows.
    pub fn settled(&self) -> Self {
        let is_grating = self.coherence.sigma().is_none();
        let windows = if is_grating { Windows::ONE } else { self.windows };
        Self {
            method: Method::of_pictures(windows),
            windows,
            terms: self.terms.filter(|_| windows != Windows::All),
            wavelengths: self.wavelengths.filter(|_| !is_grating),
            ..self.clone()
        }
    }

    /// Returns these settings with the windows and the accuracy of `other`.
    pub fn as_accurate_as(&self, other: &Self) -> Self {
        let Self { windows, basis, tolerance, terms, wavelengths, .. } = *other;
        Self { windows, basis, tolerance, terms, wavelengths, ..self.clone() }
    }

    /// Returns these settings for the colours of a picture, by the method of pictures on the device.
    pub fn for_pictures(self) -> Self {
        Self { method: Method::of_pictures(self.windows), purpose: Purpose::Picture, ..self }
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
        ErrorBudget::new(self.tolerance, Question { purpose: self.purpose, is_grating, has_long_footprints })
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

impl Default for Optics {
    fn default() -> Self {
        Self {
            method: Method::default(),
            coherence: Coherence::SUNLIGHT,
            windows: Windows::All,
            beyond: Beyond::Copies,
            reflectance: Reflectance::default(),
            illuminant: Illuminant::D65,
            tolerance: 1e-2,
            purpose: Purpose::Directions,
            basis: Basis::default(),
            terms: None,
            wavelengths: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_that_do_not_go_together_are_refused_and_settled() {
        let grating = Coherence::Repeats([3, 7]);
        let one = Optics { windows: Windows::ONE, ..Optics::default() };
        let refused = [
            Optics { coherence: grating, ..Optics::default() },
            Optics { coherence: grating, wavelengths: Some(9), ..one.clone() },
            Optics { purpose: Purpose::Picture, ..Optics::default() },
            Optics { method: Method::Table, ..one.clone() },
            Optics { method: Method::Table, tolerance: 1e-4, ..Optics::default() },
            Optics { terms: Some(9), ..Optics::default() },
        ];
        for optics in refused {
            let error = optics.check().unwrap_err();
            assert!(
                error.kind() == crate::error::ErrorKind::Usage && !error.remedies().is_empty(),
                "{optics:?}: {error}"
            );
            let settled = Optics { tolerance: 1e-2, ..optics }.settled();
            assert_eq!(settled.clone().checked().unwrap(), settled);
        }
        let kept = Optics { terms: Some(9), wavelengths: Some(12), ..one.for_pictures() };
        assert_eq!(kept.settled(), kept);
        let settled = Optics { coherence: grating, wavelengths: Some(9), ..Optics::default() }.settled();
        assert_eq!(
            (settled.method, settled.windows, settled.wavelengths),
            (Method::Spectral, Windows::ONE, None)
        );
    }
}
