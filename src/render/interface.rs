//! Blocks and bindings that Rust and the shaders share. Its twin is `shaders/interface.glsl`.

use super::color_table::{Filter, Grid};
use crate::precompute::Layers;
use crate::precompute::kernel::Kernel;
use crate::precompute::near::OCTAVES;
use crate::scene::MAX_LIGHTS;
use crate::vk::descriptors::Binding;
use ash::vk;
use bytemuck::{Pod, Zeroable};

/// Bins of |(u, v)| over 0 … 2 for which a wavelength comb is chosen; `UV_BINS` of the shaders.
pub const UV_BINS: usize = 256;

/// Bindings of lights beyond the first, two lights each.
pub const MORE_LIGHTS: u32 = (MAX_LIGHTS as u32 - 1).div_ceil(2);

/// Binding numbers of set 0.
pub mod binding {
    /// Camera, lights, pigment.
    pub const FRAME: u32 = 0;
    /// Layers and window.
    pub const OPTICS: u32 = 1;
    /// The layers' texture.
    pub const LAYERS: u32 = 2;
    /// c_n(z), and the pairs of terms that z needs.
    pub const COEFFICIENTS: u32 = 3;
    /// Wavelength combs by |(u, v)|.
    pub const COMBS: u32 = 4;
    /// Nodes of all combs.
    pub const NODES: u32 = 5;
    /// Pigment texture.
    pub const PIGMENT: u32 = 6;
    /// Directions to evaluate.
    pub const QUERIES: u32 = 7;
    /// What they evaluate to.
    pub const ANSWERS: u32 = 8;
    /// ω_r and the first light's ω_i of every pixel.
    pub const DIRECTIONS: u32 = 9;
    /// Pigment of every pixel.
    pub const ALBEDOS: u32 = 10;
    /// ω_i of every pixel for the second and the third light; the fourth follows.
    pub const MORE_LIGHTS: u32 = 11;
    /// The colour table's texture.
    pub const COLOR_TABLE: u32 = 15;
    /// Where its texels stand.
    pub const TABLE: u32 = 16;
    /// The lines' texture.
    pub const LINES: u32 = 17;
    /// Weights of nodes that stand where rays cross lines.
    pub const LINE_WEIGHTS: u32 = 18;
    /// Where the lines and the weights stand.
    pub const LINES_BLOCK: u32 = 19;
    /// The lines' texture where two pairs of terms share a texel.
    pub const PACKED_LINES: u32 = 20;
    /// Footprints of every pixel for the first light; those of the others follow.
    pub const FOOTPRINTS: u32 = 21;
}

/// The `Frame` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FrameBlock {
    /// World to clip space, column by column.
    pub clip_from_world: [[f32; 4]; 4],
    /// Position of the viewer; w unused.
    pub eye: [f32; 4],
    /// Unit vector to each light, and its irradiance over π.
    pub lights: [[f32; 4]; MAX_LIGHTS],
    /// Albedo of the pigment; w: 1 where the texture counts.
    pub base_color: [f32; 4],
    /// x: number of lights.
    pub counts: [i32; 4],
    /// Which sample of the picture the frame is.
    pub sample: SampleBlock,
}

/// A sample of a picture, as [`super::sampling::Sample`] has it (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SampleBlock {
    /// Place in the pixel, from its centre: x to the right, y downward \[pixels\].
    pub jitter: [f32; 2],
    /// Standard deviation of the part of the pixel filter that shading averages over \[pixels\].
    pub footprint: f32,
    /// Number of the sample, from 0.
    pub index: u32,
    /// Number of samples in the picture.
    pub count: u32,
    /// Low bits of the sequence's seed.
    pub seed: u32,
    /// std140 rounds a structure up to 16 bytes.
    pub padding: [u32; 2],
}

/// The `Optics` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct OpticsBlock {
    /// Texels of a layer.
    pub texture_size: [f32; 2],
    /// Centre of the texel of f = 0.
    pub origin: [f32; 2],
    /// L_x, L_y \[µm\].
    pub texels_per_frequency: [f32; 2],
    /// Largest frequencies \[µm⁻¹\].
    pub band: [f32; 2],
    /// σ of the window \[µm\].
    pub sigma: f32,
    /// R₀ of Schlick.
    pub normal_reflectance: f32,
    /// Bands of z per unit of k|w| \[µm\].
    pub bands_per_z: f32,
    /// Number of the last column of the coefficients of a band; the first is 0.
    pub last_column: f32,
    /// Pairs of terms that k|w| needs: ⌈`pairs_per_z`·k|w| + `fewest_pairs`⌉.
    pub pairs_per_z: f32,
    /// See `pairs_per_z`.
    pub fewest_pairs: f32,
    /// std140 rounds a block up to 16 bytes.
    pub padding: [f32; 2],
}

/// What the shaders are specialised for, by `constant_id`; see `shaders/spectrum.glsl` and `shaders/lines.glsl`. A branch on such
/// a constant costs nothing, where software devices run both sides of one on a uniform.
pub fn specialization(layers: &Layers) -> Vec<u32> {
    let cubic = layers.interpolation.kernels.map(|kernel| u32::from(kernel == Kernel::Cubic));
    let mut constants = vec![
        cubic[0],
        cubic[1],
        layers.half_plane.into(),
        layers.z_bands as u32,
        layers.pairs() as u32,
        (layers.pairs_needed.slope > 0.0).into(),
        layers.coefficients.source as u32,
    ];
    if let Some(lines) = &layers.lines {
        // Numbers 7 and 8 belong to shaders of colour tables.
        let cubic = lines.kernel == Kernel::Cubic;
        constants.extend([0, 0, 1, lines.grouped as u32, cubic.into(), lines.are_packed().into()]);
    }
    constants
}

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

/// What `shaders/repeats.glsl` takes as push constants.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CopiesBlock {
    /// Copies of the patch along x and y.
    pub count: [f32; 2],
    /// T_x, T_y \[µm\].
    pub period: [f32; 2],
    /// Lag beyond which the colour functions have little \[µm\].
    pub colour_lag: f32,
    /// Relative error of the sum over wavelengths.
    pub tolerance: f32,
    /// Queries that `repeats_eval.comp` answers at once; 0 in a picture.
    pub queries: u32,
}

/// The `Table` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TableBlock {
    /// Texture coordinate per unit of u.
    pub texture_per_uv: f32,
    /// Texels of the finest level per unit of u.
    pub texels_per_uv: f32,
    /// What a stored 1 stands for.
    pub unit: f32,
    /// Added to the level that a footprint asks for.
    pub finest: f32,
    /// Pieces of the range of |w|.
    pub pieces: f32,
    /// |u| and |v| up to which the finer part is read.
    pub near: f32,
    /// Texture coordinate per unit of u there.
    pub near_texture_per_uv: f32,
    /// Texture coordinate of u = v = 0 there.
    pub near_centre: f32,
}

/// The same for shaders that read a colour table of `grid` by `filter`: `PAIRS` are the table's layers, for the probe. The
/// number of lights follows where pixels are shaded.
pub fn table_specialization(grid: &Grid, filter: Filter) -> Vec<u32> {
    vec![0, 0, 1, 1, grid.texture(filter).1 as u32, 0, 0, filter.taps() as u32]
}

/// A direction to evaluate.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct QueryBlock {
    /// To the light; w: wavenumber \[µm⁻¹\], or 0 for the colour.
    pub light: [f32; 4],
    /// To the viewer; w unused.
    pub view: [f32; 4],
}

/// Bindings of what the geometry pass writes.
pub fn geometry_bindings() -> impl Iterator<Item = u32> {
    let footprints = binding::FOOTPRINTS..binding::FOOTPRINTS + MAX_LIGHTS as u32;
    (binding::DIRECTIONS..binding::MORE_LIGHTS + MORE_LIGHTS).chain(footprints)
}

/// All bindings of the optics, for graphics and compute.
pub fn optics_bindings() -> Vec<Binding> {
    use vk::DescriptorType as T;
    let stages =
        vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT | vk::ShaderStageFlags::COMPUTE;
    let geometry = geometry_bindings().map(|number| (number, T::COMBINED_IMAGE_SAMPLER));
    [
        (binding::FRAME, T::UNIFORM_BUFFER),
        (binding::OPTICS, T::UNIFORM_BUFFER),
        (binding::LAYERS, T::COMBINED_IMAGE_SAMPLER),
        (binding::COEFFICIENTS, T::COMBINED_IMAGE_SAMPLER),
        (binding::COMBS, T::STORAGE_BUFFER),
        (binding::NODES, T::COMBINED_IMAGE_SAMPLER),
        (binding::PIGMENT, T::COMBINED_IMAGE_SAMPLER),
        (binding::QUERIES, T::STORAGE_BUFFER),
        (binding::ANSWERS, T::STORAGE_BUFFER),
        (binding::COLOR_TABLE, T::COMBINED_IMAGE_SAMPLER),
        (binding::TABLE, T::UNIFORM_BUFFER),
        (binding::LINES, T::COMBINED_IMAGE_SAMPLER),
        (binding::LINE_WEIGHTS, T::COMBINED_IMAGE_SAMPLER),
        (binding::LINES_BLOCK, T::UNIFORM_BUFFER),
        (binding::PACKED_LINES, T::COMBINED_IMAGE_SAMPLER),
    ]
    .into_iter()
    .chain(geometry)
    .map(|(number, kind)| Binding { number, kind, stages })
    .collect()
}
