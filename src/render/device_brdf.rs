//! A source on the device as a [`Brdf`].

use super::evaluator::{AT_ONCE, Evaluator, Query};
use super::source::Source;
use crate::brdf::albedo::DirectionalAlbedo;
use crate::brdf::energy_map::EnergyMap;
use crate::brdf::{Brdf, without_cosine};
use crate::error::Result;
use crate::optics::geometry::Pair;
use crate::optics::orders::{ColourFunctions, Repeats};
use crate::optics::quadrature::Wavelengths;
use crate::settings::Optics;
use crate::task::{DIRECTIONS, Task};
use crate::vk::device::Device;
use glam::DVec3;
use std::sync::{Arc, Mutex, PoisonError};

/// Maker of the limit of energy of single wavelengths; `None` where the theory has none.
pub type MakeLimit = dyn Fn(&Task) -> Result<Option<Arc<DirectionalAlbedo>>> + Send + Sync;

/// Evaluates a source on the device.
///
/// For a grating the device evaluates the response of one period, which is smooth. The periodic factor is multiplied
/// here in f64, which resolves orders of any sharpness.
pub struct DeviceBrdf {
    evaluator: Mutex<Evaluator>,
    // True if the source averages over footprints.
    averages: bool,
    grating: Option<PeriodicFactor>,
    limit: Option<Arc<MakeLimit>>,
    // Limit of the colours of a grating, which are sums over single wavelengths.
    energy: Option<Arc<EnergyMap>>,
}

impl DeviceBrdf {
    /// Uploads `source` for `optics`.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, source: &Source, optics: &Optics) -> Result<Self> {
        let grating = match source {
            Source::Grating(grating) => Some(PeriodicFactor {
                repeats: grating.repeats,
                colours: ColourFunctions::new(&optics.illuminant, optics.budget().window.wavelengths),
                tolerance: optics.budget().window.wavelengths,
            }),
            _ => None,
        };
        Ok(Self {
            evaluator: Mutex::new(Evaluator::new(device, source, optics)?),
            averages: matches!(source, Source::Table(_)),
            grating,
            limit: None,
            energy: source.energy().cloned(),
        })
    }

    /// Returns the same BRDF with single wavelengths within the limit of energy that `limit` makes once it is needed; colours have that of the source.
    pub fn limited(self, limit: Arc<MakeLimit>) -> Self {
        Self { limit: Some(limit), ..self }
    }

    fn ask(&self, pairs: &[Pair], wavelength: Option<f64>, task: &Task) -> Result<Vec<DVec3>> {
        let mut evaluator = self.evaluator.lock().unwrap_or_else(PoisonError::into_inner);
        let weighted = match &self.grating {
            Some(grating) => {
                let mut weighted = grating.cosine_weighted(&mut evaluator, pairs, wavelength, task)?;
                if let (None, Some(energy)) = (wavelength, &self.energy) {
                    weighted.iter_mut().zip(pairs).for_each(|(f, pair)| *f /= energy.limit(pair));
                }
                weighted
            }
            None => {
                let queries: Vec<Query> = pairs.iter().map(|&pair| Query { pair, wavelength }).collect();
                evaluator.cosine_weighted(&queries)?
            }
        };
        Ok(pairs.iter().zip(weighted).map(|(pair, f)| without_cosine(pair, f)).collect())
    }
}

impl Brdf for DeviceBrdf {
    fn spectral(&self, pairs: &[Pair], wavelength: f64, task: &Task) -> Result<Vec<f64>> {
        let values = self.ask(pairs, Some(wavelength), task)?.into_iter().map(|f| f.x);
        Ok(match self.limit.as_ref().map_or(Ok(None), |make| make(task))? {
            Some(limit) => values.zip(limit.limits(pairs, wavelength)).map(|(f, limit)| f / limit).collect(),
            None => values.collect(),
        })
    }

    fn xyz(&self, pairs: &[Pair], task: &Task) -> Result<Vec<DVec3>> {
        self.ask(pairs, None, task)
    }

    fn average_over(&mut self, deviation: f64) -> bool {
        let evaluator = self.evaluator.get_mut().unwrap_or_else(PoisonError::into_inner);
        evaluator.average_over(if self.averages { deviation } else { 0.0 });
        self.averages
    }

    fn batch(&self) -> usize {
        // A colour through a grating needs many responses.
        if self.grating.is_some() { AT_ONCE / 64 } else { AT_ONCE }
    }
}

/// Periodic factor of the copies of a period, and the colour functions summed through it.
struct PeriodicFactor {
    repeats: Repeats,
    colours: ColourFunctions,
    tolerance: f64,
}

impl PeriodicFactor {
    /// Returns f·cos θ_i \[sr⁻¹\] of every pair: the value at `wavelength` \[µm\] in all three components, or the XYZ
    /// of the colour, without a limit of energy.
    fn cosine_weighted(
        &self,
        evaluator: &mut Evaluator,
        pairs: &[Pair],
        wavelength: Option<f64>,
        task: &Task,
    ) -> Result<Vec<DVec3>> {
        let mut sums = vec![DVec3::ZERO; pairs.len()];
        // Responses of one period, each with the pair that it belongs to and its weight there.
        let mut asked: Vec<(Query, usize, DVec3)> = Vec::new();
        for (place, &pair) in pairs.iter().enumerate() {
            let Wavelengths { wavenumbers, weights } = self.wavelengths(&pair, wavelength)?;
            let single = |q: f64| Query { pair, wavelength: Some(1.0 / q) };
            asked.extend(wavenumbers.into_iter().zip(weights).map(|(q, weight)| (single(q), place, weight)));
            if asked.len() >= AT_ONCE {
                task.report(DIRECTIONS, place, pairs.len())?;
                add(evaluator, &mut asked, &mut sums)?;
            }
        }
        add(evaluator, &mut asked, &mut sums)?;
        Ok(sums)
    }

    /// Returns the wavelengths whose responses make up the value of `pair`.
    fn wavelengths(&self, pair: &Pair, wavelength: Option<f64>) -> Result<Wavelengths> {
        if !pair.above_horizon() {
            return Ok(Wavelengths { wavenumbers: Vec::new(), weights: Vec::new() });
        }
        let uv = pair.uvw().truncate();
        if let Some(wavelength) = wavelength {
            let q = 1.0 / wavelength;
            let weights = vec![DVec3::splat(self.repeats.factor(uv * q))];
            return Ok(Wavelengths { wavenumbers: vec![q], weights });
        }
        self.repeats.check(self.repeats.count(uv, &self.colours, self.tolerance))?;
        Ok(self.repeats.wavelengths(uv, &self.colours, self.tolerance))
    }
}

/// Evaluates the `asked` queries, adds them to `sums` and clears the list.
fn add(evaluator: &mut Evaluator, asked: &mut Vec<(Query, usize, DVec3)>, sums: &mut [DVec3]) -> Result<()> {
    for part in asked.chunks(AT_ONCE) {
        let single: Vec<Query> = part.iter().map(|(query, ..)| *query).collect();
        for ((_, place, weight), f) in part.iter().zip(evaluator.of_one_period(&single)?) {
            sums[*place] += *weight * f.x;
        }
    }
    asked.clear();
    Ok(())
}
