//! Where a frame is drawn to: a linear HDR colour image with depth, and the 8-bit image that is displayed.

use crate::error::{Error, Result};
use crate::vk::access::Access;
use crate::vk::buffer::Buffer;
use crate::vk::commands::Commands;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::sync::Arc;

/// Format of radiance: signed, and as exact as the reference that judges it.
pub const RADIANCE: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
/// Format of depth.
pub const DEPTH: vk::Format = vk::Format::D32_SFLOAT;
/// Format of depth with the number of the object that is seen beside it.
const DEPTH_AND_OBJECT: vk::Format = vk::Format::D32_SFLOAT_S8_UINT;
/// Format of the displayed picture; the shader applies the transfer function.
pub const DISPLAY: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Format of directions and pigment.
pub const GEOMETRY: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// What the geometry pass clears directions to: farther out than any is projected (`UNCOVERED` of `shaders/pixel.glsl`).
pub const UNCOVERED: f32 = 100.0;

/// Format of footprints.
pub const FOOTPRINTS: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// What the geometry pass is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GeometrySettings {
    /// Whether the pigment is of a texture.
    pub textured: bool,
    /// Whether directions hold [`UNCOVERED`] where nothing is covered; else they hold anything there.
    pub marked: bool,
    /// Whether footprints are written.
    pub footprints: bool,
    /// Whether the light casts shadows.
    pub shadows: bool,
    /// Whether surroundings are among the lights; under them, their radiance in the mirrored direction is written.
    pub mirrored: bool,
    /// Whether lamps are among the lights.
    pub lamps: bool,
    /// Whether there are several objects, so that the number of the one that is seen stands beside the depth.
    pub several: bool,
}

impl GeometrySettings {
    /// Format of the depth.
    pub fn depth_format(&self) -> vk::Format {
        if self.several { DEPTH_AND_OBJECT } else { DEPTH }
    }
}

/// What the geometry pass finds at each pixel under one light, directions in stereographic projection.
pub struct Geometry {
    /// ω_r (xy) and ω_i (zw).
    pub directions: Image,
    /// Albedo of the pigment, linear sRGB; w: how bright the light is at the pixel, its falloff, or 1 where it is far away. Where the pigment is of a
    /// texture, lamps are among the lights, or another image stands behind it.
    pub albedo: Option<Image>,
    /// Radiance of the surroundings in the mirrored direction, where they are among the lights; written where the light is drawn from them.
    pub mirrored: Option<Image>,
    /// Depth; [`crate::vk::commands::FAR`] where nothing is covered. Where there are several objects, beside it the number of the one that is seen, from 1.
    pub depth: Image,
    /// How (u, v) = −(ω_i + ω_r).xy changes from pixel to pixel: du/dx, dv/dx, du/dy, dv/dy, x to the right and y downward, where it is asked
    /// for; anything where nothing is covered.
    pub footprints: Option<Image>,
    /// What the images are for.
    pub settings: GeometrySettings,
}

impl Geometry {
    /// Images of `size` pixels.
    ///
    /// # Errors
    /// Where the device has no room or does not make images of that size.
    pub fn new(device: &Arc<Device>, size: [u32; 2], settings: GeometrySettings) -> Result<Self> {
        let GeometrySettings { textured, footprints, mirrored, lamps, .. } = settings;
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::SAMPLED;
        let make = |name, format, usage| {
            Image::new(device, &Description { name, format, size, layers: 1, array: false, usage })
        };
        let image = |wanted: bool, name, format| wanted.then(|| make(name, format, usage)).transpose();
        Ok(Self {
            directions: make("directions", GEOMETRY, usage)?,
            // The attachments of a pass have no gaps.
            albedo: image(textured || lamps || mirrored, "albedos", GEOMETRY)?,
            mirrored: image(mirrored, "mirrored radiance", GEOMETRY)?,
            footprints: image(footprints, "footprints", FOOTPRINTS)?,
            depth: make(
                "depth",
                settings.depth_format(),
                vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC,
            )?,
            settings,
        })
    }

    /// The colour images in the order of `geometry.frag`, those that the pass writes for a light that is drawn from the surroundings or not.
    pub fn images(&self, mirrors: bool) -> impl Iterator<Item = &Image> {
        let mirrored = self.mirrored.as_ref().filter(|_| mirrors);
        let others = [self.footprints.as_ref(), self.albedo.as_ref(), mirrored];
        std::iter::once(&self.directions).chain(others.into_iter().flatten())
    }
}

/// The images of one picture size.
pub struct Target {
    /// Linear radiance; anything where nothing is covered.
    pub radiance: Image,
    /// Displayed picture. A window that shows it holds it too.
    pub display: Arc<Image>,
}

impl Target {
    /// Images of `size` pixels.
    ///
    /// # Errors
    /// Where the device has no room or does not make images of that size.
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

    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.radiance.size()
    }
}

/// Bytes per texel of the formats that are read back, of depth without what stands beside it.
fn texel_size(format: vk::Format) -> Result<u64> {
    match format {
        vk::Format::R32G32B32A32_SFLOAT => Ok(16),
        vk::Format::R8G8B8A8_UNORM | DEPTH | DEPTH_AND_OBJECT => Ok(4),
        other => {
            Err(Error::failed(format!("{other:?} cannot be read back"), "report this as a bug of diffract"))
        }
    }
}

/// Reads an image back to the host, tightly packed; `last` is its last use.
///
/// # Errors
/// Where the device is lost or out of memory.
pub fn read_back(device: &Arc<Device>, image: &Image, last: Access) -> Result<Vec<u8>> {
    read_back_part(device, image, last, [0; 2], image.size())
}

/// As [`read_back`], the rectangle of `size` texels at `corner` alone.
///
/// # Errors
/// As [`read_back`].
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

/// Reads the rectangle of `size` texels at `corner` of the numbers beside the depth; 0 where nothing is covered.
///
/// # Errors
/// As [`read_back`].
pub fn read_back_objects(
    device: &Arc<Device>,
    depth: &Image,
    corner: [u32; 2],
    size: [u32; 2],
) -> Result<Vec<u8>> {
    let stencil = (depth, vk::ImageAspectFlags::STENCIL, 1);
    read_back_aspect(device, stencil, Access::DepthAttachment, corner, size)
}

/// Reads the rectangle of `size` texels at `corner` of an aspect of an image, of so many bytes a texel.
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
