//! Direct sum as a [`Brdf`].

use super::{Brdf, without_cosine};
use crate::error::Result;
use crate::optics::geometry::Pair;
use crate::optics::reference::Reference;
use crate::optics::spectrum::Illuminant;
use crate::task::{DIRECTIONS, Task};
use glam::DVec3;

/// Direct sum in f64, with the illuminant of colours.
#[derive(Clone, Debug)]
pub struct DirectSum {
    /// Direct sum.
    pub reference: Reference,
    /// Illuminant.
    pub illuminant: Illuminant,
}

impl DirectSum {
    /// Returns what `value` gives for each of the `pairs`.
    fn each<T>(pairs: &[Pair], task: &Task, value: impl Fn(&Pair) -> Result<T>) -> Result<Vec<T>> {
        let one = |(done, pair)| {
            task.report(DIRECTIONS, done, pairs.len())?;
            value(pair)
        };
        pairs.iter().enumerate().map(one).collect()
    }
}

impl Brdf for DirectSum {
    fn spectral(&self, pairs: &[Pair], wavelength: f64, task: &Task) -> Result<Vec<f64>> {
        Self::each(pairs, task, |pair| Ok(self.reference.brdf(pair, wavelength)))
    }

    fn xyz(&self, pairs: &[Pair], task: &Task) -> Result<Vec<DVec3>> {
        Self::each(pairs, task, |pair| {
            let weighted = self.reference.cosine_weighted_xyz(pair, &self.illuminant)?;
            Ok(without_cosine(pair, weighted))
        })
    }
}
