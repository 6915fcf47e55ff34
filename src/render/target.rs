//! Render targets of a frame: a linear HDR colour image with depth, and the displayed 8-bit image.

use crate::error::{Error, Result};
use crate::vk::access::Access;
use crate::vk::buffer::Buffer;
use crate::vk::commands::Commands;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::sync::Arc;

/// Format of radiance: signed, with the precision of the reference it is compared with.
pub const RADIANCE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
/// Format of depth.
pub const DEPTH: vk::Format = vk::Format::D32_SFLOAT;
/// Format of depth with the object number in the stencil.
pub const DEPTH_AND_OBJECT: vk::Format = vk::Format::D32_SFLOAT_S8_UINT;
/// Format of the displayed picture; the shader applies the transfer function.
pub const DISPLAY: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Images of one picture size.
pub struct Target {
    /// Linear radiance; undefined at uncovered pixels.
    pub radiance: Image,
    /// Displayed picture, shared with a window that shows it.
    pub display: Arc<Image>,
}

impl Target {
    /// Makes images of `size` pixels.
    ///
    /// # Errors
    /// Fails if the device is out of memory or does not support images of that size.
    pub fn new(device: &Arc<Device>, size: [u32; 2]) -> Result<Self> {
        let attachment = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let make = |name, format, usage| {
            Image::new(device, &Description { name, format, size, layers: 1, array: false, usage })
        };
        Ok(Self {
            radiance: make("radiance", RADIANCE, attachment | vk::ImageUsageFlags::SAMPLED)?,
            display: Arc::new(make("display", DISPLAY, attachment | vk::ImageUsageFlags::SAMPLED)?),
        })
    }

    /// Returns width and height \[pixels\].
    pub fn size(&self) -> [u32; 2] {
        self.radiance.size()
    }
}

/// Returns the bytes per texel of a format that can be read back; without the stencil of a depth format.
fn texel_size(format: vk::Format) -> Result<u64> {
    match format {
        vk::Format::R32G32B32A32_SFLOAT => Ok(16),
        vk::Format::R8G8B8A8_UNORM | DEPTH | DEPTH_AND_OBJECT => Ok(4),
        other => Err(Error::bug(format!("{other:?} cannot be read back"))),
    }
}

/// Reads an image back to the host, tightly packed; `last` is its last use.
///
/// # Errors
/// Fails if the device is lost or out of memory.
pub fn read_back(device: &Arc<Device>, image: &Image, last: Access) -> Result<Vec<u8>> {
    read_back_part(device, image, last, [0; 2], image.size())
}

/// Reads the rectangle of `size` texels at `corner` back to the host, as [`read_back`].
///
/// # Errors
/// Same as [`read_back`].
pub fn read_back_part(
    device: &Arc<Device>,
    image: &Image,
    last: Access,
    corner: [u32; 2],
    size: [u32; 2],
) -> Result<Vec<u8>> {
    let without_stencil = image.aspect() & !vk::ImageAspectFlags::STENCIL;
    read_back_aspect(device, (image, without_stencil, texel_size(image.format())?), last, corner, size)
}

/// Reads the rectangle of `size` texels at `corner` of the object numbers in the stencil; 0 at uncovered pixels.
///
/// # Errors
/// Same as [`read_back`].
pub fn read_back_objects(
    device: &Arc<Device>,
    depth: &Image,
    corner: [u32; 2],
    size: [u32; 2],
) -> Result<Vec<u8>> {
    let stencil = (depth, vk::ImageAspectFlags::STENCIL, 1);
    read_back_aspect(device, stencil, Access::DepthAttachment, corner, size)
}

/// Reads the rectangle of `size` texels at `corner` of one aspect of an image with `bytes` bytes per texel.
fn read_back_aspect(
    device: &Arc<Device>,
    (image, aspect, bytes): (&Image, vk::ImageAspectFlags, u64),
    last: Access,
    corner: [u32; 2],
    size: [u32; 2],
) -> Result<Vec<u8>> {
    let bytes = u64::from(size[0]) * u64::from(size[1]) * bytes;
    let usage = vk::BufferUsageFlags::TRANSFER_DST;
    let host = Buffer::new(device, "read back", bytes, usage, MemoryLocation::GpuToCpu)?;
    Commands::new(device, "read back")?.run(|record| {
        record.images(&[(image, last, Access::TransferRead)]);
        record.copy_from_image((image, aspect), corner, size, &host);
        record.images(&[(image, Access::TransferRead, last)]);
        record.memory(Access::TransferWrite, Access::HostRead);
        Ok(())
    })?;
    Ok(host.bytes()?.to_vec())
}
