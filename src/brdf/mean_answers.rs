//! Mean over coherence areas as a [`Brdf`].

use super::albedo::Decimation;
use super::mean::MeanBrdf;
use super::tabulated::{ColourSampling, SummedOrders, TabulatedMean};
use super::{Brdf, Progress, without_cosine};
use crate::error::{Remedy, Result};
use crate::filter::Covariance;
use crate::optics::geometry::Pair;
use crate::optics::spectrum::{Illuminant, SHORTEST};
use glam::DVec3;
use rayon::prelude::*;

/// Pairs evaluated between two steps of a progress bar.
const AT_ONCE: usize = 4096;

/// Mean from the series of the orders, to a tolerance. A value does not depend on other queries.
pub struct MeanFromOrders<'a> {
    mean: MeanBrdf<'a>,
    illuminant: &'a Illuminant,
    sampling: ColourSampling,
    footprint: Covariance,
    // Series for wavelengths from SHORTEST/2ⁿ, with n, made on first use.
    tables: Vec<(u32, TabulatedMean<'a>)>,
    progress: &'a Progress<'a>,
}

impl<'a> MeanFromOrders<'a> {
    /// Prepares the mean `mean`, with colours under `illuminant` within the relative error `tolerance`.
    pub fn new(mean: MeanBrdf<'a>, illuminant: &'a Illuminant, tolerance: f64) -> Self {
        Self {
            mean,
            illuminant,
            sampling: ColourSampling::within(tolerance),
            footprint: Covariance::default(),
            tables: Vec::new(),
            progress: &|_, _, _| Ok(()),
        }
    }

    /// Returns the same mean, which tells `progress` about the series that it makes.
    pub fn telling(self, progress: &'a Progress<'a>) -> Self {
        Self { progress, ..self }
    }

    /// Returns the series for `wavelength` \[µm\]: for all visible light, or for shorter wavelengths by octaves.
    fn table(&mut self, wavelength: f64) -> Result<&TabulatedMean<'a>> {
        let progress = self.progress;
        let octave = (SHORTEST / wavelength).log2().ceil().max(0.0) as u32;
        let known = self.tables.iter().position(|(known, _)| *known == octave);
        let place = match known {
            Some(place) => place,
            None => {
                let shortest = SHORTEST * 0.5f64.powi(octave as i32);
                let told = |done, of| progress("orders", done, of);
                let table = TabulatedMean::with_sampling(self.mean.clone(), shortest, self.sampling, &told)?
                    .limited(Decimation::Coarse);
                self.tables.push((octave, table));
                self.tables.len() - 1
            }
        };
        Ok(&self.tables[place].1)
    }
}

impl Brdf for MeanFromOrders<'_> {
    fn spectral(&mut self, pairs: &[Pair], wavelength: f64) -> Result<Vec<f64>> {
        let footprint = self.footprint;
        Ok(spectral(self.table(wavelength)?, pairs, wavelength, &footprint))
    }

    fn xyz(&mut self, pairs: &[Pair]) -> Result<Vec<DVec3>> {
        let (illuminant, footprint, progress) = (self.illuminant, self.footprint, self.progress);
        xyz(self.table(SHORTEST)?, pairs, illuminant, &footprint, progress)
    }

    fn average_over(&mut self, deviation: f64) -> bool {
        self.footprint = Covariance::round(deviation);
        true
    }

    fn albedo(&mut self, light: DVec3, wavelength: Option<f64>) -> Result<Option<f64>> {
        let illuminant = self.illuminant;
        Ok(self.table(wavelength.unwrap_or(SHORTEST))?.sent(light, wavelength, illuminant))
    }

    fn batch(&self) -> usize {
        AT_ONCE
    }
}

fn spectral(table: &TabulatedMean<'_>, pairs: &[Pair], wavelength: f64, footprint: &Covariance) -> Vec<f64> {
    let one = |pair: &Pair| {
        let weighted = table.unlimited(pair, wavelength, footprint);
        without_cosine(pair, DVec3::splat(weighted)).x
    };
    limited(table, pairs, wavelength, pairs.par_iter().map(one).collect())
}

/// Returns the `values` of `pairs` within the limit of energy of `table`.
fn limited(table: &TabulatedMean<'_>, pairs: &[Pair], wavelength: f64, values: Vec<f64>) -> Vec<f64> {
    match table.limit() {
        Some(limit) => {
            values.iter().zip(limit.limits(pairs, wavelength)).map(|(f, limit)| f / limit).collect()
        }
        None => values,
    }
}

fn xyz(
    table: &TabulatedMean<'_>,
    pairs: &[Pair],
    illuminant: &Illuminant,
    footprint: &Covariance,
    progress: &Progress<'_>,
) -> Result<Vec<DVec3>> {
    table.prepare_colours(&|done, of| progress("energy", done, of))?;
    let asked: Vec<_> = pairs.iter().map(|pair| (*pair, *footprint)).collect();
    let weighted = table.xyz(illuminant, &asked, SummedOrders::All, &|_, _| Ok(()))?;
    Ok(pairs.iter().zip(weighted).map(|(pair, f)| without_cosine(pair, f)).collect())
}

/// F64 reference of the mean: a direct sum for the first few single wavelengths; the series of all orders for further
/// ones, and for colours.
pub struct MeanReference<'a> {
    mean: MeanBrdf<'a>,
    illuminant: &'a Illuminant,
    shortest: f64,
    footprint: Covariance,
    answered: usize,
    table: Option<TabulatedMean<'a>>,
    too_large: bool,
    progress: &'a Progress<'a>,
}

/// Number of direct sums that take as long as the table of all orders.
const WORTH_A_TABLE: usize = 24;

impl<'a> MeanReference<'a> {
    /// Prepares the reference for wavelengths from `shortest` \[µm\], with colours under `illuminant`.
    pub fn new(mean: MeanBrdf<'a>, illuminant: &'a Illuminant, shortest: f64) -> Self {
        Self {
            mean,
            illuminant,
            shortest,
            footprint: Covariance::default(),
            answered: 0,
            table: None,
            too_large: false,
            progress: &|_, _, _| Ok(()),
        }
    }

    /// Returns the same reference, which tells `progress` about the series that it makes.
    pub fn telling(self, progress: &'a Progress<'a>) -> Self {
        Self { progress, ..self }
    }

    /// Returns the series of all orders, made on first use.
    fn table(&mut self) -> Result<&TabulatedMean<'a>> {
        let table = match self.table.take() {
            Some(table) => table,
            None => {
                let told = |done, of| (self.progress)("orders", done, of);
                TabulatedMean::new(self.mean.clone(), self.shortest, &told)?.limited(Decimation::Fine)
            }
        };
        Ok(self.table.insert(table))
    }
}

impl Brdf for MeanReference<'_> {
    fn spectral(&mut self, pairs: &[Pair], wavelength: f64) -> Result<Vec<f64>> {
        self.answered += pairs.len();
        let many = self.answered > WORTH_A_TABLE;
        let footprint = self.footprint;
        if many && !self.too_large {
            match self.table() {
                Ok(table) => return Ok(spectral(table, pairs, wavelength, &footprint)),
                // The direct sum needs no memory.
                Err(e) if e.is_too_large() => self.too_large = true,
                Err(e) => return Err(e),
            }
        }
        let values = pairs.iter().map(|pair| self.mean.brdf(pair, wavelength, &footprint)).collect();
        if !self.mean.reflectance.is_limited() {
            return Ok(values);
        }
        let table = self.table().map_err(|e| e.or(Remedy::UnlimitedTheory))?;
        Ok(limited(table, pairs, wavelength, values))
    }

    fn xyz(&mut self, pairs: &[Pair]) -> Result<Vec<DVec3>> {
        let (illuminant, footprint, progress) = (self.illuminant, self.footprint, self.progress);
        xyz(self.table()?, pairs, illuminant, &footprint, progress)
    }

    fn average_over(&mut self, deviation: f64) -> bool {
        self.footprint = Covariance::round(deviation);
        true
    }

    fn albedo(&mut self, light: DVec3, wavelength: Option<f64>) -> Result<Option<f64>> {
        let illuminant = self.illuminant;
        // Direct sums answer where there is no series of all orders.
        if self.too_large {
            return Ok(None);
        }
        match self.table() {
            Ok(table) => Ok(table.sent(light, wavelength, illuminant)),
            Err(e) if e.is_too_large() => {
                self.too_large = true;
                Ok(None)
            }
            Err(e) => Err(e),
        }
    }

    fn batch(&self) -> usize {
        if self.table.is_some() { AT_ONCE } else { WORTH_A_TABLE }
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
    fn mean(field: &HeightField) -> MeanBrdf<'_> {
        let reflectance = Reflectance::from(1.5).by(Theory::Stam);
        MeanBrdf { field, sigma: 1.25, beyond: Beyond::Copies, reflectance }
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
        let found = MeanReference::new(mean.clone(), &Illuminant::D65, 0.4).spectral(&pairs, 0.5).unwrap();
        let orders = TabulatedMean::new(mean.clone(), 0.4, &|_, _| Ok(())).unwrap();
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
            let mut answers = MeanFromOrders::new(mean(&field), &Illuminant::D65, 1e-3);
            let (mut squares, mut faintest, mut brightest) = (0.0, f64::INFINITY, 0.0f64);
            let pairs = pairs(100);
            for wavelength in [0.3, 0.45, 0.7] {
                let found = answers.spectral(&pairs, wavelength).unwrap();
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
    fn an_answer_depends_on_its_own_question_alone() {
        let [field, _] = short_patches();
        let pairs = pairs(20);
        let mut alone = MeanFromOrders::new(mean(&field), &Illuminant::D65, 1e-2);
        let one = (alone.spectral(&pairs[..1], 0.55).unwrap()[0], alone.xyz(&pairs[..1]).unwrap()[0]);
        let mut together = MeanFromOrders::new(mean(&field), &Illuminant::D65, 1e-2);
        let _ = together.spectral(&pairs, 0.2).unwrap();
        assert_eq!(together.spectral(&pairs, 0.55).unwrap()[0], one.0);
        assert_eq!(together.xyz(&pairs).unwrap()[0], one.1);
    }

    #[test]
    fn colours_keep_the_tolerance_each_by_itself() {
        for field in short_patches() {
            let pairs = pairs(50);
            // The trapezoid rule over many wavelengths.
            let nodes = Wavelengths::trapezoid(&Illuminant::D65, 4001);
            let mut single = MeanFromOrders::new(mean(&field), &Illuminant::D65, 1e-3);
            let mut exact = vec![DVec3::ZERO; pairs.len()];
            for (weight, q) in nodes.weights.iter().zip(&nodes.wavenumbers) {
                let wavelength = 1.0 / q;
                let values = single.spectral(&pairs, wavelength.max(SHORTEST)).unwrap();
                exact.iter_mut().zip(values).for_each(|(sum, value)| *sum += *weight * value);
            }
            for tolerance in [1e-1, 1e-2] {
                let mut answers = MeanFromOrders::new(mean(&field), &Illuminant::D65, tolerance);
                let found = answers.xyz(&pairs).unwrap();
                let square = |(a, b): (&DVec3, &DVec3)| (*a - *b).length_squared() / b.length_squared();
                let rms = (found.iter().zip(&exact).map(square).sum::<f64>() / pairs.len() as f64).sqrt();
                eprintln!("{tolerance:e}: {rms:.1e}");
                assert!(rms <= tolerance, "{tolerance}: {rms}");
            }
        }
    }
}
