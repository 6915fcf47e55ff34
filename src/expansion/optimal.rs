//! The optimal expansion: singular functions of e^{izh} on the z that a scene can ask for and the heights that the surface
//! really has, so that as few terms as there can be carry it.
//!
//! The kernel is sampled at quadrature points of z and bins of the heights' histogram, its real and imaginary parts one
//! below the other so that the functions of h come out real, and decomposed. Rows are weighted by 1/√(1 − |⟨e^{izh}⟩|²),
//! the part of the light that is scattered at z: errors count relative to what is seen beside the mirror peak. A right
//! singular vector continues to every height by the left one (Nyström): b_n(t) = Σ_q u_qn s_q {cos, sin}(z_q a t)/σ_n.

use super::{Expansion, HeightScale};
use crate::surface::HeightField;
use nalgebra::DMatrix;
use rustfft::num_complex::Complex64;

/// Bins of the histogram of heights: the phase in a bin changes by less than a hundredth for every surface that taylor can
/// do, and the functions themselves are smooth in it.
const BINS: usize = 512;
/// Entries of the tables of b_n, linear between them: an error of (2/16384)²/8 · X² of the function.
const TABLE: usize = 16_384;
/// Part of the weight that every height gets, seen or not: keeps the functions tame where the histogram is empty.
const UNSEEN: f64 = 1e-3;
/// Most terms kept; singular values beyond are below rounding for any surface that fits the z range.
const MAX_TERMS: usize = 96;
/// Singular values below this part of the largest are noise of the decomposition.
const NOISE: f64 = 1e-11;

/// The optimal expansion of one surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimal {
    half_range: f64,
    z_max: f64,
    /// t of each bin's centre, and its weight.
    bins: Vec<(f64, f64)>,
    /// `[n][entry]`: b_n over t.
    tables: Vec<Vec<f64>>,
}

impl Optimal {
    /// Decomposes e^{izh} over the heights of `field` and 0 ≤ z ≤ `z_max` \[rad/µm\].
    pub fn new(field: &HeightField, z_max: f64) -> Self {
        let scale = HeightScale::of(field);
        let bins = histogram(field, &scale);
        let x_max = z_max * scale.half_range;
        // As many points as the kernel has degrees of freedom over z, and three times over.
        let points = 24 + (3.0 * x_max) as usize;
        let z_of = |q: usize| (q as f64 + 0.5) / points as f64 * z_max;
        let row_weight: Vec<f64> = (0..points)
            .map(|q| {
                let mean: Complex64 =
                    bins.iter().map(|&(t, w)| Complex64::cis(z_of(q) * scale.half_range * t) * w).sum();
                // A flat surface scatters nothing; then every row counts alike.
                (1.0 - mean.norm_sqr()).max(1e-12).sqrt().recip()
            })
            .collect();
        let kernel = |q: usize, t: f64| {
            let phase = z_of(q % points) * scale.half_range * t;
            row_weight[q % points] * if q < points { phase.cos() } else { phase.sin() }
        };
        let matrix = DMatrix::from_fn(2 * points, BINS, |q, j| kernel(q, bins[j].0) * bins[j].1.sqrt());
        let decomposed = matrix.svd(true, false);
        let tables = match decomposed.u {
            Some(u) => {
                let largest = decomposed.singular_values.max();
                let kept = decomposed.singular_values.iter().take(MAX_TERMS).enumerate();
                kept.filter(|(_, s)| **s > NOISE * largest)
                    .map(|(n, s)| {
                        let at = |t: f64| (0..2 * points).map(|q| u[(q, n)] * kernel(q, t)).sum::<f64>() / s;
                        (0..=TABLE).map(|i| at(2.0 * i as f64 / TABLE as f64 - 1.0)).collect()
                    })
                    .collect()
            }
            None => Vec::new(),
        };
        Self { half_range: scale.half_range, z_max, bins, tables }
    }
}

/// Centres in t and weights, which add up to 1, of the bins of the heights.
fn histogram(field: &HeightField, scale: &HeightScale) -> Vec<(f64, f64)> {
    let mut counts = [0.0f64; BINS];
    for &h in field.heights() {
        let bin = ((scale.normalise(h) + 1.0) / 2.0 * BINS as f64) as usize;
        counts[bin.min(BINS - 1)] += 1.0;
    }
    let samples = field.heights().len() as f64;
    let weight = |count: f64| (1.0 - UNSEEN) * count / samples + UNSEEN / BINS as f64;
    counts
        .iter()
        .enumerate()
        .map(|(i, &count)| (2.0 * (i as f64 + 0.5) / BINS as f64 - 1.0, weight(count)))
        .collect()
}

impl Expansion for Optimal {
    fn basis(&self, n: usize, t: f64) -> f64 {
        let Some(table) = self.tables.get(n) else { return 0.0 };
        let place = (t + 1.0) / 2.0 * TABLE as f64;
        let left = (place as usize).min(TABLE - 1);
        let share = place - left as f64;
        table[left] * (1.0 - share) + table[left + 1] * share
    }

    /// The projection of e^{izh} on b_n under the heights' weights.
    fn coefficients(&self, z: f64, out: &mut [Complex64]) {
        out.fill(Complex64::ZERO);
        for &(t, weight) in &self.bins {
            let value = Complex64::cis(z * self.half_range * t) * weight;
            for (n, c) in out.iter_mut().enumerate().take(self.tables.len()) {
                *c += value * self.basis(n, t);
            }
        }
    }

    fn most_terms(&self) -> usize {
        self.tables.len()
    }

    /// The sup error on a grid of heights and of z: measured, not proven.
    fn truncation_bound(&self, z: f64, terms: usize) -> f64 {
        const HEIGHTS: usize = 256;
        const ZS: usize = 32;
        let mut c = vec![Complex64::ZERO; terms];
        (0..=ZS).fold(0.0, |worst, q| {
            let z = z.min(self.z_max) * q as f64 / ZS as f64;
            self.coefficients(z, &mut c);
            (0..=HEIGHTS).fold(worst, |worst, i| {
                let t = 2.0 * i as f64 / HEIGHTS as f64 - 1.0;
                let sum: Complex64 = c.iter().enumerate().map(|(n, c)| c * self.basis(n, t)).sum();
                worst.max((sum - Complex64::cis(z * self.half_range * t)).norm())
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

    /// Heights spread evenly over `range` \[µm\].
    fn even(range: f64) -> HeightField {
        let heights = (0..4096).map(|i| range * f64::from(i) / 4095.0).collect();
        HeightField::new(64, 64, [0.1, 0.1], heights).unwrap()
    }

    #[test]
    fn far_fewer_terms_than_the_polynomials_need_reach_the_same_error() {
        let z_max = 4.0 * std::f64::consts::PI / 0.38;
        // Height range, sup error, and the terms that Chebyshev needs for it.
        for (range, tolerance, chebyshev) in
            [(0.15, 1e-4, 9), (0.30, 1e-3, 11), (0.50, 1e-3, 16), (1.0, 1e-3, 26)]
        {
            let optimal = Optimal::new(&even(range), z_max);
            let terms =
                (1..optimal.most_terms()).find(|&n| optimal.truncation_bound(z_max, n) <= tolerance).unwrap();
            eprintln!("H = {range}: {terms} terms");
            assert!(terms < chebyshev, "H = {range}: {terms} terms");
        }
    }

    #[test]
    fn the_measured_bound_holds_between_its_grid_points() {
        let z_max = 4.0 * std::f64::consts::PI / 0.38;
        let optimal = Optimal::new(&even(0.43), z_max);
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
    fn a_flat_surface_has_one_function() {
        let flat = HeightField::new(4, 4, [0.1, 0.1], vec![2.0; 16]).unwrap();
        let optimal = Optimal::new(&flat, 33.0);
        let mut c = [Complex64::ZERO];
        optimal.coefficients(20.0, &mut c);
        // All heights are one, but a thousandth of the weight is spread over heights that do not occur.
        assert!((c[0] * optimal.basis(0, 0.0) - 1.0).norm() < 2e-3);
    }
}
