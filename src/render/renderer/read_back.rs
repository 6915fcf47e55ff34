//! Read-back of the geometry pass: the directions seen by pixels.

use super::{Content, GeometryInput, Renderer};
use crate::error::{Error, Result};
use crate::render::directions::{Directions, Pixel};
use crate::render::frame::View;
use crate::render::light_passes::LightPass;
use crate::render::sampling::{Sample, Sampling};
use crate::render::target;
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
            return Err(Error::failed(
                format!("there is no light {light}"),
                "report this as a bug of diffract",
            ));
        }
        self.directions_in(view, &LightPass::of_all(light, *sample))
    }

    /// Returns the directions of `pass` of `view`, exactly as shading reads them.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn directions_in(&mut self, view: &View, pass: &LightPass) -> Result<Directions> {
        self.draw_geometry(view, pass)?;
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
            self.draw_geometry(view, &pass)?;
            directions.push(self.read_directions(view, &pass, part)?);
        }
        Ok(Some(Pixel { radiance, directions }))
    }

    /// Returns the directions in `part` of the last frame drawn, a `pass` of `view`.
    fn read_directions(&self, view: &View, pass: &LightPass, part: PictureArea) -> Result<Directions> {
        let stored = self.read(&self.geometry.directions, part)?;
        let covered = self.covered(part)?;
        let unit = |s: [f32; 2], covered: bool| if covered { unprojected(s) } else { [0.0; 4] };
        let both = || stored.iter().zip(&covered);
        let footprints = match &self.geometry.footprints {
            Some(image) => self.read(image, part)?,
            None => Vec::new(),
        };
        let kept = |(f, covered): ([f32; 4], &bool)| if *covered { f } else { [0.0; 4] };
        let falloffs = match &self.geometry.albedo {
            Some(image) if self.geometry.settings.lamps => {
                self.read(image, part)?.iter().map(|[.., falloff]| *falloff).collect()
            }
            _ => Vec::new(),
        };
        let mirrored = match &self.geometry.mirrored {
            Some(image) if self.mirrors(view, pass) => {
                let read = self.read(image, part)?.into_iter();
                read.zip(&covered).map(kept).map(|[red, green, blue, _]| [red, green, blue]).collect()
            }
            _ => Vec::new(),
        };
        Ok(Directions {
            light_number: pass.light,
            light: both().map(|(&[.., x, y], &covered)| unit([x, y], covered)).collect(),
            view: both().map(|(&[x, y, ..], &covered)| unit([x, y], covered)).collect(),
            footprints: footprints.into_iter().zip(&covered).map(kept).collect(),
            filter: pass.sample.footprint,
            irradiance: view.incident(pass).irradiance.as_dvec3(),
            falloffs,
            mirrored,
            objects: self.objects_seen(part)?,
        })
    }

    /// Returns the object number of each pixel of `part`, from 0; empty if there is one object.
    fn objects_seen(&self, part: PictureArea) -> Result<Vec<u8>> {
        if !self.geometry.settings.several {
            return Ok(Vec::new());
        }
        let (corner, size) = match part {
            PictureArea::All => ([0; 2], self.geometry.depth.size()),
            PictureArea::Pixel(at) => (at, [1; 2]),
        };
        let stencil = target::read_back_objects(&self.device, &self.geometry.depth, corner, size)?;
        Ok(stencil.into_iter().map(|number| number.saturating_sub(1)).collect())
    }

    /// Draws the geometry of a `pass` of `view`, unless the images hold it already.
    fn draw_geometry(&mut self, view: &View, pass: &LightPass) -> Result<()> {
        self.write(view, self.target.size(), pass)?;
        if self.image_input.is_some() && self.image_input == self.block_input {
            return Ok(());
        }
        // The new geometry may cover other pixels than the existing radiance.
        let of_same_pixels = |found: &GeometryInput| {
            found.view == *view
                && found.size == self.target.size()
                && found.pass.sample.jitter == pass.sample.jitter
        };
        if self.shows == Content::Sample && !self.image_input.as_ref().is_some_and(of_same_pixels) {
            self.shows = Content::Nothing;
        }
        self.image_input = None;
        let mirrored = self.mirrors(view, pass);
        self.commands.run(|record| {
            self.geometry_pass.record(record, &self.geometry, &self.objects, mirrored);
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
    pub(in crate::render) fn depth(&self) -> Result<Vec<f32>> {
        self.depth_of(PictureArea::All)
    }

    fn depth_of(&self, part: PictureArea) -> Result<Vec<f32>> {
        let depth = self.read_bytes(&self.geometry.depth, Access::DepthAttachment, part)?;
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
