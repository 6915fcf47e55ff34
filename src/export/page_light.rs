//! Surroundings of a page: directions that stand for parts of them, as `diffract lights` has them, and a small picture for what the surface mirrors.

use super::page_mesh::upright;
use crate::error::Result;
use crate::scene::Environment;
use glam::DVec3;
use half::f16;
use std::f64::consts::PI;

/// Largest number of directions, as in `assets/export/surroundings.glsl`.
pub const PARTS: u32 = 16;
/// Largest width of the picture \[pixels\].
const WIDTH: usize = 128;

/// Part of the surroundings, in the page's world, whose up is +y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PagePart {
    /// Unit vector toward it.
    pub direction: DVec3,
    /// Variance of its directions along each axis across `direction`.
    pub variance: f64,
    /// Irradiance of a plane that faces it, linear sRGB.
    pub irradiance: DVec3,
    /// Length of the mean of its unit vectors.
    pub mean: f64,
}

/// Surroundings of a page.
pub struct PageLight {
    /// Surroundings that all of it is of.
    environment: Environment,
    /// Parts with light.
    pub parts: Vec<PagePart>,
    /// Width of the picture in [`Self::bytes`].
    pub width: usize,
}

impl PageLight {
    /// Returns the surroundings called `name`, a built-in name.
    ///
    /// # Errors
    /// No such surroundings.
    pub fn new(name: &str) -> Result<Self> {
        let environment = Environment::open(name)?;
        let part = |i| {
            let part = environment.incident(i, PARTS);
            PagePart {
                direction: upright(part.direction.as_vec3()).as_dvec3(),
                variance: part.variance,
                irradiance: part.irradiance.as_dvec3() * (PI / f64::from(PARTS)),
                mean: part.mean,
            }
        };
        let parts = (0..PARTS).map(part).filter(|part| part.irradiance != DVec3::ZERO).collect();
        let width = environment.levels().iter().map(|level| level.size[0]).find(|w| *w <= WIDTH).unwrap_or(1);
        Ok(Self { environment, parts, width })
    }

    /// Returns the radiance from a unit vector of the page's world.
    pub fn radiance(&self, toward: DVec3) -> DVec3 {
        self.environment.radiance(DVec3::new(toward.x, -toward.z, toward.y))
    }

    /// Returns the height of a texel of the picture \[rad\].
    pub fn texel(&self) -> f64 {
        2.0 * PI / self.width as f64
    }

    /// Returns the parts, each as eight 32-bit floats: direction, variance, irradiance, mean; then the levels of the picture from the finest on, linear sRGB as
    /// 16-bit floats. All are little-endian.
    pub fn bytes(&self) -> Vec<u8> {
        let numbers = |part: &PagePart| {
            let ([x, y, z], [r, g, b]) = (part.direction.to_array(), part.irradiance.to_array());
            [x, y, z, part.variance, r, g, b, part.mean]
        };
        let parts = self.parts.iter().flat_map(numbers).flat_map(|number| (number as f32).to_le_bytes());
        let levels = self.environment.levels();
        let small = levels.iter().filter(|level| level.size[0] <= self.width);
        let texels = small.flat_map(|level| level.radiance.iter().flat_map(|c| c.to_array()));
        parts.chain(texels.flat_map(|c| f16::from_f32(c).to_le_bytes())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_the_studio_have_all_its_light_and_its_window_is_in_front_above() {
        let light = PageLight::new("studio").unwrap();
        assert_eq!(light.parts.len(), PARTS as usize);
        let sum = |normal: DVec3| -> DVec3 {
            light.parts.iter().map(|part| part.irradiance * part.direction.dot(normal).max(0.0)).sum()
        };
        // A plane that faces up, which is +z of the surroundings and +y of the page.
        let whole = light.environment.irradiance(DVec3::Z) * PI;
        assert!((sum(DVec3::Y) - whole).length() < 0.1 * whole.length(), "{} of {whole}", sum(DVec3::Y));
        assert!(sum(DVec3::Y).y > 3.0 * sum(DVec3::NEG_Y).y);
        let pane = DVec3::new(0.43, 0.73, 0.53).normalize();
        assert!(light.radiance(pane).y > 4.0, "{}", light.radiance(pane));
        assert!(light.radiance(DVec3::new(pane.x, pane.z, -pane.y)).y < 0.1);
    }

    #[test]
    fn the_picture_follows_the_parts_level_by_level() {
        let light = PageLight::new("sky").unwrap();
        let texels: usize = (0..8).map(|level| (WIDTH >> level) * (WIDTH >> (level + 1)).max(1)).sum();
        let bytes = light.bytes();
        assert_eq!([light.width, bytes.len()], [WIDTH, 32 * light.parts.len() + 6 * texels]);
        let at = |i: usize| f16::from_le_bytes([bytes[i], bytes[i + 1]]).to_f64();
        let first = DVec3::new(at(32 * light.parts.len()), at(32 * light.parts.len() + 2), 0.0);
        // The top row is the zenith.
        assert!((first - DVec3::new(0.26, 0.31, 0.0)).length() < 1e-3, "{first}");
    }
}
