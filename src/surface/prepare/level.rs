//! Levelling: subtracting an offset, a tilt, a bow, or the offsets of the scan lines.

use super::{facet, polynomial, rows};
use crate::error::{Error, Result};
use crate::surface::HeightField;
use std::fmt;

/// Offset, tilt, bow or scan line offsets to subtract from a height field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Levelling {
    /// Nothing.
    #[default]
    None,
    /// The mean height.
    Mean,
    /// The plane of least squares through all heights.
    Plane,
    /// The polynomial of least squares of this total degree in `x` and `y`, 1 … [`Levelling::MAX_DEGREE`]: a scanner's bow.
    Polynomial(u8),
    /// The mean of each row: offsets between scan lines.
    Rows,
    /// The median of each row, which few high particles in the row do not move.
    RowsMedian,
    /// The tilt that most facets of the surface share: terraces and flat ground become horizontal, whatever stands on them.
    Facet,
}

impl Levelling {
    /// Largest degree of [`Levelling::Polynomial`]. Higher degrees follow the structure itself.
    pub const MAX_DEGREE: u8 = 12;

    /// Parses a levelling.
    ///
    /// # Errors
    /// Another word, a degree that is missing or out of range.
    pub fn parse(text: &str) -> Result<Self> {
        match text {
            "none" => Ok(Self::None),
            "mean" => Ok(Self::Mean),
            "plane" => Ok(Self::Plane),
            "rows" => Ok(Self::Rows),
            "rows-median" => Ok(Self::RowsMedian),
            "facet" => Ok(Self::Facet),
            _ => {
                let degree =
                    text.strip_prefix("polynomial:").filter(|n| n.bytes().all(|b| b.is_ascii_digit()));
                let degree =
                    degree.and_then(|n| n.parse().ok()).filter(|n| (1..=Self::MAX_DEGREE).contains(n));
                degree.map(Self::Polynomial).ok_or_else(|| {
                    let largest = Self::MAX_DEGREE;
                    Error::usage(
                        format!("there is no level `{text}`"),
                        format!(
                            "give none, mean, plane, polynomial:N with a degree N from 1 to {largest}, rows, rows-median or facet"
                        ),
                    )
                })
            }
        }
    }
}

impl fmt::Display for Levelling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Mean => f.write_str("mean"),
            Self::Plane => f.write_str("plane"),
            Self::Polynomial(degree) => write!(f, "polynomial:{degree}"),
            Self::Rows => f.write_str("rows"),
            Self::RowsMedian => f.write_str("rows-median"),
            Self::Facet => f.write_str("facet"),
        }
    }
}

#[doc(hidden)]
impl HeightField {
    /// Returns the field less the part that `level` describes.
    ///
    /// # Errors
    /// Heights so large that their sums are not finite numbers.
    pub fn levelled(&self, level: Levelling) -> Result<Self> {
        match level {
            Levelling::None => Ok(self.clone()),
            Levelling::Mean => polynomial::subtract(self, 0),
            Levelling::Plane => polynomial::subtract(self, 1),
            Levelling::Polynomial(degree) => polynomial::subtract(self, usize::from(degree)),
            Levelling::Rows => rows::subtract(self, rows::mean),
            Levelling::RowsMedian => rows::subtract(self, rows::median),
            Levelling::Facet => facet::level(self),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::tests::field;

    fn largest(field: &HeightField) -> f64 {
        field.heights().iter().fold(0.0, |m, h| m.max(h.abs()))
    }

    #[test]
    fn a_plane_is_taken_away_to_rounding() {
        let tilted = field(33, 20, |x, y| 5.0 + 0.3 * x - 0.2 * y);
        assert!(largest(&tilted.levelled(Levelling::Plane).unwrap()) < 1e-14);
        assert!(largest(&tilted.levelled(Levelling::Mean).unwrap()) > 0.1);
        assert_eq!(tilted.levelled(Levelling::None).unwrap(), tilted);
    }

    #[test]
    fn the_plane_leaves_what_is_orthogonal_to_it() {
        let ridge = |x: f64, _: f64| (x * 7.0).cos();
        let bare = field(33, 20, ridge).levelled(Levelling::Mean).unwrap();
        let tilted =
            field(33, 20, |x, y| ridge(x, y) + 1.0 + 0.4 * x + 0.1 * y).levelled(Levelling::Plane).unwrap();
        let worst =
            bare.heights().iter().zip(tilted.heights()).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(worst < 1e-13, "{worst}");
    }

    #[test]
    fn a_single_sample_row_or_column_levels_to_zero() {
        for (columns, rows) in [(1, 1), (1, 9), (9, 1)] {
            let line = field(columns, rows, |x, y| 2.0 + x + y);
            assert!(largest(&line.levelled(Levelling::Plane).unwrap()) < 1e-14);
        }
    }
}
