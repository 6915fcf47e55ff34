//! Answers through repeats by the device: it gives the response of one period, which is smooth, and the periodic factor is
//! multiplied here in f64, where it is stable at the orders however sharp they are.

use super::prepare;
use crate::error::Result;
use crate::optics::orders::{Colours, Repeats};
use crate::render::evaluator::{Evaluator, Query};
use crate::render::shading::Shading;
use crate::surface::HeightField;
use crate::vk::device::Device;
use glam::DVec3;
use std::sync::Arc;

/// Responses of one period that are asked for at once.
const AT_ONCE: usize = 16_384;

/// One period on the device, and its repeats.
pub struct Repeated {
    evaluator: Evaluator,
    repeats: Repeats,
    colours: Colours,
    tolerance: f64,
}

impl Repeated {
    /// `copies` of `field`, which begin `shift` \[µm\] from its edges, for wavelengths from `shortest` \[µm\].
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(
        field: &HeightField,
        copies: [u32; 2],
        shift: [f64; 2],
        shading: &Shading,
        shortest: f64,
        device: &Arc<Device>,
    ) -> Result<Self> {
        shading.check_wavelengths()?;
        let mut layers =
            prepare::windowed_layers(&field.begun_at(shift), shading, f64::INFINITY, shortest, device)?;
        let repeats = Repeats { copies, period: field.patch_size() };
        layers.sigma = repeats.sigma();
        // Colours are summed here, so the device's own combs are the smallest there are.
        let single = Shading { wavelengths: Some(4), ..shading.clone() };
        Ok(Self {
            evaluator: Evaluator::new(device, &layers, &single)?,
            repeats,
            colours: Colours::new(&shading.illuminant, shading.quadrature()),
            tolerance: shading.quadrature(),
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
    fn terms(&self, query: &Query) -> Result<Vec<(f64, DVec3)>> {
        if !query.pair.above_horizon() {
            return Ok(Vec::new());
        }
        let uv = query.pair.uvw().truncate();
        if let Some(wavelength) = query.wavelength {
            let q = 1.0 / wavelength;
            return Ok(vec![(q, DVec3::splat(self.repeats.factor(uv * q)))]);
        }
        let sampling = self.repeats.sampling(uv, self.colours.lag, self.tolerance);
        self.repeats.check(&sampling)?;
        Ok(self.repeats.terms(&sampling, uv, &self.colours))
    }
}
