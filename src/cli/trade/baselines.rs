//! The baselines that `trade` compares with: the grating equation and the thesis' own shader.

use crate::cli::benchmark::{BenchmarkOptions, BenchmarkScene, References, TimingLimits, shown};
use crate::error::Result;
use crate::measure::trade::{GRATING, Measurement, THESIS};
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::SHORTEST;
use crate::precompute::thesis;
use crate::render::picture::Painter;
use crate::render::resources::Optics;
use crate::surface::statistics::Statistics;

/// Baselines of a frame.
pub struct Baselines<'a> {
    pub scene: &'a BenchmarkScene,
    /// Any setting of the frame; the baselines share its light and coherence.
    pub options: &'a BenchmarkOptions,
    pub limits: TimingLimits,
}

impl Baselines<'_> {
    /// Measures the baseline called `series`; `None` if it does not apply to this surface or coherence.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn measure(&self, series: &str, references: &mut References) -> Result<Option<Measurement>> {
        match series {
            GRATING => self.grating(references),
            _ => self.thesis(references),
        }
    }

    /// The classical shader of a grating of one period, at the brightness that fits the reference best. `None` for a surface
    /// that is not periodic.
    fn grating(&self, references: &mut References) -> Result<Option<Measurement>> {
        let [along_x, along_y] = Statistics::of(&self.scene.field).period;
        let (axis, period) = match (along_x, along_y) {
            (Some(period), _) => ([1.0, 0.0], period),
            (None, Some(period)) => ([0.0, 1.0], period),
            (None, None) => return Ok(None),
        };
        let mut benchmark = self.scene.prepare(self.options)?;
        let exact = references.of(self.scene, &benchmark.shading, &benchmark.directions)?;
        let painter = &mut benchmark.painter;
        let colors = |painter: &mut Painter, strength: f32| {
            painter.shade_as_grating(axis, period as f32, strength)?;
            self.scene.paint(painter).map(|picture| shown(&picture, &exact.pixels))
        };
        // The picture is linear in the strength: a least-squares fit between the pictures of strengths 0 and 1.
        let (pigment, one) = (colors(painter, 0.0)?, colors(painter, 1.0)?);
        let pixels = pigment.iter().zip(&one).zip(&exact.colors);
        let (product, square) = pixels.fold((0.0, 0.0), |(p, s), ((pigment, one), exact)| {
            let orders = *one - *pigment;
            (p + orders.dot(*exact - *pigment), s + orders.length_squared())
        });
        let strength = if square > 0.0 { (product / square).max(0.0) as f32 } else { 0.0 };
        painter.shade_as_grating(axis, period as f32, strength)?;
        Ok(Some(Measurement {
            flags: format!("grating equation, one period of {:.0} nm, for comparison", period * 1e3),
            series: GRATING.to_owned(),
            kernel: "none".to_owned(),
            ..self.scene.measure(painter, exact, self.limits)?
        }))
    }

    /// The sum of the thesis' own shader. `None` for repeats, for which the thesis has another sum.
    fn thesis(&self, references: &mut References) -> Result<Option<Measurement>> {
        let shading = self.options.optics.for_pictures(&self.options.colour)?;
        let Coherence::Gaussian { length } = shading.coherence else { return Ok(None) };
        let field = &self.scene.field;
        let layers = thesis::layers(field, length / 4.0, SHORTEST)?;
        let (low, high) = field.range();
        let mut painter = self.scene.painter(Optics::Thesis(&layers, (high - low) / 2.0), &shading)?;
        let directions = self.scene.directions(&mut painter)?;
        let exact = references.of(self.scene, &shading, &directions)?;
        let lights = self.scene.view.lights.len();
        // A texel holds two terms.
        let reads = thesis::WAVELENGTHS * thesis::TERMS.div_ceil(2) * thesis::TAPS * lights;
        Ok(Some(Measurement {
            flags: "the thesis' sum: 37 terms, 81 wavelengths, 3 x 3 reads, for comparison".to_owned(),
            series: THESIS.to_owned(),
            terms: thesis::TERMS,
            layers: thesis::TERMS,
            kernel: "3 x 3 bins".to_owned(),
            wavelengths: (thesis::WAVELENGTHS * lights) as f64,
            samples: reads as f64,
            ..self.scene.measure(&mut painter, exact, self.limits)?
        }))
    }
}
