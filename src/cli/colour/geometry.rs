//! Geometries of instruments by name.

use crate::error::{Error, Result};

/// Geometry of a standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedGeometry {
    /// Light at 45°, seen along the normal: CIE 15.
    FortyFiveToZero,
    /// ASTM E2194, for paint with metal flakes.
    AstmE2194,
    /// ASTM E2539, for interference pigments.
    AstmE2539,
}

impl NamedGeometry {
    const ALL: [Self; 3] = [Self::FortyFiveToZero, Self::AstmE2194, Self::AstmE2539];

    fn name(self) -> &'static str {
        match self {
            Self::FortyFiveToZero => "45/0",
            Self::AstmE2194 => "e2194",
            Self::AstmE2539 => "e2539",
        }
    }

    /// Returns the geometry of this name.
    ///
    /// # Errors
    /// Another name.
    pub fn from_name(text: &str) -> Result<Self> {
        let named = Self::ALL.into_iter().find(|geometry| geometry.name() == text);
        named.ok_or_else(|| {
            Error::usage(
                format!("there is no geometry `{text}`"),
                "give 45/0, e2194 or e2539, or name the directions by --light and --aspecular",
            )
        })
    }

    /// Returns the angle of the light and the aspecular angle of each direction \[degrees\].
    pub fn aspecular(self) -> impl Iterator<Item = (f64, f64)> {
        let all: &[(f64, f64)] = match self {
            Self::FortyFiveToZero => &[(45.0, 45.0)],
            Self::AstmE2194 => &[(45.0, 15.0), (45.0, 45.0), (45.0, 110.0)],
            Self::AstmE2539 => &[
                (45.0, -15.0),
                (45.0, 15.0),
                (45.0, 25.0),
                (45.0, 45.0),
                (45.0, 75.0),
                (45.0, 110.0),
                (15.0, -15.0),
                (15.0, 15.0),
            ],
        };
        all.iter().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn geometries_have_names_and_stay_above_the_horizon() {
        for geometry in NamedGeometry::ALL {
            assert_eq!(NamedGeometry::from_name(geometry.name()).unwrap(), geometry);
            assert!(geometry.aspecular().all(|(light, angle)| (angle - light).abs() < 90.0));
        }
        assert!(NamedGeometry::from_name("d8").unwrap_err().to_string().contains("45/0, e2194 or e2539"));
    }
}
