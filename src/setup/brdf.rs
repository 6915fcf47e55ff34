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

/// Calls `ask` with the BRDF of `field` under `settings` and its weight in the mean: once, or once for each window, column by column,
/// if the method evaluates one window at a time or `settings` ask for it. All windows share a limit of energy. Notes for the user go
/// to `context`, which also has the device, if one is needed.
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
    let illuminant = optics.illuminant.clone();
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
            ask(&mut MeanReference::new(mean()?, illuminant, settings.shortest), 1.0)
        }
        (Method::Reference, Windows::Grid(windows)) => {
            for_each_sum(field, settings, windows, context, task, ask)
        }
        (Method::Spectral, Windows::All) => {
            ask(&mut MeanFromOrders::new(mean()?, illuminant, optics.tolerance), 1.0)
        }
        _ => for_each_source(field, settings, context, task, ask),
    }
}

/// Does [`for_each_window`] by direct sums.
fn for_each_sum(
    field: &HeightField,
    settings: &SourceSettings,
    windows: [u32; 2],
    context: &Context,
    task: &Task,
    mut ask: impl FnMut(&mut dyn Brdf, f64) -> Result<()>,
) -> Result<()> {
    let (limit, too_high) = single_limit(field, settings, task)?;
    too_high.iter().for_each(|note| context.tell(note));
    let limit = limit.map(|limit| limit as Arc<dyn EnergyLimit>);
    let Optics { coherence, reflectance, illuminant, .. } = &settings.optics;
    let sum = |field: &HeightField, windows| {
        let reference = Reference::new(field, *coherence, windows, reflectance.clone());
        DirectSum { reference: reference.limited(limit.clone()), illuminant: illuminant.clone() }
    };
    if !settings.windows_apart {
        return ask(&mut sum(field, windows), 1.0);
    }
    // A window elsewhere on the periodic surface is this window on the moved surface.
    shifts(field, windows)
        .try_for_each(|shift| ask(&mut sum(&field.begun_at(shift), [1, 1]), weight(windows)))
}

/// Does [`for_each_window`] by sources on the device.
fn for_each_source(
    field: &HeightField,
    settings: &SourceSettings,
    context: &Context,
    task: &Task,
    mut ask: impl FnMut(&mut dyn Brdf, f64) -> Result<()>,
) -> Result<()> {
    let optics = &settings.optics;
    let device = context.device()?;
    let limit = shared_limit(field, settings);
    let windows @ [n, m] = optics.windows.grid().unwrap_or([1, 1]);
    // Spectra of many windows would fill the cache.
    let mut in_use = if n * m <= CACHED_WINDOWS { InUse::new(context) } else { InUse::default() };
    let mut energy = None;
    // Colour tables contain the average.
    let one = match optics.windows {
        Windows::Grid(_) => Optics { windows: Windows::ONE, ..optics.clone() },
        Windows::All => optics.clone(),
    };
    for shift in shifts(field, windows) {
        let settings = SourceSettings { optics: one.clone(), shift, ..settings.clone() };
        let made = source(field, &settings, device.candidate(), &mut in_use, task)?;
        made.note.iter().for_each(|note| context.tell(note));
        let mut brdf = DeviceBrdf::new(&device, &made.source, &one)?.limited(Arc::clone(&limit));
        // Kept for the next window.
        energy = made.source.energy().cloned().or(energy);
        drop(made);
        ask(&mut brdf, weight(windows))?;
    }
    Ok(())
}

/// Returns the limit of `field`, made where it is first needed: colours never do.
fn shared_limit(field: &HeightField, settings: &SourceSettings) -> Arc<MakeLimit> {
    let made_limit = OnceLock::new();
    let (field, settings) = (field.clone(), settings.clone());
    Arc::new(move |task| {
        if let Some(limit) = made_limit.get() {
            return Ok(Option::clone(limit));
        }
        let (limit, _) = single_limit(&field, &settings, task)?;
        Ok(made_limit.get_or_init(|| limit).clone())
    })
}

/// Returns the offset of each of n × m windows \[µm\], which are spread evenly over the patch, column by column.
fn shifts(field: &HeightField, [n, m]: [u32; 2]) -> impl Iterator<Item = [f64; 2]> {
    let [width, height] = field.patch_size();
    let part = |number: u32, of: u32, side: f64| f64::from(number) / f64::from(of) * side;
    (0..n).flat_map(move |i| (0..m).map(move |j| [part(i, n, width), part(j, m, height)]))
}

/// Returns the weight of each of n × m windows in their mean.
fn weight([n, m]: [u32; 2]) -> f64 {
    1.0 / (f64::from(n) * f64::from(m))
}
