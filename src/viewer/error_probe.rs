//! Measures the error of the picture shown: random pixels against the f64 reference.

use super::prepared::Prepared;
use super::threads;
use crate::error::Result;
use crate::measure::error::{PixelErrors, sample};
use crate::render::directions::Directions;
use crate::render::frame::View;
use crate::render::reference_picture::{covered, reference_pixels};
use crate::render::renderer::Renderer;
use crate::task::{Progress, Task};
use glam::DVec3;
use std::sync::Arc;

/// Number of pixels that are compared.
const PIXELS: usize = 300;
/// Number of pixels that suffice to estimate the cost of a picture.
const COUNTED: usize = 4096;

/// Pixels of a picture, with the directions they were shaded for.
#[derive(Clone, Debug)]
pub struct ProbeSamples {
    /// Linear sRGB radiance of each pixel.
    pub radiance: Vec<DVec3>,
    /// Directions of each pixel, one entry per light.
    pub directions: Vec<Directions>,
}

/// Returns the directions of every pixel, one entry per light of `view`.
///
/// # Errors
/// Fails if the device is lost.
pub fn directions(renderer: &mut Renderer, view: &View) -> Result<Vec<Directions>> {
    (0..view.light_count()).map(|light| renderer.directions(view, light)).collect()
}

/// Returns a subset of the pixels, evenly spaced, that suffices to estimate the cost of a picture.
pub fn thinned(directions: &[Directions], pixels: usize) -> Vec<Directions> {
    // With an odd stride the samples of a picture of even width are not confined to a few columns.
    let stride = (pixels / COUNTED).max(1) | 1;
    let of_light = |seen: &Directions| {
        let chosen: Vec<usize> = (0..seen.view.len()).step_by(stride).collect();
        seen.of_pixels(&chosen)
    };
    directions.iter().map(of_light).collect()
}

/// Returns random pixels of the first object in the last picture of `view` drawn by `renderer`.
///
/// # Errors
/// Fails if the device is lost.
pub fn samples(renderer: &mut Renderer, view: &View) -> Result<ProbeSamples> {
    let radiance = renderer.read_back()?.radiance;
    let directions = directions(renderer, view)?;
    let mut pixels = covered(&directions);
    // The settings apply to the first object alone.
    pixels.retain(|&pixel| directions.iter().all(|seen| seen.object(pixel) == 0));
    let chosen = sample(&pixels, PIXELS);
    Ok(ProbeSamples {
        radiance: chosen
            .iter()
            .map(|&i| DVec3::from_array([0, 1, 2].map(|c| radiance[i][c].into())))
            .collect(),
        directions: directions.iter().map(|seen| seen.of_pixels(&chosen)).collect(),
    })
}

/// Pixels to compare with the reference, and the settings they were drawn with.
pub struct ProbeTask {
    /// Surface and settings.
    pub prepared: Arc<Prepared>,
    /// Camera and lights.
    pub view: View,
    /// Exposure \[stops\].
    pub exposure: f64,
    /// Pixels.
    pub samples: ProbeSamples,
}

/// State of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeStatus {
    /// Fraction of the work that is done.
    Running(f32),
    /// Result.
    Done(PixelErrors),
}

/// Measurement in the background. Dropping it cancels the measurement without waiting.
pub struct ErrorProbe {
    task: Task,
}

impl ErrorProbe {
    /// Compares the pixels of `probe` with the reference and sends progress and result to `reply`.
    ///
    /// # Errors
    /// Fails if the system refuses a thread.
    pub fn new(
        probe: ProbeTask,
        reply: impl Fn(Result<ProbeStatus>) + Send + Sync + 'static,
    ) -> Result<Self> {
        let reply = Arc::new(reply);
        let task = Task::reporting({
            let reply = Arc::clone(&reply);
            move |Progress { done, of, .. }| reply(Ok(ProbeStatus::Running(done as f32 / of.max(1) as f32)))
        });
        let running = task.clone();
        let work = move || {
            let errors = probe.errors(&running);
            if !running.is_cancelled() {
                reply(errors.map(ProbeStatus::Done));
            }
        };
        threads::spawn("reference", work)?;
        Ok(Self { task })
    }
}

impl ProbeTask {
    fn errors(&self, task: &Task) -> Result<PixelErrors> {
        let (field, optics) = (&self.prepared.field, self.prepared.optics());
        let ProbeSamples { radiance, directions } = &self.samples;
        let pixels: Vec<usize> = (0..radiance.len()).collect();
        let exact = reference_pixels(field, optics, &self.view, directions, &pixels, task)?;
        Ok(PixelErrors::of(radiance, &exact, self.exposure))
    }
}

impl Drop for ErrorProbe {
    fn drop(&mut self) {
        self.task.cancel();
    }
}
