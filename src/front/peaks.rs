//! Peaks of the diffracted light in the plane of the light, and the period of a grating from them.

use super::windows;
use crate::context::Context;
use crate::error::{Error, ErrorKind, Result};
use crate::front::SurfaceBrdf;
use crate::measure::order_peaks::{FollowedBranch, OrderPeaks, spread_over_windows};
use crate::measure::peaks::{PeriodStatistics, Sought, WindowSpread};
use crate::measure::sweep::{AngleSweep, SweepPlane, independent_windows, windows_of_spread};
use crate::optics::coherence::Windows;
use crate::settings::Optics;
use crate::surface::HeightField;
use crate::task::{DIRECTIONS, Task};

/// Largest number of evaluations of a search.
const MAX_EVALUATIONS: usize = 50_000_000;
/// Largest order.
const MAX_ORDER: u32 = 1000;
/// Largest angle of the light \[degrees\]: grazing light reflects nothing.
const MOST_GRAZING: f64 = 89.99;
/// Fewest angles that can have a maximum inside.
const FEWEST_ANGLES: usize = 3;

/// Light, directions and order of the peaks that [`HeightField::peaks`] finds.
#[derive(Clone, Debug, PartialEq)]
pub struct PeakSettings {
    plane: SweepPlane,
    order: u32,
    period: Option<f64>,
    over_windows: bool,
}

/// Largest response of a wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct AngularPeak {
    /// Wavelength \[µm\].
    pub wavelength: f64,
    /// View angle \[degrees\]; `None` if nothing is reflected.
    pub angle: Option<f64>,
    /// Period by the grating equation \[µm\]; `None` also in the mirror direction, which fits every period.
    pub period: Option<f64>,
    /// Largest BRDF \[1/sr\].
    pub response: f64,
    /// True if the maximum lies inside the range of angles.
    pub is_clear: bool,
    /// Number of the branch of maxima, from 0, on which the largest response lies; `None` where there is one branch only.
    pub branch: Option<usize>,
}

/// Period of a grating with its uncertainty \[µm\].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeasuredPeriod {
    /// Mean over the wavelengths; `None` if none has a period.
    pub mean: Option<f64>,
    /// Standard deviation over the wavelengths; `None` below two.
    pub deviation: Option<f64>,
    /// Standard error over windows of the surface; `None` if it holds fewer than two that are independent, 0 if the peaks
    /// of all of them lie at the same angles.
    pub error: Option<f64>,
    /// Half the width of the 95 % confidence interval; `None` if the error is 0 or fewer than four windows are independent.
    pub half_interval: Option<f64>,
    /// Number of wavelengths with this period.
    pub wavelengths: usize,
}

/// Peaks of a surface, and its period.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfacePeaks {
    /// Peak of each wavelength.
    pub peaks: Vec<AngularPeak>,
    /// Period over all wavelengths, or of the strongest branch if there are several.
    pub period: MeasuredPeriod,
    /// Periods of the branches between which the largest response changes, the strongest first; empty if it does not change.
    pub branches: Vec<MeasuredPeriod>,
}

impl PeakSettings {
    /// Returns settings for light at `theta_i` from the normal toward +x \[degrees\], growing view `angles` toward +x \[degrees\], all visible wavelengths in steps of
    /// 1 nm, and the first order.
    pub fn new(theta_i: f64, angles: Vec<f64>) -> Self {
        let wavelengths = (380..=780).map(|nm| f64::from(nm) / 1e3).collect();
        let plane = SweepPlane { theta_i, azimuth: 0.0, wavelengths, angles };
        Self { plane, order: 1, period: None, over_windows: true }
    }

    /// Returns the settings with these growing wavelengths \[µm\].
    #[must_use]
    pub fn with_wavelengths(mut self, wavelengths: Vec<f64>) -> Self {
        self.plane.wavelengths = wavelengths;
        self
    }

    /// Returns the settings in the plane of this azimuth from +x toward +y \[degrees\] instead of that of +x.
    #[must_use]
    pub fn with_azimuth(mut self, azimuth: f64) -> Self {
        self.plane.azimuth = azimuth;
        self
    }

    /// Returns the settings of this order; with a `period` \[µm\] that is about expected, peaks are sought within half an order of its grating equation.
    #[must_use]
    pub fn with_order(self, order: u32, period: Option<f64>) -> Self {
        Self { order, period, ..self }
    }

    /// Returns the settings with or without the standard error over windows of the surface, which takes a Vulkan device.
    #[must_use]
    pub fn with_error_over_windows(self, over_windows: bool) -> Self {
        Self { over_windows, ..self }
    }

    /// Fails for settings out of range.
    fn check(&self) -> Result<()> {
        let refused = |what: &str, remedy: &str| Err(Error::usage(what.to_owned(), remedy.to_owned()));
        let SweepPlane { theta_i, azimuth, wavelengths, angles } = &self.plane;
        let grows = |values: &[f64]| values.windows(2).all(|pair| pair[0] < pair[1]);
        if !(theta_i.abs() <= MOST_GRAZING && azimuth.is_finite()) {
            return refused("the angle of the light is out of range", "give -89.99 to 89.99 degrees");
        }
        if angles.len() < FEWEST_ANGLES
            || !grows(angles)
            || angles.iter().any(|a| a.is_nan() || a.abs() > 90.0)
        {
            return refused(
                "the view angles do not grow",
                "give three or more from -90 to 90 degrees, each once",
            );
        }
        if wavelengths.is_empty() || !grows(wavelengths) {
            return refused("the wavelengths do not grow", "give one or more, each once");
        }
        if !(1..=MAX_ORDER).contains(&self.order)
            || self.period.is_some_and(|period| period.is_nan() || period <= 0.0)
        {
            return refused(
                "there is no such order",
                "give an order of 1 to 1000, and a period above zero or none",
            );
        }
        if self.plane.evaluations() > MAX_EVALUATIONS {
            return refused(
                "these are more evaluations than are made at once",
                "give fewer angles or wavelengths",
            );
        }
        Ok(())
    }
}

impl HeightField {
    /// Finds the direction of the brightest light of each wavelength, and the period that follows by the grating equation, under `optics`. Where there is no device for the
    /// standard error over windows, it is left out, and `context` receives a note.
    ///
    /// # Errors
    /// Fails for settings out of range or that do not go together, if there is too little memory, or if the task is cancelled.
    pub fn peaks(
        &self,
        optics: &Optics,
        settings: &PeakSettings,
        context: &Context,
        task: &Task,
    ) -> Result<SurfacePeaks> {
        settings.check()?;
        let PeakSettings { plane, order, period, .. } = settings;
        let sweep = AngleSweep::through(plane, optics, self, &mut |plane, optics, field| {
            responses(plane, optics, field, task)
        })?;
        let sought = Sought { theta_i: plane.theta_i, order: *order, period: *period };
        let mut found = [OrderPeaks::new(sought, &sweep)];
        found[0].find_branches(&sweep, &[]);
        if settings.over_windows {
            let alone = windows_alone(self, optics, plane, context, task)?;
            spread_over_windows(independent_windows(optics, self), &alone, &mut found);
        }
        let [found] = found;
        Ok(SurfacePeaks::from(&found))
    }
}

/// Returns the responses of the mean or of the direct sum, wavelength by wavelength.
fn responses(plane: &SweepPlane, optics: &Optics, field: &HeightField, task: &Task) -> Result<Vec<f64>> {
    let brdf = SurfaceBrdf::with_shortest(field, optics, plane.wavelengths[0], task)?;
    let pairs: Vec<_> =
        plane.pairs().iter().map(|pair| [pair.light.to_array(), pair.view.to_array()]).collect();
    let mut responses = Vec::with_capacity(plane.evaluations());
    for (number, wavelength) in plane.wavelengths.iter().enumerate() {
        task.report(DIRECTIONS, number, plane.wavelengths.len())?;
        responses.extend(brdf.spectral(&pairs, *wavelength, task)?);
    }
    Ok(responses)
}

/// Returns the sweeps of single windows from which the spread of the mean follows; none if there are too few, or no device, which `context` is told.
fn windows_alone(
    field: &HeightField,
    optics: &Optics,
    plane: &SweepPlane,
    context: &Context,
    task: &Task,
) -> Result<Vec<AngleSweep>> {
    let counts = windows_of_spread(optics, field).filter(|_| optics.windows == Windows::All);
    let Some(count) = counts else { return Ok(Vec::new()) };
    let sweeps = AngleSweep::of_windows(plane, optics, field, [count; 2], &mut |plane, optics, field| {
        windows::responses(plane, optics, field, context, task)
    });
    match sweeps {
        Err(error) if error.kind() == ErrorKind::Device => {
            context.tell(&error.at("the standard error over windows is left out"));
            Ok(Vec::new())
        }
        sweeps => sweeps,
    }
}

impl From<&OrderPeaks> for SurfacePeaks {
    fn from(found: &OrderPeaks) -> Self {
        let peak = |(place, peak): (usize, &crate::measure::peaks::Peak)| AngularPeak {
            wavelength: peak.wavelength,
            angle: peak.angle,
            period: peak.period,
            response: peak.response,
            is_clear: peak.clear,
            branch: found.branch_at(place).map(|number| number - 1),
        };
        let (statistics, spread) = found.strongest();
        let branch = |of: &FollowedBranch| MeasuredPeriod::new(&of.branch.statistics, of.spread.as_ref());
        Self {
            peaks: found.peaks.iter().enumerate().map(peak).collect(),
            period: MeasuredPeriod::new(statistics, spread),
            branches: found.branches.iter().map(branch).collect(),
        }
    }
}

impl MeasuredPeriod {
    fn new(statistics: &PeriodStatistics, spread: Option<&WindowSpread>) -> Self {
        Self {
            mean: statistics.mean,
            deviation: statistics.deviation,
            error: spread.map(|spread| spread.error),
            half_interval: spread.and_then(|spread| spread.half_interval),
            wavelengths: statistics.count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::synth::{Spec, SurfaceKind};

    fn settings() -> PeakSettings {
        let angles = (380..=570).map(|tenths| f64::from(tenths) / 10.0).collect();
        PeakSettings::new(-75.0, angles).with_wavelengths(vec![0.5, 0.55, 0.6])
    }

    #[test]
    fn the_period_of_a_blaze_follows_from_its_peaks() {
        let field = HeightField::generate(&Spec::new(SurfaceKind::Blaze)).unwrap();
        let optics = Optics::new();
        let found = field
            .peaks(&optics, &settings().with_error_over_windows(false), &Context::default(), &Task::silent())
            .unwrap();
        assert!((found.period.mean.unwrap() - 2.5).abs() < 5e-3, "{found:?}");
        assert!(found.peaks.iter().all(|peak| peak.is_clear && peak.branch.is_none()));
        assert_eq!((found.period.error, found.period.wavelengths, found.branches.len()), (None, 3, 0));
    }

    #[test]
    fn settings_out_of_range_are_refused() {
        let refused = [
            PeakSettings::new(90.0, vec![0.0, 1.0, 2.0]),
            PeakSettings::new(30.0, vec![0.0, 1.0]),
            PeakSettings::new(30.0, vec![2.0, 1.0, 0.0]),
            PeakSettings::new(30.0, vec![0.0, 1.0, f64::NAN]),
            settings().with_wavelengths(Vec::new()),
            settings().with_order(0, None),
            settings().with_order(1, Some(-1.0)),
            settings().with_azimuth(f64::NAN),
        ];
        assert!(refused.iter().all(|settings| settings.check().is_err()));
        settings().check().unwrap();
    }
}
