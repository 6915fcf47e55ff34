//! What the optics needs on the device: the layers as a 2D-array texture, the tables, their descriptor set.

mod shade_by;

use super::color_table::{ColorTable, Filter, grid::LEVELS, pyramid::in_layers};
use super::interface::{
    CopiesBlock, FrameBlock, LinesBlock, MORE_LIGHTS, OpticsBlock, TableBlock, binding, geometry_bindings,
    optics_bindings, specialization, table_specialization,
};
use super::pigment::Pigment;
use super::shading::Shading;
use super::tables::{Combs, Table};
use super::target::Geometry;
use super::upload;
use crate::error::Result;
use crate::optics::brdf::schlick;
use crate::optics::orders::{Colours, Repeats};
use crate::optics::sliding::Sliding;
use crate::precompute::Layers;
use crate::precompute::texels::Texels;
use crate::precompute::thesis;
use crate::scene::MAX_LIGHTS;
use crate::vk::buffer::Buffer;
use crate::vk::descriptors::Descriptors;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::sampler::Sampler;
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::sync::Arc;

/// What shaders shade from.
#[derive(Clone, Copy)]
pub enum Optics<'a> {
    /// Layers, whose spectrum is summed for every pixel.
    Layers(&'a Layers),
    /// Layers of one period, which repeats so many times.
    Repeats(&'a Layers, Repeats),
    /// What [`crate::precompute::thesis`] makes, for heights of so large a half range \[µm\]: to compare with.
    Thesis(&'a Layers, f64),
    /// A colour table, and how a picture reads it.
    Table(&'a ColorTable, Filter),
}

impl<'a> From<&'a Layers> for Optics<'a> {
    fn from(layers: &'a Layers) -> Self {
        Self::Layers(layers)
    }
}

impl<'a> From<&'a ColorTable> for Optics<'a> {
    fn from(table: &'a ColorTable) -> Self {
        Self::Table(table, Filter::default())
    }
}

/// Which of them is on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reads {
    /// Layers.
    #[default]
    Layers,
    /// A colour table.
    Table,
}

impl Reads {
    /// The word for the method on the command line and in reports.
    pub fn method(self) -> &'static str {
        match self {
            Self::Layers => "spectral",
            Self::Table => "table",
        }
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
    /// What the shaders of the optics are specialised for.
    pub specialization: Vec<u32>,
    /// What the shaders read.
    pub reads: Reads,
    /// How the patch repeats, where the layers are of one period.
    pub copies: Option<CopiesBlock>,
    /// Half the range of heights \[µm\], where the layers are those of the thesis.
    pub thesis: Option<f32>,
    // Whether a table is averaged over pixels.
    averages: bool,
    // Held for the descriptor set; fields go in order, so it goes first.
    images: Vec<Image>,
    edge: Sampler,
    _samplers: Vec<Sampler>,
    buffers: Vec<Buffer>,
}

impl Resources {
    /// Uploads `optics`, the small tables that `shading` asks for, and `pigment`.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new<'a>(
        device: &Arc<Device>,
        optics: impl Into<Optics<'a>>,
        shading: &Shading,
        pigment: &Pigment,
    ) -> Result<Self> {
        match optics.into() {
            Optics::Layers(layers) => {
                let combs = Combs::of(layers, shading);
                Self::of_layers(device, (layers, layers.sigma), combs, shading, pigment)
            }
            Optics::Repeats(layers, repeats) => {
                let (block, combs) = repeated(&repeats, shading);
                let optics = (layers, repeats.sigma());
                let resources = Self::of_layers(device, optics, combs, shading, pigment)?;
                Ok(Self { copies: Some(block), ..resources })
            }
            Optics::Thesis(layers, half_range) => {
                let combs = Combs::even_wavelengths(&shading.illuminant, thesis::WAVELENGTHS);
                let resources = Self::of_layers(device, (layers, layers.sigma), combs, shading, pigment)?;
                Ok(Self { thesis: Some(half_range as f32), ..resources })
            }
            Optics::Table(table, filter) => Self::of_table(device, table, filter, shading, pigment),
        }
    }

    fn of_layers(
        device: &Arc<Device>,
        (layers, sigma): (&Layers, f64),
        combs: Combs,
        shading: &Shading,
        pigment: &Pigment,
    ) -> Result<Self> {
        let float = vk::Format::R32G32B32A32_SFLOAT;
        let count = layers.count() as u32;
        let pigment_size = pigment.size.map(|n| n as usize);
        let [lines, packed_lines] = lines_textures(device, layers)?;
        let images = vec![
            texture(
                device,
                "layers",
                format(&layers.texels),
                layers.size,
                Some(count),
                layers.texels.bytes(),
            )?,
            texture(
                device,
                "coefficients",
                float,
                [layers.coefficients.columns, 1],
                Some(count),
                bytemuck::cast_slice(&layers.coefficients.values),
            )?,
            numbers(device, "nodes", &combs.nodes)?,
            texture(device, "pigment", vk::Format::R8G8B8A8_SRGB, pigment_size, None, &pigment.texels)?,
            lines,
            numbers(device, "weights of lines", &combs.line_weights())?,
            packed_lines,
        ];
        let edge = Sampler::linear(device, "table sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        let repeat = Sampler::linear(device, "pigment sampler", vk::SamplerAddressMode::REPEAT)?;
        let nearest = Sampler::nearest(device, "integer sampler")?;
        let specialization = specialization(layers);
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let optics = optics_block(layers, sigma, shading.ior);
        let buffers = vec![
            upload::buffer(device, "optics", uniform, bytemuck::bytes_of(&optics))?,
            upload::buffer(device, "combs", storage, bytemuck::cast_slice(&combs.bins))?,
            upload::buffer(device, "lines", uniform, bytemuck::bytes_of(&lines_block(layers, &combs)))?,
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
        for number in geometry_bindings() {
            descriptors.image(number, &images[3], &edge);
        }
        for number in [binding::QUERIES, binding::ANSWERS] {
            descriptors.buffer(number, &buffers[1]);
        }
        descriptors.image(binding::COLOR_TABLE, &images[0], &edge);
        descriptors.buffer(binding::TABLE, &buffers[0]);
        descriptors.image(binding::LINES, &images[4], &edge);
        descriptors.image(binding::PACKED_LINES, &images[6], &nearest);
        descriptors.image(binding::LINE_WEIGHTS, &images[5], &edge);
        descriptors.buffer(binding::LINES_BLOCK, &buffers[2]);
        Ok(Self {
            descriptors,
            frame,
            combs,
            specialization,
            reads: Reads::Layers,
            copies: None,
            thesis: None,
            averages: false,
            images,
            edge,
            _samplers: vec![repeat, nearest],
            buffers,
        })
    }

    /// The layers that a table was made from are not needed. What only they need is bound to something else that is there.
    fn of_table(
        device: &Arc<Device>,
        table: &ColorTable,
        filter: Filter,
        shading: &Shading,
        pigment: &Pigment,
    ) -> Result<Self> {
        let grid = &table.grid;
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let (texels, layers) = grid.texture(filter);
        let (size, layers) = (texels.map(|n| n as u32), layers as u32);
        let format = vk::Format::R16G16B16A16_SFLOAT;
        let description = Description { name: "colour table", format, size, layers, array: true, usage };
        let image = match filter {
            Filter::Point => {
                let image = Image::new(device, &description)?;
                upload::image(device, &image, layers, bytemuck::cast_slice(&table.levels[0]))?;
                image
            }
            Filter::Pixel => {
                let image = Image::with_levels(device, &description, LEVELS as u32)?;
                let finest = in_layers(grid, &table.levels[0]);
                let levels = std::iter::once(&finest).chain(&table.levels[1..]);
                let levels: Vec<&[u8]> = levels.map(|level| bytemuck::cast_slice(level)).collect();
                upload::levels(device, &image, layers, &levels)?;
                image
            }
        };
        let pigment_size = pigment.size.map(|n| n as usize);
        let images = vec![
            image,
            texture(device, "pigment", vk::Format::R8G8B8A8_SRGB, pigment_size, None, &pigment.texels)?,
            no_packed_lines(device)?,
        ];
        let nearest = Sampler::nearest(device, "integer sampler")?;
        let edge = Sampler::linear(device, "table sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        let repeat = Sampler::linear(device, "pigment sampler", vk::SamplerAddressMode::REPEAT)?;
        let name = "colour table sampler";
        let levels = match filter {
            // Of one level there is nothing to choose, and devices need not look.
            Filter::Point => Sampler::linear(device, name, vk::SamplerAddressMode::CLAMP_TO_EDGE)?,
            Filter::Pixel => Sampler::trilinear(device, name)?,
        };
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let optics = table_optics_block(table, filter, shading.ior);
        let block = TableBlock {
            texture_per_uv: (1.0 / (grid.spacing * grid.side as f64)) as f32,
            texels_per_uv: (1.0 / grid.spacing) as f32,
            unit: table.unit,
            finest: OWN_WIDTH,
            pieces: grid.pieces as f32,
            near: grid.near().extent() as f32,
            near_texture_per_uv: (1.0 / (grid.near().spacing * grid.side as f64)) as f32,
            near_centre: (grid.near().side as f64 / 2.0 / grid.side as f64) as f32,
        };
        let buffers = vec![
            upload::buffer(device, "optics", uniform, bytemuck::bytes_of(&optics))?,
            upload::buffer(device, "table", uniform, bytemuck::bytes_of(&block))?,
            upload::buffer(device, "no combs", storage, &[0; 16])?,
        ];
        let frame =
            Buffer::new(device, "frame", size_of::<FrameBlock>() as u64, uniform, MemoryLocation::CpuToGpu)?;
        let descriptors = Descriptors::new(device, "optics set", &optics_bindings())?;
        descriptors.buffer(binding::FRAME, &frame);
        descriptors.buffer(binding::OPTICS, &buffers[0]);
        descriptors.buffer(binding::TABLE, &buffers[1]);
        for number in [binding::COMBS, binding::QUERIES, binding::ANSWERS] {
            descriptors.buffer(number, &buffers[2]);
        }
        descriptors.image(binding::COLOR_TABLE, &images[0], &levels);
        descriptors.image(binding::PIGMENT, &images[1], &repeat);
        let of_layers = [binding::COEFFICIENTS, binding::LAYERS, binding::NODES];
        let of_lines = [binding::LINES, binding::LINE_WEIGHTS];
        for number in of_layers.into_iter().chain(of_lines).chain(geometry_bindings()) {
            descriptors.image(number, &images[0], &edge);
        }
        descriptors.buffer(binding::LINES_BLOCK, &buffers[0]);
        descriptors.image(binding::PACKED_LINES, &images[2], &nearest);
        Ok(Self {
            descriptors,
            frame,
            combs: Combs::none(),
            specialization: table_specialization(grid, filter),
            reads: Reads::Table,
            copies: None,
            thesis: None,
            averages: filter == Filter::Pixel,
            images,
            edge,
            _samplers: vec![repeat, levels, nearest],
            buffers,
        })
    }
}

impl Resources {
    /// Whether shading asks which pixels are covered, beyond the depth test. Only the sample of a table at a pixel's centre does not: a sum
    /// over wavelengths may go on for any time on the lanes of a pixel beside the mesh, and averages look at neighbours.
    pub fn asks_what_is_covered(&self) -> bool {
        self.reads == Reads::Layers || self.averages
    }

    /// Points the set at what the geometry pass writes. The device must not be using the set.
    pub fn read_from(&self, geometry: &Geometry) {
        // Every binding has to hold something; what there is none of is never read.
        let there = &geometry.directions;
        self.descriptors.image(binding::DIRECTIONS, there, &self.edge);
        self.descriptors.image(binding::ALBEDOS, geometry.albedo.as_ref().unwrap_or(there), &self.edge);
        for place in 0..MORE_LIGHTS {
            let image = geometry.more_lights.get(place as usize).unwrap_or(there);
            self.descriptors.image(binding::MORE_LIGHTS + place, image, &self.edge);
        }
        for light in 0..MAX_LIGHTS {
            let image = geometry.footprints.get(light).unwrap_or(there);
            self.descriptors.image(binding::FOOTPRINTS + light as u32, image, &self.edge);
        }
    }
}

/// A linear sample of averages over Δ is the average over a box and a tent, with the variance Δ²/4; a footprint of width F has
/// F²/12. So a footprint asks for Δ = F/√3: log₂(1/√3) levels below F.
const OWN_WIDTH: f32 = -0.792_481_25;

/// The `Optics` block of `layers` that are seen as through a Gaussian of standard deviation `sigma` \[µm\].
pub fn optics_block(layers: &Layers, sigma: f64, ior: f64) -> OpticsBlock {
    let pair = |v: [f64; 2]| v.map(|x| x as f32);
    OpticsBlock {
        texture_size: layers.size.map(|n| n as f32),
        origin: layers.origin.map(|n| n as f32 + 0.5),
        texels_per_frequency: pair(layers.length),
        band: pair(layers.band),
        // The shaders square what they read, and multiply by σ².
        sigma: sigma as f32 * layers.texels.unit(),
        normal_reflectance: schlick(ior, 1.0) as f32,
        bands_per_z: (layers.z_bands as f64 / layers.z_max) as f32,
        last_column: (layers.coefficients.columns - 1) as f32,
        pairs_per_z: layers.pairs_needed.slope as f32,
        fewest_pairs: layers.pairs_needed.fewest as f32,
        padding: [0.0; 2],
    }
}

/// The `Optics` block of a table: what is read of the layers, by the probe, is the table.
fn table_optics_block(table: &ColorTable, filter: Filter, ior: f64) -> OpticsBlock {
    let (texels, _) = table.grid.texture(filter);
    OpticsBlock {
        texture_size: texels.map(|n| n as f32),
        origin: texels.map(|n| n as f32 / 2.0),
        sigma: table.sigma as f32,
        normal_reflectance: schlick(ior, 1.0) as f32,
        ..OpticsBlock::default()
    }
}

/// The `Lines` block of `layers` and the weights of `combs`.
fn lines_block(layers: &Layers, combs: &Combs) -> LinesBlock {
    let (Some(lines), Some(sliding)) = (&layers.lines, &combs.sliding) else { return LinesBlock::default() };
    let pair = |v: [f64; 2]| v.map(|x| x as f32);
    let [first, last] = sliding.columns;
    LinesBlock {
        across: pair(lines.across),
        along: pair(lines.along),
        origin: lines.origin.map(|n| n as f32),
        from: lines.from as f32,
        unit: (lines.texels.unit() / layers.texels.unit()).powi(2),
        first_column: first as f32,
        columns_per_wavenumber: (Sliding::COLUMNS as f64 / (last - first)) as f32,
        first_row: sliding.steps.0.log2() as f32,
        rows_per_octave: (1.0 / sliding.steps.1) as f32,
        last_column: (Sliding::COLUMNS - 1) as f32,
        nearest: lines.nearest() as f32,
        padding: [0.0; 2],
        near: std::array::from_fn(|octave| {
            let [point, line] = lines.near.get(octave).copied().unwrap_or_default();
            [point as f32, line as f32, 0.0, 0.0]
        }),
    }
}

/// What `shaders/repeats.glsl` takes, and the colour functions in place of combs.
fn repeated(repeats: &Repeats, shading: &Shading) -> (CopiesBlock, Combs) {
    let tolerance = shading.quadrature();
    let colours = Colours::new(&shading.illuminant, tolerance);
    let block = CopiesBlock {
        count: repeats.copies.map(|n| n as f32),
        period: repeats.period.map(|x| x as f32),
        colour_lag: colours.lag as f32,
        tolerance: tolerance as f32,
        queries: 0,
    };
    (block, Combs::densities(&colours))
}

/// A table as a texture.
fn numbers(device: &Arc<Device>, name: &str, table: &Table) -> Result<Image> {
    let float = vk::Format::R32G32B32A32_SFLOAT;
    texture(device, name, float, table.size, None, bytemuck::cast_slice(&table.values))
}

/// Two pairs of terms, of 16-bit floats.
const TWO_PAIRS: vk::Format = vk::Format::R32G32B32A32_UINT;

/// What stands for packed lines where there are none: a binding of integers has to hold integers, read or not.
fn no_packed_lines(device: &Arc<Device>) -> Result<Image> {
    texture(device, "no packed lines", TWO_PAIRS, [1, 1], Some(1), &[0; 16])
}

/// The lines of `layers`, one pair of terms to a texel and two: of these, what there is none of is one texel.
fn lines_textures(device: &Arc<Device>, layers: &Layers) -> Result<[Image; 2]> {
    let lines_of = |packed: bool| -> Result<Image> {
        match layers.lines.as_ref().filter(|lines| lines.are_packed() == packed) {
            Some(lines) => {
                let (format, to_a_texel) = if packed { (TWO_PAIRS, 2) } else { (format(&lines.texels), 1) };
                let size = [lines.size[0] * lines.grouped / to_a_texel, lines.size[1]];
                let count = lines.layers(layers.pairs(), layers.z_bands) as u32;
                texture(device, "lines", format, size, Some(count), lines.texels.bytes())
            }
            None if packed => no_packed_lines(device),
            None => texture(device, "no lines", vk::Format::R8G8B8A8_UNORM, [1, 1], Some(1), &[0; 4]),
        }
    };
    Ok([lines_of(false)?, lines_of(true)?])
}

/// The format of `texels`.
fn format(texels: &Texels) -> vk::Format {
    if texels.is_half() { vk::Format::R16G16B16A16_SFLOAT } else { vk::Format::R32G32B32A32_SFLOAT }
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
