//! Pictures of a scene: what all of its views share is prepared once, then each is drawn.

use super::{InUse, Method, Settings, averages_footprints, source};
use crate::error::Result;
use crate::render::exposure;
use crate::render::footprints;
use crate::render::frame::{Shown, View};
use crate::render::picture::{Directions, Painter, Picture};
use crate::render::pigment::Pigment;
use crate::render::sampling::{Sample, Sampling};
use crate::render::shading::Shading;
use crate::render::source::Source;
use crate::scene::Scene;
use crate::surface::HeightField;
use crate::vk::device::Device;
use std::slice;
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

/// The scene's own view under `shading`, with its pigment texture where it has one.
pub fn own_view(scene: &Scene, shading: &Shading) -> View {
    View { pigment: scene.pigment.is_some(), ..View::under(scene, &scene.lights, &shading.coherence) }
}

/// A scene on a device, ready to be drawn from several views: mesh, pigment and source are there once.
pub struct PreparedScene<'a> {
    settings: &'a PictureSettings,
    shown: Shown,
    source: Source,
    painter: Painter,
}

impl<'a> PreparedScene<'a> {
    /// Everything that pictures of `scene` share. The source comes from `make`, which gets the optics of `settings` with sizes of footprints that
    /// suit all of `views`.
    ///
    /// # Errors
    /// A pigment texture that cannot be read; where the device is lost or has no room; what `make` returns.
    pub fn new(
        device: &Arc<Device>,
        scene: &'a Scene,
        settings: &'a PictureSettings,
        views: &[View],
        make: impl FnOnce(&Settings) -> Result<Source>,
    ) -> Result<Self> {
        let pigment = scene.pigment.as_deref().map(Pigment::read).transpose()?.unwrap_or_else(Pigment::white);
        let PictureSettings { size, sampling, .. } = *settings;
        let mut optics = settings.optics.clone();
        if averages_footprints(&optics) {
            optics.footprints = footprints::sizes(device, &scene.mesh, views, size, &sampling.sample(0))?;
        }
        let source = make(&optics)?;
        let lights = views.iter().map(|view| view.light_count()).max().unwrap_or(0);
        let shading = &settings.optics.shading;
        let mut painter = Painter::new(device, &source, shading, &scene.mesh, &pigment, size, lights)?;
        if scene.shadows {
            painter.cast_shadows()?;
        }
        Ok(Self { settings, shown: Shown::of(scene), source, painter })
    }

    /// Fails where a picture of `view` takes more than the source can do.
    ///
    /// # Errors
    /// With the numbers and what to do; where the device is lost.
    pub fn check(&mut self, view: &View) -> Result<()> {
        let shading = &self.settings.optics.shading;
        if !self.source.has_limits(shading) {
            return Ok(());
        }
        let seen = self.directions(view, &Sampling::ONE.sample(0))?;
        self.source.check(shading, &seen)
    }

    /// Draws `view`, which [`Self::check`] found good. Tells `progress` after each sample how many are done; what it returns as an error ends
    /// the picture.
    ///
    /// # Errors
    /// Where the device is lost or has no room, and what `progress` returns.
    pub fn draw(&mut self, view: &View, progress: &mut dyn FnMut(u32) -> Result<()>) -> Result<Picture> {
        self.painter.paint_samples(view, &self.settings.sampling, self.shown, progress)
    }

    /// Shows pictures as `shown` says from now on, instead of as the scene does.
    pub fn show(&mut self, shown: Shown) {
        self.shown = shown;
    }

    /// The exposure \[stops\] that [`exposure::automatic`] gives one sample of `view`; `None` where nothing in it is lit.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn meter(&mut self, view: &View) -> Result<Option<f64>> {
        self.painter.draw_sample(view, &Sampling::ONE.sample(0), self.shown)?;
        Ok(exposure::automatic(&self.painter.picture()?.radiance))
    }

    /// The directions that each light of `view` comes from in `sample`.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn directions(&mut self, view: &View, sample: &Sample) -> Result<Vec<Directions>> {
        (0..view.light_count()).map(|light| self.painter.directions_of(view, light, sample)).collect()
    }

    /// What draws.
    pub fn painter(&mut self) -> &mut Painter {
        &mut self.painter
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
    let view = own_view(scene, &settings.optics.shading);
    let make = |optics: &Settings| {
        let made = source(field, optics, device.candidate(), &mut InUse::default(), &|_, _, _| Ok(()))?;
        Ok(made.source)
    };
    let mut prepared = PreparedScene::new(device, scene, settings, slice::from_ref(&view), make)?;
    prepared.check(&view)?;
    prepared.draw(&view, &mut |_| Ok(()))
}
