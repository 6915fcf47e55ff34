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
const DEPTH_AND_OBJECT: vk::Format = vk::Format::D32_SFLOAT_S8_UINT;
/// Format of the displayed picture; the shader applies the transfer function.
pub const DISPLAY: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Format of directions and pigment.
pub const GEOMETRY: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Clear value of directions: outside the range of the projection (`UNCOVERED` of `shaders/pixel.glsl`).
pub const UNCOVERED: f32 = 100.0;

/// Format of footprints.
pub const FOOTPRINTS: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Outputs of the geometry pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GeometrySettings {
    /// True if a texture gives the pigment.
    pub textured: bool,
    /// True if directions are [`UNCOVERED`] at uncovered pixels; otherwise they are undefined there.
    pub marked: bool,
    /// True if footprints are written.
    pub footprints: bool,
    /// True if the light casts shadows.
    pub shadows: bool,
    /// True if surroundings are among the lights; their radiance in the mirrored direction is then written.
    pub mirrored: bool,
    /// True if lamps are among the lights.
    pub lamps: bool,
    /// True if there are several objects, so that the object number is written beside the depth.
    pub several: bool,
}

impl GeometrySettings {
    /// Returns the format of the depth.
    pub fn depth_format(&self) -> vk::Format {
        if self.several { DEPTH_AND_OBJECT } else { DEPTH }
    }
}

/// Output of the geometry pass under one light. Directions are in stereographic projection.
pub struct Geometry {
    /// ω_r (xy) and ω_i (zw).
    pub directions: Image,
    /// Albedo of the pigment, linear sRGB; w: falloff of the light, 1 for a distant light. Present if a texture gives
    /// the pigment, if lamps are among the lights, or if another image follows.
    pub albedo: Option<Image>,
    /// Radiance of the surroundings in the mirrored direction. Present if surroundings are among the lights; written
    /// under that light.
    pub mirrored: Option<Image>,
    /// Depth; [`crate::vk::commands::FAR`] at uncovered pixels. With several objects, the stencil holds the object
    /// number, from 1.
    pub depth: Image,
    /// Jacobian of (u, v) = −(ω_i + ω_r).xy: du/dx, dv/dx, du/dy, dv/dy per pixel, x to the right and y downward.
    /// Present if requested; undefined at uncovered pixels.
    pub footprints: Option<Image>,
    /// Settings that the images were made for.
    pub settings: GeometrySettings,
}

impl Geometry {
    /// Makes images of `size` pixels.
    ///
    /// # Errors
    /// Fails if the device is out of memory or does not support images of that size.
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
            // Attachments of a pass must be contiguous.
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

    /// Iterates over the colour images in the order of `geometry.frag`. `mirrors`: including that of the mirrored
    /// radiance.
    pub fn images(&self, mirrors: bool) -> impl Iterator<Item = &Image> {
        let mirrored = self.mirrored.as_ref().filter(|_| mirrors);
        let others = [self.footprints.as_ref(), self.albedo.as_ref(), mirrored];
        std::iter::once(&self.directions).chain(others.into_iter().flatten())
    }
}

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
        other => {
            Err(Error::failed(format!("{other:?} cannot be read back"), "report this as a bug of diffract"))
        }
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
