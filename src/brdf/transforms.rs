//! The f64 transforms as a [`Brdf`].

use super::{Brdf, without_cosine};
use crate::error::Result;
use crate::optics::geometry::Pair;
use crate::optics::nufft;
use crate::optics::reference::Reference;
use crate::optics::spectrum::Illuminant;
use glam::DVec3;

/// What [`DirectSum`](super::DirectSum) gives, by transforms that many directions share.
#[derive(Clone, Debug)]
pub struct Transforms<'a> {
    /// The sum that the transforms stand for.
    pub reference: Reference<'a>,
    /// The light.
    pub illuminant: &'a Illuminant,
}

impl Brdf for Transforms<'_> {
    fn spectral(&mut self, pairs: &[Pair], wavelength: f64) -> Result<Vec<f64>> {
        let weighted = nufft::cosine_weighted(&self.reference, pairs, wavelength)?;
        let f = |(pair, weighted): (&Pair, f64)| without_cosine(pair, DVec3::splat(weighted)).x;
        Ok(pairs.iter().zip(weighted).map(f).collect())
    }

    fn xyz(&mut self, pairs: &[Pair]) -> Result<Vec<DVec3>> {
        let weighted = nufft::cosine_weighted_xyz(&self.reference, self.illuminant, pairs, &|_, _| Ok(()))?;
        Ok(pairs.iter().zip(weighted).map(|(pair, f)| without_cosine(pair, f)).collect())
    }

    fn batch(&self) -> usize {
        usize::MAX
    }
}
