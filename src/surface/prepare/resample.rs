//! Another distance between samples over the same patch.

use super::interpolate::{EdgeRule, Resampler};
use crate::error::{Error, Result};
use crate::memory;
use crate::surface::transpose::transposed;
use crate::surface::{HeightField, MAX_SIDE, statistics};
use rayon::prelude::*;

/// Returns `field` with samples about `spacing` \[µm\] apart: the nearest spacing that divides the patch, so that the patch keeps its size
/// and a periodic field stays periodic. Frequencies that the new samples cannot hold are filtered out.
///
/// # Errors
/// More samples than [`MAX_SIDE`] on a side or than the memory holds.
pub(super) fn apply(field: &HeightField, spacing: [f64; 2]) -> Result<HeightField> {
    let patch = field.patch_size();
    let wanted = [0, 1].map(|axis| (patch[axis] / spacing[axis]).round().max(1.0));
    if wanted.iter().any(|n| *n > MAX_SIDE as f64) {
        return Err(Error::limit(
            format!("{} x {} samples are more than {MAX_SIDE} on a side", wanted[0], wanted[1]),
            "give a larger distance between samples",
        ));
    }
    let [columns, rows] = wanted.map(|n| n as usize);
    let largest = columns.max(field.columns()) as u64 * rows.max(field.rows()) as u64;
    memory::ensure_room(3 * largest * size_of::<f64>() as u64, &format!("{columns} x {rows} samples"))?;
    let tiling = statistics::joining(field)?;
    let across = along_rows(field.heights(), field.columns(), columns, EdgeRule::of(&tiling, 0));
    let turned = transposed(columns, &across);
    let both = along_rows(&turned, field.rows(), rows, EdgeRule::of(&tiling, 1));
    let pixel_size = [patch[0] / columns as f64, patch[1] / rows as f64];
    HeightField::new(columns, rows, pixel_size, transposed(rows, &both))
}

/// Resamples rows of `old` samples to rows of `new` ones.
fn along_rows(heights: &[f64], old: usize, new: usize, beyond: EdgeRule) -> Vec<f64> {
    if old == new {
        return heights.to_vec();
    }
    let resampler = Resampler::new(old, new);
    let mut resampled = vec![0.0; heights.len() / old * new];
    resampled.par_chunks_mut(new).zip(heights.par_chunks(old)).for_each(|(new, old)| {
        new.iter_mut().zip(resampler.apply(old, beyond)).for_each(|(h, value)| *h = value);
    });
    resampled
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::tests::{difference, field};
    use std::f64::consts::TAU;

    #[test]
    fn a_band_limited_sinusoid_is_kept_by_more_and_by_fewer_samples() {
        // Whole periods over 10 µm x 7 µm: the field tiles. The shortest has five samples a period after the coarsest step.
        let wave = |x: f64, y: f64| 0.2 * (TAU * (0.5 * x + y / 3.5)).sin() + 0.1 * (TAU * 1.2 * x).cos();
        let old = field(100, 100, wave);
        for (spacing, samples) in
            [([0.073, 0.05], [137, 140]), ([0.15, 0.175], [67, 40]), ([0.16, 0.07], [63, 100])]
        {
            let new = apply(&old, spacing).unwrap();
            assert_eq!([new.columns(), new.rows()], samples);
            assert!((new.patch_size()[0] - 10.0).abs() < 1e-12 && (new.patch_size()[1] - 7.0).abs() < 1e-12);
            let worst = (0..new.heights().len()).fold(0.0f64, |worst, i| {
                let (c, r) = (i % new.columns(), i / new.columns());
                worst.max((new.row(r)[c] - wave(new.x(c), new.y(r))).abs())
            });
            assert!(worst < 3e-5, "{spacing:?}: {worst}");
        }
    }

    #[test]
    fn a_frequency_that_the_new_samples_cannot_hold_vanishes() {
        let fine = field(100, 20, |x, _| (TAU * 4.0 * x).sin());
        let coarse = apply(&fine, [0.2, 0.07]).unwrap();
        let largest = coarse.heights().iter().fold(0.0f64, |m, h| m.max(h.abs()));
        assert!(largest < 1e-3, "a period of 250 nm from samples 200 nm apart: {largest}");
    }

    #[test]
    fn a_tilted_plane_that_does_not_tile_stays_a_plane() {
        let plane = field(50, 40, |x, y| 1.0 + 0.3 * x - 0.2 * y);
        let new = apply(&plane, [0.07, 0.1]).unwrap();
        for (column, row) in [(0, 0), (new.columns() - 1, 0), (20, new.rows() - 1)] {
            let expected = 1.0 + 0.3 * new.x(column) - 0.2 * new.y(row);
            assert!((new.row(row)[column] - expected).abs() < 3e-5, "{column}, {row}");
        }
    }

    #[test]
    fn the_same_spacing_changes_nothing_and_too_small_a_one_is_refused() {
        let some = field(30, 20, |x, y| (x * y).sin());
        assert_eq!(difference(&apply(&some, [0.1, 0.07]).unwrap(), &some), 0.0);
        assert!(apply(&some, [1e-6, 0.07]).unwrap_err().to_string().contains("more than"));
        assert_eq!(apply(&some, [100.0, 100.0]).unwrap().heights().len(), 1);
    }
}
