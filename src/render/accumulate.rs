//! The sum of the samples of a picture, and its display.

use super::frame::{DisplayPass, Shown};
use super::shader;
use super::target::{self, Target};
use crate::error::Result;
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::{Drawing, Pipeline};
use crate::vk::sampler::Sampler;
use ash::vk;
use std::sync::Arc;

/// Sums the samples of pictures of one size.
pub struct Accumulation {
    pipeline: Pipeline,
    descriptors: Descriptors,
    display: DisplayPass,
    /// Sum of the radiance of samples; alpha: how many of them cover the pixel. Readable by shaders between passes.
    pub sum: Image,
    sampler: Sampler,
}

impl Accumulation {
    /// For samples that are drawn into `target`.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(device: &Arc<Device>, target: &Target) -> Result<Self> {
        let descriptors = Descriptors::new(device, "accumulation set", &[Binding::texture(0)])?;
        let drawing = Drawing { vertex_stride: 0, attributes: &[], colors: &[target::RADIANCE], depth: None };
        let (vertex, fragment) = (shader!("display.vert"), shader!("accumulate.frag"));
        let own = Self {
            pipeline: Pipeline::adding(device, vertex, fragment, &drawing, &[&descriptors], 0)?,
            descriptors,
            display: DisplayPass::of_mean(device, target::DISPLAY)?,
            sum: sum(device, target.size())?,
            sampler: Sampler::nearest(device, "accumulation sampler")?,
        };
        own.point_at(target);
        Ok(own)
    }

    /// Takes samples of other sizes from now on. The device must not be using the passes.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn resize(&mut self, device: &Arc<Device>, target: &Target) -> Result<()> {
        if target.size() != self.sum.size() {
            self.sum = sum(device, target.size())?;
        }
        self.point_at(target);
        Ok(())
    }

    fn point_at(&self, target: &Target) {
        self.descriptors.image(0, &target.radiance, &self.sampler);
        self.display.read_from(&self.sum);
    }

    /// Records the addition of `target.radiance` (a colour attachment until now, readable by shaders from then on); the `first` begins a new sum.
    pub fn record(&self, record: &Recorder<'_>, target: &Target, first: bool) {
        let before = if first { Access::Nothing } else { Access::ShaderRead };
        record.images(&[
            (&target.radiance, Access::ColorAttachment, Access::ShaderRead),
            (&self.sum, before, Access::ColorAttachment),
        ]);
        let add = |draw: &Recorder<'_>| {
            draw.bind(&self.pipeline, &[&self.descriptors]);
            draw.draw(3);
        };
        if first {
            record.render(&[(&self.sum, Some([0.0; 4]))], None, add);
        } else {
            record.render_onto(&self.sum, None, add);
        }
        record.images(&[(&self.sum, Access::ColorAttachment, Access::ShaderRead)]);
    }

    /// Records the display of the mean of `samples` samples into `into`, which it leaves a colour attachment.
    pub fn record_display(&self, record: &Recorder<'_>, into: &Image, samples: u32, shown: Shown) {
        self.display.record_mean(record, into, samples, shown);
    }
}

fn sum(device: &Arc<Device>, size: [u32; 2]) -> Result<Image> {
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
        | vk::ImageUsageFlags::SAMPLED
        | vk::ImageUsageFlags::TRANSFER_SRC;
    let (format, name) = (target::RADIANCE, "sum of samples");
    Image::new(device, &Description { name, format, size, layers: 1, array: false, usage })
}
