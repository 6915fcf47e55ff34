//! Texture of egui on the device, mostly glyphs. The frame that first shows a change also copies it. Barriers order the
//! copy after the reads of earlier frames, so that the host never waits.

use crate::error::{Error, Result};
use crate::vk::access::Access;
use crate::vk::buffer::Buffer;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::sampler::Sampler;
use ash::vk;
use egui::ImageData;
use egui::epaint::ImageDelta;
use std::sync::Arc;

/// Texture and the descriptor set through which the panel's pipeline reads it.
pub struct Atlas {
    // Before the image, so that it is dropped first.
    descriptors: Descriptors,
    image: Image,
    // Last recorded access.
    last: Access,
}

/// Resources used for the last time by one frame. They are freed when the device has finished the frame.
#[derive(Default)]
pub struct FrameResources {
    staging: Vec<Buffer>,
    atlases: Vec<Atlas>,
}

impl FrameResources {
    /// Keeps `atlas`, which no later frame reads.
    pub fn keep(&mut self, atlas: Atlas) {
        self.atlases.push(atlas);
    }

    /// Frees everything. The device must have finished the frame.
    pub fn clear(&mut self) {
        self.staging.clear();
        self.atlases.clear();
    }
}

impl Atlas {
    /// Makes an atlas of `size` texels, read through `sampler`; its texels are undefined until they are written.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, sampler: &Sampler, size: [u32; 2]) -> Result<Self> {
        let description = Description {
            name: "panel texture",
            format: vk::Format::R8G8B8A8_SRGB,
            size,
            layers: 1,
            array: false,
            usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
        };
        let image = Image::new(device, &description)?;
        // Binding in the pipeline layout of egui_ash_renderer.
        let binding = Binding {
            number: 0,
            kind: vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            stages: vk::ShaderStageFlags::FRAGMENT,
        };
        let descriptors = Descriptors::new(device, "panel texture", &[binding])?;
        descriptors.image(0, &image, sampler);
        Ok(Self { descriptors, image, last: Access::Nothing })
    }

    /// Returns the descriptor set.
    pub fn set(&self) -> vk::DescriptorSet {
        self.descriptors.set()
    }

    /// Returns width and height \[texels\].
    pub fn size(&self) -> [u32; 2] {
        self.image.size()
    }

    /// Records the copy of `delta`. `resources` keeps the staging buffer until the device has read it.
    ///
    /// # Errors
    /// Fails if the device is out of memory, or if the change lies outside the atlas.
    pub fn write(
        &mut self,
        device: &Arc<Device>,
        record: &Recorder<'_>,
        delta: &ImageDelta,
        resources: &mut FrameResources,
    ) -> Result<()> {
        let ImageData::Color(new) = &delta.image;
        let corner = delta.pos.unwrap_or([0, 0]);
        let inside = |i: usize| corner[i] + new.size[i] <= self.size()[i] as usize;
        if !(inside(0) && inside(1)) {
            return Err(misplaced());
        }
        let texels: Vec<u8> = new.pixels.iter().flat_map(|texel| texel.to_array()).collect();
        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
        let staging = Buffer::with_data(device, "panel staging", usage, &texels)?;
        let before = std::mem::replace(&mut self.last, Access::ShaderRead);
        let [corner, size] = [corner, new.size].map(|pair| pair.map(|n| n as u32));
        record.images(&[(&self.image, before, Access::TransferWrite)]);
        record.copy_to_part(&staging, &self.image, corner, size);
        record.images(&[(&self.image, Access::TransferWrite, self.last)]);
        resources.staging.push(staging);
        Ok(())
    }
}

/// Returns the error of an inconsistent texture change, which indicates a bug in egui or here.
pub(super) fn misplaced() -> Error {
    Error::bug("the panel changes a texture that is not there")
}
