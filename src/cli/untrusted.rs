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
use crate::surface::files::{self, scan::Scan, sidecar::Sidecar};
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
    /// Function that reads all of the bytes. It panics only if a reader accepted input that it must refuse.
    pub read: fn(&[u8]) -> Result<()>,
}

/// All readers.
pub const READERS: [UntrustedReader; 29] = [
    UntrustedReader { name: "height_image", read: height_image },
    UntrustedReader { name: "gsf", read: |bytes| scan(files::gsf::read(bytes)) },
    UntrustedReader { name: "gwy", read: |bytes| scan(files::gwy::read(bytes)) },
    UntrustedReader { name: "nanoscope", read: |bytes| scan(files::nanoscope::read(bytes)) },
    UntrustedReader { name: "igor", read: |bytes| scan(files::igor::read(bytes)) },
    UntrustedReader { name: "digital_surf", read: |bytes| scan(files::digital_surf::read(bytes)) },
    UntrustedReader { name: "x3p", read: |bytes| scan(files::x3p::read(bytes)) },
    UntrustedReader { name: "sdf_text", read: |bytes| scan(files::sdf::read_text(bytes)) },
    UntrustedReader { name: "sdf_binary", read: |bytes| scan(files::sdf::read_binary(bytes)) },
    UntrustedReader { name: "npy", read: |bytes| scan(files::npy::read(bytes)) },
    UntrustedReader { name: "height_text", read: |bytes| scan(files::text::read(bytes)) },
    UntrustedReader { name: "xyz", read: |bytes| scan(files::xyz::read(bytes)) },
    UntrustedReader { name: "tiff", read: |bytes| scan(files::tiff::read(bytes)) },
    UntrustedReader { name: "sidecar", read: |bytes| Sidecar::parse(text(bytes)?).map(drop) },
    UntrustedReader { name: "pigment", read: |bytes| Pigment::from_bytes(bytes).map(drop) },
    UntrustedReader { name: "environment", read: environment },
    UntrustedReader {
        name: "material",
        read: |bytes| Material::from_text("material", text(bytes)?).map(drop),
    },
    UntrustedReader { name: "mesh", read: |bytes| obj::from_bytes(bytes).map(drop) },
    UntrustedReader { name: "gltf", read: |bytes| gltf_file::from_bytes(bytes).map(drop) },
    UntrustedReader { name: "ply", read: |bytes| ply_file::load(bytes, &Task::silent()).map(drop) },
    UntrustedReader { name: "stl", read: |bytes| stl_file::load(bytes.to_vec(), &Task::silent()).map(drop) },
    UntrustedReader { name: "scene", read: scene },
    UntrustedReader { name: "queries", read: |bytes| eval::QueryTable::parse(text(bytes)?).map(drop) },
    UntrustedReader { name: "illuminant", read: |bytes| Illuminant::from_text(text(bytes)?).map(drop) },
    UntrustedReader { name: "layers", read: layers },
    UntrustedReader { name: "colours", read: colours },
    UntrustedReader { name: "sweep", read: sweep },
    UntrustedReader { name: "values", read: values },
    UntrustedReader { name: "command_line", read: command_line },
];

/// Returns the bytes as text, like [`crate::input::read_text`].
fn text(bytes: &[u8]) -> Result<&str> {
    std::str::from_utf8(bytes)
        .map_err(|e| Error::input(format!("it is not text ({e})"), "give text").caused_by(e))
}

fn height_image(bytes: &[u8]) -> Result<()> {
    const HEIGHT: f64 = 0.4;
    let settings = files::ReadSettings { pixel_size: Some([0.1, 0.1]), height: Some(HEIGHT), channel: None };
    let scan = files::image::read(bytes)?;
    drop(scan);
    let field = files::from_bytes(bytes, "png", &settings)?.into_field()?;
    let (low, high) = field.range();
    assert!(high - low <= HEIGHT * (1.0 + 1e-12), "heights beyond the image's own range");
    Ok(())
}

/// Reads every channel of a file and converts it to a height field.
fn scan(scan: Result<Scan>) -> Result<()> {
    let mut whole = Ok(());
    for channel in scan?.channels {
        let ([columns, rows], spacing) = (channel.size, channel.spacing);
        assert!(spacing.iter().flatten().all(|d| d.is_finite() && *d > 0.0), "a distance that is none");
        match channel.samples() {
            Ok(samples) => {
                assert_eq!(samples.len(), columns * rows, "samples that do not fill their grid");
                assert!(samples.iter().all(|h| h.is_finite() || h.is_nan()), "an infinite height");
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
