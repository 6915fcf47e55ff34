//! Chebyshev interpolation on 0 … z_max.

use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::PI;
use std::sync::Arc;

/// Returns the `count` Chebyshev nodes of the first kind on 0 … `end`, increasing.
pub fn nodes(count: usize, end: f64) -> Vec<f64> {
    (0..count).map(|j| 0.5 * end * (1.0 - (PI * (j as f64 + 0.5) / count as f64).cos())).collect()
}

/// Returns the matrix from values at [`nodes`] to coefficients a_k of Σ a_k T_k(x), x = 2z/`end` − 1: row k, column j.
pub fn coefficients_from_values(count: usize) -> Vec<Vec<f64>> {
    let n = count as f64;
    let entry = |k: usize, j: usize| {
        let norm = if k == 0 { 1.0 / n } else { 2.0 / n };
        // Node j stands at x = −cos(π(j + ½)/n) = cos(π − π(j + ½)/n).
        norm * (k as f64 * (PI - PI * (j as f64 + 0.5) / n)).cos()
    };
    (0..count).map(|k| (0..count).map(|j| entry(k, j)).collect()).collect()
}

/// Cosine transform from values at [`nodes`] to coefficients, in O(n log n): the product with [`coefficients_from_values`].
pub struct ChebyshevTransform {
    fft: Arc<dyn Fft<f64>>,
    // e^{−iπk/(2n)} with the norm and the sign of coefficient k.
    turns: Vec<Complex64>,
}

/// Memory that a thread needs for [`ChebyshevTransform::apply`].
pub struct ChebyshevScratch {
    values: Vec<Complex64>,
    of_fft: Vec<Complex64>,
}

impl ChebyshevTransform {
    /// Prepares transforms of `count` values.
    pub fn new(count: usize) -> Self {
        let n = count as f64;
        let turn = |k: usize| {
            let norm = if k == 0 { 1.0 / n } else { 2.0 / n };
            let sign = if k.is_multiple_of(2) { norm } else { -norm };
            Complex64::from_polar(sign.abs(), -0.5 * PI * k as f64 / n) * sign.signum()
        };
        Self { fft: FftPlanner::new().plan_fft_forward(count), turns: (0..count).map(turn).collect() }
    }

    /// Returns memory for [`Self::apply`].
    pub fn scratch(&self) -> ChebyshevScratch {
        ChebyshevScratch {
            values: vec![Complex64::ZERO; self.turns.len()],
            of_fft: vec![Complex64::ZERO; self.fft.get_inplace_scratch_len()],
        }
    }

    /// Calls `out` with the number and the value of each coefficient of the `values`. Values in even places, then those in odd places backward,
    /// have a Fourier transform whose parts are the cosine sums (Makhoul 1980, "A fast cosine transform in one and two dimensions").
    pub fn apply(
        &self,
        values: impl Iterator<Item = f64>,
        scratch: &mut ChebyshevScratch,
        mut out: impl FnMut(usize, f64),
    ) {
        let ChebyshevScratch { values: sorted, of_fft } = scratch;
        let count = self.turns.len();
        for (j, value) in values.enumerate() {
            let place = if j.is_multiple_of(2) { j / 2 } else { count - 1 - j / 2 };
            sorted[place] = Complex64::new(value, 0.0);
        }
        self.fft.process_with_scratch(sorted, of_fft);
        for (k, (sum, turn)) in sorted.iter().zip(&self.turns).enumerate() {
            out(k, (sum * turn).re);
        }
    }
}

/// Writes T_0(x) … T_{n−1}(x) into `values`.
pub fn polynomials(x: f64, values: &mut [f64]) {
    let (mut before, mut term) = (1.0, x);
    for value in values {
        *value = before;
        (before, term) = (term, 2.0 * x * term - before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fast_transform_is_the_product_with_the_matrix() {
        for count in [1, 2, 3, 12, 37, 128, 1000] {
            let values: Vec<f64> = (0..count).map(|j| (0.37 * (j * j) as f64).sin() + 0.2).collect();
            let transform = ChebyshevTransform::new(count);
            let mut scratch = transform.scratch();
            // The second time in the same memory.
            for _ in 0..2 {
                let mut found = vec![0.0; count];
                transform.apply(values.iter().copied(), &mut scratch, |k, a| found[k] = a);
                for (k, row) in coefficients_from_values(count).iter().enumerate() {
                    let exact: f64 = row.iter().zip(&values).map(|(m, v)| m * v).sum();
                    assert!(
                        (found[k] - exact).abs() < 1e-13,
                        "{count}, {k}: {} instead of {exact}",
                        found[k]
                    );
                }
            }
        }
    }

    #[test]
    fn a_polynomial_of_lower_degree_is_interpolated_exactly() {
        let f = |z: f64| 3.0 - 2.0 * z + 0.5 * z.powi(4);
        let values: Vec<f64> = nodes(6, 2.5).into_iter().map(f).collect();
        let coefficients: Vec<f64> = coefficients_from_values(6)
            .iter()
            .map(|row| row.iter().zip(&values).map(|(m, v)| m * v).sum())
            .collect();
        for z in [0.0, 0.3, 1.7, 2.5] {
            let mut t = [0.0; 6];
            polynomials(2.0 * z / 2.5 - 1.0, &mut t);
            let sum: f64 = t.iter().zip(&coefficients).map(|(t, a)| t * a).sum();
            assert!((sum - f(z)).abs() < 1e-12, "{z}: {sum} {}", f(z));
        }
    }
}
