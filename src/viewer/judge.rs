//! The error of what is shown, measured: random pixels against the direct sum in f64.

use crate::error::{Error, Result};
use crate::render::frame::View;
use crate::render::picture::{Directions, Painter};
use crate::render::reference_picture::reference_picture;
use super::worker::Prepared;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Pixels that are judged.
pub const PIXELS: usize = 300;
/// Pixels that are enough to count the cost of a picture by.
const COUNTED: usize = 4096;

/// What a pixel shows, and its directions for each light.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Linear sRGB radiance.
    pub radiance: [f32; 4],
    /// ω_i and ω_r for each light.
    pub directions: Vec<[[f32; 4]; 2]>,
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
    // A prime stride beside a picture's width does not fall on the same columns.
    let stride = (pixels / COUNTED).max(1) | 1;
    let some = |all: &[[f32; 4]]| all.iter().step_by(stride).copied().collect();
    directions.iter().map(|d| Directions { light: some(&d.light), view: some(&d.view) }).collect()
}

/// Random pixels of the picture of `view` that `painter` has just drawn, all of them where the mesh covers.
///
/// # Errors
/// Where the device is lost.
pub fn samples(painter: &mut Painter, view: &View) -> Result<Vec<Sample>> {
    let radiance = painter.picture()?.radiance;
    let directions = directions(painter, view)?;
    let covered: Vec<usize> = (0..radiance.len()).filter(|&i| radiance[i][3] > 0.0).collect();
    let mut chance = Chance(0x9e37_79b9_7f4a_7c15);
    let sample = |index: usize| Sample {
        radiance: radiance[index],
        directions: directions.iter().map(|d| [d.light[index], d.view[index]]).collect(),
    };
    let count = if covered.is_empty() { 0 } else { PIXELS };
    Ok((0..count).map(|_| sample(covered[chance.below(covered.len())])).collect())
}

/// Numbers without a pattern that matters here (Vigna's splitmix64); the same each time, so that a measurement can be repeated.
struct Chance(u64);

impl Chance {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % end as u64) as usize
    }
}

/// How far a measurement has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Pixels judged.
    pub done: usize,
    /// Pixels to judge.
    pub of: usize,
    /// Relative L2 error over them.
    pub error: f64,
}

/// A measurement in the background; dropping it ends it after the pixel at hand, which nobody waits for.
pub struct Judge {
    stop: Arc<AtomicBool>,
}

impl Judge {
    /// Judges `samples` of `prepared` under `view` one after another, and tells `say` after each.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn new(
        prepared: Arc<Prepared>,
        view: View,
        samples: Vec<Sample>,
        say: impl Fn(Result<Verdict>) + Send + 'static,
    ) -> Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let work = move || {
            let (mut difference, mut whole) = (0.0, 0.0);
            for (index, sample) in samples.iter().enumerate() {
                let judged = against(&prepared, &view, sample);
                if stopped.load(Ordering::Relaxed) {
                    return;
                }
                match judged {
                    Ok([d, w]) => {
                        difference += d;
                        whole += w;
                        let error = (difference / whole).sqrt();
                        say(Ok(Verdict { done: index + 1, of: samples.len(), error }));
                    }
                    Err(e) => return say(Err(e)),
                }
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

/// Squared difference of a sample from the direct sum, and the sum squared.
fn against(prepared: &Prepared, view: &View, sample: &Sample) -> Result<[f64; 2]> {
    let directions: Vec<Directions> =
        sample.directions.iter().map(|&[light, seen]| Directions { light: vec![light], view: vec![seen] }).collect();
    let exact =
        reference_picture(&prepared.field, &prepared.shading, view, &directions, &|_, _| Ok(()))?;
    let square = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let exact: [f64; 3] = std::array::from_fn(|i| f64::from(exact[0][i]));
    let difference = std::array::from_fn(|i| f64::from(sample.radiance[i]) - exact[i]);
    Ok([square(difference), square(exact)])
}
