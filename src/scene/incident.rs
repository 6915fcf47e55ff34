//! Light samples of a picture, and helpers of all kinds of lights.

use crate::optics::coherence::Coherence;
use crate::optics::spectrum::MIDDLE;
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// Variance of a sample's average relative to the variance of its part of the light. If the parts just touched, the sum of their blurs
/// would ripple; twice the width (four times the variance) leaves little of the ripple (Křivánek and Colbert 2008, 4.2).
pub(super) const WIDER: f64 = 4.0;
/// Number of samples of a disc or lamp below which the share of each grows faster, as (MANY_SAMPLES/N)²: so few points lie unevenly, and
/// draw the light's image askew. With the first power, eight samples of a mirrored disc err more than one.
const MANY_SAMPLES: f64 = 16.0;

/// Returns the share of the variance of a disc or lamp that each of `count` samples averages over; their points have the rest.
pub(super) fn share_of_sample(count: u32) -> f64 {
    let count = f64::from(count.max(1));
    (WIDER / count * (MANY_SAMPLES / count).max(1.0)).min(1.0)
}

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
    /// Length of the mean of the unit vectors that the sample stands for: 1 for a point, 0 for light from all around.
    pub mean: f64,
}

impl Incident {
    /// No light.
    pub const NONE: Self =
        Self { direction: DVec3::Z, place: None, irradiance: Vec3::ZERO, variance: 0.0, mean: 1.0 };
}

/// Returns the mean of max(cos θ, 0) over the directions of a sample, by the `cosine` of its middle and the length of its
/// `mean` vector, [`Incident::mean`]. The cosine to the normal counts as evenly spread, with the mean and the variance of a
/// cap's. That is exact where the cap's middle is the normal (Archimedes) and for light from all around, and within 0.02
/// elsewhere. Twin of `mean_cosine` in `light.glsl`.
pub fn mean_cosine(cosine: f64, mean: f64) -> f64 {
    let whole = mean * cosine;
    let along = (1.0 - mean).powi(2);
    let across = 1.5 * (1.0 - mean * mean - along / 3.0);
    let half = (along * cosine * cosine + across * (1.0 - cosine * cosine)).max(0.0).sqrt();
    if whole.abs() >= half { whole.max(0.0) } else { (whole + half).powi(2) / (4.0 * half) }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the mean of max(cos θ, 0) over a cap within `height` = 1 − cos α of a middle at this `cosine`.
    fn over_cap(cosine: f64, height: f64) -> f64 {
        let sine = (1.0 - cosine * cosine).sqrt();
        let (rings, turns) = (400, 400);
        let mut sum = 0.0;
        for ring in 0..rings {
            let z = 1.0 - height * (f64::from(ring) + 0.5) / f64::from(rings);
            let across = (1.0 - z * z).sqrt();
            for turn in 0..turns {
                let x = across * (TAU * (f64::from(turn) + 0.5) / f64::from(turns)).cos();
                sum += (z * cosine + x * sine).max(0.0);
            }
        }
        sum / f64::from(rings * turns)
    }

    #[test]
    fn the_mean_cosine_of_caps_is_that_of_their_directions() {
        // 1 − height/2 is the length of the mean of a cap's directions.
        for height in [1e-3, 0.1, 0.5, 1.0, 1.5, 2.0] {
            for cosine in [-1.0, -0.7, -0.2, 0.0, 0.3, 0.8, 1.0] {
                let [exact, found] = [over_cap(cosine, height), mean_cosine(cosine, 1.0 - 0.5 * height)];
                let allowed = if cosine.abs() == 1.0 || height == 2.0 { 1e-4 } else { 0.02 };
                assert!((found - exact).abs() < allowed, "{height}, {cosine}: {found} instead of {exact}");
            }
        }
        assert_eq!([-0.5, 0.0, 0.5].map(|cosine| mean_cosine(cosine, 1.0)), [0.0, 0.0, 0.5]);
    }
}
