//! Chebyshev interpolation on 0 … z_max.

use std::f64::consts::PI;

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
