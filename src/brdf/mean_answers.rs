//! The mean over coherence areas as a [`Brdf`].

use super::mean::MeanBrdf;
use super::tabulated::{ColourSampling, SummedOrders, TabulatedMean};
use super::{Brdf, without_cosine};
use crate::error::Result;
use crate::filter::Covariance;
use crate::optics::geometry::Pair;
use crate::optics::spectrum::{Illuminant, SHORTEST};
use glam::DVec3;
use rayon::prelude::*;

/// Pairs that are answered between two steps of a progress bar.
const AT_ONCE: usize = 4096;

/// The mean from the series of the orders, to a tolerance. An answer depends on its own question alone.
pub struct MeanFromOrders<'a> {
    mean: MeanBrdf<'a>,
    illuminant: &'a Illuminant,
    sampling: ColourSampling,
    // Series for wavelengths from SHORTEST/2ⁿ, made when they are first asked for, with n.
    tables: Vec<(u32, TabulatedMean<'a>)>,
}

impl<'a> MeanFromOrders<'a> {
    /// Prepares answers for `mean`, and colours under `illuminant` within the relative error `tolerance`.
    pub fn new(mean: MeanBrdf<'a>, illuminant: &'a Illuminant, tolerance: f64) -> Self {
        Self { mean, illuminant, sampling: ColourSampling::within(tolerance), tables: Vec::new() }
    }

    /// Returns the series for `wavelength` \[µm\]: for all visible light, or below that by octaves.
    fn table(&mut self, wavelength: f64) -> Result<&TabulatedMean<'a>> {
        let octave = (SHORTEST / wavelength).log2().ceil().max(0.0) as u32;
        let known = self.tables.iter().position(|(known, _)| *known == octave);
        let place = match known {
            Some(place) => place,
            None => {
                let shortest = SHORTEST * 0.5f64.powi(octave as i32);
                let table =
                    TabulatedMean::with_sampling(self.mean.clone(), shortest, self.sampling, &|_, _| Ok(()))?;
                self.tables.push((octave, table));
                self.tables.len() - 1
            }
        };
        Ok(&self.tables[place].1)
    }
}

impl Brdf for MeanFromOrders<'_> {
    fn spectral(&mut self, pairs: &[Pair], wavelength: f64) -> Result<Vec<f64>> {
        Ok(spectral(self.table(wavelength)?, pairs, wavelength))
    }

    fn xyz(&mut self, pairs: &[Pair]) -> Result<Vec<DVec3>> {
        let illuminant = self.illuminant;
        xyz(self.table(SHORTEST)?, pairs, illuminant)
    }

    fn batch(&self) -> usize {
        AT_ONCE
    }
}

fn spectral(table: &TabulatedMean<'_>, pairs: &[Pair], wavelength: f64) -> Vec<f64> {
    let one = |pair: &Pair| {
        let weighted = table.cosine_weighted(pair, wavelength, &Covariance::default());
        without_cosine(pair, DVec3::splat(weighted)).x
    };
    pairs.par_iter().map(one).collect()
}

fn xyz(table: &TabulatedMean<'_>, pairs: &[Pair], illuminant: &Illuminant) -> Result<Vec<DVec3>> {
    let asked: Vec<_> = pairs.iter().map(|pair| (*pair, Covariance::default())).collect();
    let weighted = table.xyz(illuminant, &asked, SummedOrders::All, &|_, _| Ok(()))?;
    Ok(pairs.iter().zip(weighted).map(|(pair, f)| without_cosine(pair, f)).collect())
}

/// The f64 reference of the mean: a direct sum for the first few single wavelengths, and the series of all orders once there are many, or for colours.
pub struct MeanReference<'a> {
    mean: MeanBrdf<'a>,
    illuminant: &'a Illuminant,
    shortest: f64,
    answered: usize,
    table: Option<TabulatedMean<'a>>,
    too_large: bool,
}

/// Direct sums that take as long as the table of all orders.
const WORTH_A_TABLE: usize = 24;

impl<'a> MeanReference<'a> {
    /// Prepares answers for wavelengths from `shortest` \[µm\], and colours under `illuminant`.
    pub fn new(mean: MeanBrdf<'a>, illuminant: &'a Illuminant, shortest: f64) -> Self {
        Self { mean, illuminant, shortest, answered: 0, table: None, too_large: false }
    }

    /// Returns the series of all orders, made when they are first asked for.
    fn table(&mut self) -> Result<&TabulatedMean<'a>> {
        let table = match self.table.take() {
            Some(table) => table,
            None => TabulatedMean::new(self.mean.clone(), self.shortest, &|_, _| Ok(()))?,
        };
        Ok(self.table.insert(table))
    }
}

impl Brdf for MeanReference<'_> {
    fn spectral(&mut self, pairs: &[Pair], wavelength: f64) -> Result<Vec<f64>> {
        self.answered += pairs.len();
        if self.answered > WORTH_A_TABLE && !self.too_large {
            match self.table() {
                Ok(table) => return Ok(spectral(table, pairs, wavelength)),
                // The direct sum needs no room.
                Err(_) => self.too_large = true,
            }
        }
        Ok(pairs.iter().map(|pair| self.mean.brdf(pair, wavelength)).collect())
    }

    fn xyz(&mut self, pairs: &[Pair]) -> Result<Vec<DVec3>> {
        let illuminant = self.illuminant;
        xyz(self.table()?, pairs, illuminant)
    }

    fn batch(&self) -> usize {
        if self.table.is_some() { AT_ONCE } else { WORTH_A_TABLE }
    }
}
