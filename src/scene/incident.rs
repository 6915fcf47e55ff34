//! What a sample of a picture gets from a light, and what lights of all kinds share.

use crate::optics::coherence::Coherence;
use crate::optics::spectrum::MIDDLE;
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// By how much wider than its own part of a light a sample averages. With parts that just touch, the sum of their blurs would go up and down from
/// one to the next; twice the width (four times the variance) leaves little of that (Křivánek and Colbert 2008, 4.2).
pub(super) const WIDER: f64 = 4.0;

/// What one sample of a picture gets from a light: one direction or one point, which stands for a part of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incident {
    /// Unit vector to the light, from the middle of the scene where it is a lamp.
    pub direction: DVec3,
    /// The point of a lamp.
    pub place: Option<LampPoint>,
    /// Irradiance over π of a surface that faces the light, linear sRGB: a white diffuse surface has this radiance. Of a lamp, at distance 1
    /// straight before it; [`LampPoint::falloff`] has the rest.
    pub irradiance: Vec3,
    /// Variance of the directions that the sample stands for, along each axis across `direction`; of a lamp, of the points.
    pub variance: f64,
}

impl Incident {
    /// No light.
    pub const NONE: Self = Self { direction: DVec3::Z, place: None, irradiance: Vec3::ZERO, variance: 0.0 };
}

/// A point of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampPoint {
    /// The point \[units of the scene\].
    pub point: DVec3,
    /// Where to the lamp emits.
    pub emits: Emits,
}

/// Where to a lamp emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emits {
    /// Everywhere, as a sphere does. Light falls off with the square of the distance from the middle, and a point that is farther counts for more:
    /// the mean over the points of a disc is what the sphere gives to any surface that sees all of it.
    AllAround {
        /// Of the lamp.
        middle: DVec3,
    },
    /// As a diffuse face does.
    ToOneSide {
        /// Unit vector.
        normal: DVec3,
    },
}

impl LampPoint {
    /// Irradiance of a surface at `place` that faces the point, relative to that at distance 1 straight before the lamp. The twin of `falloff`
    /// in `geometry.frag`.
    pub fn falloff(&self, place: DVec3) -> f64 {
        match self.emits {
            Emits::AllAround { middle } => self.point.distance(place) / middle.distance(place).powi(3),
            Emits::ToOneSide { normal } => {
                let from = place - self.point;
                normal.dot(from).max(0.0) / from.length().powi(3)
            }
        }
    }
}

/// Variance of the directions, along each axis, that light of `coherence` comes from.
pub(super) fn spread_of(coherence: &Coherence) -> f64 {
    coherence.sigma().map_or(0.0, |sigma| (MIDDLE / (8f64.sqrt() * PI * sigma)).powi(2))
}

/// Takes the unit square to the unit disc so that equal areas stay equal: radius and angle.
pub(super) fn concentric([u, v]: [f64; 2]) -> (f64, f64) {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if x == 0.0 && y == 0.0 {
        return (0.0, 0.0);
    }
    if x.abs() > y.abs() {
        (x.abs(), FRAC_PI_4 * (y / x) + if x < 0.0 { PI } else { 0.0 })
    } else {
        (y.abs(), TAU / 4.0 - FRAC_PI_4 * (x / y) + if y < 0.0 { PI } else { 0.0 })
    }
}
