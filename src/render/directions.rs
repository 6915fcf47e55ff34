//! What pixels see: the directions that a frame shades, as data.

use crate::filter::Covariance;
use glam::{DVec2, DVec3};

/// What one pixel of a frame shows, and what it was shaded for.
#[derive(Clone, Debug)]
pub struct Pixel {
    /// Linear sRGB radiance.
    pub radiance: DVec3,
    /// Its directions, one entry per light.
    pub directions: Vec<Directions>,
}

/// The directions that a frame shades.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    /// Number of the light.
    pub light_number: usize,
    /// ω_i per pixel (w: covered).
    pub light: Vec<[f32; 4]>,
    /// ω_r per pixel (w: covered).
    pub view: Vec<[f32; 4]>,
    /// du/dx, dv/dx, du/dy, dv/dy per pixel, as [`Geometry::footprints`](super::target::Geometry::footprints) has them; zero where nothing is covered. Empty where the
    /// painter was not asked for footprints.
    pub footprints: Vec<[f32; 4]>,
    /// Standard deviation of the part of the pixel filter that shading averages over \[pixels\].
    pub filter: f64,
    /// Irradiance over π of a surface that faces the light, linear sRGB; of a lamp at distance 1. A light that is not drawn in every sample is the
    /// brighter.
    pub irradiance: DVec3,
    /// How bright the light is at each pixel, as a factor of `irradiance`; empty where there are no lamps.
    pub falloffs: Vec<f32>,
    /// Radiance of the surroundings in the mirrored direction of each pixel, linear sRGB; zero where nothing is covered. Where it is not
    /// empty, the light is drawn from the surroundings, and their specular order is this.
    pub mirrored: Vec<[f32; 3]>,
    /// Number of the object that each pixel shows, from 0; 0 where nothing is covered. Empty where there is one object.
    pub objects: Vec<u8>,
}

impl Directions {
    /// Those of the pixels number `chosen` alone.
    pub fn of_pixels(&self, chosen: &[usize]) -> Self {
        fn some<T: Copy>(all: &[T], chosen: &[usize]) -> Vec<T> {
            chosen.iter().filter_map(|&i| all.get(i)).copied().collect()
        }
        Self {
            light: some(&self.light, chosen),
            view: some(&self.view, chosen),
            footprints: some(&self.footprints, chosen),
            falloffs: some(&self.falloffs, chosen),
            mirrored: some(&self.mirrored, chosen),
            objects: some(&self.objects, chosen),
            ..*self
        }
    }

    /// The object that pixel number `i` shows.
    pub fn object(&self, i: usize) -> usize {
        self.objects.get(i).map_or(0, |&object| object.into())
    }

    /// Irradiance over π at pixel number `i` of a surface that faces the light, linear sRGB.
    pub fn irradiance(&self, i: usize) -> DVec3 {
        self.irradiance * self.falloffs.get(i).map_or(1.0, |&falloff| f64::from(falloff))
    }

    /// What shading averages over at pixel number `i`; nothing where the painter was not asked for footprints.
    pub fn covariance(&self, i: usize) -> Covariance {
        let Some(&footprint) = self.footprints.get(i) else { return Covariance::default() };
        let [a, b, c, d] = footprint.map(f64::from);
        Covariance::of_footprint(DVec2::new(a, b), DVec2::new(c, d), self.filter)
    }
}
