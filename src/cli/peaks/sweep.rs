//! The response over wavelengths and view angles, and the peaks in it.

use super::Arguments;
use crate::cli::console::Console;
use crate::cli::progress::ProgressBar;
use crate::cli::{evaluation, prepare};
use crate::error::Result;
use crate::measure::branches::ResponseMap;
use crate::measure::peaks::Sought;
use crate::memory;
use crate::optics::coherence::Windows;
use crate::optics::geometry::{Pair, direction};
use crate::settings::{Method, Optics};
use crate::setup::SourceSettings;
use crate::surface::HeightField;
use crate::task::DIRECTIONS;
use std::f64::consts::PI;

/// Returns the number of independent windows on `field`; `None` for a finite grating.
///
/// Intensities through Gaussian windows at a distance d correlate by exp(−d²/(2σ²)), whose integral is the area of one independent window.
pub fn independent_windows(optics: &Optics, field: &HeightField) -> Option<f64> {
    let sigma = optics.coherence.sigma()?;
    let [width, height] = field.patch_size();
    Some(width * height / (2.0 * PI * sigma * sigma))
}

/// Response at every wavelength and angle.
#[derive(Clone, Debug)]
pub struct AngleSweep {
    /// Wavelengths \[µm\], growing.
    pub wavelengths: Vec<f64>,
    /// View angles \[degrees\], growing.
    pub angles: Vec<f64>,
    /// The BRDF \[sr⁻¹\], wavelength by wavelength.
    pub responses: Vec<f64>,
}

impl AngleSweep {
    /// Returns the sweep averaged over the windows of `arguments`, and the sweeps of single windows from which its spread follows: of the
    /// same windows, or of some windows for the mean over all.
    pub fn of(
        arguments: &Arguments,
        optics: &Optics,
        field: &HeightField,
        console: &Console,
    ) -> Result<(Self, Vec<Self>)> {
        match optics.windows {
            Windows::ONE => Ok((Self::through(arguments, optics, field, console)?, Vec::new())),
            Windows::Grid(counts) => {
                let windows = Self::of_windows(arguments, optics, field, counts, console)?;
                Ok((Self::mean(&windows), windows))
            }
            Windows::All => {
                let mean = Self::through(arguments, optics, field, console)?;
                let counts = Self::windows_of_spread(optics, field);
                let windows = counts.map_or(Ok(Vec::new()), |n| {
                    Self::of_windows(arguments, optics, field, [n; 2], console)
                })?;
                Ok((mean, windows))
            }
        }
    }

    /// Returns the number of windows along each side of the patch for the spread of the mean over all: about as many as are independent.
    /// `None` for fewer than two, and for the f64 reference, whose single windows take minutes.
    fn windows_of_spread(optics: &Optics, field: &HeightField) -> Option<u32> {
        const MOST: f64 = 4.0;
        let independent = independent_windows(optics, field)?;
        let is_quick = optics.method != Method::Reference;
        (is_quick && independent >= 2.0).then(|| independent.sqrt().ceil().clamp(2.0, MOST) as u32)
    }

    /// Returns the sweep of each of n × m windows.
    fn of_windows(
        arguments: &Arguments,
        optics: &Optics,
        field: &HeightField,
        [n, m]: [u32; 2],
        console: &Console,
    ) -> Result<Vec<Self>> {
        // Every window's sweep and the mean.
        let sweeps = u64::from(n) * u64::from(m) + 1;
        let evaluations = arguments.wavelengths.count() as u64 * arguments.angles.count() as u64;
        memory::ensure_room(sweeps * evaluations * size_of::<f64>() as u64, "the sweeps of all windows")?;
        let one = Optics { windows: Windows::ONE, ..optics.clone() };
        let mut windows = Vec::new();
        let bar = ProgressBar::hidden(console, "windows", "a smaller number of --windows", (n * m) as usize);
        bar.add(0);
        for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
            // A window elsewhere on the periodic surface is this window on the moved surface. The surface moves by whole samples, which are
            // far smaller than a window.
            let samples = |part: u32, of: u32, all: usize| {
                (f64::from(part) / f64::from(of) * all as f64).round() as usize
            };
            let moved = field.moved(samples(i, n, field.columns()), samples(j, m, field.rows()));
            windows.push(Self::through(arguments, &one, &moved, console)?);
            bar.add(1);
        }
        Ok(windows)
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

    fn through(
        arguments: &Arguments,
        optics: &Optics,
        field: &HeightField,
        console: &Console,
    ) -> Result<Self> {
        let wavelengths: Vec<f64> = arguments.wavelengths.values().iter().map(|nm| nm / 1e3).collect();
        let angles = arguments.angles.values();
        let evaluations = wavelengths.len() * angles.len();
        // This sweep and the mean.
        memory::ensure_room(evaluations as u64 * 2 * size_of::<f64>() as u64, "the sweep")?;
        let azimuth = arguments.axis.azimuth();
        let light = direction(arguments.theta_i, azimuth);
        let pairs: Vec<Pair> = angles.iter().map(|&a| Pair::new(light, direction(a, azimuth))).collect();
        let mut responses = Vec::with_capacity(evaluations);
        let settings = SourceSettings { shortest: wavelengths[0], ..SourceSettings::new(optics.clone()) };
        prepare::for_each_window(console, field, &settings, |brdf, _| {
            let bar = ProgressBar::over(console, DIRECTIONS, "a range with larger steps", evaluations);
            for &wavelength in &wavelengths {
                let found = evaluation::ask(brdf, &pairs, Some(wavelength), &bar)?;
                responses.extend(found.iter().map(|f| f.x));
            }
            Ok(())
        })?;
        Ok(Self { wavelengths, angles, responses })
    }

    /// Returns the responses as a map in which the peaks of `sought` are searched.
    pub fn map(&self, sought: Sought) -> ResponseMap<'_> {
        let Self { wavelengths, angles, responses } = self;
        ResponseMap { wavelengths, angles, responses, sought }
    }
}
