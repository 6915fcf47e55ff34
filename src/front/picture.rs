//! Pictures of a scene.

use crate::context::Context;
use crate::error::{Error, Result};
use crate::measure::error::PixelErrors;
use crate::picture_file;
use crate::render::renderer::Picture;
use crate::render::sampling::Sampling;
use crate::scene::Scene;
use crate::settings::Optics;
use crate::setup::{self, PictureSettings};
use crate::surface::HeightField;
use crate::task::Task;
use glam::DVec3;
use image::{Rgba, Rgba32FImage};
use std::path::Path;

impl PictureSettings {
    /// Returns settings for a picture of `size` pixels with 16 samples each, as drawn by `diffract render`: in sunlight, by a colour table.
    pub fn new(size: [u32; 2]) -> Self {
        let source = setup::SourceSettings::new(Optics::default().for_pictures());
        Self { size, sampling: Sampling { count: 16, seed: 1 }, source }
    }

    /// Returns the settings with so many samples of each pixel.
    #[must_use]
    pub fn with_samples(mut self, count: u32) -> Self {
        self.sampling.count = count.max(1);
        self
    }

    /// Returns the settings with these optics, by the method that pictures have.
    #[must_use]
    pub fn with_optics(mut self, optics: &Optics) -> Self {
        self.source.optics = optics.clone().for_pictures();
        self
    }
}

/// Draws `scene` with the surface `field` on its first object, on the device of `context`, whose cache keeps what is computed.
///
/// # Errors
/// Fails for settings that do not go together, without a device that suits, if it is lost or out of memory, if a texture cannot be read, or if the task is cancelled.
pub fn draw(
    scene: &Scene,
    field: &HeightField,
    settings: &PictureSettings,
    context: &Context,
    task: &Task,
) -> Result<Picture> {
    context.run(|| setup::picture(scene, field, settings, context, task))
}

impl Picture {
    /// Writes the picture to `path`, whole or not at all: .png as displayed, .exr linear radiance.
    ///
    /// # Errors
    /// Fails for another extension, and for a place that cannot be written to.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        picture_file::save(path, self)
    }
}

/// Difference of a picture from a more exact one of the same scene.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PictureDifference {
    /// Number of compared pixels: those that the exact picture covers.
    pub pixels: usize,
    /// ‖picture − exact‖/‖exact‖ over all of them, in linear sRGB.
    pub relative_l2: f64,
    /// Half of the 95 % interval of that number, where the pixels are a random part of the picture.
    pub relative_l2_interval: f64,
}

impl PictureDifference {
    /// Compares the EXR file `picture` with the EXR file `exact`.
    ///
    /// # Errors
    /// Fails for files that cannot be read as pictures, and for pictures of different sizes.
    pub fn from_files(picture: impl AsRef<Path>, exact: impl AsRef<Path>) -> Result<Self> {
        let [picture, exact] = [read(picture.as_ref())?, read(exact.as_ref())?];
        if picture.dimensions() != exact.dimensions() {
            return Err(Error::input("the pictures differ in size", "draw both in the same size"));
        }
        let colour = |pixel: &Rgba<f32>| DVec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into());
        // Alpha is how much of a pixel the mesh covers.
        let covered = picture.pixels().zip(exact.pixels()).filter(|(_, exact)| exact[3] > 0.0);
        let (picture, exact): (Vec<_>, Vec<_>) = covered.map(|(a, b)| (colour(a), colour(b))).unzip();
        let PixelErrors { pixels, relative_l2, relative_l2_interval, .. } =
            PixelErrors::of(&picture, &exact, 0.0);
        Ok(Self { pixels, relative_l2, relative_l2_interval })
    }
}

fn read(path: &Path) -> Result<Rgba32FImage> {
    let opened = image::open(path).map_err(|e| {
        let what = format!("{}: this is no picture that can be read ({e})", path.display());
        Error::input(what, "name an EXR file that this program has drawn").caused_by(e)
    })?;
    Ok(opened.into_rgba32f())
}
