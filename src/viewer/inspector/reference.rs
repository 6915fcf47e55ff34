//! Thread that evaluates the f64 reference for the inspected pixel. It keeps the reference's table until surface or
//! settings change.

use super::reading::{LightAt, Reading};
use crate::error::Result;
use crate::optics::spectrum::{LONGEST, SHORTEST};
use crate::render::reference_picture::PixelReference;
use crate::task::{Progress, Task};
use crate::viewer::prepared::Prepared;
use crate::viewer::threads;
use glam::DVec3;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Number of wavelengths of a spectrum, 5 nm apart.
pub const WAVELENGTHS: usize = 81;

/// Returns wavelength number `i` of a spectrum \[µm\].
pub fn wavelength(i: usize) -> f64 {
    SHORTEST + (LONGEST - SHORTEST) * i as f64 / (WAVELENGTHS - 1) as f64
}

/// Answer of the reference for a pixel.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Fraction of the preparation that is done.
    Preparing(f32),
    /// Result.
    Done {
        /// Linear sRGB radiance of the pixel, averaged over its footprint as the picture is.
        radiance: DVec3,
        /// BRDF under each light.
        lights: Vec<LightAnswer>,
    },
}

/// BRDF for the directions of a light and of the viewer, not averaged over the footprint.
#[derive(Clone, Debug, PartialEq)]
pub struct LightAnswer {
    /// f \[sr⁻¹\] at each [`wavelength`].
    pub spectrum: Vec<f64>,
    /// XYZ of f \[sr⁻¹\].
    pub xyz: DVec3,
}

/// Handle of the thread. Dropping it ends the thread without waiting.
pub struct DirectionReference {
    readings: Sender<Reading>,
    task: Task,
}

impl DirectionReference {
    /// Starts a thread that answers readings by their number to `reply`.
    ///
    /// # Errors
    /// Fails if the system refuses a thread.
    pub fn new(reply: impl Fn(u64, Result<Answer>) + Send + Sync + 'static) -> Result<Self> {
        let (readings, received) = channel();
        let task = Task::silent();
        let queue = Queue { received, task: task.clone() };
        let reply: Arc<Reply> = Arc::new(reply);
        let work = move || {
            let mut next = queue.next();
            while let Some(reading) = next {
                next = answer(reading, &queue, &reply);
            }
        };
        threads::spawn("inspector", work)?;
        Ok(Self { readings, task })
    }

    /// Requests an answer for `reading` and drops earlier requests.
    pub fn ask(&self, reading: Reading) {
        // Sending fails only after a panic of the thread, which is reported elsewhere.
        let _ = self.readings.send(reading);
    }
}

impl Drop for DirectionReference {
    fn drop(&mut self) {
        self.task.cancel();
    }
}

/// Receiver of the answers to readings, by their numbers.
type Reply = dyn Fn(u64, Result<Answer>) + Send + Sync;

struct Queue {
    received: Receiver<Reading>,
    task: Task,
}

impl Queue {
    /// Waits for the newest reading; `None` if the thread is to end.
    fn next(&self) -> Option<Reading> {
        let first = self.received.recv().ok()?;
        Some(self.newer(first)).filter(|_| !self.task.is_cancelled())
    }

    /// Returns the newest reading, which is `reading` if no other waits.
    fn newer(&self, reading: Reading) -> Reading {
        self.received.try_iter().last().unwrap_or(reading)
    }
}

/// Answers `first` and the following readings of the same surface and settings. Returns the first reading of others.
fn answer(first: Reading, queue: &Queue, reply: &Arc<Reply>) -> Option<Reading> {
    let prepared = first.prepared.clone();
    let Prepared { field, number, .. } = &*prepared;
    let told = Arc::clone(reply);
    let number_of_first = first.number;
    let task = queue.task.observed(move |Progress { done, of, .. }| {
        told(number_of_first, Ok(Answer::Preparing(done as f32 / of.max(1) as f32)));
    });
    let reference = PixelReference::new(field, prepared.optics(), &task);
    let mut reading = queue.newer(first.clone());
    while reading.prepared.number == *number && !queue.task.is_cancelled() {
        match &reference {
            Ok(reference) => reply(reading.number, of_pixel(reference, &reading, &queue.task)),
            Err(e) => reply(reading.number, Err(e.clone())),
        }
        reading = queue.next()?;
    }
    Some(reading).filter(|_| !queue.task.is_cancelled())
}

fn of_pixel(reference: &PixelReference, reading: &Reading, task: &Task) -> Result<Answer> {
    let wavelengths: Vec<f64> = (0..WAVELENGTHS).map(wavelength).collect();
    let colors = reference.colors(&reading.view, 0, &reading.directions, &[0], task)?;
    let of_light = |(number, light): (usize, &LightAt)| {
        Ok(LightAnswer {
            spectrum: reference.spectrum(&light.pair, &wavelengths),
            xyz: reference.xyz(&light.pair, reading.view.illuminant(number))?,
        })
    };
    let lights = reading.lights.iter().enumerate().map(of_light).collect::<Result<_>>()?;
    Ok(Answer::Done { radiance: colors.first().copied().unwrap_or_default(), lights })
}
