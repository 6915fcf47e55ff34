//! Baking: `bake.comp` sums the spectrum for every texel, a tile at a time.

use super::grid::Grid;
use super::nodes::NODES;
use super::pyramid::Planes;
use crate::error::Result;
use crate::expansion::Basis;
use crate::optics::spectrum::SHORTEST;
use crate::precompute::{Layers, Settings};
use crate::render::interface::{UV_BINS, binding};
use crate::render::resources::{Pigment, Resources};
use crate::render::shader;
use crate::render::shading::{Purpose, Shading};
use crate::vk::access::Access;
use crate::vk::buffer::Buffer;
use crate::vk::commands::Commands;
use crate::vk::device::Device;
use crate::vk::pipeline::Pipeline;
use crate::vk::selection::Candidate;
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
/// Most products of a place, a wavelength, a pair of terms and a node of w in a submission: a software device takes a quarter
/// of a second for as many.
const WORK: usize = 150_000_000;

/// Push constants of `bake.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Tile {
    first: u32,
    count: u32,
    comb: i32,
    wavelengths: i32,
    spacing: f32,
    centre: f32,
    x_per_z: f32,
    pieces: i32,
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

/// Adds `share` of the table of `layers`, of [`Basis::Phase`](crate::expansion::Basis::Phase), to `planes`. `progress(done, of)` is called between submissions, in texels; an
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
    let for_combs = Shading { tolerance: COMB_SHARE * shading.tolerance, ..shading.clone() };
    let resources = Resources::new(device, layers, &for_combs, &Pigment::white())?;
    let combs = &resources.combs;
    let places = Places::new(grid);
    let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let list = Buffer::with_data(device, "places", storage, bytemuck::cast_slice(&places.words))?;
    let numbers = 6 * grid.values();
    let sums = Buffer::new(device, "sums", (TILE * numbers * 4) as u64, storage, MemoryLocation::GpuToCpu)?;
    resources.descriptors.buffer(binding::QUERIES, &list);
    resources.descriptors.buffer(binding::ANSWERS, &sums);
    let constants = [resources.specialization.as_slice(), &[grid.values() as u32]].concat();
    let code = shader!("bake.comp").with(&constants);
    let pipeline = Pipeline::compute(device, code, &resources.descriptors, size_of::<Tile>() as u32)?;
    let mut commands = Commands::new(device, "bake")?;
    for bin in 0..UV_BINS {
        let [comb, wavelengths] = combs.bins[bin];
        let work = (wavelengths as usize * layers.pairs() * grid.values()).max(1);
        let at_once = (WORK / work).clamp(GROUP, TILE);
        let mut first = places.begins[bin];
        while first < places.begins[bin + 1] {
            progress(first, places.words.len())?;
            let count = at_once.min(places.begins[bin + 1] - first);
            let tile = Tile {
                first: first as u32,
                count: count as u32,
                comb,
                wavelengths,
                spacing: grid.spacing as f32,
                centre: grid.centre() as f32,
                x_per_z: (2.0 / layers.z_max) as f32,
                pieces: grid.pieces as i32,
            };
            commands.run(|record| {
                record.bind(&pipeline, &resources.descriptors);
                record.push(&pipeline, bytemuck::bytes_of(&tile));
                record.dispatch(count.div_ceil(GROUP) as u32);
                record.memory(Access::ComputeWrite, Access::HostRead);
                Ok(())
            })?;
            let read: &[f32] = bytemuck::cast_slice(&sums.bytes()?[..count * numbers * 4]);
            scatter(read, &places.words[first..first + count], grid, share, planes);
            first += count;
        }
    }
    progress(places.words.len(), places.words.len())
}

/// Adds what a tile holds to the planes, at each place and at the place opposite.
fn scatter(sums: &[f32], words: &[u32], grid: &Grid, share: f32, planes: &mut Planes) {
    let (last, values) = (grid.side * grid.side - 1, grid.values());
    planes.par_iter_mut().enumerate().for_each(|(number, plane)| {
        // Planes go by piece, channel and node; sums by node and channel.
        let (piece, channel, m) = (number / (3 * NODES), number / NODES % 3, number % NODES);
        let at = |sign: usize| {
            let row = (sign * values + piece * NODES + m) * 3 + channel;
            &sums[row * words.len()..][..words.len()]
        };
        for ((word, with), against) in words.iter().zip(at(0)).zip(at(1)) {
            let place = (word >> 16) as usize * grid.side + (word & 0xffff) as usize;
            plane[place] += share * with;
            plane[last - place] += share * against;
        }
    });
}

/// Share of the tolerance that the layers are told, as a multiple: errors of single wavelengths average down in a colour,
/// six to eight times.
const LAYERS_SHARE: f64 = 3.0;

/// What the layers are made for that a table under `shading` is baked from, on `device`.
///
/// # Errors
/// For settings that layers cannot do.
pub fn layer_settings(shading: &Shading, device: &Candidate) -> Result<Settings> {
    let for_layers = Shading {
        tolerance: (LAYERS_SHARE * shading.tolerance).min(1.0),
        purpose: Purpose::Directions,
        basis: Basis::Phase,
        windows: [1, 1],
        ..shading.clone()
    };
    for_layers.layer_settings(SHORTEST, device)
}
