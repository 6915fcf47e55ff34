//! Sources and pipelines of all objects, and the lights that each of them shades.

use crate::error::Result;
use crate::optics::color;
use crate::optics::spectrum::Illuminant;
use crate::render::frame::View;
use crate::render::gbuffer::GBufferSettings;
use crate::render::light_passes::LightPass;
use crate::render::object::{DeviceObject, ObjectSource};
use crate::render::passes::light_run::LightRun;
use crate::render::passes::shade::{ShadePass, ShadedObject};
use crate::render::source::BoundSource;
use crate::scene::Light;
use crate::vk::device::Device;
use glam::Vec3;
use std::sync::Arc;

/// Source and pass of an object under the lights of one illuminant.
pub(super) struct ObjectShading {
    /// Number of the object.
    pub object: usize,
    /// True for the default shading of the object, used for lights without a separate illuminant.
    pub is_first: bool,
    illuminant: Illuminant,
    // White of the illuminant, linear sRGB.
    white: Vec3,
    pub source: BoundSource,
    pass: ShadePass,
    /// Variance of (u, v) of the specular order, if surroundings are read in the mirrored direction.
    pub specular_spread: Option<f32>,
}

/// Returns the colour of a white diffuse surface under `illuminant`, linear sRGB.
fn white_of(illuminant: &Illuminant) -> Vec3 {
    color::xyz_to_linear_srgb(illuminant.white()).as_vec3()
}

/// Shadings of all objects, one or more for each.
pub(super) struct Shadings {
    /// In the order of the objects; at least one.
    all: Vec<ObjectShading>,
    /// True if the lights cast shadows.
    shadows: bool,
}

impl Shadings {
    /// Makes shadings without objects.
    pub fn new(shadows: bool) -> Self {
        Self { all: Vec::new(), shadows }
    }

    /// Adds the shadings of the next object, number `object`, from `sources`. They mirror a specular order of the
    /// variance `spread`, if it is given, instead of that of the source.
    pub fn add<'a>(
        &mut self,
        object: usize,
        sources: impl IntoIterator<Item = (BoundSource, &'a Illuminant)>,
        spread: Option<f64>,
    ) {
        let entry = sources.into_iter().enumerate().map(|(place, (source, illuminant))| ObjectShading {
            object,
            is_first: place == 0,
            illuminant: illuminant.clone(),
            white: white_of(illuminant),
            pass: ShadePass::default(),
            specular_spread: spread.map(|spread| spread as f32).or(source.specular_spread),
            source,
        });
        self.all.extend(entry);
    }

    /// Returns the default source of the first object.
    pub fn first_source(&self) -> &BoundSource {
        &self.all[0].source
    }

    /// Iterates over the default shading of each object.
    pub fn defaults(&self) -> impl Iterator<Item = &ObjectShading> {
        self.all.iter().filter(|entry| entry.is_first)
    }

    /// Takes the data that depends on the index, the illuminant or the number of copies from `sources`.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn rebind<'a>(
        &mut self,
        device: &Arc<Device>,
        sources: impl Iterator<Item = &'a ObjectSource>,
    ) -> Result<()> {
        for (entry, ObjectSource { source, optics }) in self.all.iter_mut().zip(sources) {
            source.rebind(device, &mut entry.source, optics)?;
            if entry.illuminant != optics.illuminant {
                entry.illuminant.clone_from(&optics.illuminant);
                entry.white = white_of(&optics.illuminant);
            }
        }
        Ok(())
    }

    /// Returns `passes`, or passes of one light each if sums over wavelengths make a light long to draw.
    pub fn bounded(&self, passes: Vec<LightPass>) -> Vec<LightPass> {
        if self.all.iter().all(|entry| entry.source.parts(false) == 1) {
            return passes;
        }
        passes.into_iter().flat_map(LightPass::each_light).collect()
    }

    /// Returns the number of parts of a pixel's sum in `pass` of `view`.
    pub fn parts(&self, view: &View, pass: &LightPass) -> u32 {
        let mirrors = self.mirrors(view, pass);
        self.all.iter().map(|entry| entry.source.parts(mirrors)).max().unwrap_or(1)
    }

    /// Returns the largest number of loop iterations of a pixel in `pass` of `view`.
    pub fn iterations(&self, view: &View, pass: &LightPass) -> usize {
        let mirrors = self.mirrors(view, pass);
        let lights = pass.choices.map_or(pass.lights, |choices| choices.taken as usize);
        let of = |entry: &ObjectShading| entry.source.iterations_of_pixel(mirrors) * lights;
        self.all.iter().map(of).max().unwrap_or(0)
    }

    /// Returns true if the specular order of surroundings is reflected separately.
    pub fn mirrors_surroundings(&self) -> bool {
        self.all.iter().any(|entry| entry.specular_spread.is_some())
    }

    /// Returns true if `pass` of `view` mirrors surroundings.
    fn mirrors(&self, view: &View, pass: &LightPass) -> bool {
        pass.numbers().any(|light| self.run_of(view, light, pass).mirrored)
    }

    /// Returns the run of light number `light` of a `pass` of `view` alone.
    pub fn run_of(&self, view: &View, light: usize, pass: &LightPass) -> LightRun {
        LightRun {
            first: pass.place_of(light) as u32,
            lights: pass.choices.map_or(1, |choices| choices.taken),
            mirrored: view.is_surroundings(light) && self.mirrors_surroundings(),
            lamp: view.lights.get(light).is_some_and(Light::is_lamp),
            shadows: self.shadows,
            chosen: pass.choices.is_some(),
        }
    }

    /// Makes the pipelines for the lights of `pass`, unless they are there already.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn prepare(
        &mut self,
        device: &Arc<Device>,
        objects: &[DeviceObject],
        settings: GBufferSettings,
        (view, pass): (&View, &LightPass),
    ) -> Result<()> {
        let runs: Vec<_> = self.all.iter().map(|entry| self.runs(view, pass, entry)).collect();
        for (entry, runs) in self.all.iter_mut().zip(runs) {
            let frame = &objects[entry.object].frame.descriptors;
            for lights in runs {
                entry.pass.prepare(device, lights, frame, &entry.source, settings)?;
            }
        }
        Ok(())
    }

    /// Returns the draw calls of a `pass` of `view` on `objects`.
    pub fn draws<'a>(
        &'a self,
        objects: &'a [DeviceObject],
        view: &View,
        pass: &LightPass,
    ) -> Vec<ShadedObject<'a>> {
        let first = pass.place_of(pass.light) as u32;
        let mut draws = Vec::new();
        for entry in &self.all {
            draws.extend(self.runs(view, pass, entry).into_iter().map(|run| ShadedObject {
                number: entry.object,
                object: &objects[entry.object],
                source: &entry.source,
                pass: &entry.pass,
                lights: run,
                white: entry.white,
                counts: pass.is_first && run.first == first,
            }));
        }
        draws
    }

    /// Returns the lights of `pass` of `view` that `entry` shades, as runs of consecutive lights of one kind.
    fn runs(&self, view: &View, pass: &LightPass, entry: &ObjectShading) -> Vec<LightRun> {
        let mut runs: Vec<LightRun> = Vec::new();
        for light in pass.numbers() {
            if !self.shades(entry, view.illuminant(light)) {
                continue;
            }
            let alone = self.run_of(view, light, pass);
            match runs.last_mut() {
                Some(run) if run.is_continued_by(alone) => run.lights += 1,
                _ => runs.push(alone),
            }
        }
        runs
    }

    /// Returns true if `entry` shades its object under a light of this `illuminant`: it has the same illuminant, or it is
    /// the object's default and no shading of the object matches.
    fn shades(&self, entry: &ObjectShading, illuminant: Option<&Illuminant>) -> bool {
        let mut of_object = self.all.iter().filter(|other| other.object == entry.object);
        match illuminant {
            Some(illuminant) if of_object.any(|other| other.illuminant == *illuminant) => {
                *illuminant == entry.illuminant
            }
            _ => entry.is_first,
        }
    }
}
