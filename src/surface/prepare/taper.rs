//! Tapering: heights that fade to their mean at the edges, so that copies meet on level ground.

use super::words::about;
use crate::error::{Error, Result};
use crate::surface::HeightField;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Returns `field` with its deviation from the mean height multiplied by a raised cosine (a Tukey window) over `length` \[µm\] at each
/// edge.
///
/// # Errors
/// A `length` of more than half a side.
pub(super) fn apply(field: &HeightField, length: f64) -> Result<HeightField> {
    let [width, height] = field.patch_size();
    if 2.0 * length > width.min(height) {
        return Err(Error::input(
            format!("the edges overlap on a field of {} x {}", about(width), about(height)),
            "give at most half of the shorter side",
        ));
    }
    let [dx, dy] = field.pixel_size();
    let [across, down] =
        [(field.columns(), dx), (field.rows(), dy)].map(|(n, spacing)| window(n, spacing, length));
    let mean = crate::surface::statistics::mean(field);
    let mut heights = field.heights().to_vec();
    heights.par_chunks_mut(field.columns()).zip(&down).for_each(|(row, down)| {
        row.iter_mut().zip(&across).for_each(|(h, across)| *h = mean + across * down * (*h - mean));
    });
    HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights)
}

/// Returns a window of 1 inside, falling to 0 at the outer edges of the first and the last of `n` cells.
fn window(n: usize, spacing: f64, length: f64) -> Vec<f64> {
    let weight = |i: usize| {
        let from_edge = (i.min(n - 1 - i) as f64 + 0.5) * spacing;
        if from_edge < length { 0.5 - 0.5 * (PI * from_edge / length).cos() } else { 1.0 }
    };
    (0..n).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::tests::field;
    use crate::surface::tiling::{Verdict, tiles};

    #[test]
    fn tapered_edges_meet_and_the_middle_stays() {
        let tilted = field(60, 60, |x, y| 2.0 + 0.3 * x + 0.1 * (5.0 * y).sin());
        assert_ne!(tiles(&tilted).verdict, Verdict::Tiles);
        let tapered = apply(&tilted, 1.0).unwrap();
        assert_eq!(tiles(&tapered).verdict, Verdict::Tiles);
        let mean = tilted.heights().iter().sum::<f64>() / 3600.0;
        assert!((tapered.row(30)[0] - mean).abs() < 0.01 * (tilted.row(30)[0] - mean).abs());
        for (column, row) in [(10, 15), (30, 30), (49, 44)] {
            assert!((tapered.row(row)[column] - tilted.row(row)[column]).abs() < 1e-15);
        }
        // Half way in, the raised cosine is a half: 5 samples of 100 nm lie on both sides of 0.5 um.
        let [at, next] = [4, 5].map(|c| (tapered.row(30)[c] - mean) / (tilted.row(30)[c] - mean));
        assert!((at + next - 1.0).abs() < 1e-12);
    }

    #[test]
    fn edges_that_overlap_are_refused_with_the_size() {
        let e = apply(&field(60, 60, |x, _| x), 2.2).unwrap_err().to_string();
        assert!(e.contains("6um x 4.2um"), "{e}");
    }
}
