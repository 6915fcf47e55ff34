//! Mean over coherence areas as a [`Brdf`].

use super::albedo::Decimation;
use super::mean::MeanBrdf;
use super::tabulated::{ColourSampling, SummedOrders, TabulatedMean};
use super::{Brdf, without_cosine};
use crate::error::{Error, Remedy, Result};
use crate::filter::Covariance;
use crate::optics::geometry::Pair;
use crate::optics::spectrum::{Illuminant, SHORTEST};
use crate::task::{DIRECTIONS, Task};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Pairs evaluated between two steps of a progress bar.
const AT_ONCE: usize = 4096;

/// Mean from the series of the orders, to a tolerance. A value does not depend on other queries.
pub struct MeanFromOrders {
    mean: MeanBrdf,
    illuminant: Illuminant,
    sampling: ColourSampling,
    footprint: Covariance,
    // Series for wavelengths from SHORTEST/2ⁿ by n, made on first use.
    tables: Mutex<BTreeMap<u32, Arc<TabulatedMean>>>,
}

impl MeanFromOrders {
    /// Prepares the mean `mean`, with colours under `illuminant` within the relative error `tolerance`.
    pub fn new(mean: MeanBrdf, illuminant: Illuminant, tolerance: f64) -> Self {
        Self {
            mean,
            illuminant,
            sampling: ColourSampling::within(tolerance),
            footprint: Covariance::default(),
            tables: Mutex::default(),
        }
    }

    /// Returns the series for `wavelength` \[µm\]: for all visible light, or for shorter wavelengths by octaves.
    fn table(&self, wavelength: f64, task: &Task) -> Result<Arc<TabulatedMean>> {
        let octave = (SHORTEST / wavelength).log2().ceil().max(0.0) as u32;
        // Whoever else needs a series waits for it here.
        let mut tables = self.tables.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(table) = tables.get(&octave) {
            return Ok(Arc::clone(table));
        }
        let shortest = SHORTEST * 0.5f64.powi(octave as i32);
        let table = TabulatedMean::with_sampling(self.mean.clone(), shortest, self.sampling, task)?;
        let table = Arc::new(table.limited(Decimation::Coarse));
        tables.insert(octave, Arc::clone(&table));
        Ok(table)
    }
}

impl Brdf for MeanFromOrders {
    fn spectral(&self, pairs: &[Pair], wavelength: f64, task: &Task) -> Result<Vec<f64>> {
        spectral(&*self.table(wavelength, task)?, pairs, wavelength, &self.footprint, task)
    }

    fn xyz(&self, pairs: &[Pair], task: &Task) -> Result<Vec<DVec3>> {
        xyz(&*self.table(SHORTEST, task)?, pairs, &self.illuminant, &self.footprint, task)
    }

    fn average_over(&mut self, deviation: f64) -> bool {
        self.footprint = Covariance::round(deviation);
        true
    }

    fn averaged_over(&self, deviation: f64) -> Option<Box<dyn Brdf>> {
        let Self { mean, illuminant, sampling, .. } = self;
        let tables = self.tables.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Some(Box::new(Self {
            mean: mean.clone(),
            illuminant: illuminant.clone(),
            sampling: *sampling,
            footprint: Covariance::round(deviation),
            tables: Mutex::new(tables),
        }))
    }

    fn albedo(&self, light: DVec3, wavelength: Option<f64>, task: &Task) -> Result<Option<f64>> {
        let table = self.table(wavelength.unwrap_or(SHORTEST), task)?;
        Ok(table.sent(light, wavelength, &self.illuminant))
    }

    fn batch(&self) -> usize {
        AT_ONCE
    }
}

fn spectral(
    table: &TabulatedMean,
    pairs: &[Pair],
    wavelength: f64,
    footprint: &Covariance,
    task: &Task,
) -> Result<Vec<f64>> {
    let one = |pair: &Pair| {
        task.check()?;
        let weighted = table.unlimited(pair, wavelength, footprint);
        Ok(without_cosine(pair, DVec3::splat(weighted)).x)
    };
    Ok(limited(table, pairs, wavelength, pairs.par_iter().map(one).collect::<Result<_>>()?))
}

/// Returns the `values` of `pairs` within the limit of energy of `table`.
fn limited(table: &TabulatedMean, pairs: &[Pair], wavelength: f64, values: Vec<f64>) -> Vec<f64> {
    match table.limit() {
        Some(limit) => {
            values.iter().zip(limit.limits(pairs, wavelength)).map(|(f, limit)| f / limit).collect()
        }
        None => values,
    }
}

fn xyz(
    table: &TabulatedMean,
    pairs: &[Pair],
    illuminant: &Illuminant,
    footprint: &Covariance,
    task: &Task,
) -> Result<Vec<DVec3>> {
    table.prepare_colours(task)?;
    let asked: Vec<_> = pairs.iter().map(|pair| (*pair, *footprint)).collect();
    let weighted = table.xyz(illuminant, &asked, SummedOrders::All, task)?;
    Ok(pairs.iter().zip(weighted).map(|(pair, f)| without_cosine(pair, f)).collect())
}

/// F64 reference of the mean: a direct sum for the first few single wavelengths; the series of all orders for further
/// ones, and for colours.
pub struct MeanReference {
    mean: MeanBrdf,
    illuminant: Illuminant,
    shortest: f64,
    footprint: Covariance,
    answered: AtomicUsize,
    // Made on first use.
    table: Mutex<Option<Arc<TabulatedMean>>>,
    too_large: AtomicBool,
}

/// Number of direct sums that take as long as the table of all orders.
const WORTH_A_TABLE: usize = 24;

impl MeanReference {
    /// Prepares the reference for wavelengths from `shortest` \[µm\], with colours under `illuminant`.
    pub fn new(mean: MeanBrdf, illuminant: Illuminant, shortest: f64) -> Self {
        Self {
            mean,
            illuminant,
            shortest,
            footprint: Covariance::default(),
            answered: AtomicUsize::new(0),
            table: Mutex::default(),
            too_large: AtomicBool::new(false),
        }
    }

    /// Returns the series of all orders.
    fn table(&self, task: &Task) -> Result<Arc<TabulatedMean>> {
        // Whoever else needs the series waits for it here.
        let mut table = self.table.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(table) = &*table {
            return Ok(Arc::clone(table));
        }
        let made = TabulatedMean::new(self.mean.clone(), self.shortest, task)?.limited(Decimation::Fine);
        Ok(Arc::clone(table.insert(Arc::new(made))))
    }

    /// Returns the series of all orders; `None` if the surface is too large for it. Direct sums need no memory.
    fn table_if_possible(&self, task: &Task) -> Result<Option<Arc<TabulatedMean>>> {
        if self.too_large.load(Ordering::Relaxed) {
            return Ok(None);
        }
        match self.table(task) {
            Ok(table) => Ok(Some(table)),
            Err(error) if error.is_too_large() => {
                self.too_large.store(true, Ordering::Relaxed);
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }
}

impl Brdf for MeanReference {
    fn spectral(&self, pairs: &[Pair], wavelength: f64, task: &Task) -> Result<Vec<f64>> {
        let answered = self.answered.fetch_add(pairs.len(), Ordering::Relaxed) + pairs.len();
        if answered > WORTH_A_TABLE
            && let Some(table) = self.table_if_possible(task)?
        {
            return spectral(&table, pairs, wavelength, &self.footprint, task);
        }
        let one = |(done, pair)| {
            task.report(DIRECTIONS, done, pairs.len())?;
            Ok(self.mean.brdf(pair, wavelength, &self.footprint))
        };
        let values = pairs.iter().enumerate().map(one).collect::<Result<_>>()?;
        if !self.mean.reflectance.is_limited() {
            return Ok(values);
        }
        let advise = |e: Error| if e.is_too_large() { e.or(Remedy::UnlimitedTheory) } else { e };
        let table = self.table(task).map_err(advise)?;
        Ok(limited(&table, pairs, wavelength, values))
    }

    fn xyz(&self, pairs: &[Pair], task: &Task) -> Result<Vec<DVec3>> {
        xyz(&*self.table(task)?, pairs, &self.illuminant, &self.footprint, task)
    }

    fn average_over(&mut self, deviation: f64) -> bool {
        self.footprint = Covariance::round(deviation);
        true
    }

    fn averaged_over(&self, deviation: f64) -> Option<Box<dyn Brdf>> {
        let table = self.table.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Some(Box::new(Self {
            footprint: Covariance::round(deviation),
            table: Mutex::new(table),
            ..Self::new(self.mean.clone(), self.illuminant.clone(), self.shortest)
        }))
    }

    fn albedo(&self, light: DVec3, wavelength: Option<f64>, task: &Task) -> Result<Option<f64>> {
        let table = self.table_if_possible(task)?;
        Ok(table.and_then(|table| table.sent(light, wavelength, &self.illuminant)))
    }

    fn batch(&self) -> usize {
        let is_made = self.table.lock().unwrap_or_else(PoisonError::into_inner).is_some();
        if is_made { AT_ONCE } else { WORTH_A_TABLE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::energy::EnergyLimit;
    use crate::optics::geometry::direction;
    use crate::optics::material::Material;
    use crate::optics::quadrature::Wavelengths;
    use crate::optics::reflectance::Reflectance;
    use crate::optics::theory::Theory;
    use crate::random::Random;
    use crate::spectra::power::Beyond;
    use crate::surface::HeightField;

    fn pairs(count: usize) -> Vec<Pair> {
        let mut random = Random::new(11);
        let mut any = || direction(80.0 * random.share(), 360.0 * random.share());
        (0..count).map(|_| Pair::new(any(), any())).collect()
    }

    /// Returns the mean by Stam's theory, whose values have no limit of energy.
    fn mean(field: &HeightField) -> MeanBrdf {
        let reflectance = Reflectance::from(1.5).by(Theory::Stam);
        MeanBrdf { field: field.clone(), sigma: 1.25, beyond: Beyond::Copies, reflectance }
    }

    #[test]
    fn values_within_a_limit_of_energy_are_those_without_it_over_the_excess_of_either_direction() {
        let silver = Material::from_name_or_file("silver").unwrap();
        // A sinusoid of period 0.6 µm, which is deep and short, so that the theory would make much light, and noise, so that all orders have some.
        let height = |i: u32| {
            0.1 * (std::f64::consts::TAU * f64::from(i % 20) / 10.0).sin()
                + 0.05 * (f64::from(i) * 0.618_034).fract()
        };
        let field = HeightField::new(20, 20, [0.06; 2], (0..400).map(height).collect()).unwrap();
        let mean = MeanBrdf { reflectance: Reflectance::of_material(silver, None), ..mean(&field) };
        let pairs = pairs(40);
        let found = MeanReference::new(mean.clone(), Illuminant::D65, 0.4)
            .spectral(&pairs, 0.5, &Task::silent())
            .unwrap();
        let orders = TabulatedMean::new(mean.clone(), 0.4, &Task::silent()).unwrap();
        let albedo = orders.albedo(Decimation::Fine);
        let mut limited = 0;
        for (pair, found) in pairs.iter().zip(found) {
            let free = mean.brdf(pair, 0.5, &Covariance::default());
            let limit = albedo.single(pair, 0.5);
            assert!((found * limit - free).abs() <= 1e-3 * free, "{found} {limit} {free}");
            limited += usize::from(limit > 1.01);
        }
        assert!(limited > 5, "{limited} directions are limited");
    }

    /// Returns patches of 8 × 8 samples, whose orders are fourteen standard deviations of the blur apart: rough, and of
    /// two heights.
    fn short_patches() -> [HeightField; 2] {
        let rough = (0..64).map(|i| 0.2 * (f64::from(i) * 0.618_034).fract()).collect();
        let stepped = (0..64).map(|i| if i % 8 < 3 || i > 40 { 0.12 } else { 0.0 }).collect();
        [rough, stepped].map(|heights| HeightField::new(8, 8, [0.1; 2], heights).unwrap())
    }

    #[test]
    fn faint_directions_between_the_orders_of_short_patches_keep_their_own_value() {
        for field in short_patches() {
            let answers = MeanFromOrders::new(mean(&field), Illuminant::D65, 1e-3);
            let (mut squares, mut faintest, mut brightest) = (0.0, f64::INFINITY, 0.0f64);
            let pairs = pairs(100);
            for wavelength in [0.3, 0.45, 0.7] {
                let found = answers.spectral(&pairs, wavelength, &Task::silent()).unwrap();
                for (pair, found) in pairs.iter().zip(found) {
                    let exact = mean(&field).brdf(pair, wavelength, &Covariance::default());
                    if exact == 0.0 {
                        // Beyond the frequencies resolved by the samples.
                        assert_eq!(found, 0.0);
                        continue;
                    }
                    squares += (found / exact - 1.0).powi(2) / 300.0;
                    (faintest, brightest) = (faintest.min(exact), brightest.max(exact));
                }
            }
            eprintln!("{faintest:.1e} to {brightest:.1e}: {:.1e} of their own value", squares.sqrt());
            assert!(faintest < 1e-9 * brightest, "no direction is faint");
            assert!(squares.sqrt() < 1e-3, "{}", squares.sqrt());
        }
    }

    #[test]
    fn a_surface_that_is_too_high_for_the_series_is_summed_directly_and_cancelled_work_is_not() {
        let heights = (0..64).map(|i| if i % 8 < 4 { 0.0 } else { 900.0 }).collect();
        let field = HeightField::new(8, 8, [0.1; 2], heights).unwrap();
        let pairs = pairs(WORTH_A_TABLE + 1);
        let task = Task::silent();
        assert!(TabulatedMean::new(mean(&field), SHORTEST, &task).is_err_and(|e| e.is_too_large()));
        let reference = MeanReference::new(mean(&field), Illuminant::D65, SHORTEST);
        assert_eq!(reference.spectral(&pairs, 0.55, &task).unwrap().len(), pairs.len());
        assert_eq!(reference.albedo(DVec3::Z, None, &task).unwrap(), None);
        let [field, _] = short_patches();
        let reference = MeanReference::new(mean(&field), Illuminant::D65, SHORTEST);
        task.cancel();
        assert!(reference.albedo(DVec3::Z, None, &task).is_err_and(|e| e.is_cancelled()));
        assert!(reference.albedo(DVec3::Z, None, &Task::silent()).unwrap().is_some(), "not too large");
    }

    #[test]
    fn an_answer_depends_on_its_own_question_alone() {
        let [field, _] = short_patches();
        let pairs = pairs(20);
        let alone = MeanFromOrders::new(mean(&field), Illuminant::D65, 1e-2);
        let one = (
            alone.spectral(&pairs[..1], 0.55, &Task::silent()).unwrap()[0],
            alone.xyz(&pairs[..1], &Task::silent()).unwrap()[0],
        );
        let together = MeanFromOrders::new(mean(&field), Illuminant::D65, 1e-2);
        let _ = together.spectral(&pairs, 0.2, &Task::silent()).unwrap();
        assert_eq!(together.spectral(&pairs, 0.55, &Task::silent()).unwrap()[0], one.0);
        assert_eq!(together.xyz(&pairs, &Task::silent()).unwrap()[0], one.1);
    }

    #[test]
    fn colours_keep_the_tolerance_each_by_itself() {
        for field in short_patches() {
            let pairs = pairs(50);
            // The trapezoid rule over many wavelengths.
            let nodes = Wavelengths::trapezoid(&Illuminant::D65, 4001);
            let single = MeanFromOrders::new(mean(&field), Illuminant::D65, 1e-3);
            let mut exact = vec![DVec3::ZERO; pairs.len()];
            for (weight, q) in nodes.weights.iter().zip(&nodes.wavenumbers) {
                let wavelength = 1.0 / q;
                let values = single.spectral(&pairs, wavelength.max(SHORTEST), &Task::silent()).unwrap();
                exact.iter_mut().zip(values).for_each(|(sum, value)| *sum += *weight * value);
            }
            for tolerance in [1e-1, 1e-2] {
                let answers = MeanFromOrders::new(mean(&field), Illuminant::D65, tolerance);
                let found = answers.xyz(&pairs, &Task::silent()).unwrap();
                let square = |(a, b): (&DVec3, &DVec3)| (*a - *b).length_squared() / b.length_squared();
                let rms = (found.iter().zip(&exact).map(square).sum::<f64>() / pairs.len() as f64).sqrt();
                eprintln!("{tolerance:e}: {rms:.1e}");
                assert!(rms <= tolerance, "{tolerance}: {rms}");
            }
        }
    }
}
