//! Surfaces: made, read, prepared, measured, saved.

use crate::error::{Error, Result};
use crate::figure::{Axis, ColorMap, ColorScale, Raster};
use crate::notes;
use crate::optics::coherence::Beyond;
use crate::surface::files::ReadSettings;
use crate::surface::files::topography::Topography;
use crate::surface::files::write::{self, ScanFormat};
use crate::surface::prepare::{self, PreparationStep};
use crate::surface::statistics::Statistics;
use crate::surface::statistics::plot_grid::PlotGrid;
use crate::surface::synth::{self, Spec, SurfaceKind};
use crate::surface::{HeightField, SurfaceSource};
use crate::task::Task;
use std::path::Path;

/// Measures of a height field, as `surface info` prints them. The heights are taken as they are: prepare the field first.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfaceMeasures {
    /// Mean height \[µm\].
    pub mean: f64,
    /// Standard deviation of the heights about their mean, ISO 25178-2 Sq \[µm\].
    pub rms: f64,
    /// RMS slope along x and y.
    pub rms_slopes: [f64; 2],
    /// Periods that stand out of the power spectrum, strongest first \[µm\].
    pub periods: Vec<f64>,
    /// Upper bound of the instrument's noise: the RMS height of white noise as strong as the spectrum at its highest frequencies \[µm\].
    pub noise: f64,
}

impl HeightField {
    /// Makes the surface that `settings` describe.
    ///
    /// # Errors
    /// Fails for lengths that are not positive, for too few or too many samples a period, and for a period or a height of the flat surface.
    pub fn generate(settings: &Spec) -> Result<Self> {
        synth::generate(settings)
    }

    /// Reads the file `path`, or makes the built-in surface of that name, as the command line does. Use [`Self::read`] to see progress and cancel.
    ///
    /// # Errors
    /// See [`Self::read`] and [`Self::generate`].
    pub fn open(name: impl AsRef<Path>) -> Result<Self> {
        SurfaceSource::named(name.as_ref().as_os_str()).load(&Task::silent())
    }

    /// Returns the field after the preparation `steps`, in the words of scene files, such as `level plane` or `crop 40um`.
    ///
    /// # Errors
    /// Fails for words that are no step, and for a step that cannot be done; the message names it. Also fails if the task is cancelled.
    pub fn prepare(&self, steps: &[&str], task: &Task) -> Result<Self> {
        let steps: Vec<_> = steps.iter().map(|step| PreparationStep::parse(step)).collect::<Result<_>>()?;
        prepare::apply_all(self.clone(), &steps, task)
    }

    /// Writes the field to `path`, whole or not at all, in the format of its extension: .gsf, .gwy, .npy, .tif, .txt or .x3p.
    ///
    /// # Errors
    /// Fails for another extension, heights that the format cannot hold, and a place that cannot be written to.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        write::write(path, ScanFormat::of(path)?, &Topography::of(self.clone()), notes::software().to_owned())
    }

    /// Returns the continuation beyond the patch that suits the field: copies if they join without visible steps, else a surface that is alike.
    pub fn continuation(&self) -> Beyond {
        Beyond::suited_to(self)
    }

    /// Returns a picture of the heights in false colour as the bytes of a PNG, averaged down until no side is longer than `most` pixels.
    ///
    /// # Errors
    /// Fails for a picture of no pixels.
    pub fn preview(&self, most: usize) -> Result<Vec<u8>> {
        if most == 0 {
            return Err(Error::usage("a picture of no pixels shows nothing", "give 1 or more along a side"));
        }
        let grid = PlotGrid::of_heights(self, most);
        let [low, high] = grid.core();
        let scale = ColorScale { axis: Axis::linear("", low, high), map: ColorMap::Viridis };
        Raster::values(grid.size[0], &grid.values, scale).png_bytes()
    }

    /// Measures the field.
    ///
    /// # Errors
    /// Fails if there is too little memory for the spectrum, or if the task is cancelled.
    pub fn measure(&self, task: &Task) -> Result<SurfaceMeasures> {
        let Statistics { heights, slopes, periods, noise, .. } = Statistics::of(self, task)?;
        Ok(SurfaceMeasures {
            mean: heights.mean,
            rms: heights.sq,
            rms_slopes: slopes.rms,
            periods: periods.iter().map(|period| period.length).collect(),
            noise,
        })
    }
}

impl<'a> ReadSettings<'a> {
    /// Returns settings that take everything from the file.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the settings with the distances between samples along x and y \[µm\], instead of the file's.
    #[must_use]
    pub fn with_pixel_size(self, pixel_size: [f64; 2]) -> Self {
        Self { pixel_size: Some(pixel_size), ..self }
    }

    /// Returns the settings with the height of the largest code of an image, or the range of other heights \[µm\].
    #[must_use]
    pub fn with_height(self, height: f64) -> Self {
        Self { height: Some(height), ..self }
    }

    /// Returns the settings with the channel of this name, or of this number from 1.
    #[must_use]
    pub fn with_channel(self, channel: &'a str) -> Self {
        Self { channel: Some(channel), ..self }
    }
}

impl Spec {
    /// Returns the default surface of `kind`.
    pub fn new(kind: SurfaceKind) -> Self {
        Self {
            kind,
            seed: 0,
            patch: None,
            pixel_size: None,
            period: None,
            height: None,
            duty: None,
            flank: None,
        }
    }

    /// Returns the settings with the seed of a random surface.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Returns the settings with these sides of the patch \[µm\], rounded to whole periods.
    #[must_use]
    pub fn with_patch(self, patch: [f64; 2]) -> Self {
        Self { patch: Some(patch), ..self }
    }

    /// Returns the settings with this largest distance between samples \[µm\].
    #[must_use]
    pub fn with_pixel_size(self, pixel_size: [f64; 2]) -> Self {
        Self { pixel_size: Some(pixel_size), ..self }
    }

    /// Returns the settings with this period or mean distance along x \[µm\].
    #[must_use]
    pub fn with_period(self, period: f64) -> Self {
        Self { period: Some(period), ..self }
    }

    /// Returns the settings with this full height \[µm\].
    #[must_use]
    pub fn with_height(self, height: f64) -> Self {
        Self { height: Some(height), ..self }
    }

    /// Returns the settings of a lamellar grating with ridges of this share of the period, at half of their height, and flanks of this width \[µm\].
    #[must_use]
    pub fn with_ridges(self, duty: f64, flank: f64) -> Self {
        Self { duty: Some(duty), flank: Some(flank), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_is_made_prepared_measured_saved_and_read() {
        let settings =
            Spec::new(SurfaceKind::Sinusoid).with_patch([8.0, 8.0]).with_period(2.0).with_height(0.3);
        let made = HeightField::generate(&settings).unwrap();
        let measures = made.measure(&Task::silent()).unwrap();
        assert!((measures.rms - 0.15 / 2f64.sqrt()).abs() < 1e-4, "{measures:?}");
        assert!((measures.periods[0] - 2.0).abs() < 1e-2, "{measures:?}");
        let mould = made.prepare(&["invert", "level mean"], &Task::silent()).unwrap();
        assert!(mould.heights().iter().zip(made.heights()).all(|(a, b)| (a + b).abs() < 1e-12));
        assert!(made.prepare(&["inverse"], &Task::silent()).is_err());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        made.save(&path).unwrap();
        let settings = ReadSettings::new().with_pixel_size(made.pixel_size());
        let read = HeightField::read(&path, &settings, &Task::silent()).unwrap();
        assert!(read.heights().iter().zip(made.heights()).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(made.save(folder.path().join("a.jpg")).is_err());
        let ridges = Spec::new(SurfaceKind::Lamellar).with_ridges(0.3, 0.0).with_height(0.1);
        let ridges = HeightField::generate(&ridges).unwrap();
        let mean = ridges.heights().iter().sum::<f64>() / ridges.heights().len() as f64;
        assert!((mean - 0.03).abs() < 1e-9, "{mean}");
        assert_eq!(HeightField::open("blaze").unwrap().patch_size(), [20.0; 2]);
        assert_eq!(made.continuation(), Beyond::Copies);
        let half_period = HeightField::from_fn(9, 9, [0.1; 2], |x, _| x).unwrap();
        assert_eq!(half_period.continuation(), Beyond::Alike);
        let picture = image::load_from_memory(&made.preview(20).unwrap()).unwrap();
        assert!(picture.width() <= 20 && picture.width() > 9, "{picture:?}");
        assert!(made.preview(0).is_err());
    }
}
