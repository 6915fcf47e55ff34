//! A texture of egui's on the device, glyphs mostly. What is new in it is copied by the commands of the frame that shows it
//! first: barriers put the copy between the frames before, which may still read, and that one, and the host waits for nothing.

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

/// A texture, and the descriptor set by which the panel's pipeline reads it.
pub struct Atlas {
    // Before the image that it points to.
    descriptors: Descriptors,
    image: Image,
    // How the commands recorded so far leave the image.
    last: Access,
}

/// What is not needed beyond one frame: let go of when the device is done with that frame.
#[derive(Default)]
pub struct Kept {
    staging: Vec<Buffer>,
    atlases: Vec<Atlas>,
}

impl Kept {
    /// Keeps `atlas`, which this frame or one before it may read and no later one does.
    pub fn keep(&mut self, atlas: Atlas) {
        self.atlases.push(atlas);
    }

    /// Lets go of everything. The device must be done with the frame.
    pub fn clear(&mut self) {
        self.staging.clear();
        self.atlases.clear();
    }
}

impl Atlas {
    /// An atlas of `size` texels, read through `sampler`; its texels have yet to be written.
    ///
    /// # Errors
    /// Where the device has no room.
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
        // As the pipeline layout of egui_ash_renderer has it.
        let binding = Binding {
            number: 0,
            kind: vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            stages: vk::ShaderStageFlags::FRAGMENT,
        };
        let descriptors = Descriptors::new(device, "panel texture", &[binding])?;
        descriptors.image(0, &image, sampler);
        Ok(Self { descriptors, image, last: Access::Nothing })
    }

    /// The descriptor set.
    pub fn set(&self) -> vk::DescriptorSet {
        self.descriptors.set()
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        self.image.size()
    }

    /// Records the copy of what `delta` changes. The texels wait in `kept` until the device has read them.
    ///
    /// # Errors
    /// Where the device has no room, or the change lies outside of the atlas.
    pub fn write(
        &mut self,
        device: &Arc<Device>,
        record: &Recorder<'_>,
        delta: &ImageDelta,
        kept: &mut Kept,
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
        kept.staging.push(staging);
        Ok(())
    }
}

/// egui changes only what it has made.
pub(super) fn misplaced() -> Error {
    Error::failed("the panel changes a texture that is not there", "report this as a bug of diffract")
}
