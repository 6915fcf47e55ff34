//! Digital Surf's surfaces (.sur), plain or compressed.
//!
//! A header of 512 bytes, a comment, a private zone, then integers row by row from the top. The step of each axis has a separate unit.
//! Compressed files (`DSCOMPRESSED`) have zlib streams for the integers. Sources: Digital Surf's *Surf file format* and the readers of
//! Gwyddion and RosettaSciIO.

use super::bytes::{Cursor, Number, Order, cut_short, damaged};
use super::format::Format;
use super::scan::{Block, Channel, Scan, size, spacing};
use super::units;
use crate::error::{Error, Result};
use crate::memory;
use flate2::read::ZlibDecoder;
use std::borrow::Cow;
use std::io::Read;

/// First bytes of a plain file.
pub const MAGIC: &[u8] = b"DIGITAL SURF";
/// First bytes of a compressed file.
pub const COMPRESSED_MAGIC: &[u8] = b"DSCOMPRESSED";

/// Bytes of the header.
const HEADER: usize = 512;
/// The number in `format` of files whose numbers have their most significant byte first.
const MACINTOSH: u16 = 257;
/// Largest number of streams of a compressed file; real files have one for each core.
const MOST_STREAMS: u32 = 1 << 16;

/// The format.
pub const FORMAT: Format = Format {
    name: "digital_surf",
    title: "Digital Surf",
    extensions: &["sur"],
    signature: |b| b.starts_with(MAGIC) || b.starts_with(COMPRESSED_MAGIC),
    is_by_name: false,
    read,
    facts: [
        "yes",
        "yes",
        "two below the lowest code, if the header says so",
        "16 and 32 bits, compressed, both byte orders",
    ],
};

/// Reads the file in `bytes`. Several surfaces in one file are channels.
///
/// # Errors
/// A profile or a picture instead of a surface; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let mut channels = Vec::new();
    let mut rest = bytes;
    let mut left = 1;
    while left > 0 {
        let header = DigitalSurfHeader::read(rest)?;
        if channels.is_empty() {
            left = u32::from(header.objects.max(1));
        }
        left -= 1;
        let (channel, end) = surface(rest, &header, channels.len())?;
        channels.push(channel);
        rest = &rest[end..];
        // The objects that the header counts may include other kinds behind the surfaces.
        if !(rest.starts_with(MAGIC) || rest.starts_with(COMPRESSED_MAGIC)) {
            break;
        }
    }
    Ok(Scan::new("Digital Surf", channels))
}

struct DigitalSurfHeader {
    order: Order,
    compressed: bool,
    objects: u16,
    kind: u16,
    special_points: bool,
    bits: u16,
    lowest: i32,
    counts: [i32; 2],
    steps: [f64; 3],
    name: String,
    step_units: [String; 3],
    height_offset: f64,
    /// Offset of the samples in the file \[bytes\].
    data: usize,
}

impl DigitalSurfHeader {
    fn read(bytes: &[u8]) -> Result<Self> {
        let format = bytes.get(12..14).ok_or_else(cut_short)?;
        let macintosh = u16::from_le_bytes([format[0], format[1]]) == MACINTOSH;
        let order = if macintosh { Order::Big } else { Order::Little };
        let from = |place: usize| Cursor::new(bytes.get(..HEADER).unwrap_or_default(), order).at(place);
        if bytes.len() < HEADER {
            return Err(cut_short());
        }
        let mut steps = from(120);
        let unit = |place: usize| from(place).text(16);
        Ok(Self {
            order,
            compressed: bytes.starts_with(COMPRESSED_MAGIC),
            objects: from(14).u16()?,
            kind: from(18).u16()?,
            special_points: from(86).u16()? != 0,
            bits: from(98).u16()?,
            lowest: from(100).i32()?,
            counts: [from(108).i32()?, from(112).i32()?],
            steps: [steps.f32()?, steps.f32()?, steps.f32()?],
            name: unit(164)?,
            step_units: [unit(180)?, unit(196)?, unit(212)?],
            height_offset: from(474).f32()?,
            data: HEADER + usize::from(from(334).u16()?) + usize::from(from(336).u16()?),
        })
    }

    /// Checks that the object is a surface.
    ///
    /// # Errors
    /// Another kind of object.
    fn check_kind(&self) -> Result<()> {
        let what = match self.kind {
            3 => "a picture of two colours",
            4 | 7 => "profiles",
            10 | 11 => "intensities",
            12..=19 => "a picture in colours",
            20.. => "spectra",
            _ => return Ok(()),
        };
        Err(Error::input(format!("holds {what} and no surface"), "choose a file with a surface in it"))
    }
}

/// Returns the surface at the beginning of `bytes`, and the offset of its end.
fn surface<'a>(bytes: &'a [u8], header: &DigitalSurfHeader, i: usize) -> Result<(Channel<'a>, usize)> {
    header.check_kind()?;
    let [columns, rows] = header.counts.map(|n| u64::try_from(n).unwrap_or(0));
    let size = size(columns, rows)?;
    let number = match header.bits {
        16 => Number::I16,
        32 => Number::I32,
        bits => return Err(damaged(format!("its samples have {bits} bits"))),
    };
    let count = size[0] * size[1] * number.bytes();
    let data = bytes.get(header.data..).ok_or_else(cut_short)?;
    let (data, used) = if header.compressed {
        inflate(data, header.order, count)?
    } else {
        (Cow::Borrowed(data.get(..count).ok_or_else(cut_short)?), count)
    };
    // The offset is in the unit of the step; readers differ about it, and differences of heights do not depend on it.
    let offset = if header.height_offset.is_finite() { header.height_offset } else { 0.0 };
    let block = Block {
        bytes: data,
        scale: [header.steps[2], offset],
        // The code two below the lowest one marks samples that were not measured.
        missing: header.special_points.then(|| f64::from(header.lowest) - 2.0),
        ..Block::plain(&[], number, header.order)
    };
    let step = |i: usize| spacing(header.steps[i] * units::length(&header.step_units[i])?, 1);
    let name = if header.name.is_empty() { "Height" } else { &header.name };
    let name = if i == 0 { name.to_owned() } else { format!("{name} {}", i + 1) };
    let channel = Channel::stored(name, &header.step_units[2], size, [step(0), step(1)], block)?;
    Ok((channel, header.data + used))
}

/// Decompresses `count` bytes from the streams at the beginning of `bytes`, and returns the length of the streams as well.
fn inflate(bytes: &[u8], order: Order, count: usize) -> Result<(Cow<'static, [u8]>, usize)> {
    let mut cursor = Cursor::new(bytes, order);
    let streams = cursor.u32()?;
    if streams > MOST_STREAMS {
        return Err(damaged(format!("it counts {streams} streams")));
    }
    let lengths = (0..streams).map(|_| Ok((cursor.u32()? as usize, cursor.u32()? as usize)));
    let lengths: Vec<(usize, usize)> = lengths.collect::<Result<_>>()?;
    let total = lengths.iter().fold(0_usize, |sum, (raw, _)| sum.saturating_add(*raw));
    /// Largest compression ratio of zlib, rounded up.
    const DENSEST: usize = 1100;
    if total < count || bytes.len().saturating_mul(DENSEST) < count {
        return Err(damaged("its streams hold fewer samples than its header counts"));
    }
    memory::ensure_room(count as u64, "the samples of a compressed surface")?;
    let mut inflated = Vec::with_capacity(count);
    for (raw, packed) in lengths {
        let wanted = raw.min(count - inflated.len());
        let before = inflated.len();
        let stream = cursor.take(packed)?;
        let mut decoder = ZlibDecoder::new(stream);
        decoder.by_ref().take(wanted as u64).read_to_end(&mut inflated).map_err(damaged)?;
        if wanted == raw && decoder.read(&mut [0]).map_err(damaged)? > 0 {
            return Err(damaged("a stream holds more than it promises"));
        }
        if inflated.len() - before != wanted {
            return Err(damaged("a stream holds less than it promises"));
        }
    }
    Ok((Cow::Owned(inflated), cursor.place()))
}

#[cfg(test)]
#[path = "digital_surf_tests.rs"]
mod tests;
