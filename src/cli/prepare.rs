//! What commands need before they can shade: a device, and the layers, from the cache or made with a progress bar.

use super::{check_validation, say, validation};
use crate::error::Result;
use crate::optics::sampling::{self, Limit};
use crate::optics::spectrum::SHORTEST;
use crate::precompute::{Layers, Settings, cache, compute_at};
use crate::render::color_table::{self, ColorTable};
use crate::render::shading::Shading;
use crate::surface::HeightField;
use crate::vk::device::Device;
use crate::vk::instance::Instance;
use crate::vk::selection::DeviceChoice;
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::{Arc, Once};

/// Opens the device that `wish` means.
pub fn device(wish: &DeviceChoice) -> Result<Arc<Device>> {
    Device::open(Arc::new(Instance::new(validation())?), wish)
}

/// Fails if validation had anything to say about `device` so far.
pub fn finish(device: &Device) -> Result<()> {
    check_validation(&device.instance().messages())
}

/// Layers of `field` for wavelengths from `shortest` \[µm\] on `device`.
pub fn layers(field: &HeightField, shading: &Shading, shortest: f64, device: &Device) -> Result<Layers> {
    layers_at(field, shading, Window::CENTRE, shortest, device)
}

/// Where a window stands.
#[derive(Clone, Copy)]
pub struct Window {
    /// Its centre from that of the patch \[µm\].
    pub shift: [f64; 2],
    /// Whether its layers are worth a place in the cache.
    pub kept: bool,
}

impl Window {
    /// The one that most commands mean.
    pub const CENTRE: Self = Self { shift: [0.0; 2], kept: true };
}

/// The layers of `window`.
pub fn layers_at(
    field: &HeightField,
    shading: &Shading,
    window: Window,
    shortest: f64,
    device: &Device,
) -> Result<Layers> {
    layers_for(field, &shading.layer_settings(shortest, device.candidate())?, window)
}

/// Layers of `field` under a Gaussian of standard deviation `sigma` \[µm\], or, where that is infinite, of one period alone.
pub fn windowed_layers(
    field: &HeightField,
    shading: &Shading,
    sigma: f64,
    shortest: f64,
    device: &Device,
) -> Result<Layers> {
    layers_for(field, &shading.windowed_settings(sigma, shortest, device.candidate())?, Window::CENTRE)
}

fn layers_for(field: &HeightField, settings: &Settings, window: Window) -> Result<Layers> {
    warn_of_coarse_samples(field, settings.shortest_wavelength);
    let bar = progress_bar("spectra");
    let progress = |done: usize, of: usize| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        Ok(())
    };
    let (layers, not_kept) = if window.kept {
        cache::obtain_at(field, settings, window.shift, &progress)?
    } else {
        (compute_at(field, settings, window.shift, &progress)?, None)
    };
    bar.finish_and_clear();
    if let Some(error) = not_kept {
        say(&format_args!("the spectra are not kept for next time: {error}"));
    }
    Ok(layers)
}

/// The colour table of `field` on `device`, from the cache or baked with a progress bar.
pub fn color_table(field: &HeightField, shading: &Shading, device: &Arc<Device>) -> Result<ColorTable> {
    warn_of_coarse_samples(field, SHORTEST);
    let bar = progress_bar("colours");
    let (table, not_kept) = color_table::obtain(device, field, shading, &|what, done, of| {
        bar.set_message(what);
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        Ok(())
    })?;
    bar.finish_and_clear();
    if let Some(error) = not_kept {
        say(&format_args!("the colour table is not kept for next time: {error}"));
    }
    Ok(table)
}

/// Tells, once a run, where `field` is sampled too coarsely for directions at wavelengths from `shortest` \[µm\].
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

/// A progress bar on stderr, drawn on a terminal only.
pub fn progress_bar(what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new(1);
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}
