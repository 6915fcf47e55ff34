//! Blurred series between the orders: sums of a Gaussian over the few orders, or points of a level, that it reaches.

use super::pyramid::{Downsampling, LevelGrid, Pyramid, PyramidLevel};
use super::series::OrderSeries;
use glam::DVec2;
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::PI;

/// Reads the series of orders under Gaussians of any width.
pub struct OrderReader<'a> {
    /// Series of the orders.
    pub series: &'a OrderSeries,
    pyramid: Pyramid,
    /// Registers of this machine.
    arch: Arch,
}

impl<'a> OrderReader<'a> {
    /// Computes the levels of `series`.
    pub fn new(series: &'a OrderSeries) -> Self {
        Self { series, pyramid: Pyramid::new(series, Downsampling::FAST), arch: Arch::new() }
    }

    /// Writes Σ_m |c_m|²/z² γ̂(f − m/T) \[µm⁴/rad²\] as a Chebyshev series into `out`, `[point][term]`, for every frequency f of `square`. γ̂ is
    /// the blur of the orders, widened by `variance` \[µm⁻²\]. Frequencies that the samples of the surface do not hold are 0.
    pub fn read(&self, square: &Square, variance: f64, scratch: &mut ReadScratch, out: &mut [f32]) {
        let (level, left) = self.level(variance);
        let ReadScratch { taps, row, runs } = scratch;
        for (axis, taps) in taps.iter_mut().enumerate() {
            self.find_taps(square, &level.grid, axis, left[axis], taps);
        }
        if taps.iter().any(AxisTaps::is_dark) {
            out.fill(0.0);
            return;
        }
        find_runs(&level, &taps[0], runs);
        let (begin, end) = taps[0].range();
        row.resize((end - begin) as usize * level.terms + MOST_LANES, 0.0);
        self.arch.dispatch(Gather { level: &level, taps, runs, row, out });
    }

    /// Returns the coarsest level that a blur widened by `variance` \[µm⁻²\] can be read from, and the variance that is left \[orders²\].
    fn level(&self, variance: f64) -> (PyramidLevel<'_>, [f64; 2]) {
        let OrderSeries { blur, grid, .. } = self.series;
        let asked = [0, 1].map(|axis| (blur.variance[axis] + variance) * grid.patch[axis].powi(2));
        let left = |number: usize| {
            let level = self.pyramid.grid(number);
            let of_axis = |axis| level.left(axis, asked[axis], self.pyramid.downsampling.blur);
            Some([of_axis(0)?, of_axis(1)?])
        };
        let coarsest = (1..self.pyramid.count()).rev().find_map(|number| Some((number, left(number)?)));
        let (number, left) = coarsest.unwrap_or((0, asked));
        (self.pyramid.level(number, self.series), left)
    }

    /// Finds the points along `axis` that a Gaussian of variance `left` \[orders²\] reaches from each place of `square`.
    fn find_taps(&self, square: &Square, level: &LevelGrid, axis: usize, left: f64, taps: &mut AxisTaps) {
        let (patch, step) = (self.series.grid.patch[axis], level.step[axis]);
        let deviation = left.sqrt() / step;
        let reach = self.pyramid.downsampling.reach * deviation;
        // Density over frequencies times the distance of points.
        let peak = patch / ((2.0 * PI).sqrt() * deviation);
        taps.count = (2.0 * reach).floor() as usize + 1;
        taps.first.clear();
        taps.weights.clear();
        for i in 0..square.side {
            let f = square.first[axis] + square.step * i as f64;
            let place = f * patch / step;
            let first = (place - reach).ceil();
            let is_held = f.abs() <= self.series.band[axis];
            taps.first.push(first as i64);
            for k in 0..taps.count {
                let away = (first + k as f64 - place) / deviation;
                let is_near = is_held && away.abs() <= self.pyramid.downsampling.reach;
                taps.weights.push(if is_near { (peak * (-0.5 * away * away).exp()) as f32 } else { 0.0 });
            }
        }
    }
}

/// Numbers of the widest vector register.
const MOST_LANES: usize = 16;

/// Working arrays of [`OrderReader::read`].
#[derive(Default)]
pub struct ReadScratch {
    /// Points along x and y.
    taps: [AxisTaps; 2],
    /// Columns that any place of a square reads.
    runs: Vec<Run>,
    /// Sums along y of the columns that any point of a square reads, `[column][term]`, and [`MOST_LANES`] more.
    row: Vec<f32>,
}

/// Points that each place of a square reads along an axis.
#[derive(Default)]
struct AxisTaps {
    /// Points of a place.
    count: usize,
    /// Number of each place's first point.
    first: Vec<i64>,
    /// `[place][point]`.
    weights: Vec<f32>,
}

impl AxisTaps {
    /// Returns the number of the first point and the weights of place `i`.
    #[inline(always)]
    fn of(&self, i: usize) -> (i64, &[f32]) {
        (self.first[i], &self.weights[i * self.count..(i + 1) * self.count])
    }

    /// Returns true if no place reads anything.
    fn is_dark(&self) -> bool {
        self.weights.iter().all(|weight| *weight == 0.0)
    }

    /// Returns the numbers of the first point and of the one behind the last of all places.
    fn range(&self) -> (i64, i64) {
        let last = self.first.last().copied().unwrap_or_default();
        (self.first.first().copied().unwrap_or_default(), last + self.count as i64)
    }
}

/// Columns that stand side by side in memory.
struct Run {
    /// First column within the range that a square reads.
    at: usize,
    /// First column of the level.
    from: usize,
    /// Number of columns.
    count: usize,
}

/// Finds the columns of `level` that `along_x` reads; there are gaps beyond the ends.
fn find_runs(level: &PyramidLevel<'_>, along_x: &AxisTaps, runs: &mut Vec<Run>) {
    let (begin, end) = along_x.range();
    runs.clear();
    for (at, number) in (begin..end).enumerate() {
        let Some(from) = level.grid.lines[0].place(number) else { continue };
        match runs.last_mut() {
            Some(run) if run.at + run.count == at && run.from + run.count == from => run.count += 1,
            _ => runs.push(Run { at, from, count: 1 }),
        }
    }
}

/// Sums the taps along y and then along x.
struct Gather<'a> {
    level: &'a PyramidLevel<'a>,
    taps: &'a [AxisTaps; 2],
    runs: &'a [Run],
    row: &'a mut [f32],
    out: &'a mut [f32],
}

impl WithSimd for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { level, taps: [along_x, along_y], runs, row, out } = self;
        let (terms, columns) = (level.terms, level.grid.lines[0].size);
        let begin = along_x.range().0;
        for (j, out) in out.chunks_exact_mut(along_x.first.len() * terms).enumerate() {
            let (first, weights) = along_y.of(j);
            row.fill(0.0);
            for (number, &weight) in (first..).zip(weights) {
                if weight == 0.0 {
                    continue;
                }
                let Some(y) = level.grid.lines[1].place(number) else { continue };
                for run in runs {
                    let from = &level.series[(y * columns + run.from) * terms..][..run.count * terms];
                    add_scaled(simd, &mut row[run.at * terms..][..run.count * terms], from, weight);
                }
            }
            for (i, out) in out.chunks_exact_mut(terms).enumerate() {
                let (first, weights) = along_x.of(i);
                let read = &row[(first - begin) as usize * terms..];
                for (register, out) in out.chunks_mut(S::F32_LANES).enumerate() {
                    let mut sum = simd.splat_f32s(0.0);
                    // The last register of a series reaches into the next one, and its end is not stored.
                    let mut at = register * S::F32_LANES;
                    for &weight in weights {
                        let (values, _) = S::as_simd_f32s(&read[at..at + S::F32_LANES]);
                        sum = simd.mul_add_e_f32s(values[0], simd.splat_f32s(weight), sum);
                        at += terms;
                    }
                    simd.partial_store_f32s(out, sum);
                }
            }
        }
    }
}

/// Adds `weight` times `values` to `sums`.
#[inline(always)]
fn add_scaled<S: Simd>(simd: S, sums: &mut [f32], values: &[f32], weight: f32) {
    let (sums, rest) = S::as_mut_simd_f32s(sums);
    let (values, left) = S::as_simd_f32s(values);
    let factor = simd.splat_f32s(weight);
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum = simd.mul_add_e_f32s(*value, factor, *sum);
    }
    for (sum, value) in rest.iter_mut().zip(left) {
        *sum += weight * value;
    }
}

/// Square of frequencies, or of places −(u, v).
#[derive(Clone, Copy, Debug)]
pub struct Square {
    /// Point of least x and y.
    pub first: DVec2,
    /// Distance of neighbours along either axis.
    pub step: f64,
    /// Points along a side.
    pub side: usize,
}

impl Square {
    /// Returns one point alone.
    pub fn point(at: DVec2) -> Self {
        Self { first: at, step: 0.0, side: 1 }
    }

    /// Returns the square with every point `factor` times as far from the origin.
    pub fn scaled(self, factor: f64) -> Self {
        Self { first: self.first * factor, step: self.step * factor, ..self }
    }

    /// Returns the largest distance of a point from the origin.
    pub fn farthest(&self) -> f64 {
        self.first.abs().max(self.last().abs()).length()
    }

    /// Returns the smallest distance from the origin of anything between the points.
    pub fn nearest(&self) -> f64 {
        DVec2::ZERO.clamp(self.first, self.last()).length()
    }

    /// Returns point number `i`, row by row.
    pub fn place(&self, i: usize) -> DVec2 {
        self.first + self.step * DVec2::new((i % self.side) as f64, (i / self.side) as f64)
    }

    fn last(&self) -> DVec2 {
        self.first + self.step * (self.side - 1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectra::power::{Beyond, Blur, OrderGrid, PowerSettings, Transform};
    use crate::surface::HeightField;
    use crate::task::Task;
    use pulp::Scalar;

    fn rough(pixel: [f64; 2]) -> HeightField {
        let wave = |x: f64, y: f64| {
            (6.3 * x).sin() + 0.6 * (5.1 * x + 7.7 * y).cos() + 0.4 * (11.0 * y - 3.0 * x).sin()
        };
        let n = 60;
        let at = |i: usize| 0.3 * wave(0.1 * (i % n) as f64, 0.1 * (i / n) as f64) / 4.0;
        HeightField::new(n, n, pixel, (0..n * n).map(at).collect()).unwrap()
    }

    #[test]
    fn a_read_is_the_blurred_sum_over_the_orders() {
        // Error of the audited series and of the cut-off of the Gaussian.
        const ALLOWED: f64 = 2e-3;
        // With the lag window, whose blur follows the sides of the patch, and with pixels that are not square, the axes differ.
        for (pixel, beyond) in
            [([0.1, 0.1], Beyond::Copies), ([0.1, 0.05], Beyond::Alike), ([0.2, 0.03], Beyond::Copies)]
        {
            let field = rough(pixel);
            let settings = PowerSettings::new(2.0, beyond, 2e-3);
            let series = OrderSeries::new(&field, &settings, &Task::silent()).unwrap();
            let reader = OrderReader::new(&series);
            let blur =
                DVec2::from_array(Blur::of_orders(settings.sigma, field.patch_size(), beyond).variance);
            // Every order's power by its transform, without the specular order, and its copies beyond the band.
            let orders = OrderGrid::new(&field, 100.0, 0.0);
            let transform = Transform::new(&field, orders, beyond);
            let band = DVec2::from_array([0, 1].map(|k| orders.size[k] as f64 / orders.patch[k]));
            let place = |i: usize| {
                let at = [i % orders.size[0], i / orders.size[0]];
                DVec2::from_array([0, 1].map(|k| (at[k] as f64 - orders.origin[k] as f64) / orders.patch[k]))
            };
            let copies: Vec<DVec2> =
                (0..9).map(|i| band * DVec2::new((i % 3) as f64 - 1.0, (i / 3) as f64 - 1.0)).collect();
            // Nothing else, a little, about as much as the coherence, and several levels.
            let spreads = [0.0, 0.05, 0.6, 1.7, 3.9, 9.0, 40.0];
            let mut sums = [[0.0; 2]; 7];
            for i in 0..60 {
                let f = DVec2::from_angle(2.4 * f64::from(i)) * (0.2 + 0.06 * f64::from(i));
                if f.x.abs() > 0.5 * band.x || f.y.abs() > 0.5 * band.y {
                    continue;
                }
                let z = 4.0 + 0.3 * f64::from(i);
                let powers = transform.at(z).powers;
                let mut t = vec![0.0; series.terms];
                series.polynomials_at(z, &mut t);
                for ([error, energy], spread) in sums.iter_mut().zip(spreads) {
                    let spread = spread * blur.min_element();
                    let variance = blur + spread;
                    let peak = 1.0 / (2.0 * PI * (variance.x * variance.y).sqrt());
                    let lobe = |d: DVec2| peak * (-0.5 * (d * d / variance).element_sum()).exp();
                    let of_order = |(i, power): (usize, &f64)| {
                        power * copies.iter().map(|copy| lobe(f - place(i) - *copy)).sum::<f64>()
                    };
                    let exact: f64 = powers.iter().enumerate().map(of_order).sum();
                    let mut terms = vec![0f32; series.terms];
                    reader.read(&Square::point(f), spread, &mut ReadScratch::default(), &mut terms);
                    let value: f64 = terms.iter().zip(&t).map(|(a, t)| f64::from(*a) * t).sum();
                    *error += (value * z * z - exact).powi(2);
                    *energy += exact * exact;
                }
            }
            for ([error, energy], spread) in sums.into_iter().zip(spreads) {
                let error = f64::sqrt(error / energy);
                eprintln!("{beyond:?}, {pixel:?}, widened by {spread} of the blur's variance: {error:.1e}");
                assert!(error <= ALLOWED, "{beyond:?}, {spread}: {error}");
            }
        }
    }

    #[test]
    fn a_square_is_read_as_each_of_its_points_and_registers_give_the_plain_sums() {
        let field = rough([0.1; 2]);
        let series =
            OrderSeries::new(&field, &PowerSettings::new(2.0, Beyond::Copies, 1e-2), &Task::silent())
                .unwrap();
        let reader = OrderReader::new(&series);
        // The square reaches beyond the band.
        for (first, variance) in [(DVec2::new(-0.3, 0.2), 0.0), (DVec2::new(4.6, -5.3), 0.02)] {
            let square = Square { first, step: 0.06, side: 8 };
            let mut all = vec![0f32; 64 * series.terms];
            let mut scratch = ReadScratch::default();
            reader.read(&square, variance, &mut scratch, &mut all);
            let largest = all.iter().fold(0f32, |most, a| most.max(a.abs()));
            assert!(largest > 0.0);
            let mut one = vec![0f32; series.terms];
            for (i, found) in all.chunks_exact(series.terms).enumerate() {
                reader.read(&Square::point(square.place(i)), variance, &mut ReadScratch::default(), &mut one);
                let apart = found.iter().zip(&one).map(|(a, b)| (a - b).abs()).fold(0f32, f32::max);
                assert!(apart < 1e-5 * largest, "{i}: {apart} of {largest}");
            }
            let (level, _) = reader.level(variance);
            let mut plain = vec![0f32; all.len()];
            let ReadScratch { taps, runs, row } = &mut scratch;
            Gather { level: &level, taps, runs, row, out: &mut plain }.with_simd(Scalar);
            let apart = all.iter().zip(&plain).map(|(a, b)| (a - b).abs()).fold(0f32, f32::max);
            assert!(apart < 1e-5 * largest, "{apart} of {largest}");
        }
    }
}
