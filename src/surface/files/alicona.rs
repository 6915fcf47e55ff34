//! Height maps of Alicona's focus-variation microscopes (.al3d): tags of text, then 32-bit floats in metres from the top.
//!
//! Rows are padded to eight bytes. Source: Alicona, *AL3D File Format Specification*, version 1.0.

use super::bytes::{Cursor, Number, Order, damaged};
use super::format::Format;
use super::header::TextHeader;
use super::scan::{Block, Channel, Scan, size, spacing};
use crate::error::{Error, Result};

/// The format.
pub const FORMAT: Format = Format {
    name: "alicona",
    title: "Alicona Imaging",
    extensions: &["al3d"],
    signature: |b| b.starts_with(MAGIC),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "NaN, the header's value", "the depth image; the texture is left out"],
};

/// First bytes of a file.
const MAGIC: &[u8] = b"AliconaImaging\0\r\n";
/// Bytes of the name of a tag, of its value, and of the end of the line.
const NAME: usize = 20;
const VALUE: usize = 30;
const LINE_END: usize = 2;
/// Bytes that the length of a row is a multiple of.
const ALIGNMENT: usize = 8;

/// Reads the file in `bytes`.
///
/// # Errors
/// A header without sizes; a file without a depth image; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let mut cursor = Cursor::new(bytes, Order::Little).at(MAGIC.len());
    let mut header = TextHeader::default();
    // The first two tags are the version and the number of the others.
    let mut left = 2;
    while left > 0 {
        let (name, value) = (cursor.text(NAME)?, cursor.text(VALUE)?);
        if cursor.take(LINE_END)? != b"\r\n" {
            return Err(damaged(format!("the tag `{name}` has no end")));
        }
        header.insert("", &name, &value);
        left -= 1;
        if name == "TagCount" {
            left = header.count("", "TagCount")?;
        }
    }
    let size = size(header.count("", "Cols")?, header.count("", "Rows")?)?;
    let offset = header.count("", "DepthImageOffset")?;
    if offset == 0 {
        return Err(Error::input("holds a picture and no heights", "choose a file with a depth image"));
    }
    let width = size[0] * Number::F32.bytes();
    let stride = width.next_multiple_of(ALIGNMENT);
    let mut rows = cursor.at(usize::try_from(offset).unwrap_or(usize::MAX));
    // The last row may lack its padding.
    let data = rows.take(stride * (size[1] - 1) + width)?;
    let packed: Vec<u8> = data.chunks(stride).flat_map(|row| &row[..width]).copied().collect();
    // The number in the text has more digits than the samples.
    let invalid = header.number("", "InvalidPixelValue").map(|x| f64::from(x as f32));
    let block = Block {
        bytes: packed.into(),
        missing: invalid,
        missing_from: invalid.filter(|x| *x > 0.0),
        ..Block::plain(&[], Number::F32, Order::Little)
    };
    let pixel = |name: &str| spacing(header.number("", name)?, 1);
    let spacing = [pixel("PixelSizeXMeter"), pixel("PixelSizeYMeter")];
    Ok(Scan::single(FORMAT.title, Channel::stored("Depth", "m", size, spacing, block)?))
}

#[cfg(test)]
#[path = "alicona_tests.rs"]
mod tests;
