//! What the optics needs on the device: the layers as a 2D-array texture, the tables, their descriptor set.

use super::interface::{FrameBlock, OpticsBlock, binding, optics_bindings};
use super::shading::Shading;
use super::tables::{Coefficients, Combs};
use super::upload;
use crate::error::Result;
use crate::optics::brdf::schlick;
use crate::precompute::Layers;
use crate::precompute::kernel::Kernel;
use crate::vk::buffer::Buffer;
use crate::vk::descriptors::Descriptors;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::sampler::Sampler;
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::sync::Arc;

/// A pigment texture: linear RGBA, row by row from the top.
#[derive(Clone, Debug)]
pub struct Pigment {
    /// Width and height.
    pub size: [u32; 2],
    /// sRGB-encoded RGBA texels.
    pub texels: Vec<u8>,
}

impl Pigment {
    /// One white texel: no pigment texture.
    pub fn white() -> Self {
        Self { size: [1, 1], texels: vec![255; 4] }
    }
}

/// Everything of set 0, on the device.
pub struct Resources {
    /// The set that pipelines bind.
    pub descriptors: Descriptors,
    /// Camera and lights; written before each frame.
    pub frame: Buffer,
    /// Wavelength combs, for counting what a frame does.
    pub combs: Combs,
    // Held for the descriptor set; fields go in order, so it goes first.
    _layers: Image,
    _pigment: Image,
    _samplers: [Sampler; 2],
    _buffers: [Buffer; 5],
}

impl Resources {
    /// Uploads `layers`, the tables that `shading` asks for, and `pigment`.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(device: &Arc<Device>, layers: &Layers, shading: &Shading, pigment: &Pigment) -> Result<Self> {
        let coefficients = Coefficients::new(layers, shading.tolerance);
        let combs = Combs::new(&shading.illuminant, layers.sigma, shading.tolerance, shading.wavelengths);
        let layer_image = layer_texture(device, layers)?;
        let pigment_image = pigment_texture(device, pigment)?;
        let edge = Sampler::linear(device, "layer sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        let repeat = Sampler::linear(device, "pigment sampler", vk::SamplerAddressMode::REPEAT)?;
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let optics = optics_block(layers, &coefficients, shading.ior);
        let buffers = [
            upload::buffer(device, "optics", uniform, bytemuck::bytes_of(&optics))?,
            upload::buffer(device, "coefficients", storage, bytemuck::cast_slice(&coefficients.values))?,
            upload::buffer(
                device,
                "pairs needed",
                storage,
                bytemuck::cast_slice(&coefficients.pairs_needed),
            )?,
            upload::buffer(device, "combs", storage, bytemuck::cast_slice(&combs.bins))?,
            upload::buffer(device, "nodes", storage, bytemuck::cast_slice(&combs.nodes))?,
        ];
        let frame =
            Buffer::new(device, "frame", size_of::<FrameBlock>() as u64, uniform, MemoryLocation::CpuToGpu)?;
        let descriptors = Descriptors::new(device, "optics set", &optics_bindings())?;
        descriptors.buffer(binding::FRAME, &frame);
        let numbers =
            [binding::OPTICS, binding::COEFFICIENTS, binding::PAIRS_NEEDED, binding::COMBS, binding::NODES];
        for (number, buffer) in numbers.into_iter().zip(&buffers) {
            descriptors.buffer(number, buffer);
        }
        descriptors.image(binding::LAYERS, &layer_image, &edge);
        descriptors.image(binding::PIGMENT, &pigment_image, &repeat);
        Ok(Self {
            descriptors,
            frame,
            combs,
            _layers: layer_image,
            _pigment: pigment_image,
            _samplers: [edge, repeat],
            _buffers: buffers,
        })
    }
}

/// The `Optics` block of `layers`.
pub fn optics_block(layers: &Layers, coefficients: &Coefficients, ior: f64) -> OpticsBlock {
    let pair = |v: [f64; 2]| v.map(|x| x as f32);
    OpticsBlock {
        texture_size: layers.size.map(|n| n as f32),
        origin: layers.origin.map(|n| n as f32 + 0.5),
        texels_per_frequency: pair(layers.length),
        band: pair(layers.band),
        sigma: layers.sigma as f32,
        normal_reflectance: schlick(ior, 1.0) as f32,
        entries_per_z: coefficients.entries_per_z as f32,
        kernel: match layers.interpolation.kernel {
            Kernel::Bilinear => 0,
            Kernel::Bspline => 1,
        },
        pairs: layers.pairs() as i32,
        entries: coefficients.entries() as i32,
        padding: [0; 2],
    }
}

fn layer_texture(device: &Arc<Device>, layers: &Layers) -> Result<Image> {
    let count = layers.pairs() as u32;
    let description = Description {
        name: "layers",
        format: vk::Format::R32G32B32A32_SFLOAT,
        size: layers.size.map(|n| n as u32),
        layers: count,
        array: true,
        usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
    };
    let image = Image::new(device, &description)?;
    upload::image(device, &image, count, bytemuck::cast_slice(&layers.texels))?;
    Ok(image)
}

fn pigment_texture(device: &Arc<Device>, pigment: &Pigment) -> Result<Image> {
    let description = Description {
        name: "pigment",
        format: vk::Format::R8G8B8A8_SRGB,
        size: pigment.size,
        layers: 1,
        array: false,
        usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
    };
    let image = Image::new(device, &description)?;
    upload::image(device, &image, 1, &pigment.texels)?;
    Ok(image)
}
