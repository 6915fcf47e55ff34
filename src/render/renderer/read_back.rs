//! Read-back of the picture, and of the directions that its pixels see.

use super::{Content, LightDirections, Picture, Renderer};
use crate::error::{Error, Result};
use crate::render::directions::{Directions, Pixel};
use crate::render::frame::View;
use crate::render::light_passes::LightPass;
use crate::render::sampling::{Sample, Sampling};
use crate::render::target;
use crate::scene::Light;
use crate::vk::access::Access;
use crate::vk::commands::FAR;
use crate::vk::image::Image;
use glam::DVec3;

/// Pixels to read back.
#[derive(Clone, Copy, Debug)]
pub(super) enum PictureArea {
    /// All pixels.
    All,
    /// Pixel in this column and row.
    Pixel([u32; 2]),
}

impl Renderer {
    /// Reads back the last picture at the size of the target. An abandoned picture has no radiance and the former
    /// display.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn read_back(&self) -> Result<Picture> {
        let sum = self.accumulation.as_ref().zip(self.summed.as_ref());
        let radiance = match sum.filter(|_| self.shows == Content::Mean) {
            Some((accumulation, summed)) => {
                let mut sum = self.read(&accumulation.sum, PictureArea::All)?;
                let samples = summed.samples as f32;
                sum.iter_mut().flatten().for_each(|x| *x /= samples);
                sum
            }
            None if self.shows == Content::PictureArea => {
                let [width, height] = self.target.size();
                vec![[0.0; 4]; width as usize * height as usize]
            }
            None => self.read(&self.target.radiance, PictureArea::All)?,
        };
        let display = target::read_back(&self.device, &self.target.display, Access::ShaderRead)?;
        let view = match self.shows {
            Content::Sample => self.image_input.as_ref().map(|found| &found.view),
            Content::Mean => self.summed.as_ref().map(|summed| &summed.view),
            Content::Nothing | Content::PictureArea => None,
        };
        Ok(Picture {
            size: self.target.size(),
            radiance,
            display: bytemuck::pod_collect_to_vec(&display),
            is_opaque: view.is_some_and(|view| view.background().is_some()),
        })
    }

    /// Returns for each pixel of `view` the distance of what its centre shows from the viewer's plane, along the camera's axis \[units of
    /// the scene\]; infinity where that is no object.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn distances(&mut self, view: &View) -> Result<Vec<f32>> {
        // Geometry is drawn for a light, any of them.
        let lit = View { lights: vec![Light::point(0.0, 0.0, 1.0)], environment: None, ..view.clone() };
        self.draw_directions(&lit, &LightPass::of_all(0, Sampling::ONE.sample(0)))?;
        let distance = |depth: f32| match depth {
            FAR => f32::INFINITY,
            _ => view.camera.distance_along_axis(depth, view.centre, view.reach) as f32,
        };
        Ok(self.depth()?.into_iter().map(distance).collect())
    }

    /// Returns the directions of light number `light` in one sample of `view` at the pixel centres, exactly as shading
    /// reads them.
    ///
    /// # Errors
    /// Fails if the device is lost, or if the view has no such light.
    pub fn directions(&mut self, view: &View, light: usize) -> Result<Directions> {
        self.directions_of(view, light, &Sampling::ONE.sample(0))
    }

    /// Returns the directions of light number `light` in a `sample` of `view` that draws all lights, exactly as shading
    /// reads them.
    ///
    /// # Errors
    /// Same as [`Self::directions`].
    pub fn directions_of(&mut self, view: &View, light: usize, sample: &Sample) -> Result<Directions> {
        if light >= view.light_count() {
            return Err(Error::bug(format!("there is no light {light}")));
        }
        self.directions_in(view, &LightPass::of_all(light, *sample))
    }

    /// Returns the directions of `pass` of `view`, exactly as shading reads them.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn directions_in(&mut self, view: &View, pass: &LightPass) -> Result<Directions> {
        self.draw_directions(view, pass)?;
        self.read_directions(view, pass, PictureArea::All)
    }

    /// Returns the radiance and directions of the pixel `at` of the last frame drawn, one sample of `view` at the pixel
    /// centres; `None` if no object covers it.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn pixel(&mut self, view: &View, at: [u32; 2]) -> Result<Option<Pixel>> {
        let part = PictureArea::Pixel(at);
        let size = self.target.size();
        let is_there = self.shows == Content::Sample && at[0] < size[0] && at[1] < size[1];
        if !is_there || self.covered(part)? != [true] {
            return Ok(None);
        }
        let radiance = self.read(&self.target.radiance, part)?;
        let radiance =
            radiance.first().map_or(DVec3::ZERO, |&[r, g, b, _]| DVec3::new(r.into(), g.into(), b.into()));
        let sample = Sampling::ONE.sample(0);
        let mut directions = Vec::with_capacity(view.light_count());
        for light in 0..view.light_count() {
            let pass = LightPass::of_all(light, sample);
            self.draw_directions(view, &pass)?;
            directions.push(self.read_directions(view, &pass, part)?);
        }
        Ok(Some(Pixel { radiance, directions }))
    }

    /// Returns the directions in `part` of the last frame drawn, a `pass` of `view`.
    fn read_directions(&self, view: &View, pass: &LightPass, part: PictureArea) -> Result<Directions> {
        let Some(of_light) = &self.light_directions else { return Ok(Directions::default()) };
        let covered = self.covered(part)?;
        let kept = |read: Vec<[f32; 4]>| -> Vec<[f32; 4]> {
            read.into_iter().zip(&covered).map(|(x, covered)| if *covered { x } else { [0.0; 4] }).collect()
        };
        let light = kept(self.read(&of_light.light, part)?);
        let view_of = |[x, y, ..]: &[f32; 4], covered: &bool| {
            if *covered { unprojected([*x, *y]) } else { [0.0; 4] }
        };
        let facing = self.read(&self.gbuffer.facing, part)?;
        let mirrored = if self.shadings.run_of(view, pass.light, pass).mirrored {
            let read = kept(self.read(&of_light.mirrored, part)?);
            read.into_iter().map(|[red, green, blue, _]| [red, green, blue]).collect()
        } else {
            Vec::new()
        };
        let is_covered = |covered: &bool| f32::from(u8::from(*covered));
        Ok(Directions {
            light_number: pass.light,
            view: facing.iter().zip(&covered).map(|(stored, covered)| view_of(stored, covered)).collect(),
            footprints: kept(self.read(&of_light.footprints, part)?),
            filter: pass.sample.footprint,
            incidents: view.incidents(pass),
            chosen: self.chosen(pass, part),
            falloffs: light.iter().map(|[.., w]| *w).collect(),
            light: light.iter().zip(&covered).map(|([x, y, z, _], c)| [*x, *y, *z, is_covered(c)]).collect(),
            mirrored,
            objects: self.objects_seen(part)?,
        })
    }

    /// Returns the number of the light sample of each pixel of `part` in `pass`; empty if there is one.
    fn chosen(&self, pass: &LightPass, part: PictureArea) -> Vec<u8> {
        let Some(choices) = pass.choices else { return Vec::new() };
        let [width, height] = self.gbuffer.size();
        let all = || (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        let slot = |pixel| choices.slot(pixel) as u8;
        match part {
            PictureArea::All => all().map(slot).collect(),
            PictureArea::Pixel(at) => vec![slot(at)],
        }
    }

    /// Returns the object number of each pixel of `part`, from 0; empty if there is one object.
    fn objects_seen(&self, part: PictureArea) -> Result<Vec<u8>> {
        if !self.gbuffer.settings.several {
            return Ok(Vec::new());
        }
        let (corner, size) = match part {
            PictureArea::All => ([0; 2], self.gbuffer.depth.size()),
            PictureArea::Pixel(at) => (at, [1; 2]),
        };
        let stencil = target::read_back_objects(&self.device, &self.gbuffer.depth, corner, size)?;
        Ok(stencil.into_iter().map(|number| number.saturating_sub(1)).collect())
    }

    /// Draws the directions of a `pass` of `view`, and the G-buffer unless it is up to date.
    fn draw_directions(&mut self, view: &View, pass: &LightPass) -> Result<()> {
        self.write(view, self.target.size(), pass)?;
        let run = self.shadings.run_of(view, pass.light, pass);
        let of_light = match &mut self.light_directions {
            Some(there) => there,
            none => none.insert(LightDirections::new(&self.device, self.gbuffer.size())?),
        };
        of_light.prepare(&self.device, run, &self.objects[0], &self.gbuffer)?;
        let is_stale = !self.gbuffer_is_current();
        if is_stale {
            // The new surfaces may cover other pixels than the existing radiance.
            if self.shows == Content::Sample {
                self.shows = Content::Nothing;
            }
            self.image_input = None;
        }
        let Some(of_light) = &self.light_directions else { return Ok(()) };
        self.commands.run(|record| {
            if let Some(shadow_pass) = &self.shadow_pass {
                shadow_pass.record(record, &self.objects);
            }
            if is_stale {
                self.geometry_pass.record(record, &self.gbuffer, &self.objects);
            }
            of_light.record(record, run, &self.gbuffer, &self.objects);
            Ok(())
        })?;
        self.image_input = self.block_input.clone();
        Ok(())
    }

    /// Reads the texels of `part` of an RGBA float image that shaders may read.
    pub(super) fn read(&self, image: &Image, part: PictureArea) -> Result<Vec<[f32; 4]>> {
        let bytes = self.read_bytes(image, Access::ShaderRead, part)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    fn read_bytes(&self, image: &Image, last: Access, part: PictureArea) -> Result<Vec<u8>> {
        match part {
            PictureArea::All => target::read_back(&self.device, image, last),
            PictureArea::Pixel(at) => target::read_back_part(&self.device, image, last, at, [1; 2]),
        }
    }

    /// Returns the depth of each pixel of the last geometry pass; [`FAR`] at uncovered pixels.
    pub(in crate::internals::render) fn depth(&self) -> Result<Vec<f32>> {
        self.depth_of(PictureArea::All)
    }

    fn depth_of(&self, part: PictureArea) -> Result<Vec<f32>> {
        let depth = self.read_bytes(&self.gbuffer.depth, Access::DepthAttachment, part)?;
        Ok(bytemuck::pod_collect_to_vec(&depth))
    }

    /// Returns for each pixel of `part` if an object covers it.
    pub(super) fn covered(&self, part: PictureArea) -> Result<Vec<bool>> {
        Ok(self.depth_of(part)?.into_iter().map(|depth| depth < FAR).collect())
    }
}

/// Inverts the stereographic projection from −N that directions are stored in. Returns the unit vector at `s`; w is 1.
fn unprojected(s: [f32; 2]) -> [f32; 4] {
    let k = 2.0 / (1.0 + s[0] * s[0] + s[1] * s[1]);
    [k * s[0], k * s[1], k - 1.0, 1.0]
}
