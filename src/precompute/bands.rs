//! How 0 … z_max is split into equal bands, each with functions and layers of its own: a band needs fewer terms, so a
//! wavelength fewer reads, for more layers to make and to hold.

use super::layers::{Aim, Settings};
use crate::expansion::anchored::{Anchored, Series};
use crate::expansion::chebyshev::Chebyshev;
use crate::expansion::heights::Heights;
use crate::expansion::optimal::Optimal;
use crate::expansion::phase::Phase;
use crate::expansion::shifted::Shifted;
use crate::expansion::taylor::{F32_ROUNDOFF, Taylor, rounding_bound};
use crate::expansion::{Basis, Expansion};
use crate::surface::HeightField;
use rayon::prelude::*;

/// Numbers of bands that are tried: close enough to each other that the best of them is near the best there is.
const CANDIDATES: [usize; 5] = [2, 3, 4, 6, 12];
/// Most layers that more than one band may take. More would save samples yet, but a first picture waits for them all, and they
/// outgrow every cache: at 65 µm of coherence and a tolerance of 1e-2 a dozen are 1.2 GB.
const MOST_LAYERS: usize = 12;
/// The largest z_max·a for which bands are tried, heights of 3.6 µm in visible light: beyond, no few layers do, and finding that
/// out would take longer than a single band's refusal.
const MOST_RADIANS: f64 = 60.0;
/// Most pairs of terms that are looked at for a single band; more is left to the audit.
const MOST_PAIRS: usize = 16;
/// Relative intensity errors of single directions are about this many times larger than an expansion's amplitude error
/// relative to the scattered light: twice for the square, and the faint directions. The audit decides; this only chooses
/// where it begins.
const RESIDUAL_PART: f64 = 0.3;

/// An expansion in each of some equal bands of z.
pub(super) struct Bands {
    /// The functions of each band, from z = 0 up.
    pub families: Vec<Box<dyn Expansion>>,
    /// Whether every function is real.
    pub real: bool,
    /// Pairs of terms of each.
    pub pairs: usize,
}

impl Bands {
    /// One band with one pair of terms.
    fn single(families: Vec<Box<dyn Expansion>>, basis: Basis) -> Self {
        Self { families, real: basis.is_real(), pairs: 1 }
    }

    /// Layers of all bands.
    pub fn layers(&self) -> usize {
        self.pairs * self.families.len()
    }

    /// The bands for `settings`: one where terms are named or transforms are to be few, or as many as make the pairs of terms
    /// of a wavelength few, in at most `room` layers.
    pub fn choose(field: &HeightField, settings: &Settings, z_max: f64, room: usize) -> Self {
        let heights = Heights::of(field);
        let basis = settings.basis;
        let single = families(&heights, basis, z_max, 1);
        let x = z_max * heights.half_range;
        if !tried(settings, x) {
            return Self::single(single, basis);
        }
        let allowed = RESIDUAL_PART * settings.budget.expansion;
        let cancels = basis == Basis::Taylor && rounding_bound(x, F32_ROUNDOFF) > settings.budget.expansion;
        let pairs_of_one = if cancels {
            usize::MAX
        } else {
            let left = heights.residuals(single[0].as_ref(), [0.0, z_max], MOST_PAIRS);
            left.iter().position(|&error| error <= allowed).map_or(MOST_PAIRS, |p| p + 1)
        };
        let mut best: Option<Self> = None;
        let mut fewest = (reads(settings, &single, pairs_of_one.min(MOST_PAIRS + 1)), 0);
        for count in CANDIDATES {
            if pairs_of_one <= 1 {
                break;
            }
            let families = families(&heights, basis, z_max, count);
            let width = z_max / count as f64;
            let most_pairs = MOST_LAYERS.min(room) / count;
            let needed = families.par_iter().enumerate().map(|(band, family)| {
                let range = [band as f64, band as f64 + 1.0].map(|edge| edge * width);
                let left = heights.residuals(family.as_ref(), range, most_pairs);
                left.iter().position(|&error| error <= allowed).map(|p| p + 1)
            });
            let pairs: Option<usize> =
                needed.collect::<Option<Vec<_>>>().and_then(|all| all.into_iter().max());
            let Some(pairs) = pairs else { continue };
            let cost = (reads(settings, &families, pairs), pairs.next_multiple_of(2) * count);
            if cost < fewest {
                fewest = cost;
                best = Some(Self { families, real: false, pairs });
            }
        }
        best.unwrap_or_else(|| Self::single(single, basis))
    }
}

/// Texels that a wavelength reads for `pairs` pairs of terms of `families`: coefficients from a table count as much as spectra do.
fn reads(settings: &Settings, families: &[Box<dyn Expansion>], pairs: usize) -> usize {
    /// A bilinear sample of the plane takes as long as reading so many texels.
    const SAMPLE: usize = 2;
    let spectra = settings.lines.map_or(SAMPLE * pairs, |lines| lines.texels_of_a_node(pairs));
    let computed = families.iter().all(|family| family.series().is_some());
    spectra + if computed { 0 } else { pairs }
}

/// Whether more than one band is an option for `settings` and heights of z_max·a = `x`.
fn tried(settings: &Settings, x: f64) -> bool {
    may_be_many(settings) && x <= MOST_RADIANS
}

/// Whether more than one band is an option for `settings` and some heights.
pub(super) fn may_be_many(settings: &Settings) -> bool {
    settings.terms.is_none() && settings.aim == Aim::FewSamples
}

/// The functions of each of `count` equal bands of 0 … `z_max`.
fn families(heights: &Heights, basis: Basis, z_max: f64, count: usize) -> Vec<Box<dyn Expansion>> {
    let half_range = heights.half_range;
    if count == 1 {
        return vec![match basis {
            Basis::Taylor => Box::new(Taylor { half_range }),
            Basis::Chebyshev => Box::new(Chebyshev { half_range }),
            Basis::Optimal => Box::new(Optimal::over(heights, [0.0, z_max])),
            Basis::Phase => Box::new(Phase::new(half_range, z_max)),
        }];
    }
    let anchored = |series: Series| -> Vec<Box<dyn Expansion>> {
        let bands = Anchored::bands(series, half_range, z_max, count);
        bands.into_iter().map(|band| -> Box<dyn Expansion> { Box::new(band) }).collect()
    };
    match basis {
        Basis::Taylor => anchored(Series::Powers),
        // The polynomials of Phase are in z already, and tables are baked of all z at once.
        Basis::Optimal | Basis::Phase => anchored(Series::Polynomials),
        Basis::Chebyshev => {
            let reach = z_max / count as f64;
            let shifted = |band: usize| -> Box<dyn Expansion> {
                let expansion = Chebyshev { half_range };
                Box::new(Shifted { expansion, half_range, centre: band as f64 * reach, reach })
            };
            (0..count).map(shifted).collect()
        }
    }
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
            lines: None,
            memory_limit: 1 << 30,
            side_limit: 16_384,
        };
        Bands::choose(&field(range), &settings, largest_z(0.38), room)
    }

    #[test]
    fn bands_leave_few_pairs_to_a_wavelength_where_there_is_room() {
        for (basis, pairs) in [(Basis::Taylor, 4), (Basis::Chebyshev, 3), (Basis::Optimal, 2)] {
            let bands = chosen(basis, 0.3, Aim::FewSamples, usize::MAX);
            assert!(bands.pairs <= pairs && !bands.real, "{basis:?}: {} pairs", bands.pairs);
            assert!(bands.layers() <= MOST_LAYERS);
            let little = chosen(basis, 0.3, Aim::FewSamples, 1);
            assert_eq!((little.families.len(), little.real), (1, basis.is_real()), "no room");
            assert_eq!(chosen(basis, 0.3, Aim::FewTransforms, usize::MAX).families.len(), 1);
        }
    }
}
