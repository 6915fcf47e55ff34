//! G-buffer: images of the surface that pixels see, whatever the light. `shaders/gbuffer.glsl` describes their texels.

use super::target::{DEPTH, DEPTH_AND_OBJECT};
use crate::error::Result;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use ash::vk;
use std::sync::Arc;

/// Format of the colour images: directions and positions in the precision of the reference they are compared with.
const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Clear value of the images: outside the range of the projection (`UNCOVERED` of `shaders/gbuffer.glsl`).
pub const UNCOVERED: f32 = 100.0;

/// Settings of a G-buffer, which follow from the objects and their sources.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GBufferSettings {
    /// True if a texture gives the pigment.
    pub textured: bool,
    /// True if there are several objects, so that the object number is written beside the depth.
    pub several: bool,
}

impl GBufferSettings {
    /// Returns the format of the depth.
    pub fn depth_format(&self) -> vk::Format {
        if self.several { DEPTH_AND_OBJECT } else { DEPTH }
    }
}

/// Images of the surface that pixels see.
pub struct GBuffer {
    /// Direction to the viewer and normal of the triangle.
    pub facing: Image,
    /// Rotation to the frame of the patch.
    pub orientation: Image,
    /// Rotation of the frame to the next pixel to the right, and downward. The position is in w of these and of
    /// `orientation`.
    pub curving: [Image; 2],
    /// Albedo of the pigment, linear sRGB, if a texture gives it.
    pub albedo: Option<Image>,
    /// Depth; [`crate::vk::commands::FAR`] at uncovered pixels. With several objects, the stencil holds the object
    /// number, from 1.
    pub depth: Image,
    /// Settings that the images were made for.
    pub settings: GBufferSettings,
}

impl GBuffer {
    /// Makes images of `size` pixels.
    ///
    /// # Errors
    /// Fails if the device is out of memory or does not support images of that size.
    pub fn new(device: &Arc<Device>, size: [u32; 2], settings: GBufferSettings) -> Result<Self> {
        use vk::ImageUsageFlags as Usage;
        let make = |name, format, usage| {
            Image::new(device, &Description { name, format, size, layers: 1, array: false, usage })
        };
        let color = |name| make(name, FORMAT, Usage::COLOR_ATTACHMENT | Usage::TRANSFER_SRC | Usage::SAMPLED);
        let depth_usage = Usage::DEPTH_STENCIL_ATTACHMENT | Usage::TRANSFER_SRC;
        Ok(Self {
            facing: color("facing")?,
            orientation: color("orientation")?,
            curving: [color("curving right")?, color("curving down")?],
            albedo: settings.textured.then(|| color("albedos")).transpose()?,
            depth: make("depth", settings.depth_format(), depth_usage)?,
            settings,
        })
    }

    /// Returns width and height \[pixels\].
    pub fn size(&self) -> [u32; 2] {
        self.facing.size()
    }

    /// Iterates over the colour images in the order of `geometry.frag`.
    pub fn images(&self) -> impl Iterator<Item = &Image> {
        [&self.facing, &self.orientation].into_iter().chain(&self.curving).chain(&self.albedo)
    }
}
