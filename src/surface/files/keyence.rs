//! Height maps of Keyence's laser microscopes (.vk3, .vk4, .vk6, .vk7): a table of offsets to conditions and images, little-endian.
//!
//! Heights are unsigned integers from the top, times a number of picometres; samples are a whole number of picometres apart. `.vk6` and
//! `.vk7` files hold a `.vk4` file in a zip behind a picture. Facts after SurfaceTopography and surfalize.

use super::bytes::{Cursor, Number, Order, cut_short, damaged};
use super::format::Format;
use super::scan::{Block, Channel, Scan, size, spacing};
use crate::error::Result;
use crate::memory;
use std::borrow::Cow;
use std::io::Read;
use zip::ZipArchive;

/// The format.
pub const FORMAT: Format = Format {
    name: "keyence",
    title: "Keyence VK",
    extensions: &["vk3", "vk4", "vk6", "vk7"],
    signature: |b| is_plain(b) || b.starts_with(b"VK6") || b.starts_with(b"VK7"),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "", "8, 16 and 32 bits, up to three heights"],
};

/// Name of the file in the zip.
const MEMBER: &str = "Vk4File";
/// Offset of the offset of the conditions of the measurement \[bytes\].
const CONDITIONS: usize = 12;
/// Offsets of the offsets of the heights \[bytes\].
const HEIGHTS: [usize; 3] = [36, 40, 44];
/// Offset of the distances of samples in the conditions, which the unit of heights follows \[bytes\].
const SCALES: usize = 168;
/// Bytes of the palette of an image.
const PALETTE: usize = 768;
/// Picometres of a metre.
const PICOMETRE: f64 = 1e-12;

fn is_plain(bytes: &[u8]) -> bool {
    bytes.starts_with(b"VK3_") || bytes.starts_with(b"VK4_")
}

/// Reads the file in `bytes`.
///
/// # Errors
/// A file without heights; images beyond its end; a zip without the file of the heights.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let content = if is_plain(bytes) { Cow::Borrowed(bytes) } else { Cow::Owned(unpacked(bytes)?) };
    let from = |place: usize| Cursor::new(&content, Order::Little).at(place);
    let mut scales = from((from(CONDITIONS).u32()? as usize).saturating_add(SCALES));
    let [x, y, unit] = [scales.u32()?, scales.u32()?, scales.u32()?].map(|n| f64::from(n) * PICOMETRE);
    let mut found = Vec::new();
    for (i, offset) in HEIGHTS.into_iter().enumerate() {
        let place = from(offset).u32()? as usize;
        if place > 0 {
            let name = format!("Height {i}");
            let channel = heights(&content, place, &name, [spacing(x, 1), spacing(y, 1)], unit);
            found.push((name, channel));
        }
    }
    Scan::of_readable(FORMAT.title, found)
}

/// Returns the heights at `place` of a plain file, of `unit` \[m\].
fn heights<'a>(
    content: &Cow<'a, [u8]>,
    place: usize,
    name: &str,
    spacing: [Option<f64>; 2],
    unit: f64,
) -> Result<Channel<'a>> {
    let mut cursor = Cursor::new(content, Order::Little).at(place);
    let [columns, rows, bits] = [cursor.u32()?, cursor.u32()?, cursor.u32()?];
    let number = match bits {
        8 => Number::U8,
        16 => Number::U16,
        32 => Number::U32,
        _ => return Err(damaged(format!("its samples have {bits} bits"))),
    };
    cursor.u32()?; // compression, which no file has
    let size = size(u64::from(columns), u64::from(rows))?;
    let length = cursor.u32()? as usize;
    if length != size[0] * size[1] * number.bytes() {
        return Err(damaged(format!("its {columns} x {rows} samples take {length} bytes")));
    }
    cursor.take(2 * 4 + PALETTE)?; // range of the palette, palette
    let start = cursor.place();
    let data = match content {
        Cow::Borrowed(bytes) => Cow::Borrowed(bytes.get(start..).ok_or_else(cut_short)?),
        Cow::Owned(_) => Cow::Owned(cursor.take(length)?.to_vec()),
    };
    let block = Block { bytes: data, scale: [unit, 0.0], ..Block::plain(&[], number, Order::Little) };
    Channel::stored(name, "m", size, spacing, block)
}

/// Returns the plain file in the zip in `bytes`.
fn unpacked(bytes: &[u8]) -> Result<Vec<u8>> {
    let mut archive = ZipArchive::new(std::io::Cursor::new(bytes)).map_err(damaged)?;
    let member = archive.by_name(MEMBER).map_err(damaged)?;
    let length = member.size();
    memory::ensure_room(length, "the heights in a zip")?;
    let mut content = Vec::new();
    // The size in the zip may lie.
    member.take(length).read_to_end(&mut content).map_err(damaged)?;
    Ok(content)
}

#[cfg(test)]
#[path = "keyence_tests.rs"]
mod tests;
