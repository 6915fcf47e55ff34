//! Spectra through one Gaussian window, summed over wavelengths. Its twin is `shaders/source_window.glsl`.

use super::bound::{BoundSource, Kind, uniform};
use super::cost::Cost;
use super::spectra::{self, edge, largest_wavenumber, numbers};
use super::{Summary, stages};
use crate::error::Result;
use crate::optics::sliding::Sliding;
use crate::precompute::Layers;
use crate::precompute::kernel::Kernel;
use crate::precompute::near::OCTAVES;
use crate::render::picture::Directions;
use crate::render::shading::Shading;
use crate::render::tables::Combs;
use crate::render::upload;
use crate::vk::buffer::Buffer;
use crate::vk::device::Device;
use crate::vk::pipeline::Constant;
use crate::vk::sampler::Sampler;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Spectra through a window.
#[derive(Clone, Debug)]
pub struct Window {
    /// The spectra.
    pub layers: Arc<Layers>,
}

/// Binding numbers of set 1 behind those of [`spectra::binding`].
mod binding {
    pub const COMBS: u32 = 4;
    pub const LINES_BLOCK: u32 = 5;
    pub const LINES: u32 = 6;
    pub const PACKED_LINES: u32 = 7;
    pub const LINE_WEIGHTS: u32 = 8;
}

const KINDS: [Kind; 5] = [
    Kind::STORAGE_BUFFER,
    Kind::UNIFORM_BUFFER,
    Kind::COMBINED_IMAGE_SAMPLER,
    Kind::COMBINED_IMAGE_SAMPLER,
    Kind::COMBINED_IMAGE_SAMPLER,
];

/// The `Lines` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LinesBlock {
    /// L across the lines of constant f_x and of constant f_y \[µm\].
    pub across: [f32; 2],
    /// L along them \[µm\].
    pub along: [f32; 2],
    /// Number of the point and of the line of f = 0.
    pub origin: [f32; 2],
    /// max(|u|, |v|) from which on lines are read.
    pub from: f32,
    /// Intensities on lines over those of the plane.
    pub unit: f32,
    /// First wavenumber of the weights \[µm⁻¹\].
    pub first_column: f32,
    /// Columns of the weights per wavenumber \[µm\].
    pub columns_per_wavenumber: f32,
    /// log₂ of the first row's distance of nodes \[µm⁻¹\].
    pub first_row: f32,
    /// Rows of the weights per octave of the distance.
    pub rows_per_octave: f32,
    /// Number of the last column.
    pub last_column: f32,
    /// max(|u|, |v|) that rays nearer to the mirror direction are taken for.
    pub nearest: f32,
    /// std140 aligns vectors of four to 16 bytes.
    pub padding: [f32; 2],
    /// Number of the point and of the line of f = 0 for each octave of rays below `from`; z, w unused.
    pub near: [[f32; 4]; OCTAVES],
}

impl Window {
    pub(super) fn bind(&self, device: &Arc<Device>, shading: &Shading) -> Result<BoundSource> {
        let layers = &self.layers;
        let kinds = [spectra::KINDS.as_slice(), &KINDS].concat();
        let constants = [spectra::constants(layers), line_constants(layers)].concat();
        let mut bound = BoundSource::new(device, "window set", &kinds, stages!("window"), constants)?;
        bound.spectral = layers.lines.is_none();
        spectra::upload(device, &mut bound, layers)?;
        upload_lines(device, &mut bound, layers)?;
        self.set(device, &mut bound, shading)?;
        Ok(bound)
    }

    pub(super) fn set(&self, device: &Arc<Device>, bound: &mut BoundSource, shading: &Shading) -> Result<()> {
        let layers = &self.layers;
        let combs = Combs::of(layers, shading);
        let of = (&**layers, layers.sigma);
        let (mut tables, mut buffers) = spectra::settings(device, of, shading.ior, &combs.nodes)?;
        tables.push((binding::LINE_WEIGHTS, numbers(device, "weights of lines", &combs.line_weights())?));
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let bins = Buffer::with_data(device, "combs", storage, bytemuck::cast_slice(&combs.bins))?;
        buffers.push((binding::COMBS, bins));
        buffers.push((binding::LINES_BLOCK, uniform(device, "lines block", &lines_block(layers, &combs))?));
        bound.replace(device, tables, buffers)
    }

    pub(super) fn summary(&self, shading: &Shading) -> Summary {
        let layers = &self.layers;
        let kernel = match &layers.lines {
            Some(lines) => format!("{} along lines", lines.kernel.name()),
            None => format!("{} kernel", layers.interpolation.name()),
        };
        let (terms, basis) = (layers.terms, shading.basis);
        Summary { method: "spectral", basis, terms, layers: layers.pairs(), kernel }
    }

    pub(super) fn cost(&self, shading: &Shading, directions: &[Directions]) -> Cost {
        let (layers, combs) = (&self.layers, Combs::of(&self.layers, shading));
        let per_read = layers.interpolation.samples() as usize;
        Cost::counted(directions, |pair| {
            let along = pair.uvw().truncate().abs();
            if let (Some(lines), Some(sliding)) = (&layers.lines, &combs.sliding) {
                let (_, per) = lines.crossed(along.to_array());
                let numbers = sliding.nodes(per, largest_wavenumber(layers, pair));
                return spectra::counted(layers, pair, 1, numbers.map(|m| m as f64 / per));
            }
            let nodes = combs.nodes_at(along.length()).iter().map(|node| f64::from(node[3]));
            spectra::counted(layers, pair, per_read, nodes)
        })
    }
}

/// Specialisation constants of `shaders/lines.glsl`.
fn line_constants(layers: &Layers) -> Vec<Constant> {
    const LINES: u32 = 20;
    const GROUPED: u32 = 21;
    const CUBIC_LINES: u32 = 22;
    const PACKED: u32 = 23;
    let Some(lines) = &layers.lines else { return Vec::new() };
    vec![
        Constant::new(LINES, true),
        Constant::new(GROUPED, lines.grouped as u32),
        Constant::new(CUBIC_LINES, lines.kernel == Kernel::Cubic),
        Constant::new(PACKED, lines.are_packed()),
    ]
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

/// Two pairs of terms, of 16-bit floats.
const TWO_PAIRS: vk::Format = vk::Format::R32G32B32A32_UINT;

/// Uploads the lines, one pair of terms to a texel or two: of these, what there is none of is one texel.
fn upload_lines(device: &Arc<Device>, bound: &mut BoundSource, layers: &Layers) -> Result<()> {
    for (number, packed) in [(binding::LINES, false), (binding::PACKED_LINES, true)] {
        let image = match layers.lines.as_ref().filter(|lines| lines.are_packed() == packed) {
            Some(lines) => {
                let (format, to_a_texel) =
                    if packed { (TWO_PAIRS, 2) } else { (spectra::format(&lines.texels), 1) };
                let size = [lines.size[0] * lines.grouped / to_a_texel, lines.size[1]];
                let count = lines.layers(layers.pairs(), layers.z_bands) as u32;
                upload::texture(device, "lines", format, size, Some(count), lines.texels.bytes())?
            }
            None if packed => {
                upload::texture(device, "no packed lines", TWO_PAIRS, [1, 1], Some(1), &[0; 16])?
            }
            None => {
                let format = vk::Format::R8G8B8A8_UNORM;
                upload::texture(device, "no lines", format, [1, 1], Some(1), &[0; 4])?
            }
        };
        let sampler = if packed { Sampler::nearest(device, "integer sampler")? } else { edge(device)? };
        bound.data(number, image, sampler);
    }
    Ok(())
}
