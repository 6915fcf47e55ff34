//! Statistics of a height field: the parameters of ISO 25178-2, periods, noise, and defects of the data.
//!
//! Nothing is levelled or filtered first: prepare the field, then measure it. Only spectra are taken of the heights less their plane, under
//! a Hann window.

mod bands;
mod harmonics;
pub mod height_spectrum;
mod heights;
mod joining;
mod line_periods;
mod notes;
pub mod periods;
pub mod plot_grid;
mod profile_form;
mod relief;
pub mod slopes;
mod texture;

pub use heights::{HeightParameters, deviation, mean};
pub use joining::{joining, with_periods};
pub use line_periods::line_periods;
pub use notes::notes;
pub(in crate::internals::surface) use periods::wave_vector;
pub use periods::{Period, PeriodMethod, dominant_periods};
pub use profile_form::ProfileKind;
pub use relief::{ProfileShape, Relief};
pub use slopes::Slopes;
pub use texture::Texture;

use super::HeightField;
use super::si::{metres, metres_of_both, metres_of_some, per_metre_of_both};
use super::tiling::Tiling;
use crate::error::Result;
use crate::task::{STATISTICS, Task};
use height_spectrum::SurfaceSpectrum;
use serde::Serialize;

/// Statistics of `surface info`. Serialised, lengths are metres and angles degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Side lengths of the patch \[µm\].
    #[serde(rename = "patch_m", serialize_with = "metres_of_both")]
    pub patch: [f64; 2],
    /// The largest spatial frequency along `x` and `y` that the sampling holds, 1/(2 dx) \[1/µm\].
    #[serde(rename = "largest_frequency_per_m", serialize_with = "per_metre_of_both")]
    pub largest_frequency: [f64; 2],
    /// The height distribution.
    pub heights: HeightParameters,
    /// The slope distribution.
    pub slopes: Slopes,
    /// Autocorrelation length and direction.
    pub texture: Texture,
    /// The periods that stand out of the power spectrum, strongest first.
    pub periods: Vec<Period>,
    /// Length after which the heights repeat along `x` and `y` \[µm\]; `None` if nothing clearly repeats.
    #[serde(rename = "line_periods_m", serialize_with = "metres_of_some")]
    pub line_periods: [Option<f64>; 2],
    /// RMS height of white noise that is as strong as the spectrum at the highest frequencies \[µm\]: an upper bound of the
    /// instrument's noise.
    #[serde(rename = "noise_m", serialize_with = "metres")]
    pub noise: f64,
    /// Share of the height variance above half of the largest frequency. Structure there is finer than four samples, and what is finer than
    /// two is missing or folded back.
    pub undersampled_share: f64,
    /// Seams between copies of the field, in steps and in periods.
    pub tiling: Tiling,
}

impl Statistics {
    /// Measures `field`.
    ///
    /// # Errors
    /// Too little memory for the spectrum; a task that is cancelled.
    pub fn of(field: &HeightField, task: &Task) -> Result<Self> {
        const PARTS: usize = 6;
        let are_done = |parts| task.report(STATISTICS, parts, PARTS);
        are_done(0)?;
        let [dx, dy] = field.pixel_size();
        let part = height_spectrum::analysed_part(field);
        let power = SurfaceSpectrum::windowed(&part)?;
        are_done(1)?;
        let (heights, slopes) = (HeightParameters::of(field), Slopes::of(field));
        are_done(2)?;
        let texture = Texture::of(&part, &power)?;
        are_done(3)?;
        let periods = dominant_periods(&part, &power)?;
        are_done(4)?;
        let line_periods = line_periods(field);
        are_done(5)?;
        let tiling = joining(field)?;
        are_done(PARTS)?;
        Ok(Self {
            patch: field.patch_size(),
            largest_frequency: [0.5 / dx, 0.5 / dy],
            heights,
            slopes,
            texture,
            periods,
            line_periods,
            noise: power.noise(),
            undersampled_share: power.undersampled_share(),
            tiling,
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::surface::prepare::{PreparationStep, apply_all};
    use std::f64::consts::TAU;
    use std::sync::atomic::Ordering;

    /// Returns a field of 100 nm × 50 nm samples; `x` and `y` from the left and the TOP edge.
    pub(crate) fn field(columns: usize, rows: usize, h: impl Fn(f64, f64) -> f64) -> HeightField {
        let pixel = [0.1, 0.05];
        let at = |i: usize| h((i % columns) as f64 * pixel[0], (i / columns) as f64 * pixel[1]);
        HeightField::new(columns, rows, pixel, (0..columns * rows).map(at).collect()).unwrap()
    }

    #[test]
    fn a_sinusoid_has_its_closed_form_numbers() {
        let s = Statistics::of(&field(200, 40, |x, _| 3.0 + 0.2 * (TAU * x / 2.0).sin()), &Task::silent())
            .unwrap();
        assert!((s.patch[0] - 20.0).abs() < 1e-12 && (s.patch[1] - 2.0).abs() < 1e-12);
        assert!(
            (s.largest_frequency[0] - 5.0).abs() < 1e-12 && (s.largest_frequency[1] - 10.0).abs() < 1e-12
        );
        assert!((s.line_periods[0].unwrap() - 2.0).abs() < 1e-9, "{:?}", s.line_periods);
        assert_eq!(s.line_periods[1], None);
        assert!((s.periods[0].length - 2.0).abs() < 1e-3, "{:?}", s.periods);
        assert!(s.noise < 1e-9 && s.undersampled_share < 1e-9, "{s:?}");
    }

    #[test]
    fn serialised_lengths_are_metres_and_everything_is_a_number() {
        let s = Statistics::of(&field(64, 64, |x, y| (TAU * x).sin() + 0.01 * y), &Task::silent()).unwrap();
        let json = serde_json::to_value(&s).unwrap();
        let number = |path: &str| json.pointer(path).and_then(serde_json::Value::as_f64).unwrap();
        assert!((number("/patch_m/0") - 6.4e-6).abs() < 1e-18);
        assert!((number("/heights/sq_m") - s.heights.sq * 1e-6).abs() < 1e-18);
        assert!((number("/periods/0/length_m") - 1e-6).abs() < 1e-9);
        assert!((number("/largest_frequency_per_m/0") - 5e6).abs() < 1.0);
    }

    #[test]
    fn the_smallest_fields_have_statistics_too() {
        for (columns, rows) in [(1, 1), (1, 40), (40, 1), (2, 2), (3, 5)] {
            let json = serde_json::to_string(
                &Statistics::of(&field(columns, rows, |x, y| x * y + x), &Task::silent()).unwrap(),
            );
            assert!(json.unwrap().contains("\"sq_m\":"), "{columns} x {rows}");
        }
        let flat = Statistics::of(&field(64, 64, |_, _| 0.3), &Task::silent()).unwrap();
        assert!(flat.periods.is_empty() && flat.noise < 1e-12 && flat.heights.sq < 1e-12, "{flat:?}");
    }

    #[test]
    fn work_on_a_surface_is_cancelled_at_each_of_its_reports() {
        let waves = field(64, 64, |x, y| (TAU * x).sin() + 0.01 * y);
        let steps = ["level plane", "invert"].map(|step| PreparationStep::parse(step).unwrap());
        let all = |task: &Task| {
            let prepared = apply_all(waves.clone(), &steps, task)?;
            Statistics::of(&prepared, task).map(drop)
        };
        let reports = 2 + 7;
        for last in 1..=reports {
            let (task, reported) = Task::cancelled_at(last);
            assert!(all(&task).unwrap_err().is_cancelled(), "{last}");
            assert_eq!(reported.load(Ordering::Relaxed), last);
        }
        assert!(all(&Task::cancelled_at(reports + 1).0).is_ok());
    }
}
