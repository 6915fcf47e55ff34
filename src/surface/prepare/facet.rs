//! Levelling by facets: the tilt that most of the surface shares becomes horizontal.
//!
//! The plane of least squares through a staircase follows its steps. The slopes of its small facets do not: most of them have the slope of
//! the terraces. The highest density of slopes is found by mean shift [Cheng 1995, "Mean shift, mode seeking, and clustering"] with a
//! Gaussian kernel, from the mean slope on; Gwyddion's facet levelling is the same iteration.

use crate::error::Result;
use crate::sums;
use crate::surface::HeightField;
use rayon::prelude::*;

/// The kernel's variance as a share of the slopes' mean square deviation: wide enough to reach the next mode, narrow enough to leave
/// walls out (1/20, the value of Gwyddion's documentation).
const KERNEL: f64 = 1.0 / 20.0;
/// Largest number of iterations, which converge geometrically.
const MOST_ITERATIONS: usize = 100;
/// Shift relative to the slopes' deviation below which it is rounding.
const CONVERGED: f64 = 1e-10;
/// Largest number of facets, evenly spread over larger fields.
const MOST_FACETS: usize = 1 << 18;

/// Returns `field` less the plane of the most frequent slope and less its mean.
///
/// # Errors
/// Heights so large that their sums are not finite numbers.
pub(super) fn level(field: &HeightField) -> Result<HeightField> {
    let slope = most_frequent(&slopes(field));
    let mut heights = field.heights().to_vec();
    heights.par_chunks_mut(field.columns()).enumerate().for_each(|(row, heights)| {
        let offset = slope[1] * field.y(row);
        heights.iter_mut().enumerate().for_each(|(column, h)| *h -= slope[0] * field.x(column) + offset);
    });
    let tilted = HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights)?;
    super::polynomial::subtract(&tilted, 0)
}

/// Slopes along `x` and `y` of the facets between four neighbouring samples, or of the single line that there is.
fn slopes(field: &HeightField) -> Vec<[f64; 2]> {
    let [dx, dy] = field.pixel_size();
    let (columns, rows) = (field.columns(), field.rows());
    let facets = (columns - 1).max(1) * (rows - 1).max(1);
    let step = facets.div_ceil(MOST_FACETS);
    let facet = |i: usize| {
        let (column, row) = (i % (columns - 1).max(1), i / (columns - 1).max(1));
        let (right, below) = ((column + 1).min(columns - 1), (row + 1).min(rows - 1));
        let [a, b] = [column, right].map(|c| field.row(row)[c]);
        let [c, d] = [column, right].map(|c| field.row(below)[c]);
        [(b - a + d - c) / (2.0 * dx), (a - c + b - d) / (2.0 * dy)] // y grows up
    };
    (0..facets).step_by(step).map(facet).collect()
}

fn most_frequent(slopes: &[[f64; 2]]) -> [f64; 2] {
    let mean = |weight: &(dyn Fn(&[f64; 2]) -> f64 + Sync)| {
        let add = |a: [f64; 3], b: [f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let weighted = |s: &[f64; 2]| {
            let weight = weight(s);
            [weight * s[0], weight * s[1], weight]
        };
        let add_one = |sum, i: usize| add(sum, weighted(&slopes[i]));
        let [x, y, total] = sums::of_range(0..slopes.len(), || [0.0; 3], add_one, add);
        [x / total, y / total]
    };
    let distance = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
    let mut mode = mean(&|_| 1.0);
    for _ in 0..MOST_ITERATIONS {
        let add_one = |sum: f64, i: usize| sum + distance(&slopes[i], &mode);
        let variance = sums::of_range(0..slopes.len(), || 0.0, add_one, |a, b| a + b) / slopes.len() as f64;
        if variance == 0.0 {
            break; // a plane
        }
        let next = mean(&|s| (-distance(s, &mode) / (2.0 * KERNEL * variance)).exp());
        if !next.iter().all(|s| s.is_finite()) {
            break; // no facet is near: the mean slope is in a gap and the best there is
        }
        let shift = distance(&next, &mode);
        mode = next;
        if shift <= CONVERGED * CONVERGED * variance {
            break;
        }
    }
    mode
}

#[cfg(test)]
mod tests {
    use crate::surface::prepare::tests::{difference, field};
    use crate::surface::prepare::{Levelling, PreparationStep};

    /// Terraces 1 µm wide, each 50 nm above the one before.
    fn staircase(x: f64) -> f64 {
        0.05 * (x + 0.013).floor()
    }

    #[test]
    fn the_terraces_of_a_tilted_staircase_become_horizontal() {
        let tilted = field(100, 30, |x, y| staircase(x) + 0.02 * x - 0.01 * y);
        let flat = field(100, 30, |x, _| staircase(x)).levelled(Levelling::Mean).unwrap();
        assert!(difference(&tilted.levelled(Levelling::Facet).unwrap(), &flat) < 1e-9);
        let by_plane = tilted.levelled(Levelling::Plane).unwrap();
        assert!(difference(&by_plane, &flat) > 0.1, "the plane of least squares follows the steps");
    }

    #[test]
    fn a_plane_vanishes_and_a_line_is_levelled_along_itself() {
        for (columns, rows) in [(30, 20), (30, 1), (1, 20), (1, 1)] {
            let plane = field(columns, rows, |x, y| 4.0 + 0.3 * x + 0.2 * y);
            let left = PreparationStep::Level(Levelling::Facet).apply(&plane).unwrap();
            assert!(left.heights().iter().all(|h| h.abs() < 1e-13), "{columns} x {rows}");
        }
    }
}
