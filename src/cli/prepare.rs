//! Preparation of commands that shade: a device, and a source, from the cache or made with a progress bar.

use super::check_validation;
use super::console::Console;
use super::progress::{LESS_WORK, ProgressBar};
use crate::brdf::Brdf;
use crate::brdf::energy_map::EnergyMapHeader;
use crate::error::Result;
use crate::optics::sampling::{self, Limit};
use crate::render::source::Source;
use crate::scene::{Scene, SceneOverrides};
use crate::settings::Method;
use crate::setup::{self, InUse, SourceSettings};
use crate::surface::HeightField;
use crate::task::Task;
use crate::vk::device::Device;
use crate::vk::selection::DeviceChoice;
use std::ffi::OsStr;
use std::sync::Arc;
use std::time::Instant;

/// Keeps the pipelines of `device`. Fails if there are validation messages about it.
pub fn finish(console: &Console, device: &Device) -> Result<()> {
    console.context().keep_pipelines(device);
    check(device)
}

/// Fails if there are validation messages about `device` so far.
pub fn check(device: &Device) -> Result<()> {
    check_validation(&device.instance().messages())
}

/// Opens the scene called `name` with `overrides`, with a progress bar while the mesh file is read, and tells its notes.
pub fn scene(console: &Console, name: &OsStr, overrides: &SceneOverrides) -> Result<Scene> {
    let bar = ProgressBar::new(console, "mesh", "a mesh of fewer triangles");
    let scene = Scene::open_telling(name, overrides, &bar.task())?;
    drop(bar);
    scene.notes().iter().for_each(|note| console.say(note));
    Ok(scene)
}

/// Returns the source of `field` under `settings` on `device`: one of `in_use`, from the cache, or made with a progress bar.
pub fn source(
    console: &Console,
    field: &HeightField,
    settings: &SourceSettings,
    device: &Arc<Device>,
    in_use: &mut InUse,
) -> Result<Source> {
    if setup::averages_footprints(settings) {
        console.detail(&format_args!(
            "pixels are averaged over standard deviations of (u, v) from {:.1e} on",
            settings.footprints.shorter
        ));
    }
    warn_of_coarse_samples(console, field, settings.shortest);
    let start = Instant::now();
    let bar = ProgressBar::new(console, "spectra", LESS_WORK);
    let made = setup::source(field, settings, device.candidate(), in_use, &bar.task())?;
    drop(bar);
    let (extent, summary) = (made.source.extent(), made.source.summary(&settings.optics));
    const MIB: f64 = 1024.0 * 1024.0;
    console.detail(&format_args!(
        "{}: {} layers of {} x {} texels, {:.1} MiB, made in {:.2} s",
        summary.method,
        extent.layers,
        extent.size[0],
        extent.size[1],
        extent.bytes as f64 / MIB,
        start.elapsed().as_secs_f64()
    ));
    made.note.iter().for_each(|note| console.context().tell(note));
    if let Some(energy) = made.source.energy() {
        let EnergyMapHeader { largest, error } = energy.header();
        console.detail(&format_args!(
            "limit of energy: albedo up to {largest:.3} of a flat surface's; between its directions the map errs by {error:.1e}"
        ));
    }
    Ok(made.source)
}

/// Calls `ask` with the BRDF of `field` under `settings` and its share in the mean, like [`setup::for_each_window`].
pub fn for_each_window(
    console: &Console,
    field: &HeightField,
    settings: &SourceSettings,
    mut ask: impl FnMut(&mut dyn Brdf, f64) -> Result<()>,
) -> Result<()> {
    warn_of_coarse_samples(console, field, settings.shortest);
    let bar = ProgressBar::new(console, "spectra", LESS_WORK);
    let task = Task::reporting(move |progress| {
        bar.show(&progress);
        if progress.done >= progress.of {
            bar.clear();
        }
    });
    // The reference averages over windows by itself.
    let is_apart = settings.windows_apart || settings.optics.method != Method::Reference;
    let grid = settings.optics.windows.grid().filter(|_| is_apart);
    let [n, m] = grid.unwrap_or([1, 1]);
    let windows = ProgressBar::hidden(console, "windows", "a smaller number of --windows", (n * m) as usize);
    windows.add(0);
    let ask_and_count = |brdf: &mut dyn Brdf, share: f64| {
        ask(brdf, share)?;
        windows.add(1);
        Ok(())
    };
    let context = console.context();
    // A named device has to exist, even if the CPU computes everything.
    if *context.device_choice() != DeviceChoice::default() {
        context.device()?;
    }
    setup::for_each_window(field, settings, context, &task, ask_and_count)?;
    context.opened_device().map_or(Ok(()), |device| finish(console, &device))
}

/// Warns, once a run, if `field` is sampled too coarsely for directions at wavelengths from `shortest` \[µm\].
pub fn warn_of_coarse_samples(console: &Console, field: &HeightField, shortest: f64) {
    if let Some(Limit { axis, spacing, largest, needed }) = sampling::limit(field.pixel_size(), shortest) {
        console.say_once(
            "coarse samples",
            &format_args!(
                "samples {:.1} nm apart hold |{axis}| up to {largest:.2} at {:.0} nm (2 needs {:.1} nm); beyond that \
                 the surface is taken as dark",
                spacing * 1e3,
                shortest * 1e3,
                needed * 1e3
            ),
        );
    }
}
