//! The Chebyshev expansion: b_n = T_n(t), c_n = (2 − δ_{n0}) iⁿ J_n(z a), by the Jacobi–Anger expansion
//! e^{ix cos θ} = J_0(x) + 2 Σ iⁿ J_n(x) cos nθ (Abramowitz & Stegun 9.1.44–47). Coefficients and functions are bounded by
//! 2 and 1, so nothing cancels.

use super::Expansion;
use rustfft::num_complex::Complex64;

/// The Chebyshev expansion over heights of half range `half_range` \[µm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chebyshev {
    /// a, half the range of heights \[µm\].
    pub half_range: f64,
}

/// Most terms considered: enough for kilometres of phase.
const MAX_TERMS: usize = 512;

impl Expansion for Chebyshev {
    fn basis(&self, n: usize, t: f64) -> Complex64 {
        (n as f64 * t.clamp(-1.0, 1.0).acos()).cos().into()
    }

    fn coefficients(&self, z: f64, out: &mut [Complex64]) {
        const I_POWERS: [Complex64; 4] =
            [Complex64::ONE, Complex64::new(0.0, 1.0), Complex64::new(-1.0, 0.0), Complex64::new(0.0, -1.0)];
        let bessel = bessel_j(z * self.half_range, out.len());
        for (n, (slot, j)) in out.iter_mut().zip(bessel).enumerate() {
            *slot = I_POWERS[n % 4] * if n == 0 { j } else { 2.0 * j };
        }
    }

    fn most_terms(&self) -> usize {
        MAX_TERMS
    }

    /// 2 Σ_{n≥K} |J_n(x)| with |J_n(x)| ≤ (x/2)ⁿ/n! (Abramowitz & Stegun 9.1.62), which also bounds every smaller x.
    fn truncation_bound(&self, z: f64, terms: usize) -> f64 {
        let half = (z * self.half_range).abs() / 2.0;
        let mut term = 1.0;
        let mut sum = 0.0;
        for n in 0..terms + 400 {
            if n > 0 {
                term *= half / n as f64;
            }
            if n >= terms {
                sum += 2.0 * term;
            }
        }
        sum
    }

    fn rounding_bound(&self, _z: f64, roundoff: f64) -> f64 {
        // Σ|c_n|² = 1 + small (Neumann): at most about two roundings of a sum of modulus below 2.
        4.0 * roundoff
    }
}

/// J_0(x) … J_{count−1}(x) by Miller's backward recurrence, normalised by J_0 + 2 Σ J_{2m} = 1.
pub fn bessel_j(x: f64, count: usize) -> Vec<f64> {
    if x == 0.0 {
        return (0..count).map(|n| if n == 0 { 1.0 } else { 0.0 }).collect();
    }
    // From well above both the order and the argument, where J is negligible: 40 orders more give full f64 accuracy.
    let start = (count.max(x.abs().ceil() as usize) + 40 + (x.abs().sqrt() as usize) * 4) & !1;
    let mut j = vec![0.0f64; start + 2];
    j[start] = 1e-300;
    for n in (1..=start).rev() {
        j[n - 1] = 2.0 * n as f64 / x * j[n] - j[n + 1];
        if j[n - 1].abs() > 1e200 {
            j.iter_mut().for_each(|v| *v *= 1e-250);
        }
    }
    let norm = j[0] + 2.0 * j.iter().skip(2).step_by(2).sum::<f64>();
    j.truncate(count);
    j.iter_mut().for_each(|v| *v /= norm);
    j
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bessel_functions_have_their_tabulated_values() {
        // Abramowitz & Stegun, tables 9.1 and 9.4.
        let j = bessel_j(1.0, 3);
        assert!((j[0] - 0.765_197_686_557_966_5).abs() < 1e-14);
        assert!((j[1] - 0.440_050_585_744_933_5).abs() < 1e-14);
        let j = bessel_j(10.0, 11);
        assert!((j[0] + 0.245_935_764_451_348_3).abs() < 1e-13);
        assert!((j[10] - 0.207_486_106_633_358_9).abs() < 1e-13);
        assert_eq!(bessel_j(0.0, 2), [1.0, 0.0]);
    }

    #[test]
    fn the_bound_holds_for_random_arguments_and_takes_the_known_number_of_terms() {
        let chebyshev = Chebyshev { half_range: 1.0 };
        for i in 0..2000 {
            let x = 14.0 * (f64::from(i) * 0.618_034).fract();
            let t = 2.0 * (f64::from(i) * 0.754_878).fract() - 1.0;
            let terms = 1 + i as usize % 40;
            let mut c = vec![Complex64::ZERO; terms];
            chebyshev.coefficients(x, &mut c);
            let sum: Complex64 = c.iter().enumerate().map(|(n, c)| c * chebyshev.basis(n, t)).sum();
            let error = (sum - Complex64::cis(x * t)).norm();
            assert!(
                error <= chebyshev.truncation_bound(x, terms) + 1e-12,
                "x = {x}, {terms} terms: {error:e}"
            );
        }
        // Height range, sup error, terms; |z| ≤ 4π/0.38.
        for (range, tolerance, terms) in
            [(0.15, 1e-4, 9), (0.30, 1e-3, 11), (0.50, 1e-3, 16), (1.0, 1e-3, 26)]
        {
            let z = 4.0 * std::f64::consts::PI / 0.38;
            let chebyshev = Chebyshev { half_range: range / 2.0 };
            // The sup error itself, on a grid of heights at the largest z.
            let error = |terms: usize| {
                let mut c = vec![Complex64::ZERO; terms];
                chebyshev.coefficients(z, &mut c);
                (0..=400).map(|i| f64::from(i) / 200.0 - 1.0).fold(0.0f64, |worst, t| {
                    let sum: Complex64 = c.iter().enumerate().map(|(n, c)| c * chebyshev.basis(n, t)).sum();
                    worst.max((sum - Complex64::cis(z * range / 2.0 * t)).norm())
                })
            };
            assert!(error(terms) <= tolerance, "H = {range}: {:e}", error(terms));
        }
    }
}
