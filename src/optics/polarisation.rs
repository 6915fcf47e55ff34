//! Polarisation of the light that is measured.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Direction of the electric field of the light that comes in, against its plane of incidence; by Stam's theory against the plane through the directions to the light and the viewer.
///
/// Only the factor depends on it. By Stam's theory: Fresnel's equations at the half vector have one for each direction, and unpolarised light has their mean. A lamp or a
/// camera behind a polariser that is turned along or across the grooves of a grating, with light across them, sees one of both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Polarisation {
    /// Unpolarised light.
    #[default]
    None,
    /// Electric field perpendicular to the plane (s).
    Te,
    /// Electric field in the plane (p).
    Tm,
}

#[doc(hidden)]
impl Polarisation {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::None, Self::Te, Self::Tm];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Te => "te",
            Self::Tm => "tm",
        }
    }

    /// Returns the number in shaders, the place in [`Self::ALL`].
    pub fn number(self) -> u32 {
        match self {
            Self::None => 0,
            Self::Te => 1,
            Self::Tm => 2,
        }
    }

    /// Returns the polarisation of this name.
    ///
    /// # Errors
    /// Another name.
    pub fn from_name(name: &str) -> Result<Self> {
        let named = Self::ALL.into_iter().find(|polarisation| polarisation.name() == name);
        named.ok_or_else(|| Error::usage(format!("unknown polarisation `{name}`"), "give te, tm or none"))
    }

    /// Returns the reflected share of this light from the shares of TE and TM.
    pub fn share(self, [te, tm]: [f64; 2]) -> f64 {
        match self {
            Self::None => 0.5 * (te + tm),
            Self::Te => te,
            Self::Tm => tm,
        }
    }
}
