//! BRDF of a height field by the chosen method.

use super::{InUse, SourceSettings, single_limit, source};
use crate::brdf::mean::MeanBrdf;
use crate::brdf::{Brdf, DirectSum, MeanFromOrders, MeanReference};
use crate::context::Context;
use crate::error::Result;
use crate::optics::coherence::Windows;
use crate::optics::energy::EnergyLimit;
use crate::optics::reference::Reference;
use crate::render::device_brdf::{DeviceBrdf, MakeLimit};
use crate::settings::{Method, Optics};
use crate::surface::HeightField;
use crate::task::Task;
use std::sync::{Arc, OnceLock};

/// Maximum number of windows whose spectra the cache on disk keeps: more would fill it.
const CACHED_WINDOWS: u32 = 16;

/// Calls `ask` with the BRDF of `field` under `settings` and its weight in the mean: once, or once for each window if
/// the method evaluates one window at a time. Notes for the user go to `context`, which also has the device, if one is needed.
///
/// # Errors
/// Same as [`source`], or the error of `ask`.
pub fn for_each_window(
    field: &HeightField,
    settings: &SourceSettings,
    context: &Context,
    task: &Task,
    mut ask: impl FnMut(&mut dyn Brdf, f64) -> Result<()>,
) -> Result<()> {
    let optics = &settings.optics;
    optics.check()?;
    let illuminant = &optics.illuminant;
    let mean = || -> Result<MeanBrdf> {
        let sigma = settings.power_sigma()?;
        Ok(MeanBrdf {
            field: field.clone(),
            sigma,
            beyond: optics.beyond,
            reflectance: optics.reflectance.clone(),
        })
    };
    match (optics.method, optics.windows) {
        (Method::Reference, Windows::All) => {
            return ask(&mut MeanReference::new(mean()?, illuminant.clone(), settings.shortest), 1.0);
        }
        (Method::Reference, Windows::Grid(windows)) => {
            let (limit, too_high) = single_limit(field, settings, task)?;
            too_high.iter().for_each(|note| context.tell(note));
            let limit = limit.map(|limit| limit as Arc<dyn EnergyLimit>);
            let reference = Reference::new(field, optics.coherence, windows, optics.reflectance.clone());
            let reference = reference.limited(limit);
            return ask(&mut DirectSum { reference, illuminant: illuminant.clone() }, 1.0);
        }
        (Method::Spectral, Windows::All) => {
            return ask(&mut MeanFromOrders::new(mean()?, illuminant.clone(), optics.tolerance), 1.0);
        }
        _ => {}
    }
    let device = context.device()?;
    // All windows share a limit, which colours do not need.
    let made_limit = OnceLock::new();
    let (of, under) = (field.clone(), settings.clone());
    let limit: Arc<MakeLimit> = Arc::new(move |task| {
        if let Some(limit) = made_limit.get() {
            return Ok(Option::clone(limit));
        }
        let (limit, _) = single_limit(&of, &under, task)?;
        Ok(made_limit.get_or_init(|| limit).clone())
    });
    let [n, m] = optics.windows.grid().unwrap_or([1, 1]);
    // Spectra of many windows would fill the cache.
    let mut in_use = if n * m <= CACHED_WINDOWS { InUse::new(context) } else { InUse::default() };
    let mut energy = None;
    // Colour tables contain the average.
    let one = match optics.windows {
        Windows::Grid(_) => Optics { windows: Windows::ONE, ..optics.clone() },
        Windows::All => optics.clone(),
    };
    let patch = field.patch_size();
    for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let shift = [f64::from(i) / f64::from(n) * patch[0], f64::from(j) / f64::from(m) * patch[1]];
        let settings = SourceSettings { optics: one.clone(), shift, ..settings.clone() };
        let made = source(field, &settings, device.candidate(), &mut in_use, task)?;
        made.note.iter().for_each(|note| context.tell(note));
        let mut brdf = DeviceBrdf::new(&device, &made.source, &one)?.limited(Arc::clone(&limit));
        // Kept for the next window.
        energy = made.source.energy().cloned().or(energy);
        drop(made);
        ask(&mut brdf, 1.0 / (f64::from(n) * f64::from(m)))?;
    }
    Ok(())
}
