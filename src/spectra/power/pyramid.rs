//! Levels of the orders for averages over many of them, like mip levels of a texture: each is a Gaussian blur of the one below at half the
//! points along one axis or both. A wider Gaussian is then a short sum over a level's points.

use super::orders::OrderGrid;
use super::series::OrderSeries;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Accuracy of a pyramid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Downsampling {
    /// Standard deviation b of a level's blur, and least one of the Gaussian that reads it, over the distance of its points. Aliases are at
    /// most exp(−π²b²) of the sum, at the lags that both blurs together attenuate least.
    pub blur: f64,
    /// Standard deviations within which a Gaussian is summed.
    pub reach: f64,
}

impl Downsampling {
    /// Downsampling for the f64 reference: aliases of 2e-10 and cuts of 1e-10.
    pub const EXACT: Self = Self { blur: 1.5, reach: 6.8 };
    /// Downsampling for colour tables: aliases of 5e-5, and 6e-5 of a Gaussian beyond its cut along each axis.
    pub const FAST: Self = Self { blur: 1.0, reach: 4.0 };
}

/// Points along an axis, by number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridLine {
    /// Number of the first.
    pub first: i64,
    /// Number of points.
    pub size: usize,
    /// True if the first follows the last.
    pub wraps: bool,
}

impl GridLine {
    /// Returns the index of a point; `None` beyond the ends.
    pub fn place(&self, number: i64) -> Option<usize> {
        let place = number - self.first;
        if self.wraps {
            return Some(place.rem_euclid(self.size as i64) as usize);
        }
        usize::try_from(place).ok().filter(|&i| i < self.size)
    }

    /// Returns about every second point, up to `reach` points beyond the ends, where the Gaussian is cut off, and the ratio of the distances
    /// between points. A line that wraps around has a whole number of them.
    fn halved(&self, reach: f64) -> (Self, f64) {
        if self.wraps {
            let size = self.size.div_ceil(2);
            return (Self { first: 0, size, wraps: true }, self.size as f64 / size as f64);
        }
        let reach = reach.ceil() as i64;
        let first = (self.first - reach).div_euclid(2);
        let last = (self.first + self.size as i64 + reach).div_euclid(2);
        (Self { first, size: (last - first + 1) as usize, wraps: false }, 2.0)
    }
}

/// Position and blur of a level's points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelGrid {
    /// Points along x and y.
    pub lines: [GridLine; 2],
    /// Orders from point to point along x and y.
    pub step: [f64; 2],
    /// Variance of the blur along x and y \[orders²\]; 0 for the orders themselves.
    pub variance: [f64; 2],
}

impl LevelGrid {
    fn of_orders(orders: &OrderGrid) -> Self {
        let OrderGrid { size, origin, periodic, .. } = orders;
        let line =
            |axis: usize| GridLine { first: -(origin[axis] as i64), size: size[axis], wraps: periodic[axis] };
        Self { lines: [line(0), line(1)], step: [1.0; 2], variance: [0.0; 2] }
    }

    /// Returns the remaining variance along an axis for a Gaussian of variance `asked` \[orders²\]; `None` if it is too narrow to be
    /// sampled by the points.
    pub fn left(&self, axis: usize, asked: f64, blur: f64) -> Option<f64> {
        let left = asked - self.variance[axis];
        let least = if self.variance[axis] > 0.0 { (blur * self.step[axis]).powi(2) } else { 0.0 };
        (left >= least).then_some(left)
    }
}

/// Series of a level: density of power per order at its points.
pub struct PyramidLevel<'a> {
    /// Points.
    pub grid: LevelGrid,
    /// Terms of each series.
    pub terms: usize,
    /// `[row][column][term]`.
    pub series: &'a [f32],
}

impl<'a> PyramidLevel<'a> {
    /// Returns the series of point (x, y); `None` beyond the ends.
    pub fn at(&self, x: i64, y: i64) -> Option<&'a [f32]> {
        self.row(y)?.at(x)
    }

    /// Returns row `y`; `None` beyond the ends.
    pub fn row(&self, y: i64) -> Option<PyramidRow<'a>> {
        let [columns, rows] = &self.grid.lines;
        let begin = rows.place(y)? * columns.size * self.terms;
        let series = &self.series[begin..begin + columns.size * self.terms];
        Some(PyramidRow { columns: *columns, terms: self.terms, series })
    }
}

/// Row of points of a level.
#[derive(Clone, Copy)]
pub struct PyramidRow<'a> {
    columns: GridLine,
    terms: usize,
    series: &'a [f32],
}

impl<'a> PyramidRow<'a> {
    /// Returns the series of point `x`; `None` beyond the ends.
    pub fn at(&self, x: i64) -> Option<&'a [f32]> {
        self.columns.place(x).map(|place| self.series_of(place))
    }

    /// Returns the points from `first` on.
    pub fn points_from(self, first: i64) -> PyramidPoints<'a> {
        PyramidPoints { row: self, number: first, place: self.columns.place(first) }
    }

    /// Returns the series at this index of the row.
    fn series_of(&self, place: usize) -> &'a [f32] {
        &self.series[place * self.terms..(place + 1) * self.terms]
    }
}

/// Points of a row, one after the other.
pub struct PyramidPoints<'a> {
    row: PyramidRow<'a>,
    /// Number of the next point, and its index in the row.
    number: i64,
    place: Option<usize>,
}

impl<'a> PyramidPoints<'a> {
    /// Returns the series of the next point; `None` if it is beyond the ends.
    pub fn next_point(&mut self) -> Option<&'a [f32]> {
        let place = self.place;
        self.number += 1;
        // Only a step into the line, or over its end, needs a division.
        self.place = match place {
            Some(place) if place + 1 < self.row.columns.size => Some(place + 1),
            _ => self.row.columns.place(self.number),
        };
        place.map(|place| self.row.series_of(place))
    }
}

/// The orders and their levels.
pub struct Pyramid {
    /// Accuracy.
    pub downsampling: Downsampling,
    orders: LevelGrid,
    levels: Vec<(LevelGrid, Vec<f32>)>,
}

impl Pyramid {
    /// Computes the levels above the orders of `series`, down to a few points.
    pub fn new(series: &OrderSeries, downsampling: Downsampling) -> Self {
        let mut pyramid =
            Self { downsampling, orders: LevelGrid::of_orders(&series.grid), levels: Vec::new() };
        while let Some(halved) = pyramid.axes_to_halve(series) {
            let below = pyramid.level(pyramid.levels.len(), series);
            let next = downsampled(&below, halved, downsampling);
            pyramid.levels.push(next);
        }
        pyramid
    }

    /// Returns the level of the orders of `series` themselves.
    pub fn orders(series: &OrderSeries) -> PyramidLevel<'_> {
        let grid = LevelGrid::of_orders(&series.grid);
        PyramidLevel { grid, terms: series.terms, series: series.coefficients() }
    }

    /// Returns the number of levels, the orders included.
    pub fn count(&self) -> usize {
        self.levels.len() + 1
    }

    /// Returns a level; 0 is that of the orders of `series`.
    pub fn level<'a>(&'a self, number: usize, series: &'a OrderSeries) -> PyramidLevel<'a> {
        let (grid, values) = match number.checked_sub(1) {
            None => (&self.orders, series.coefficients()),
            Some(i) => (&self.levels[i].0, self.levels[i].1.as_slice()),
        };
        PyramidLevel { grid: *grid, terms: series.terms, series: values }
    }

    /// Returns the points of a level.
    pub fn grid(&self, number: usize) -> &LevelGrid {
        number.checked_sub(1).map_or(&self.orders, |i| &self.levels[i].0)
    }

    /// Returns the axes along which the next level has half the points: those along which they stand closest, in frequency. `None` if few
    /// are left.
    fn axes_to_halve(&self, series: &OrderSeries) -> Option<[bool; 2]> {
        /// Points along the longer side of the last level.
        const FEWEST: usize = 32;
        /// Ratio of two distances that count as alike.
        const ALIKE: f64 = 1.5;
        let last = self.grid(self.levels.len());
        let is_long = |axis: usize| last.lines[axis].size > FEWEST;
        let distance = |axis: usize| last.step[axis] / series.grid.patch[axis];
        let closest = (0..2).filter(|axis| is_long(*axis)).map(distance).fold(f64::INFINITY, f64::min);
        let halved = [0, 1].map(|axis| is_long(axis) && distance(axis) < ALIKE * closest);
        halved.contains(&true).then_some(halved)
    }
}

/// Points of the level below that a point gathers: the number of the first, and the weight of each.
struct Gathered {
    first: i64,
    weights: Vec<f32>,
}

/// Returns the points that each point of `next` gathers, `ratio` points apart, by a Gaussian of standard deviation `blur` \[points\].
fn gathered(next: &GridLine, ratio: f64, blur: f64, reach: f64) -> Vec<Gathered> {
    let density = |x: f64| (-0.5 * (x / blur).powi(2)).exp() / ((2.0 * PI).sqrt() * blur);
    let at = |number: i64| {
        let centre = number as f64 * ratio;
        if blur == 0.0 {
            return Gathered { first: number, weights: vec![1.0] };
        }
        let first = (centre - reach * blur).ceil() as i64;
        let last = (centre + reach * blur).floor() as i64;
        Gathered { first, weights: (first..=last).map(|i| density(i as f64 - centre) as f32).collect() }
    };
    (next.first..next.first + next.size as i64).map(at).collect()
}

/// Blurs `below` and keeps about every second point along the axes that are `halved`.
fn downsampled(below: &PyramidLevel<'_>, halved: [bool; 2], accuracy: Downsampling) -> (LevelGrid, Vec<f32>) {
    let (mut grid, mut taps) = (below.grid, [Vec::new(), Vec::new()]);
    for axis in 0..2 {
        let (line, step) = (below.grid.lines[axis], below.grid.step[axis]);
        let mut blur = 0.0;
        let (mut next, mut ratio) = (line, 1.0);
        if halved[axis] {
            // Variance of the blur of twice the distance of points, less that of the level below. The ratio is close to 2.
            let variance_below = below.grid.variance[axis] / (step * step);
            let widest = (2.0 * accuracy.blur).powi(2) - variance_below;
            (next, ratio) = line.halved(accuracy.reach * widest.sqrt());
            blur = ((ratio * accuracy.blur).powi(2) - variance_below).sqrt();
        }
        grid.lines[axis] = next;
        grid.step[axis] = step * ratio;
        grid.variance[axis] += (blur * step).powi(2);
        taps[axis] = gathered(&next, ratio, blur, accuracy.reach);
    }
    let [columns, rows] = grid.lines.map(|line| line.size);
    let terms = below.terms;
    let [line_x, line_y] = below.grid.lines;
    let add = |sum: &mut [f32], from: &[f32], weight: f32| {
        sum.iter_mut().zip(from).for_each(|(sum, a)| *sum += weight * a);
    };
    let mut along_x = vec![0f32; columns * line_y.size * terms];
    let row_length = line_x.size * terms;
    along_x.par_chunks_exact_mut(columns * terms).zip(below.series.par_chunks_exact(row_length)).for_each(
        |(out, row)| {
            for (sum, from) in out.chunks_exact_mut(terms).zip(&taps[0]) {
                for (x, &weight) in (from.first..).zip(&from.weights) {
                    if let Some(i) = line_x.place(x) {
                        add(sum, &row[i * terms..][..terms], weight);
                    }
                }
            }
        },
    );
    let mut series = vec![0f32; columns * rows * terms];
    series.par_chunks_exact_mut(columns * terms).zip(&taps[1]).for_each(|(out, from)| {
        for (y, &weight) in (from.first..).zip(&from.weights) {
            if let Some(i) = line_y.place(y) {
                add(out, &along_x[i * columns * terms..][..columns * terms], weight);
            }
        }
    });
    (grid, series)
}
