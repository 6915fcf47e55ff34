//! The Kaiser–Bessel kernel between the bins of a transform (Jackson et al. 1991): φ(t) = I₀(β√(1 − (2t/w)²)) over w = 10
//! bins, with the transform ∝ sinh(√(β² − (πwx)²))/√(β² − (πwx)²) at x = position/length.

use std::f64::consts::PI;

/// Width of the kernel in bins.
pub const TAPS: usize = 10;
/// Degree of the polynomials that approximate φ between two bins with an error below 1e-11 of its peak.
const DEGREE: usize = 14;

/// φ for one shape parameter.
#[derive(Clone, Debug)]
pub struct GriddingKernel {
    shape: f64,
    /// Chebyshev coefficients in 2·fraction − 1 of φ at each of the taps.
    pieces: [[f64; TAPS]; DEGREE + 1],
}

impl GriddingKernel {
    /// Returns the kernel with β = `shape`·w.
    pub fn new(shape: f64) -> Self {
        let beta = shape * TAPS as f64;
        let peak = bessel_i0(beta);
        let at = |t: f64| {
            let inside = 1.0 - (2.0 * t / TAPS as f64).powi(2);
            bessel_i0(beta * inside.max(0.0).sqrt()) / peak
        };
        let mut pieces = [[0.0; TAPS]; DEGREE + 1];
        let points = DEGREE + 1;
        for (k, coefficients) in pieces.iter_mut().enumerate() {
            for (tap, slot) in coefficients.iter_mut().enumerate() {
                let sum: f64 = (0..points)
                    .map(|j| {
                        let angle = PI * (j as f64 + 0.5) / points as f64;
                        let fraction = (angle.cos() + 1.0) / 2.0;
                        at(fraction - Self::offset(tap)) * (k as f64 * angle).cos()
                    })
                    .sum();
                *slot = sum * if k == 0 { 1.0 } else { 2.0 } / points as f64;
            }
        }
        Self { shape, pieces }
    }

    /// Returns the offset of a tap from the bin at or below: −4 … 5.
    pub fn offset(tap: usize) -> f64 {
        tap as f64 - (TAPS as f64 / 2.0 - 1.0)
    }

    /// Returns φ at every tap for a place `fraction` ∈ \[0, 1) above a bin.
    pub fn weights(&self, fraction: f64) -> [f64; TAPS] {
        let x = 2.0 * fraction - 1.0;
        // Clenshaw's recurrence, all taps at once.
        let (mut last, mut before) = ([0.0; TAPS], [0.0; TAPS]);
        for coefficients in self.pieces[1..].iter().rev() {
            for tap in 0..TAPS {
                let next = 2.0 * x * last[tap] - before[tap] + coefficients[tap];
                before[tap] = last[tap];
                last[tap] = next;
            }
        }
        std::array::from_fn(|tap| x * last[tap] - before[tap] + self.pieces[0][tap])
    }

    /// Returns ∫ φ(t) e^{2πixt} dt, in the same units, at `x` = position/length within ±1/2.
    pub fn transform(&self, x: f64) -> f64 {
        let width = TAPS as f64;
        let beta = self.shape * width;
        let root = (beta * beta - (PI * width * x).powi(2)).max(0.0).sqrt();
        let shape = if root > 0.0 { root.sinh() / root } else { 1.0 };
        width * shape / bessel_i0(beta)
    }
}

/// Returns I₀(x) by its power series, whose terms are all positive.
fn bessel_i0(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..200 {
        term *= quarter / f64::from(k * k);
        sum += term;
        if term < 1e-17 * sum {
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pieces_are_the_kernel_and_the_transform_is_its_transform() {
        let (shape, half) = (2.3, TAPS as f64 / 2.0);
        let kernel = GriddingKernel::new(shape);
        let beta = shape * TAPS as f64;
        for i in 0..100 {
            let fraction = f64::from(i) / 100.0;
            for (tap, weight) in kernel.weights(fraction).into_iter().enumerate() {
                let t = fraction - GriddingKernel::offset(tap);
                let exact = bessel_i0(beta * (1.0 - (t / half).powi(2)).max(0.0).sqrt()) / bessel_i0(beta);
                assert!((weight - exact).abs() < 1e-11, "{t}: {weight} {exact}");
            }
        }
        for x in [0.0, 0.1, 0.3, 0.5] {
            let sum: f64 = (0..1000 * TAPS)
                .map(|i| {
                    let t = (i as f64 + 0.5) / 1000.0 - half;
                    let phi = bessel_i0(beta * (1.0 - (t / half).powi(2)).sqrt()) / bessel_i0(beta);
                    phi * (2.0 * PI * x * t).cos() / 1000.0
                })
                .sum();
            assert!((kernel.transform(x) - sum).abs() < 1e-9, "{x}: {} {sum}", kernel.transform(x));
        }
    }

    #[test]
    fn bessel_functions_have_their_tabulated_values() {
        // Abramowitz & Stegun, table 9.8: I₀(1), I₀(5).
        assert!((bessel_i0(1.0) - 1.266_065_877_752_009).abs() < 1e-14);
        assert!((bessel_i0(5.0) - 27.239_871_823_604_44).abs() < 1e-12);
    }
}
