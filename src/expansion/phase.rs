//! The expansion in z: e^{izh} as a polynomial in z at each height, c_n(z) Chebyshev's and the same for every surface.
//!
//! With z = (1 + x) z_max/2 and y = z_max h/2, e^{izh} = e^{iy} e^{iyx} = Σ T_m(x) β_m(y), β_m = e^{iy} (2 − δ_{m0}) i^m J_m(y)
//! (Jacobi–Anger). β_m is complex: its real part is b_2m with c_2m = T_m, its imaginary part b_2m+1 with c_2m+1 = i T_m. So
//! a pair of terms is one polynomial, and who sums many z at one frequency needs no table of coefficients: a recurrence
//! makes them.

use super::Expansion;
use rustfft::num_complex::Complex64;

/// Most polynomials: enough for twenty radians of y.
const MOST: usize = 48;
/// Intervals of the table of β_m over y: linear between, to (Δy)²/8.
const INTERVALS: usize = 1 << 14;

/// The expansion over heights of half range a and |z| up to z_max.
pub struct Phase {
    /// y = `scale`·t.
    scale: f64,
    z_max: f64,
    /// `[polynomial][y]`.
    table: Vec<Vec<Complex64>>,
}

impl Phase {
    /// For heights of half range `half_range` \[µm\] and |z| up to `z_max` \[rad/µm\].
    pub fn new(half_range: f64, z_max: f64) -> Self {
        const I_POWERS: [Complex64; 4] =
            [Complex64::ONE, Complex64::new(0.0, 1.0), Complex64::new(-1.0, 0.0), Complex64::new(0.0, -1.0)];
        let scale = z_max * half_range / 2.0;
        let mut table = vec![Vec::new(); MOST];
        for i in 0..=INTERVALS {
            let y = scale * (2.0 * i as f64 / INTERVALS as f64 - 1.0);
            for (m, j) in bessel_j(y.abs(), MOST).into_iter().enumerate() {
                // J_m(−y) = (−1)^m J_m(y)
                let sign = if y < 0.0 && m % 2 == 1 { -1.0 } else { 1.0 };
                let twice = if m == 0 { 1.0 } else { 2.0 };
                table[m].push(Complex64::cis(y) * I_POWERS[m % 4] * (sign * twice * j));
            }
        }
        Self { scale, z_max, table }
    }
}

impl Expansion for Phase {
    fn basis(&self, n: usize, t: f64) -> Complex64 {
        let place = (t.clamp(-1.0, 1.0) + 1.0) * 0.5 * INTERVALS as f64;
        let left = (place as usize).min(INTERVALS - 1);
        let row = &self.table[n / 2];
        let beta = row[left] + (row[left + 1] - row[left]) * (place - left as f64);
        if n.is_multiple_of(2) { beta.re } else { beta.im }.into()
    }

    fn coefficients(&self, z: f64, out: &mut [Complex64]) {
        let x = 2.0 * z / self.z_max - 1.0;
        let (mut before, mut own) = (x, 1.0); // T_{−1} = T_1
        for pair in out.chunks_mut(2) {
            for (slot, unit) in pair.iter_mut().zip([Complex64::ONE, Complex64::I]) {
                *slot = unit * own;
            }
            (before, own) = (own, 2.0 * x * own - before);
        }
    }

    fn most_terms(&self) -> usize {
        2 * MOST
    }

    /// Σ_{m≥M} 2 |J_m(y)| with |J_m(y)| ≤ (y/2)^m/m! (Abramowitz & Stegun 9.1.62); an odd term is half a polynomial.
    fn truncation_bound(&self, _z: f64, terms: usize) -> f64 {
        let mut term = 1.0;
        let mut sum = 0.0;
        for m in 0..terms / 2 + 400 {
            if m > 0 {
                term *= self.scale / 2.0 / m as f64;
            }
            if m >= terms / 2 {
                sum += 2.0 * term;
            }
        }
        sum
    }

    fn rounding_bound(&self, _z: f64, roundoff: f64) -> f64 {
        // As for Chebyshev's over heights: Σ|β_m|² is about 1.
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
    fn the_bound_holds_over_the_whole_range_of_heights_and_z() {
        let (half_range, z_max) = (0.4, 33.0);
        let phase = Phase::new(half_range, z_max);
        for terms in [8, 12, 20, 32] {
            let mut worst = 0.0f64;
            for i in 0..2000 {
                let z = z_max * (f64::from(i) * 0.618_034).fract();
                let t = 2.0 * (f64::from(i) * 0.754_878).fract() - 1.0;
                let mut c = vec![Complex64::ZERO; terms];
                phase.coefficients(z, &mut c);
                let sum: Complex64 = c.iter().enumerate().map(|(n, c)| c * phase.basis(n, t)).sum();
                worst = worst.max((sum - Complex64::cis(z * half_range * t)).norm());
            }
            // The table of β_m is linear between its places.
            assert!(worst <= phase.truncation_bound(z_max, terms) + 1e-6, "{terms} terms: {worst:e}");
            assert!(terms < 32 || worst < 1e-4, "{worst:e}");
        }
    }
}
