//! Lights: points and discs of the sky, and lamps.

use super::lamp::{Lamp, Room};
use crate::error::Result;
use crate::optics::coherence::Coherence;
use crate::optics::geometry::direction;
use crate::optics::spectrum::MIDDLE;
use crate::units;
pub use crate::units::FarLight;
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::fmt;

/// A light of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// So far away that all of the scene sees it in the same direction.
    Far(FarLight),
    /// In the scene.
    Lamp(Lamp),
}

/// Most lights of a scene: each costs a whole spectrum per fragment. Twin of `MAX_LIGHTS` in `frame.glsl`.
pub const MAX_LIGHTS: usize = 4;

/// Most lights where one of them is a lamp: how bright it is differs from pixel to pixel and takes the image of a fourth.
pub const MAX_LIGHTS_WITH_LAMPS: usize = 3;

/// The most of `lights` that a picture takes.
pub fn most_lights(lights: &[Light]) -> usize {
    if lights.iter().any(Light::is_lamp) { MAX_LIGHTS_WITH_LAMPS } else { MAX_LIGHTS }
}

/// By how much wider than its own part of a light a sample averages. With parts that just touch, the sum of their blurs would go up and down from
/// one to the next; twice the width (four times the variance) leaves little of that (Křivánek and Colbert 2008, 4.2).
pub(super) const WIDER: f64 = 4.0;

/// What one sample of a picture gets from a light: one direction or one point, which stands for a part of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incident {
    /// Unit vector to the light, from the middle of the scene where it is a lamp.
    pub direction: DVec3,
    /// The point of a lamp.
    pub place: Option<Place>,
    /// Irradiance over π of a surface that faces the light, linear sRGB: a white diffuse surface has this radiance. Of a lamp, at distance 1
    /// straight before it; [`Place::falloff`] has the rest.
    pub irradiance: Vec3,
    /// Variance of the directions that the sample stands for, along each axis across `direction`; of a lamp, of the points.
    pub variance: f64,
}

/// A point of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
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

impl Place {
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

impl Light {
    /// A lamp, or `THETA,PHI[,INTENSITY]`, a point of the sky, `sun:…` or `disc:SIZE:…`.
    ///
    /// # Errors
    /// As [`Lamp::parse`] and [`units::light`].
    pub fn parse(text: &str) -> Result<Self> {
        if Lamp::is_named_by(text) {
            Lamp::parse(text).map(Self::Lamp)
        } else {
            units::light(text).map(Self::Far)
        }
    }

    /// A point of the sky, as [`FarLight`] has it.
    pub fn point(theta: f64, phi: f64, intensity: f64) -> Self {
        Self::Far(FarLight { theta, phi, intensity, size: 0.0 })
    }

    /// Whether it stands in the scene.
    pub fn is_lamp(&self) -> bool {
        matches!(self, Self::Lamp(_))
    }

    /// The light without the extent that `coherence` holds already.
    #[must_use]
    pub fn beyond(self, coherence: &Coherence, room: &Room) -> Self {
        match self {
            Self::Far(light) => Self::Far(light.beyond(coherence)),
            Self::Lamp(lamp) => Self::Lamp(lamp.beyond(coherence, room)),
        }
    }

    /// The light turned by `degrees` about the vertical through the middle of `room`.
    #[must_use]
    pub fn turned(self, degrees: f64, room: &Room) -> Self {
        match self {
            Self::Far(light) => Self::Far(FarLight { phi: light.phi + degrees, ..light }),
            Self::Lamp(lamp) => Self::Lamp(lamp.turned(degrees, room)),
        }
    }

    /// The light as the middle of `room` sees it: a point of the sky. What is below the horizon is moved up to it.
    pub fn from_afar(&self, room: &Room) -> FarLight {
        let lamp = match self {
            Self::Far(light) => return *light,
            Self::Lamp(lamp) => lamp,
        };
        let to_lamp = lamp.middle - room.centre;
        let theta = to_lamp.truncate().length().atan2(to_lamp.z).to_degrees().min(90.0);
        FarLight { theta, phi: to_lamp.y.atan2(to_lamp.x).to_degrees(), intensity: 1.0, size: 0.0 }
    }

    /// What the sample at `point` (uniform in 0 … 1) of `count` samples gets in `room`.
    pub fn incident(&self, point: [f64; 2], count: u32, room: &Room) -> Incident {
        match self {
            Self::Far(light) => light.incident(point, count),
            Self::Lamp(lamp) => lamp.incident(point, count, room),
        }
    }
}

impl From<FarLight> for Light {
    fn from(light: FarLight) -> Self {
        Self::Far(light)
    }
}

impl fmt::Display for Light {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Far(light) => light.fmt(f),
            Self::Lamp(lamp) => lamp.fmt(f),
        }
    }
}

/// Variance of the directions, along each axis, that light of `coherence` comes from.
pub(super) fn spread_of(coherence: &Coherence) -> f64 {
    coherence.sigma().map_or(0.0, |sigma| (MIDDLE / (8f64.sqrt() * PI * sigma)).powi(2))
}

impl FarLight {
    /// The unit vector to the light's centre, `theta` from the world's up (+z), `phi` from +x toward +y. Its intensity is the irradiance
    /// over π: a white diffuse surface that faces a light of intensity 1 has a radiance of 1.
    pub fn direction(&self) -> Vec3 {
        direction(self.theta, self.phi).as_vec3()
    }

    /// What the sample at `point` (uniform in 0 … 1) of `count` samples gets. Directions are spread evenly over a disc around the light's
    /// centre, by the map of Shirley and Chiu (1997), which keeps neighbours together. Each stands for four times its part of the
    /// variance, and the disc is smaller by as much, so that all samples together have the light's. Few samples look at the centre.
    pub fn incident(&self, point: [f64; 2], count: u32) -> Incident {
        let centre = direction(self.theta, self.phi);
        let share = (WIDER / f64::from(count.max(1))).min(1.0);
        let cap = (1.0 - (0.5 * self.size).to_radians().cos()) * (1.0 - share);
        let (radius, angle) = concentric(point);
        let height = radius * radius * cap; // 1 − cos α
        let sine = (height * (2.0 - height)).max(0.0).sqrt();
        let (across, along) = centre.any_orthonormal_pair();
        let direction = centre * (1.0 - height) + (across * angle.cos() + along * angle.sin()) * sine;
        Incident {
            direction,
            place: None,
            irradiance: Vec3::splat(self.intensity as f32),
            variance: self.variance() * share,
        }
    }

    /// Variance of the disc's directions along each axis across its centre: ⟨sin² α⟩/2 over its solid angle.
    fn variance(&self) -> f64 {
        let cap = 1.0 - (0.5 * self.size).to_radians().cos();
        (cap - cap * cap / 3.0) / 2.0
    }

    /// The light without the extent that `coherence` holds already: light of a coherence length comes from directions that spread by
    /// λ/(√8 π σ), which is the sun's disc for sunlight.
    #[must_use]
    pub fn beyond(self, coherence: &Coherence) -> Self {
        let held = spread_of(coherence);
        let own = self.variance();
        let left = if own > 0.0 { (1.0 - held / own).max(0.0).sqrt() } else { 0.0 };
        Self { size: self.size * left, ..self }
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units;

    #[test]
    fn samples_of_a_disc_cover_its_solid_angle_evenly() {
        let light = units::light("disc:40deg:30,70").unwrap();
        let centre = light.direction().as_dvec3();
        let side = 200;
        let place = |i: usize| (i as f64 + 0.5) / f64::from(side);
        let points = (0..side * side).map(|i| [place((i % side) as usize), place((i / side) as usize)]);
        let directions: Vec<DVec3> = points.map(|p| light.incident(p, 1 << 20).direction).collect();
        let count = directions.len() as f64;
        let cosines: Vec<f64> = directions.iter().map(|d| d.dot(centre)).collect();
        let edge = 20f64.to_radians().cos();
        assert!(cosines.iter().all(|c| *c >= edge - 1e-12));
        assert!(directions.iter().all(|d| (d.length() - 1.0).abs() < 1e-12));
        // The cosine is uniform over a cap.
        assert!((cosines.iter().sum::<f64>() / count - (1.0 + edge) / 2.0).abs() < 1e-4);
        let across = centre.any_orthonormal_vector();
        let variance = directions.iter().map(|d| d.dot(across).powi(2)).sum::<f64>() / count;
        assert!((variance / light.variance() - 1.0).abs() < 1e-3);
        assert!((light.incident([0.1, 0.2], 4).direction - centre).length() < 1e-7);
        // However many samples there are, their spread and what each averages over make up the light's variance.
        for count in [5, 16, 100] {
            let all = (0..side * side)
                .map(|i| light.incident([place((i % side) as usize), place((i / side) as usize)], count));
            let spread = all.map(|i| i.direction.dot(across).powi(2)).sum::<f64>() / f64::from(side * side);
            let sum = spread + light.incident([0.1, 0.2], count).variance;
            assert!((sum / light.variance() - 1.0).abs() < 0.01, "{count}: {sum}");
        }
    }

    #[test]
    fn the_sun_is_no_more_than_what_the_coherence_of_sunlight_holds() {
        let sun = units::light("sun:30,70").unwrap();
        assert_eq!(sun.beyond(&Coherence::SUNLIGHT).size, 0.0);
        assert_eq!(sun.beyond(&Coherence::Repeats([3, 3])), sun);
        let disc = units::light("disc:5deg:30,70").unwrap();
        let left = disc.beyond(&Coherence::SUNLIGHT);
        let held = (MIDDLE / (8f64.sqrt() * PI * 65.0 / 4.0)).powi(2);
        assert!((left.variance() + held - disc.variance()).abs() < 1e-3 * held, "{left:?}");
        assert_eq!(units::light("30,70").unwrap().beyond(&Coherence::SUNLIGHT).size, 0.0);
    }
}
