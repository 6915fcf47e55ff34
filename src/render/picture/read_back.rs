//! Reads back what the geometry pass wrote: the directions that pixels see.

use super::{Content, Painter};
use crate::error::{Error, Result};
use crate::render::directions::{Directions, Pixel};
use crate::render::frame::View;
use crate::render::sampling::{Sample, Sampling};
use crate::render::target::{self, Geometry};
use crate::vk::access::Access;
use crate::vk::commands::FAR;
use crate::vk::image::Image;
use glam::DVec3;

/// Which pixels are read back.
#[derive(Clone, Copy, Debug)]
pub(super) enum PictureArea {
    /// All of them.
    All,
    /// The one in this column and row.
    Pixel([u32; 2]),
}

impl Painter {
    /// The directions of light number `light` in one sample of `view` at the centres of pixels, as the shading has them.
    ///
    /// # Errors
    /// Where the device is lost, and where the pictures have no such light.
    pub fn directions(&mut self, view: &View, light: usize) -> Result<Directions> {
        self.directions_of(view, light, &Sampling::ONE.sample(0))
    }

    /// The directions of light number `light` in `sample` of `view`, as the shading has them.
    ///
    /// # Errors
    /// As [`Self::directions`].
    pub fn directions_of(&mut self, view: &View, light: usize, sample: &Sample) -> Result<Directions> {
        if light >= self.geometry.settings.lights {
            return Err(Error::failed(
                format!("there is no light {light}"),
                "report this as a bug of diffract",
            ));
        }
        self.draw_geometry(view, sample)?;
        self.found(view, light, sample, PictureArea::All)
    }

    /// What pixel `at` of the frame of `view` that was drawn last shows, one sample at the centres of pixels; `None` where the mesh does not
    /// cover it.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn pixel(&self, view: &View, at: [u32; 2]) -> Result<Option<Pixel>> {
        let (part, lights) = (PictureArea::Pixel(at), self.geometry.settings.lights.min(view.light_count()));
        let size = self.target.size();
        let is_there = self.shows == Content::Sample && at[0] < size[0] && at[1] < size[1];
        if !is_there || self.covered(part)? != [true] {
            return Ok(None);
        }
        let radiance = self.read(&self.target.radiance, part)?;
        let radiance =
            radiance.first().map_or(DVec3::ZERO, |&[r, g, b, _]| DVec3::new(r.into(), g.into(), b.into()));
        let of = |light| self.found(view, light, &Sampling::ONE.sample(0), part);
        Ok(Some(Pixel { radiance, directions: (0..lights).map(of).collect::<Result<_>>()? }))
    }

    /// The directions of light number `light` in `part` of the frame of `sample` of `view` that was drawn last.
    fn found(&self, view: &View, light: usize, sample: &Sample, part: PictureArea) -> Result<Directions> {
        let first = self.read(&self.geometry.directions, part)?;
        let lights = match light.checked_sub(1) {
            None => first.iter().map(|&[.., x, y]| [x, y]).collect(),
            Some(more) => {
                let image = self.read(&self.geometry.more_lights[more / 2], part)?;
                image
                    .iter()
                    .map(|&[a, b, c, d]| if more % 2 == 0 { [a, b] } else { [c, d] })
                    .collect::<Vec<_>>()
            }
        };
        let covered = self.covered(part)?;
        let of = |(s, covered): ([f32; 2], &bool)| if *covered { unprojected(s) } else { [0.0; 4] };
        let footprints = match self.geometry.footprints.get(light) {
            Some(image) => self.read(image, part)?,
            None => Vec::new(),
        };
        let kept = |(f, covered): ([f32; 4], &bool)| if *covered { f } else { [0.0; 4] };
        let falloffs = match &self.geometry.falloffs {
            Some(image) => self.read(image, part)?.iter().map(|falloffs| falloffs[light]).collect(),
            None => Vec::new(),
        };
        let surrounds = self.geometry.settings.mirrored && light == view.lights.len();
        let mirrored = if surrounds { self.mirrored(&covered, part)? } else { Vec::new() };
        Ok(Directions {
            light: lights.into_iter().zip(&covered).map(of).collect(),
            view: first.iter().map(|stored| [stored[0], stored[1]]).zip(&covered).map(of).collect(),
            footprints: footprints.into_iter().zip(&covered).map(kept).collect(),
            filter: sample.footprint,
            share: sample.share(),
            irradiance: view.incidents(sample).get(light).map_or(DVec3::ZERO, |i| i.irradiance.as_dvec3()),
            falloffs,
            mirrored,
            objects: self.objects_seen(part)?,
        })
    }

    /// Radiance of the surroundings in the mirrored direction of each `covered` pixel, as the geometry pass wrote it: behind the last light,
    /// and beside the albedo.
    fn mirrored(&self, covered: &[bool], part: PictureArea) -> Result<Vec<[f32; 3]>> {
        let Geometry { more_lights, albedo, settings, .. } = &self.geometry;
        let place = settings.lights - 1;
        let (Some(image), Some(albedo)) = (more_lights.get(place / 2), albedo) else {
            return Ok(Vec::new());
        };
        let of = |((lights, albedo), covered): (([f32; 4], [f32; 4]), &bool)| {
            let [a, b, c, d] = lights;
            let [red, green] = if place % 2 == 0 { [a, b] } else { [c, d] };
            if *covered { [red, green, albedo[3]] } else { [0.0; 3] }
        };
        Ok(self.read(image, part)?.into_iter().zip(self.read(albedo, part)?).zip(covered).map(of).collect())
    }

    /// Number of the object that each pixel of `part` shows, from 0; empty where there is one object.
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

    /// Draws the geometry of a `sample` of `view` alone, unless it is there.
    fn draw_geometry(&mut self, view: &View, sample: &Sample) -> Result<()> {
        self.write(view, self.target.size(), sample)?;
        if self.found.is_some() && self.found == self.written {
            return Ok(());
        }
        // What is covered may be other pixels than those of the radiance that is there.
        if self.shows == Content::Sample {
            self.shows = Content::Nothing;
        }
        self.found = None;
        self.commands.run(|record| {
            self.find.record(record, &self.geometry, &self.objects);
            Ok(())
        })?;
        self.found = self.written.clone();
        Ok(())
    }

    /// The texels of `part` of an image of four floats that shaders may read.
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

    /// Depth of each pixel of what was found last; [`FAR`] where nothing is covered.
    pub(in crate::render) fn depth(&self) -> Result<Vec<f32>> {
        self.depth_of(PictureArea::All)
    }

    fn depth_of(&self, part: PictureArea) -> Result<Vec<f32>> {
        let depth = self.read_bytes(&self.geometry.depth, Access::DepthAttachment, part)?;
        Ok(bytemuck::pod_collect_to_vec(&depth))
    }

    /// Whether the mesh covers each pixel of `part`.
    pub(super) fn covered(&self, part: PictureArea) -> Result<Vec<bool>> {
        Ok(self.depth_of(part)?.into_iter().map(|depth| depth < FAR).collect())
    }
}

/// The unit vector at `s` of the stereographic projection from −N that directions are stored by; w is 1.
fn unprojected(s: [f32; 2]) -> [f32; 4] {
    let k = 2.0 / (1.0 + s[0] * s[0] + s[1] * s[1]);
    [k * s[0], k * s[1], k - 1.0, 1.0]
}
