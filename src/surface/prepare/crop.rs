//! Cropping of a height field to a rectangle.

use super::words::{about, length, lengths};
use crate::error::{Error, Result};
use crate::surface::HeightField;
use crate::units;
use std::fmt;

/// A rectangle \[µm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crop {
    /// Width and height, rounded to whole samples.
    pub size: [f64; 2],
    /// Distances of the left edge from the field's left edge and of the top edge from the field's top edge; `None`: in the middle.
    pub corner: Option<[f64; 2]>,
}

impl Crop {
    /// Parses `40um`, `40umx20um`, or either with a corner as in `40umx20um+5um+3um`.
    pub(super) fn parse(text: &str) -> Result<Self> {
        const FORM: &str =
            "give a side as in 40um, two as in 40umx20um, and the corner as in 40umx20um+5um+3um";
        let fields: Vec<&str> = text.split('+').collect();
        let (size, corner) = match fields[..] {
            [size] => (size, None),
            [size, x, y] => (size, Some([units::length_or_zero(x)?, units::length_or_zero(y)?])),
            _ => return Err(Error::usage(format!("`{text}` is not a rectangle"), FORM)),
        };
        Ok(Self { size: units::length_pair(size)?, corner })
    }

    /// Returns the samples of `field` in the rectangle.
    pub(super) fn apply(&self, field: &HeightField) -> Result<HeightField> {
        let (columns, from_column) = self.range(0, field.columns(), field)?;
        let (rows, from_row) = self.range(1, field.rows(), field)?;
        let kept =
            (from_row..from_row + rows).flat_map(|row| &field.row(row)[from_column..from_column + columns]);
        HeightField::new(columns, rows, field.pixel_size(), kept.copied().collect())
    }

    /// Returns the number of samples along `axis` that are kept, out of `count`, and the index of the first.
    fn range(&self, axis: usize, count: usize, field: &HeightField) -> Result<(usize, usize)> {
        let samples = |length: f64| (length / field.pixel_size()[axis]).round();
        let kept = samples(self.size[axis]).max(1.0);
        let first = match self.corner {
            Some(corner) => samples(corner[axis]),
            None => ((count as f64 - kept) / 2.0).floor().max(0.0),
        };
        if first + kept > count as f64 {
            let [width, height] = field.patch_size().map(about);
            return Err(Error::input(
                format!("the field of {width} x {height} does not hold the rectangle"),
                "give a smaller one",
            ));
        }
        Ok((kept as usize, first as usize))
    }
}

impl fmt::Display for Crop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&lengths(self.size))?;
        let offset = |um: f64| if um == 0.0 { "0um".to_owned() } else { length(um) };
        self.corner.map_or(Ok(()), |[x, y]| write!(f, "+{}+{}", offset(x), offset(y)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::tests::field;

    fn crop(text: &str, field: &HeightField) -> Result<HeightField> {
        Crop::parse(text)?.apply(field)
    }

    #[test]
    fn a_crop_keeps_the_samples_within_and_their_spacing() {
        let surface = field(20, 20, |x, y| 3.0 * x + 100.0 * y); // 100 nm x 70 nm
        let part = crop("1umx0.7um", &surface).unwrap();
        assert_eq!((part.columns(), part.rows(), part.pixel_size()), (10, 10, surface.pixel_size()));
        assert_eq!(part.row(0), &surface.row(5)[5..15], "from the middle");
        let corner = crop("300nmx140nm+200nm+70nm", &surface).unwrap();
        assert_eq!((corner.columns(), corner.rows()), (3, 2));
        assert_eq!(corner.row(0), &surface.row(1)[2..5], "from the left and from the top");
        assert_eq!(crop("2umx1.4um", &surface).unwrap(), surface);
        assert_eq!(crop("2umx1.4um+0um+0um", &surface).unwrap(), surface);
        assert_eq!(crop("1nm", &surface).unwrap().heights().len(), 1, "one sample is left at least");
    }

    #[test]
    fn a_rectangle_that_leaves_the_field_is_an_error_that_says_its_size() {
        let surface = field(20, 20, |x, _| x);
        for text in ["3um", "2umx2um", "1umx1um+1.5um+0um", "100nm+0um+2um", "1m"] {
            let e = crop(text, &surface).unwrap_err().to_string();
            assert!(e.contains("2um x 1.4um"), "{text}: {e}");
        }
    }
}
