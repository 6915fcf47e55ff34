//! TIFF files of Park Systems' (PSIA's) microscopes: the picture is a thumbnail, the heights stand in private tags.
//!
//! Tag 50434 holds the samples, the bottom row first, 50435 a header of fixed fields (little-endian). A height is
//! (stored number × scale + offset) × gain in the header's unit; the gain may be negative. Facts after Gwyddion's description.

use super::bytes::{Cursor, Number, Order, cut_short, damaged};
use super::format::Format;
use super::scan::{Block, Channel, Rows, Scan, size, spacing};
use super::tiff_tags::TiffDirectory;
use crate::error::{Error, Result};

/// Private tags.
const VERSION_TAG: u16 = 50433;
const DATA_TAG: u16 = 50434;
const HEADER_TAG: u16 = 50435;

/// Version from which the header names the type of samples; older files have 16-bit integers.
const TYPED: u32 = 0x0100_0002;

/// Offset of the type of samples in the header \[bytes\].
const TYPE_PLACE: usize = 348;

/// The format.
pub const FORMAT: Format = Format {
    name: "park",
    title: "TIFF of Park Systems",
    extensions: &["tiff"],
    signature: recognise,
    is_by_name: false,
    read,
    facts: ["yes", "yes", "NaN", "private tags 50434 and 50435"],
};

/// Returns true if `bytes` are a TIFF with Park's samples.
fn recognise(bytes: &[u8]) -> bool {
    TiffDirectory::all(bytes).first().is_some_and(|tags| tags.value(DATA_TAG).is_some())
}

/// Reads the file in `bytes`.
///
/// # Errors
/// A header that is too short; fewer samples than the header promises; line profiles.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let directories = TiffDirectory::all(bytes);
    let tags = directories.first().ok_or_else(cut_short)?;
    let data = tags.value(DATA_TAG).ok_or_else(|| damaged("Park's samples (tag 50434) are missing"))??;
    let header = tags.value(HEADER_TAG).ok_or_else(|| damaged("Park's header (tag 50435) is missing"))??;
    let version = tags.number(VERSION_TAG).map_or(0, |version| version as u32);
    let header = ParkHeader::read(header, version)?;
    let size = size(u64::from(header.counts[0]), u64::from(header.counts[1]))?;
    let block = Block {
        scale: [header.scale * header.gain, header.offset * header.gain],
        rows: Rows::BottomFirst,
        ..Block::plain(data, header.number, Order::Little)
    };
    let side = |i: usize| spacing(header.sides[i], size[i]);
    let channel = Channel::stored(header.name, &header.unit, size, [side(0), side(1)], block)?;
    Ok(Scan::single("Park TIFF", channel))
}

struct ParkHeader {
    name: String,
    counts: [u32; 2],
    /// Width and height of the whole image \[m\].
    sides: [f64; 2],
    gain: f64,
    scale: f64,
    offset: f64,
    unit: String,
    number: Number,
}

impl ParkHeader {
    fn read(header: &[u8], version: u32) -> Result<Self> {
        let mut cursor = Cursor::new(header, Order::Little);
        /// Value of `image type` for a line profile.
        const LINE_PROFILE: u32 = 1;
        if cursor.u32()? == LINE_PROFILE {
            return Err(Error::input("holds a line profile and no image", "choose an image file"));
        }
        let name = cursor.wide_text(32)?;
        cursor.wide_text(8)?; // mode
        cursor.take(8 + 4 + 4)?; // filter, flattening, tracking
        let counts = [cursor.u32()?, cursor.u32()?];
        cursor.take(8 + 4 + 8 + 4 + 4 + 4)?; // angle, kind of scan, overscan, directions, exchanged axes
        let sides = [cursor.f64()? * 1e-6, cursor.f64()? * 1e-6];
        cursor.take(4 * 8)?; // offsets, rate, set point
        cursor.wide_text(8)?; // its unit
        cursor.take(2 * 8)?; // biases
        let gain = cursor.f64()?;
        let scale = cursor.f64()?;
        let offset = cursor.f64()?;
        let unit = cursor.wide_text(8)?;
        let number = if version >= TYPED && header.len() >= TYPE_PLACE + 4 {
            match Cursor::new(header, Order::Little).at(TYPE_PLACE).u32()? {
                0 => Number::I16,
                1 => Number::I32,
                2 => Number::F32,
                other => return Err(damaged(format!("its samples have the unknown type {other}"))),
            }
        } else {
            Number::I16
        };
        Ok(Self {
            name: if name.is_empty() { "Height".to_owned() } else { name },
            counts,
            sides,
            gain,
            scale: if scale == 0.0 { 1.0 } else { scale },
            offset,
            unit: if unit.is_empty() { "um".to_owned() } else { unit },
            number,
        })
    }
}

#[cfg(test)]
#[path = "park_tests.rs"]
mod tests;
