//! Levelling: taking the offset or the tilt of a scan away.

use super::HeightField;
use crate::error::Result;

/// What is subtracted from a height field before use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Level {
    /// Nothing.
    #[default]
    None,
    /// The mean height.
    Mean,
    /// The plane of least squares through all heights.
    Plane,
}

impl Level {
    /// Every choice, in the order in which help texts name them.
    pub const ALL: [Self; 3] = [Self::None, Self::Mean, Self::Plane];

    /// The word for it on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Mean => "mean",
            Self::Plane => "plane",
        }
    }

    /// The choice that `name` means.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|level| level.name() == name)
    }
}

/// A plane h = mean + slope_x · x + slope_y · y over the patch, `x` and `y` from its centre \[µm\].
#[derive(Clone, Copy, Debug, Default)]
struct Plane {
    mean: f64,
    slope: [f64; 2],
}

impl HeightField {
    /// The field less what `level` says.
    ///
    /// # Errors
    /// Heights so large that their sums are not finite numbers.
    pub fn levelled(&self, level: Level) -> Result<Self> {
        let plane = match level {
            Level::None => return Ok(self.clone()),
            Level::Mean => Plane { mean: mean(self), ..Plane::default() },
            Level::Plane => least_squares(self),
        };
        let heights = (0..self.rows()).flat_map(|row| {
            let offset = plane.mean + plane.slope[1] * self.y(row);
            let line = self.row(row).iter().enumerate();
            line.map(move |(column, h)| h - offset - plane.slope[0] * self.x(column))
        });
        Self::new(self.columns(), self.rows(), self.pixel_size(), heights.collect())
    }
}

/// The mean height \[µm\], from sums of rows, which lose less than one long sum.
pub(super) fn mean(field: &HeightField) -> f64 {
    let total: f64 = (0..field.rows()).map(|row| field.row(row).iter().sum::<f64>()).sum();
    total / field.heights().len() as f64
}

/// The plane of least squares. On a grid centred on the origin 1, x and y are orthogonal, so each coefficient is a
/// projection of its own: slope_x = Σ x h / Σ x².
fn least_squares(field: &HeightField) -> Plane {
    let mean = mean(field);
    let (mut along_x, mut along_y) = (0.0, 0.0);
    for row in 0..field.rows() {
        let (mut line, mut moment) = (0.0, 0.0);
        for (column, h) in field.row(row).iter().enumerate() {
            line += h - mean;
            moment += field.x(column) * (h - mean);
        }
        along_x += moment;
        along_y += field.y(row) * line;
    }
    let squares_x: f64 = (0..field.columns()).map(|c| field.x(c).powi(2)).sum::<f64>() * field.rows() as f64;
    let squares_y: f64 = (0..field.rows()).map(|r| field.y(r).powi(2)).sum::<f64>() * field.columns() as f64;
    // A single column or row has no extent to tilt over.
    let slope = |moment: f64, squares: f64| if squares > 0.0 { moment / squares } else { 0.0 };
    Plane { mean, slope: [slope(along_x, squares_x), slope(along_y, squares_y)] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(columns: usize, rows: usize, h: impl Fn(f64, f64) -> f64) -> HeightField {
        let empty = HeightField::new(columns, rows, [0.1, 0.07], vec![0.0; columns * rows]).unwrap();
        let at = |i: usize| h(empty.x(i % columns), empty.y(i / columns));
        HeightField::new(columns, rows, [0.1, 0.07], (0..columns * rows).map(at).collect()).unwrap()
    }

    fn largest(field: &HeightField) -> f64 {
        field.heights().iter().fold(0.0, |m, h| m.max(h.abs()))
    }

    #[test]
    fn a_plane_is_taken_away_to_rounding() {
        let tilted = field(33, 20, |x, y| 5.0 + 0.3 * x - 0.2 * y);
        assert!(largest(&tilted.levelled(Level::Plane).unwrap()) < 1e-14);
        assert!(largest(&tilted.levelled(Level::Mean).unwrap()) > 0.1);
        assert_eq!(tilted.levelled(Level::None).unwrap(), tilted);
    }

    #[test]
    fn the_plane_leaves_what_is_orthogonal_to_it() {
        let ridge = |x: f64, _: f64| (x * 7.0).cos();
        let bare = field(33, 20, ridge).levelled(Level::Mean).unwrap();
        let tilted =
            field(33, 20, |x, y| ridge(x, y) + 1.0 + 0.4 * x + 0.1 * y).levelled(Level::Plane).unwrap();
        let worst =
            bare.heights().iter().zip(tilted.heights()).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(worst < 1e-13, "{worst}");
    }

    #[test]
    fn a_single_sample_row_or_column_levels_to_zero() {
        for (columns, rows) in [(1, 1), (1, 9), (9, 1)] {
            let line = field(columns, rows, |x, y| 2.0 + x + y);
            assert!(largest(&line.levelled(Level::Plane).unwrap()) < 1e-14);
        }
    }

    #[test]
    fn heights_too_large_to_sum_are_an_error() {
        let huge = HeightField::new(2, 1, [1.0; 2], vec![f64::MAX; 2]).unwrap();
        assert!(huge.levelled(Level::Mean).is_err());
    }

    #[test]
    fn every_name_means_its_level() {
        for level in Level::ALL {
            assert_eq!(Level::from_name(level.name()), Some(level));
        }
        assert_eq!(Level::from_name("Plane "), None);
    }
}
