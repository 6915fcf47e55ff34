//! Baking: `bake.comp` sums the spectrum for every texel, a tile at a time.

use super::grid::Grid;
use super::nodes::{self, NODES};
use super::pyramid::Planes;
use crate::error::Result;
use crate::precompute::Layers;
use crate::render::interface::{UV_BINS, binding};
use crate::render::resources::{Pigment, Resources};
use crate::render::shader;
use crate::render::shading::Shading;
use crate::render::tables::Combs;
use crate::vk::access::Access;
use crate::vk::buffer::Buffer;
use crate::vk::commands::Commands;
use crate::vk::device::Device;
use crate::vk::pipeline::Pipeline;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use gpu_allocator::MemoryLocation;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

/// Share of the tolerance that the wavelength combs are told; they take 0.6 of it.
pub const COMB_SHARE: f64 = 0.4;
/// `local_size_x` of `bake.comp`.
const GROUP: usize = 64;
/// Most places of one submission.
const TILE: usize = 1 << 15;
/// Most products of a place, a wavelength and a pair of terms in a submission: a software device takes a quarter of a
/// second for as many.
const WORK: usize = 20_000_000;

/// Push constants of `bake.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Tile {
    first: u32,
    count: u32,
    first_step: u32,
    wavelengths: u32,
    pairs: u32,
    spacing: f32,
    centre: f32,
}

/// The places of half a grid, u ≤ 0, by the bin of |(u, v)| that their wavelengths depend on; within a bin along the ring, so
/// that neighbours in the list read neighbouring texels of the layers.
struct Places {
    words: Vec<u32>,
    /// Where each bin begins, and the end.
    begins: Vec<usize>,
}

impl Places {
    fn new(grid: &Grid) -> Self {
        let half = grid.side / 2;
        let mut keyed: Vec<(u32, u32, u32)> = (0..grid.side)
            .into_par_iter()
            .flat_map_iter(|row| {
                (half..grid.side).filter_map(move |column| {
                    let (x, y) = (grid.at(column), grid.at(row));
                    // A texel's diagonal beyond 2, so that linear interpolation there has all that it reads.
                    let uv = x.hypot(y);
                    (uv <= 2.0 + 1.5 * grid.spacing).then(|| {
                        let bin = ((uv * 0.5 * UV_BINS as f64) as u32).min(UV_BINS as u32 - 1);
                        let angle = ((y.atan2(x) / PI + 1.0) * f64::from(1 << 20)) as u32;
                        (bin, angle, column as u32 | (row as u32) << 16)
                    })
                })
            })
            .collect();
        keyed.par_sort_unstable();
        let begins = (0..=UV_BINS as u32).map(|bin| keyed.partition_point(|&(b, ..)| b < bin)).collect();
        Self { words: keyed.into_iter().map(|(.., word)| word).collect(), begins }
    }
}

/// Adds `share` of the table of `layers` to `planes`. `progress(done, of)` is called between submissions, in texels; an
/// error from it ends the work.
///
/// # Errors
/// Where the device has no room or is lost, and what `progress` returns.
pub fn bake(
    device: &Arc<Device>,
    layers: &Layers,
    shading: &Shading,
    grid: &Grid,
    share: f32,
    planes: &mut Planes,
    progress: &dyn Fn(usize, usize) -> Result<()>,
) -> Result<()> {
    let resources = Resources::new(device, layers, shading, &Pigment::white())?;
    let combs =
        Combs::new(&shading.illuminant, layers.sigma, COMB_SHARE * shading.tolerance, shading.wavelengths);
    let places = Places::new(grid);
    let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let list = Buffer::with_data(device, "places", storage, bytemuck::cast_slice(&places.words))?;
    let numbers = 6 * grid.values();
    let sums = Buffer::new(device, "sums", (TILE * numbers * 4) as u64, storage, MemoryLocation::GpuToCpu)?;
    let longest = combs.bins.iter().map(|bin| bin[1] as usize).max().unwrap_or(0);
    let stride = 1 + layers.pairs() * grid.values();
    let mut steps =
        Buffer::new(device, "steps", (longest * stride * 16) as u64, storage, MemoryLocation::CpuToGpu)?;
    resources.descriptors.buffer(binding::QUERIES, &list);
    resources.descriptors.buffer(binding::ANSWERS, &sums);
    resources.descriptors.buffer(binding::COMBS, &steps);
    let constants = [grid.values() as i32];
    let pipeline = Pipeline::compute_with(
        device,
        shader!("bake.comp"),
        &resources.descriptors,
        size_of::<Tile>() as u32,
        &constants,
    )?;
    let mut commands = Commands::new(device, "bake")?;
    for bin in 0..UV_BINS {
        let [comb, wavelengths] = combs.bins[bin];
        let nodes = &combs.nodes.values[comb as usize * combs.nodes.size[0]..][..wavelengths as usize];
        // All of a bin is summed at the nodes of its inner edge, where the range is the longest.
        let largest_w = nodes::largest_w(2.0 * bin as f64 / UV_BINS as f64);
        steps.write(bytemuck::cast_slice(&step_table(layers, grid, nodes, largest_w)))?;
        let at_once = (WORK / (wavelengths as usize * (layers.pairs() + 1))).clamp(GROUP, TILE);
        let mut first = places.begins[bin];
        while first < places.begins[bin + 1] {
            progress(first, places.words.len())?;
            let count = at_once.min(places.begins[bin + 1] - first);
            let tile = Tile {
                first: first as u32,
                count: count as u32,
                first_step: 0,
                wavelengths: wavelengths as u32,
                pairs: layers.pairs() as u32,
                spacing: grid.spacing as f32,
                centre: grid.centre() as f32,
            };
            commands.run(|record| {
                record.bind(&pipeline, &resources.descriptors);
                record.push(&pipeline, bytemuck::bytes_of(&tile));
                record.dispatch(count.div_ceil(GROUP) as u32);
                record.memory(Access::ComputeWrite, Access::HostRead);
                Ok(())
            })?;
            let read: &[f32] = bytemuck::cast_slice(&sums.bytes()?[..count * numbers * 4]);
            scatter(read, &places.words[first..first + count], grid, largest_w, share, planes);
            first += count;
        }
    }
    progress(places.words.len(), places.words.len())
}

/// What `bake.comp` reads for each wavelength of a comb: weight times q² and q, then the coefficients.
fn step_table(layers: &Layers, grid: &Grid, comb: &[[f32; 4]], largest_w: f64) -> Vec<[f32; 4]> {
    let table = &layers.coefficients;
    let coefficient = |term: usize, z: f64| {
        if term >= layers.terms {
            return [0.0; 2];
        }
        let column = (z / table.step).min(table.columns as f64 - 1.001);
        let (left, t) = (column as usize, column.fract() as f32);
        let at = |i: usize| table.values[term * table.columns + i];
        std::array::from_fn(|part| at(left)[part] * (1.0 - t) + at(left + 1)[part] * t)
    };
    let mut steps = Vec::with_capacity(comb.len() * (1 + layers.pairs() * grid.values()));
    for &[x, y, z, q] in comb {
        let q2 = q * q;
        steps.push([x * q2, y * q2, z * q2, q]);
        for pair in 0..layers.pairs() {
            for m in 0..grid.values() {
                let z = 2.0 * PI * f64::from(q) * largest_w * nodes::place(m, grid.pieces);
                let ([a, b], [c, d]) = (coefficient(2 * pair, z), coefficient(2 * pair + 1, z));
                steps.push([a, b, c, d]);
            }
        }
    }
    steps
}

/// Adds what a tile holds, at nodes of 0 … `largest_w`, to the planes, at nodes of each place's own range: there and at the
/// place opposite.
fn scatter(sums: &[f32], words: &[u32], grid: &Grid, largest_w: f64, share: f32, planes: &mut Planes) {
    let (last, values) = (grid.side * grid.side - 1, grid.values());
    let places: Vec<(usize, f64)> = words
        .par_iter()
        .map(|word| {
            let (x, y) = ((word & 0xffff) as usize, (word >> 16) as usize);
            (y * grid.side + x, nodes::largest_w(grid.at(x).hypot(grid.at(y))) / largest_w)
        })
        .collect();
    // The three channels of a node have the same weights.
    let mut of_nodes: Vec<Vec<(usize, &mut [f32])>> = (0..values).map(|_| Vec::new()).collect();
    for (number, plane) in planes.iter_mut().enumerate() {
        let (piece, channel, m) = (number / 12, number / NODES % 3, number % NODES);
        of_nodes[piece * NODES + m].push((channel, plane));
    }
    of_nodes.into_par_iter().enumerate().for_each(|(number, mut channels)| {
        let at = |sign: usize, node: usize, channel: usize| {
            &sums[((sign * values + node) * 3 + channel) * words.len()..][..words.len()]
        };
        for (i, &(place, ratio)) in places.iter().enumerate() {
            let (first, weights) = nodes::at(ratio * nodes::place(number, grid.pieces), grid.pieces);
            for (channel, plane) in &mut channels {
                let value = |sign| -> f32 {
                    (0..NODES).map(|m| share * weights[m] as f32 * at(sign, first + m, *channel)[i]).sum()
                };
                plane[place] += value(0);
                plane[last - place] += value(1);
            }
        }
    });
}

/// Share of the tolerance that the layers are told, as a multiple: errors of single wavelengths average down in a colour,
/// six to eight times.
const LAYERS_SHARE: f64 = 3.0;

/// The tolerance to make layers for, where a table of `tolerance` is baked from them.
pub fn layers_tolerance(tolerance: f64) -> f64 {
    (LAYERS_SHARE * tolerance).min(1.0)
}
