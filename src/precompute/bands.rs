//! How 0 … z_max is split into equal bands, each with functions and layers of its own: a band needs fewer terms, so a
//! wavelength fewer reads, for more layers to make and to hold.

use super::layers::{Aim, Settings};
use crate::expansion::chebyshev::Chebyshev;
use crate::expansion::heights::Heights;
use crate::expansion::optimal::Optimal;
use crate::expansion::shifted::Shifted;
use crate::expansion::taylor::{F32_ROUNDOFF, Taylor, rounding_bound};
use crate::expansion::{Basis, Expansion};
use crate::surface::HeightField;
use rayon::prelude::*;

/// Numbers of bands that are tried: close enough to each other that the best of them is near the best there is.
const CANDIDATES: [usize; 8] = [2, 3, 4, 6, 8, 12, 16, 20];
/// Most layers that more than one band may take: at 65 µm of coherence and a tolerance of 1e-2 they are 2 GiB.
const MOST_LAYERS: usize = 24;
/// Most pairs of terms that are looked at for a single band; more is left to the audit.
const MOST_PAIRS: usize = 16;
/// Relative intensity errors of single directions are about this many times larger than an expansion's amplitude error
/// relative to the scattered light: twice for the square, and the faint directions. The audit decides; this only chooses
/// where it begins.
const RESIDUAL_PART: f64 = 0.5;

/// An expansion in each of some equal bands of z.
pub(super) struct Bands {
    /// The functions of each band, from z = 0 up.
    pub families: Vec<Box<dyn Expansion>>,
    /// Whether every function is real.
    pub real: bool,
    /// Pairs of terms of the deep bands; the others have one less.
    pub pairs: usize,
    /// Bands, from z = 0 up, that take all `pairs`: where little is scattered, an error counts for more.
    pub deep: usize,
}

impl Bands {
    /// One band with one pair of terms.
    fn single(families: Vec<Box<dyn Expansion>>, basis: Basis) -> Self {
        Self { families, real: basis.is_real(), pairs: 1, deep: 1 }
    }

    /// Layers of all bands.
    pub fn layers(&self) -> usize {
        (self.pairs - 1) * self.families.len() + self.deep
    }

    /// Adds the least that can make an error smaller: terms in twice as many deep bands.
    pub fn deepen(&mut self) {
        if self.deep == self.families.len() {
            self.pairs += 1;
            self.deep = 1;
        } else {
            self.deep = (2 * self.deep).min(self.families.len());
        }
    }

    /// The bands for `settings`: one where terms are named or transforms are to be few, or as many as make the pairs of terms
    /// of a wavelength few, in at most `room` layers.
    pub fn choose(field: &HeightField, settings: &Settings, z_max: f64, room: usize) -> Self {
        let heights = Heights::of(field);
        let basis = settings.basis;
        let single = families(&heights, basis, z_max, 1);
        if settings.terms.is_some() || settings.aim == Aim::FewTransforms {
            return Self::single(single, basis);
        }
        let allowed = RESIDUAL_PART * settings.budget.expansion;
        let x = z_max * heights.half_range;
        let cancels = basis == Basis::Taylor && rounding_bound(x, F32_ROUNDOFF) > settings.budget.expansion;
        let pairs_of_one = if cancels {
            usize::MAX
        } else {
            let left = heights.residuals(single[0].as_ref(), [0.0, z_max], MOST_PAIRS);
            left.iter().position(|&error| error <= allowed).map_or(MOST_PAIRS, |p| p + 1)
        };
        let mut best: Option<Self> = None;
        for count in CANDIDATES {
            let most = best.as_ref().map_or(pairs_of_one, |b| b.common());
            if most <= 1 {
                break;
            }
            let families = families(&heights, basis, z_max, count);
            let width = z_max / count as f64;
            let most_pairs = MOST_LAYERS.min(room) / count + 1;
            let needed: Vec<usize> = families
                .par_iter()
                .enumerate()
                .map(|(band, family)| {
                    let range = [band as f64, band as f64 + 1.0].map(|edge| edge * width);
                    let left = heights.residuals(family.as_ref(), range, most_pairs);
                    left.iter().position(|&error| error <= allowed).map_or(usize::MAX, |p| p + 1)
                })
                .collect();
            let candidate = Self::of(families, &needed);
            if let Some(candidate) = candidate
                && candidate.layers() <= MOST_LAYERS.min(room)
                && candidate.common() < most
            {
                best = Some(candidate);
            }
        }
        best.unwrap_or_else(|| Self::single(single, basis))
    }

    /// Families of which each needs so many pairs; `None` where they need too many.
    fn of(families: Vec<Box<dyn Expansion>>, needed: &[usize]) -> Option<Self> {
        let pairs = *needed.iter().max()?;
        let deep = needed.iter().rposition(|&n| n == pairs)? + 1;
        (pairs < usize::MAX).then_some(Self { families, real: false, pairs, deep })
    }

    /// Pairs of terms of most bands.
    fn common(&self) -> usize {
        if 2 * self.deep < self.families.len() { self.pairs - 1 } else { self.pairs }
    }
}

/// The functions of each of `count` equal bands of 0 … `z_max`.
fn families(heights: &Heights, basis: Basis, z_max: f64, count: usize) -> Vec<Box<dyn Expansion>> {
    let half_range = heights.half_range;
    let width = z_max / count as f64;
    let (centre, reach) = (|band: usize| (band as f64 + 0.5) * width, width / 2.0);
    let of = |band: usize| -> Box<dyn Expansion> {
        match basis {
            Basis::Taylor if count == 1 => Box::new(Taylor { half_range }),
            Basis::Chebyshev if count == 1 => Box::new(Chebyshev { half_range }),
            Basis::Taylor => Box::new(Shifted {
                expansion: Taylor { half_range },
                half_range,
                centre: centre(band),
                reach,
            }),
            Basis::Chebyshev => Box::new(Shifted {
                expansion: Chebyshev { half_range },
                half_range,
                centre: centre(band),
                reach,
            }),
            Basis::Optimal => {
                Box::new(Optimal::over(heights, [band as f64 * width, (band as f64 + 1.0) * width]))
            }
        }
    };
    (0..count).into_par_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precompute::Budget;
    use crate::precompute::layers::largest_z;

    fn field(range: f64) -> HeightField {
        let heights = (0..4096).map(|i| range * (f64::from(i) * 0.618_034).fract()).collect();
        HeightField::new(64, 64, [0.1, 0.1], heights).unwrap()
    }

    fn chosen(basis: Basis, range: f64, aim: Aim, room: usize) -> Bands {
        let settings = Settings {
            sigma: 2.0,
            shortest_wavelength: 0.38,
            budget: Budget { interpolation: 2e-2, expansion: 1e-2 },
            basis,
            terms: None,
            aim,
            memory_limit: 1 << 30,
            side_limit: 16_384,
        };
        Bands::choose(&field(range), &settings, largest_z(0.38), room)
    }

    #[test]
    fn bands_leave_one_or_two_pairs_to_a_wavelength_where_there_is_room() {
        for (basis, pairs) in [(Basis::Taylor, 2), (Basis::Chebyshev, 2), (Basis::Optimal, 1)] {
            let bands = chosen(basis, 0.3, Aim::FewSamples, usize::MAX);
            assert!(bands.common() <= pairs && !bands.real, "{basis:?}: {} pairs", bands.pairs);
            assert!(bands.layers() <= MOST_LAYERS && bands.deep <= bands.families.len());
            let little = chosen(basis, 0.3, Aim::FewSamples, 1);
            assert_eq!((little.families.len(), little.real), (1, basis.is_real()), "no room");
            assert_eq!(chosen(basis, 0.3, Aim::FewTransforms, usize::MAX).families.len(), 1);
        }
    }

    #[test]
    fn deepening_adds_layers_until_every_band_has_one_more_pair() {
        let mut bands = chosen(Basis::Optimal, 0.3, Aim::FewSamples, usize::MAX);
        let (pairs, count) = (bands.pairs, bands.families.len());
        while bands.pairs == pairs {
            let before = bands.layers();
            bands.deepen();
            assert!(bands.layers() > before);
        }
        assert_eq!((bands.pairs, bands.deep), (pairs + 1, 1));
        assert_eq!(bands.layers(), pairs * count + 1);
    }
}
