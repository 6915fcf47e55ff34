//! Radiance of the surroundings in the mirrored direction, averaged over a pixel and over the spread of the specular
//! order.

use crate::scene::Environment;
use glam::{DMat2, DMat3, DVec2, DVec3};
use std::f64::consts::TAU;

/// Directions of the mean. The radiance is a picture of pixels, whose edges this number of directions smooths to about
/// 1 %.
const COUNT: u32 = 256;
/// Angle between one direction and the next: the golden angle, which spreads points evenly over a disc (Vogel 1979).
const GOLDEN: f64 = 0.381_966_011_250_105_1 * TAU;

/// Gaussian distribution of directions around a mirrored one, in the components of the tangent plane. In these the
/// specular order has the same spread at every angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflection {
    /// Columns T, B and N of the surface, N on the side of the direction.
    pub frame: DMat3,
    /// Components of the mirrored direction along T and B.
    pub middle: DVec2,
    /// Change of `middle` over one standard deviation of the pixel filter, to the right and downward.
    pub change: [DVec2; 2],
    /// Variance of the specular order along each axis.
    pub spread: f64,
}

impl Reflection {
    /// Averages the radiance of `environment`, linear sRGB.
    pub fn radiance(&self, environment: &Environment) -> DVec3 {
        let change = DMat2::from_cols(self.change[0], self.change[1]);
        let covariance = change * change.transpose() + DMat2::from_diagonal(DVec2::splat(self.spread));
        let [xx, xy, yy] = [covariance.x_axis.x, covariance.x_axis.y, covariance.y_axis.y];
        // Cholesky's root of the covariance.
        let first = xx.sqrt().max(f64::MIN_POSITIVE);
        let root =
            [DVec2::new(first, xy / first), DVec2::new(0.0, (yy - (xy / first).powi(2)).max(0.0).sqrt())];
        let sum: DVec3 = (0..COUNT).map(|i| environment.radiance(self.toward(root, i))).sum();
        sum / f64::from(COUNT)
    }

    /// Returns direction number `i`; beyond the horizon, the nearest one on it.
    fn toward(&self, root: [DVec2; 2], i: u32) -> DVec3 {
        // Rings of equal weight of a Gaussian.
        let radius = (-2.0 * (1.0 - (f64::from(i) + 0.5) / f64::from(COUNT)).ln()).sqrt();
        let place = DVec2::from_angle(GOLDEN * f64::from(i)) * radius;
        let tangential = (self.middle + root[0] * place.x + root[1] * place.y).clamp_length_max(1.0);
        let up = (1.0 - tangential.length_squared()).max(0.0).sqrt();
        self.frame * tangential.extend(up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Returns the mean of `radiance` over a reflection toward `middle`, with a pixel that changes it by 0.02 along T
    /// and 0.01 along B.
    fn mean(middle: DVec2, spread: f64, radiance: &dyn Fn(DVec3) -> Vec3) -> DVec3 {
        let change = [DVec2::X * 0.02, DVec2::Y * 0.01];
        Reflection { frame: DMat3::IDENTITY, middle, change, spread }.radiance(&Environment::of(radiance))
    }

    #[test]
    fn a_mean_of_radiance_has_the_moments_of_its_gaussian() {
        let middle = DVec2::new(0.3, -0.2);
        let of_offset = |d: DVec3| {
            let x = d.truncate() - middle;
            (x * x).extend(x.x * x.y).as_vec3() + 1.0
        };
        let found = mean(middle, 1e-3, &of_offset) - 1.0;
        let exact = DVec3::new(0.02f64.powi(2) + 1e-3, 0.01f64.powi(2) + 1e-3, 0.0);
        // Error of 256 directions and of pixels whose side has a variance of 1.3e-5.
        assert!((found - exact).abs().max_element() < 6e-5, "{found} instead of {exact}");
    }

    #[test]
    fn even_surroundings_are_mirrored_as_they_are_at_any_angle() {
        for middle in [DVec2::ZERO, DVec2::new(0.999, 0.0)] {
            let found = mean(middle, 1e-2, &|_| Vec3::new(1.0, 2.0, 0.5));
            assert!((found - DVec3::new(1.0, 2.0, 0.5)).length() < 1e-6, "{found}");
        }
    }
}
