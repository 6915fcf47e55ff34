//! The unit cell: the smallest part of a height field whose copies give the field.

use super::HeightField;
use crate::error::Result;

/// Largest difference between copies over the height range: rounding of formulas, far below the digits of any file.
const ROUNDING: f64 = 1e-9;

#[doc(hidden)]
impl HeightField {
    /// Returns the smallest block of whole samples whose copies, side by side along both axes, give this field: one period of a grating
    /// of whole periods, one sample along the axis that its heights do not depend on, and the field itself if nothing repeats.
    ///
    /// # Errors
    /// Those of [`HeightField::new`].
    pub fn unit_cell(&self) -> Result<Self> {
        let (low, high) = self.range();
        let allowed = ROUNDING * (high - low);
        let (width, height) = (self.columns(), self.rows());
        let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= allowed);
        let along_x = |period: usize| {
            (0..height).all(|row| same(&self.row(row)[period..], &self.row(row)[..width - period]))
        };
        let along_y = |period: usize| (period..height).all(|row| same(self.row(row), self.row(row - period)));
        let columns = smallest_divisor(width, along_x);
        let rows = smallest_divisor(height, along_y);
        let heights = (0..rows).flat_map(|row| self.row(row)[..columns].iter().copied()).collect();
        Self::new(columns, rows, self.pixel_size(), heights)
    }
}

/// Returns the smallest divisor of `count` that is a `period`; `count` itself is one.
fn smallest_divisor(count: usize, period: impl Fn(usize) -> bool) -> usize {
    (1..count).find(|n| count.is_multiple_of(*n) && period(*n)).unwrap_or(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::synth::{Spec, SurfaceKind, generate};

    fn size(field: &HeightField) -> [usize; 2] {
        let cell = field.unit_cell().unwrap();
        [cell.columns(), cell.rows()]
    }

    #[test]
    fn the_cell_of_a_grating_is_one_period_and_that_of_a_plane_one_sample() {
        let field = |kind| generate(&Spec::new(kind)).unwrap();
        // 20 µm hold 10 periods of the sinusoid in 240 samples, and 8 of the blaze in 216.
        assert_eq!(size(&field(SurfaceKind::Sinusoid)), [24, 1]);
        assert_eq!(size(&field(SurfaceKind::Blaze)), [27, 1]);
        assert_eq!(size(&field(SurfaceKind::Flat)), [1, 1]);
    }

    #[test]
    fn copies_of_a_cell_along_both_axes_give_it_back_and_a_single_spike_is_no_copy() {
        let cell = |column: usize, row: usize| ((column % 4) * 7 + (row % 3) * 5 % 11) as f64 * 0.01;
        let mut heights: Vec<f64> = (0..12 * 6).map(|i| cell(i % 12, i / 12)).collect();
        let field = |heights: &[f64]| HeightField::new(12, 6, [0.1, 0.2], heights.to_vec()).unwrap();
        assert_eq!(size(&field(&heights)), [4, 3]);
        assert_eq!(field(&heights).unit_cell().unwrap().pixel_size(), [0.1, 0.2]);
        heights[30] += 1e-3;
        assert_eq!(size(&field(&heights)), [12, 6]);
    }
}
