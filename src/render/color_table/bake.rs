//! Baking: `bake.comp` sums the spectrum for every sample of the rings, a tile at a time.

use super::aperture::Aperture;
use super::grid::Grid;
use super::nodes::NODES;
use super::rings::{Rings, Samples};
use crate::error::Result;
use crate::expansion::Basis;
use crate::optics::orders::{Colours, Repeats, Sampling};
use crate::optics::spectrum::SHORTEST;
use crate::precompute::{Layers, Settings};
use crate::render::evaluator::queries_and_answers;
use crate::render::shader;
use crate::render::shading::{Purpose, Shading};
use crate::render::source::grating::CopiesBlock;
use crate::render::source::{BoundSource, Grating, Source};
use crate::render::tables::Combs;
use crate::vk::access::Access;
use crate::vk::buffer::Buffer;
use crate::vk::commands::Commands;
use crate::vk::device::Device;
use crate::vk::pipeline::{Constant, Pipeline};
use crate::vk::selection::Candidate;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use gpu_allocator::MemoryLocation;
use std::f64::consts::PI;
use std::sync::Arc;

/// Share of the tolerance that the wavelength combs are told; they take 0.48 of it.
pub const COMB_SHARE: f64 = 0.5;
/// `local_size_x` of `bake.comp`.
const GROUP: usize = 64;
/// Most places of one submission.
const TILE: usize = 1 << 15;
/// Most products of a place, a wavelength, a pair of terms and a node of w in a submission: a software device takes a
/// fraction of a second for as many, and others want to draw beside.
const WORK: usize = 40_000_000;

/// Push constants of `bake.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Tile {
    first: u32,
    count: u32,
    comb: i32,
    wavelengths: i32,
    x_per_z: f32,
    pieces: i32,
    copies: CopiesBlock,
}

/// The wavelengths whose sum a table through a window under `shading` stands for: far more than the bake takes, since what these
/// err by need not be interpolated, or those that the user names.
pub fn true_combs(sigma: f64, shading: &Shading) -> Combs {
    const PART: f64 = 0.02;
    Combs::new(&shading.illuminant, sigma, PART * shading.quadrature(), shading.wavelengths)
}

/// `shading` for the sum over wavelengths.
fn for_wavelengths(shading: &Shading) -> Shading {
    Shading { tolerance: COMB_SHARE * shading.tolerance, ..shading.clone() }
}

/// Wavelengths of a bake through `repeats` at |(u, v)| = `radius`, where they are most; `lag`: of the colour functions \[µm\].
fn most_wavelengths(repeats: &Repeats, lag: f64, shading: &Shading, radius: f64) -> Sampling {
    /// Directions looked at, over a quarter of a ring.
    const DIRECTIONS: i32 = 32;
    let along = |i| {
        let uv = DVec2::from_angle(0.5 * PI * f64::from(i) / f64::from(DIRECTIONS)) * radius;
        repeats.sampling(uv, lag, for_wavelengths(shading).quadrature())
    };
    let more = |a: Sampling, b: Sampling| if b.wavelengths() > a.wavelengths() { b } else { a };
    (1..=DIRECTIONS).map(along).fold(along(0), more)
}

/// Fails where a place of a table with places up to |(u, v)| = `outer` would take more wavelengths than a colour may.
///
/// # Errors
/// With both numbers.
pub fn check_wavelengths(aperture: &Aperture, shading: &Shading, outer: f64) -> Result<()> {
    let Some(repeats) = aperture.repeats() else { return Ok(()) };
    let lag = Colours::new(&shading.illuminant, for_wavelengths(shading).quadrature()).lag;
    repeats.check(&most_wavelengths(repeats, lag, shading, outer))
}

/// What the device reads in a bake: spectra, and combs or copies.
fn bound(
    device: &Arc<Device>,
    layers: &Arc<Layers>,
    aperture: &Aperture,
    shading: &Shading,
) -> Result<BoundSource> {
    let layers = layers.clone();
    let source = match aperture {
        Aperture::Gaussian(_) => Source::window(layers),
        Aperture::Repeats(repeats) => Source::Grating(Grating { layers, repeats: *repeats }),
    };
    source.bind(device, &for_wavelengths(shading))
}

/// Room for what a bake of `grid` finds on `rings`.
pub fn samples(rings: &Rings, grid: &Grid) -> Samples {
    let width = 3 * grid.values();
    Samples { width, values: vec![0.0; 2 * width * rings.begins[rings.radii.len()]] }
}

/// Adds `share` of the table of `layers`, of [`Basis::Phase`], to `samples`. `progress(done, of)` is called between
/// submissions, in places; an error from it ends the work.
///
/// # Errors
/// Where the device has no room or is lost, and what `progress` returns.
pub fn bake(
    device: &Arc<Device>,
    (layers, aperture): (&Arc<Layers>, &Aperture),
    shading: &Shading,
    (rings, grid): (&Rings, &Grid),
    share: f32,
    samples: &mut Samples,
    progress: &dyn Fn(usize, usize) -> Result<()>,
) -> Result<()> {
    // The layers' own unit, in which the device squares them.
    let share = share * layers.texels.unit().powi(2);
    let source = bound(device, layers, aperture, shading)?;
    let told = for_wavelengths(shading);
    let combs = Combs::of(layers, &told);
    let copies = aperture.repeats().map(|repeats| {
        let colours = Colours::new(&shading.illuminant, told.quadrature());
        CopiesBlock::new(repeats, &colours, told.quadrature())
    });
    let places = rings.places();
    let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let list = Buffer::with_data(device, "places", storage, bytemuck::cast_slice(&places))?;
    let width = samples.width;
    let bytes = (TILE * 2 * width * 4) as u64;
    let sums = Buffer::new(device, "sums", bytes, storage, MemoryLocation::GpuToCpu)?;
    let descriptors = queries_and_answers(device, &list, &sums)?;
    /// Constants of `bake.comp`.
    const NODES_OF_W: u32 = 0;
    const REPEATS: u32 = 1;
    let own = [Constant::new(NODES_OF_W, grid.values() as u32), Constant::new(REPEATS, copies.is_some())];
    let constants = [source.constants(), &own].concat();
    let code = shader!("bake.comp").with(&constants);
    let sets = [&descriptors, &source.descriptors];
    let pipeline = Pipeline::compute(device, code, &sets, size_of::<Tile>() as u32)?;
    let mut commands = Commands::new(device, "bake")?;
    for (ring, ends) in rings.begins.windows(2).enumerate() {
        let radius = rings.radii[ring];
        let [comb, wavelengths] = combs.at(radius);
        let most = match (aperture, &copies) {
            (Aperture::Repeats(repeats), Some(block)) => {
                most_wavelengths(repeats, f64::from(block.colour_lag), shading, radius).wavelengths().ceil()
                    as usize
            }
            _ => wavelengths as usize,
        };
        let work = (most * layers.pairs() * grid.values()).max(1);
        let at_once = (WORK / work).clamp(GROUP, TILE);
        for first in (ends[0]..ends[1]).step_by(at_once) {
            progress(first, places.len())?;
            let count = at_once.min(ends[1] - first);
            let tile = Tile {
                first: first as u32,
                count: count as u32,
                comb,
                wavelengths,
                x_per_z: (2.0 / layers.z_max) as f32,
                pieces: grid.pieces as i32,
                copies: copies.unwrap_or_default(),
            };
            commands.run(|record| {
                record.bind(&pipeline, &sets);
                record.push(&pipeline, bytemuck::bytes_of(&tile));
                record.dispatch(count.div_ceil(GROUP) as u32);
                record.memory(Access::ComputeWrite, Access::HostRead);
                Ok(())
            })?;
            let read: &[f32] = bytemuck::cast_slice(&sums.bytes()?[..count * 2 * width * 4]);
            // The half that is baked, and the one opposite.
            let half = [2 * ends[0] + first - ends[0], ends[0] + ends[1] + first - ends[0]];
            collect(read, count, half, share, samples);
        }
    }
    progress(places.len(), places.len())
}

/// Adds what a tile of `count` places holds to the samples from `begins` on, with the places and with those opposite.
fn collect(sums: &[f32], count: usize, begins: [usize; 2], share: f32, samples: &mut Samples) {
    let width = samples.width;
    for (sign, begin) in begins.into_iter().enumerate() {
        for number in 0..width {
            // Samples go by piece, channel and node; sums by node and channel.
            let (piece, channel, m) = (number / (3 * NODES), number / NODES % 3, number % NODES);
            let row = sign * width + (piece * NODES + m) * 3 + channel;
            let own = samples.values[begin * width + number..].iter_mut().step_by(width);
            own.zip(&sums[row * count..][..count]).for_each(|(value, sum)| *value += share * sum);
        }
    }
}

/// Share of the tolerance that the layers are told, as those of a picture.
const LAYERS_SHARE: f64 = 0.5;

/// What the layers are made for that a table under `shading` is baked from, on `device`.
///
/// # Errors
/// For settings that layers cannot do.
pub fn layer_settings(shading: &Shading, device: &Candidate) -> Result<Settings> {
    let for_layers = Shading {
        tolerance: (LAYERS_SHARE * shading.tolerance).min(1.0),
        purpose: Purpose::Picture,
        basis: Basis::Phase,
        windows: [1, 1],
        ..shading.clone()
    };
    let sigma = for_layers.coherence.sigma().unwrap_or(f64::INFINITY);
    for_layers.windowed_settings(sigma, SHORTEST, device)
}
