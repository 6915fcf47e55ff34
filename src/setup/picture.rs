//! A picture of a scene in one call.

use super::{InUse, Method, Settings, averages_footprints, source};
use crate::error::Result;
use crate::render::footprints;
use crate::render::frame::{Shown, View};
use crate::render::picture::{Painter, Picture};
use crate::render::pigment::Pigment;
use crate::render::sampling::Sampling;
use crate::render::shading::Shading;
use crate::scene::Scene;
use crate::surface::HeightField;
use crate::vk::device::Device;
use std::sync::Arc;

/// What a picture follows from beside the scene and its surface.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureSettings {
    /// Width and height \[pixels\].
    pub size: [u32; 2],
    /// Samples that each pixel is the mean of.
    pub sampling: Sampling,
    /// The optics, by a method that works on the device.
    pub optics: Settings,
}

impl PictureSettings {
    /// A picture of `size` pixels, 16 samples each, as `diffract render` draws it: in sunlight, by a colour table.
    pub fn new(size: [u32; 2]) -> Self {
        Self {
            size,
            sampling: Sampling { count: 16, seed: 1 },
            optics: Settings::new(Method::Table, Shading::default().for_pictures()),
        }
    }
}

/// Draws `scene` with the surface `field` on `device`. What is computed for it is kept in the cache on disk, where
/// [`Settings::cached`] says so.
///
/// # Errors
/// As [`source`]; a pigment texture that cannot be read; where the device is lost or has no room.
pub fn picture(
    device: &Arc<Device>,
    scene: &Scene,
    field: &HeightField,
    settings: &PictureSettings,
) -> Result<Picture> {
    let pigment = scene.pigment.as_deref().map(Pigment::read).transpose()?;
    let view = View { pigment: pigment.is_some(), ..View::of(scene, scene.lights.clone()) };
    let pigment = pigment.unwrap_or_else(Pigment::white);
    let PictureSettings { size, sampling, .. } = *settings;
    let mut optics = settings.optics.clone();
    if averages_footprints(&optics) {
        optics.footprints = footprints::sizes(device, &scene.mesh, &view, size, &sampling.sample(0))?;
    }
    let made = source(field, &optics, device.candidate(), &mut InUse::default(), &|_, _, _| Ok(()))?;
    let (source, shading, lights) = (&made.source, &optics.shading, view.lights.len());
    let mut painter = Painter::new(device, source, shading, &scene.mesh, &pigment, size, lights)?;
    if source.has_limits(shading) {
        let centres = Sampling::ONE.sample(0);
        let seen = (0..lights).map(|light| painter.directions_of(&view, light, &centres));
        source.check(shading, &seen.collect::<Result<Vec<_>>>()?)?;
    }
    let shown = Shown { exposure: scene.exposure, background: scene.background };
    painter.paint_samples(&view, &sampling, shown, &mut |_| Ok(()))
}
