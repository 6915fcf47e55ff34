//! Height maps of Sensofar's profilers (.plu, .apx): a header of fixed fields, then 32-bit floats in micrometres from the top.
//!
//! Little-endian, without magic bytes. Every layer begins with its size. Facts after Gwyddion's description and SurfaceTopography.

use super::bytes::{Cursor, Number, Order};
use super::format::Format;
use super::scan::{Block, Channel, Scan, size, spacing};
use crate::error::{Error, Result};

/// The format.
pub const FORMAT: Format = Format {
    name: "sensofar",
    title: "Sensofar",
    extensions: &["plu", "apx"],
    signature,
    is_by_name: true,
    read,
    facts: ["yes", "yes", "1000001", "topographies, several layers; profiles are refused"],
};

/// Offset of the number of rows, which that of columns follows \[bytes\].
const COUNTS: usize = 388;
/// Offset of the distances of samples \[bytes\].
const SPACINGS: usize = 404;
/// Offset of the type of the measurement \[bytes\].
const KIND: usize = 428;
/// Offset of the number of layers, which two bytes and the number of pictures of a layer follow \[bytes\].
const LAYERS: usize = 489;
/// Offset of the first layer \[bytes\].
const DATA: usize = 500;
/// Type of a topography.
const TOPOGRAPHY: u32 = 3;
/// Number of a sample that was not measured.
const INVALID: f64 = 1_000_001.0;
/// Length of the date \[bytes\].
const DATE: usize = 128;
/// Bytes of the range of heights behind a layer.
const RANGE: usize = 8;

/// Returns true if the header counts the samples of the first layer as the layer does, behind a date.
fn signature(bytes: &[u8]) -> bool {
    let number = |place: usize| Cursor::new(bytes, Order::Little).at(place).u32().ok();
    let is_date = bytes.get(..DATE).is_some_and(|date| {
        date[..8].iter().all(|b| b.is_ascii_alphanumeric() || *b == b' ') && date.iter().all(u8::is_ascii)
    });
    is_date
        && number(KIND) == Some(TOPOGRAPHY)
        && number(DATA).is_some_and(|rows| rows > 0 && number(COUNTS) == Some(rows))
        && number(DATA + 4).is_some_and(|columns| columns > 0 && number(COUNTS + 4) == Some(columns))
}

/// Reads the file in `bytes`.
///
/// # Errors
/// A profile or pictures instead of a topography; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let from = |place: usize| Cursor::new(bytes, Order::Little).at(place);
    let kind = from(KIND).u32()?;
    if kind != TOPOGRAPHY {
        return Err(Error::input(
            format!("holds no topography (type {kind} instead of {TOPOGRAPHY})"),
            "choose a file with a measured surface",
        ));
    }
    let mut pixel = from(SPACINGS);
    let spacing = [pixel.f32()?, pixel.f32()?].map(|um| spacing(um * 1e-6, 1));
    let layers = from(LAYERS).u8()?.max(1);
    let pictures = usize::from(from(LAYERS + 3).u8()?);
    let mut cursor = from(DATA);
    let mut found = Vec::new();
    for i in 1..=layers {
        let [rows, columns] = [cursor.u32()?, cursor.u32()?];
        let size = size(u64::from(columns), u64::from(rows))?;
        let count = size[0] * size[1];
        let data = cursor.take(count * Number::F32.bytes())?;
        let block = Block { missing: Some(INVALID), ..Block::plain(data, Number::F32, Order::Little) };
        found.push(("Topography".to_owned(), Channel::stored("Topography", "um", size, spacing, block)));
        // Pictures in three colours follow, except behind the last layer of some files.
        if i < layers {
            cursor.take(RANGE + 3 * count * pictures)?;
        }
    }
    Scan::of_readable(FORMAT.title, found)
}

#[cfg(test)]
#[path = "sensofar_tests.rs"]
mod tests;
