//! Limit of energy: no surface reflects more than a flat one of its material.
//!
//! E(ω) is the directional albedo of the theory in use, the share of the light from ω that it sends into all directions, the specular order
//! included; R(ω) is Fresnel's reflectance of a flat surface. Where E > R the theory makes light. The BRDF is divided by max(1, E(ω_i)/R(ω_i), E(ω_r)/R(ω_r)), which is reciprocal and
//! leaves it as it is where E ≤ R. Both E and R are of unpolarised light, because R of TM vanishes at Brewster's angle.

use super::geometry::Pair;
use glam::DVec3;
use std::fmt::Debug;

/// Divisor of the BRDF of one surface.
pub trait EnergyLimit: Debug + Send + Sync {
    /// Returns E/R for light from `direction` at `wavelength` \[µm\], from all orders.
    fn excess(&self, direction: DVec3, wavelength: f64) -> f64;

    /// Returns E/R interpolated between tabulated directions and wavelengths of visible light, for sums over many of them.
    fn tabulated_excess(&self, direction: DVec3, wavelength: f64) -> f64;

    /// Returns the divisor for a single wavelength \[µm\].
    fn single(&self, pair: &Pair, wavelength: f64) -> f64 {
        self.excess(pair.light, wavelength).max(self.excess(pair.view, wavelength)).max(1.0)
    }

    /// Returns the divisor for a wavelength \[µm\] of a colour.
    fn in_colours(&self, pair: &Pair, wavelength: f64) -> f64 {
        let excess = |direction| self.tabulated_excess(direction, wavelength);
        excess(pair.light).max(excess(pair.view)).max(1.0)
    }
}

/// Directions above the surface on a square of [`Self::SIDE`]² points, ends included: Lambert's equal-area projection (x, y)/√(1 + z), in which quantities that are smooth in
/// cos θ stay smooth up to the horizon. Points beyond the horizon stand for the nearest direction above it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DirectionGrid;

impl DirectionGrid {
    /// Points along a side.
    pub const SIDE: usize = 64;
    /// Number of points.
    pub const COUNT: usize = Self::SIDE * Self::SIDE;

    /// Returns the direction of a point.
    pub fn direction(number: usize) -> DVec3 {
        /// Smallest cosine: a direction just above the horizon.
        const LOWEST: f64 = 1e-4;
        let at = |i: usize| 2.0 * i as f64 / (Self::SIDE - 1) as f64 - 1.0;
        let [x, y] = [at(number % Self::SIDE), at(number / Self::SIDE)];
        let squared = x * x + y * y;
        let z = (1.0 - squared).max(LOWEST);
        let across = (1.0 - z * z).sqrt();
        let scale = if squared > 0.0 { across / squared.sqrt() } else { 0.0 };
        DVec3::new(x * scale, y * scale, z)
    }

    /// Returns whether a point, or one beside it, is above the horizon; others are never read.
    pub fn is_read(number: usize) -> bool {
        let at = |i: usize| (2.0 * i as f64 / (Self::SIDE - 1) as f64 - 1.0).abs() - 2.0 / (Self::SIDE - 1) as f64;
        let [x, y] = [at(number % Self::SIDE), at(number / Self::SIDE)].map(|x| x.max(0.0));
        x * x + y * y <= 1.0
    }

    /// Interpolates `value` of the points around a direction above the horizon.
    pub fn interpolate(direction: DVec3, value: impl Fn(usize) -> f64) -> f64 {
        let place = direction.truncate() / (1.0 + direction.z.clamp(0.0, 1.0)).sqrt();
        let place = (place + 1.0) * (0.5 * (Self::SIDE - 1) as f64);
        let place = place.clamp(glam::DVec2::ZERO, glam::DVec2::splat((Self::SIDE - 1) as f64));
        let corner = place.floor().min(glam::DVec2::splat((Self::SIDE - 2) as f64));
        let share = place - corner;
        let first = corner.y as usize * Self::SIDE + corner.x as usize;
        let row = |first: usize| value(first) * (1.0 - share.x) + value(first + 1) * share.x;
        row(first) * (1.0 - share.y) + row(first + Self::SIDE) * share.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::geometry::direction;

    #[test]
    fn directions_are_found_where_they_stand() {
        for number in (0..DirectionGrid::COUNT).step_by(37) {
            let at = DirectionGrid::direction(number);
            assert!((at.length() - 1.0).abs() < 1e-12 && at.z > 0.0);
        }
        // Functions that are linear in the projection come back exactly, and cos θ nearly.
        for (theta, phi) in [(0.0, 0.0), (30.0, 10.0), (60.0, 200.0), (85.0, 300.0), (89.9, 45.0)] {
            let asked = direction(theta, phi);
            let cosine = DirectionGrid::interpolate(asked, |number| DirectionGrid::direction(number).z);
            assert!((cosine - asked.z).abs() < 1e-3, "{theta} {phi}: {cosine} {}", asked.z);
        }
    }
}
