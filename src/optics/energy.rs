//! Limit of energy: no surface reflects more than a flat one of its material.
//!
//! E(ω) is the directional albedo of the theory in use, the share of the light from ω that it sends into all
//! directions, the specular order included; R(ω) is Fresnel's reflectance of a flat surface. Where E > R the theory
//! makes light. The BRDF is divided by max(1, E(ω_i)/R(ω_i), E(ω_r)/R(ω_r)), which is reciprocal and leaves it as it is
//! where E ≤ R. Both E and R are of unpolarised light, because R of TM vanishes at Brewster's angle.

use super::geometry::Pair;
use super::spectrum::Illuminant;
use glam::{DVec2, DVec3};
use std::fmt::Debug;

/// Divisor of the BRDF of one surface.
pub trait EnergyLimit: Debug + Send + Sync {
    /// Returns the divisor for a single wavelength \[µm\].
    fn single(&self, pair: &Pair, wavelength: f64) -> f64;

    /// Returns the divisor for the colour of light of this spectrum: X, Y and Z have one, so that hues stay.
    fn colour(&self, pair: &Pair, illuminant: &Illuminant) -> f64;
}

/// Directions above the surface on a square of [`Self::SIDE`]² points, ends included. A direction stands at
/// (x, y)/√((1 + √z)(1 + z)), whose distance from the middle is √(1 − √cos θ): points are dense near the horizon, where
/// albedos change most. Points beyond the horizon stand for the nearest direction above it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DirectionGrid;

impl DirectionGrid {
    /// Points along a side. It is odd, so that one stands at the normal: there the albedo of a symmetric grating has a peak,
    /// because its orders on both sides appear at the same wavelengths.
    pub const SIDE: usize = 65;
    /// Number of points.
    pub const COUNT: usize = Self::SIDE * Self::SIDE;

    /// Returns the place of a point in the square from −1 to 1.
    fn place(number: usize) -> DVec2 {
        let at = |i: usize| 2.0 * i as f64 / (Self::SIDE - 1) as f64 - 1.0;
        DVec2::new(at(number % Self::SIDE), at(number / Self::SIDE))
    }

    /// Returns the direction of a point.
    pub fn direction(number: usize) -> DVec3 {
        /// Smallest root of a cosine: a direction just above the horizon.
        const LOWEST: f64 = 0.01;
        let place = Self::place(number);
        let z = (1.0 - place.length_squared()).max(LOWEST).powi(2);
        (place.normalize_or_zero() * (1.0 - z * z).sqrt()).extend(z)
    }

    /// Returns the weight of a point in integrals over cos θ dω.
    pub fn weight(number: usize) -> f64 {
        // cos θ = (1 − r²)², and dω = 4 (1 − r²) dA.
        (1.0 - Self::place(number).length_squared()).max(0.0).powi(3)
    }

    /// Returns true if the point or one beside it is above the horizon; others are never read.
    pub fn is_read(number: usize) -> bool {
        let step = 2.0 / (Self::SIDE - 1) as f64;
        (Self::place(number).abs() - step).max(DVec2::ZERO).length_squared() <= 1.0
    }

    /// Interpolates `value` of the points around a direction above the horizon.
    pub fn interpolate(direction: DVec3, value: impl Fn(usize) -> f64) -> f64 {
        let z = direction.z.clamp(0.0, 1.0);
        let place = direction.truncate() / ((1.0 + z.sqrt()) * (1.0 + z)).sqrt();
        let place = (place + 1.0) * (0.5 * (Self::SIDE - 1) as f64);
        let place = place.clamp(DVec2::ZERO, DVec2::splat((Self::SIDE - 1) as f64));
        let corner = place.floor().min(DVec2::splat((Self::SIDE - 2) as f64));
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
        for (theta, phi) in [(0.0, 0.0), (30.0, 10.0), (60.0, 200.0), (85.0, 300.0), (89.9, 45.0)] {
            let asked = direction(theta, phi);
            let cosine = DirectionGrid::interpolate(asked, |number| DirectionGrid::direction(number).z);
            assert!((cosine - asked.z).abs() < 2e-3, "{theta} {phi}: {cosine} {}", asked.z);
        }
    }
}
