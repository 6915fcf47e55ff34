//! The response over wavelengths and view angles in the plane of the light, through one window, several, or in the mean.

use super::branches::ResponseMap;
use super::peaks::Sought;
use crate::error::Result;
use crate::memory;
use crate::optics::coherence::Windows;
use crate::optics::geometry::{Pair, direction};
use crate::settings::{Method, Optics};
use crate::surface::HeightField;
use std::f64::consts::PI;

/// Directions of a sweep: a light and view angles in one plane, and wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPlane {
    /// Angle of the light \[degrees\], positive toward the axis.
    pub theta_i: f64,
    /// Azimuth of the axis \[degrees\].
    pub azimuth: f64,
    /// Wavelengths \[µm\], growing.
    pub wavelengths: Vec<f64>,
    /// View angles \[degrees\], growing.
    pub angles: Vec<f64>,
}

impl SweepPlane {
    /// Returns the pair of directions of each view angle.
    pub fn pairs(&self) -> Vec<Pair> {
        let light = direction(self.theta_i, self.azimuth);
        self.angles.iter().map(|&angle| Pair::new(light, direction(angle, self.azimuth))).collect()
    }

    /// Returns the number of responses of a sweep.
    pub fn evaluations(&self) -> usize {
        self.wavelengths.len() * self.angles.len()
    }
}

/// Answers the responses of a plane, window by window, if the settings have several, and wavelength by wavelength.
pub type Answer<'a> = dyn FnMut(&SweepPlane, &Optics, &HeightField) -> Result<Vec<f64>> + 'a;

/// Returns the number of independent windows on `field`; `None` for a finite grating.
///
/// Intensities through Gaussian windows at a distance d correlate by exp(−d²/(2σ²)), whose integral is the area of one independent window.
pub fn independent_windows(optics: &Optics, field: &HeightField) -> Option<f64> {
    let sigma = optics.coherence.sigma()?;
    let [width, height] = field.patch_size();
    Some(width * height / (2.0 * PI * sigma * sigma))
}

/// Returns the number of windows along each side of the patch for the spread of the mean over all: about as many as are independent. `None` for
/// fewer than two, and for the f64 reference, whose single windows take minutes.
pub fn windows_of_spread(optics: &Optics, field: &HeightField) -> Option<u32> {
    const MOST: f64 = 4.0;
    let independent = independent_windows(optics, field)?;
    let is_quick = optics.method != Method::Reference;
    (is_quick && independent >= 2.0).then(|| independent.sqrt().ceil().clamp(2.0, MOST) as u32)
}

/// Response at every wavelength and angle.
#[derive(Clone, Debug, PartialEq)]
pub struct AngleSweep {
    /// Wavelengths \[µm\], growing.
    pub wavelengths: Vec<f64>,
    /// View angles \[degrees\], growing.
    pub angles: Vec<f64>,
    /// The BRDF \[sr⁻¹\], wavelength by wavelength.
    pub responses: Vec<f64>,
}

impl AngleSweep {
    /// Returns the sweep in `plane` that `answer` answers, of one window or of the mean.
    ///
    /// # Errors
    /// Fails if there is too little memory, or with the error of `answer`.
    pub fn through(
        plane: &SweepPlane,
        optics: &Optics,
        field: &HeightField,
        answer: &mut Answer<'_>,
    ) -> Result<Self> {
        // This sweep and the mean.
        memory::ensure_room(plane.evaluations() as u64 * 2 * size_of::<f64>() as u64, "the sweep")?;
        let responses = answer(plane, optics, field)?;
        let SweepPlane { wavelengths, angles, .. } = plane.clone();
        Ok(Self { wavelengths, angles, responses })
    }

    /// Returns the sweep through each of n × m windows, for which `answer` answers one by one.
    ///
    /// # Errors
    /// Those of [`Self::through`].
    pub fn of_windows(
        plane: &SweepPlane,
        optics: &Optics,
        field: &HeightField,
        counts: [u32; 2],
        answer: &mut Answer<'_>,
    ) -> Result<Vec<Self>> {
        // The answer, every window's sweep and the mean.
        let sweeps = 2 * u64::from(counts[0]) * u64::from(counts[1]) + 1;
        let evaluations = plane.evaluations();
        memory::ensure_room(
            sweeps * evaluations as u64 * size_of::<f64>() as u64,
            "the sweeps of all windows",
        )?;
        let optics = Optics { windows: Windows::Grid(counts), ..optics.clone() };
        let responses = answer(plane, &optics, field)?;
        let SweepPlane { wavelengths, angles, .. } = plane;
        let sweep = |responses: &[f64]| Self {
            wavelengths: wavelengths.clone(),
            angles: angles.clone(),
            responses: responses.to_vec(),
        };
        Ok(responses.chunks(evaluations).map(sweep).collect())
    }

    /// Returns the mean of `sweeps` of the same wavelengths and angles, at least one.
    pub fn mean(sweeps: &[Self]) -> Self {
        let mut mean = sweeps[0].clone();
        for sweep in &sweeps[1..] {
            mean.responses.iter_mut().zip(&sweep.responses).for_each(|(sum, f)| *sum += f);
        }
        mean.responses.iter_mut().for_each(|f| *f /= sweeps.len() as f64);
        mean
    }

    /// Returns this mean of `count` ≥ 2 sweeps without the sweep `one`.
    pub fn without(&self, one: &Self, count: usize) -> Self {
        let mut rest = self.clone();
        let count = count as f64;
        // Rounding leaves no response below 0.
        let left = |mean: f64, f: f64| ((mean * count - f) / (count - 1.0)).max(0.0);
        rest.responses.iter_mut().zip(&one.responses).for_each(|(mean, f)| *mean = left(*mean, *f));
        rest
    }

    /// Returns the responses as a map in which the peaks of `sought` are searched.
    pub fn map(&self, sought: Sought) -> ResponseMap<'_> {
        let Self { wavelengths, angles, responses } = self;
        ResponseMap { wavelengths, angles, responses, sought }
    }
}
