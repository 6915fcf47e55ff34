//! Expansions over a band of z whose coefficients are real polynomials, the same for every band, so that a shader computes them
//! in a few steps instead of reading them.
//!
//! With z = z₀ + d Δ, 0 ≤ d ≤ 1, e^{izh} = e^{i z₀ h} e^{idy} and y = Δh. Both families have c_0 = b_0 = 1 and c_n = 0 at d = 0, so that
//! nothing errs at the lower end of a band: toward z = 0 less and less is scattered, the BRDF divides by w², and whatever an
//! expansion left there of a height would be lifted without end.
//!
//! - [`Series::Powers`], the Taylor series in the height about z₀: c_n = dⁿ, b_n = (iy)ⁿ/n!.
//! - [`Series::Polynomials`]: c_n = d T_{n−1}(2d − 1) with Chebyshev's polynomials T. Given these, the b_n that leave least of each height,
//!   in the squares over d weighted as Chebyshev's are, are the Chebyshev coefficients of (e^{idy} − 1)/d, and more terms leave those that
//!   there are as they are.

use super::Expansion;
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;
use std::sync::Arc;

/// Most terms: bands are there for fewer than a dozen.
const MOST: usize = 32;
/// Intervals of the table of b_n over t; linear between, to (2/8192)²/8 · y².
const INTERVALS: usize = 1 << 13;

/// Which polynomials of the place in the band the coefficients are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Series {
    /// Powers.
    Powers,
    /// The place times Chebyshev's polynomials.
    Polynomials,
}

impl Series {
    /// c_0 … c_{len−1} at the place `d` ∈ \[0, 1\] into `out`.
    fn evaluate(self, d: f64, out: &mut [Complex64]) {
        let x = 2.0 * d - 1.0;
        // The one before last, and the last: of the polynomials, d T_{−1} = d T_1 stands where 1 does.
        let (mut before, mut last) = (d * x, d);
        for (n, slot) in out.iter_mut().enumerate() {
            if n == 0 {
                *slot = Complex64::ONE;
                continue;
            }
            *slot = last.into();
            let next = match self {
                Self::Powers => last * d,
                Self::Polynomials => 2.0 * x * last - before,
            };
            (before, last) = (last, next);
        }
    }
}

/// The expansion over one band of z.
#[derive(Clone, Debug)]
pub struct Anchored {
    series: Series,
    /// z₀ a.
    start: f64,
    /// Δa: y at t = 1.
    reach: f64,
    z_start: f64,
    z_width: f64,
    /// b_n over t, without e^{i z₀ h}: `[n][entry]`, shared by all bands.
    table: Arc<Vec<Vec<Complex64>>>,
}

impl Anchored {
    /// One expansion for each of `count` equal bands of 0 … `z_max` \[rad/µm\], over heights of half range `half_range` \[µm\].
    pub fn bands(series: Series, half_range: f64, z_max: f64, count: usize) -> Vec<Self> {
        let z_width = z_max / count as f64;
        let reach = z_width * half_range;
        let table = Arc::new(table(series, reach));
        (0..count)
            .map(|band| {
                let z_start = band as f64 * z_width;
                Self { series, start: z_start * half_range, reach, z_start, z_width, table: table.clone() }
            })
            .collect()
    }
}

/// b_n at the table's places of t, for y = `reach`·t: `[n][entry]`.
fn table(series: Series, reach: f64) -> Vec<Vec<Complex64>> {
    // As many as the Chebyshev coefficients that are kept, twice, and what turns by `reach` over the band.
    let points = 2 * MOST + reach as usize;
    let angles: Vec<f64> = (0..points).map(|q| (q as f64 + 0.5) / points as f64 * PI).collect();
    let cosines: Vec<Vec<f64>> =
        (0..MOST - 1).map(|m| angles.iter().map(|angle| (m as f64 * angle).cos()).collect()).collect();
    let column = |entry: usize| -> Vec<Complex64> {
        let y = reach * (2.0 * entry as f64 / INTERVALS as f64 - 1.0);
        match series {
            Series::Powers => {
                let mut power = Complex64::ONE;
                let mut next = |n: usize| {
                    let own = power;
                    power *= Complex64::new(0.0, y) / (n as f64 + 1.0);
                    own
                };
                (0..MOST).map(&mut next).collect()
            }
            Series::Polynomials => {
                let slopes: Vec<Complex64> = angles.iter().map(|a| slope((1.0 + a.cos()) / 2.0, y)).collect();
                let coefficient = |(m, cosines): (usize, &Vec<f64>)| {
                    let twice = if m == 0 { 1.0 } else { 2.0 };
                    let sum: Complex64 =
                        slopes.iter().zip(cosines).map(|(slope, cosine)| slope * cosine).sum();
                    sum * (twice / points as f64)
                };
                std::iter::once(Complex64::ONE).chain(cosines.iter().enumerate().map(coefficient)).collect()
            }
        }
    };
    let columns: Vec<Vec<Complex64>> = (0..=INTERVALS).into_par_iter().map(column).collect();
    (0..MOST).map(|n| columns.iter().map(|column| column[n]).collect()).collect()
}

/// (e^{idy} − 1)/d with every digit, however small d is.
fn slope(d: f64, y: f64) -> Complex64 {
    let half = d * y / 2.0;
    let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
    Complex64::new(0.0, y * sinc) * Complex64::cis(half)
}

impl Expansion for Anchored {
    fn basis(&self, n: usize, t: f64) -> Complex64 {
        let place = (t.clamp(-1.0, 1.0) + 1.0) * 0.5 * INTERVALS as f64;
        let left = (place as usize).min(INTERVALS - 1);
        let row = &self.table[n];
        Complex64::cis(self.start * t) * (row[left] + (row[left + 1] - row[left]) * (place - left as f64))
    }

    fn coefficients(&self, z: f64, out: &mut [Complex64]) {
        self.series.evaluate((z - self.z_start) / self.z_width, out);
    }

    fn series(&self) -> Option<Series> {
        Some(self.series)
    }

    fn most_terms(&self) -> usize {
        MOST
    }

    /// The bound over the whole band, whatever `z`. Of powers it is Lagrange's remainder yᴷ/K!. Of the polynomials 8 Σ_{j≥K} (y/4)ʲ/j!:
    /// (e^{idy} − 1)/d = iy ∫ e^{isdy} ds over 0 … 1 has the Chebyshev coefficients iy ∫ 2 iᵐ e^{isy/2} J_m(sy/2) ds (Jacobi–Anger), and
    /// |J_m(x)| ≤ (x/2)ᵐ/m! (Abramowitz & Stegun 9.1.62) leaves 8 (y/4)^{m+1}/(m+1)! of each.
    fn truncation_bound(&self, _z: f64, terms: usize) -> f64 {
        /// Beyond, the sum has no digits left for any band.
        const TAIL: usize = 400;
        let (y, factor, last) = match self.series {
            Series::Powers => (self.reach, 1.0, terms),
            Series::Polynomials => (self.reach / 4.0, 8.0, terms + TAIL),
        };
        let mut term = 1.0;
        let mut sum = 0.0;
        for j in 0..=last {
            if j > 0 {
                term *= y / j as f64;
            }
            if j >= terms {
                sum += term;
            }
        }
        factor * sum
    }

    /// |c_n| ≤ 1, and Σ|b_n| ≤ 1 + e^y of powers, whose sum is at most 1 + 8 e^{y/4} of the polynomials: half a unit each.
    fn rounding_bound(&self, _z: f64, roundoff: f64) -> f64 {
        let sum = match self.series {
            Series::Powers => self.reach.exp(),
            Series::Polynomials => 1.0 + 8.0 * (self.reach / 4.0).exp(),
        };
        2.0 * roundoff * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn the_bounds_hold_in_every_band_and_a_twentieth_of_them_does_not() {
        let (half_range, z_max, count) = (0.3, 33.0, 4);
        for series in [Series::Powers, Series::Polynomials] {
            let bands = Anchored::bands(series, half_range, z_max, count);
            for (band, family) in bands.iter().enumerate() {
                let range = [band, band + 1].map(|edge| z_max * edge as f64 / count as f64);
                for terms in [3, 6, 9] {
                    let (bound, found) =
                        (family.truncation_bound(range[1], terms), worst(family, half_range, range, terms));
                    assert!(
                        found <= bound * 1.0001 + 1e-6 && found > bound / 20.0,
                        "{series:?}, {terms} terms in band {band}: {found:e} of {bound:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_polynomials_leave_less_than_the_powers_and_neither_leaves_anything_where_a_band_begins() {
        let (half_range, z_max) = (0.215, 33.0);
        let [powers, polynomials] = [Series::Powers, Series::Polynomials]
            .map(|series| Anchored::bands(series, half_range, z_max, 4).swap_remove(1));
        let range = [z_max / 4.0, z_max / 2.0];
        for terms in [4, 6] {
            let [coarse, fine] = [&powers, &polynomials].map(|f| worst(f, half_range, range, terms));
            assert!(10.0 * fine < coarse, "{terms} terms: {fine:e}, {coarse:e}");
        }
        for family in [&powers, &polynomials] {
            let at_start = worst(family, half_range, [range[0]; 2], 4);
            assert!(at_start < 1e-12, "{at_start:e}");
        }
    }

    #[test]
    fn each_pair_of_polynomials_follows_from_the_one_before_as_the_shader_makes_them() {
        for d in [0.0, 0.13, 0.5, 0.77, 1.0] {
            let x: f64 = 2.0 * d - 1.0;
            let mut c = [Complex64::ZERO; 8];
            Series::Polynomials.evaluate(d, &mut c);
            let t = [1.0, x, 2.0 * x * x - 1.0, 4.0 * x.powi(3) - 3.0 * x];
            for (m, t) in t.iter().enumerate() {
                assert!((c[m + 1] - d * t).norm() < 1e-12, "{m} at {d}");
            }
            Series::Powers.evaluate(d, &mut c);
            for (n, c) in c.iter().enumerate() {
                assert!((c - d.powi(n as i32)).norm() < 1e-12, "{n} at {d}");
            }
        }
    }
}
