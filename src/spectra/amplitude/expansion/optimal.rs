//! The optimal expansion: singular functions of e^{izh} on the range of z of a scene and the heights that occur in the surface, with the
//! fewest possible terms.
//!
//! The kernel is sampled at quadrature points of z and bins of the heights' histogram, and decomposed. Rows are weighted by 1/√(1 −
//! |⟨e^{izh}⟩|²), where 1 − |⟨e^{izh}⟩|² is the part of the light that is scattered at z: errors are relative to the light beside the
//! specular peak. A right singular vector continues to every height by the left one (Nyström): b_n(t) = Σ_q u*_qn r_q e^{i z_q a t}/s_n.
//! The functions are complex: a range of z on one side of 0 has half the width of the ±z that real functions serve, and needs
//! correspondingly fewer terms.
//!
//! Toward z = 0 less and less light is scattered, and the BRDF divides by w²: any error there would be amplified without limit. If the
//! range begins at 0, the first function is therefore the constant, its coefficient the mean m(z) = ⟨e^{izh}⟩, and the decomposition is of
//! the remainder (e^{izh} − m)/√(1 − |m|²), which has a limit, (h − ⟨h⟩)/√⟨(h − ⟨h⟩)²⟩. All other coefficients are 0 at z = 0, and errors
//! stay proportional to the scattered light down to there. This takes no additional term, because with the weights above the constant would
//! come first by itself.

use super::Expansion;
use super::heights::HeightHistogram;
use crate::optics::svd::Svd;
use crate::surface::HeightField;
use rustfft::num_complex::Complex64;

/// Entries of the tables of b_n, linear between them: an error of (2/16384)²/8 · X² of the function.
const TABLE: usize = 16_384;
/// Largest number of terms; singular values beyond are below rounding for any surface that fits the z range.
const MAX_TERMS: usize = 96;
/// Singular values relative to the largest possible one below which they are noise of the decomposition.
const NOISE: f64 = 1e-11;

/// Optimal expansion of one surface over a range of z.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimal {
    z_range: [f64; 2],
    heights: HeightHistogram,
    /// `[n][entry]`: b_n over t.
    tables: Vec<Vec<Complex64>>,
    /// b_n at each bin's centre.
    at_bins: Vec<Vec<Complex64>>,
}

impl Optimal {
    /// Decomposes e^{izh} over the heights of `field` and z from `z_range[0]` to `z_range[1]` \[rad/µm\].
    pub fn new(field: &HeightField, z_range: [f64; 2]) -> Self {
        Self::over(&HeightHistogram::of(field), z_range)
    }

    /// Decomposes e^{izh} over heights that are counted already.
    pub fn over(heights: &HeightHistogram, z_range: [f64; 2]) -> Self {
        let bins = &heights.bins;
        let rows: Vec<PhaseRow> =
            heights.points(z_range).iter().map(|&z| PhaseRow::new(heights, z_range, z)).collect();
        let column =
            |&(t, weight): &(f64, f64)| rows.iter().map(|row| row.value(t) * weight.sqrt()).collect();
        let decomposed = Svd::of(bins.iter().map(column).collect());
        // Without the mean, rows of a nearly flat surface are 0 or noise. Each row has a length of at most 1.
        let largest = decomposed.s.first().copied().unwrap_or(0.0);
        let noise = NOISE * largest.max((rows.len() as f64).sqrt());
        let kept = decomposed.s.iter().take_while(|s| **s > noise).count().min(MAX_TERMS);
        let mut tables = vec![vec![Complex64::ZERO; TABLE + 1]; kept];
        for entry in 0..=TABLE {
            let t = 2.0 * entry as f64 / TABLE as f64 - 1.0;
            let column: Vec<Complex64> = rows.iter().map(|row| row.value(t)).collect();
            for (n, table) in tables.iter_mut().enumerate() {
                let sum: Complex64 = column.iter().zip(&decomposed.u[n]).map(|(k, u)| u.conj() * k).sum();
                table[entry] = sum / decomposed.s[n];
            }
        }
        if begins_at_zero(z_range) {
            tables.insert(0, vec![Complex64::ONE; TABLE + 1]);
            tables.truncate(MAX_TERMS);
        }
        let at_bins =
            tables.iter().map(|table| bins.iter().map(|&(t, _)| look_up(table, t)).collect()).collect();
        Self { z_range, heights: heights.clone(), tables, at_bins }
    }
}

/// Returns true if the constant is a separate function.
fn begins_at_zero(z_range: [f64; 2]) -> bool {
    z_range[0] == 0.0
}

/// Row e^{izh} at one z over the heights, less its mean if the range of z begins at 0, relative to the scattered light.
struct PhaseRow {
    x: f64,
    less: Complex64,
    weight: f64,
}

impl PhaseRow {
    fn new(heights: &HeightHistogram, z_range: [f64; 2], z: f64) -> Self {
        let x = z * heights.half_range;
        if !begins_at_zero(z_range) {
            return Self { x, less: -Complex64::ONE, weight: heights.scattered(z).sqrt().recip() };
        }
        let less = mean_beyond_one(heights, x);
        let square: f64 = heights.bins.iter().map(|&(t, w)| (beyond_one(x * t) - less).norm_sqr() * w).sum();
        // A flat surface scatters nothing.
        Self { x, less, weight: if square > 0.0 { square.sqrt().recip() } else { 0.0 } }
    }

    fn value(&self, t: f64) -> Complex64 {
        (beyond_one(self.x * t) - self.less) * self.weight
    }
}

/// Returns e^{ix} − 1 with full precision for small x.
fn beyond_one(x: f64) -> Complex64 {
    let (sin, cos) = (x / 2.0).sin_cos();
    Complex64::new(-2.0 * sin * sin, 2.0 * sin * cos)
}

/// Returns ⟨e^{ixt}⟩ − 1 over the heights.
fn mean_beyond_one(heights: &HeightHistogram, x: f64) -> Complex64 {
    heights.bins.iter().map(|&(t, w)| beyond_one(x * t) * w).sum()
}

/// Interpolates linearly between the entries of a table over t ∈ \[−1, 1\].
fn look_up(table: &[Complex64], t: f64) -> Complex64 {
    let place = (t + 1.0) / 2.0 * TABLE as f64;
    let left = (place as usize).min(TABLE - 1);
    let share = place - left as f64;
    table[left] * (1.0 - share) + table[left + 1] * share
}

impl Expansion for Optimal {
    fn basis(&self, n: usize, t: f64) -> Complex64 {
        self.tables.get(n).map_or(Complex64::ZERO, |table| look_up(table, t))
    }

    /// Projects e^{izh} on b_n under the heights' weights.
    fn coefficients(&self, z: f64, out: &mut [Complex64]) {
        out.fill(Complex64::ZERO);
        let x = z * self.heights.half_range;
        let first = usize::from(begins_at_zero(self.z_range)).min(out.len());
        // The other functions are orthogonal to the constant; without it their coefficients are 0 at z = 0, rounding included.
        let mean = mean_beyond_one(&self.heights, x);
        let less = if first == 1 { mean } else { -Complex64::ONE };
        for (bin, &(t, weight)) in self.heights.bins.iter().enumerate() {
            let value = (beyond_one(x * t) - less) * weight;
            for (c, b) in out.iter_mut().zip(&self.at_bins).skip(first) {
                *c += value * b[bin].conj();
            }
        }
        if first == 1 {
            out[0] = Complex64::ONE + mean;
        }
    }

    fn most_terms(&self) -> usize {
        self.tables.len()
    }

    /// Measures the sup error on a grid of heights and of z: not a proven bound.
    fn truncation_bound(&self, z: f64, terms: usize) -> f64 {
        /// Samples a radian of the phase zh: the error between them is larger by half a per cent at most.
        const A_RADIAN: f64 = 5.0;
        /// Fewest samples of z and of the heights: flat surfaces have hardly any phase.
        const FEWEST: [usize; 2] = [32, 256];
        let [from, to] = self.z_range;
        let to = z.clamp(from, to);
        let zs = FEWEST[0].max((A_RADIAN * (to - from) * self.heights.half_range) as usize);
        let heights = FEWEST[1].max((A_RADIAN * 2.0 * to * self.heights.half_range) as usize);
        let mut c = vec![Complex64::ZERO; terms];
        (0..=zs).fold(0.0, |worst, q| {
            let z = from + (to - from) * q as f64 / zs as f64;
            self.coefficients(z, &mut c);
            (0..=heights).fold(worst, |worst, i| {
                let t = 2.0 * i as f64 / heights as f64 - 1.0;
                let sum: Complex64 = c.iter().enumerate().map(|(n, c)| c * self.basis(n, t)).sum();
                worst.max((sum - Complex64::cis(z * self.heights.half_range * t)).norm())
            })
        })
    }

    fn rounding_bound(&self, _z: f64, roundoff: f64) -> f64 {
        // The functions are orthonormal under the weights and Σ|c_n|² ≤ 1: as for Chebyshev.
        4.0 * roundoff
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns heights spread evenly over `range` \[µm\].
    fn even(range: f64) -> HeightField {
        let heights = (0..4096).map(|i| range * f64::from(i) / 4095.0).collect();
        HeightField::new(64, 64, [0.1, 0.1], heights).unwrap()
    }

    #[test]
    fn far_fewer_terms_than_the_polynomials_need_reach_the_same_error() {
        let z_max = 4.0 * std::f64::consts::PI / 0.38;
        // Height range, sup error, and the terms that a low-rank factorisation takes for it.
        for (range, tolerance, rank) in
            [(0.15, 1e-4, 6), (0.30, 1e-3, 7), (0.50, 1e-3, 8), (1.0, 1e-3, 12), (2.0, 1e-3, 18)]
        {
            let optimal = Optimal::new(&even(range), [0.0, z_max]);
            let terms =
                (1..optimal.most_terms()).find(|&n| optimal.truncation_bound(z_max, n) <= tolerance).unwrap();
            eprintln!("H = {range}: {terms} terms");
            assert!(terms <= rank, "H = {range}: {terms} terms");
        }
    }

    #[test]
    fn the_measured_bound_holds_between_its_grid_points() {
        let z_max = 4.0 * std::f64::consts::PI / 0.38;
        let optimal = Optimal::new(&even(0.43), [0.0, z_max]);
        for terms in [4, 6, 8, 10] {
            let bound = optimal.truncation_bound(z_max, terms);
            let mut c = vec![Complex64::ZERO; terms];
            for i in 0..500 {
                let z = z_max * (f64::from(i) * 0.618_034).fract();
                let t = 2.0 * (f64::from(i) * 0.754_878).fract() - 1.0;
                optimal.coefficients(z, &mut c);
                let sum: Complex64 = c.iter().enumerate().map(|(n, c)| c * optimal.basis(n, t)).sum();
                let error = (sum - Complex64::cis(z * 0.215 * t)).norm();
                assert!(error <= 1.05 * bound, "{terms} terms: {error:e} > {bound:e}");
            }
        }
    }

    #[test]
    fn toward_z_0_the_error_fades_with_what_is_scattered() {
        let field = even(0.43);
        let heights = HeightHistogram::of(&field);
        let optimal = Optimal::new(&field, [0.0, 4.0 * std::f64::consts::PI / 0.38]);
        for terms in [2, 4, 6] {
            let mut c = vec![Complex64::ZERO; terms];
            let mut left = |z: f64| -> f64 {
                optimal.coefficients(z, &mut c);
                let off = |t: f64| -> f64 {
                    let sum: Complex64 = c.iter().enumerate().map(|(n, c)| c * optimal.basis(n, t)).sum();
                    (sum - Complex64::cis(z * heights.half_range * t)).norm_sqr()
                };
                let square: f64 = heights.bins.iter().map(|&(t, w)| w * off(t)).sum();
                // ⟨|e^{izh} − m|²⟩, which 1 − |m|² has no digits of.
                let x = z * heights.half_range;
                let mean = mean_beyond_one(&heights, x);
                let scattered: f64 =
                    heights.bins.iter().map(|&(t, w)| w * (beyond_one(x * t) - mean).norm_sqr()).sum();
                (square / scattered).sqrt()
            };
            let near = left(0.3);
            for z in [1e-2, 1e-4, 1e-6] {
                assert!(left(z) < 1.5 * near, "{terms} terms at z = {z}: {:e}, {near:e} at 0.3", left(z));
            }
            optimal.coefficients(0.0, &mut c);
            assert!(c[0] == Complex64::ONE && c[1..].iter().all(|c| *c == Complex64::ZERO), "{c:?}");
        }
    }

    #[test]
    fn a_flat_surface_has_one_function() {
        let flat = HeightField::new(4, 4, [0.1, 0.1], vec![2.0; 16]).unwrap();
        for z_range in [[0.0, 33.0], [16.0, 33.0]] {
            let optimal = Optimal::new(&flat, z_range);
            assert_eq!(optimal.most_terms(), 1);
            let mut c = [Complex64::ZERO];
            optimal.coefficients(20.0, &mut c);
            // All heights are one, but a thousandth of the weight is spread over heights that do not occur.
            assert!((c[0] * optimal.basis(0, 0.0) - 1.0).norm() < 2e-3);
        }
    }
}
