//! The height field: a sampled patch of surface, in micrometres.

use crate::error::{Error, Remedy, Result};
use crate::notes::PreparationRecord;
use std::sync::Arc;

/// The longest side, in samples, that is accepted. Keeps every index product far from overflow and a field within
/// a few gigabytes of memory.
pub const MAX_SIDE: usize = 16_384;

/// Largest height above or below zero: a kilometre \[µm\]. Nanometres that a file calls metres are less, and counts of terms that follow from heights stay small numbers.
const LARGEST_HEIGHT: f64 = 1e9;

/// Heights on a regular grid. Row 0 is the top of a height image: `x` grows along a row, `y` grows UP, so row 0 has
/// the largest `y`. The origin is the patch centre; samples sit at cell centres. Clones share the heights.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    columns: usize,
    rows: usize,
    pixel_size: [f64; 2],
    heights: Arc<Vec<f64>>,
    prepared: PreparationRecord,
}

impl HeightField {
    /// Returns a field of `columns` × `rows` heights \[µm\], row by row from the top, with sample spacing `pixel_size` \[µm\].
    ///
    /// # Errors
    /// An empty or oversized grid, a length of `heights` that is not `columns * rows`, a spacing that is not finite and
    /// positive, a height that is not finite or more than a kilometre.
    pub fn new(columns: usize, rows: usize, pixel_size: [f64; 2], heights: Vec<f64>) -> Result<Self> {
        check_size(columns, rows)?;
        if heights.len() != columns * rows {
            return Err(Error::input(
                format!("{} heights do not fill {columns} x {rows}", heights.len()),
                "give columns * rows heights",
            ));
        }
        if !pixel_size.iter().all(|d| d.is_finite() && *d > 0.0) {
            return Err(Error::usage(
                format!("the pixel size {} x {} um is not positive", pixel_size[0], pixel_size[1]),
                Remedy::PixelSize,
            ));
        }
        if let Some(i) = heights.iter().position(|h| !h.is_finite()) {
            return Err(Error::input(
                format!("the height at column {}, row {} is not a number", i % columns, i / columns),
                "fill holes in the scan before use",
            ));
        }
        if let Some(height) = heights.iter().find(|h| h.abs() > LARGEST_HEIGHT) {
            return Err(Error::input(
                format!("a height of {height:e} um is more than a kilometre"),
                [Remedy::Words("check the unit of the heights".into())],
            ));
        }
        Ok(Self {
            columns,
            rows,
            pixel_size,
            heights: heights.into(),
            prepared: PreparationRecord::default(),
        })
    }

    /// Returns the field of `columns` × `rows` samples of the surface z = `height`(x, y), `pixel_size` \[µm\] apart. x and y are \[µm\]
    /// from the patch centre.
    ///
    /// # Errors
    /// See [`HeightField::new`].
    pub fn from_fn(
        columns: usize,
        rows: usize,
        pixel_size: [f64; 2],
        height: impl Fn(f64, f64) -> f64,
    ) -> Result<Self> {
        check_size(columns, rows)?;
        let flat = Self::new(columns, rows, pixel_size, vec![0.0; columns * rows])?;
        let row = |row| (0..columns).map(move |column| (column, row));
        let places = (0..rows).flat_map(row);
        let heights = places.map(|(column, row)| height(flat.x(column), flat.y(row))).collect();
        Self::new(columns, rows, pixel_size, heights)
    }

    /// Returns the number of samples along `x`.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Returns the number of samples along `y`.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the sample spacing along `x` and `y` \[µm\].
    pub fn pixel_size(&self) -> [f64; 2] {
        self.pixel_size
    }

    /// Returns the side lengths T_x, T_y of the patch, which are also its periods when it repeats \[µm\].
    pub fn patch_size(&self) -> [f64; 2] {
        [self.columns as f64 * self.pixel_size[0], self.rows as f64 * self.pixel_size[1]]
    }

    /// Returns all heights \[µm\], row by row from the top.
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }
}

#[doc(hidden)]
impl HeightField {
    /// Returns all heights \[µm\], without a copy of them if there is no other clone of the field.
    pub fn into_heights(self) -> Vec<f64> {
        Arc::unwrap_or_clone(self.heights)
    }

    /// Returns the steps that made these heights of the measured ones.
    pub fn prepared(&self) -> &PreparationRecord {
        &self.prepared
    }

    /// Returns the same heights with the record of their preparation.
    #[must_use]
    pub fn with_record(self, prepared: PreparationRecord) -> Self {
        Self { prepared, ..self }
    }

    /// Returns the heights of one row \[µm\]; row 0 has the largest `y`.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.heights[row * self.columns..(row + 1) * self.columns]
    }

    /// Returns `x` of a column's sample, from the patch centre \[µm\].
    pub fn x(&self, column: usize) -> f64 {
        (column as f64 - (self.columns - 1) as f64 / 2.0) * self.pixel_size[0]
    }

    /// Returns `y` of a row's sample, from the patch centre \[µm\].
    pub fn y(&self, row: usize) -> f64 {
        ((self.rows - 1) as f64 / 2.0 - row as f64) * self.pixel_size[1]
    }
}

impl HeightField {
    /// Returns the lowest and highest height \[µm\].
    pub fn range(&self) -> (f64, f64) {
        self.heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &h| (lo.min(h), hi.max(h)))
    }
}

#[doc(hidden)]
impl HeightField {
    /// Returns the same periodic surface with its origin moved by whole samples, `columns` along +x and `rows` along +y: the sample at that
    /// offset moves to the centre.
    #[must_use]
    pub fn moved(&self, columns: usize, rows: usize) -> Self {
        let row = |r: usize| self.row((r + self.rows - rows % self.rows) % self.rows);
        let cell = |r: usize, c: usize| row(r)[(c + columns) % self.columns];
        let heights = (0..self.rows)
            .flat_map(|r| (0..self.columns).map(move |c| cell(r, c)))
            .collect::<Vec<_>>()
            .into();
        Self { heights, prepared: self.prepared.clone(), ..*self }
    }

    /// Returns the period of the same surface that begins `shift` \[µm\] from the edges: the samples before it are taken from the next
    /// period.
    #[must_use]
    pub fn begun_at(&self, shift: [f64; 2]) -> Self {
        let [columns, rows] =
            [0, 1].map(|i| (shift[i] / self.pixel_size()[i] - 0.5).ceil().max(0.0) as usize);
        self.moved(columns, rows)
    }
}

/// Fails for a grid without samples and for one that is too large.
fn check_size(columns: usize, rows: usize) -> Result<()> {
    if columns == 0 || rows == 0 {
        return Err(Error::input(
            format!("the height field is empty ({columns} x {rows})"),
            "give at least one sample",
        ));
    }
    if columns > MAX_SIDE || rows > MAX_SIDE {
        return Err(Error::input(
            format!("the height field of {columns} x {rows} samples is larger than {MAX_SIDE} on a side"),
            "crop it or average it down",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_is_sampled_about_the_patch_centre_with_y_upward() {
        let field = HeightField::from_fn(3, 2, [0.5, 2.0], |x, y| 10.0 * x + y).unwrap();
        assert_eq!(field.heights(), [-4.0, 1.0, 6.0, -6.0, -1.0, 4.0]);
        assert!(HeightField::from_fn(usize::MAX, 2, [1.0; 2], |_, _| 0.0).is_err(), "too large to allocate");
        assert!(HeightField::from_fn(2, 2, [1.0; 2], |x, _| (x - 9.0).sqrt()).is_err(), "not a number");
        assert!(HeightField::from_fn(2, 1, [1.0; 2], |_, _| f64::MAX).is_err(), "more than a kilometre");
    }

    #[test]
    fn a_moved_field_has_in_its_middle_what_stood_right_of_and_above_it() {
        let field = HeightField::new(5, 3, [1.0, 1.0], (0..15).map(f64::from).collect()).unwrap();
        assert_eq!(field.row(1)[2], 7.0, "the middle");
        let moved = field.moved(1, 1);
        assert_eq!(moved.row(1)[2], field.row(0)[3], "x + 1 is a column on, y + 1 is a row up");
        assert_eq!(moved.moved(4, 2), field);
    }
}
