//! Heights between the samples of a line: a windowed sinc, and the continuation beyond the ends.

use crate::surface::HeightField;
use crate::surface::tiling::Tiling;
use crate::surface::transpose::transposed;
use std::f64::consts::PI;

/// Zeros of the sinc on each side. With [`BETA`], a sinusoid of four samples a period and more is kept to 1e-4.
const LOBES: f64 = 8.0;
/// Shape of the Kaiser window [Kaiser 1974]: side lobes 80 dB down.
const BETA: f64 = 8.0;

/// Continuation of a line beyond its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EdgeRule {
    /// Periodic: the line again.
    Copies,
    /// Point reflection about the end sample, which continues the slope.
    Turned,
}

impl EdgeRule {
    /// Returns the periodic rule if `tiling` joins along `axis`, otherwise the point reflection.
    pub(super) fn of(tiling: &Tiling, axis: usize) -> Self {
        if tiling.joins(axis) { Self::Copies } else { Self::Turned }
    }

    /// Returns the sample at `index` of the continued `line`.
    fn sample(self, line: &[f64], index: isize) -> f64 {
        let n = line.len() as isize;
        match self {
            Self::Copies => line[index.rem_euclid(n) as usize],
            Self::Turned if n == 1 => line[0],
            Self::Turned => {
                // Point reflections about both ends in turn: the line repeats every 2(n − 1) samples, higher by twice the difference of its
                // ends.
                let (span, last) = (2 * (n - 1), n - 1);
                let (turns, place) = (index.div_euclid(span), index.rem_euclid(span));
                let rise = 2.0 * (line[last as usize] - line[0]) * turns as f64;
                let start = if place <= last {
                    line[place as usize]
                } else {
                    2.0 * line[last as usize] - line[(span - place) as usize]
                };
                start + rise
            }
        }
    }

    /// Returns `line` with `pad` samples more at each end.
    pub(super) fn extended(self, line: &[f64], pad: usize) -> Vec<f64> {
        let pad = pad as isize;
        (-pad..line.len() as isize + pad).map(|i| self.sample(line, i)).collect()
    }
}

/// Weights of the interpolation from one number of samples to another over the same length.
pub(super) struct Resampler {
    /// First padded old sample of each new sample, and the weights from there on.
    taps: Vec<(usize, Vec<f64>)>,
    pad: usize,
}

impl Resampler {
    /// Computes the weights from `old` to `new` samples, at the centres of equal cells of one length. Frequencies that the new samples
    /// cannot hold are left out.
    pub(super) fn new(old: usize, new: usize) -> Self {
        let ratio = old as f64 / new as f64;
        // Fewer samples need a wider sinc: its cut-off frequency is that of the new samples.
        let scale = ratio.max(1.0);
        let reach = LOBES * scale;
        let pad = reach.ceil() as usize + 1;
        let tap = |i: usize| {
            let centre = (i as f64 + 0.5) * ratio - 0.5;
            let from = (centre - reach).ceil();
            let count = ((centre + reach).floor() - from) as usize + 1;
            let mut weights: Vec<f64> =
                (0..count).map(|j| kernel((from + j as f64 - centre) / scale)).collect();
            let total: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|w| *w /= total); // a constant stays as it is
            ((from + pad as f64) as usize, weights)
        };
        Self { taps: (0..new).map(tap).collect(), pad }
    }

    /// Returns the new samples of `line`.
    pub(super) fn apply<'a>(&'a self, line: &[f64], beyond: EdgeRule) -> impl Iterator<Item = f64> + use<'a> {
        let extended = beyond.extended(line, self.pad);
        let sum = move |(first, weights): &(usize, Vec<f64>)| -> f64 {
            weights.iter().zip(&extended[*first..]).map(|(w, h)| w * h).sum()
        };
        self.taps.iter().map(sum)
    }
}

/// Returns sinc(x) under a Kaiser window of [`LOBES`] on each side.
fn kernel(x: f64) -> f64 {
    let inside = 1.0 - (x / LOBES).powi(2);
    if inside < 0.0 {
        return 0.0;
    }
    let sinc = if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    sinc * bessel_i0(BETA * inside.sqrt()) / bessel_i0(BETA)
}

/// Returns the modified Bessel function I₀ by its power series [Abramowitz and Stegun 9.6.12]; here 0 ≤ x ≤ [`BETA`].
fn bessel_i0(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > sum * f64::EPSILON {
        term *= quarter / (k * k);
        sum += term;
        k += 1.0;
    }
    sum
}

/// The cubic B-spline through the samples of a field [Unser 1999, "Splines: a perfect fit for signal and image processing"].
pub(super) struct Spline {
    columns: usize,
    rows: usize,
    coefficients: Vec<f64>,
}

impl Spline {
    /// Computes the coefficients by a recursive filter along each axis.
    pub(super) fn new(field: &HeightField) -> Self {
        use rayon::prelude::*;
        let (columns, rows) = (field.columns(), field.rows());
        let mut heights = field.heights().to_vec();
        heights.par_chunks_mut(columns).for_each(prefilter);
        let mut turned = transposed(columns, &heights);
        turned.par_chunks_mut(rows).for_each(prefilter);
        Self { columns, rows, coefficients: transposed(rows, &turned) }
    }

    /// Returns the height at `column`, `row` between the samples; both within the field.
    pub(super) fn at(&self, column: f64, row: f64) -> f64 {
        let (first_column, across) = cubic_weights(column);
        let (first_row, down) = cubic_weights(row);
        let mut sum = 0.0;
        for (j, wy) in down.iter().enumerate() {
            let r = reflected(first_row + j as isize, self.rows);
            let line = &self.coefficients[r * self.columns..(r + 1) * self.columns];
            let across = across.iter().enumerate();
            sum += wy
                * across
                    .map(|(i, wx)| wx * line[reflected(first_column + i as isize, self.columns)])
                    .sum::<f64>();
        }
        sum
    }
}

/// Returns the first of four samples and their weights.
fn cubic_weights(place: f64) -> (isize, [f64; 4]) {
    let floor = place.floor();
    let t = place - floor;
    let s = 1.0 - t;
    let weights =
        [s * s * s, 4.0 - 6.0 * t * t + 3.0 * t * t * t, 4.0 - 6.0 * s * s + 3.0 * s * s * s, t * t * t];
    (floor as isize - 1, weights.map(|w| w / 6.0))
}

/// Reflects an index into 0 … n − 1 at the end samples; the index is off by a few at most.
fn reflected(index: isize, n: usize) -> usize {
    let last = n as isize - 1;
    if last == 0 {
        return 0;
    }
    let place = index.rem_euclid(2 * last);
    (if place > last { 2 * last - place } else { place }) as usize
}

/// Turns samples into coefficients of the cubic B-spline, the line being reflected at its end samples [Unser 1999, box 2].
fn prefilter(line: &mut [f64]) {
    let n = line.len();
    if n == 1 {
        return; // reflected at its only sample, the spline is constant
    }
    let pole = 3f64.sqrt() - 2.0;
    // |pole|^40 is below rounding.
    const FORGOTTEN: usize = 40;
    let mut sum = 0.0;
    let mut power = 1.0;
    for i in 0..FORGOTTEN {
        sum += power * line[reflected(i as isize, n)];
        power *= pole;
    }
    line[0] = sum;
    for i in 1..n {
        line[i] += pole * line[i - 1];
    }
    line[n - 1] = pole / (pole * pole - 1.0) * (line[n - 1] + pole * line[n - 2]);
    for i in (0..n - 1).rev() {
        line[i] = pole * (line[i + 1] - line[i]);
    }
    line.iter_mut().for_each(|c| *c *= 6.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::tests::field;

    #[test]
    fn beyond_its_ends_a_line_goes_on_in_copies_or_with_its_slope() {
        let line = [0.0, 1.0, 3.0];
        let copies: Vec<f64> = (-3..6).map(|i| EdgeRule::Copies.sample(&line, i)).collect();
        assert_eq!(copies, [0.0, 1.0, 3.0, 0.0, 1.0, 3.0, 0.0, 1.0, 3.0]);
        let turned: Vec<f64> = (-4..9).map(|i| EdgeRule::Turned.sample(&line, i)).collect();
        assert_eq!(turned, [-6.0, -5.0, -3.0, -1.0, 0.0, 1.0, 3.0, 5.0, 6.0, 7.0, 9.0, 11.0, 12.0]);
        assert_eq!(EdgeRule::Turned.sample(&[5.0], -7), 5.0);
    }

    #[test]
    fn the_bessel_function_has_its_tabulated_values() {
        for (x, expected) in [(0.0, 1.0), (1.0, 1.266_065_877_752_008_4), (8.0, 427.564_115_721_804_8)] {
            assert!((bessel_i0(x) / expected - 1.0).abs() < 1e-14, "{x}");
        }
    }

    #[test]
    fn the_spline_goes_through_the_samples_and_follows_a_smooth_surface_between_them() {
        let smooth = |x: f64, y: f64| (3.0 * x).sin() * (2.0 * y).cos() + 0.2 * x;
        let samples = field(40, 50, smooth);
        let spline = Spline::new(&samples);
        for (column, row) in [(0, 0), (39, 49), (7, 31)] {
            assert!((spline.at(column as f64, row as f64) - samples.row(row)[column]).abs() < 1e-13);
        }
        for (column, row) in [(20.5, 25.5), (17.25, 12.9), (12.1, 30.0)] {
            let x = samples.x(0) + column * 0.1;
            let y = samples.y(0) - row * 0.07;
            assert!((spline.at(column, row) - smooth(x, y)).abs() < 3e-5, "{column}, {row}");
        }
    }
}
