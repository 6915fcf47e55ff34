//! The Taylor expansion of \[Single 2014\] C.1, about the middle height: b_n = tⁿ, c_n = (i z a)ⁿ/n!.

use super::Expansion;
use crate::error::{Error, Remedy, Result};
use rustfft::num_complex::Complex64;

/// Unit roundoff of f32, the type of the stored layers and of their sums.
pub const F32_ROUNDOFF: f64 = 5.960_464_477_539_063e-8;

/// Largest number of terms: beyond it rounding of f32 dominates by far.
pub const MAX_TERMS: usize = 64;

/// Taylor expansion over heights of half range `half_range` \[µm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taylor {
    /// a, half the range of heights \[µm\].
    pub half_range: f64,
}

impl Expansion for Taylor {
    fn basis(&self, n: usize, t: f64) -> Complex64 {
        t.powi(n as i32).into()
    }

    fn coefficients(&self, z: f64, out: &mut [Complex64]) {
        let step = Complex64::new(0.0, z * self.half_range);
        let mut c = Complex64::ONE;
        for (n, slot) in out.iter_mut().enumerate() {
            *slot = c;
            c = c * step / (n as f64 + 1.0);
        }
    }

    fn most_terms(&self) -> usize {
        MAX_TERMS
    }

    fn truncation_bound(&self, z: f64, terms: usize) -> f64 {
        if terms == 0 { 1.0 } else { tight_bound(z * self.half_range, terms - 1) }
    }

    fn rounding_bound(&self, z: f64, roundoff: f64) -> f64 {
        rounding_bound(z * self.half_range, roundoff)
    }
}

/// Returns |x|^{N+1}/(N+1)!, factor by factor so that neither the power nor the factorial overflows separately.
fn first_dropped_term(x: f64, order: usize) -> f64 {
    (1..=order + 1).fold(1.0, |term, n| term * x.abs() / n as f64)
}

/// Returns the bound of \[Single 2014\] C.4 on |e^{ix} − Σ_{n≤N} (ix)ⁿ/n!|: e^{|x|} |x|^{N+1}/(N+1)!. Its factor M = e^X belongs to the
/// real exponential.
pub fn thesis_bound(x: f64, order: usize) -> f64 {
    x.abs().exp() * first_dropped_term(x, order)
}

/// Returns the tight bound on the same error: |x|^{N+1}/(N+1)!, because every derivative of e^{ix} has modulus 1 (Lagrange's remainder).
pub fn tight_bound(x: f64, order: usize) -> f64 {
    first_dropped_term(x, order)
}

/// Returns the error of rounding to unit roundoff `roundoff`, relative to the specular peak: the terms add up to e^{|x|} before they
/// cancel.
pub fn rounding_bound(x: f64, roundoff: f64) -> f64 {
    roundoff * x.abs().exp()
}

/// Returns the smallest number of terms for which truncation and rounding together stay within `tolerance`, for arguments up to `x` =
/// z_max·a and a storage of unit roundoff `roundoff`.
///
/// # Errors
/// Rounding that exceeds the tolerance for any number of terms.
pub fn terms_for(x: f64, tolerance: f64, roundoff: f64) -> Result<usize> {
    let rounding = rounding_bound(x, roundoff);
    if rounding > tolerance {
        return Err(Error::limit(
            format!(
                "the Taylor expansion cannot reach {tolerance:.1e} here: its terms grow to e^{x:.1} = {:.1e} before they \
                 cancel, and 32-bit floats leave {rounding:.1e} of that",
                x.exp()
            ),
            [Remedy::OptimalBasis, Remedy::TimesTolerance(rounding / tolerance), Remedy::LevelPlane],
        ));
    }
    let mut term = 1.0;
    for terms in 1..=MAX_TERMS.max((3.0 * x) as usize + 32) {
        term *= x.abs() / terms as f64;
        if term + rounding <= tolerance {
            return Ok(terms);
        }
    }
    Err(Error::limit(
        format!("no number of Taylor terms leaves room for rounding within {tolerance:.1e}"),
        [Remedy::OptimalBasis, Remedy::LargerTolerance],
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use std::f64::consts::PI;

    fn partial_sum(x: f64, order: usize) -> Complex64 {
        let mut c = vec![Complex64::ZERO; order + 1];
        Taylor { half_range: 1.0 }.coefficients(x, &mut c);
        c.iter().sum()
    }

    #[test]
    fn the_thesis_bound_gives_the_thesis_figures() {
        // The thesis rounds its bounds up to three decimals, as a bound must be: 2.9942e-4 is printed as 2.9950e-4.
        for (order, printed, unit) in [(20, 2.9950, 1e-4), (25, 8.8150, 1e-8), (30, 1.0050, 1e-11)] {
            let bound = thesis_bound(1.5 * PI, order) / unit;
            assert_eq!(format!("{:.4}", (bound * 1e3).ceil() / 1e3), format!("{printed:.4}"));
        }
    }

    #[test]
    fn the_tight_bound_holds_and_a_tenth_of_it_does_not() {
        let mut random = Random::new(7);
        let mut uniform = || random.share();
        let mut beyond_a_tenth = 0;
        for _ in 0..10_000 {
            let x = (uniform() * 2.0 - 1.0) * 12.0;
            let order = (uniform() * 40.0) as usize;
            let error = (partial_sum(x, order) - Complex64::cis(x)).norm();
            // The sum itself is only good to the rounding of its largest term.
            let rounding = 4.0 * f64::EPSILON * x.abs().exp();
            assert!(error <= tight_bound(x, order) + rounding, "x = {x}, N = {order}");
            if error > tight_bound(x, order) / 10.0 + rounding {
                beyond_a_tenth += 1;
            }
        }
        assert!(beyond_a_tenth > 1000, "a tenth of the bound was exceeded only {beyond_a_tenth} times");
    }

    #[test]
    fn the_number_of_terms_is_the_smallest_and_follows_the_height() {
        // Height range, tolerance, terms of the tight centred bound (|w| ≤ 2, λ ≥ 0.38 µm).
        for (range, tolerance, terms) in [(0.15, 1e-4, 13), (0.30, 1e-3, 18), (0.50, 1e-3, 27)] {
            let x = 4.0 * PI / 0.38 * range / 2.0;
            assert_eq!(terms_for(x, tolerance, 0.0).unwrap(), terms, "H = {range}");
            assert!(tight_bound(x, terms - 1) <= tolerance && tight_bound(x, terms - 2) > tolerance);
        }
    }

    #[test]
    fn heights_that_32_bit_floats_cannot_hold_are_refused_with_the_reason() {
        let x = 4.0 * PI / 0.38 * 0.41;
        let message = terms_for(x, 1e-2, F32_ROUNDOFF).unwrap_err().to_string();
        assert!(message.contains("32-bit"), "{message}");
        assert!(terms_for(4.0 * PI / 0.38 * 0.215, 1e-3, F32_ROUNDOFF).is_ok());
    }
}
