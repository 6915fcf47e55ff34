//! Baselines that `trade` compares with: the grating equation and the shader of the thesis.

use crate::cli::benchmark::{BenchmarkOptions, BenchmarkScene, References, TimingLimits, shown};
use crate::error::Result;
use crate::measure::trade::{GRATING, Measurement, THESIS};
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::SHORTEST;
use crate::render::renderer::Renderer;
use crate::render::source::{ClassicalGrating, Source, Thesis};
use crate::spectra::amplitude::thesis;
use crate::surface::statistics::line_periods;
use std::sync::Arc;

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
    /// A baseline that cannot be drawn.
    pub fn measure(&self, series: &str, references: &mut References) -> Result<Option<Measurement>> {
        match series {
            GRATING => self.grating(references),
            _ => self.thesis(references),
        }
    }

    /// Measures the classical shader of a grating of one period, at the brightness that fits the reference best. `None` for a surface that
    /// is not periodic.
    fn grating(&self, references: &mut References) -> Result<Option<Measurement>> {
        let [along_x, along_y] = line_periods(&self.scene.field);
        let (axis, period) = match (along_x, along_y) {
            (Some(period), _) => ([1.0, 0.0], period),
            (None, Some(period)) => ([0.0, 1.0], period),
            (None, None) => return Ok(None),
        };
        let shading = self.scene.shading(self.options)?;
        let classical = |strength| Source::ClassicalGrating(ClassicalGrating { axis, period, strength });
        let (mut renderer, directions) = self.scene.renderer(&classical(0.0), &shading)?;
        let exact = references.of(self.scene, &shading, &directions)?;
        let colors = |renderer: &mut Renderer, strength: f64| {
            renderer.set_source(&classical(strength), &shading)?;
            self.scene.paint(renderer).map(|picture| shown(&picture, &exact.pixels))
        };
        // The picture is linear in the strength: a least-squares fit between the pictures of strengths 0 and 1.
        let (pigment, one) = (colors(&mut renderer, 0.0)?, colors(&mut renderer, 1.0)?);
        let pixels = pigment.iter().zip(&one).zip(&exact.colors);
        let (product, square) = pixels.fold((0.0, 0.0), |(p, s), ((pigment, one), exact)| {
            let orders = *one - *pigment;
            (p + orders.dot(*exact - *pigment), s + orders.length_squared())
        });
        let strength = if square > 0.0 { (product / square).max(0.0) } else { 0.0 };
        renderer.set_source(&classical(strength), &shading)?;
        Ok(Some(Measurement {
            flags: format!("grating equation, one period of {:.0} nm, for comparison", period * 1e3),
            series: GRATING.to_owned(),
            kernel: "none".to_owned(),
            ..self.scene.measure(&mut renderer, exact, self.limits)?
        }))
    }

    /// Measures the sum of the thesis' shader. `None` for repeats, for which the thesis has another sum.
    fn thesis(&self, references: &mut References) -> Result<Option<Measurement>> {
        let shading = self.scene.shading(self.options)?;
        let Coherence::Gaussian { length } = shading.coherence else { return Ok(None) };
        let field = &self.scene.field;
        let layers = Arc::new(thesis::layers(field, length / 4.0, SHORTEST)?);
        let (low, high) = field.range();
        let source = Source::Thesis(Thesis { layers, half_range: (high - low) / 2.0 });
        let (mut renderer, directions) = self.scene.renderer(&source, &shading)?;
        let exact = references.of(self.scene, &shading, &directions)?;
        let cost = source.cost(&shading, &directions);
        Ok(Some(Measurement {
            flags: "the thesis' sum: 37 terms, 81 wavelengths, 3 x 3 reads, for comparison".to_owned(),
            series: THESIS.to_owned(),
            terms: thesis::TERMS,
            layers: thesis::TERMS,
            kernel: "3 x 3 bins".to_owned(),
            wavelengths: cost.wavelengths_per_pixel(),
            samples: cost.samples_per_pixel(),
            ..self.scene.measure(&mut renderer, exact, self.limits)?
        }))
    }
}
