//! The response over wavelengths and view angles, and the peaks in it.

use super::{Arguments, MANY_SUMS};
use crate::cli::{evaluation, prepare, say};
use crate::error::Result;
use crate::measure::peaks::Peak;
use crate::memory;
use crate::optics::coherence::Windows;
use crate::optics::geometry::{Pair, direction};
use crate::setup::{Method, Settings};
use crate::surface::HeightField;

/// The response at every wavelength and angle.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Wavelengths \[µm\], growing.
    pub wavelengths: Vec<f64>,
    /// View angles \[degrees\], growing.
    pub angles: Vec<f64>,
    /// The BRDF \[sr⁻¹\], wavelength by wavelength.
    pub responses: Vec<f64>,
}

impl Sweep {
    /// Averaged over the windows that `arguments` ask for, of the `field`, and the sweep of each window alone, where several are asked for.
    pub fn of(arguments: &Arguments, field: &HeightField) -> Result<(Self, Vec<Self>)> {
        let [n, m] = match arguments.optics.windows() {
            all_or_one @ (Windows::All | Windows::ONE) => {
                return Ok((Self::through(arguments, field, all_or_one)?, Vec::new()));
            }
            Windows::Grid(counts) => counts,
        };
        // Every window's sweep and the mean.
        let sweeps = u64::from(n) * u64::from(m) + 1;
        let evaluations = arguments.wavelengths.count() as u64 * arguments.angles.count() as u64;
        memory::ensure_room(sweeps * evaluations * size_of::<f64>() as u64, "the sweeps of all windows")?;
        let mut windows = Vec::new();
        for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
            // A window elsewhere on the endless surface is this window on the surface moved: by whole samples, which are
            // far smaller than a window.
            let samples = |part: u32, of: u32, all: usize| {
                (f64::from(part) / f64::from(of) * all as f64).round() as usize
            };
            let moved = field.moved(samples(i, n, field.columns()), samples(j, m, field.rows()));
            windows.push(Self::through(arguments, &moved, Windows::ONE)?);
        }
        Ok((Self::mean(&windows), windows))
    }

    /// The mean of `sweeps` of the same wavelengths and angles, one at least.
    fn mean(sweeps: &[Self]) -> Self {
        let mut mean = sweeps[0].clone();
        for sweep in &sweeps[1..] {
            mean.responses.iter_mut().zip(&sweep.responses).for_each(|(sum, f)| *sum += f);
        }
        mean.responses.iter_mut().for_each(|f| *f /= sweeps.len() as f64);
        mean
    }

    /// What is left of this mean of `count` ≥ 2 sweeps without `one` of them.
    pub fn without(&self, one: &Self, count: usize) -> Self {
        let mut rest = self.clone();
        let count = count as f64;
        // Rounding leaves no response below 0.
        let left = |mean: f64, f: f64| ((mean * count - f) / (count - 1.0)).max(0.0);
        rest.responses.iter_mut().zip(&one.responses).for_each(|(mean, f)| *mean = left(*mean, *f));
        rest
    }

    fn through(arguments: &Arguments, field: &HeightField, windows: Windows) -> Result<Self> {
        let optics = &arguments.optics;
        let mut shading = optics.monochrome(field);
        shading.windows = windows;
        let wavelengths: Vec<f64> = arguments.wavelengths.values().iter().map(|nm| nm / 1e3).collect();
        let angles = arguments.angles.values();
        let evaluations = wavelengths.len() * angles.len();
        // This sweep and the mean.
        memory::ensure_room(evaluations as u64 * 2 * size_of::<f64>() as u64, "the sweep")?;
        if optics.method() == Method::Reference && windows != Windows::All && evaluations > MANY_SUMS {
            say(&format_args!("{evaluations} direct sums take their time; --method spectral is faster"));
        }
        let azimuth = arguments.axis.azimuth();
        let light = direction(arguments.theta_i, azimuth);
        let pairs: Vec<Pair> = angles.iter().map(|&a| Pair::new(light, direction(a, azimuth))).collect();
        let mut responses = Vec::with_capacity(evaluations);
        let method = optics.method();
        let settings = Settings { shortest: wavelengths[0], ..Settings::new(method, shading) };
        prepare::for_each_window(field, &settings, &arguments.device.wish(), |brdf, _| {
            let bar = evaluation::bar(evaluations);
            for &wavelength in &wavelengths {
                let found = evaluation::ask(brdf, &pairs, Some(wavelength), &bar)?;
                responses.extend(found.iter().map(|f| f.x));
            }
            bar.finish_and_clear();
            Ok(())
        })?;
        Ok(Self { wavelengths, angles, responses })
    }

    /// The peak of each wavelength for `order`: in all the range, or, with a `period` \[µm\], within half an order.
    pub fn peaks(&self, theta_i: f64, order: u32, period: Option<f64>) -> Vec<Peak> {
        let sweeps = self.wavelengths.iter().zip(self.responses.chunks(self.angles.len()));
        let peak = |(&wavelength, responses): (&f64, &[f64])| match period {
            None => Peak::find(wavelength, theta_i, order, &self.angles, responses),
            Some(d) => Peak::find_near(wavelength, theta_i, order, &self.angles, responses, d),
        };
        sweeps.map(peak).collect()
    }
}
