//! Pictures of a scene: the data shared by all views is prepared once, then each view is drawn.

use super::{InUse, SourceSettings, averages_footprints, pigment_alone, source};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::optics::coherence::Beyond;
use crate::render::exposure;
use crate::render::footprints;
use crate::render::frame::{Shown, View};
use crate::render::object::{ObjectSource, ObjectSources, ObjectTextures, objects};
use crate::render::renderer::{Picture, Renderer, RendererSettings};
use crate::render::sampling::Sampling;
use crate::render::source::Source;
use crate::scene::{Light, Mesh, Object, Scene};
use crate::settings::{Method, Optics};
use crate::spectra::power::OrderSeries;
use crate::surface::{HeightField, SurfaceSource};
use crate::task::Task;
use crate::vk::device::Device;
use std::slice;
use std::sync::Arc;

/// Settings of a picture, in addition to the scene and its surface.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PictureSettings {
    /// Width and height \[pixels\].
    #[doc(hidden)]
    pub size: [u32; 2],
    /// Samples of each pixel.
    #[doc(hidden)]
    pub sampling: Sampling,
    /// Settings of the first object's source, with a method that runs on the device.
    #[doc(hidden)]
    pub source: SourceSettings,
}

/// Returns the scene's view under `optics`.
pub fn own_view(scene: &Scene, optics: &Optics) -> View {
    View::under(scene, &scene.lights, &optics.coherence)
}

/// Surface of an object and settings of its source.
#[derive(Clone, Debug)]
pub struct ObjectSurface {
    /// Height field; `None` for an object that does not diffract and shows its pigment alone.
    pub field: Option<Arc<HeightField>>,
    /// Settings of its source.
    pub source: SourceSettings,
}

impl ObjectSurface {
    /// Returns the surfaces of all objects of `scene`, the first of which has this `field` and these `settings`. The
    /// others differ in their height fields, which `load` reads, and in their reflectances.
    ///
    /// # Errors
    /// Fails with the error of `load`.
    pub fn of(
        scene: &Scene,
        field: &Arc<HeightField>,
        settings: &SourceSettings,
        load: &mut dyn FnMut(&SurfaceSource) -> Result<Arc<HeightField>>,
    ) -> Result<Vec<Self>> {
        let first = Self { field: Some(field.clone()), source: settings.clone() };
        let other = |(number, object): (usize, &Object)| {
            Self::of_object(object, settings, load).map_err(|e| e.at(format!("object {number}")))
        };
        let others = scene.objects.iter().enumerate().skip(1).map(other).collect::<Result<Vec<_>>>()?;
        first.check_heights()?;
        Ok(std::iter::once(first).chain(others).collect())
    }

    /// Returns the surface of an `object` after the first, with the `settings` of the first except for the parts that
    /// depend on the object.
    fn of_object(
        object: &Object,
        settings: &SourceSettings,
        load: &mut dyn FnMut(&SurfaceSource) -> Result<Arc<HeightField>>,
    ) -> Result<Self> {
        let field = object.surface.as_ref().map(load).transpose()?;
        let mut source = settings.clone();
        source.optics.beyond = field.as_ref().map_or(Beyond::Copies, |field| Beyond::suited_to(field));
        let first = &source.optics.reflectance;
        let reflectance = object.reflectance.clone().unwrap_or_default().polarised(first.polarisation());
        source.optics.reflectance = reflectance.by(first.stated_theory());
        let prepared = Self { field, source };
        prepared.check_heights()?;
        Ok(prepared)
    }

    /// Fails early for heights that no table supports.
    fn check_heights(&self) -> Result<()> {
        match (&self.field, self.source.optics.method) {
            (Some(field), Method::Table) => {
                self.source.optics.check()?;
                OrderSeries::check_heights(field, &self.source.power_settings()?)
            }
            _ => Ok(()),
        }
    }

    /// Returns this surface with settings for the footprint sizes of `mesh` in `views`, of `size` pixels, if the source
    /// averages over footprints.
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
        let mut prepared = self.clone();
        if self.field.is_some() && averages_footprints(&self.source) {
            prepared.source.footprints = footprints::sizes(device, mesh, views, size, sampling)?;
        }
        Ok(prepared)
    }

    /// Returns the sources of the object in `views`: those that `make` returns under the scene's illuminant, and under
    /// each other illuminant of a light.
    ///
    /// # Errors
    /// Fails with the error of `make`.
    pub fn sources(
        &self,
        views: &[View],
        make: &mut dyn FnMut(&Self) -> Result<Source>,
    ) -> Result<ObjectSources> {
        let mut sources = ObjectSources::new(make(self)?, self.source.optics.clone());
        for illuminant in views.iter().flat_map(|view| view.lights.iter()).filter_map(Light::illuminant) {
            if sources.all().all(|known| known.optics.illuminant != *illuminant) {
                let mut under = self.clone();
                under.source.optics.illuminant = illuminant.clone();
                sources.under.push(ObjectSource { source: make(&under)?, optics: under.source.optics });
            }
        }
        Ok(sources)
    }
}

/// Scene on a device, ready to be drawn from several views; meshes, pigments and sources are shared.
pub struct PreparedScene {
    settings: PictureSettings,
    shown: Shown,
    source: Source,
    renderer: Renderer,
}

impl PreparedScene {
    /// Prepares the data that pictures of `scene` share; its objects have these `surfaces`. `make` makes the source of
    /// each from settings with footprint sizes for all of `views`.
    ///
    /// # Errors
    /// Fails if a picture cannot be read, if the device is lost or out of memory, or with the error of `make`.
    pub fn new(
        device: &Arc<Device>,
        (scene, surfaces): (&Scene, &[ObjectSurface]),
        settings: &PictureSettings,
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
        let shadows = RendererSettings { shadows: scene.shadows, ..RendererSettings::default() };
        let renderer = Renderer::new(device, &objects, size, shadows)?;
        let source = sources.swap_remove(0).first.source;
        Ok(Self { settings: settings.clone(), shown: Shown::of(scene), source, renderer })
    }

    /// Checks that a picture of `view` is within the limits of the source.
    ///
    /// # Errors
    /// Fails with the numbers and a remedy, or if the device is lost.
    pub fn check(&mut self, view: &View) -> Result<()> {
        let optics = &self.settings.source.optics;
        if !self.source.has_limits(optics) {
            return Ok(());
        }
        let lights = 0..view.light_count();
        let seen = lights.map(|light| self.renderer.directions(view, light)).collect::<Result<Vec<_>>>()?;
        self.source.check(optics, &seen)
    }

    /// Draws `view`, which must pass [`Self::check`].
    ///
    /// # Errors
    /// Fails if the device is lost or out of memory, or if the task is cancelled.
    pub fn draw(&mut self, view: &View, task: &Task) -> Result<Picture> {
        self.renderer.render(view, &self.settings.sampling, self.shown, task)
    }

    /// Sets the display settings of the following pictures, in place of the scene's.
    pub fn show(&mut self, shown: Shown) {
        self.shown = shown;
    }

    /// Returns the exposure \[stops\] that [`exposure::automatic`] gives one sample of `view`; `None` if nothing in it
    /// is lit.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn meter(&mut self, view: &View) -> Result<Option<f64>> {
        self.renderer.draw_sample(view, &Sampling::ONE.sample(0), self.shown)?;
        Ok(exposure::automatic(&self.renderer.read_back()?.radiance))
    }

    /// Returns by how much the theory of the first object was limited, in words, as [`EnergyMap::note`](crate::brdf::energy_map::EnergyMap::note).
    pub fn energy_note(&self) -> Option<String> {
        self.source.energy()?.note()
    }

    /// Returns the renderer.
    pub fn renderer(&mut self) -> &mut Renderer {
        &mut self.renderer
    }
}

/// Draws `scene` with the surface `field` on the device of `context`, whose cache keeps what is computed.
///
/// # Errors
/// Same as [`source`]; also fails if a pigment texture cannot be read, if there is no device, if it is lost or out of memory, or if the task is cancelled.
pub fn picture(
    scene: &Scene,
    field: &HeightField,
    settings: &PictureSettings,
    context: &Context,
    task: &Task,
) -> Result<Picture> {
    let view = own_view(scene, &settings.source.optics);
    let field = Arc::new(field.clone());
    let surfaces = ObjectSurface::of(scene, &field, &settings.source, &mut |s| s.load(task).map(Arc::new))?;
    let device = context.device()?;
    let mut in_use = InUse::new(context);
    let make = |surface: &ObjectSurface| match &surface.field {
        Some(field) => {
            let made = source(field, &surface.source, device.candidate(), &mut in_use, task)?;
            made.note.iter().for_each(|note| context.tell(note));
            Ok(made.source)
        }
        None => Ok(pigment_alone()),
    };
    let mut prepared =
        PreparedScene::new(&device, (scene, &surfaces), settings, slice::from_ref(&view), make)?;
    prepared.check(&view)?;
    let picture = prepared.draw(&view, task)?;
    context.keep_pipelines(&device);
    Ok(picture)
}
