//! Answers through repeats by the device: it gives the response of one period, which is smooth, and the periodic factor is
//! multiplied here in f64, where it is stable at the orders however sharp they are.

use super::prepare;
use crate::error::{Error, Result};
use crate::optics::orders::{Repeats, Sampling};
use crate::optics::quadrature::{Ladder, Nodes};
use crate::optics::spectrum::Illuminant;
use crate::render::evaluator::{Evaluator, Query};
use crate::render::shading::Shading;
use crate::surface::HeightField;
use crate::vk::device::Device;
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// Part of the tolerance that the sum over wavelengths may take, as with a Gaussian window.
const QUADRATURE_SHARE: f64 = 0.6;
/// Most wavelengths for one colour.
const MAX_NODES: usize = 20_000;
/// Responses of one period that are asked for at once.
const AT_ONCE: usize = 16_384;

/// One period on the device, and its repeats.
pub struct Repeated {
    evaluator: Evaluator,
    repeats: Repeats,
    illuminant: Illuminant,
    tolerance: f64,
    /// Combs by their number of nodes.
    combs: BTreeMap<usize, Nodes>,
}

impl Repeated {
    /// `copies` of `field`, for wavelengths from `shortest` \[µm\].
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(
        field: &HeightField,
        copies: [u32; 2],
        shading: &Shading,
        shortest: f64,
        device: &Arc<Device>,
    ) -> Result<Self> {
        let mut layers = prepare::windowed_layers(field, shading, f64::INFINITY, shortest, device)?;
        let repeats = Repeats { copies, period: field.patch_size() };
        // What a window's σ stands for in the shader is 4πσ² = |peak|²/A: (n m T_x T_y)² over A = n m T_x T_y.
        let [n, m] = copies.map(f64::from);
        layers.sigma = (n * m * repeats.period[0] * repeats.period[1] / (4.0 * PI)).sqrt();
        // Colours are summed here, so the device's own combs are the smallest there are.
        let single = Shading { wavelengths: Some(4), ..shading.clone() };
        Ok(Self {
            evaluator: Evaluator::new(device, &layers, &single)?,
            repeats,
            illuminant: shading.illuminant.clone(),
            tolerance: shading.tolerance * QUADRATURE_SHARE,
            combs: BTreeMap::new(),
        })
    }

    /// f·cos θ_i \[sr⁻¹\] of every query, in order: three times the value at its wavelength, or the XYZ of the colour.
    /// `done` is called for each.
    ///
    /// # Errors
    /// Where the device is lost, or a colour would take too many wavelengths.
    pub fn cosine_weighted(&mut self, queries: &[Query], done: &dyn Fn()) -> Result<Vec<DVec3>> {
        let mut sums = vec![DVec3::ZERO; queries.len()];
        // Responses of one period, each with the query it belongs to and its weight there.
        let mut asked: Vec<(Query, usize, DVec3)> = Vec::new();
        for (place, query) in queries.iter().enumerate() {
            for (q, weight) in self.terms(query)? {
                let one = Query { pair: query.pair, wavelength: Some(1.0 / q) };
                asked.push((one, place, weight));
            }
            if asked.len() >= AT_ONCE {
                self.add(&mut asked, &mut sums)?;
            }
            done();
        }
        self.add(&mut asked, &mut sums)?;
        Ok(sums)
    }

    /// Adds what is `asked` for to `sums`, and forgets it.
    fn add(&mut self, asked: &mut Vec<(Query, usize, DVec3)>, sums: &mut [DVec3]) -> Result<()> {
        for part in asked.chunks(AT_ONCE) {
            let single: Vec<Query> = part.iter().map(|(query, ..)| *query).collect();
            for ((_, place, weight), f) in part.iter().zip(self.evaluator.cosine_weighted(&single)?) {
                sums[*place] += *weight * f.x;
            }
        }
        asked.clear();
        Ok(())
    }

    /// Wavenumbers \[µm⁻¹\] and weights whose responses make up the answer to `query`.
    fn terms(&mut self, query: &Query) -> Result<Vec<(f64, DVec3)>> {
        if !query.pair.above_horizon() {
            return Ok(Vec::new());
        }
        let uv = query.pair.uvw().truncate();
        if let Some(wavelength) = query.wavelength {
            let q = 1.0 / wavelength;
            return Ok(vec![(q, DVec3::splat(self.repeats.factor(uv * q)))]);
        }
        match self.repeats.sampling(uv, self.tolerance) {
            Sampling::Orders(axis) => Ok(self.repeats.orders(axis, uv, &self.illuminant)),
            Sampling::Comb(needed) => {
                if needed > MAX_NODES {
                    return Err(Error::failed(
                        format!(
                            "the colour of one direction would take {needed} wavelengths at these repeats"
                        ),
                        "ask for single wavelengths, or for fewer repeats",
                    ));
                }
                // Rounded up to a ladder of counts, so that few combs are ever made.
                let step = (needed as f64).ln() / Ladder::RATIO.ln();
                let count = Ladder::RATIO.powf(step.ceil()).ceil() as usize;
                let illuminant = &self.illuminant;
                let comb = self.combs.entry(count).or_insert_with(|| Nodes::catmull_rom(illuminant, count));
                Ok(self.repeats.comb(comb, uv))
            }
        }
    }
}
