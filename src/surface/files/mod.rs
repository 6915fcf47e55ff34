//! Files of microscopes and of programs for surfaces: read into heights, and written.
//!
//! One module for each format turns bytes into a [`Scan`]: the channels with their sizes, units and distances. The common steps are here: a
//! format is recognised by its content and then by its name, a channel is chosen, options and sidecars give the scales that are missing,
//! and samples that were not measured are known. [`Topography`] is the result. `docs/SCANS.md` has the table of formats.

pub mod alicona;
pub mod bcr;
pub mod bytes;
pub mod choose;
pub mod digital_surf;
pub mod format;
pub mod frt;
pub mod gsf;
pub mod gwy;
pub mod hdf5;
pub mod header;
pub mod igor;
pub mod image;
pub mod invalid;
pub mod jpk;
pub mod jpk_hdf5;
pub mod keyence;
pub mod nanonis;
pub mod nanoscope;
pub mod nanosurf;
pub mod nanosurf_hdf5;
pub mod npy;
pub mod park;
pub mod picoview;
pub mod plausible;
pub mod profile;
pub mod scan;
pub mod sdf;
pub mod sensofar;
pub mod sidecar;
pub mod table;
#[cfg(test)]
mod testing;
pub mod text;
mod text_head;
pub mod tiff;
pub mod tiff_tags;
pub mod topography;
pub mod units;
mod unread;
pub mod write;
pub mod wsxm;
pub mod wyko;
pub mod x3p;
pub mod xyz;
pub mod zygo;
pub mod zygo_hdf5;
pub mod zygo_xyz;

use super::HeightField;
use crate::error::{self, Error, Remedy, Result};
use crate::task::{READING, Task};
use crate::{input, memory};
use format::Format;
use plausible::HeightSource;
use scan::{Quantity, Scan};
use sidecar::Sidecar;
use std::io::Read;
use std::path::Path;
pub use topography::{ChannelInfo, FileSummary, ScanOrigin, Spacing, Topography};

/// Largest file \[bytes\]: several channels of the largest field in double precision.
pub const MAX_FILE: u64 = 8 << 30;

/// Micrometres of a metre.
const UM: f64 = 1e6;

/// Settings for reading a file: its channel, and scales that the file lacks or that replace the file's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ReadSettings<'a> {
    /// Distance of samples \[µm\], instead of the file's.
    pub pixel_size: Option<[f64; 2]>,
    /// Height of the largest code of an image; for heights with a scale, their new range \[µm\].
    pub height: Option<f64>,
    /// Channel by name, or by number from 1.
    pub channel: Option<&'a str>,
}

/// Reads the file `path`.
///
/// # Errors
/// A file that is missing, not regular, too large, of no known format or damaged; a channel that is not there; no scale in the
/// file, beside it or in `settings`; a task that is cancelled: between parts of the file, and between the steps of its format.
pub fn read(path: &Path, settings: &ReadSettings, task: &Task) -> Result<Topography> {
    let bytes = load(path, task)?;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    let read = || {
        let scan = recognise(&bytes, &extension)?;
        task.check()?;
        assemble(scan, settings, task, || Sidecar::beside(path))
    };
    read().map_err(|e| e.at(path.display()))
}

impl HeightField {
    /// Reads the heights in the file `path` of a microscope or of a program for surfaces, or in a grey image.
    ///
    /// # Errors
    /// See [`read`].
    pub fn read(path: impl AsRef<Path>, settings: &ReadSettings, task: &Task) -> Result<Self> {
        read(path.as_ref(), settings, task)?.into_field()
    }
}

/// All formats that are read. The first one whose signature fits reads a file. Recognition, lists of extensions, the table in
/// `docs/SCANS.md` and the fuzzer's readers follow from these rows.
pub const FORMATS: &[Format] = &[
    gsf::FORMAT,
    gwy::FORMAT,
    nanoscope::FORMAT,
    igor::FORMAT,
    digital_surf::FORMAT,
    x3p::FORMAT,
    sdf::FORMAT,
    jpk::FORMAT,
    jpk_hdf5::FORMAT,
    nanosurf::FORMAT,
    nanosurf_hdf5::FORMAT,
    zygo::FORMAT,
    zygo_hdf5::FORMAT,
    wyko::FORMAT,
    nanonis::FORMAT,
    keyence::FORMAT,
    sensofar::FORMAT,
    alicona::FORMAT,
    wsxm::FORMAT,
    picoview::FORMAT,
    frt::FORMAT,
    bcr::FORMAT,
    park::FORMAT,
    tiff::FORMAT,
    image::FORMAT,
    npy::FORMAT,
    text::FORMAT,
    zygo_xyz::FORMAT,
    xyz::FORMAT,
];

/// Returns the extensions of the names of height files, without the dot, each once.
pub fn extensions() -> Vec<&'static str> {
    let mut found = Vec::new();
    for extension in FORMATS.iter().flat_map(|format| format.extensions) {
        if !found.contains(extension) {
            found.push(*extension);
        }
    }
    found
}

/// Returns the extensions for people: with dots and a space between them.
pub fn dotted_extensions() -> String {
    extensions().iter().map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(" ")
}

/// Returns true if `extension` is that of a height file, in any case.
pub fn is_extension(extension: &str) -> bool {
    extensions().contains(&extension.to_lowercase().as_str())
}

/// Returns the kinds of files that can be read, for messages.
pub fn known() -> String {
    format!("a height file ({})", dotted_extensions())
}

/// Reads a file that is in memory; `extension` is that of its name, in lower case.
///
/// # Errors
/// See [`read`].
pub fn from_bytes(bytes: &[u8], extension: &str, settings: &ReadSettings) -> Result<Topography> {
    assemble(recognise(bytes, extension)?, settings, &Task::silent(), || Ok(Sidecar::default()))
}

/// Reads all of a file, part by part.
fn load(path: &Path, task: &Task) -> Result<Vec<u8>> {
    const MIB: usize = 1 << 20;
    /// Bytes between two reports: some milliseconds from a disk.
    const PART: u64 = 16 << 20;
    let file = input::open(path, &known(), MAX_FILE)?;
    let at = |e: Error| e.at(path.display());
    let length = file.metadata().map_or(0, |m| m.len());
    if length == 0 {
        return Err(at(Error::input("is empty", "save the file again")));
    }
    memory::ensure_room(length, "the file").map_err(at)?;
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    // The file may grow while it is read, so the limit applies to the read bytes as well.
    let mut file = file.take(MAX_FILE);
    loop {
        let done = bytes.len();
        task.report(READING, done / MIB, (length as usize).max(done).div_ceil(MIB))?;
        let read = file.by_ref().take(PART).read_to_end(&mut bytes).map_err(|e| {
            at(Error::files(format!("cannot be read: {}", error::cause(&e)), "check the disk").caused_by(e))
        })?;
        if read == 0 {
            return Ok(bytes);
        }
    }
}

/// Reads `bytes` in the format of their content, or else in that of the `extension` of the file's name. Channels of the same name are
/// numbered.
///
/// # Errors
/// No known format; errors of the format's reader.
pub fn recognise<'a>(bytes: &'a [u8], extension: &str) -> Result<Scan<'a>> {
    if let Some(refusal) = unread::by_content(bytes) {
        return Err(refusal);
    }
    let by_name = |format: &&Format| format.is_by_name && format.has_extension(extension);
    let by_content = FORMATS.iter().find(|format| (format.signature)(bytes));
    // The name of what is neither read nor text.
    let named = |e: Error| unread::by_name(extension).unwrap_or(e);
    let mut scan = match by_content.or_else(|| FORMATS.iter().find(by_name)) {
        Some(format) => (format.read)(bytes)?,
        // Text has no magic bytes, and no NUL but in UTF-16.
        None if bytes.contains(&0) && table::wide_order(bytes).is_none() => {
            return Err(named(Error::input("is of no known format", format!("give {}", known()))));
        }
        None => text::read(bytes).map_err(named)?,
    };
    scan.number_equal_names();
    Ok(scan)
}

/// Returns the heights of the chosen channel of `scan`, with the scales that `settings` or the sidecar give.
fn assemble(
    mut scan: Scan,
    settings: &ReadSettings,
    task: &Task,
    sidecar: impl FnOnce() -> Result<Sidecar>,
) -> Result<Topography> {
    if let Some(height) = settings.height.filter(|h| !h.is_finite() || *h < 0.0) {
        return Err(Error::usage(format!("the full height {height} um cannot be"), Remedy::FullHeight));
    }
    let chosen = choose::choose(&scan, settings.channel)?;
    let info = |c: &scan::Channel| ChannelInfo { name: c.name.clone(), unit: c.unit.clone(), size: c.size };
    let channels: Vec<ChannelInfo> = scan.channels.iter().map(info).collect();
    let mut notes = std::mem::take(&mut scan.notes);
    let channel = scan.channels.swap_remove(chosen);
    let lacks_scale = channel.quantity != Quantity::Height && settings.height.is_none();
    let lacks_distance = channel.spacing.contains(&None) && settings.pixel_size.is_none();
    let beside = if lacks_scale || lacks_distance { sidecar()? } else { Sidecar::default() };
    let (size, quantity, prepared) = (channel.size, channel.quantity, channel.prepared.clone());
    let spacing = match (settings.pixel_size.or(beside.pixel_size), channel.spacing) {
        (Some(um), _) => Spacing::Micrometres(um),
        (None, [Some(x), Some(y)]) => Spacing::Metres([x, y]),
        // A single line has no distance of lines: its width is that of a sample.
        (None, [Some(x), None]) if size[1] == 1 => Spacing::Metres([x, x]),
        (None, [None, Some(y)]) if size[0] == 1 => Spacing::Metres([y, y]),
        _ => return Err(missing("distance of samples", Remedy::PixelSize)),
    };
    let height = settings.height.or(beside.height);
    if quantity == Quantity::Other {
        let (unit, name) = (choose::unit(&channels[chosen].unit), &channels[chosen].name);
        // A unit of another quantity is no height, whatever range a user gives.
        if units::is_of_another_quantity(&channels[chosen].unit) {
            return Err(Error::usage(
                format!("the channel `{name}` is in {unit}, which is no length"),
                Remedy::Channel,
            ));
        }
        if height.is_none() {
            return Err(Error::usage(
                format!("the channel `{name}` is in {unit}, which is no length"),
                [Remedy::Channel, Remedy::FullHeight],
            ));
        }
    }
    let needed = || missing("scale of heights", Remedy::FullHeight);
    let coded = matches!(quantity, Quantity::Code { .. });
    let code_height = if coded { height.ok_or_else(needed)? } else { 0.0 };
    let samples = channel.samples()?;
    task.check()?;
    if let Quantity::Code { largest } = quantity {
        notes.extend(plausible::narrow_codes(&samples, largest));
    }
    let unit = match (quantity, height) {
        (Quantity::Code { .. }, _) => code_height,
        (_, Some(height)) => range_becomes(height, &samples),
        (_, None) => UM,
    };
    let quantisation = match quantity {
        Quantity::Code { largest } if largest <= f64::from(u8::MAX) => Some(unit / largest / UM),
        _ => None,
    };
    let origin = ScanOrigin { format: scan.format, channels, chosen, quantisation, warnings: Vec::new() };
    let mut topography = Topography::new(size, spacing, samples, unit, Some(origin))?.with_record(prepared);
    let scale = if settings.height.is_some() { HeightSource::Given } else { HeightSource::File };
    topography.warn(notes, scale);
    Ok(topography)
}

/// Returns the unit of `samples` \[µm\] for which the measured ones span `height` \[µm\]. Equal samples stay as they are.
fn range_becomes(height: f64, samples: &[f64]) -> f64 {
    let low = samples.iter().copied().fold(f64::INFINITY, f64::min);
    let high = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let factor = height / (high - low);
    if factor.is_finite() { factor } else { UM }
}

fn missing(what: &str, remedy: Remedy) -> Error {
    Error::usage(format!("the file carries no {what}"), remedy)
}

#[cfg(test)]
mod tests;
