//! Display of a scene, and the background behind the meshes.

use crate::error::{Error, Result};
use crate::optics::color::Tone;
use crate::units;
use glam::DVec3;
use std::fmt;

/// Display of the radiance of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplaySettings {
    /// Exposure \[stops\].
    pub exposure: f64,
    /// True if the exposure is measured from the first picture; `exposure` is used for a picture without light.
    pub auto_exposure: bool,
    /// Tone curve.
    pub tone: Tone,
    /// Background of the pixels that no mesh covers.
    pub background: Background,
    /// True if the background was asked for, so that pictures are opaque.
    pub is_opaque: bool,
}

/// Background of the pixels that the mesh does not cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// A colour, linear sRGB from 0 to 1.
    Color(DVec3),
    /// The environment map.
    Surroundings,
}

/// Linear sRGB.
const DARK_GREY: DVec3 = DVec3::splat(0.01);

impl Background {
    /// Parses `R,G,B`, linear sRGB from 0 to 1 each, or `surroundings`.
    ///
    /// # Errors
    /// Another form, or numbers out of range.
    pub fn parse(text: &str) -> Result<Self> {
        if text == "surroundings" {
            return Ok(Self::Surroundings);
        }
        units::color(text).map(|color| Self::Color(color.into())).map_err(|_| {
            Error::usage(
                format!("'{text}' is no background"),
                "give R,G,B from 0 to 1 each, linear sRGB, as in 0.8,0.2,0.1, or surroundings",
            )
        })
    }

    /// Returns the colour, linear sRGB; a dark grey instead of an environment map that the scene lacks.
    pub fn color(self) -> DVec3 {
        match self {
            Self::Color(color) => color,
            Self::Surroundings => DARK_GREY,
        }
    }
}

impl fmt::Display for Background {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Color(color) => write!(f, "{},{},{}", color.x, color.y, color.z),
            Self::Surroundings => f.write_str("surroundings"),
        }
    }
}

impl Default for Background {
    fn default() -> Self {
        Self::Color(DARK_GREY)
    }
}
