//! Part of the small-slope factor that a table holds, because it depends on the wavelength.
//!
//! The kernel |B|² depends on both directions, and a table has room for (u, v, w) alone. The table holds the mean of |B|²
//! over the pairs of directions that share (u, v, w), divided for each of X, Y and Z by that of one refractive index
//! ([`IndexTriple`]). The factor in front of the table is |B|² of these indices at the pixel's own directions. Colours of
//! metals err by 0.3 to 0.6 % in daylight and by 0.5 to 1.1 % in light of 15 nm standard deviation.

use super::LARGEST_W;
use crate::optics::factor::IndexTriple;
use crate::optics::reflectance::Reflectance;
use crate::optics::small_slope::mean_intensity;
use crate::optics::spectrum::{LONGEST, SHORTEST};
use crate::optics::theory::Theory;
use rayon::prelude::*;

/// Means of |B|² of one surface.
pub struct HeldFactor {
    // [wavenumber][w][uv]
    means: Vec<Vec<f32>>,
    // [channel][w][uv], of the indices.
    indices: [Vec<f32>; 3],
}

impl HeldFactor {
    /// Added to both means of a ratio, so that it tends to 1 where both are below it, less than a hundredth of glass at
    /// normal incidence: TM light has a mean of 0 at Brewster's angle, which depends on the wavelength.
    const DARK: f64 = 3e-4;
    /// Steps of |(u, v)| and |w| over 0 … 2.
    const STEPS: usize = 96;
    /// Wavenumbers over the visible range, ends included: as far apart as the rows of tables of metals.
    const WAVENUMBERS: usize = 48;

    /// Returns what a table of `reflectance` holds; `None` if one index serves all wavelengths, or by Stam's theory.
    pub fn new(reflectance: &Reflectance) -> Option<Self> {
        if reflectance.theory() == Theory::Stam || reflectance.index().is_some() {
            return None;
        }
        let at = |i: usize| LARGEST_W * i as f64 / Self::STEPS as f64;
        let polarisation = reflectance.polarisation();
        let table = |index| -> Vec<f32> {
            let row = |j: usize| {
                (0..=Self::STEPS).map(move |i| mean_intensity(index, at(i), at(j), polarisation) as f32)
            };
            (0..=Self::STEPS).flat_map(row).collect()
        };
        let (first, last) = (1.0 / LONGEST, 1.0 / SHORTEST);
        let wavenumber = |i: usize| first + (last - first) * i as f64 / (Self::WAVENUMBERS - 1) as f64;
        let means =
            (0..Self::WAVENUMBERS).into_par_iter().map(|i| table(reflectance.index_at(1.0 / wavenumber(i))));
        let indices = IndexTriple::of(reflectance).complex().map(table);
        Some(Self { means: means.collect(), indices })
    }

    /// Returns the mean, raised by [`Self::DARK`], at a wavenumber \[µm⁻¹\], |(u, v)| and |w|.
    pub fn mean(&self, wavenumber: f64, uv: f64, w: f64) -> f64 {
        let (first, last) = (1.0 / LONGEST, 1.0 / SHORTEST);
        let place = (wavenumber - first) / (last - first) * (Self::WAVENUMBERS - 1) as f64;
        let place = place.clamp(0.0, (Self::WAVENUMBERS - 1) as f64);
        let left = (place as usize).min(Self::WAVENUMBERS - 2);
        let share = place - left as f64;
        let [below, above] = [left, left + 1].map(|i| interpolated(&self.means[i], uv, w));
        below + share * (above - below) + Self::DARK
    }

    /// Returns the factors of X, Y and Z after the sums: one over the mean of the indices, raised likewise.
    pub fn scales(&self, uv: f64, w: f64) -> [f64; 3] {
        [0, 1, 2].map(|channel| (interpolated(&self.indices[channel], uv, w) + Self::DARK).recip())
    }
}

/// Interpolates a table over |w| and |(u, v)|.
fn interpolated(table: &[f32], uv: f64, w: f64) -> f64 {
    let place = |x: f64| {
        let place = (x / LARGEST_W).clamp(0.0, 1.0) * HeldFactor::STEPS as f64;
        let left = (place as usize).min(HeldFactor::STEPS - 1);
        (left, place - left as f64)
    };
    let ((i, s), (j, t)) = (place(uv), place(w));
    let row = |j: usize| {
        let [a, b] = [i, i + 1].map(|i| f64::from(table[j * (HeldFactor::STEPS + 1) + i]));
        a + s * (b - a)
    };
    let (below, above) = (row(j), row(j + 1));
    below + t * (above - below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::geometry::Pair;
    use crate::optics::material::Material;
    use crate::optics::polarisation::Polarisation;
    use crate::optics::small_slope::intensity;
    use crate::optics::spectrum::{Illuminant, MIDDLE};
    use crate::random::Random;
    use glam::DVec3;

    /// Returns pairs of directions whose cosines are above 0.05.
    fn pairs(count: usize) -> Vec<Pair> {
        let mut random = Random::new(3);
        let mut any = || {
            let (z, turn) = (0.05 + 0.95 * random.share(), std::f64::consts::TAU * random.share());
            let across = (1.0 - z * z).sqrt();
            DVec3::new(across * turn.cos(), across * turn.sin(), z)
        };
        (0..count).map(|_| Pair::new(any(), any())).collect()
    }

    /// Spectra: daylight, and daylight through filters of 15 nm standard deviation.
    fn filters() -> Vec<Box<dyn Fn(f64) -> f64>> {
        let narrow = |centre: f64| -> Box<dyn Fn(f64) -> f64> {
            Box::new(move |wavelength: f64| (-0.5 * ((wavelength - centre) / 0.015).powi(2)).exp())
        };
        let centres = [0.43, 0.47, 0.53, 0.58, 0.62, 0.66];
        std::iter::once(Box::new(|_| 1.0) as Box<dyn Fn(f64) -> f64>).chain(centres.map(narrow)).collect()
    }

    /// Returns the relative L2 errors of colours in daylight and in narrow light, where `held` approximates |B|² of X,
    /// Y and Z at a wavelength.
    fn errors(reflectance: &Reflectance, held: &dyn Fn(&Pair, f64) -> DVec3) -> [f64; 2] {
        let wavelengths: Vec<f64> = (0..81).map(|i| 0.38 + 0.005 * f64::from(i)).collect();
        let luminance = Illuminant::D65.luminance();
        let weights: Vec<DVec3> = wavelengths
            .iter()
            .map(|wavelength| Illuminant::D65.weight(1e3 * wavelength, luminance))
            .collect();
        let mut sums = [[0.0; 2]; 2];
        for pair in pairs(150) {
            let light = (pair.light.z * pair.view.z).powi(2);
            let exact: Vec<f64> = wavelengths
                .iter()
                .map(|wavelength| intensity(reflectance.index_at(*wavelength), &pair, Polarisation::None))
                .collect();
            let approximate: Vec<DVec3> =
                wavelengths.iter().map(|wavelength| held(&pair, *wavelength)).collect();
            for (number, filter) in filters().iter().enumerate() {
                let [mut right, mut found] = [DVec3::ZERO; 2];
                for (i, wavelength) in wavelengths.iter().enumerate() {
                    let weight = weights[i] * filter(*wavelength);
                    right += weight * exact[i];
                    found += weight * approximate[i];
                }
                let sum = &mut sums[number.min(1)];
                sum[0] += light * (found - right).length_squared();
                sum[1] += light * right.length_squared();
            }
        }
        sums.map(|[error, all]| (error / all).sqrt())
    }

    #[test]
    fn the_mean_over_pairs_keeps_colours_of_metals_that_the_half_vector_does_not() {
        for name in ["gold", "copper", "silver", "aluminium", "nickel", "silicon"] {
            let reflectance = Reflectance::of_material(Material::from_name_or_file(name).unwrap(), None);
            let factor = HeldFactor::new(&reflectance).unwrap();
            let indices = IndexTriple::of(&reflectance);
            let of_mean = |pair: &Pair, wavelength: f64| {
                let (uv, w) = (pair.uvw().truncate().length(), pair.uvw().z.abs());
                let ratio = factor.mean(1.0 / wavelength, uv, w) * DVec3::from_array(factor.scales(uv, w));
                ratio * DVec3::from_array(indices.intensity(pair))
            };
            // The way of Stam's factor: R at the half vector, over that of one wavelength.
            let of_half = |pair: &Pair, wavelength: f64| {
                let [r, m] = [wavelength, MIDDLE].map(|l| reflectance.at(l, pair.cos_half_angle()));
                DVec3::splat(intensity(reflectance.index_at(MIDDLE), pair, Polarisation::None) * r / m)
            };
            let ([day, narrow], [day_half, narrow_half]) =
                (errors(&reflectance, &of_mean), errors(&reflectance, &of_half));
            eprintln!(
                "{name}: daylight {day:.4}, narrow light {narrow:.4}; by the half vector {day_half:.3}, {narrow_half:.3}"
            );
            assert!(day < 0.012 && narrow < 0.025, "{name}: {day} {narrow}");
            assert!(narrow_half > 3.0 * narrow, "{name}: {narrow_half} by the half vector");
        }
    }
}
