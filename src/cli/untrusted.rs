//! Every reader of untrusted input, by name, as a function of bytes.
//!
//! The fuzz target in `fuzz/` calls these, and `tests/regressions` replays the inputs that it once found. A reader may refuse its input; it
//! may not panic, overflow, hang, or take memory out of proportion.

use super::{eval, options, range, sequence, usage};
use crate::cache::{self, Kept, Key};
use crate::error::{Error, Result};
use crate::figure::FigureStyle;
use crate::measure::trade;
use crate::notes::Notes;
use crate::optics::color::Tone;
use crate::optics::material::Material;
use crate::optics::reflectance::Film;
use crate::optics::spectrum::Illuminant;
use crate::render::pigment::Pigment;
use crate::scene::environment::Environment;
use crate::scene::{Background, Light, Scene, gltf_file, obj, ply_file, stl_file};
use crate::spectra::amplitude::Layers;
use crate::surface::files::{
    self,
    scan::{Quantity, Scan},
    sidecar::Sidecar,
};
use crate::table::{ColorTable, TableReader};
use crate::task::Task;
use crate::units;
use crate::vk::selection::DeviceChoice;
use glam::DVec2;
use std::ffi::OsString;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

/// A reader of one kind of input.
#[derive(Clone, Copy, Debug)]
pub struct UntrustedReader {
    /// Kind of input; the name of its folders in `fuzz/seeds` and `tests/regressions`.
    pub name: &'static str,
    function: Function,
}

/// Function of a reader.
#[derive(Clone, Copy, Debug)]
enum Function {
    /// The reader of a format of heights.
    Scan(for<'a> fn(&'a [u8]) -> Result<Scan<'a>>),
    /// Another reader. It panics only if it accepted input that it must refuse.
    Plain(fn(&[u8]) -> Result<()>),
}

impl UntrustedReader {
    const fn new(name: &'static str, read: fn(&[u8]) -> Result<()>) -> Self {
        Self { name, function: Function::Plain(read) }
    }

    /// Reads all of the bytes.
    ///
    /// # Errors
    /// Input that the reader refuses.
    pub fn read(&self, bytes: &[u8]) -> Result<()> {
        match self.function {
            Function::Scan(read) => scan(read(bytes)),
            Function::Plain(read) => read(bytes),
        }
    }
}

/// Returns all readers: those of the formats of heights, and the others.
pub fn readers() -> Vec<UntrustedReader> {
    let formats = files::FORMATS.iter();
    let formats =
        formats.map(|format| UntrustedReader { name: format.name, function: Function::Scan(format.read) });
    formats.chain(OTHERS).collect()
}

/// Readers of what is no file of heights.
const OTHERS: [UntrustedReader; 16] = [
    UntrustedReader::new("sidecar", |bytes| Sidecar::parse(text(bytes)?).map(drop)),
    UntrustedReader::new("pigment", |bytes| Pigment::from_bytes(bytes).map(drop)),
    UntrustedReader::new("environment", environment),
    UntrustedReader::new("material", |bytes| Material::from_text("material", text(bytes)?).map(drop)),
    UntrustedReader::new("mesh", |bytes| obj::from_bytes(bytes).map(drop)),
    UntrustedReader::new("gltf", |bytes| gltf_file::from_bytes(bytes).map(drop)),
    UntrustedReader::new("ply", |bytes| ply_file::load(bytes, &Task::silent()).map(drop)),
    UntrustedReader::new("stl", |bytes| stl_file::load(bytes.to_vec(), &Task::silent()).map(drop)),
    UntrustedReader::new("scene", scene),
    UntrustedReader::new("queries", |bytes| eval::QueryTable::parse(text(bytes)?).map(drop)),
    UntrustedReader::new("illuminant", |bytes| Illuminant::from_text(text(bytes)?).map(drop)),
    UntrustedReader::new("layers", layers),
    UntrustedReader::new("colours", colours),
    UntrustedReader::new("sweep", sweep),
    UntrustedReader::new("values", values),
    UntrustedReader::new("command_line", command_line),
];

/// Returns the bytes as text, like [`crate::input::read_text`].
fn text(bytes: &[u8]) -> Result<&str> {
    std::str::from_utf8(bytes)
        .map_err(|e| Error::input(format!("it is not text ({e})"), "give text").caused_by(e))
}

/// Reads every channel of a file.
fn scan(scan: Result<Scan>) -> Result<()> {
    /// Share by which the least signed code of 8 bits exceeds the largest one.
    const LEAST_CODE: f64 = 1.0 / 127.0;
    let mut whole = Ok(());
    for channel in scan?.channels {
        let ([columns, rows], spacing, quantity) = (channel.size, channel.spacing, channel.quantity);
        assert!(spacing.iter().flatten().all(|d| d.is_finite() && *d > 0.0), "a distance that is none");
        match channel.samples() {
            Ok(samples) => {
                assert_eq!(samples.len(), columns * rows, "samples that do not fill their grid");
                assert!(samples.iter().all(|h| h.is_finite() || h.is_nan()), "an infinite height");
                let is_share = |h: &f64| h.is_nan() || h.abs() <= 1.0 + LEAST_CODE;
                assert!(
                    !matches!(quantity, Quantity::Code { .. }) || samples.iter().all(is_share),
                    "codes beyond the image's own range"
                );
            }
            Err(e) => whole = Err(e),
        }
    }
    whole
}

/// Reads a scene, with a folder that does not exist for the files that it names.
fn scene(bytes: &[u8]) -> Result<()> {
    Scene::parse(text(bytes)?, Path::new("/nowhere")).map(drop)
}

/// Reads an environment map, and draws light samples from it.
fn environment(bytes: &[u8]) -> Result<()> {
    let environment = Environment::from_bytes("environment", bytes)?;
    for index in [0, 8, 15] {
        let incident = environment.incident(index, 16);
        assert!((incident.direction.length() - 1.0).abs() < 1e-9, "a direction that is none");
        assert!(incident.irradiance.is_finite() && incident.variance.is_finite(), "light beyond numbers");
    }
    Ok(())
}

/// Reads a cached `T`: from a file as it is, or from a file with a correct check sum that is made of `bytes`: a line with a number of zero
/// bytes, a line with the JSON of the header, and the payload, which the zeros follow.
fn kept<T: Kept>(bytes: &[u8]) -> Option<T> {
    const MEMORY: u64 = 64 << 20;
    const MOST_ZEROS: usize = 1 << 20;
    let key = Key::named(T::FORMAT.name);
    let read = |file: &[u8]| {
        cache::read(&mut Cursor::new(file), file.len() as u64, &T::FORMAT, &key, MEMORY, T::build)
    };
    if let Some(built) = read(bytes) {
        return Some(built);
    }
    let mut parts = bytes.splitn(3, |b| *b == b'\n');
    let zeros: usize = std::str::from_utf8(parts.next()?).ok()?.parse().ok()?;
    let header = serde_json::from_slice(parts.next()?).ok()?;
    let mut payload = parts.next()?.to_vec();
    payload.resize(payload.len() + zeros.min(MOST_ZEROS), 0);
    read(&cache::seal(&T::FORMAT, &key, &header, &payload))
}

fn layers(bytes: &[u8]) -> Result<()> {
    let Some(layers) = kept::<Layers>(bytes) else {
        return Err(Error::input("there are no layers in it", "make them"));
    };
    // Checks the numbers from which the shader's tables are sized.
    let pairs = layers.pairs_at(layers.z_max);
    let texels = layers.size[0] * layers.size[1] * 4 * layers.pairs();
    assert!(pairs <= layers.pairs() && texels == layers.texels.len(), "layers that do not fit their numbers");
    Ok(())
}

fn colours(bytes: &[u8]) -> Result<()> {
    let Some(table) = kept::<ColorTable>(bytes) else {
        return Err(Error::input("there is no colour table in it", "bake one"));
    };
    // Checks the sizes of the textures, and reads outside of the table.
    for (mip, texels) in table.mips.iter().enumerate() {
        let count = table.header.numbers_of_mip(mip);
        assert!(count > 0 && texels.len() == count, "a table that does not fit its numbers");
    }
    let level = table.header.grid.level(1e-2);
    let reader = TableReader::new(Arc::new(table));
    for place in [DVec2::ZERO, DVec2::splat(2.0), DVec2::splat(-1e9)] {
        reader.at(place, 2.0, level);
    }
    Ok(())
}

/// Reads the rows of an interrupted sweep, and makes all results from them.
fn sweep(bytes: &[u8]) -> Result<()> {
    let rows = trade::from_csv(text(bytes)?, "f");
    if rows.is_empty() {
        return Err(Error::input("no row of it belongs to this sweep", "measure"));
    }
    let written = trade::csv(&rows)?;
    assert_eq!(trade::from_csv(&written, "f"), rows, "rows that are not read back as they are");
    trade::markdown(&rows, "A machine.", &[]);
    trade::wanted(&rows, Some(1e-2), Some(15.0));
    super::trade::figure(&rows, "Speed against accuracy", "A machine.")
        .svg(&FigureStyle::default(), &Notes::default())
        .map(drop)
}

/// Parses the bytes as every kind of value of options and scenes.
fn values(bytes: &[u8]) -> Result<()> {
    let text = text(bytes)?;
    let limits = (-1e3, 1e5);
    let results = [
        units::length(text).map(drop),
        units::length_pair(text).map(drop),
        units::angle(text).map(drop),
        Light::parse(text).map(drop),
        Background::parse(text).map(drop),
        units::triple(text).map(drop),
        units::color(text).map(drop),
        units::counts(text).map(drop),
        units::size(text).map(drop),
        options::coherence(text).map(drop),
        options::tolerance(text).map(drop),
        options::exposure(text).map(drop),
        options::Exposure::parse(text).map(drop),
        Tone::from_name(text).map(drop),
        Film::parse(text).map(drop),
        options::seed(text).map(drop),
        sequence::frames(text).map(drop),
        range::Range::parse(text, limits, "values").map(|range| drop(range.values())),
        DeviceChoice::parse(text).map(drop),
    ];
    results.into_iter().find(Result::is_ok).unwrap_or_else(|| Err(Error::usage("it is no value", "give one")))
}

/// Parses a command line, a word a line.
fn command_line(bytes: &[u8]) -> Result<()> {
    let words = bytes.split(|b| *b == b'\n').map(word);
    usage::understand([OsString::from("diffract")].into_iter().chain(words)).map(drop)
}

#[cfg(unix)]
fn word(bytes: &[u8]) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(bytes.to_vec())
}

#[cfg(not(unix))]
fn word(bytes: &[u8]) -> OsString {
    String::from_utf8_lossy(bytes).into_owned().into()
}
