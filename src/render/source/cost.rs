//! What a frame does, counted in f64 over the directions that it shades.

use crate::optics::geometry::Pair;
use crate::render::directions::Directions;
use glam::DVec3;

/// Work of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Pixels that the mesh covers.
    pub covered: usize,
    /// Wavelengths summed, over all pixels and lights.
    pub wavelengths: usize,
    /// Texture samples, over all pixels and lights: of the hardware, or interpolated along a line.
    pub samples: usize,
}

impl Cost {
    /// Samples per covered pixel.
    pub fn samples_per_pixel(&self) -> f64 {
        self.samples as f64 / self.covered.max(1) as f64
    }

    /// Wavelengths per covered pixel.
    pub fn wavelengths_per_pixel(&self) -> f64 {
        self.wavelengths as f64 / self.covered.max(1) as f64
    }

    /// Counts what `of_pair` says of each pair of directions above the horizon: wavelengths and samples.
    pub(super) fn counted(directions: &[Directions], of_pair: impl Fn(&Pair) -> (usize, usize)) -> Self {
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
