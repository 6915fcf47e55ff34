//! The BRDF for a list of directions, by whichever method is asked for.

use super::options::Method;
use super::prepare::{self, Window};
use super::repeated::Repeated;
use crate::error::{Error, Result};
use crate::optics::coherence::Coherence;
use crate::optics::geometry::Pair;
use crate::optics::reference::Reference;
use crate::optics::spectrum::SHORTEST;
use crate::render::evaluator::{Evaluator, Query};
use crate::render::shading::Shading;
use crate::surface::HeightField;
use crate::vk::device::Device;
use crate::vk::selection::DeviceChoice;
use glam::DVec3;
use indicatif::ProgressBar;
use std::sync::Arc;

/// Wavelengths that can be asked for \[µm\]: from hard ultraviolet to far infrared.
pub const WAVELENGTHS: (f64, f64) = (0.01, 100.0);
/// Queries that are worth a submission of their own, and few enough for a progress bar to move and for memory to stay
/// at a few megabytes.
pub const AT_ONCE: usize = 16_384;

/// Windows whose layers the cache keeps: more would fill a disk.
const KEPT_WINDOWS: u32 = 16;

/// A surface that is ready to be asked.
pub struct Answers<'a> {
    by: By<'a>,
    shading: &'a Shading,
    bar: ProgressBar,
}

/// What computes the answers.
enum By<'a> {
    Sum(Reference<'a>),
    Layers(Box<Evaluator>, Arc<Device>),
    Repeats(Box<Repeated>, Arc<Device>),
}

impl<'a> Answers<'a> {
    /// Makes `field` ready for wavelengths from `shortest` \[µm\]: the reference needs nothing, the layers need a device.
    ///
    /// # Errors
    /// Where there is no device or it has no room, and for settings that the method cannot do.
    pub fn prepare(
        method: Method,
        wish: &DeviceChoice,
        field: &'a HeightField,
        shading: &'a Shading,
        shortest: f64,
    ) -> Result<Self> {
        Self::prepare_at(method, wish, field, shading, Window::CENTRE, shortest)
    }

    /// The same; layers are those of `window`.
    fn prepare_at(
        method: Method,
        wish: &DeviceChoice,
        field: &'a HeightField,
        shading: &'a Shading,
        window: Window,
        shortest: f64,
    ) -> Result<Self> {
        let by = match method {
            Method::Reference => {
                prepare::warn_of_coarse_samples(field, shortest);
                By::Sum(Reference::new(field, shading.coherence, shading.windows, shading.ior))
            }
            Method::Spectral => {
                let device = prepare::device(wish)?;
                if let Coherence::Repeats(copies) = shading.coherence {
                    let repeated = Repeated::new(field, copies, window.shift, shading, shortest, &device)?;
                    return Ok(Self {
                        by: By::Repeats(Box::new(repeated), device),
                        shading,
                        bar: prepare::progress_bar("directions"),
                    });
                }
                let layers = prepare::layers_at(field, shading, window, shortest, &device)?;
                By::Layers(Box::new(Evaluator::new(&device, &layers, shading)?), device)
            }
            Method::Table => {
                let device = prepare::device(wish)?;
                let table = prepare::color_table(field, shading, &device)?;
                By::Layers(Box::new(Evaluator::new(&device, &table, shading)?), device)
            }
        };
        Ok(Self { by, shading, bar: prepare::progress_bar("directions") })
    }

    /// Lets the progress bar end at `count` queries.
    pub fn announce(&self, count: usize) {
        self.bar.set_length(count as u64);
    }

    /// f \[sr⁻¹\] of each query, in order: three times the value at its wavelength, or the XYZ of the colour. 0 below
    /// the horizon.
    ///
    /// # Errors
    /// Where the device is lost, or a colour would take too many wavelengths.
    pub fn brdf(&mut self, queries: &[Query]) -> Result<Vec<DVec3>> {
        let (shading, bar) = (self.shading, &self.bar);
        match &mut self.by {
            By::Sum(reference) => {
                let one = |query: &Query| {
                    bar.inc(1);
                    summed(reference, shading, query)
                };
                queries.iter().map(one).collect()
            }
            By::Layers(evaluator, _) => {
                let mut all = Vec::with_capacity(queries.len());
                for part in queries.chunks(AT_ONCE) {
                    let weighted = evaluator.cosine_weighted(part)?;
                    all.extend(part.iter().zip(weighted).map(|(q, f)| without_cosine(&q.pair, f)));
                    bar.inc(part.len() as u64);
                }
                Ok(all)
            }
            By::Repeats(repeated, _) => {
                let weighted = repeated.cosine_weighted(queries, &|| bar.inc(1))?;
                Ok(queries.iter().zip(weighted).map(|(q, f)| without_cosine(&q.pair, f)).collect())
            }
        }
    }

    /// Gives the device back.
    ///
    /// # Errors
    /// If validation had anything to say.
    pub fn finish(self) -> Result<()> {
        self.bar.finish_and_clear();
        match self.by {
            By::Sum(_) => Ok(()),
            By::Layers(evaluator, device) => {
                drop(evaluator);
                prepare::finish(&device)
            }
            By::Repeats(repeated, device) => {
                drop(repeated);
                prepare::finish(&device)
            }
        }
    }
}

/// Lets `ask` have the answers of `field` under `shading` to `count` queries, once, or, where the method does one window at a
/// time, once for each window, and tells it the share of these answers in the mean.
///
/// # Errors
/// As [`Answers::prepare`], and what `ask` returns.
pub fn over_windows(
    (method, wish): (Method, &DeviceChoice),
    field: &HeightField,
    shading: &Shading,
    (shortest, count): (f64, usize),
    mut ask: impl FnMut(&mut Answers, f64) -> Result<()>,
) -> Result<()> {
    // The others average by themselves.
    let [n, m] = if method == Method::Spectral { shading.windows } else { [1, 1] };
    let one = Shading { windows: [1, 1], ..shading.clone() };
    let shading = if method == Method::Spectral { &one } else { shading };
    let patch = field.patch_size();
    for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let shift = [f64::from(i) / f64::from(n) * patch[0], f64::from(j) / f64::from(m) * patch[1]];
        let window = Window { shift, kept: n * m <= KEPT_WINDOWS };
        let mut answers = Answers::prepare_at(method, wish, field, shading, window, shortest)?;
        answers.announce(count);
        ask(&mut answers, 1.0 / (f64::from(n) * f64::from(m)))?;
        answers.finish()?;
    }
    Ok(())
}

fn summed(reference: &Reference, shading: &Shading, query: &Query) -> Result<DVec3> {
    match query.wavelength {
        Some(wavelength) => Ok(DVec3::splat(reference.brdf(&query.pair, wavelength))),
        None => {
            let weighted = reference.cosine_weighted_xyz(&query.pair, &shading.illuminant)?;
            Ok(without_cosine(&query.pair, weighted))
        }
    }
}

/// f from f·cos θ_i; 0 below the horizon.
fn without_cosine(pair: &Pair, weighted: DVec3) -> DVec3 {
    if pair.above_horizon() { weighted / pair.light.z } else { DVec3::ZERO }
}

/// Fails where `method` has no single wavelengths.
pub fn check_single_wavelengths(method: Method) -> Result<()> {
    if method != Method::Table {
        return Ok(());
    }
    Err(Error::usage(
        "--method table holds colours, summed over the spectrum, and no single wavelength",
        "use --method spectral or --method reference",
    ))
}

/// The shortest wavelength that is asked for \[µm\]; colours ask for all.
pub fn shortest(queries: &[Query]) -> f64 {
    queries.iter().map(|q| q.wavelength.unwrap_or(SHORTEST)).fold(f64::INFINITY, f64::min)
}
