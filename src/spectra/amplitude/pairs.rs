//! Number of pairs of terms for a wavelength.

use super::audit::{PLANES, PlaneTerms};
use serde::{Deserialize, Serialize};

/// Number of pairs of terms for k|w| = z: ⌈`slope`·z + `fewest`⌉. A formula costs the shader less than a table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairRule {
    /// Pairs per unit of z \[µm\].
    pub slope: f64,
    /// Pairs at z = 0.
    pub fewest: f64,
}

impl PairRule {
    /// Returns the rule for the same number of `pairs` everywhere.
    pub(super) fn constant(pairs: usize) -> Self {
        Self { slope: 0.0, fewest: pairs as f64 }
    }

    /// Returns the lowest line that is nowhere below the number for the audited planes. The number of a plane holds from the plane below it
    /// on: scattering fades with z as fast as the terms do, so the sup bound, which is relative to the specular peak, would drop visible
    /// terms.
    pub(super) fn over(planes: &[PlaneTerms; PLANES]) -> Self {
        /// Rounding up reaches the number from anywhere above the one before.
        const ABOVE: f64 = 1e-3;
        let corner = |i: usize| {
            let z = if i == 0 { 0.0 } else { planes[i - 1].z };
            (z, planes[i].terms.div_ceil(2) as f64 - 1.0 + ABOVE)
        };
        let corners: [(f64, f64); PLANES] = std::array::from_fn(corner);
        let mut best = Self::constant(planes.iter().map(|p| p.terms.div_ceil(2)).max().unwrap_or(1));
        let end = planes[PLANES - 1].z;
        for &(za, na) in &corners {
            for &(zb, nb) in corners.iter().filter(|(zb, _)| *zb > za) {
                let slope = ((nb - na) / (zb - za)).max(0.0);
                let line = Self { slope, fewest: na - slope * za };
                let suffices = corners.iter().all(|&(z, n)| slope * z + line.fewest >= n - 1e-9);
                if suffices && line.middle(end) < best.middle(end) {
                    best = line;
                }
            }
        }
        best
    }

    fn middle(&self, end: f64) -> f64 {
        self.slope * end / 2.0 + self.fewest
    }

    pub(super) fn at(&self, z: f64) -> usize {
        (self.slope * z + self.fewest).ceil().max(1.0) as usize
    }
}
