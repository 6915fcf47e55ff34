//! Preparation of commands that shade: a device, and a source, from the cache or made with a progress bar.

use super::progress::{LESS_WORK, ProgressBar};
use super::remedies::in_options;
use super::verbosity::detail;
use super::{check_validation, say, validation};
use crate::brdf::Brdf;
use crate::brdf::energy_map::EnergyMapHeader;
use crate::error::Result;
use crate::optics::sampling::{self, Limit};
use crate::render::source::Source;
use crate::scene::Scene;
use crate::settings::Method;
use crate::setup::{self, InUse, SourceSettings};
use crate::surface::HeightField;
use crate::task::Task;
use crate::vk::device::Device;
use crate::vk::instance::Instance;
use crate::vk::selection::DeviceChoice;
use std::cell::OnceCell;
use std::ffi::OsStr;
use std::sync::{Arc, Once};
use std::time::Instant;

/// Opens the device that `wish` names, with the pipelines that the cache keeps for it.
pub fn device(wish: &DeviceChoice) -> Result<Arc<Device>> {
    let device = Device::open(Arc::new(Instance::new(validation())?), wish)?;
    setup::load_pipelines(&device);
    Ok(device)
}

/// Keeps the pipelines of `device`. Fails if there are validation messages about it.
pub fn finish(device: &Device) -> Result<()> {
    setup::keep_pipelines(device);
    check(device)
}

/// Fails if there are validation messages about `device` so far.
pub fn check(device: &Device) -> Result<()> {
    check_validation(&device.instance().messages())
}

/// Opens the scene called `name`, with a progress bar while the mesh file is read.
pub fn scene(name: &OsStr) -> Result<Scene> {
    let bar = ProgressBar::new("mesh", "a mesh of fewer triangles");
    Scene::open_telling(name, &bar.task())
}

/// Returns the source of `field` under `settings` on `device`: one of `in_use`, from the cache, or made with a progress bar.
pub fn source(
    field: &HeightField,
    settings: &SourceSettings,
    device: &Arc<Device>,
    in_use: &mut InUse,
) -> Result<Source> {
    if setup::averages_footprints(settings) {
        detail(&format_args!(
            "pixels are averaged over standard deviations of (u, v) from {:.1e} on",
            settings.footprints.shorter
        ));
    }
    warn_of_coarse_samples(field, settings.shortest);
    let start = Instant::now();
    let bar = ProgressBar::new("spectra", LESS_WORK);
    let made = setup::source(field, settings, device.candidate(), in_use, &bar.task())?;
    drop(bar);
    let (extent, summary) = (made.source.extent(), made.source.summary(&settings.optics));
    const MIB: f64 = 1024.0 * 1024.0;
    detail(&format_args!(
        "{}: {} layers of {} x {} texels, {:.1} MiB, made in {:.2} s",
        summary.method,
        extent.layers,
        extent.size[0],
        extent.size[1],
        extent.bytes as f64 / MIB,
        start.elapsed().as_secs_f64()
    ));
    if let Some(note) = made.note {
        say(&in_options(&note));
    }
    if let Some(energy) = made.source.energy() {
        let EnergyMapHeader { largest, error } = energy.header();
        detail(&format_args!(
            "limit of energy: albedo up to {largest:.3} of a flat surface's; between its directions the map errs by {error:.1e}"
        ));
    }
    Ok(made.source)
}

/// Calls `ask` with the BRDF of `field` under `settings` and its share in the mean, like [`setup::for_each_window`], on the device that
/// `wish` names.
pub fn for_each_window(
    field: &HeightField,
    settings: &SourceSettings,
    wish: &DeviceChoice,
    mut ask: impl FnMut(&mut dyn Brdf, f64) -> Result<()>,
) -> Result<()> {
    warn_of_coarse_samples(field, settings.shortest);
    let bar = ProgressBar::new("spectra", LESS_WORK);
    let task = Task::reporting(move |progress| {
        bar.show(&progress);
        if progress.done >= progress.of {
            bar.clear();
        }
    });
    // The reference averages over windows by itself.
    let grid = settings.optics.windows.grid().filter(|_| settings.optics.method != Method::Reference);
    let [n, m] = grid.unwrap_or([1, 1]);
    let windows = ProgressBar::hidden("windows", "a smaller number of --windows", (n * m) as usize);
    windows.add(0);
    let ask_and_count = |brdf: &mut dyn Brdf, share: f64| {
        ask(brdf, share)?;
        windows.add(1);
        Ok(())
    };
    let opened = OnceCell::new();
    let open = || {
        let device = device(wish)?;
        Ok(opened.get_or_init(|| device).clone())
    };
    // A named device has to exist, even if the CPU computes everything.
    if *wish != DeviceChoice::default() {
        open()?;
    }
    setup::for_each_window(field, settings, &open, &task, &|note| say(&in_options(note)), ask_and_count)?;
    opened.get().map_or(Ok(()), |device| finish(device))
}

/// Warns, once a run, if `field` is sampled too coarsely for directions at wavelengths from `shortest` \[µm\].
pub fn warn_of_coarse_samples(field: &HeightField, shortest: f64) {
    static TOLD: Once = Once::new();
    if let Some(Limit { axis, spacing, largest, needed }) = sampling::limit(field.pixel_size(), shortest) {
        TOLD.call_once(|| {
            say(&format_args!(
                "samples {:.1} nm apart hold |{axis}| up to {largest:.2} at {:.0} nm (2 needs {:.1} nm); beyond that \
                 the surface is taken as dark",
                spacing * 1e3,
                shortest * 1e3,
                needed * 1e3
            ));
        });
    }
}
