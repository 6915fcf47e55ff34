//! From a height field and settings to what is shaded from: what every command and the viewer start with.

mod brdf;

pub use brdf::for_each_window;

use crate::error::{Error, Result};
use crate::optics::coherence::Coherence;
use crate::optics::orders::Repeats;
use crate::optics::spectrum::SHORTEST;
use crate::precompute::{self, Layers, compute_at};
use crate::render::color_table::{self, ColorTable, Filter};
use crate::render::shading::Shading;
use crate::render::source::{Grating, Source, Table};
use crate::surface::HeightField;
use crate::vk::device::Device;
use crate::vk::selection::Candidate;
use std::sync::{Arc, Weak};

/// How the optics is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Wavelengths are summed over spectra, on the device.
    #[default]
    Spectral,
    /// A colour table is read, on the device.
    Table,
    /// The direct sum in f64, on the CPU.
    Reference,
}

impl Method {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spectral => "spectral",
            Self::Table => "table",
            Self::Reference => "reference",
        }
    }
}

/// Everything that a source follows from beside the height field.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// By which method.
    pub method: Method,
    /// What a pixel shows of a colour table.
    pub filter: Filter,
    /// The optics.
    pub shading: Shading,
    /// Shortest wavelength that will be asked for \[µm\].
    pub shortest: f64,
    /// The window's centre from that of the patch \[µm\].
    pub shift: [f64; 2],
    /// Whether the result is worth a place in the cache on disk.
    pub cached: bool,
}

impl Settings {
    /// A window in the middle, for colours.
    pub fn new(method: Method, shading: Shading) -> Self {
        let filter = Filter::default();
        Self { method, filter, shading, shortest: SHORTEST, shift: [0.0; 2], cached: true }
    }
}

/// The device that a source is made for.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// What it can hold.
    pub limits: &'a Candidate,
    /// The device itself, which bakes colour tables.
    pub device: Option<&'a Arc<Device>>,
}

impl<'a> From<&'a Arc<Device>> for Target<'a> {
    fn from(device: &'a Arc<Device>) -> Self {
        Self { limits: device.candidate(), device: Some(device) }
    }
}

/// Called with what is made, steps done and steps in all, as far as they are known; an error from it cancels the work.
pub type Progress<'a> = dyn Fn(&'static str, usize, usize) -> Result<()> + 'a;

/// A source, and why it could not be kept for next time, where that is so.
pub struct Made {
    /// The source.
    pub source: Source,
    /// For the user.
    pub note: Option<String>,
}

/// Data that is still in use somewhere, for requests that share it.
#[derive(Default)]
pub struct InUse {
    layers: Vec<(blake3::Hash, Weak<Layers>)>,
    tables: Vec<(blake3::Hash, Weak<ColorTable>)>,
}

/// The source of `field` under `settings` on `target`: from what is `in_use`, from the cache on disk, or made and kept there.
///
/// # Errors
/// For settings that the method cannot do, where the data does not fit into the device or this machine, and what `progress` returns.
pub fn source(
    field: &HeightField,
    settings: &Settings,
    target: Target<'_>,
    in_use: &mut InUse,
    progress: &Progress<'_>,
) -> Result<Made> {
    let shading = &settings.shading;
    match (settings.method, shading.coherence) {
        (Method::Reference, _) => Err(Error::usage(
            "--method reference has no device to shade on",
            "use --method spectral or --method table",
        )),
        (Method::Table, _) => {
            let device = target.device.ok_or_else(|| {
                Error::failed("a colour table needs an open device", "report this as a bug of diffract")
            })?;
            let (table, note) = table(field, shading, device, in_use, progress)?;
            Ok(Made { source: Source::Table(Table { table, filter: settings.filter }), note })
        }
        (Method::Spectral, Coherence::Gaussian { length }) => {
            let (layers, note) = layers(field, settings, length / 4.0, target, in_use, progress)?;
            Ok(Made { source: Source::window(layers), note })
        }
        (Method::Spectral, Coherence::Repeats(copies)) => {
            shading.check_wavelengths()?;
            let repeats = Repeats { copies, period: field.patch_size() };
            // A grating that begins elsewhere is the grating of a surface that does.
            let begun = field.begun_at(settings.shift);
            let settings = Settings { shift: [0.0; 2], ..settings.clone() };
            let (layers, note) = layers(&begun, &settings, f64::INFINITY, target, in_use, progress)?;
            Ok(Made { source: Source::Grating(Grating { layers, repeats }), note })
        }
    }
}

/// Spectra through a Gaussian of standard deviation `sigma` \[µm\], or, where that is infinite, of one period.
fn layers(
    field: &HeightField,
    settings: &Settings,
    sigma: f64,
    target: Target<'_>,
    in_use: &mut InUse,
    progress: &Progress<'_>,
) -> Result<(Arc<Layers>, Option<String>)> {
    let own = settings.shading.windowed_settings(sigma, settings.shortest, target.limits)?;
    let key = precompute::cache::key_at(field, &own, settings.shift);
    if let Some(known) = find(&mut in_use.layers, &key) {
        return Ok((known, None));
    }
    let progress = |done, of| progress("spectra", done, of);
    let (layers, not_kept) = if settings.cached {
        precompute::cache::obtain_at(field, &own, settings.shift, &progress)?
    } else {
        (compute_at(field, &own, settings.shift, &progress)?, None)
    };
    let layers = Arc::new(layers);
    in_use.layers.push((key, Arc::downgrade(&layers)));
    Ok((layers, not_kept.map(|e| format!("the spectra are not kept for next time: {e}"))))
}

fn table(
    field: &HeightField,
    shading: &Shading,
    device: &Arc<Device>,
    in_use: &mut InUse,
    progress: &Progress<'_>,
) -> Result<(Arc<ColorTable>, Option<String>)> {
    let key = color_table::key(field, shading, device.candidate())?;
    if let Some(known) = find(&mut in_use.tables, &key) {
        return Ok((known, None));
    }
    let (table, not_kept) = color_table::obtain(device, field, shading, progress)?;
    let table = Arc::new(table);
    in_use.tables.push((key, Arc::downgrade(&table)));
    Ok((table, not_kept.map(|e| format!("the colour table is not kept for next time: {e}"))))
}

/// What is known by `key`; forgets what nobody uses any more.
fn find<T>(known: &mut Vec<(blake3::Hash, Weak<T>)>, key: &blake3::Hash) -> Option<Arc<T>> {
    known.retain(|(_, data)| data.strong_count() > 0);
    known.iter().find(|(own, _)| own == key).and_then(|(_, data)| data.upgrade())
}
