//! Conversion between spatial frequencies of the surface and directions of light: (u, v) = −ω_i − ω_r, and the first
//! order of the frequency f is at (u, v) = λ f.

use glam::DVec2;

/// Returns the horizontal part of the direction into which the frequency `f` \[1/µm\] diffracts `wavelength` \[µm\]
/// from `light` (the horizontal part of ω_i); `None` if that order is evanescent.
pub fn direction(f: DVec2, wavelength: f64, light: DVec2) -> Option<DVec2> {
    let toward = -light - f * wavelength;
    (toward.length_squared() <= 1.0).then_some(toward)
}

/// Returns centre and radius of the disc of frequencies \[1/µm\] whose first orders of `wavelength` \[µm\] from `light`
/// propagate.
pub fn visible(wavelength: f64, light: DVec2) -> (DVec2, f64) {
    (-light / wavelength, 1.0 / wavelength)
}

/// Returns length \[µm\] and azimuth \[degrees, 0 to 180\] of the period of the frequency `f` \[1/µm\].
pub fn period(f: DVec2) -> [f64; 2] {
    [1.0 / f.length(), f.y.atan2(f.x).to_degrees().rem_euclid(180.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::geometry::{Pair, direction as unit};

    #[test]
    fn frequencies_and_directions_are_those_of_the_grating_equation() {
        let light = unit(25.0, 40.0);
        let view = unit(50.0, 190.0);
        let uv = Pair::new(light, view).uvw().truncate();
        let toward = direction(uv / 0.6, 0.6, light.truncate()).unwrap();
        assert!((toward - view.truncate()).length() < 1e-12);
        // Normal incidence: d sin θ = λ.
        let toward = direction(DVec2::new(1.0 / 1.2, 0.0), 0.6, DVec2::ZERO).unwrap();
        assert!((toward.length() - 0.5).abs() < 1e-12);
        assert_eq!(direction(DVec2::new(2.0, 0.0), 0.6, DVec2::ZERO), None);
        assert_eq!(period(DVec2::new(0.0, -0.8)), [1.25, 90.0]);
    }

    #[test]
    fn the_disc_of_visible_frequencies_ends_at_the_horizon() {
        let light = unit(60.0, 10.0).truncate();
        let (middle, radius) = visible(0.55, light);
        for i in 0..36u8 {
            let at = DVec2::from_angle(f64::from(i) * 0.1745) * radius;
            assert!(direction(middle + at * 0.999, 0.55, light).is_some());
            assert!(direction(middle + at * 1.001, 0.55, light).is_none());
        }
        // The frequency 0 is the specular direction.
        assert!((direction(DVec2::ZERO, 0.55, light).unwrap() + light).length() < 1e-12);
    }
}
