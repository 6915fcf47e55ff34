//! Streaks: runs of samples along a row that differ from the rows above and below, left by a probe that lost the surface for a moment.
//!
//! Offsets of whole rows are removed by [`super::Levelling::Rows`]. A surface with grooves one to three samples wide along the rows has
//! such runs everywhere: leave this step out for it.

use crate::error::Result;
use crate::surface::HeightField;
use rayon::prelude::*;

/// A streak is above (or below) both rows beside it by more than this many times the RMS step from row to row. For a sinusoid of any period
/// and direction the factor is at most √2.
const CLEAR: f64 = 2.0;
/// Largest number of rows of a streak.
const WIDEST: usize = 3;
/// Samples that a streak has at least; a quarter of a shorter row. Anything shorter may be a particle, which is about as high as wide.
const SHORTEST: usize = 16;

/// Returns `field` with each streak replaced by the straight line between the samples above and below it. Nothing else moves.
///
/// # Errors
/// Heights so far apart that their differences are not finite numbers.
pub(super) fn apply(field: &HeightField) -> Result<HeightField> {
    let threshold = CLEAR * step_between_rows(field);
    let shortest = SHORTEST.min(field.columns().div_ceil(4));
    let mut heights = field.heights().to_vec();
    let mut clean = vec![true; field.heights().len()];
    for width in 1..=WIDEST {
        let candidates = (1..field.rows().saturating_sub(width))
            .into_par_iter()
            .flat_map_iter(|first| [1.0, -1.0].map(|sign| Streak { field, first, width, sign }));
        let found: Vec<_> = candidates
            .map(|streak| (streak.runs(threshold, shortest), streak))
            .filter(|(runs, _)| !runs.is_empty())
            .collect();
        for (runs, streak) in found {
            runs.into_iter().for_each(|run| streak.replace(run, &mut heights, &mut clean));
        }
    }
    HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights)
}

/// Returns the RMS height difference of neighbouring rows \[µm\].
fn step_between_rows(field: &HeightField) -> f64 {
    let below = field.heights().iter().skip(field.columns());
    let squares: f64 = field.heights().iter().zip(below).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / (field.heights().len() - field.columns()).max(1) as f64).sqrt()
}

/// Rows that may be a streak: `first` and the next ones, `width` in all, with a row above and one below.
struct Streak<'a> {
    field: &'a HeightField,
    first: usize,
    width: usize,
    /// 1 for a streak above the surface, −1 for one below.
    sign: f64,
}

impl Streak<'_> {
    fn above(&self) -> &[f64] {
        self.field.row(self.first - 1)
    }

    fn below(&self) -> &[f64] {
        self.field.row(self.first + self.width)
    }

    /// Returns the height by which the rows stand out of both neighbouring rows, in each column; negative if they do not.
    fn clearances(&self) -> Vec<f64> {
        let beside = self.above().iter().zip(self.below());
        let mut clearances = vec![f64::INFINITY; self.field.columns()];
        for row in self.first..self.first + self.width {
            clearances.iter_mut().zip(self.field.row(row)).for_each(|(c, h)| *c = c.min(self.sign * h));
        }
        let outside = beside.map(|(a, b)| (self.sign * a).max(self.sign * b));
        clearances.iter_mut().zip(outside).for_each(|(c, outside)| *c -= outside);
        clearances
    }

    /// Returns the runs of columns that are clear by more than `threshold`, each at least `shortest` long.
    fn runs(&self, threshold: f64, shortest: usize) -> Vec<std::ops::Range<usize>> {
        let mut runs = Vec::new();
        let mut start = 0;
        for (column, clearance) in self.clearances().into_iter().chain([f64::NEG_INFINITY]).enumerate() {
            if clearance > threshold {
                continue;
            }
            if column - start >= shortest {
                runs.push(start..column);
            }
            start = column + 1;
        }
        runs
    }

    /// Replaces the samples of `run` that no narrower streak has replaced.
    fn replace(&self, run: std::ops::Range<usize>, heights: &mut [f64], clean: &mut [bool]) {
        for column in run {
            for i in 0..self.width {
                let part = (i + 1) as f64 / (self.width + 1) as f64;
                let place = (self.first + i) * self.field.columns() + column;
                if std::mem::replace(&mut clean[place], false) {
                    heights[place] = self.above()[column] * (1.0 - part) + self.below()[column] * part;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::tests::field;
    use crate::surface::synth::{Spec, SurfaceKind, generate};

    #[test]
    fn a_streak_is_replaced_by_what_is_beside_it_and_nothing_else_moves() {
        let clean = field(60, 40, |x, y| 0.1 * (7.0 * x).sin() + 0.03 * y);
        for (rows, height) in [(10..11, 0.2), (20..22, -0.3), (5..8, 0.25)] {
            let mut heights = clean.heights().to_vec();
            let within = |i: usize| rows.contains(&(i / 60)) && (15..45).contains(&(i % 60));
            (0..heights.len()).filter(|i| within(*i)).for_each(|i| heights[i] += height);
            let left = apply(&HeightField::new(60, 40, clean.pixel_size(), heights).unwrap()).unwrap();
            for (i, (a, b)) in left.heights().iter().zip(clean.heights()).enumerate() {
                // Along y the surface is straight: the line between the rows beside is the surface.
                let most = if within(i) { 1e-12 } else { 0.0 };
                assert!((a - b).abs() <= most, "{rows:?}, sample {i}: {a} and not {b}");
            }
        }
    }

    #[test]
    fn surfaces_without_streaks_keep_every_height() {
        for kind in SurfaceKind::ALL {
            let surface = generate(&Spec { patch: Some([10.0; 2]), ..Spec::new(kind) }).unwrap();
            assert_eq!(apply(&surface).unwrap(), surface, "{kind:?}");
        }
        for period in 2..12 {
            let grooves = field(40, 60, |_, y| (std::f64::consts::TAU * y / 0.07 / f64::from(period)).sin());
            assert_eq!(
                apply(&grooves).unwrap(),
                grooves,
                "grooves along the rows, {period} samples a period"
            );
        }
    }
}
