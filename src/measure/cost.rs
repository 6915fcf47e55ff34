//! What a frame does, counted: the same loops as `shaders/diffraction.glsl`, in f64.

use crate::optics::geometry::Pair;
use crate::precompute::Layers;
use crate::render::picture::Directions;
use crate::render::tables::Combs;
use glam::DVec3;
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

/// Wavelengths and samples of one pair of directions.
fn of_pair(layers: &Layers, combs: &Combs, pair: &Pair) -> (usize, usize) {
    if !pair.above_horizon() {
        return (0, 0);
    }
    let uvw = pair.uvw();
    let nodes = combs.nodes_at(uvw.truncate().length());
    let in_band = |q: f64| (uvw.x * q).abs() <= layers.band[0] && (uvw.y * q).abs() <= layers.band[1];
    let per_read = layers.interpolation.samples() as usize;
    nodes.iter().map(|node| f64::from(node[3])).take_while(|&q| in_band(q)).fold(
        (0, 0),
        |(count, samples), q| {
            let pairs = layers.pairs_at(2.0 * PI * q * -uvw.z);
            (count + 1, samples + pairs * per_read)
        },
    )
}
