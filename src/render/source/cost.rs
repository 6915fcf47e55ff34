//! Work of a frame, counted in f64 over the directions that it shades.

use crate::filter::Covariance;
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
    /// Texture samples, over all pixels and lights: hardware samples, or interpolated ones along a line.
    pub samples: usize,
}

/// Pixel and light to shade.
pub(super) struct LitPixel {
    /// Directions.
    pub pair: Pair,
    /// Covariance that shading averages over.
    pub footprint: Covariance,
}

impl Cost {
    /// Returns the samples per covered pixel.
    pub fn samples_per_pixel(&self) -> f64 {
        self.samples as f64 / self.covered.max(1) as f64
    }

    /// Returns the wavelengths per covered pixel.
    pub fn wavelengths_per_pixel(&self) -> f64 {
        self.wavelengths as f64 / self.covered.max(1) as f64
    }

    /// Sums the wavelengths and samples that `of_pixel` returns for each light that reaches a pixel.
    pub(super) fn counted(directions: &[Directions], of_pixel: impl Fn(&LitPixel) -> (usize, usize)) -> Self {
        let mut cost = Self::default();
        for (index, seen) in directions.iter().enumerate() {
            for (i, (light, view)) in seen.light.iter().zip(&seen.view).enumerate() {
                if view[3] == 0.0 {
                    continue;
                }
                cost.covered += usize::from(index == 0);
                let vector = |v: &[f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
                let pair = Pair::new(vector(light), vector(view));
                if !pair.above_horizon() {
                    continue;
                }
                let (wavelengths, samples) = of_pixel(&LitPixel { pair, footprint: seen.covariance(i) });
                cost.wavelengths += wavelengths;
                cost.samples += samples;
            }
        }
        cost
    }
}
