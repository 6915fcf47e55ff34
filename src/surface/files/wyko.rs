//! Files of Wyko's and Veeco's interferometers (.opd): a directory of named blocks, then the blocks one after the other.
//!
//! A height is the stored number times `Wavelength` \[nm\] over `Mult`; samples lie `Pixel_size` \[mm\] apart, times `Aspect` along y.
//! Columns are stored one after the other, each from the bottom. Facts after Gwyddion's description and surfalize.

use super::bytes::{Cursor, Number, Order, damaged, text};
use super::format::Format;
use super::scan::{Block, Channel, Scan, flip, size, spacing};
use crate::error::Result;
use crate::surface::transpose::transposed;

/// The format.
pub const FORMAT: Format = Format {
    name: "wyko",
    title: "Wyko (Veeco, Bruker)",
    extensions: &["opd"],
    signature: |b| b.get(2..).is_some_and(|b| b.starts_with(b"Directory\0")),
    is_by_name: false,
    read,
    facts: [
        "yes, with the aspect of pixels",
        "yes",
        "the reserved codes",
        "8 and 16 bits, 32-bit floats; intensities are left out",
    ],
};

/// Bytes before the directory.
const PRELUDE: usize = 2;
/// Bytes of an entry of the directory; of its name.
const ENTRY: usize = 24;
const NAME: usize = 16;
/// Type of a block that is an array.
const ARRAY: u16 = 3;
/// Names of arrays of heights.
const HEIGHTS: [&str; 5] = ["RAW_DATA", "RAW DATA", "OPD", "SAMPLE_DATA", "Raw"];

/// Block of the file.
struct WykoBlock<'a> {
    name: String,
    kind: u16,
    bytes: &'a [u8],
}

/// Reads the file in `bytes`.
///
/// # Errors
/// A file without heights or without their scale; blocks beyond the end of the file.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let blocks = blocks(bytes)?;
    let number = |name: &str| blocks.iter().find(|block| block.name == name).and_then(WykoBlock::number);
    let wavelength = number("Wavelength").ok_or_else(|| damaged("its wavelength is missing"))?;
    let mult = number("Mult").filter(|mult| *mult != 0.0).unwrap_or(1.0);
    let aspect = number("Aspect").filter(|aspect| *aspect > 0.0).unwrap_or(1.0);
    let pixel = number("Pixel_size").map(|mm| mm * 1e-3);
    let spacing = [pixel.and_then(|d| spacing(d, 1)), pixel.and_then(|d| spacing(d * aspect, 1))];
    let is_height = |block: &&WykoBlock| block.kind == ARRAY && HEIGHTS.contains(&block.name.as_str());
    // The user's title, if there is one, names the heights.
    let title = blocks.iter().find(|block| block.name == "Title").map(|block| text(block.bytes));
    let title = title.filter(|title| !title.is_empty());
    let channels = blocks.iter().filter(is_height).map(|block| {
        let name = title.as_ref().unwrap_or(&block.name);
        (name.clone(), block.heights(name, wavelength / mult, spacing))
    });
    Scan::of_readable(FORMAT.title, channels.collect())
}

/// Returns all blocks but the directory.
fn blocks(bytes: &[u8]) -> Result<Vec<WykoBlock<'_>>> {
    let mut entries = Cursor::new(bytes, Order::Little).at(PRELUDE);
    let mut entry = || -> Result<(String, u16, usize)> {
        let name = text(entries.take(NAME)?);
        // A block of a negative length is empty.
        let (kind, length) = (entries.u16()?, entries.i32()?.max(0) as usize);
        entries.u16()?; // flags
        Ok((name, kind, length))
    };
    let (_, _, length) = entry()?;
    let mut rest = Cursor::new(bytes, Order::Little).at(PRELUDE.saturating_add(length));
    let mut found = Vec::new();
    for _ in 1..length / ENTRY {
        let (name, kind, length) = entry()?;
        found.push(WykoBlock { name, kind, bytes: rest.take(length)? });
    }
    Ok(found)
}

impl WykoBlock<'_> {
    /// Returns the number in a block of one number. Its type says whether it is an integer; its length counts where they differ.
    fn number(&self) -> Option<f64> {
        let mut cursor = Cursor::new(self.bytes, Order::Little);
        let number = match (self.kind, self.bytes.len()) {
            (6 | 7, 2) => cursor.i16().map(f64::from),
            (6 | 12, 4) => cursor.i32().map(f64::from),
            (7, 4..) => cursor.f32(),
            (8, 8..) => cursor.f64(),
            _ => return None,
        };
        number.ok().filter(|x| x.is_finite())
    }
}

impl<'a> WykoBlock<'a> {
    /// Returns the array as heights, of `unit` \[nm\].
    fn heights(&self, name: &str, unit: f64, spacing: [Option<f64>; 2]) -> Result<Channel<'a>> {
        let mut cursor = Cursor::new(self.bytes, Order::Little);
        let [columns, rows] = [cursor.u16()?, cursor.u16()?];
        // Above the thresholds nothing was measured.
        let (number, invalid) = match cursor.u16()? {
            1 => (Number::U8, f64::INFINITY),
            2 => (Number::I16, 32_766.0),
            4 => (Number::F32, f64::from(1e38_f32)),
            width => return Err(damaged(format!("its samples have {width} bytes"))),
        };
        let size = size(u64::from(columns), u64::from(rows))?;
        let block = Block {
            scale: [unit, 0.0],
            missing_from: Some(invalid),
            ..Block::plain(cursor.take(cursor.left())?, number, Order::Little)
        };
        let turned = Channel::stored(name, "nm", [size[1], size[0]], spacing, block)?;
        Ok(Channel { size, ..turned }.changed(move |columns| {
            let mut samples = transposed(size[1], &columns);
            flip(&mut samples, size[0]);
            samples
        }))
    }
}

#[cfg(test)]
#[path = "wyko_tests.rs"]
mod tests;
