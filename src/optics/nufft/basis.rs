//! A low-rank expansion of e^{izh} with nine digits: its singular functions over the heights and the range of z, as Chebyshev
//! series valid for every height in range.

use crate::optics::svd::Svd;
use crate::surface::HeightField;
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;

/// Truncation error, relative to the scattered amplitude at the same z.
const ACCURACY: f64 = 2e-10;
/// Fewest bins of the histogram of heights over the range; two for each radian of phase are added.
const BINS: usize = 256;
/// Part of the weight that every height gets, whether it occurs or not.
const UNSEEN: f64 = 1e-3;
/// Points of the interpolation of c_n(z).
const STENCIL: usize = 8;
/// Step of the table of c_n(z), as a phase z·a \[rad\]: eight points a step apart interpolate to 1e-12.
const PHASE_STEP: f64 = 0.08;

/// b_n(h) and c_n(z) with e^{iz(h − middle)} ≈ Σ c_n(z) b_n(h).
#[derive(Debug)]
pub struct HeightBasis {
    middle: f64,
    half_range: f64,
    /// `[term][degree]`: the series of b_n in Chebyshev polynomials.
    series: Vec<Vec<f64>>,
    /// Distance of the columns of `table` \[rad/µm\]; column `STENCIL`/2 − 1 stands at 0.
    column_step: f64,
    /// `[column][term]`: c_n.
    table: Vec<Complex64>,
}

impl HeightBasis {
    /// Computes the functions for the heights of `field` and |z| up to `z_max` \[rad/µm\].
    pub fn new(field: &HeightField, z_max: f64) -> Self {
        let (low, high) = field.range();
        let (middle, half_range) = ((low + high) / 2.0, (high - low) / 2.0);
        let largest_phase = z_max * half_range;
        // The Bessel functions of the series fall faster than exponentially beyond their argument.
        let degrees = (largest_phase + 12.0 * (largest_phase + 1.0).cbrt()) as usize + 10;
        let bins = histogram(field, middle, half_range, BINS + (2.0 * largest_phase) as usize);
        let points = 24 + (3.0 * largest_phase) as usize;
        let phases: Vec<f64> =
            (0..points).map(|q| (q as f64 + 0.5) / points as f64 * largest_phase).collect();
        // In polynomials that are orthonormal under the weights of the heights, the singular vectors are the best functions.
        let Some(lower) = cholesky(gram(&bins, degrees)) else {
            return Self { middle, half_range, series: Vec::new(), column_step: 1.0, table: Vec::new() };
        };
        let rows: Vec<Vec<Complex64>> = phases
            .iter()
            .map(|&phase| {
                // Errors are relative to the scattered light.
                let mean: Complex64 = bins.iter().map(|&(t, w)| Complex64::cis(phase * t) * w).sum();
                let weight = (1.0 - mean.norm_sqr()).max(1e-12).sqrt().recip();
                jacobi_anger(phase, degrees).into_iter().map(|c| c * weight).collect()
            })
            .collect();
        let part = |row: usize, n: usize| {
            if row.is_multiple_of(2) { rows[row / 2][n].re } else { rows[row / 2][n].im }
        };
        let column = |n: usize| -> Vec<Complex64> {
            let entry = |row: usize| (n..degrees).map(|k| part(row, k) * lower[k][n]).sum::<f64>();
            (0..2 * points).map(|row| entry(row).into()).collect()
        };
        let decomposed = Svd::of((0..degrees).map(column).collect());
        let terms = terms_needed(&decomposed, points);
        // b_n = v_n·L⁻¹·T and c_n = c·L·v_n: the product over all n is c·T again. Of a real matrix the vectors are real.
        let kept: Vec<Vec<f64>> =
            decomposed.v.iter().take(terms).map(|v| v.iter().map(|x| x.re).collect()).collect();
        let from_series: Vec<Vec<f64>> = kept.iter().map(|v| product(&lower, v)).collect();
        let series = kept.iter().map(|v| solve_transposed(&lower, v)).collect();
        let mut basis = Self { middle, half_range, series, column_step: 1.0, table: Vec::new() };
        basis.tabulate(&from_series, z_max);
        basis
    }

    /// Returns the number of terms.
    pub fn terms(&self) -> usize {
        self.series.len()
    }

    /// Writes b_n at `height` \[µm\] into `out`, which has room for all.
    pub fn values(&self, height: f64, out: &mut [f64]) {
        let t = if self.half_range > 0.0 { (height - self.middle) / self.half_range } else { 0.0 };
        let polynomials = chebyshev(t, self.series.first().map_or(0, Vec::len));
        for (slot, series) in out.iter_mut().zip(&self.series) {
            *slot = series.iter().zip(&polynomials).map(|(s, p)| s * p).sum();
        }
    }

    /// Tabulates c_n(z) from the coefficients of the Chebyshev series, which `from_series` maps to those of the functions.
    fn tabulate(&mut self, from_series: &[Vec<f64>], z_max: f64) {
        let largest_phase = z_max * self.half_range;
        let columns = (largest_phase / PHASE_STEP).ceil().max(8.0) as usize;
        self.column_step = z_max / columns as f64;
        for column in 0..columns + STENCIL {
            let z = (column as f64 - (STENCIL as f64 / 2.0 - 1.0)) * self.column_step;
            let series = jacobi_anger(z * self.half_range, from_series.first().map_or(1, Vec::len));
            let term = |weights: &Vec<f64>| series.iter().zip(weights).map(|(c, w)| c * w).sum::<Complex64>();
            self.table.extend(from_series.iter().map(term));
        }
    }

    /// Writes c_n at 0 ≤ `z` ≤ z_max into `out`.
    pub fn coefficients(&self, z: f64, out: &mut [Complex64]) {
        let terms = self.terms();
        let place = z / self.column_step;
        let left = (place as usize).min((self.table.len() / terms).saturating_sub(STENCIL));
        out.fill(Complex64::ZERO);
        let weights = lagrange(place - left as f64);
        for (column, weight) in self.table[left * terms..].chunks(terms).zip(weights) {
            out.iter_mut().zip(column).for_each(|(o, c)| *o += c * weight);
        }
    }
}

/// Returns T_0 … T_{count−1} at `t`.
fn chebyshev(t: f64, count: usize) -> Vec<f64> {
    let (mut now, mut next) = (1.0, t);
    (0..count)
        .map(|_| {
            let value = now;
            (now, next) = (next, 2.0 * t * next - now);
            value
        })
        .collect()
}

/// Returns the first `count` coefficients of the Chebyshev series of e^{i·phase·t}, by a cosine transform of its values: exact to rounding,
/// because the series ends long before the points do.
fn jacobi_anger(phase: f64, count: usize) -> Vec<Complex64> {
    let points = 2 * count;
    let angle = |j: usize| PI * (j as f64 + 0.5) / points as f64;
    let values: Vec<Complex64> = (0..points).map(|j| Complex64::cis(phase * angle(j).cos())).collect();
    let mut series = vec![Complex64::ZERO; count];
    for (j, value) in values.iter().enumerate() {
        for (slot, polynomial) in series.iter_mut().zip(chebyshev(angle(j).cos(), count)) {
            *slot += value * (polynomial * 2.0 / points as f64);
        }
    }
    series[0] *= 0.5;
    series
}

/// Returns ⟨T_n T_m⟩ under the weights of the heights, for m ≤ n.
fn gram(bins: &[(f64, f64)], degrees: usize) -> Vec<Vec<f64>> {
    let mut gram: Vec<Vec<f64>> = (0..degrees).map(|n| vec![0.0; n + 1]).collect();
    for &(t, weight) in bins {
        let polynomials = chebyshev(t, degrees);
        for (row, factor) in gram.iter_mut().zip(&polynomials) {
            row.iter_mut().zip(&polynomials).for_each(|(sum, other)| *sum += weight * factor * other);
        }
    }
    gram
}

/// Returns L of a symmetric `matrix` = L Lᵀ, both lower triangles by rows; `None` if it is not positive definite.
fn cholesky(mut matrix: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    for row in 0..matrix.len() {
        for column in 0..=row {
            let done: f64 = (0..column).map(|k| matrix[row][k] * matrix[column][k]).sum();
            let left = matrix[row][column] - done;
            matrix[row][column] = if column < row { left / matrix[column][column] } else { left.sqrt() };
        }
        let positive = matrix[row][row] > 0.0;
        if !positive {
            return None;
        }
    }
    Some(matrix)
}

/// Returns L·`v`.
fn product(lower: &[Vec<f64>], v: &[f64]) -> Vec<f64> {
    lower.iter().map(|row| row.iter().zip(v).map(|(l, v)| l * v).sum()).collect()
}

/// Returns the solution of Lᵀ·x = `v`.
fn solve_transposed(lower: &[Vec<f64>], v: &[f64]) -> Vec<f64> {
    let mut x = v.to_vec();
    for row in (0..x.len()).rev() {
        x[row] /= lower[row][row];
        for column in 0..row {
            x[column] -= lower[row][column] * x[row];
        }
    }
    x
}

/// Returns the weights of the points −3 … 4 of a polynomial through them, at `x` ∈ \[0, 1\].
fn lagrange(x: f64) -> [f64; STENCIL] {
    let place = |i: usize| i as f64 - (STENCIL as f64 / 2.0 - 1.0);
    std::array::from_fn(|i| {
        let others = (0..STENCIL).filter(|&j| j != i);
        others.map(|j| (x - place(j)) / (place(i) - place(j))).product()
    })
}

/// Returns the fewest terms whose error is at most [`ACCURACY`] at every point of z.
fn terms_needed(Svd { u, s, .. }: &Svd, points: usize) -> usize {
    let mut left = vec![0.0; points];
    for n in (0..s.len()).rev() {
        for (q, left) in left.iter_mut().enumerate() {
            *left += (s[n] * u[n][2 * q].re).powi(2) + (s[n] * u[n][2 * q + 1].re).powi(2);
        }
        if left.iter().any(|&l| l > ACCURACY * ACCURACY) {
            return n + 1;
        }
    }
    1
}

/// Returns the centres in t and the weights, which add up to 1, of `count` bins of the heights.
fn histogram(field: &HeightField, middle: f64, half_range: f64, count: usize) -> Vec<(f64, f64)> {
    let mut counts = vec![0.0f64; count];
    for &h in field.heights() {
        let t = if half_range > 0.0 { (h - middle) / half_range } else { 0.0 };
        counts[(((t + 1.0) / 2.0 * count as f64) as usize).min(count - 1)] += 1.0;
    }
    let samples = field.heights().len() as f64;
    let weight = |n: f64| (1.0 - UNSEEN) * n / samples + UNSEEN / count as f64;
    let centre = |i: usize| 2.0 * (i as f64 + 0.5) / count as f64 - 1.0;
    counts.iter().enumerate().map(|(i, &n)| (centre(i), weight(n))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the largest error over heights in range and 0 ≤ z ≤ z_max.
    fn sup_error(range: f64, z_max: f64) -> (usize, f64) {
        let heights = (0..4096).map(|i| range * f64::from(i) / 4095.0).collect();
        let field = HeightField::new(64, 64, [0.1, 0.1], heights).unwrap();
        let basis = HeightBasis::new(&field, z_max);
        let terms = basis.terms();
        let (mut b, mut c) = (vec![0.0; terms], vec![Complex64::ZERO; terms]);
        let mut worst = 0.0f64;
        for i in 0..600 {
            let z = z_max * (f64::from(i) * 0.618_034).fract();
            let h = range * (f64::from(i) * 0.754_878).fract();
            basis.values(h, &mut b);
            basis.coefficients(z, &mut c);
            let sum: Complex64 = c.iter().zip(&b).map(|(c, b)| c * b).sum();
            worst = worst.max((sum - Complex64::cis(z * (h - range / 2.0))).norm());
        }
        (terms, worst)
    }

    #[test]
    fn the_functions_carry_the_phase_of_every_height_and_every_angle() {
        let z_max = 4.0 * PI / 0.38;
        for range in [0.01, 0.15, 0.43, 1.0, 3.0] {
            let (terms, worst) = sup_error(range, z_max);
            eprintln!("H = {range}: {terms} terms, {worst:.1e}");
            assert!(worst < 3e-8, "H = {range}: {worst:e}");
        }
    }

    #[test]
    fn a_flat_surface_needs_next_to_nothing() {
        let flat = HeightField::new(4, 4, [0.1, 0.1], vec![2.0; 16]).unwrap();
        let basis = HeightBasis::new(&flat, 33.0);
        let (mut b, mut c) = (vec![0.0; basis.terms()], vec![Complex64::ZERO; basis.terms()]);
        basis.values(2.0, &mut b);
        basis.coefficients(20.0, &mut c);
        let sum: Complex64 = c.iter().zip(&b).map(|(c, b)| c * b).sum();
        assert!((sum.norm() - 1.0).abs() < 1e-9 && basis.terms() < 3, "{} terms, {sum}", basis.terms());
    }
}
