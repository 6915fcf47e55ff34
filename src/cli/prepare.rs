//! What commands need before they can shade: a device, and the layers, from the cache or made with a progress bar.

use super::{check_validation, say, validation};
use crate::error::{Error, Result};
use crate::expansion::Basis;
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::SHORTEST;
use crate::precompute::{self, Layers, Settings, cache};
use crate::render::color_table::{self, ColorTable, Grid, bake::layers_tolerance, check_tolerance};
use crate::render::shading::Shading;
use crate::surface::HeightField;
use crate::vk::device::Device;
use crate::vk::instance::Instance;
use crate::vk::selection::Wish;
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::Arc;

/// Share of the device's memory that the layers may take; pictures and the rest need some.
const DEVICE_SHARE: f64 = 0.75;

/// Opens the device that `wish` means.
pub fn device(wish: &Wish) -> Result<Arc<Device>> {
    Device::open(Arc::new(Instance::new(validation())?), wish)
}

/// Fails if validation had anything to say about `device` so far.
pub fn finish(device: &Device) -> Result<()> {
    check_validation(&device.instance().messages())
}

/// Layers of `field` for wavelengths from `shortest` \[µm\] on `device`.
pub fn layers(field: &HeightField, shading: &Shading, shortest: f64, device: &Device) -> Result<Layers> {
    if shading.windows != [1, 1] {
        return Err(Error::usage(
            "--method spectral does one window only",
            "leave --windows away, or use --method table or --method reference",
        ));
    }
    let settings = settings("spectral", shading, shortest, device)?;
    warn_of_coarse_samples(field, shortest);
    let folder = cache::folder();
    let key = cache::key(field, &settings);
    if let Some(layers) = folder.as_ref().and_then(|f| cache::load(f, &key, settings.memory_limit)) {
        return Ok(layers);
    }
    let bar = progress_bar("spectra");
    let layers = precompute::compute(field, &settings, &|done, of| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        Ok(())
    })?;
    bar.finish_and_clear();
    if let Some(folder) = folder
        && let Err(error) = cache::store(&folder, &key, &layers)
    {
        say(&format_args!("the spectra are not kept for next time: {error}"));
    }
    Ok(layers)
}

/// What layers are made for, where `shading` is asked for of `method`.
fn settings(method: &str, shading: &Shading, shortest: f64, device: &Device) -> Result<Settings> {
    let Coherence::Gaussian { length } = shading.coherence else {
        return Err(Error::usage(
            format!("--method {method} does not do --coherence repeats yet"),
            "use --coherence gaussian:LENGTH or --method reference",
        ));
    };
    Ok(Settings {
        sigma: length / 4.0,
        shortest_wavelength: shortest,
        tolerance: shading.tolerance,
        basis: shading.basis,
        terms: shading.terms,
        memory_limit: (device.candidate().memory as f64 * DEVICE_SHARE) as usize,
        side_limit: device.candidate().max_side as usize,
    })
}

/// The colour table of `field` on `device`, from the cache or baked with a progress bar.
pub fn color_table(field: &HeightField, shading: &Shading, device: &Arc<Device>) -> Result<ColorTable> {
    if shading.terms.is_some() {
        return Err(Error::usage(
            "--method table sums as many terms as its tolerance asks for",
            "leave --terms away, or use --method spectral",
        ));
    }
    check_tolerance(shading.tolerance)?;
    let tolerance = layers_tolerance(shading.tolerance);
    let for_layers = Shading { tolerance, basis: Basis::Phase, windows: [1, 1], ..shading.clone() };
    let settings = settings("table", &for_layers, SHORTEST, device)?;
    let room = settings.memory_limit as u64;
    // What is hopeless is refused before any work: a table has at least one node.
    Grid::new(settings.sigma, shading.tolerance, 1).check(device.candidate().max_side, room)?;
    let folder = cache::folder();
    let key = color_table::cache::key(field, &settings, shading);
    if let Some(table) = folder.as_ref().and_then(|f| color_table::cache::load(f, &key, room)) {
        warn_of_coarse_samples(field, SHORTEST);
        return Ok(table);
    }
    let layers = layers(field, &for_layers, SHORTEST, device)?;
    let bar = progress_bar("colours");
    let made = (field, layers, &settings);
    let table = color_table::make(device, made, shading, room, &|what, done, of| {
        bar.set_message(what);
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        Ok(())
    })?;
    bar.finish_and_clear();
    if let Some(folder) = folder
        && let Err(error) = color_table::cache::store(&folder, &key, &table)
    {
        say(&format_args!("the colour table is not kept for next time: {error}"));
    }
    Ok(table)
}

/// A height field sampled at dx knows nothing above 1/(2dx); directions ask for up to 2/λ.
pub fn warn_of_coarse_samples(field: &HeightField, shortest: f64) {
    let coarsest = field.pixel_size().into_iter().fold(0.0, f64::max);
    let needed = shortest / 4.0;
    // Spacings like 97.66 nm are meant to be enough; only what loses a visible part is told.
    if coarsest > needed * 1.001 {
        let limit = (shortest / (2.0 * coarsest)).min(2.0);
        say(&format_args!(
            "samples {:.1} nm apart hold |u| up to {limit:.2} at {:.0} nm (2 needs {:.1} nm); beyond that the \
             surface is taken as dark",
            coarsest * 1e3,
            shortest * 1e3,
            needed * 1e3
        ));
    }
}

/// A progress bar on stderr, drawn on a terminal only.
pub fn progress_bar(what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new(1);
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}
