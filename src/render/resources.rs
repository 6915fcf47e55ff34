//! What the optics needs on the device: the layers as a 2D-array texture, the tables, their descriptor set.

use super::interface::{FrameBlock, OpticsBlock, binding, optics_bindings, specialization};
use super::shading::Shading;
use super::tables::{Combs, Table};
use super::target::Geometry;
use super::upload;
use crate::error::{Error, Result};
use crate::input;
use crate::optics::brdf::schlick;
use crate::precompute::Layers;
use crate::scene::MAX_LIGHTS;
use crate::vk::buffer::Buffer;
use crate::vk::descriptors::Descriptors;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::sampler::Sampler;
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Largest side of a pigment texture \[pixels\].
const MAX_PIGMENT: u32 = 8192;

/// A pigment texture, row by row from the top.
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

    /// The picture in the file `path`.
    ///
    /// # Errors
    /// Where it is no PNG or TIFF of a sensible size.
    pub fn read(path: &Path) -> Result<Self> {
        let mut bytes = Vec::new();
        let file = input::open(path, PIGMENT, input::MAX_TEXT)?;
        file.take(input::MAX_TEXT).read_to_end(&mut bytes).map_err(|e| no_pigment(&e).at(path.display()))?;
        Self::from_bytes(&bytes).map_err(|e| e.at(path.display()))
    }

    /// The picture in the bytes of a file.
    ///
    /// # Errors
    /// Where it is no PNG or TIFF of a sensible size.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        use image::ImageFormat::{Png, Tiff};
        let mut reader = image::ImageReader::new(std::io::Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|e| no_pigment(&e))?;
        if !matches!(reader.format(), Some(Png | Tiff)) {
            return Err(no_pigment(&"neither PNG nor TIFF"));
        }
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(MAX_PIGMENT);
        limits.max_image_height = Some(MAX_PIGMENT);
        reader.limits(limits);
        let picture = reader.decode().map_err(|e| no_pigment(&e))?.to_rgba8();
        Ok(Self { size: [picture.width(), picture.height()], texels: picture.into_raw() })
    }
}

/// What a pigment texture is.
const PIGMENT: &str = "a PNG or TIFF picture for the pigment";

fn no_pigment(cause: &dyn std::fmt::Display) -> Error {
    Error::failed(format!("it cannot be read as a picture ({cause})"), format!("give {PIGMENT}"))
}

/// Everything of set 0, on the device.
pub struct Resources {
    /// The set that pipelines bind.
    pub descriptors: Descriptors,
    /// Camera and lights; written before each frame.
    pub frame: Buffer,
    /// Wavelength combs, for counting what a frame does.
    pub combs: Combs,
    /// What the shaders of the optics are specialised for.
    pub specialization: [u32; 8],
    // Held for the descriptor set; fields go in order, so it goes first.
    _images: [Image; 4],
    edge: Sampler,
    _repeat: Sampler,
    _buffers: [Buffer; 2],
}

impl Resources {
    /// Uploads `layers`, the tables that `shading` asks for, and `pigment`.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(device: &Arc<Device>, layers: &Layers, shading: &Shading, pigment: &Pigment) -> Result<Self> {
        let combs = Combs::new(&shading.illuminant, layers.sigma, shading.quadrature(), shading.wavelengths);
        let float = vk::Format::R32G32B32A32_SFLOAT;
        let table = |name, table: &Table| {
            texture(device, name, float, table.size, None, bytemuck::cast_slice(&table.values))
        };
        let count = layers.count() as u32;
        let pigment_size = pigment.size.map(|n| n as usize);
        let images = [
            texture(device, "layers", float, layers.size, Some(count), bytemuck::cast_slice(&layers.texels))?,
            texture(
                device,
                "coefficients",
                float,
                [layers.coefficients.columns, 1],
                Some(count),
                bytemuck::cast_slice(&layers.coefficients.values),
            )?,
            table("nodes", &combs.nodes)?,
            texture(device, "pigment", vk::Format::R8G8B8A8_SRGB, pigment_size, None, &pigment.texels)?,
        ];
        let edge = Sampler::linear(device, "table sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        let repeat = Sampler::linear(device, "pigment sampler", vk::SamplerAddressMode::REPEAT)?;
        let specialization = specialization(layers);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let optics = optics_block(layers, shading.ior);
        let buffers = [
            upload::buffer(device, "optics", uniform, bytemuck::bytes_of(&optics))?,
            upload::buffer(device, "combs", storage, bytemuck::cast_slice(&combs.bins))?,
        ];
        let frame =
            Buffer::new(device, "frame", size_of::<FrameBlock>() as u64, uniform, MemoryLocation::CpuToGpu)?;
        let descriptors = Descriptors::new(device, "optics set", &optics_bindings())?;
        descriptors.buffer(binding::FRAME, &frame);
        descriptors.buffer(binding::OPTICS, &buffers[0]);
        descriptors.buffer(binding::COMBS, &buffers[1]);
        let numbers = [binding::LAYERS, binding::COEFFICIENTS, binding::NODES, binding::PIGMENT];
        for (number, image) in numbers.into_iter().zip(&images) {
            descriptors.image(number, image, if number == binding::PIGMENT { &repeat } else { &edge });
        }
        // Until a geometry pass is there: some drivers touch every binding of a set, read by the shader or not.
        for number in binding::VIEW_DIRECTIONS..binding::LIGHT_DIRECTIONS + MAX_LIGHTS as u32 {
            descriptors.image(number, &images[3], &edge);
        }
        for number in [binding::QUERIES, binding::ANSWERS] {
            descriptors.buffer(number, &buffers[1]);
        }
        Ok(Self {
            descriptors,
            frame,
            combs,
            specialization,
            _images: images,
            edge,
            _repeat: repeat,
            _buffers: buffers,
        })
    }
}

impl Resources {
    /// Points the set at what the geometry pass writes. The device must not be using the set.
    pub fn read_from(&self, geometry: &Geometry) {
        self.descriptors.image(binding::VIEW_DIRECTIONS, &geometry.view, &self.edge);
        self.descriptors.image(binding::ALBEDOS, &geometry.albedo, &self.edge);
        for light in 0..MAX_LIGHTS {
            // Every binding has to hold something; those beyond the lights are never read.
            let image = geometry.lights.get(light).unwrap_or(&geometry.view);
            self.descriptors.image(binding::LIGHT_DIRECTIONS + light as u32, image, &self.edge);
        }
    }
}

/// The `Optics` block of `layers`.
pub fn optics_block(layers: &Layers, ior: f64) -> OpticsBlock {
    let pair = |v: [f64; 2]| v.map(|x| x as f32);
    OpticsBlock {
        texture_size: layers.size.map(|n| n as f32),
        origin: layers.origin.map(|n| n as f32 + 0.5),
        texels_per_frequency: pair(layers.length),
        band: pair(layers.band),
        sigma: layers.sigma as f32,
        normal_reflectance: schlick(ior, 1.0) as f32,
        bands_per_z: (layers.z_bands as f64 / layers.z_max) as f32,
        last_column: (layers.coefficients.columns - 1) as f32,
        pairs_per_z: layers.pairs_needed.slope as f32,
        fewest_pairs: layers.pairs_needed.fewest as f32,
        padding: [0.0; 2],
    }
}

/// A texture that holds tightly packed `data`, ready for shaders; an array where `layers` says of how many.
fn texture(
    device: &Arc<Device>,
    name: &str,
    format: vk::Format,
    size: [usize; 2],
    layers: Option<u32>,
    data: &[u8],
) -> Result<Image> {
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let size = size.map(|n| n as u32);
    let (array, layers) = (layers.is_some(), layers.unwrap_or(1));
    let image = Image::new(device, &Description { name, format, size, layers, array, usage })?;
    upload::image(device, &image, layers, data)?;
    Ok(image)
}
