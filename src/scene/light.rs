//! Lights: points and discs of the sky, and lamps.

use super::far_light::FarLight;
use super::incident::Incident;
use super::lamp::{Lamp, Room};
use crate::error::Result;
use crate::optics::coherence::Coherence;
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

impl Light {
    /// A lamp, or `THETA,PHI[,INTENSITY]`, a point of the sky, `sun:…` or `disc:SIZE:…`.
    ///
    /// # Errors
    /// As [`Lamp::parse`] and [`FarLight::parse`].
    pub fn parse(text: &str) -> Result<Self> {
        if Lamp::is_named_by(text) {
            Lamp::parse(text).map(Self::Lamp)
        } else {
            FarLight::parse(text).map(Self::Far)
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
