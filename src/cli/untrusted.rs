//! Every reader of what strangers write, by name, as a function of bytes.
//!
//! The fuzz targets in `fuzz/` call these, and `tests/regressions` replays what they once found. A reader may refuse what
//! it is given; it may not panic, overflow, hang, or take memory out of proportion.

use super::{eval, options, range, usage};
use crate::error::{Error, Result};
use crate::measure::trade;
use crate::optics::spectrum::Illuminant;
use crate::precompute::cache;
use crate::render::pigment::Pigment;
use crate::scene::{Scene, obj};
use crate::surface::image_file;
use crate::units;
use crate::vk::selection::DeviceChoice;
use std::ffi::OsString;
use std::io::Cursor;
use std::path::Path;

/// A reader of one kind of input.
#[derive(Clone, Copy, Debug)]
pub struct Reader {
    /// What it reads; the name of its fuzz target and of its folder in `tests/regressions`.
    pub name: &'static str,
    /// Reads all of the bytes. Panics only where a reader let something through that it must not.
    pub read: fn(&[u8]) -> Result<()>,
}

/// All of them.
pub const READERS: [Reader; 10] = [
    Reader { name: "height_image", read: height_image },
    Reader { name: "pigment", read: |bytes| Pigment::from_bytes(bytes).map(drop) },
    Reader { name: "mesh", read: |bytes| obj::from_bytes(bytes).map(drop) },
    Reader { name: "scene", read: scene },
    Reader { name: "queries", read: |bytes| eval::Table::parse(text(bytes)?).map(drop) },
    Reader { name: "illuminant", read: |bytes| Illuminant::from_text(text(bytes)?).map(drop) },
    Reader { name: "layers", read: layers },
    Reader { name: "sweep", read: sweep },
    Reader { name: "values", read: values },
    Reader { name: "command_line", read: command_line },
];

/// Text, as [`crate::input::read_text`] has it.
fn text(bytes: &[u8]) -> Result<&str> {
    std::str::from_utf8(bytes).map_err(|e| Error::failed(format!("it is not text ({e})"), "give text"))
}

fn height_image(bytes: &[u8]) -> Result<()> {
    let field = image_file::from_reader(Cursor::new(bytes), [0.1, 0.1], 0.4)?;
    assert!(
        field.heights().iter().all(|h| (0.0..=0.4).contains(h)),
        "a height outside of the image's own range"
    );
    Ok(())
}

/// Files that the scene names are looked for where there are none.
fn scene(bytes: &[u8]) -> Result<()> {
    Scene::parse(text(bytes)?, Path::new("/nowhere")).map(drop)
}

/// A cache file as it is, and the same bytes as the content of one whose check sum is right.
fn layers(bytes: &[u8]) -> Result<()> {
    const MEMORY: usize = 64 << 20;
    let key = blake3::hash(b"layers");
    let sealed = cache::sealed(&key, bytes);
    let read = |file: &[u8]| cache::read(&mut Cursor::new(file), file.len() as u64, &key, MEMORY);
    let found = read(bytes).or_else(|| read(&sealed));
    let Some(layers) = found else { return Err(Error::failed("there are no layers in it", "make them")) };
    // What the shader's tables are counted from.
    let pairs = layers.pairs_at(layers.z_max);
    let texels = layers.size[0] * layers.size[1] * 4 * layers.pairs();
    assert!(pairs <= layers.pairs() && texels == layers.texels.len(), "layers that do not fit their numbers");
    Ok(())
}

/// The rows of a sweep that goes on, and everything that is made of them.
fn sweep(bytes: &[u8]) -> Result<()> {
    let rows = trade::from_csv(text(bytes)?, "f");
    if rows.is_empty() {
        return Err(Error::failed("no row of it belongs to this sweep", "measure"));
    }
    let written = trade::csv(&rows)?;
    assert_eq!(trade::from_csv(&written, "f"), rows, "rows that are not read back as they are");
    trade::markdown(&rows, "A machine.", &[]);
    trade::wanted(&rows, Some(1e-2), Some(15.0));
    super::trade::figure(&rows, "Speed against accuracy", "A machine.").svg().map(drop)
}

/// Every kind of value that options and scenes take.
fn values(bytes: &[u8]) -> Result<()> {
    let text = text(bytes)?;
    let limits = (-1e3, 1e5);
    let results = [
        units::length(text).map(drop),
        units::length_pair(text).map(drop),
        units::angle(text).map(drop),
        units::light(text).map(drop),
        units::triple(text).map(drop),
        units::color(text).map(drop),
        units::counts(text).map(drop),
        units::size(text).map(drop),
        options::coherence(text).map(drop),
        options::tolerance(text).map(drop),
        options::exposure(text).map(drop),
        options::seed(text).map(drop),
        range::Range::parse(text, limits, "values").map(|range| drop(range.values())),
        DeviceChoice::parse(text).map(drop),
    ];
    results.into_iter().find(Result::is_ok).unwrap_or_else(|| Err(Error::usage("it is no value", "give one")))
}

/// A word a line.
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
