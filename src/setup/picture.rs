//! Pictures of a scene: what all of its views share is prepared once, then each is drawn.

use super::{InUse, Method, Settings, averages_footprints, beyond_of, pigment_alone, source};
use crate::error::{Error, Result};
use crate::optics::coherence::Beyond;
use crate::render::exposure;
use crate::render::footprints;
use crate::render::frame::{Shown, View};
use crate::render::object::{ObjectSource, ObjectSources, ObjectTextures, objects};
use crate::render::picture::{Painter, Picture};
use crate::render::sampling::Sampling;
use crate::render::shading::Shading;
use crate::render::source::Source;
use crate::scene::{Light, Mesh, Object, Scene};
use crate::spectra::power::OrderSeries;
use crate::surface::{HeightField, SurfaceSource};
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

/// The surface of an object and how it is computed.
#[derive(Clone, Debug)]
pub struct ObjectSurface {
    /// The height field; `None`: nothing is diffracted, and the pigment is seen alone.
    pub field: Option<Arc<HeightField>>,
    /// The optics.
    pub optics: Settings,
}

impl ObjectSurface {
    /// Those of all objects of `scene`, the first of which has this `field` and these `optics`. The others differ by their own height fields, which
    /// `load` reads, and by what they reflect.
    ///
    /// # Errors
    /// What `load` returns.
    pub fn of(
        scene: &Scene,
        field: &Arc<HeightField>,
        optics: &Settings,
        load: &mut dyn FnMut(&SurfaceSource) -> Result<Arc<HeightField>>,
    ) -> Result<Vec<Self>> {
        let first = Self { field: Some(field.clone()), optics: optics.clone() };
        let other = |(number, object): (usize, &Object)| {
            Self::of_object(object, optics, load).map_err(|e| e.at(format!("object {}", number + 1)))
        };
        let others = scene.objects.iter().enumerate().map(other).collect::<Result<Vec<_>>>()?;
        first.check_heights()?;
        Ok(std::iter::once(first).chain(others).collect())
    }

    /// That of an `object` beside the first, in the `optics` of the first but for what follows from the object.
    fn of_object(
        object: &Object,
        optics: &Settings,
        load: &mut dyn FnMut(&SurfaceSource) -> Result<Arc<HeightField>>,
    ) -> Result<Self> {
        let field = object.surface.as_ref().map(load).transpose()?;
        let mut optics = optics.clone();
        optics.shading.beyond = field.as_ref().map_or(Beyond::Copies, |field| beyond_of(field));
        optics.shading.reflectance = object.reflectance.clone().unwrap_or_default();
        let own = Self { field, optics };
        own.check_heights()?;
        Ok(own)
    }

    /// Fails at once for heights of which no table can be made.
    fn check_heights(&self) -> Result<()> {
        match (&self.field, self.optics.method) {
            (Some(field), Method::Table) => {
                super::check(&self.optics)?;
                OrderSeries::check_heights(field, &self.optics.power_settings()?)
            }
            _ => Ok(()),
        }
    }

    /// The same with optics for footprints as large as those of `mesh` in `views`, of `size` pixels, where the source averages over them.
    ///
    /// # Errors
    /// Fails if the device is lost or out of memory.
    pub fn seen(
        &self,
        device: &Arc<Device>,
        mesh: &Mesh,
        views: &[View],
        size: [u32; 2],
        sampling: &Sampling,
    ) -> Result<Self> {
        let mut own = self.clone();
        if self.field.is_some() && averages_footprints(&self.optics) {
            own.optics.footprints = footprints::sizes(device, mesh, views, size, sampling)?;
        }
        Ok(own)
    }

    /// What the object is shaded from in `views`: from what `make` returns under the scene's illuminant, and under each other that lights have of
    /// their own.
    ///
    /// # Errors
    /// What `make` returns.
    pub fn sources(
        &self,
        views: &[View],
        make: &mut dyn FnMut(&Self) -> Result<Source>,
    ) -> Result<ObjectSources> {
        let mut sources = ObjectSources::new(make(self)?, self.optics.shading.clone());
        for illuminant in views.iter().flat_map(|view| view.lights.iter()).filter_map(Light::illuminant) {
            if sources.all().all(|known| known.shading.illuminant != *illuminant) {
                let mut under = self.clone();
                under.optics.shading.illuminant = illuminant.clone();
                sources.under.push(ObjectSource { source: make(&under)?, shading: under.optics.shading });
            }
        }
        Ok(sources)
    }
}

/// A scene on a device, ready to be drawn from several views: meshes, pigments and sources are there once.
pub struct PreparedScene<'a> {
    settings: &'a PictureSettings,
    shown: Shown,
    source: Source,
    painter: Painter,
}

impl<'a> PreparedScene<'a> {
    /// Everything that pictures of `scene` share, whose objects have these `surfaces`. The source of each comes from `make`, which gets the optics with
    /// sizes of footprints that suit all of `views`.
    ///
    /// # Errors
    /// A picture that cannot be read; where the device is lost or out of memory; what `make` returns.
    pub fn new(
        device: &Arc<Device>,
        (scene, surfaces): (&'a Scene, &[ObjectSurface]),
        settings: &'a PictureSettings,
        views: &[View],
        mut make: impl FnMut(&ObjectSurface) -> Result<Source>,
    ) -> Result<Self> {
        let textures = ObjectTextures::of(scene)?;
        let PictureSettings { size, sampling, .. } = *settings;
        let mut sources = Vec::with_capacity(surfaces.len());
        for (number, (mesh, surface)) in scene.meshes().zip(surfaces).enumerate() {
            let seen = surface.seen(device, mesh, views, size, &sampling)?;
            let named = |e: Error| if number > 0 { e.at(format!("object {number}")) } else { e };
            sources.push(seen.sources(views, &mut make).map_err(named)?);
        }
        let objects = objects(scene, &textures, &sources);
        let mut painter = Painter::of_objects(device, &objects, size)?;
        if scene.shadows {
            painter.cast_shadows()?;
        }
        let source = sources.swap_remove(0).own.source;
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
        let lights = 0..view.light_count();
        let seen = lights.map(|light| self.painter.directions(view, light)).collect::<Result<Vec<_>>>()?;
        self.source.check(shading, &seen)
    }

    /// Draws `view`, which [`Self::check`] found good. Tells `progress` after each sample how many are done; what it returns as an error ends
    /// the picture.
    ///
    /// # Errors
    /// Fails if the device is lost or out of memory, and what `progress` returns.
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
    /// Fails if the device is lost.
    pub fn meter(&mut self, view: &View) -> Result<Option<f64>> {
        self.painter.draw_sample(view, &Sampling::ONE.sample(0), self.shown)?;
        Ok(exposure::automatic(&self.painter.picture()?.radiance))
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
/// Same as [`source`]; a pigment texture that cannot be read; where the device is lost or out of memory.
pub fn picture(
    device: &Arc<Device>,
    scene: &Scene,
    field: &HeightField,
    settings: &PictureSettings,
) -> Result<Picture> {
    let view = own_view(scene, &settings.optics.shading);
    let field = Arc::new(field.clone());
    let surfaces = ObjectSurface::of(scene, &field, &settings.optics, &mut |s| s.load().map(Arc::new))?;
    let mut in_use = InUse::default();
    let make = |surface: &ObjectSurface| match &surface.field {
        Some(field) => {
            let made = source(field, &surface.optics, device.candidate(), &mut in_use, &|_, _, _| Ok(()))?;
            Ok(made.source)
        }
        None => Ok(pigment_alone()),
    };
    let mut prepared =
        PreparedScene::new(device, (scene, &surfaces), settings, slice::from_ref(&view), make)?;
    prepared.check(&view)?;
    prepared.draw(&view, &mut |_| Ok(()))
}
