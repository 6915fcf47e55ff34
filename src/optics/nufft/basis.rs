//! The Chebyshev series of e^{izh} over the heights, e^{iza t} = J₀(za) + 2 Σ iⁿ J_n(za) T_n(t) with h = middle + a t (Jacobi and Anger;
//! Abramowitz & Stegun 9.1.44, 9.1.45).

use crate::surface::HeightField;
use rustfft::num_complex::Complex64;

/// First Bessel function of the series that is left out, at the largest z, relative to the scattered amplitude.
const ACCURACY: f64 = 1e-11;
/// Orders beyond the last function at which the recurrence of the Bessel functions begins: they fall by 1e-16 over them.
const BEYOND: usize = 16;

/// T_n(h) and their coefficients c_n(z) with e^{iz(h − middle)} ≈ Σ c_n(z) T_n(h).
#[derive(Debug)]
pub struct HeightBasis {
    middle: f64,
    half_range: f64,
    terms: usize,
}

impl HeightBasis {
    /// Counts the functions for the heights of `field` and |z| up to `z_max` \[rad/µm\].
    pub fn new(field: &HeightField, z_max: f64) -> Self {
        let (low, high) = field.range();
        let (middle, half_range) = ((low + high) / 2.0, (high - low) / 2.0);
        let phase = z_max * half_range;
        // The functions fall faster than exponentially beyond their argument.
        let bessel = bessel(phase, phase as usize + 24 + (12.0 * phase.cbrt()) as usize);
        let needed = bessel.iter().rposition(|j| j.abs() > ACCURACY * phase.min(1.0));
        Self { middle, half_range, terms: needed.map_or(1, |last| last + 1) }
    }

    /// Returns the number of terms.
    pub fn terms(&self) -> usize {
        self.terms
    }

    /// Writes T_n at `height` \[µm\] into `out`, which has room for all.
    pub fn values(&self, height: f64, out: &mut [f64]) {
        let t = if self.half_range > 0.0 { (height - self.middle) / self.half_range } else { 0.0 };
        let (mut now, mut next) = (1.0, t);
        for slot in out {
            *slot = now;
            (now, next) = (next, 2.0 * t * next - now);
        }
    }

    /// Writes c_n at 0 ≤ `z` ≤ z_max into `out`.
    pub fn coefficients(&self, z: f64, out: &mut [Complex64]) {
        let (mut turn, mut factor) = (Complex64::ONE, 1.0);
        for (slot, value) in out.iter_mut().zip(bessel(z * self.half_range, self.terms)) {
            *slot = turn * (factor * value);
            (turn, factor) = (turn * Complex64::I, 2.0);
        }
    }
}

/// Returns J_0 … J_{count−1} at `x` ≥ 0, by the recurrence J_{n−1} = (2n/x) J_n − J_{n+1} downward from an order far beyond `count` and
/// `x` (Miller; Abramowitz & Stegun 9.12, example 1), normalised by J_0 + 2 Σ J_{2k} = 1.
fn bessel(x: f64, count: usize) -> Vec<f64> {
    /// Below it J_1 = x/2 is the last function that counts beside 1.
    const SMALL: f64 = 1e-150;
    /// Size beyond which all values are scaled down.
    const LARGE: f64 = 1e150;
    let mut values = vec![0.0; count];
    if x < SMALL {
        values.iter_mut().take(1).for_each(|first| *first = 1.0);
        return values;
    }
    let start = count.max(x as usize + (4.0 * x.cbrt()) as usize) + BEYOND;
    let (mut next, mut now, mut sum) = (0.0, 1.0, 0.0);
    for n in (0..=start).rev() {
        if n < count {
            values[n] = now;
        }
        if n.is_multiple_of(2) {
            sum += if n == 0 { now } else { 2.0 * now };
        }
        (next, now) = (now, 2.0 * n as f64 / x * now - next);
        if now.abs() > LARGE {
            (next, now, sum) = (next / LARGE, now / LARGE, sum / LARGE);
            values.iter_mut().for_each(|value| *value /= LARGE);
        }
    }
    values.iter_mut().for_each(|value| *value /= sum);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

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
        for range in [0.0, 1e-6, 0.01, 0.15, 0.43, 1.0, 3.0, 100.0] {
            let (terms, worst) = sup_error(range, z_max);
            eprintln!("H = {range}: {terms} terms, {worst:.1e}");
            assert!(worst < 1e-10, "H = {range}: {worst:e}");
            assert!(range > 0.0 || terms == 1, "a flat surface needs the constant alone");
        }
    }

    #[test]
    fn bessel_functions_have_their_tabulated_values() {
        // Abramowitz & Stegun, tables 9.1 and 9.2: J₀(1), J₁(1), J₂(1); J₀(10), J₁(10).
        let [one, ten] = [1.0, 10.0].map(|x| bessel(x, 3));
        for (value, exact) in
            one.iter().zip([0.765_197_686_557_967, 0.440_050_585_744_934, 0.114_903_484_931_900])
        {
            assert!((value - exact).abs() < 1e-14, "{value} {exact}");
        }
        assert!(
            (ten[0] + 0.245_935_764_451_348).abs() < 1e-14 && (ten[1] - 0.043_472_746_168_862).abs() < 1e-14
        );
    }
}
