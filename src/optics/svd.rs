//! Singular value decomposition of matrices of low numerical rank, such as sampled kernels.
//!
//! A = Q R by Gram–Schmidt orthogonalisation with pivoting, until the remainder of every column is rounding (Golub & Van Loan, *Matrix
//! Computations*, 5.4.2); then one-sided Jacobi rotations (Hestenes 1958; ibid. 8.6.3) of the few rows of R.

use rustfft::num_complex::Complex64;

/// Decomposition A = U diag(s) V*, with decreasing singular values.
#[derive(Clone, Debug)]
pub struct Svd {
    /// The columns of U, one for each singular value.
    pub u: Vec<Vec<Complex64>>,
    /// The singular values.
    pub s: Vec<f64>,
    /// The columns of V.
    pub v: Vec<Vec<Complex64>>,
}

/// Relative remainder of a column, compared to the largest column, below which it is rounding.
const ROUNDING: f64 = 1e-15;
/// Largest number of sweeps of rotations; they converge quadratically within a dozen.
const SWEEPS: usize = 60;
/// Cosine below which two vectors count as orthogonal: the rounding in a product of vectors of 10⁴ numbers. Smaller rotations would never
/// end, and each would add rounding.
const ORTHOGONAL: f64 = 1e-14;
/// Remaining length of a unit vector after the second pass against the former directions, below which it is rounding.
const LOST: f64 = 0.5;

impl Svd {
    /// Decomposes the matrix with these `columns`, all of one length.
    pub fn of(mut columns: Vec<Vec<Complex64>>) -> Self {
        let width = columns.len();
        let mut q: Vec<Vec<Complex64>> = Vec::new();
        // Rows of R.
        let mut r: Vec<Vec<Complex64>> = Vec::new();
        let mut first = None;
        while let Some((pivot, length)) =
            columns.iter().map(|c| norm(c)).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
        {
            let largest = *first.get_or_insert(length);
            if length <= ROUNDING * largest || q.len() == columns[pivot].len().min(width) {
                break;
            }
            let mut direction: Vec<Complex64> = columns[pivot].iter().map(|x| x / length).collect();
            // Second pass against the former directions, parts of which rounding has brought back.
            for other in &q {
                let part = dot(other, &direction);
                add(&mut direction, -part, other);
            }
            let length = norm(&direction);
            if length < LOST {
                break;
            }
            direction.iter_mut().for_each(|x| *x /= length);
            let row: Vec<Complex64> = columns
                .iter_mut()
                .map(|column| {
                    let part = dot(&direction, column);
                    add(column, -part, &direction);
                    part
                })
                .collect();
            q.push(direction);
            r.push(row);
        }
        // R* = W diag(s) Z*, rotated from the columns of R*; then A = (Q Z) diag(s) W*.
        let mut rotated: Vec<Vec<Complex64>> =
            r.into_iter().map(|row| row.into_iter().map(|x| x.conj()).collect()).collect();
        let mut u = q;
        orthogonalise(&mut rotated, &mut u);
        let mut order: Vec<(f64, usize)> = rotated.iter().map(|c| norm(c)).zip(0..).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        let unit = |n: usize, s: f64| rotated[n].iter().map(|x| x / s).collect();
        Self {
            v: order.iter().map(|&(s, n)| unit(n, s)).collect(),
            u: order.iter().map(|&(_, n)| u[n].clone()).collect(),
            s: order.into_iter().map(|(s, _)| s).collect(),
        }
    }
}

/// Rotates pairs of `columns` until all are orthogonal, and those of `along` by the same rotations.
fn orthogonalise(columns: &mut [Vec<Complex64>], along: &mut [Vec<Complex64>]) {
    for _ in 0..SWEEPS {
        let mut done = true;
        for i in 0..columns.len() {
            for j in i + 1..columns.len() {
                let (a, b) = (square(&columns[i]), square(&columns[j]));
                let product = dot(&columns[i], &columns[j]);
                let size = product.norm();
                if size <= ORTHOGONAL * (a * b).sqrt() {
                    continue;
                }
                done = false;
                // The rotation that makes the 2 × 2 Gram matrix diagonal (ibid. 8.4.2), after a turn of the phase that makes it real.
                let tau = (b - a) / (2.0 * size);
                let t = tau.signum() / (tau.abs() + tau.hypot(1.0));
                let c = t.hypot(1.0).recip();
                let turn = product / size;
                rotate(columns, (i, j), c, c * t, turn);
                rotate(along, (i, j), c, c * t, turn);
            }
        }
        if done {
            return;
        }
    }
}

/// Replaces columns i and j by c·i − s·j′ and s·i + c·j′ with j′ = j/`turn`.
fn rotate(columns: &mut [Vec<Complex64>], (i, j): (usize, usize), c: f64, s: f64, turn: Complex64) {
    let (head, tail) = columns.split_at_mut(j);
    for (x, y) in head[i].iter_mut().zip(&mut tail[0]) {
        let (a, b) = (*x, *y * turn.conj());
        (*x, *y) = (a * c - b * s, a * s + b * c);
    }
}

/// Returns ⟨a, b⟩ = Σ a* b.
fn dot(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}

fn add(to: &mut [Complex64], factor: Complex64, other: &[Complex64]) {
    to.iter_mut().zip(other).for_each(|(x, y)| *x += factor * y);
}

fn square(a: &[Complex64]) -> f64 {
    a.iter().map(Complex64::norm_sqr).sum()
}

fn norm(a: &[Complex64]) -> f64 {
    square(a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a smooth kernel, whose singular values fall beyond rounding, and one whose do not.
    fn matrices() -> Vec<Vec<Vec<Complex64>>> {
        let entry = |i: usize, j: usize| Complex64::cis(0.02 * (i * j) as f64 / (1.0 + 0.01 * j as f64));
        let mut smooth: Vec<Vec<Complex64>> =
            (0..60).map(|j| (0..40).map(|i| entry(i, j)).collect()).collect();
        smooth[7] = vec![Complex64::ZERO; 40];
        let noise = |k: usize| (k as f64 * 0.618_034).fract() - 0.5;
        let rough = (0..12)
            .map(|j| {
                (0..30).map(|i| Complex64::new(noise(i * 31 + j * 17), noise(i * 7 + j * 101))).collect()
            })
            .collect();
        vec![smooth, rough]
    }

    #[test]
    fn vectors_are_orthonormal_and_their_product_is_the_matrix() {
        for matrix in matrices() {
            let Svd { u, s, v } = Svd::of(matrix.clone());
            assert!(s.is_sorted_by(|a, b| a >= b) && s[s.len() - 1] > 0.0);
            for vectors in [&u, &v] {
                for (i, a) in vectors.iter().enumerate() {
                    for (j, b) in vectors.iter().enumerate().filter(|(j, _)| s[i].min(s[*j]) > 1e-3 * s[0]) {
                        let expected = if i == j { 1.0 } else { 0.0 };
                        assert!((dot(a, b) - expected).norm() < 1e-12, "{i} {j}: {}", dot(a, b));
                    }
                }
            }
            // Also the vectors of the smallest values see no more of the large ones than rounding.
            for n in 0..s.len() {
                for (j, column) in matrix.iter().enumerate() {
                    let off = dot(&u[n], column) - s[n] * v[n][j].conj();
                    assert!(off.norm() < 1e-14 * s[0], "{n} {j}: {}", off.norm() / s[0]);
                }
            }
            for (j, column) in matrix.iter().enumerate() {
                for (i, exact) in column.iter().enumerate() {
                    let sum: Complex64 = (0..s.len()).map(|n| u[n][i] * s[n] * v[n][j].conj()).sum();
                    assert!((sum - exact).norm() < 1e-13 * s[0], "{i} {j}: {sum} {exact}");
                }
            }
        }
    }

    #[test]
    fn known_singular_values_are_found() {
        // The columns (3, 4) and (0, 5): the eigenvalues of A*A are 45 and 5.
        let real = |a: f64, b: f64| vec![Complex64::from(a), Complex64::from(b)];
        let found = Svd::of(vec![real(3.0, 4.0), real(0.0, 5.0)]).s;
        assert!((found[0] - 45f64.sqrt()).abs() < 1e-14 && (found[1] - 5f64.sqrt()).abs() < 1e-14);
        assert!(Svd::of(vec![real(0.0, 0.0); 3]).s.is_empty());
    }
}
