//! What a frame does, counted: the same loops as `shaders/diffraction.glsl`, in f64.

use crate::optics::geometry::Pair;
use crate::precompute::Layers;
use crate::render::color_table::{Filter, Grid};
use crate::render::picture::Directions;
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
    /// Hardware samples of the layers, over all pixels and lights.
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
        let mut cost = Self::default();
        for (index, seen) in directions.iter().enumerate() {
            for (light, view) in seen.light.iter().zip(&seen.view) {
                if view[3] == 0.0 {
                    continue;
                }
                cost.covered += usize::from(index == 0);
                let vector = |v: &[f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
                let (wavelengths, samples) = of_pair(layers, combs, &Pair::new(vector(light), vector(view)));
                cost.wavelengths += wavelengths;
                cost.samples += samples;
            }
        }
        cost
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
            // To the other pixel of a quad's row or column, as derivatives are taken.
            let step =
                |i: usize, other: usize| if covered(other) { toward(other) - toward(i) } else { DVec2::ZERO };
            let width = size[0] as usize;
            for i in (0..seen.view.len()).filter(|&i| covered(i)) {
                cost.covered += usize::from(index == 0);
                let (x, y) = (i % width, i / width);
                let below = if (y ^ 1) < size[1] as usize { (y ^ 1) * width + x } else { i };
                let beside = if (x ^ 1) < width { y * width + (x ^ 1) } else { i };
                let taps = filter.taps_over(grid, step(i, beside), step(i, below));
                cost.samples += 3 * taps; // X, Y, Z
            }
        }
        cost
    }
}

/// Wavelengths and samples of one pair of directions.
fn of_pair(layers: &Layers, combs: &Combs, pair: &Pair) -> (usize, usize) {
    if !pair.above_horizon() {
        return (0, 0);
    }
    let uvw = pair.uvw();
    let nodes = combs.nodes_at(uvw.truncate().length());
    let in_band = |q: f64| (uvw.x * q).abs() <= layers.band[0] && (uvw.y * q).abs() <= layers.band[1];
    let per_read = layers.interpolation.kernel.samples() as usize;
    nodes.iter().map(|node| f64::from(node[3])).take_while(|&q| in_band(q)).fold(
        (0, 0),
        |(count, samples), q| {
            let pairs = layers.terms_at(2.0 * PI * q * -uvw.z).div_ceil(2);
            (count + 1, samples + pairs * per_read)
        },
    )
}
