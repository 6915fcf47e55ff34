//! The sum of the samples of a picture, and its display.

use super::frame::{DisplayPass, Shown};
use super::sampling::PixelWeights;
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
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Sums the samples of pictures of one size.
pub struct Accumulation {
    pipeline: Pipeline,
    radiance: Descriptors,
    display: DisplayPass,
    /// Sum of the radiance of samples; alpha: how many of them cover the pixel. Readable by shaders between passes.
    pub sum: Image,
    // Where there are groups.
    group: Option<Group>,
    sampler: Sampler,
}

/// The sum of what was drawn of a group of passes that are added together.
struct Group {
    image: Image,
    descriptors: Descriptors,
}

/// What is added of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Addition {
    /// What the samples of a pixel and of those around it count for the pixel.
    pub weights: PixelWeights,
    /// Of the picture \[pixels\].
    pub size: [u32; 2],
    /// Number of the pass in its group, from 0.
    pub pass: usize,
    /// Passes of the group, which come into the sum together.
    pub passes: usize,
    /// Whether the group begins a new sum.
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
    /// For samples that are drawn into `target`.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(device: &Arc<Device>, target: &Target) -> Result<Self> {
        let radiance = set(device)?;
        let drawing = Drawing { vertex_stride: 0, attributes: &[], colors: &[target::RADIANCE], depth: None };
        let (vertex, fragment) = (shader!("display.vert"), shader!("accumulate.frag"));
        let push_bytes = size_of::<WeightsBlock>() as u32;
        let own = Self {
            pipeline: Pipeline::adding(device, vertex, fragment, &drawing, &[&radiance], push_bytes)?,
            radiance,
            display: DisplayPass::of_mean(device, target::DISPLAY)?,
            sum: sum(device, target.size())?,
            group: None,
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

    /// Makes room for groups of so many passes.
    ///
    /// # Errors
    /// Where the device has none.
    pub fn make_room(&mut self, device: &Arc<Device>, passes: usize) -> Result<()> {
        if passes > 1 && self.group.is_none() {
            let group = Group { image: sum(device, self.sum.size())?, descriptors: set(device)? };
            group.descriptors.image(0, &group.image, &self.sampler);
            self.group = Some(group);
        }
        Ok(())
    }

    /// Records the addition of `target.radiance` (a colour attachment until now, readable by shaders from then on), for which [`Self::make_room`] has made
    /// room. A group that is given up leaves the sum as it was.
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

    /// Adds what `from` has, `into` an image, of which it is the `first` or which shaders read.
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

    /// Records the display of the mean of `samples` samples into `into`, which it leaves a colour attachment.
    pub fn record_display(&self, record: &Recorder<'_>, into: &Image, samples: u32, shown: Shown) {
        self.display.record_mean(record, into, samples, shown);
    }
}

/// Of what is added.
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
