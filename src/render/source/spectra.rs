//! Spectra of an expansion's terms, shared by the sources of a window and of a grating. Its twin is
//! `shaders/spectra.glsl`.

use super::Extent;
use super::bound::{BoundSource, Kind, uniform};
use super::surface_factor::MediumBlock;
use crate::error::Result;
use crate::optics::geometry::Pair;
use crate::render::tables::TableTexture;
use crate::render::upload;
use crate::spectra::amplitude::Layers;
use crate::spectra::amplitude::kernel::{Interpolation, Kernel};
use crate::spectra::amplitude::texels::Texels;
use crate::vk::buffer::Buffer;
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::Constant;
use crate::vk::sampler::Sampler;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::f64::consts::PI;
use std::sync::Arc;

/// Binding numbers of set 1.
pub(super) mod binding {
    pub const BLOCK: u32 = 2;
    pub const LAYERS: u32 = 3;
    pub const COEFFICIENTS: u32 = 4;
    pub const NODES: u32 = 5;
}

/// Kinds of the bindings, in order.
pub(super) const KINDS: [Kind; 4] = [
    Kind::UNIFORM_BUFFER,
    Kind::COMBINED_IMAGE_SAMPLER,
    Kind::COMBINED_IMAGE_SAMPLER,
    Kind::COMBINED_IMAGE_SAMPLER,
];

/// The `Spectra` block (std140).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SpectraBlock {
    /// Texels of a layer.
    pub texture_size: [f32; 2],
    /// Centre of the texel at frequency 0.
    pub origin: [f32; 2],
    /// L_x, L_y \[µm\].
    pub texels_per_frequency: [f32; 2],
    /// Largest frequencies \[µm⁻¹\].
    pub band: [f32; 2],
    /// σ of the window \[µm\].
    pub sigma: f32,
    /// Half the range of heights \[µm\].
    pub half_range: f32,
    /// Texture coordinate of the coefficients at k|w| = 0, and its change per unit of k|w| \[µm\].
    pub column: [f32; 2],
    /// Pairs of terms needed at k|w|: ⌈`pairs_per_z`·k|w| + `fewest_pairs`⌉.
    pub pairs_per_z: f32,
    /// See `pairs_per_z`.
    pub fewest_pairs: f32,
    /// std140 aligns structures to 16 bytes.
    pub padding: [f32; 2],
    /// Refractive indices of the surface.
    pub medium: MediumBlock,
}

/// Makes the `Spectra` block of `layers` seen through a Gaussian window of standard deviation `sigma` \[µm\].
pub fn spectra_block(layers: &Layers, sigma: f64, medium: MediumBlock) -> SpectraBlock {
    let pair = |v: [f64; 2]| v.map(|x| x as f32);
    let columns = layers.coefficients.columns as f64;
    SpectraBlock {
        texture_size: layers.size.map(|n| n as f32),
        origin: layers.origin.map(|n| n as f32 + 0.5),
        texels_per_frequency: pair(layers.length),
        band: pair(layers.band),
        // The shaders square the texel values and multiply by σ².
        sigma: sigma as f32 * layers.texels.unit(),
        column: pair([0.5 / columns, (columns - 1.0) / columns / layers.z_max]),
        pairs_per_z: layers.pairs_needed.slope as f32,
        fewest_pairs: layers.pairs_needed.fewest as f32,
        half_range: layers.coefficients.half_range as f32,
        padding: [0.0; 2],
        medium,
    }
}

/// Returns the specialisation constants of `shaders/spectra.glsl`.
pub(super) fn constants(layers: &Layers) -> Vec<Constant> {
    const HALF_PLANE: u32 = 12;
    const PAIRS: u32 = 13;
    const FEWER_PAIRS: u32 = 14;
    const TAYLOR: u32 = 15;
    let mut constants = kernel_constants(&layers.interpolation);
    constants.extend([
        Constant::new(HALF_PLANE, layers.half_plane),
        Constant::new(PAIRS, layers.pairs() as u32),
        Constant::new(FEWER_PAIRS, layers.pairs_needed.slope > 0.0),
        Constant::new(TAYLOR, layers.coefficients.taylor),
    ]);
    constants
}

/// Returns the specialisation constants of `shaders/kernel.glsl`.
pub(super) fn kernel_constants(interpolation: &Interpolation) -> Vec<Constant> {
    const CUBIC_X: u32 = 40;
    const CUBIC_Y: u32 = 41;
    const WEIGHS_TEXELS: u32 = 42;
    let [x, y] = interpolation.kernels.map(|kernel| kernel == Kernel::Cubic);
    vec![
        Constant::new(CUBIC_X, x),
        Constant::new(CUBIC_Y, y),
        Constant::new(WEIGHS_TEXELS, interpolation.weighs_texels()),
    ]
}

/// Uploads the spectra and their coefficients.
pub(super) fn upload(device: &Arc<Device>, bound: &mut BoundSource, layers: &Layers) -> Result<()> {
    let count = Some(layers.pairs() as u32);
    let texels = &layers.texels;
    let image = upload::texture(device, "spectra", format(texels), layers.size, count, texels.bytes())?;
    bound.data(binding::LAYERS, image, edge(device)?);
    let table = &layers.coefficients;
    let (size, values) = ([table.columns, 1], bytemuck::cast_slice(&table.values));
    let image = upload::texture(device, "coefficients", FLOATS, size, count, values)?;
    bound.data(binding::COEFFICIENTS, image, edge(device)?);
    Ok(())
}

/// Images and buffers, each with its binding number.
type Bound = (Vec<(u32, Image)>, Vec<(u32, Buffer)>);

/// Makes the block and the nodes, with their binding numbers.
pub(super) fn settings(
    device: &Arc<Device>,
    (layers, sigma): (&Layers, f64),
    nodes: &TableTexture,
    medium: MediumBlock,
) -> Result<Bound> {
    let block = uniform(device, "spectra block", &spectra_block(layers, sigma, medium))?;
    let nodes = numbers(device, "nodes", nodes)?;
    Ok((vec![(binding::NODES, nodes)], vec![(binding::BLOCK, block)]))
}

/// Makes a texture of a table.
pub(super) fn numbers(device: &Arc<Device>, name: &str, table: &TableTexture) -> Result<Image> {
    upload::texture(device, name, FLOATS, table.size, None, bytemuck::cast_slice(&table.values))
}

/// Makes a linear sampler that clamps to the edge.
pub(super) fn edge(device: &Arc<Device>) -> Result<Sampler> {
    Sampler::linear(device, "spectra sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)
}

/// Four 32-bit floats.
const FLOATS: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Returns the texture format of `texels`.
pub(super) fn format(texels: &Texels) -> vk::Format {
    if texels.is_half() { vk::Format::R16G16B16A16_SFLOAT } else { FLOATS }
}

/// Returns the size of the texture of `layers`.
pub(super) fn extent(layers: &Layers) -> Extent {
    Extent { layers: layers.pairs(), size: layers.size, bytes: layers.bytes() as u64 }
}

/// Counts the wavelengths and samples of `pair` over the ascending `wavenumbers`, at `per_read` samples per pair of
/// terms.
pub(super) fn counted(
    layers: &Layers,
    pair: &Pair,
    per_read: usize,
    wavenumbers: impl Iterator<Item = f64>,
) -> (usize, usize) {
    let uvw = pair.uvw();
    let largest = largest_wavenumber(layers, pair);
    wavenumbers.take_while(|&q| q <= largest).fold((0, 0), |(count, samples), q| {
        (count + 1, samples + layers.pairs_at(2.0 * PI * q * -uvw.z) * per_read)
    })
}

/// Returns the wavenumber at which `pair` leaves the band \[µm⁻¹\].
pub(super) fn largest_wavenumber(layers: &Layers, pair: &Pair) -> f64 {
    let along = pair.uvw().truncate().abs();
    (layers.band[0] / along.x.max(1e-9)).min(layers.band[1] / along.y.max(1e-9))
}
