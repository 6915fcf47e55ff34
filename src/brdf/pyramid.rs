//! Orders blurred and thinned out, level by level, for averages over many of them: light from all around spreads over thousands of orders.
//!
//! Level n has every 2ⁿth order, blurred by a Gaussian of that standard deviation. What a wider Gaussian averages over is the level's points under the Gaussian
//! that the blur lacks. Both are sampled at their standard deviation at least, so that aliases are exp(−2π²) = 3e-9 of the sum.

use super::spread::CUT;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Series of every `step`th order, blurred by a Gaussian of `step` orders.
pub(super) struct Level {
    /// Orders from point to point.
    pub step: f64,
    grid: Grid,
    terms: usize,
    series: Vec<f32>,
}

/// Points along an axis, by number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// Number of the first; 0 where they wrap around.
    pub first: i64,
    /// How many there are.
    pub size: usize,
    /// Whether the first follows the last.
    pub wraps: bool,
}

/// Points along x and y.
pub(super) type Grid = [Line; 2];

impl Line {
    fn place(&self, number: i64) -> Option<usize> {
        if self.wraps {
            return Some(number.rem_euclid(self.size as i64) as usize);
        }
        usize::try_from(number - self.first).ok().filter(|&i| i < self.size)
    }

    /// Every second point, as far as a Gaussian that ends `reach` points away carries anything.
    fn thinned(&self, reach: i64) -> Self {
        if self.wraps {
            return Self { size: self.size / 2, ..*self };
        }
        let first = (self.first - reach).div_euclid(2);
        let last = (self.first + self.size as i64 + reach).div_euclid(2);
        Self { first, size: (last - first + 1) as usize, wraps: false }
    }

    /// Whether every second of its points are points of the same line.
    fn can_be_thinned(&self) -> bool {
        !self.wraps || self.size.is_multiple_of(2)
    }
}

impl Level {
    /// The series of point (x, y); `None` where nothing reaches.
    pub fn at(&self, x: i64, y: i64) -> Option<&[f32]> {
        let [columns, rows] = &self.grid;
        let begin = (rows.place(y)? * columns.size + columns.place(x)?) * self.terms;
        Some(&self.series[begin..begin + self.terms])
    }
}

/// All levels above the orders on `grid`, whose series of `terms` terms `orders` gives, down to a few points. A line that wraps around ends them where
/// it has an odd number of points.
pub(super) fn levels<'a>(
    grid: Grid,
    terms: usize,
    orders: impl Fn(i64, i64) -> Option<&'a [f32]> + Sync,
) -> Vec<Level> {
    /// Points along the longer side of the last level.
    const FEWEST: usize = 32;
    let goes_on =
        |grid: &Grid| grid.iter().all(Line::can_be_thinned) && grid.iter().any(|line| line.size > FEWEST);
    let mut levels: Vec<Level> = Vec::new();
    if goes_on(&grid) {
        // From no blur to two points.
        levels.push(thinned(grid, 1.0, 2.0, terms, &orders));
    }
    while let Some(last) = levels.last().filter(|level| goes_on(&level.grid)) {
        // From one point to two.
        let next = thinned(last.grid, last.step, 3f64.sqrt(), terms, &|x, y| last.at(x, y));
        levels.push(next);
    }
    levels
}

/// Every second point of `grid`, whose points stand `step` orders apart, blurred by a Gaussian of standard deviation `blur` \[points\].
fn thinned<'a>(
    grid: Grid,
    step: f64,
    blur: f64,
    terms: usize,
    at: &(impl Fn(i64, i64) -> Option<&'a [f32]> + Sync),
) -> Level {
    let reach = (CUT * blur).ceil() as i64;
    let weight = |i: i64| ((-0.5 * (i as f64 / blur).powi(2)).exp() / ((2.0 * PI).sqrt() * blur)) as f32;
    let weights: Vec<(i64, f32)> = (-reach..=reach).map(|i| (i, weight(i))).collect();
    let next = grid.map(|line| line.thinned(reach));
    let [columns, rows] = next.map(|line| line.size);
    let add = |sum: &mut [f32], series: Option<&[f32]>, weight: f32| {
        for (sum, a) in sum.iter_mut().zip(series.unwrap_or_default()) {
            *sum += weight * a;
        }
    };
    let mut along_x = vec![0f32; columns * grid[1].size * terms];
    along_x.par_chunks_mut(columns * terms).enumerate().for_each(|(row, out)| {
        let y = grid[1].first + row as i64;
        for (column, sum) in out.chunks_exact_mut(terms).enumerate() {
            let x = 2 * (next[0].first + column as i64);
            weights.iter().for_each(|&(i, weight)| add(sum, at(x + i, y), weight));
        }
    });
    let mut series = vec![0f32; columns * rows * terms];
    series.par_chunks_mut(columns * terms).enumerate().for_each(|(row, out)| {
        let y = 2 * (next[1].first + row as i64);
        for &(i, weight) in &weights {
            let line = grid[1].place(y + i).map(|row| &along_x[row * columns * terms..][..columns * terms]);
            add(out, line, weight);
        }
    });
    Level { step: 2.0 * step, grid: next, terms, series }
}
