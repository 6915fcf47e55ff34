//! Radiance of the surroundings in the mirrored direction, averaged over a pixel and over the spread of the specular order.

use crate::scene::Environment;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Directions of the mean. The radiance of surroundings is a picture of pixels, whose edges this many directions soften to about a hundredth.
const COUNT: u32 = 256;
/// Turn between one direction and the next: the golden angle, by which places on a disc are evenly apart (Vogel 1979).
const GOLDEN: f64 = 0.381_966_011_250_105_1 * TAU;

/// Gaussian of directions around a mirrored one, by the components in the tangent plane. There the specular order spreads evenly, whatever the angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflection {
    /// Columns T, B and N of the surface, N to the side of the direction.
    pub frame: DMat3,
    /// Mirrored direction, by T and B.
    pub middle: DVec2,
    /// Change of `middle` over one standard deviation of the pixel filter, to the right and downward.
    pub change: [DVec2; 2],
    /// Variance of the specular order along each axis.
    pub spread: f64,
}

impl Reflection {
    /// Averages the radiance of `environment`, linear sRGB.
    pub fn radiance(&self, environment: &Environment) -> DVec3 {
        let [right, down] = self.change;
        let products = |a: fn(DVec2) -> f64, b: fn(DVec2) -> f64| a(right) * b(right) + a(down) * b(down);
        let (x, y): (fn(DVec2) -> f64, fn(DVec2) -> f64) = (|v| v.x, |v| v.y);
        let [xx, xy, yy] = [products(x, x) + self.spread, products(x, y), products(y, y) + self.spread];
        // Cholesky's root of the covariance.
        let first = xx.sqrt().max(f64::MIN_POSITIVE);
        let root = [DVec2::new(first, xy / first), DVec2::new(0.0, (yy - (xy / first).powi(2)).max(0.0).sqrt())];
        let sum: DVec3 = (0..COUNT).map(|i| environment.radiance(self.toward(root, i))).sum();
        sum / f64::from(COUNT)
    }

    /// Returns direction number `i`. Beyond the horizon it is the nearest above.
    fn toward(&self, root: [DVec2; 2], i: u32) -> DVec3 {
        // Each ring of a Gaussian between two radii has as much weight as the next.
        let radius = (-2.0 * (1.0 - (f64::from(i) + 0.5) / f64::from(COUNT)).ln()).sqrt();
        let place = DVec2::from_angle(GOLDEN * f64::from(i)) * radius;
        let tangential = (self.middle + root[0] * place.x + root[1] * place.y).clamp_length_max(1.0);
        let up = (1.0 - tangential.length_squared()).max(0.0).sqrt();
        self.frame * tangential.extend(up)
    }
}
