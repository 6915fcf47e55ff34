//! Directions in the tangent frame and the quantities that the optics derives from a pair of them.

use glam::DVec3;

/// Returns sine and cosine of an angle in degrees, exact at every multiple of 90°, so that a direction in the horizon has a cosine of 0 and
/// not of 6e-17 (by which the geometric factor would divide).
pub fn sin_cos_degrees(angle: f64) -> (f64, f64) {
    let turn = angle.rem_euclid(360.0);
    let quadrant = (turn / 90.0).floor();
    let (s, c) = (turn - quadrant * 90.0).to_radians().sin_cos();
    match quadrant as i64 & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Returns the unit vector at polar angle `theta` from +N and azimuth `phi` from +T toward +B \[degrees\].
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    let (sin_theta, cos_theta) = sin_cos_degrees(theta);
    let (sin_phi, cos_phi) = sin_cos_degrees(phi);
    DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

/// Returns polar angle and azimuth of a unit vector \[degrees\], as [`direction`] takes them, the azimuth from 0 to 360; that of the normal is 0.
pub fn angles(direction: DVec3) -> (f64, f64) {
    let across = direction.truncate().length();
    let azimuth =
        if across < 1e-12 { 0.0 } else { direction.y.atan2(direction.x).to_degrees().rem_euclid(360.0) };
    // Rounding brings a direction just below +x to −0° or 360°.
    let azimuth = if azimuth > 360.0 - 1e-9 { 0.0 } else { azimuth + 0.0 };
    (across.atan2(direction.z).to_degrees(), azimuth)
}

/// Pair of a light and a view direction, both away from the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// ω_i, to the light.
    pub light: DVec3,
    /// ω_r, to the viewer.
    pub view: DVec3,
}

impl Pair {
    /// Returns the pair of unit vectors `light` = ω_i and `view` = ω_r.
    pub fn new(light: DVec3, view: DVec3) -> Self {
        Self { light, view }
    }

    /// Returns true if both directions are above the surface; below the horizon nothing is reflected.
    pub fn above_horizon(&self) -> bool {
        self.light.z > 0.0 && self.view.z > 0.0
    }

    /// Returns (u, v, w) = −ω_i − ω_r, dimensionless, with w ≤ 0 above the horizon and a length of at most 2.
    pub fn uvw(&self) -> DVec3 {
        -self.light - self.view
    }

    /// Returns the cosine between either direction and the half vector: |(u, v, w)|/2, because ω_i·(ω_i + ω_r) = |ω_i + ω_r|²/2 for unit
    /// vectors.
    pub fn cos_half_angle(&self) -> f64 {
        self.uvw().length() / 2.0
    }

    /// Returns G · cos θ_i with G = (1 + ω_i·ω_r)²/(cos θ_i cos θ_r) (\[Single 2014\] B.13). The sum 1 + ω_i·ω_r cancels near opposite
    /// grazing directions; (u² + v² + w²)/2 equals it and does not.
    pub fn geometric_factor_times_cos_light(&self) -> f64 {
        let one_plus_dot = self.uvw().length_squared() / 2.0;
        one_plus_dot * one_plus_dot / self.view.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_of_a_direction_are_those_that_made_it() {
        for (theta, phi) in [(0.0, 0.0), (1e-4, 359.0), (30.0, 180.0), (75.0, 270.0), (89.0, 12.5)] {
            let (found_theta, found_phi) = angles(direction(theta, phi));
            assert!((found_theta - theta).abs() < 1e-9 && (found_phi - phi).abs() < 1e-7);
        }
        assert_eq!(angles(DVec3::new(0.5, -1e-17, 0.75f64.sqrt())).1, 0.0);
    }

    #[test]
    fn directions_in_the_horizon_have_a_cosine_of_exactly_zero() {
        for phi in [0.0, 37.0, 180.0] {
            assert_eq!(direction(90.0, phi).z, 0.0);
            assert_eq!(direction(-90.0, phi).z, 0.0);
        }
        assert_eq!(direction(0.0, 12.0), DVec3::Z);
        assert_eq!(direction(90.0, 90.0), DVec3::Y);
        assert_eq!(direction(90.0, 180.0), DVec3::NEG_X);
        assert!((direction(30.0, 0.0) - DVec3::new(0.5, 0.0, 0.75f64.sqrt())).length() < 1e-15);
    }

    #[test]
    fn the_geometric_factor_does_not_cancel_at_opposite_grazing_directions() {
        // θ_i = θ_r = 90° − δ on opposite sides: 1 + ω_i·ω_r = 1 − cos 2δ … = 2 sin²δ, so G cos θ_i = 4 sin³δ.
        let delta: f64 = 1e-7;
        let (s, c) = delta.sin_cos();
        let pair = Pair::new(DVec3::new(c, 0.0, s), DVec3::new(-c, 0.0, s));
        let exact = 4.0 * s.powi(3);
        assert!((pair.geometric_factor_times_cos_light() / exact - 1.0).abs() < 1e-12);
    }
}
