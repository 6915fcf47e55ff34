//! The error of what is shown, measured: random pixels against f64 optics.

use super::worker::Prepared;
use crate::error::{Error, Result};
use crate::measure::error::{PixelErrors, sample};
use crate::render::frame::View;
use crate::render::picture::{Directions, Painter};
use crate::render::reference_picture::{covered, reference_pixels};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Pixels that are judged.
const PIXELS: usize = 300;
/// Pixels that are enough to count the cost of a picture by.
const COUNTED: usize = 4096;

/// What some pixels show, and their directions for each light.
#[derive(Clone, Debug)]
pub struct Samples {
    /// Linear sRGB radiance of each.
    pub radiance: Vec<DVec3>,
    /// Directions of each, one entry a light.
    pub directions: Vec<Directions>,
}

/// The directions of each light of `view`.
///
/// # Errors
/// Where the device is lost.
pub fn directions(painter: &mut Painter, view: &View) -> Result<Vec<Directions>> {
    (0..view.lights.len()).map(|light| painter.directions(view, light)).collect()
}

/// Some thousand of `pixels`, evenly.
pub fn thinned(directions: &[Directions], pixels: usize) -> Vec<Directions> {
    // An odd stride does not fall on the same columns of a picture of even width.
    let stride = (pixels / COUNTED).max(1) | 1;
    let some = |all: &[[f32; 4]]| all.iter().step_by(stride).copied().collect();
    directions
        .iter()
        .map(|d| Directions { light: some(&d.light), view: some(&d.view), ..Directions::default() })
        .collect()
}

/// Random pixels of the picture of `view` that `painter` has just drawn, all of them where the mesh covers.
///
/// # Errors
/// Where the device is lost.
pub fn samples(painter: &mut Painter, view: &View) -> Result<Samples> {
    let radiance = painter.picture()?.radiance;
    let directions = directions(painter, view)?;
    let chosen = sample(&covered(&directions), PIXELS);
    let some = |all: &[[f32; 4]]| chosen.iter().map(|&i| all[i]).collect();
    Ok(Samples {
        radiance: chosen
            .iter()
            .map(|&i| DVec3::from_array([0, 1, 2].map(|c| radiance[i][c].into())))
            .collect(),
        directions: directions
            .iter()
            .map(|d| Directions { light: some(&d.light), view: some(&d.view), ..Directions::default() })
            .collect(),
    })
}

/// How far a measurement has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Part of the work that is done.
    Working(f32),
    /// What was found.
    Found(PixelErrors),
}

/// A measurement in the background; dropping it ends it soon, and nobody waits for that.
pub struct Judge {
    stop: Arc<AtomicBool>,
}

impl Judge {
    /// Judges `samples` of `prepared` under `view`, displayed at `exposure`, and tells `say` how it goes.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn new(
        prepared: Arc<Prepared>,
        view: View,
        exposure: f64,
        samples: Samples,
        say: impl Fn(Result<Verdict>) + Send + 'static,
    ) -> Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let work = move || {
            let stopped = || stopped.load(Ordering::Relaxed);
            let progress = |done: usize, of: usize| {
                if stopped() {
                    return Err(Error::failed("the picture has changed", "measure again"));
                }
                say(Ok(Verdict::Working(done as f32 / of.max(1) as f32)));
                Ok(())
            };
            let pixels: Vec<usize> = (0..samples.radiance.len()).collect();
            let (field, shading) = (&prepared.field, &prepared.shading);
            let exact = reference_pixels(field, shading, &view, &samples.directions, &pixels, &progress);
            if !stopped() {
                say(exact.map(|exact| Verdict::Found(PixelErrors::of(&samples.radiance, &exact, exposure))));
            }
        };
        std::thread::Builder::new().name("reference".to_owned()).spawn(work).map_err(|e| {
            Error::failed(format!("the system gives no thread ({e})"), "close other programs")
        })?;
        Ok(Self { stop })
    }
}

impl Drop for Judge {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}
