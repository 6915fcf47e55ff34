//! Theories of the factor in front of the power |P|², which says how much light a shallow surface scatters from one
//! direction into another.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Theory of the factor R G of the BRDF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Theory {
    /// Small-slope approximation of first order (\[Voronovich 1994\]), limited so that no surface reflects more than a flat one.
    #[default]
    SmallSlope,
    /// Kirchhoff's factor with the reflectance at the half vector, as in the thesis (\[Stam 1999\]; \[Single 2014\]
    /// B.12), without a limit.
    Stam,
}

#[doc(hidden)]
impl Theory {
    /// All theories.
    pub const ALL: [Self; 2] = [Self::SmallSlope, Self::Stam];

    /// Returns the name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::SmallSlope => "small-slope",
            Self::Stam => "stam",
        }
    }

    /// Returns the theory of this name.
    ///
    /// # Errors
    /// Fails for another name.
    pub fn from_name(name: &str) -> Result<Self> {
        let named = Self::ALL.into_iter().find(|theory| theory.name() == name);
        named.ok_or_else(|| Error::usage(format!("unknown theory `{name}`"), "give small-slope or stam"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn theories_are_found_by_their_names() {
        for theory in Theory::ALL {
            assert_eq!(Theory::from_name(theory.name()).unwrap(), theory);
        }
        assert!(Theory::from_name("kirchhoff").is_err());
    }
}
