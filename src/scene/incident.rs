//! Light samples of a picture, and helpers of all kinds of lights.

use crate::optics::coherence::Coherence;
use crate::optics::spectrum::MIDDLE;
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// Variance of a sample's average relative to the variance of its part of the light. If the parts just touched, the sum of their blurs
/// would ripple; twice the width (four times the variance) leaves little of the ripple (Křivánek and Colbert 2008, 4.2).
pub(super) const WIDER: f64 = 4.0;

/// Light sample: one direction or one point, which stands for a part of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incident {
    /// Unit vector to the light; to a lamp, from the middle of the scene.
    pub direction: DVec3,
    /// Point of a lamp; `None` for a distant light.
    pub place: Option<LampPoint>,
    /// Irradiance over π of a surface that faces the light, linear sRGB: a white diffuse surface has this radiance. For a lamp, the value
    /// at distance 1 on the axis, which [`LampPoint::falloff`] scales.
    pub irradiance: Vec3,
    /// Variance of the sample's directions along each axis across `direction`; for a lamp, variance of its points.
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
    /// Angular distribution of the emission.
    pub emits: Emits,
}

/// Angular distribution of a lamp's emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emits {
    /// Isotropic, for a sphere. Light falls off with the cube of the distance from the middle, times the distance of the point: the mean
    /// over the points of a disc is then the light of the sphere on any surface that sees all of it.
    AllAround {
        /// Middle of the lamp.
        middle: DVec3,
    },
    /// Lambertian, for a face.
    ToOneSide {
        /// Unit normal of the face.
        normal: DVec3,
    },
}

impl LampPoint {
    /// Returns the irradiance of a surface at `place` that faces the point, relative to that at distance 1 on the lamp's axis. Twin of
    /// `falloff` in `light.glsl`.
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

/// Returns the variance of the directions of light with this `coherence`, along each axis.
pub(super) fn spread_of(coherence: &Coherence) -> f64 {
    coherence.sigma().map_or(0.0, |sigma| (MIDDLE / (8f64.sqrt() * PI * sigma)).powi(2))
}

/// Maps the unit square to the unit disc, equal areas to equal areas; returns radius and angle.
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
