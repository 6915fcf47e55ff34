//! Direct sum as a [`Brdf`].

use super::{Brdf, without_cosine};
use crate::error::Result;
use crate::optics::geometry::Pair;
use crate::optics::reference::Reference;
use crate::optics::spectrum::Illuminant;
use glam::DVec3;

/// Direct sum in f64, with the illuminant of colours.
#[derive(Clone, Debug)]
pub struct DirectSum<'a> {
    /// Direct sum.
    pub reference: Reference<'a>,
    /// Illuminant.
    pub illuminant: &'a Illuminant,
}

impl Brdf for DirectSum<'_> {
    fn spectral(&mut self, pairs: &[Pair], wavelength: f64) -> Result<Vec<f64>> {
        Ok(pairs.iter().map(|pair| self.reference.brdf(pair, wavelength)).collect())
    }

    fn xyz(&mut self, pairs: &[Pair]) -> Result<Vec<DVec3>> {
        let one = |pair| {
            let weighted = self.reference.cosine_weighted_xyz(pair, self.illuminant)?;
            Ok(without_cosine(pair, weighted))
        };
        pairs.iter().map(one).collect()
    }
}
