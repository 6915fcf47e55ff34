//! Spikes: single samples that stand far out of their neighbours.

use crate::error::Result;
use crate::surface::HeightField;
use rayon::prelude::*;

/// Distance of a spike from the range of its eight neighbours, in large steps.
const CLEAR: f64 = 3.0;
/// The step that counts as large: nine of ten steps between neighbouring samples are smaller. Some spikes do not move it, and the crest of
/// a smooth surface is never three of its larger steps above its neighbours.
const LARGE_STEP: f64 = 0.9;
/// Steps that the large one is chosen from, evenly spread over larger fields.
const MOST_STEPS: usize = 1 << 20;

/// Returns `field` with every spike replaced by the median of its neighbours. Nothing else moves.
///
/// # Errors
/// Heights so far apart that their differences are not finite numbers.
pub(super) fn apply(field: &HeightField) -> Result<HeightField> {
    let threshold = CLEAR * large_step(field);
    let mut heights = field.heights().to_vec();
    heights.par_chunks_mut(field.columns()).enumerate().for_each(|(row, heights)| {
        let last = field.columns() - 1;
        let beside = [row.checked_sub(1), Some(row + 1).filter(|r| *r < field.rows())];
        let beside = beside.map(|row| row.map_or(&[][..], |row| field.row(row)));
        let here = field.row(row);
        for (column, h) in heights.iter_mut().enumerate() {
            let (from, to) = (column.saturating_sub(1), (column + 1).min(last));
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            let mut widen = |heights: &[f64]| {
                for h in heights {
                    low = low.min(*h);
                    high = high.max(*h);
                }
            };
            beside.iter().for_each(|line| widen(line.get(from..=to).unwrap_or_default()));
            widen(&here[from..column]);
            widen(&here[column + 1..=to.max(column)]);
            if low <= high && (*h > high + threshold || *h < low - threshold) {
                *h = median_of_neighbours(field, column, row);
            }
        }
    });
    HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights)
}

/// Returns the median of the up to eight neighbours of a sample, of which there is at least one.
fn median_of_neighbours(field: &HeightField, column: usize, row: usize) -> f64 {
    let mut around = Vec::with_capacity(8);
    for r in row.saturating_sub(1)..=(row + 1).min(field.rows() - 1) {
        for c in column.saturating_sub(1)..=(column + 1).min(field.columns() - 1) {
            if (r, c) != (row, column) {
                around.push(field.row(r)[c]);
            }
        }
    }
    super::rows::median(&around)
}

/// Returns the quantile [`LARGE_STEP`] of the absolute height differences of neighbouring samples \[µm\].
fn large_step(field: &HeightField) -> f64 {
    let samples = field.heights().len();
    let steps_of = |i: usize| {
        let (column, row) = (i % field.columns(), i / field.columns());
        let here = field.heights()[i];
        let right = field.row(row).get(column + 1).map(|h| (h - here).abs());
        let below = field.heights().get(i + field.columns()).map(|h| (h - here).abs());
        right.into_iter().chain(below)
    };
    let mut steps: Vec<f64> = (0..samples).step_by(samples.div_ceil(MOST_STEPS)).flat_map(steps_of).collect();
    if steps.is_empty() {
        return 0.0;
    }
    let place = ((steps.len() - 1) as f64 * LARGE_STEP) as usize;
    *steps.select_nth_unstable_by(place, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::tests::field;
    use crate::surface::synth::{Spec, SurfaceKind, generate};

    #[test]
    fn a_spike_of_one_sample_is_replaced_and_nothing_else_moves() {
        let ridge = |x: f64, y: f64| 0.2 * (4.0 * x).sin() + 0.1 * (3.0 * y).cos();
        let clean = field(40, 30, ridge);
        for (place, height) in [(15 * 40 + 17, 1.0), (0, -1.0), (40 * 30 - 1, 5.0), (39, 0.6)] {
            let mut heights = clean.heights().to_vec();
            heights[place] += height;
            let left = apply(&HeightField::new(40, 30, clean.pixel_size(), heights).unwrap()).unwrap();
            for (i, (a, b)) in left.heights().iter().zip(clean.heights()).enumerate() {
                let moved = (a - b).abs();
                assert!(if i == place { moved < 0.05 } else { moved == 0.0 }, "sample {i}: {moved}");
            }
        }
    }

    #[test]
    fn surfaces_without_spikes_keep_every_height() {
        for kind in SurfaceKind::ALL {
            let surface = generate(&Spec { patch: Some([10.0; 2]), ..Spec::new(kind) }).unwrap();
            assert_eq!(apply(&surface).unwrap(), surface, "{kind:?}: crests and walls are no spikes");
        }
    }
}
