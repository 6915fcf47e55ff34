//! The sum of the samples of a picture, and its display.

use super::display::DisplayPass;
use crate::error::Result;
use crate::render::frame::Shown;
use crate::render::sampling::PixelWeights;
use crate::render::shader;
use crate::render::target::{self, Target};
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::{Drawing, Pipeline};
use crate::vk::sampler::Sampler;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Sums the samples of pictures of one size.
pub struct Accumulation {
    pipeline: Pipeline,
    radiance: Descriptors,
    display: DisplayPass,
    /// Sum of the radiance of samples; alpha: number of them that cover the pixel. Readable by shaders between passes.
    pub sum: Image,
    // Present if passes are added in groups.
    group: Option<Group>,
    sampler: Sampler,
}

/// Sum of the passes of the current group, which are added together.
struct Group {
    image: Image,
    descriptors: Descriptors,
}

/// Addition of one pass to a sum.
#[derive(Clone, Copy, Debug)]
pub struct Addition {
    /// Weights of a sample for its pixel and the eight neighbours.
    pub weights: PixelWeights,
    /// Size of the picture \[pixels\].
    pub size: [u32; 2],
    /// Number of the pass in its group, from 0.
    pub pass: usize,
    /// Passes of the group, which come into the sum together.
    pub passes: usize,
    /// True if the group begins a new sum.
    pub first: bool,
}

/// Push constants of `accumulate.frag`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct WeightsBlock {
    across: [f32; 4],
    down: [f32; 4],
    last: [i32; 2],
    padding: [i32; 2],
}

impl WeightsBlock {
    fn new(weights: PixelWeights, size: [u32; 2]) -> Self {
        let four = |[a, b, c]: [f64; 3]| [a as f32, b as f32, c as f32, 0.0];
        let last = size.map(|n| n as i32 - 1);
        Self { across: four(weights.across), down: four(weights.down), last, padding: [0; 2] }
    }
}

impl Accumulation {
    /// Makes an empty sum for samples that are drawn into `target`.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, target: &Target) -> Result<Self> {
        let radiance = set(device)?;
        let drawing = Drawing { vertex_stride: 0, attributes: &[], colors: &[target::RADIANCE], depth: None };
        let (vertex, fragment) = (shader!("display.vert"), shader!("accumulate.frag"));
        let push_bytes = size_of::<WeightsBlock>() as u32;
        let made = Self {
            pipeline: Pipeline::adding(device, vertex, fragment, &drawing, &[&radiance], push_bytes)?,
            radiance,
            display: DisplayPass::of_mean(device, target::DISPLAY)?,
            sum: sum(device, target.size())?,
            group: None,
            sampler: Sampler::nearest(device, "accumulation sampler")?,
        };
        made.point_at(target);
        Ok(made)
    }

    /// Sets the size of the following samples to that of `target`. The device must not be using the passes.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn resize(&mut self, device: &Arc<Device>, target: &Target) -> Result<()> {
        if target.size() != self.sum.size() {
            self.group = None;
            self.sum = sum(device, target.size())?;
        }
        self.point_at(target);
        Ok(())
    }

    fn point_at(&self, target: &Target) {
        self.radiance.image(0, &target.radiance, &self.sampler);
        self.display.read_from(&self.sum);
    }

    /// Allocates the image for groups of `passes` passes.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn make_room(&mut self, device: &Arc<Device>, passes: usize) -> Result<()> {
        if passes > 1 && self.group.is_none() {
            let group = Group { image: sum(device, self.sum.size())?, descriptors: set(device)? };
            group.descriptors.image(0, &group.image, &self.sampler);
            self.group = Some(group);
        }
        Ok(())
    }

    /// Records the addition of `target.radiance` (a colour attachment before, readable by shaders afterwards). Groups
    /// of several passes need [`Self::make_room`] first. An abandoned group leaves the sum unchanged.
    pub fn record(&self, record: &Recorder<'_>, target: &Target, added: Addition) {
        let Addition { weights, size, pass, passes, first } = added;
        record.images(&[(&target.radiance, Access::ColorAttachment, Access::ShaderRead)]);
        let all = WeightsBlock::new(weights, size);
        match self.group.as_ref().filter(|_| passes > 1) {
            None => self.add(record, &self.radiance, (&self.sum, first), all),
            Some(group) => {
                self.add(record, &self.radiance, (&group.image, pass == 0), all);
                if pass + 1 == passes {
                    let as_it_is = WeightsBlock::new(PixelWeights::OWN, size);
                    self.add(record, &group.descriptors, (&self.sum, first), as_it_is);
                }
            }
        }
    }

    /// Adds the texture in `from` to the image `into`. The `first` addition clears the image; before later ones it is
    /// readable by shaders.
    fn add(
        &self,
        record: &Recorder<'_>,
        from: &Descriptors,
        (into, first): (&Image, bool),
        block: WeightsBlock,
    ) {
        let before = if first { Access::Nothing } else { Access::ShaderRead };
        record.images(&[(into, before, Access::ColorAttachment)]);
        let add = |draw: &Recorder<'_>| {
            draw.bind(&self.pipeline, &[from]);
            draw.push(&self.pipeline, bytemuck::bytes_of(&block));
            draw.draw(3);
        };
        if first {
            record.render(&[(into, Some([0.0; 4]))], None, add);
        } else {
            record.render_onto(into, None, add);
        }
        record.images(&[(into, Access::ColorAttachment, Access::ShaderRead)]);
    }

    /// Records the display of the mean of `samples` samples into `into`, which becomes a colour attachment.
    pub fn record_display(&self, record: &Recorder<'_>, into: &Image, samples: u32, shown: Shown) {
        self.display.record_mean(record, into, samples, shown);
    }
}

/// Makes the descriptor set of a radiance texture to add.
fn set(device: &Arc<Device>) -> Result<Descriptors> {
    Descriptors::new(device, "accumulation set", &[Binding::texture(0)])
}

fn sum(device: &Arc<Device>, size: [u32; 2]) -> Result<Image> {
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
        | vk::ImageUsageFlags::SAMPLED
        | vk::ImageUsageFlags::TRANSFER_SRC;
    let (format, name) = (target::RADIANCE, "sum of samples");
    Image::new(device, &Description { name, format, size, layers: 1, array: false, usage })
}
