//! Directions seen by the pixels of a frame, as data.

use crate::filter::Covariance;
use crate::scene::Incident;
use glam::{DVec2, DVec3};

/// Radiance of one pixel of a frame, and the directions it was shaded for.
#[derive(Clone, Debug)]
pub struct Pixel {
    /// Linear sRGB radiance.
    pub radiance: DVec3,
    /// Directions, one entry per light.
    pub directions: Vec<Directions>,
}

/// The directions that a frame shades.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    /// Number of the light.
    pub light_number: usize,
    /// ω_i per pixel (w: 1 if covered).
    pub light: Vec<[f32; 4]>,
    /// ω_r per pixel (w: 1 if covered).
    pub view: Vec<[f32; 4]>,
    /// du/dx, dv/dx, du/dy, dv/dy per pixel, x to the right and y downward; zero at uncovered pixels. Empty if rays were
    /// cast without them.
    pub footprints: Vec<[f32; 4]>,
    /// Standard deviation of the part of the pixel filter that shading averages over \[pixels\].
    pub filter: f64,
    /// Light samples, one or several among which pixels choose. Their irradiance is scaled up for a light that only some of
    /// the samples of a picture draw.
    pub incidents: Vec<Incident>,
    /// Number of the light sample of each pixel; empty if there is one.
    pub chosen: Vec<u8>,
    /// Brightness of the light at each pixel as a factor of that of its sample: the falloff of a lamp, and the visible share
    /// at the edges of shadows. Empty if it is 1 everywhere.
    pub falloffs: Vec<f32>,
    /// Radiance of the surroundings in the mirrored direction of each pixel, linear sRGB; zero at uncovered pixels. If
    /// not empty, the light is drawn from the surroundings, and these values give their specular order.
    pub mirrored: Vec<[f32; 3]>,
    /// Number of the object at each pixel, from 0; 0 at uncovered pixels. Empty if there is one object.
    pub objects: Vec<u8>,
}

impl Directions {
    /// Returns the directions of the pixels with the numbers `chosen`.
    pub fn of_pixels(&self, chosen: &[usize]) -> Self {
        fn some<T: Copy>(all: &[T], chosen: &[usize]) -> Vec<T> {
            chosen.iter().filter_map(|&i| all.get(i)).copied().collect()
        }
        Self {
            light: some(&self.light, chosen),
            view: some(&self.view, chosen),
            footprints: some(&self.footprints, chosen),
            incidents: self.incidents.clone(),
            chosen: some(&self.chosen, chosen),
            falloffs: some(&self.falloffs, chosen),
            mirrored: some(&self.mirrored, chosen),
            objects: some(&self.objects, chosen),
            ..*self
        }
    }

    /// Returns the number of the object at pixel number `i`.
    pub fn object(&self, i: usize) -> usize {
        self.objects.get(i).map_or(0, |&object| object.into())
    }

    /// Returns the light sample of pixel number `i`.
    pub fn incident(&self, i: usize) -> Incident {
        let number = self.chosen.get(i).map_or(0, |&number| number.into());
        self.incidents.get(number).copied().unwrap_or(Incident::NONE)
    }

    /// Returns the irradiance over π at pixel number `i` of a surface that faces the light, linear sRGB.
    pub fn irradiance(&self, i: usize) -> DVec3 {
        let falloff = self.falloffs.get(i).map_or(1.0, |&falloff| f64::from(falloff));
        self.incident(i).irradiance.as_dvec3() * falloff
    }

    /// Returns the covariance of (u, v) that shading averages over at pixel number `i`; zero without footprints.
    pub fn covariance(&self, i: usize) -> Covariance {
        let Some(&footprint) = self.footprints.get(i) else { return Covariance::default() };
        let [a, b, c, d] = footprint.map(f64::from);
        Covariance::of_footprint(DVec2::new(a, b), DVec2::new(c, d), self.filter)
    }
}
