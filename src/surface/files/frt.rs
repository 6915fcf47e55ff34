//! Height maps of FRT's MicroProf (.frt): blocks of a tag, a length and a value, little-endian.
//!
//! Heights are integers times a factor in metres, the first line is the lowest. Files with several sensors hold them in one block, each with
//! its type and size. Facts after Gwyddion's description and SurfaceTopography.

use super::bytes::{Cursor, Number, Order, damaged};
use super::format::Format;
use super::scan::{Block, Channel, Rows, Scan, size, spacing};
use crate::error::{Error, Result};

/// The format.
pub const FORMAT: Format = Format {
    name: "frt",
    title: "FRT MicroProf",
    extensions: &["frt"],
    signature: |b| b.starts_with(MAGIC),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "code 1", "16 and 32 bits, several sensors; intensities are left out"],
};

/// First bytes of a file; the version follows.
const MAGIC: &[u8] = b"FRTM_GLIDERV";
/// Tags of the blocks of heights, of counts and bits, of width and height, of the factor of heights, and of all sensors.
const HEIGHTS: u16 = 0x0b;
const COUNTS: u16 = 0x66;
const SIDES: u16 = 0x67;
const FACTOR: u16 = 0x6c;
const SENSORS: u16 = 0x7d;
/// Number of a sample that was not measured.
const INVALID: f64 = 1.0;
/// Bits of the type of an image, each with its name, that are heights.
const TYPES: [(u32, &str); 4] =
    [(0x4, "Topography"), (0x80, "Thickness"), (0x800, "Sample thickness"), (0x1000, "AFM")];
/// Bit of the type of an image of the lower sensor.
const BOTTOM: u32 = 0x1000_0000;
/// Place of the number of a sensor in the type of its image.
const SENSOR_SHIFT: u32 = 24;

/// Reads the file in `bytes`.
///
/// # Errors
/// Another version; a file without heights or scales; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let mut cursor = Cursor::new(bytes, Order::Little).at(MAGIC.len());
    let is_long = match cursor.take(4)? {
        b"1.00" => false,
        b"1.01" => true,
        other => {
            return Err(Error::input(
                format!("is of the unknown version {}", String::from_utf8_lossy(other).escape_debug()),
                "save it in version 1.01",
            ));
        }
    };
    let mut blocks = Vec::new();
    for _ in 0..cursor.u16()? {
        let tag = cursor.u16()?;
        let mut length = cursor.u32()? as usize;
        // Lengths of 64 bits are beyond the file if their upper half is not 0.
        if is_long && cursor.u32()? != 0 {
            length = usize::MAX;
        }
        blocks.push((tag, cursor.take(length)?));
    }
    let block = |tag: u16| {
        let found = blocks.iter().find(|(other, _)| *other == tag);
        found.map(|(_, bytes)| Cursor::new(bytes, Order::Little))
    };
    let missing = |what: &str| damaged(format!("its {what} are missing"));
    let mut sides = block(SIDES).ok_or_else(|| missing("width and height"))?;
    let sides = [sides.f64()?, sides.f64()?];
    let factor = block(FACTOR).ok_or_else(|| missing("units"))?.at(4).f64()?;
    let mut found = block(SENSORS).map_or_else(|| Ok(Vec::new()), sensors)?;
    if found.is_empty() {
        let mut counts = block(COUNTS).ok_or_else(|| missing("counts of samples"))?;
        let counts = [counts.u32()?, counts.u32()?, counts.u32()?];
        let data = block(HEIGHTS).ok_or_else(|| missing("heights"))?;
        found.push(("Topography".to_owned(), counts, data));
    }
    let channels = found.into_iter().map(|(name, counts, mut data)| {
        let channel = data.take(data.left()).and_then(|data| heights(&name, counts, data, sides, factor));
        (name, channel)
    });
    Scan::of_readable(FORMAT.title, channels.collect())
}

/// Name, counts with bits, and samples of an image.
type FrtImage<'a> = (String, [u32; 3], Cursor<'a>);

/// Returns the heights in the block of all sensors.
fn sensors(mut block: Cursor) -> Result<Vec<FrtImage>> {
    block.take(4 * 2)?; // numbers of buffers
    let mut found = Vec::new();
    while block.left() > 0 {
        let kind = block.u32()?;
        let counts = [block.u32()?, block.u32()?, block.u32()?];
        let bytes = counts.iter().fold(1_usize, |product, n| product.saturating_mul(*n as usize)) / 8;
        let data = Cursor::new(block.take(bytes)?, Order::Little);
        if let Some((_, name)) = TYPES.iter().find(|(bit, _)| kind & bit != 0) {
            let place = if kind & BOTTOM == 0 { "top" } else { "bottom" };
            let number = (kind >> SENSOR_SHIFT & 0xf) + 1;
            found.push((format!("{name} ({place} sensor) {number}"), counts, data));
        }
    }
    Ok(found)
}

fn heights<'a>(
    name: &str,
    [columns, rows, bits]: [u32; 3],
    data: &'a [u8],
    sides: [f64; 2],
    factor: f64,
) -> Result<Channel<'a>> {
    let number = match bits {
        16 => Number::U16,
        32 => Number::I32,
        _ => return Err(damaged(format!("its samples have {bits} bits"))),
    };
    let size = size(u64::from(columns), u64::from(rows))?;
    let block = Block {
        scale: [factor, 0.0],
        missing: Some(INVALID),
        rows: Rows::BottomFirst,
        ..Block::plain(data, number, Order::Little)
    };
    let spacing = [0, 1].map(|i| spacing(sides[i], size[i]));
    Channel::stored(name, "m", size, spacing, block)
}

#[cfg(test)]
#[path = "frt_tests.rs"]
mod tests;
