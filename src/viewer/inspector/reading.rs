//! Data of a pixel of the picture: its radiance and the directions it was shaded for.

use crate::filter::Covariance;
use crate::optics::geometry::Pair;
use crate::render::directions::{Directions, Pixel};
use crate::render::frame::View;
use crate::render::reference_picture::unit;
use crate::viewer::prepared::Prepared;
use glam::DVec3;
use std::sync::Arc;

/// Data of a pixel of the picture.
#[derive(Clone)]
pub struct Reading {
    /// Number, larger than that of any earlier reading.
    pub number: u64,
    /// Surface and settings of the picture.
    pub prepared: Arc<Prepared>,
    /// Camera and lights of the picture.
    pub view: View,
    /// Linear sRGB radiance.
    pub radiance: DVec3,
    /// Directions under each light.
    pub lights: Vec<LightAt>,
    /// Directions in the form that the reference takes, one entry per light.
    pub directions: Vec<Directions>,
}

/// Light at a pixel.
#[derive(Clone, Copy, Debug)]
pub struct LightAt {
    /// Directions in the tangent frame of the surface.
    pub pair: Pair,
    /// Standard deviations of (u, v) over the pixel, along the longer and the shorter axis.
    pub footprint: [f64; 2],
}

impl Reading {
    /// Makes the reading of `pixel` in the picture of `view`, drawn from `prepared`.
    pub fn new(number: u64, prepared: Arc<Prepared>, view: View, pixel: Pixel) -> Self {
        let Pixel { radiance, directions } = pixel;
        let light = |seen: &Directions| LightAt {
            pair: Pair::new(unit(seen.light[0]), unit(seen.view[0])),
            footprint: axes(&seen.covariance(0)),
        };
        let lights = directions.iter().map(light).collect();
        Self { number, prepared, view, radiance, lights, directions }
    }

    /// Returns the display name of light number `light`.
    pub fn light_name(&self, light: usize) -> String {
        if light < self.view.lights.len() {
            format!("light {}", light + 1)
        } else {
            "surroundings".to_owned()
        }
    }
}

fn axes(covariance: &Covariance) -> [f64; 2] {
    covariance.axes().map(|variance| variance.max(0.0).sqrt())
}

impl LightAt {
    /// Returns true if the light or the viewer is below the horizon, so that the pixel is dark.
    pub fn is_dark(&self) -> bool {
        !self.pair.above_horizon()
    }

    /// Returns θ and φ \[degrees\] of the light and of the viewer.
    pub fn angles(&self) -> [[f64; 2]; 2] {
        [self.pair.light, self.pair.view].map(|d| {
            let theta = d.truncate().length().atan2(d.z);
            [theta, d.y.atan2(d.x)].map(f64::to_degrees)
        })
    }

    /// Returns the period \[µm\] of the Fourier component of the surface whose first order diffracts `wavelength`
    /// \[µm\] from this light to this viewer: λ/|(u, v)|. Infinite in the specular direction.
    pub fn period(&self, wavelength: f64) -> f64 {
        wavelength / self.pair.uvw().truncate().length()
    }

    /// Returns the azimuth of that period's wave vector \[degrees\], from +T toward +B, 0 to 180.
    pub fn azimuth(&self) -> f64 {
        let uv = self.pair.uvw().truncate();
        uv.y.atan2(uv.x).to_degrees().rem_euclid(180.0)
    }

    /// Returns the input of `diffract eval` for these directions, with its header.
    pub fn query(&self) -> String {
        let [[theta_i, phi_i], [theta_r, phi_r]] = self.angles();
        format!("theta_i,phi_i,theta_r,phi_r\n{theta_i},{phi_i},{theta_r},{phi_r}\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::geometry::direction;

    fn light(theta_i: f64, phi_i: f64, theta_r: f64, phi_r: f64) -> LightAt {
        LightAt { pair: Pair::new(direction(theta_i, phi_i), direction(theta_r, phi_r)), footprint: [0.0; 2] }
    }

    #[test]
    fn angles_are_those_of_the_directions() {
        let [[theta_i, phi_i], [theta_r, phi_r]] = light(35.0, -50.0, 0.02, 170.0).angles();
        for (found, exact) in [(theta_i, 35.0), (phi_i, -50.0), (theta_r, 0.02), (phi_r, 170.0)] {
            assert!((found - exact).abs() < 1e-9, "{found} {exact}");
        }
    }

    #[test]
    fn the_period_is_that_of_the_grating_equation() {
        // Normal incidence: d sin θ = λ.
        let seen = light(0.0, 0.0, 30.0, 0.0);
        assert!((seen.period(0.5) - 1.0).abs() < 1e-12 && seen.azimuth().abs() < 1e-9);
        let seen = light(20.0, 90.0, 50.0, 90.0);
        let exact = 0.55 / (20f64.to_radians().sin() + 50f64.to_radians().sin());
        assert!((seen.period(0.55) / exact - 1.0).abs() < 1e-12 && (seen.azimuth() - 90.0).abs() < 1e-9);
        assert!(light(40.0, 0.0, 40.0, 180.0).period(0.5) > 1e12);
    }

    #[test]
    fn the_query_has_the_columns_of_eval_and_every_digit() {
        let seen = light(35.0, -50.0, 20.0, 10.0);
        let text = seen.query();
        let (header, row) = text.trim_end().split_once('\n').unwrap();
        assert_eq!(header, "theta_i,phi_i,theta_r,phi_r");
        let numbers: Vec<f64> = row.split(',').map(|n| n.parse().unwrap()).collect();
        let again = Pair::new(direction(numbers[0], numbers[1]), direction(numbers[2], numbers[3]));
        assert!((again.light - seen.pair.light).length() + (again.view - seen.pair.view).length() < 1e-14);
    }
}
