//! TIFF files of Park Systems' (PSIA's) microscopes: the picture is a thumbnail, the heights stand in private tags.
//!
//! Tag 50434 holds the samples, the bottom row first, 50435 a header of fixed fields (little-endian). A height is
//! (stored number × scale + offset) × gain in the header's unit; the gain may be negative. Facts after Gwyddion's description.

use super::bytes::{Cursor, Number, Order, cut_short, damaged};
use super::scan::{Block, Channel, Quantity, Rows, Scan, size, spacing};
use super::units;
use crate::error::{Error, Result};
use crate::notes::PreparationRecord;
use std::borrow::Cow;

/// Private tags.
const VERSION_TAG: u16 = 50433;
const DATA_TAG: u16 = 50434;
const HEADER_TAG: u16 = 50435;

/// Version from which the header names the type of samples; older files have 16-bit integers.
const TYPED: u32 = 0x0100_0002;

/// Offset of the type of samples in the header \[bytes\].
const TYPE_PLACE: usize = 348;

/// Reads the file in `bytes`; `None` for a TIFF without Park's tags.
///
/// # Errors
/// A header that is too short; fewer samples than the header promises; line profiles.
pub fn read(bytes: &[u8]) -> Result<Option<Scan<'_>>> {
    let Some(tags) = Tags::read(bytes) else { return Ok(None) };
    let Some(data) = tags.value(bytes, DATA_TAG) else { return Ok(None) };
    let data = data?;
    let header =
        tags.value(bytes, HEADER_TAG).ok_or_else(|| damaged("Park's header (tag 50435) is missing"))??;
    let version = tags.number(VERSION_TAG).unwrap_or_default();
    let header = ParkHeader::read(header, version)?;
    let metres = units::length(&header.unit);
    let unit = metres.unwrap_or(1.0);
    let size = size(u64::from(header.counts[0]), u64::from(header.counts[1]))?;
    let block = Block {
        bytes: Cow::Borrowed(data),
        scale: [header.scale * header.gain * unit, header.offset * header.gain * unit],
        rows: Rows::BottomFirst,
        ..Block::plain(data, header.number, Order::Little)
    };
    let decode = block.decode(size)?;
    let side = |i: usize| spacing(header.sides[i], size[i]);
    let channel = Channel {
        name: header.name,
        unit: header.unit,
        size,
        spacing: [side(0), side(1)],
        quantity: if metres.is_some() { Quantity::Height } else { Quantity::Other },
        prepared: PreparationRecord::default(),
        decode,
    };
    Ok(Some(Scan::single("Park TIFF", channel)))
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
        if !(gain.is_finite() && scale.is_finite() && offset.is_finite()) {
            return Err(damaged("its scale of heights is no number"));
        }
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

/// Entries of the first directory of a TIFF: tag, type, count, and the four bytes of the value or of its offset.
struct Tags {
    order: Order,
    entries: Vec<(u16, u16, u32, u32)>,
}

impl Tags {
    fn read(bytes: &[u8]) -> Option<Self> {
        let order = match bytes.get(..4)? {
            b"II*\0" => Order::Little,
            b"MM\0*" => Order::Big,
            _ => return None,
        };
        let mut cursor = Cursor::new(bytes, order).at(4);
        let place = cursor.u32().ok()? as usize;
        let mut cursor = cursor.at(place);
        let count = cursor.u16().ok()?;
        let mut entry =
            || Some((cursor.u16().ok()?, cursor.u16().ok()?, cursor.u32().ok()?, cursor.u32().ok()?));
        Some(Self { order, entries: (0..count).map_while(|_| entry()).collect() })
    }

    fn entry(&self, tag: u16) -> Option<(u16, u16, u32, u32)> {
        self.entries.iter().find(|entry| entry.0 == tag).copied()
    }

    /// Returns the whole number of `tag`.
    fn number(&self, tag: u16) -> Option<u32> {
        self.entry(tag).map(|(_, _, _, value)| value)
    }

    /// Returns the bytes of `tag`, which stand apart from the directory; `None` if there is no such tag.
    fn value<'a>(&self, bytes: &'a [u8], tag: u16) -> Option<Result<&'a [u8]>> {
        let (_, kind, count, place) = self.entry(tag)?;
        let width = match kind {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 => 4,
            _ => 8,
        };
        let length = (count as usize).saturating_mul(width);
        Some(Cursor::new(bytes, self.order).at(place as usize).take(length).map_err(|_| cut_short()))
    }
}

#[cfg(test)]
#[path = "park_tests.rs"]
mod tests;
