//! Least-squares polynomial over a grid.
//!
//! On a full grid the products P_i(x) P_j(y) of the orthonormal polynomials of each axis (Gram polynomials, the discrete Legendre
//! polynomials) are orthonormal. Every coefficient is therefore a projection, c_ij = Σ h P_i(x) P_j(y) for i + j up to the total degree,
//! and no system is solved.

use crate::error::Result;
use crate::surface::HeightField;
use rayon::prelude::*;

/// Returns `field` less the polynomial of least squares of total degree `degree`: the mean for degree 0, the plane for degree 1.
///
/// # Errors
/// Heights so large that their sums are not finite numbers.
pub(super) fn subtract(field: &HeightField, degree: usize) -> Result<HeightField> {
    let along_x = gram_polynomials(field.columns(), degree);
    let along_y = gram_polynomials(field.rows(), degree);
    let columns = field.columns();
    let moments: Vec<Vec<f64>> = (0..field.rows())
        .into_par_iter()
        .map(|row| {
            let project = |p: &Vec<f64>| p.iter().zip(field.row(row)).map(|(p, h)| p * h).sum();
            along_x.iter().map(project).collect()
        })
        .collect();
    let coefficient = |i: usize, j: usize| -> f64 {
        along_y[j].iter().zip(&moments).map(|(p, moments)| p * moments[i]).sum()
    };
    // For each power of x, the polynomial in y that goes with it.
    let coefficients: Vec<Vec<f64>> = (0..along_x.len())
        .map(|i| (0..along_y.len().min(degree + 1 - i)).map(|j| coefficient(i, j)).collect())
        .collect();
    let mut heights = field.heights().to_vec();
    heights.par_chunks_mut(columns).enumerate().for_each(|(row, heights)| {
        for (in_y, p) in coefficients.iter().zip(&along_x) {
            let factor: f64 = in_y.iter().zip(&along_y).map(|(c, p)| c * p[row]).sum();
            heights.iter_mut().zip(p).for_each(|(h, p)| *h -= factor * p);
        }
    });
    HeightField::new(columns, field.rows(), field.pixel_size(), heights)
}

/// Returns the orthonormal polynomials of degree 0 … `degree` on `n` equidistant points, by the three-term recurrence of Stieltjes; at most
/// `n`, which fit every height.
fn gram_polynomials(n: usize, degree: usize) -> Vec<Vec<f64>> {
    let place = |i: usize| (2 * i + 1) as f64 / n as f64 - 1.0;
    let mut polynomials = vec![vec![1.0 / (n as f64).sqrt(); n]];
    while polynomials.len() <= degree.min(n - 1) {
        let mut next: Vec<f64> =
            polynomials[polynomials.len() - 1].iter().enumerate().map(|(i, p)| place(i) * p).collect();
        // Orthogonalised against all former ones, twice, not only against the last two: rounding errors would grow with the degree.
        for _ in 0..2 {
            for p in &polynomials {
                let part: f64 = next.iter().zip(p).map(|(a, b)| a * b).sum();
                next.iter_mut().zip(p).for_each(|(a, b)| *a -= part * b);
            }
        }
        let norm = next.iter().map(|a| a * a).sum::<f64>().sqrt();
        next.iter_mut().for_each(|a| *a /= norm);
        polynomials.push(next);
    }
    polynomials
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::surface::prepare::tests::field;

    fn largest(field: &HeightField) -> f64 {
        field.heights().iter().fold(0.0, |m, h| m.max(h.abs()))
    }

    #[test]
    fn a_polynomial_of_the_degree_vanishes_and_of_the_next_one_does_not() {
        for degree in 1..=6 {
            let mut random = Random::new(degree as u64);
            let terms: Vec<(i32, i32, f64)> = (0..=degree)
                .flat_map(|i| (0..=degree - i).map(move |j| (i, j)))
                .map(|(i, j)| (i, j, random.signed()))
                .collect();
            let bow = field(41, 30, |x, y| terms.iter().map(|(i, j, c)| c * x.powi(*i) * y.powi(*j)).sum());
            let left = largest(&subtract(&bow, degree as usize).unwrap());
            assert!(left < 1e-12 * largest(&bow), "degree {degree}: {left}");
            assert!(largest(&subtract(&bow, degree as usize - 1).unwrap()) > 1e-3 * largest(&bow));
        }
    }

    #[test]
    fn the_total_degree_counts_and_not_that_of_each_axis() {
        let saddle = field(20, 20, |x, y| x * y);
        assert!(largest(&subtract(&saddle, 1).unwrap()) > 0.1);
        assert!(largest(&subtract(&saddle, 2).unwrap()) < 1e-13);
    }

    #[test]
    fn what_is_left_is_orthogonal_to_every_term() {
        let mut random = Random::new(9);
        let noise: Vec<f64> = (0..25 * 20).map(|_| 3.0 + random.signed()).collect();
        let left = subtract(&HeightField::new(25, 20, [0.1; 2], noise).unwrap(), 3).unwrap();
        for (i, j) in [(0, 0), (1, 0), (0, 1), (2, 1), (0, 3)] {
            let term = |r: usize, c: usize| left.row(r)[c] * left.x(c).powi(i) * left.y(r).powi(j);
            let sum: f64 = (0..20).flat_map(|r| (0..25).map(move |c| (r, c))).map(|(r, c)| term(r, c)).sum();
            assert!(sum.abs() < 1e-12, "x^{i} y^{j}: {sum}");
        }
        // By hand, of three heights: the line of least squares through 0, 1, 0 is their mean.
        let three = HeightField::new(3, 1, [1.0; 2], vec![0.0, 1.0, 0.0]).unwrap();
        let left = subtract(&three, 1).unwrap();
        assert!(
            (left.heights()[1] - 2.0 / 3.0).abs() < 1e-15 && (left.heights()[0] + 1.0 / 3.0).abs() < 1e-15
        );
    }

    #[test]
    fn more_coefficients_than_samples_leave_nothing() {
        let few = field(3, 2, |x, y| (x * 30.0).sin() + y);
        assert!(largest(&subtract(&few, 12).unwrap()) < 1e-14);
    }
}
