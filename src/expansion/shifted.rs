//! An expansion about another z: e^{izh} = e^{i z₀ h} e^{i(z−z₀)h}, so b_n e^{i z₀ h} with c_n(z − z₀). Near z₀ few terms do, and
//! the Taylor series has nothing to cancel.

use super::Expansion;
use rustfft::num_complex::Complex64;

/// `expansion`, of heights of half range `half_range` \[µm\], about `centre` for |z − `centre`| ≤ `reach` \[rad/µm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shifted<E> {
    /// The expansion about z = 0.
    pub expansion: E,
    /// a \[µm\].
    pub half_range: f64,
    /// z₀ \[rad/µm\].
    pub centre: f64,
    /// The largest |z − z₀| \[rad/µm\].
    pub reach: f64,
}

impl<E: Expansion> Expansion for Shifted<E> {
    fn basis(&self, n: usize, t: f64) -> Complex64 {
        Complex64::cis(self.centre * self.half_range * t) * self.expansion.basis(n, t)
    }

    fn coefficients(&self, z: f64, out: &mut [Complex64]) {
        self.expansion.coefficients(z - self.centre, out);
    }

    fn most_terms(&self) -> usize {
        self.expansion.most_terms()
    }

    /// The bound over the whole reach, whatever `z`.
    fn truncation_bound(&self, _z: f64, terms: usize) -> f64 {
        self.expansion.truncation_bound(self.reach, terms)
    }

    fn rounding_bound(&self, _z: f64, roundoff: f64) -> f64 {
        self.expansion.rounding_bound(self.reach, roundoff)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::chebyshev::Chebyshev;
    use crate::expansion::taylor::Taylor;

    fn worst(family: &dyn Expansion, half_range: f64, [from, to]: [f64; 2], terms: usize) -> f64 {
        let mut c = vec![Complex64::ZERO; terms];
        (0..2000).fold(0.0, |worst, i| {
            let z = from + (to - from) * (f64::from(i) * 0.618_034).fract();
            let t = 2.0 * (f64::from(i) * 0.754_878).fract() - 1.0;
            family.coefficients(z, &mut c);
            let sum: Complex64 = c.iter().enumerate().map(|(n, c)| c * family.basis(n, t)).sum();
            worst.max((sum - Complex64::cis(z * half_range * t)).norm())
        })
    }

    #[test]
    fn the_bounds_hold_about_another_z_and_below_it_as_above_and_a_fifth_of_them_does_not() {
        let (half_range, centre, reach) = (0.5, 20.0, 3.0);
        let range = [centre - reach, centre + reach];
        let taylor = Shifted { expansion: Taylor { half_range }, half_range, centre, reach };
        let chebyshev = Shifted { expansion: Chebyshev { half_range }, half_range, centre, reach };
        for terms in [3, 6, 9] {
            for family in [&taylor as &dyn Expansion, &chebyshev] {
                let (bound, found) =
                    (family.truncation_bound(centre, terms), worst(family, half_range, range, terms));
                assert!(
                    found <= bound * 1.0001 && found > bound / 5.0,
                    "{terms} terms: {found:e} of {bound:e}"
                );
            }
        }
    }
}
