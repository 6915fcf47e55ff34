//! What a frame does, counted: the same loops as `shaders/diffraction.glsl`, in f64.

use crate::optics::geometry::Pair;
use crate::precompute::Layers;
use crate::render::color_table::{Filter, Grid};
use crate::render::picture::Directions;
use crate::render::repeating::Repeating;
use crate::render::tables::Combs;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Work of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Pixels that the mesh covers.
    pub covered: usize,
    /// Wavelengths summed, over all pixels and lights.
    pub wavelengths: usize,
    /// Samples of the layers, over all pixels and lights: of the hardware, or interpolated along a line.
    pub samples: usize,
}

impl Cost {
    /// Hardware samples per covered pixel.
    pub fn samples_per_pixel(&self) -> f64 {
        self.samples as f64 / self.covered.max(1) as f64
    }

    /// Wavelengths per covered pixel.
    pub fn wavelengths_per_pixel(&self) -> f64 {
        self.wavelengths as f64 / self.covered.max(1) as f64
    }

    /// Counts a frame that shades `directions` (one entry per light) from `layers` and `combs`.
    pub fn of(layers: &Layers, combs: &Combs, directions: &[Directions]) -> Self {
        Self::counted(directions, |pair| {
            let along = pair.uvw().truncate().abs();
            if let (Some(lines), Some(sliding)) = (&layers.lines, &combs.sliding) {
                let (_, per) = lines.crossed(along.to_array());
                let numbers = sliding.nodes(per, largest_wavenumber(layers, pair));
                return of_wavenumbers(layers, pair, 1, numbers.map(|m| m as f64 / per));
            }
            let nodes = combs.nodes_at(along.length()).iter().map(|node| f64::from(node[3]));
            of_wavenumbers(layers, pair, layers.interpolation.samples() as usize, nodes)
        })
    }

    /// Counts what `of_pair` says of each pair of directions above the horizon: wavelengths and samples.
    fn counted(directions: &[Directions], of_pair: impl Fn(&Pair) -> (usize, usize)) -> Self {
        let mut cost = Self::default();
        for (index, seen) in directions.iter().enumerate() {
            for (light, view) in seen.light.iter().zip(&seen.view) {
                if view[3] == 0.0 {
                    continue;
                }
                cost.covered += usize::from(index == 0);
                let vector = |v: &[f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
                let pair = Pair::new(vector(light), vector(view));
                let (wavelengths, samples) = if pair.above_horizon() { of_pair(&pair) } else { (0, 0) };
                cost.wavelengths += wavelengths;
                cost.samples += samples;
            }
        }
        cost
    }
}

impl Cost {
    /// Counts a frame that shades `directions` (one entry per light) from `layers` of one period, `repeating`.
    pub fn of_repeats(layers: &Layers, repeating: &Repeating, directions: &[Directions]) -> Self {
        let Repeating { repeats, colours, tolerance } = repeating;
        Self::counted(directions, |pair| {
            let uv = pair.uvw().truncate();
            let sampling = repeats.sampling(uv, colours.lag, *tolerance);
            let per_read = layers.interpolation.samples() as usize;
            of_wavenumbers(layers, pair, per_read, sampling.wavenumbers())
        })
    }
}

impl Cost {
    /// Counts a frame of `size` pixels that reads `directions` (one entry per light) from a colour table of `grid` by
    /// `filter`.
    pub fn of_table(grid: &Grid, filter: Filter, directions: &[Directions], size: [u32; 2]) -> Self {
        let mut cost = Self::default();
        for (index, seen) in directions.iter().enumerate() {
            let covered = |i: usize| seen.view[i][3] != 0.0;
            let toward = |i: usize| {
                let along = |c: usize| f64::from(seen.light[i][c]) + f64::from(seen.view[i][c]);
                DVec2::new(along(0), along(1))
            };
            let (width, height) = (size[0] as i64, size[1] as i64);
            // The shorter of the steps to both sides, as `shorter_step` of `shaders/table.frag` has it.
            let step = |i: usize, next: [i64; 2]| {
                let (x, y) = (i as i64 % width, i as i64 / width);
                [-1, 1]
                    .into_iter()
                    .map(|side| [x + side * next[0], y + side * next[1]])
                    .filter(|[x, y]| (0..width).contains(x) && (0..height).contains(y))
                    .map(|[x, y]| (y * width + x) as usize)
                    .filter(|&other| covered(other))
                    .map(|other| toward(other) - toward(i))
                    .min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
                    .unwrap_or(DVec2::ZERO)
            };
            for i in (0..seen.view.len()).filter(|&i| covered(i)) {
                cost.covered += usize::from(index == 0);
                let taps = filter.taps_over(grid, step(i, [1, 0]), step(i, [0, 1]));
                cost.samples += 3 * taps; // X, Y, Z
            }
        }
        cost
    }
}

/// Wavelengths and samples of `pair` over `wavenumbers`, which grow, at `per_read` samples a pair of terms.
fn of_wavenumbers(
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

/// The wavenumber at which `pair` leaves the band \[µm⁻¹\].
fn largest_wavenumber(layers: &Layers, pair: &Pair) -> f64 {
    let along = pair.uvw().truncate().abs();
    (layers.band[0] / along.x.max(1e-9)).min(layers.band[1] / along.y.max(1e-9))
}
