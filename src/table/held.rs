//! Part of the small-slope factor that a table holds, because it depends on the wavelength.
//!
//! |B|² depends on both directions, and a table has room for (u, v, w) alone. The table holds the mean of |B|² over the pairs of directions that share (u, v, w), divided for each of X, Y and Z by that
//! of one refractive index ([`IndexTriple`]); the factor in front of the table is |B|² of these indices at the pixel's own directions. Colours of metals err by about 1 %
//! (`colours_of_metals_keep_the_tolerance`).

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
    /// Added to both means of a ratio, so that it tends to 1 where both are below it, less than a hundredth of glass at normal incidence: TM light has a mean of 0 at Brewster's angle, which depends on the wavelength.
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
