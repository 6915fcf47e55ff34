//! Descriptor set 0 of the graphics stages: the frame, the pigment and the G-buffer. Its twins are
//! `shaders/frame.glsl` and `shaders/gbuffer.glsl`.

use super::gbuffer::GBuffer;
use super::grooves::GrooveDirections;
use super::pigment::Pigment;
use super::surroundings::Surroundings;
use super::upload;
use crate::error::Result;
use crate::scene::environment::Environment;
use crate::scene::incident::{Emits, Incident};
use crate::vk::buffer::Buffer;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::sampler::Sampler;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use gpu_allocator::MemoryLocation;
use std::sync::Arc;

/// Largest number of lights that are drawn together. Their depth maps take up to 16 MiB each.
pub const MOST_LIGHTS: usize = 8;
/// Number of lights in a `Frame` block, a power of two: [`MOST_LIGHTS`], or directions of the surroundings among which
/// pixels choose ([`super::light_passes::Choices`]). Nine neighbouring pixels and four passes then see about all of them.
pub const LIGHT_SLOTS: usize = 32;

/// The `Frame` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FrameBlock {
    /// World to clip space, column by column.
    pub clip_from_world: [[f32; 4]; 4],
    /// Position of the viewer; w unused.
    pub viewer: [f32; 4],
    /// Albedo of the pigment; w: 1 if the texture is used.
    pub base_color: [f32; 4],
    /// Cosine and sine of the angle by which the patch is turned, if the angle is constant over the object; size of a
    /// pixel in clip space.
    pub grooves: [f32; 4],
    /// Orientation and scale of the surroundings: cosine and sine of their rotation, value of a stored 1, and variance
    /// of (u, v) of the specular order.
    pub surroundings: [f32; 4],
    /// Sample of the picture.
    pub sample: SampleBlock,
    /// Lights that are drawn together, or directions of one light; unused ones are 0.
    pub lights: [LightBlock; LIGHT_SLOTS],
}

/// Sample of a light (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightBlock {
    /// Unit vector to the light and the variance of the directions it represents; for a lamp, a point and the variance
    /// of its points.
    pub toward: [f32; 4],
    /// Kind of emitter: see [`LightBlock::emitter_of`].
    pub emitter: [f32; 4],
    /// Irradiance over π of a surface that faces the light, linear sRGB; for a lamp, at distance 1. w: weight of the
    /// mirrored radiance of surroundings, if the light is drawn from them.
    pub irradiance: [f32; 4],
    /// World to the clip space of the light's depth map, column by column.
    pub shadow_from_world: [[f32; 4]; 4],
}

impl LightBlock {
    /// Returns `emitter` of a light sample: w is 0 for a distant light (x: [`Incident::mean`]), 1 for a lamp that emits in
    /// all directions (xyz: its centre), and 2 for a lamp that emits to one side (xyz: its normal).
    pub fn emitter_of(incident: &Incident) -> [f32; 4] {
        match incident.place.map(|place| place.emits) {
            None => [incident.mean as f32, 0.0, 0.0, 0.0],
            Some(Emits::AllAround { middle }) => middle.as_vec3().extend(1.0).to_array(),
            Some(Emits::ToOneSide { normal }) => normal.as_vec3().extend(2.0).to_array(),
        }
    }
}

/// Sample of a picture, as in [`super::sampling::Sample`] (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SampleBlock {
    /// Position in the pixel, from its centre: x to the right, y downward \[pixels\].
    pub jitter: [f32; 2],
    /// Standard deviation of the part of the pixel filter that shading averages over \[pixels\].
    pub footprint: f32,
    /// Number of the sample, from 0, counting those that draw the light.
    pub index: u32,
    /// Number of samples in the picture that draw the light.
    pub count: u32,
    /// Low bits of the sequence's seed.
    pub seed: u32,
    /// [`super::light_passes::Choices::turn`]; 0 if pixels do not choose.
    pub turn: u32,
    /// [`super::light_passes::Choices::parts`].
    pub parts: u32,
}

/// Binding numbers.
pub mod binding {
    /// [`super::FrameBlock`].
    pub const FRAME: u32 = 0;
    /// Pigment texture.
    pub const PIGMENT: u32 = 1;
    /// [`super::GBuffer::facing`], the first of the G-buffer's images.
    pub const FACING: u32 = 2;
    /// [`super::GBuffer::orientation`].
    pub const ORIENTATION: u32 = 3;
    /// [`super::GBuffer::curving`].
    pub const CURVING: [u32; 2] = [4, 5];
    /// Depth from the lights.
    pub const SHADOW: u32 = 6;
    /// Picture of the surroundings.
    pub const SURROUNDINGS: u32 = 7;
    /// Map of groove directions.
    pub const GROOVES: u32 = 8;
    /// [`super::GBuffer::albedo`].
    pub const ALBEDOS: u32 = 9;
    /// Depth from directions of the surroundings.
    pub const SKY_SHADOW: u32 = 10;
}

/// Descriptor set 0 and the buffers and images bound to it.
pub struct FrameSet {
    /// Descriptor set of the pipelines.
    pub descriptors: Descriptors,
    frame: Buffer,
    _pigment: Image,
    _grooves: Image,
    _repeat: Sampler,
    edge: Sampler,
    nearest: Sampler,
    // Stands in for missing depth maps.
    unshadowed: Image,
    environment_sampler: Sampler,
    surroundings: Option<Arc<Surroundings>>,
}

impl FrameSet {
    /// Makes the set of a frame with `pigment`, `grooves` and the images of `gbuffer`.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(
        device: &Arc<Device>,
        pigment: &Pigment,
        grooves: &GrooveDirections,
        gbuffer: &GBuffer,
    ) -> Result<Self> {
        use vk::DescriptorType as T;
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        let images =
            (binding::PIGMENT..=binding::SKY_SHADOW).map(|number| (number, T::COMBINED_IMAGE_SAMPLER));
        let bindings: Vec<Binding> = std::iter::once((binding::FRAME, T::UNIFORM_BUFFER))
            .chain(images)
            .map(|(number, kind)| Binding { number, kind, stages })
            .collect();
        let size = pigment.size.map(|n| n as usize);
        let format = vk::Format::R8G8B8A8_SRGB;
        let image = upload::texture(device, "pigment", format, size, None, &pigment.texels)?;
        let (format, turns) = (vk::Format::R16G16_SFLOAT, bytemuck::cast_slice(&grooves.texels));
        let size = grooves.size.map(|n| n as usize);
        let directions = upload::texture(device, "groove directions", format, size, None, turns)?;
        let edge = Sampler::linear(device, "pixel sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        let nearest = Sampler::nearest(device, "shadow sampler")?;
        let repeat = Sampler::linear(device, "pigment sampler", vk::SamplerAddressMode::REPEAT)?;
        let unshadowed =
            upload::texture(device, "no shadow", vk::Format::R8G8B8A8_UNORM, [1, 1], Some(1), &[u8::MAX; 4])?;
        let bytes = size_of::<FrameBlock>() as u64;
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let frame = Buffer::new(device, "frame", bytes, uniform, MemoryLocation::CpuToGpu)?;
        let descriptors = Descriptors::new(device, "frame set", &bindings)?;
        descriptors.buffer(binding::FRAME, &frame);
        descriptors.image(binding::PIGMENT, &image, &repeat);
        descriptors.image(binding::GROOVES, &directions, &repeat);
        let environment_sampler = Sampler::equirectangular(device, "sampler of surroundings")?;
        // Every binding needs an image; unused ones are never read.
        descriptors.image(binding::SURROUNDINGS, &image, &environment_sampler);
        let set = Self {
            descriptors,
            frame,
            _pigment: image,
            _grooves: directions,
            _repeat: repeat,
            edge,
            nearest,
            unshadowed,
            environment_sampler,
            surroundings: None,
        };
        set.read_from(gbuffer);
        set.descriptors.image(binding::SHADOW, &set.unshadowed, &set.nearest);
        set.descriptors.image(binding::SKY_SHADOW, &set.unshadowed, &set.nearest);
        Ok(set)
    }

    /// Points the set at the images of `gbuffer`. The device must not be using the set.
    pub fn read_from(&self, gbuffer: &GBuffer) {
        let [right, down] = &gbuffer.curving;
        let images = [
            (binding::FACING, &gbuffer.facing),
            (binding::ORIENTATION, &gbuffer.orientation),
            (binding::CURVING[0], right),
            (binding::CURVING[1], down),
            (binding::ALBEDOS, gbuffer.albedo.as_ref().unwrap_or(&gbuffer.facing)),
        ];
        for (number, image) in images {
            self.descriptors.image(number, image, &self.edge);
        }
    }

    /// Points `number`, [`binding::SHADOW`] or [`binding::SKY_SHADOW`], at depth maps. The device must not be using the set.
    pub fn read_shadow(&self, number: u32, maps: &Image) {
        self.descriptors.image(number, maps, &self.nearest);
    }

    /// Uploads the picture of `environment` unless it is there already, and points the set at it. Returns the radiance
    /// of a stored 1. The device must not be using the set.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn bind_environment(&mut self, device: &Arc<Device>, environment: &Environment) -> Result<f32> {
        if let Some(there) = self.surroundings.as_ref().filter(|there| there.show(environment)) {
            return Ok(there.unit);
        }
        let surroundings = Arc::new(Surroundings::new(device, environment)?);
        let unit = surroundings.unit;
        self.read_surroundings(surroundings);
        Ok(unit)
    }

    /// Points the set at the picture of surroundings that `other` reads, unless it reads it already. The device must
    /// not be using the set.
    pub fn share_surroundings(&mut self, other: &Self) {
        let same = |there: &Arc<Surroundings>| {
            self.surroundings.as_ref().is_some_and(|bound| Arc::ptr_eq(bound, there))
        };
        if let Some(there) = other.surroundings.as_ref().filter(|there| !same(there)) {
            self.read_surroundings(there.clone());
        }
    }

    fn read_surroundings(&mut self, surroundings: Arc<Surroundings>) {
        self.descriptors.image(binding::SURROUNDINGS, &surroundings.image, &self.environment_sampler);
        self.surroundings = Some(surroundings);
    }

    /// Points binding `number` of another set at the block.
    pub fn share_block(&self, set: &Descriptors, number: u32) {
        set.buffer(number, &self.frame);
    }

    /// Writes the block of the next frame. The device must not be using the set.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn write(&mut self, block: &FrameBlock) -> Result<()> {
        self.frame.write(bytemuck::bytes_of(block))
    }
}
