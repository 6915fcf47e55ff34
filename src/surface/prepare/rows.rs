//! Offsets between scan lines: the mean or the median of each row is subtracted from the row.

use crate::error::Result;
use crate::surface::HeightField;
use rayon::prelude::*;

/// Returns `field` with `centre` of each row subtracted from the row.
///
/// # Errors
/// Heights so large that their sums are not finite numbers.
pub(super) fn subtract(field: &HeightField, centre: fn(&[f64]) -> f64) -> Result<HeightField> {
    let mut heights = field.heights().to_vec();
    heights.par_chunks_mut(field.columns()).for_each(|row| {
        let centre = centre(row);
        row.iter_mut().for_each(|h| *h -= centre);
    });
    HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights)
}

/// Returns the mean of a row that is not empty.
pub(super) fn mean(row: &[f64]) -> f64 {
    // From the first height on: large offsets would cost digits.
    let first = row[0];
    first + row.iter().map(|h| h - first).sum::<f64>() / row.len() as f64
}

/// Returns the median of a row that is not empty; for an even number of samples the mean of the two in the middle.
pub(super) fn median(row: &[f64]) -> f64 {
    let mut sorted = row.to_vec();
    let middle = sorted.len() / 2;
    let (below, upper, _) = sorted.select_nth_unstable_by(middle, f64::total_cmp);
    let upper = *upper;
    if row.len() % 2 == 1 {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    lower + (upper - lower) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::Levelling;
    use crate::surface::prepare::tests::{difference, field};

    /// Returns ridges across the rows, each row with a different offset of at most `offset`.
    fn ridges(offset: f64) -> HeightField {
        let row_offset = |y: f64| offset * (y * 91.7).sin();
        field(50, 21, |x, y| (x * 8.0).sin() + row_offset(y))
    }

    #[test]
    fn offsets_of_rows_vanish_and_the_ridges_stay() {
        for level in [Levelling::Rows, Levelling::RowsMedian] {
            let [clean, streaky] = [0.0, 0.7].map(|offset| ridges(offset).levelled(level).unwrap());
            assert!(difference(&clean, &ridges(0.7)) > 0.1);
            assert!(difference(&clean, &streaky) < 1e-14, "{level}");
        }
    }

    #[test]
    fn a_particle_moves_the_mean_of_its_row_and_not_the_median() {
        let mut heights = vec![0.0; 9];
        heights[4] = 9.0;
        let particle = HeightField::new(9, 1, [0.1; 2], heights).unwrap();
        assert_eq!(particle.levelled(Levelling::Rows).unwrap().row(0)[0], -1.0);
        assert_eq!(particle.levelled(Levelling::RowsMedian).unwrap(), particle);
    }

    #[test]
    fn the_median_of_an_even_number_is_between_the_two_in_the_middle() {
        assert_eq!(median(&[4.0, 1.0, 3.0, 2.0]), 2.5);
        assert_eq!(median(&[4.0, 1.0, 3.0]), 3.0);
        assert_eq!((median(&[7.0]), mean(&[1.0, 2.0, 6.0])), (7.0, 3.0));
    }
}
