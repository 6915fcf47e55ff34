//! Orders blurred and thinned out, level by level, for averages over many of them: light from all around spreads over thousands of orders.
//!
//! Each level has half the points of the one below, blurred by a Gaussian that is at least as wide as its points are apart. What a wider Gaussian averages over
//! is the level's points under the Gaussian that the blur lacks. Both are sampled at their standard deviation at least, so that aliases are
//! exp(−2π²) = 3e-9 of the sum.

use super::spread::CUT;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Series at points between the orders, blurred.
pub(super) struct PyramidLevel {
    /// Orders from point to point along x and y.
    pub step: [f64; 2],
    /// Variance of the blur along x and y \[orders²\], at least the square of `step`.
    pub variance: [f64; 2],
    grid: Grid,
    terms: usize,
    series: Vec<f32>,
}

/// Points along an axis, by number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GridLine {
    /// Number of the first; 0 where they wrap around.
    pub first: i64,
    /// How many there are.
    pub size: usize,
    /// Whether the first follows the last.
    pub wraps: bool,
}

/// Points along x and y.
pub(super) type Grid = [GridLine; 2];

impl GridLine {
    fn place(&self, number: i64) -> Option<usize> {
        if self.wraps {
            return Some(number.rem_euclid(self.size as i64) as usize);
        }
        usize::try_from(number - self.first).ok().filter(|&i| i < self.size)
    }

    /// About every second point, as far as a Gaussian that ends `reach` points away carries anything; and how many points it is from one to the next. A line that
    /// wraps around has a whole number of them.
    fn thinned(&self, reach: f64) -> (Self, f64) {
        if self.wraps {
            let size = self.size.div_ceil(2);
            return (Self { size, ..*self }, self.size as f64 / size as f64);
        }
        let reach = reach.ceil() as i64;
        let first = (self.first - reach).div_euclid(2);
        let last = (self.first + self.size as i64 + reach).div_euclid(2);
        (Self { first, size: (last - first + 1) as usize, wraps: false }, 2.0)
    }
}

impl PyramidLevel {
    /// The series of point (x, y); `None` where nothing reaches.
    pub fn at(&self, x: i64, y: i64) -> Option<&[f32]> {
        let [columns, rows] = &self.grid;
        let begin = (rows.place(y)? * columns.size + columns.place(x)?) * self.terms;
        Some(&self.series[begin..begin + self.terms])
    }
}

/// Variance of the blur of the first level along x and y \[orders²\]: two orders, the farthest that its points are apart.
pub(super) const NARROWEST: [f64; 2] = [4.0; 2];

/// All levels above the orders on `grid`, whose series of `terms` terms `orders` gives, down to a few points.
pub(super) fn levels<'a>(
    grid: Grid,
    terms: usize,
    orders: impl Fn(i64, i64) -> Option<&'a [f32]> + Sync,
) -> Vec<PyramidLevel> {
    /// Points along the longer side of the last level.
    const FEWEST: usize = 32;
    let goes_on = |grid: &Grid| grid.iter().any(|line| line.size > FEWEST);
    let mut levels: Vec<PyramidLevel> = Vec::new();
    if goes_on(&grid) {
        levels.push(thinned(grid, NARROWEST[0].sqrt(), terms, &orders));
    }
    while let Some(last) = levels.last().filter(|level| goes_on(&level.grid)) {
        // A blur of one point and one of √3 make one of two.
        let mut next = thinned(last.grid, 3f64.sqrt(), terms, &|x, y| last.at(x, y));
        for axis in 0..2 {
            next.variance[axis] = last.variance[axis] + next.variance[axis] * last.step[axis].powi(2);
            next.step[axis] *= last.step[axis];
        }
        levels.push(next);
    }
    levels
}

/// What a Gaussian gathers at a point: the first of the points that it reaches, and the weight of each.
struct Gathered {
    first: i64,
    weights: Vec<f32>,
}

/// What each point of `next`, `step` points of another line apart, gathers from that line by a Gaussian of standard deviation `blur` \[points\].
fn gathered(next: &GridLine, step: f64, blur: f64) -> Vec<Gathered> {
    let density = |x: f64| (-0.5 * (x / blur).powi(2)).exp() / ((2.0 * PI).sqrt() * blur);
    let at = |number: i64| {
        let centre = number as f64 * step;
        let first = (centre - CUT * blur).ceil() as i64;
        let last = (centre + CUT * blur).floor() as i64;
        Gathered { first, weights: (first..=last).map(|i| density(i as f64 - centre) as f32).collect() }
    };
    (next.first..next.first + next.size as i64).map(at).collect()
}

/// About every second point of `grid`, blurred by a Gaussian of standard deviation `blur` \[points\].
fn thinned<'a>(
    grid: Grid,
    blur: f64,
    terms: usize,
    at: &(impl Fn(i64, i64) -> Option<&'a [f32]> + Sync),
) -> PyramidLevel {
    let lines = grid.map(|line| line.thinned(CUT * blur));
    let [gathered_x, gathered_y] = lines.map(|(line, step)| gathered(&line, step, blur));
    let (next, step) = (lines.map(|(line, _)| line), lines.map(|(_, step)| step));
    let [columns, rows] = next.map(|line| line.size);
    let add = |sum: &mut [f32], series: Option<&[f32]>, weight: f32| {
        for (sum, a) in sum.iter_mut().zip(series.unwrap_or_default()) {
            *sum += weight * a;
        }
    };
    let mut along_x = vec![0f32; columns * grid[1].size * terms];
    along_x.par_chunks_mut(columns * terms).enumerate().for_each(|(row, out)| {
        let y = grid[1].first + row as i64;
        for (sum, from) in out.chunks_exact_mut(terms).zip(&gathered_x) {
            (from.first..).zip(&from.weights).for_each(|(x, &weight)| add(sum, at(x, y), weight));
        }
    });
    let mut series = vec![0f32; columns * rows * terms];
    series.par_chunks_mut(columns * terms).zip(&gathered_y).for_each(|(out, from)| {
        for (y, &weight) in (from.first..).zip(&from.weights) {
            let line = grid[1].place(y).map(|row| &along_x[row * columns * terms..][..columns * terms]);
            add(out, line, weight);
        }
    });
    PyramidLevel { step, variance: [blur * blur; 2], grid: next, terms, series }
}
