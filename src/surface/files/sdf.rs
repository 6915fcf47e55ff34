//! Surface data files of ISO 25178-71 (.sdf), as text or binary.
//!
//! A header of fixed fields in metres, then the profiles one after the other: the first one is shown at the top, as Gwyddion
//! does. A height is the stored number times `Zscale`.

use super::bytes::{Cursor, Number, Order, cut_short, damaged, decode_text};
use super::format::Format;
use super::scan::{Block, Channel, Quantity, Scan, size, spacing};
use crate::error::{Error, Result};
use crate::memory;
use crate::notes::PreparationRecord;

/// The format.
pub const FORMAT: Format = Format {
    name: "sdf",
    title: "ISO 25178-71",
    extensions: &["sdf"],
    signature: |b| TEXT_MAGICS.iter().chain(&BINARY_MAGICS).any(|magic| b.starts_with(magic)),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "`BAD`, the reserved code", "text and binary"],
};

/// First bytes of text files; the second are those of the standard's forerunner.
pub const TEXT_MAGICS: [&[u8]; 2] = [b"aISO-1.0", b"aBCR-1.0"];
/// First bytes of binary files.
pub const BINARY_MAGICS: [&[u8]; 2] = [b"bISO-1.0", b"bBCR-1.0"];

/// Reads the file in `bytes`, text or binary.
///
/// # Errors
/// See [`read_text`] and [`read_binary`].
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    if TEXT_MAGICS.iter().any(|magic| bytes.starts_with(magic)) {
        read_text(bytes)
    } else {
        read_binary(bytes)
    }
}

/// Fields of text and binary headers.
struct SdfHeader {
    counts: [u64; 2],
    scales: [f64; 3],
    compression: u64,
}

impl SdfHeader {
    fn size(&self) -> Result<[usize; 2]> {
        if self.compression != 0 {
            return Err(Error::input(
                "is compressed, in a way that no standard describes",
                "save it uncompressed",
            ));
        }
        if !self.scales[2].is_finite() || self.scales[2] == 0.0 {
            return Err(damaged(format!("its Zscale is {}", self.scales[2])));
        }
        size(self.counts[0], self.counts[1])
    }

    fn channel<'a>(&self, size: [usize; 2], decode: super::scan::Decode<'a>) -> Scan<'a> {
        let channel = Channel {
            name: "Height".to_owned(),
            unit: "m".to_owned(),
            size,
            spacing: [spacing(self.scales[0], 1), spacing(self.scales[1], 1)],
            quantity: Quantity::Height,
            prepared: PreparationRecord::default(),
            decode,
        };
        Scan::single("ISO 25178-71", channel)
    }
}

/// Reads the binary file in `bytes`.
///
/// # Errors
/// Fewer samples than its header promises, a type of samples or a compression that the standard does not have.
pub fn read_binary(bytes: &[u8]) -> Result<Scan<'_>> {
    let mut cursor = Cursor::new(bytes, Order::Little);
    cursor.take(8 + 10 + 12 + 12)?; // version, manufacturer, dates of creation and modification
    let counts = [u64::from(cursor.u16()?), u64::from(cursor.u16()?)];
    let scales = [cursor.f64()?, cursor.f64()?, cursor.f64()?];
    cursor.f64()?; // the resolution of heights
    let (compression, data_type) = (u64::from(cursor.u8()?), u64::from(cursor.u8()?));
    cursor.u8()?; // the kind of check sum
    let header = SdfHeader { counts, scales, compression };
    let size = header.size()?;
    let number = sample_type(data_type)?;
    let data = cursor.take(cursor.left())?;
    let mut block = Block::plain(data, number, Order::Little);
    block.scale[0] = scales[2];
    block.missing = missing_code(number);
    let decode = block.decode(size)?;
    Ok(header.channel(size, decode))
}

fn sample_type(code: u64) -> Result<Number> {
    match code {
        0 => Ok(Number::U8),
        1 => Ok(Number::U16),
        2 => Ok(Number::U32),
        3 => Ok(Number::F32),
        4 => Ok(Number::I8),
        5 => Ok(Number::I16),
        6 => Ok(Number::I32),
        7 => Ok(Number::F64),
        _ => Err(damaged(format!("its samples have the unknown type {code}"))),
    }
}

/// Returns the integer of a sample that was not measured; samples of 8 bits have none.
fn missing_code(number: Number) -> Option<f64> {
    match number {
        Number::U16 | Number::U32 => Some(number.largest()),
        Number::I16 => Some(f64::from(i16::MIN)),
        Number::I32 => Some(f64::from(i32::MIN)),
        _ => None,
    }
}

/// Reads the text file in `bytes`.
///
/// # Errors
/// A header without sizes or scales, fewer or more samples than the header promises, a sample that is no number.
pub fn read_text(bytes: &[u8]) -> Result<Scan<'_>> {
    let text = decode_text(bytes);
    let mut start = None;
    let mut entries = Vec::new();
    let mut place = 0;
    for line in text.split_inclusive('\n') {
        place += line.len();
        let line = line.trim();
        if line.starts_with('*') {
            start = Some(place);
            break;
        }
        // A semicolon begins a comment.
        if let Some((key, value)) = line.split(';').next().and_then(|line| line.split_once('=')) {
            entries.push((key.trim().to_lowercase(), value.trim().to_owned()));
        }
    }
    let data = &text[start.ok_or_else(cut_short)?..];
    let header = text_header(&entries)?;
    let size = header.size()?;
    let samples = samples(data, size, header.scales[2])?;
    Ok(header.channel(size, Box::new(move || Ok(samples))))
}

fn text_header(entries: &[(String, String)]) -> Result<SdfHeader> {
    let value = |key: &str| {
        let found = entries.iter().find(|(k, _)| *k == key.to_lowercase()).map(|(_, value)| value.as_str());
        found.ok_or_else(|| damaged(format!("{key} is missing")))
    };
    let whole = |key: &str| value(key)?.parse::<u64>().map_err(|_| damaged(format!("{key} is no count")));
    let number = |key: &str| value(key)?.parse::<f64>().map_err(|_| damaged(format!("{key} is no number")));
    Ok(SdfHeader {
        counts: [whole("NumPoints")?, whole("NumProfiles")?],
        scales: [number("Xscale")?, number("Yscale")?, number("Zscale")?],
        compression: if value("Compression").is_ok() { whole("Compression")? } else { 0 },
    })
}

/// Parses the numbers in `text` up to an asterisk, times `scale`.
fn samples(text: &str, size: [usize; 2], scale: f64) -> Result<Vec<f64>> {
    let count = size[0] * size[1];
    // Every sample takes a digit and a space, so that short texts promise no large arrays.
    if text.len() + 1 < 2 * count {
        return Err(cut_short());
    }
    memory::ensure_room(count as u64 * 8, &format!("a scan of {} x {} samples", size[0], size[1]))?;
    let mut samples = Vec::with_capacity(count);
    let (text, ended) = text.find('*').map_or((text, false), |end| (&text[..end], true));
    for word in text.split_whitespace() {
        if samples.len() == count {
            return Err(damaged(format!("it has more than the {count} samples that its header counts")));
        }
        let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
        let bad = word.eq_ignore_ascii_case("bad") || word.eq_ignore_ascii_case("nan");
        match number {
            Some(x) => samples.push(x * scale),
            None if bad => samples.push(f64::NAN),
            None => return Err(damaged(format!("`{word}` is no height"))),
        }
    }
    // Without the asterisk the last number may have lost digits.
    if samples.len() < count || !ended {
        return Err(cut_short());
    }
    Ok(samples)
}

#[cfg(test)]
#[path = "sdf_tests.rs"]
mod tests;
