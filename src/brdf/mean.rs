//! Mean over coherence areas in f64, by a direct sum over the samples. See [`crate::spectra::power`] for the formula.

use super::seen_part::SeenPart;
use super::spread::{CUT, NEAREST, Spread};
use crate::filter::Covariance;
use crate::optics::coherence::SUNLIGHT_LENGTH;
use crate::optics::geometry::Pair;
use crate::optics::reflectance::Reflectance;
use crate::spectra::power::{Beyond, Blur};
use crate::surface::HeightField;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;

/// Mean response of a surface.
#[derive(Clone, Debug)]
pub struct MeanBrdf {
    /// Height field.
    pub field: HeightField,
    /// Standard deviation of the coherence window \[µm\], a quarter of the coherence length.
    pub sigma: f64,
    /// Continuation of the surface beyond the patch.
    pub beyond: Beyond,
    /// Reflectance of the surface.
    pub reflectance: Reflectance,
}

impl MeanBrdf {
    /// Returns the mean of copies of `field` with this `reflectance` (a number is a refractive index), in sunlight.
    pub fn in_sunlight(field: &HeightField, reflectance: impl Into<Reflectance>) -> Self {
        Self {
            field: field.clone(),
            sigma: SUNLIGHT_LENGTH / 4.0,
            beyond: Beyond::Copies,
            reflectance: reflectance.into(),
        }
    }

    /// Returns true if the samples resolve the frequency `f` \[µm⁻¹\]: beyond 1/(2dx) the response is 0.
    pub(super) fn holds(&self, f: DVec2) -> bool {
        let [dx, dy] = self.field.pixel_size();
        f.x.abs() <= 0.5 / dx && f.y.abs() <= 0.5 / dy
    }

    pub(super) fn blur(&self) -> Blur {
        Blur::of_orders(self.sigma, self.field.patch_size(), self.beyond)
    }

    /// Returns ⟨|P|²⟩/A \[µm²\] at wavenumber `q` \[µm⁻¹\] for one (u, v, w), by a direct sum over all samples for each
    /// order near the frequency.
    pub fn power(&self, uvw: DVec3, q: f64, footprint: &Covariance) -> f64 {
        let f = -uvw.truncate() * q;
        if !self.holds(f) {
            return 0.0;
        }
        let z = 2.0 * PI * q * uvw.z.abs();
        let spread = Spread::new(self.blur(), footprint, q);
        let patch = DVec2::from_array(self.field.patch_size());
        let near = |centre: f64, variance: f64, side: f64| -> Vec<i64> {
            let reach = (CUT * variance.sqrt() * side).max(NEAREST);
            ((centre * side - reach).ceil() as i64..=(centre * side + reach).floor() as i64).collect()
        };
        let columns = near(f.x, spread.xx, patch.x);
        let rows = near(f.y, spread.yy, patch.y);
        let (specular, powers) = self.order_powers(z, &columns, &rows);
        let seen = SeenPart::new(f, &spread, footprint, q);
        let blurred: f64 = powers
            .iter()
            .enumerate()
            .map(|(i, power)| {
                let m = DVec2::new(columns[i % columns.len()] as f64, rows[i / columns.len()] as f64);
                power * seen.share(m / patch) * spread.density(f - m / patch)
            })
            .sum();
        blurred + specular * Spread::new(Blur::of_coherence(self.sigma), footprint, q).density(f)
    }

    /// Returns |c_m|² at z = k|w| \[rad/µm\] by a plain sum over the samples.
    pub(super) fn order_power(&self, order: [i64; 2], z: f64) -> f64 {
        let (specular, powers) = self.order_powers(z, &[order[0]], &[order[1]]);
        if order == [0, 0] { specular } else { powers.iter().sum() }
    }

    /// Returns |c_0|², and |c_m|² for m in `columns` × `rows`, row by row, each a plain sum over the samples.
    fn order_powers(&self, z: f64, columns: &[i64], rows: &[i64]) -> (f64, Vec<f64>) {
        let field = &self.field;
        let (low, high) = field.range();
        let middle = 0.5 * (low + high);
        let samples = [field.columns(), field.rows()];
        let taper = samples.map(|n| self.taper(n));
        let phases: Vec<Vec<Complex64>> = (0..samples[1])
            .into_par_iter()
            .map(|row| field.row(row).iter().map(|h| Complex64::cis(z * (h - middle))).collect())
            .collect();
        let count = (samples[0] * samples[1]) as f64;
        let weighed = |row: usize| -> Complex64 {
            let along = phases[row].iter().zip(&taper[0]).map(|(p, t)| p * (t * t)).sum::<Complex64>();
            along * taper[1][row].powi(2)
        };
        let mean = (0..samples[1]).map(weighed).sum::<Complex64>() / count;
        let offset = if self.beyond == Beyond::Alike { mean } else { Complex64::ZERO };
        let turns = |m: i64, place: f64, side: f64| Complex64::cis(2.0 * PI * m as f64 * place / side);
        let [tx, ty] = field.patch_size();
        let along_x: Vec<Vec<Complex64>> = columns
            .par_iter()
            .map(|&m| (0..samples[0]).map(|c| turns(m, field.x(c), tx) * taper[0][c]).collect())
            .collect();
        // [column order][row] sums along x.
        let sums: Vec<Vec<Complex64>> = along_x
            .par_iter()
            .map(|twiddles| {
                let dot = |row: usize| -> Complex64 {
                    phases[row].iter().zip(twiddles).map(|(p, t)| (p - offset) * t).sum::<Complex64>()
                        * taper[1][row]
                };
                (0..samples[1]).map(dot).collect()
            })
            .collect();
        let mut powers = Vec::with_capacity(columns.len() * rows.len());
        for &my in rows {
            let along_y: Vec<Complex64> = (0..samples[1]).map(|r| turns(my, field.y(r), ty)).collect();
            for (&mx, sums) in columns.iter().zip(&sums) {
                let sum: Complex64 = sums.iter().zip(&along_y).map(|(s, t)| s * t).sum();
                let is_specular = mx == 0 && my == 0 && self.beyond == Beyond::Copies;
                powers.push(if is_specular { 0.0 } else { (sum / count).norm_sqr() });
            }
        }
        (mean.norm_sqr(), powers)
    }

    fn taper(&self, count: usize) -> Vec<f64> {
        match self.beyond {
            Beyond::Copies => vec![1.0; count],
            Beyond::Alike => {
                let window = |i: usize| 0.5 - 0.5 * (2.0 * PI * (i as f64 + 0.5) / count as f64).cos();
                let power = (0..count).map(|i| window(i).powi(2)).sum::<f64>() / count as f64;
                (0..count).map(|i| window(i) / power.sqrt()).collect()
            }
        }
    }

    /// Returns the BRDF \[sr⁻¹\] at `wavelength` \[µm\] by the direct sum, averaged over `footprint`, without a limit of energy; 0 below the horizon.
    pub fn brdf(&self, pair: &Pair, wavelength: f64, footprint: &Covariance) -> f64 {
        if !pair.above_horizon() {
            return 0.0;
        }
        let power = self.power(pair.uvw(), 1.0 / wavelength, footprint);
        self.reflectance.cosine_weighted(pair, wavelength, 1.0, power) / pair.light.z
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::optics::coherence::Coherence;
    use crate::optics::geometry::direction;
    use crate::optics::reference::Reference;

    pub fn rough() -> HeightField {
        let heights = (0..24 * 20).map(|i| 0.15 * ((i * 37 % 101) as f64 * 0.7).sin()).collect();
        HeightField::new(24, 20, [0.1, 0.11], heights).unwrap()
    }

    pub const DIRECTIONS: [((f64, f64), (f64, f64)); 4] = [
        ((30.0, 20.0), (40.0, 170.0)),
        ((10.0, 0.0), (70.0, 80.0)),
        ((60.0, 5.0), (60.0, 185.0)),
        ((30.0, 0.0), (31.0, 179.0)),
    ];

    pub fn pair((light, view): ((f64, f64), (f64, f64))) -> Pair {
        Pair::new(direction(light.0, light.1), direction(view.0, view.1))
    }

    #[test]
    fn the_mean_does_not_depend_on_where_the_patch_begins() {
        let field = rough();
        let moved = field.moved(7, 3);
        let of = |field: &HeightField| {
            let mean = MeanBrdf {
                field: field.clone(),
                sigma: 0.75,
                beyond: Beyond::Copies,
                reflectance: 1.5.into(),
            };
            DIRECTIONS.map(|d| mean.brdf(&pair(d), 0.5, &Covariance::default()))
        };
        for (a, b) in of(&field).into_iter().zip(of(&moved)) {
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn a_footprint_is_the_average_over_its_directions() {
        let field = rough();
        let mean =
            MeanBrdf { field: field.clone(), sigma: 1.0, beyond: Beyond::Copies, reflectance: 1.5.into() };
        let footprint = Covariance { uu: 9e-4, uv: 2e-4, vv: 4e-4 };
        let uvw = DVec3::new(0.3, -0.2, -1.6);
        // A grid of directions with the weights of the normal distribution.
        let (det, mut sum, mut norm) = (footprint.uu * footprint.vv - footprint.uv * footprint.uv, 0.0, 0.0);
        for i in -40..=40 {
            for j in -40..=40 {
                let d = DVec2::new(f64::from(i) * 0.004, f64::from(j) * 0.003);
                let r2 = (footprint.vv * d.x * d.x - 2.0 * footprint.uv * d.x * d.y
                    + footprint.uu * d.y * d.y)
                    / det;
                let weight = (-0.5 * r2).exp();
                norm += weight;
                sum += weight * mean.power(uvw + d.extend(0.0), 2.0, &Covariance::default());
            }
        }
        let blurred = mean.power(uvw, 2.0, &footprint);
        assert!((sum / norm / blurred - 1.0).abs() < 1e-4, "{} {blurred}", sum / norm);
    }

    #[test]
    fn the_mean_over_all_windows_is_what_many_windows_tend_to() {
        let field = rough();
        let coherence = Coherence::Gaussian { length: 3.0 };
        let mean =
            MeanBrdf { field: field.clone(), sigma: 0.75, beyond: Beyond::Copies, reflectance: 1.5.into() };
        for directions in DIRECTIONS {
            let pair = pair(directions);
            let exact = mean.brdf(&pair, 0.55, &Covariance::default());
            let error = |n: u32| {
                let windows = Reference::new(&field, coherence, [n, n], 1.5).brdf(&pair, 0.55);
                (windows / exact - 1.0).abs()
            };
            let errors = [1, 2, 4, 8].map(error);
            // The windows are truncated at 7σ, 2e-11 of their peak, and orders at 1e-10 of theirs.
            assert!(errors[3] < 1e-8, "{directions:?}: {errors:?}");
            assert!(errors[0] > 1e-3, "one window already gives the mean: {errors:?}");
        }
    }
}
