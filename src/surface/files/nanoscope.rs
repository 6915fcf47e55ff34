//! Nanoscope files of Bruker, Veeco and Digital Instruments (.spm, .000 …): a text header, then blocks of integers.
//!
//! The header has sections `\*Name` of lines `\Key: value`. A height is the stored integer times the hard value of
//! `@2:Z scale`, over 2^(8 · `Bytes/pixel`), times the sensitivity (`@Sens. …`, in nm/V) that the scale names in brackets.
//! The factor in parentheses (V/LSB) is rounded and not used. The first stored row is the bottom of the surface. Facts after
//! the manual of Nanoscope 4.x to 10 and Gwyddion's description of the format.

mod header;

use super::bytes::{Number, Order, damaged};
use super::format::Format;
use super::scan::{Block, Channel, Quantity, Rows, Scan, size, spacing};
use super::units;
use crate::error::{Error, Result};
use crate::notes::PreparationRecord;
use header::{NanoscopeHeader, ParameterValue, Section};
use std::ops::Range;

/// First bytes of a file of images. Older files have a question mark for the backslash, those of electrochemical cells another name.
pub const MAGICS: [&[u8]; 3] = [b"\\*File list", b"?*File list", b"\\*EC File list"];
/// First bytes of a file of force curves.
pub const FORCE_MAGIC: &[u8] = b"\\*Force file list";

/// Version from which samples have four bytes, whatever `Bytes/pixel` says.
const WIDE_SAMPLES: u32 = 0x0920_0000;

/// The format.
pub const FORMAT: Format = Format {
    name: "nanoscope",
    title: "Nanoscope (Bruker, Veeco), also `.000` …",
    extensions: &["spm"],
    signature: |b| MAGICS.iter().any(|magic| b.starts_with(magic)) || b.starts_with(FORCE_MAGIC),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "", "2- and 4-byte samples, new and old scales, several channels"],
};

/// Reads the file in `bytes`.
///
/// # Errors
/// A header without images; fewer samples than the header promises; force curves.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    if bytes.starts_with(FORCE_MAGIC) {
        return Err(Error::input("holds force curves and no image", "choose an image file"));
    }
    let header = NanoscopeHeader::parse(bytes)?;
    let images = || header.sections.iter().filter(|s| s.is_image());
    let channels = images().map(|image| (image.name(), channel(bytes, &header, image)));
    Scan::of_readable("Nanoscope", channels.collect())
}

fn channel<'a>(bytes: &'a [u8], header: &NanoscopeHeader, image: &Section) -> Result<Channel<'a>> {
    let (columns, lines) = counts(image)?;
    let rows = measured(image, lines)?;
    let size = size(columns, rows.end - rows.start)?;
    let place = image.count("data offset")?;
    let length = image.optional_count("data length")?.unwrap_or(u64::MAX);
    let declared = image.optional_count("bytes/pixel")?.unwrap_or(2);
    let stored = sample_type(header.version, declared, length, columns.saturating_mul(lines))?;
    let valid = sample_type(header.version, declared, length, size[0] as u64 * size[1] as u64)?;
    // A file of a stopped scan stores either all lines or only the measured ones.
    let line = columns.saturating_mul(stored.bytes() as u64);
    let holds_all = length >= lines.saturating_mul(line);
    let (number, skipped) = if holds_all { (stored, rows.start.saturating_mul(line)) } else { (valid, 0) };
    let start = usize::try_from(place.saturating_add(skipped)).unwrap_or(usize::MAX);
    let data = bytes.get(start..).ok_or_else(super::bytes::cut_short)?;
    let scale = scale(header, image, declared)?;
    let mut block = Block::plain(data, number, Order::Little);
    block.scale[0] = scale.factor;
    block.rows = Rows::BottomFirst;
    Ok(Channel {
        name: image.name(),
        unit: scale.unit,
        size,
        spacing: spacings(header, image, [columns, lines]),
        quantity: if scale.is_length { Quantity::Height } else { Quantity::Other },
        prepared: PreparationRecord::default(),
        decode: block.decode(size)?,
    })
}

/// Returns the numbers of samples of a line and of lines; Nanoscope E writes both behind `Samps/line`.
fn counts(image: &Section) -> Result<(u64, u64)> {
    let columns = image.count("samps/line")?;
    let second = || image.text("samps/line")?.split_whitespace().nth(1)?.parse().ok();
    let rows = image.optional_count("number of lines")?.or_else(second);
    Ok((columns, rows.ok_or_else(|| damaged("`Number of lines` is missing"))?))
}

/// Returns the lines that were measured: all, or those of a scan that was stopped.
fn measured(image: &Section, lines: u64) -> Result<Range<u64>> {
    let count = image.optional_count("valid data len y")?.filter(|n| (1..lines).contains(n));
    let start = image.optional_count("valid data start y")?.unwrap_or(0);
    Ok(match count {
        Some(count) if start.saturating_add(count) <= lines => start..start + count,
        _ => 0..lines,
    })
}

fn sample_type(version: Option<u32>, declared: u64, length: u64, count: u64) -> Result<Number> {
    let wide = version.is_some_and(|v| v >= WIDE_SAMPLES) && length >= count.saturating_mul(4);
    match if wide { 4 } else { declared } {
        1 => Ok(Number::I8),
        2 => Ok(Number::I16),
        4 => Ok(Number::I32),
        other => Err(damaged(format!("{other} bytes for a sample are not known"))),
    }
}

/// Size of one step of the stored integers.
struct SampleScale {
    /// Factor in metres for a length, otherwise in units of `unit`.
    factor: f64,
    /// The unit, for people.
    unit: String,
    is_length: bool,
}

/// Returns the scale of `image`, by the newest rule that its header follows.
fn scale(header: &NanoscopeHeader, image: &Section, bytes: u64) -> Result<SampleScale> {
    let full = 2_f64.powi(8 * bytes as i32);
    let by_unit = |value: f64, unit: &str| {
        let metres = units::length(unit);
        SampleScale {
            factor: value * metres.unwrap_or(1.0) / full,
            unit: unit.to_owned(),
            is_length: metres.is_some(),
        }
    };
    if let Some(text) = image.numbered("z scale") {
        let hard = ParameterValue::parse(text).ok_or_else(|| damaged("`Z scale` is no number"))?;
        let Some(name) = &hard.soft_scale else { return Ok(by_unit(hard.number, &hard.unit)) };
        let Some(soft) = header.lookup(&format!("@{name}")).and_then(ParameterValue::parse) else {
            // A reference that leads nowhere: the numbers are volts at best.
            return Ok(SampleScale { factor: hard.number / full, unit: hard.unit, is_length: false });
        };
        let (unit, per) = soft.unit.split_once('/').unwrap_or((&soft.unit, ""));
        let value = hard.number * soft.number;
        // nm/V times mV are a thousandth of nm.
        return Ok(match ratio(&hard.unit, per) {
            Some(ratio) => by_unit(value * ratio, unit),
            None => SampleScale {
                factor: value / full,
                unit: format!("{} {}", soft.unit, hard.unit),
                is_length: false,
            },
        });
    }
    // Before version 4: a full scale with its unit.
    if let Some(value) = image.text("z scale").and_then(ParameterValue::parse_plain) {
        return Ok(by_unit(value.number, &value.unit));
    }
    /// Unit of `Z magnify image` over the whole range of codes, for files without a version \[m\].
    const MAGNIFIED: f64 = 1e-7;
    let magnified = image.text("z magnify image").and_then(ParameterValue::parse_plain);
    let value = magnified.ok_or_else(|| damaged("`Z scale` is missing"))?;
    Ok(by_unit(value.number * MAGNIFIED, "m"))
}

/// Returns the ratio of the unit `hard` to the unit `per`; units that are missing fit anything.
fn ratio(hard: &str, per: &str) -> Option<f64> {
    if hard == per || hard.is_empty() || per.is_empty() {
        return Some(1.0);
    }
    ["V", "A", "Arb", "Hz", "m", "\u{b0}", "\u{ba}"]
        .iter()
        .find_map(|base| Some(units::prefixed(hard, base)? / units::prefixed(per, base)?))
}

/// Returns the distances of samples and of lines. `Scan size` has one length or two. Where both axes have the same and the aspect ratio is
/// neither 1:1 nor 1, it is the length of a line, and pixels are square.
fn spacings(header: &NanoscopeHeader, image: &Section, [columns, lines]: [u64; 2]) -> [Option<f64>; 2] {
    let text = image.text("scan size").or_else(|| header.lookup("scan size"));
    let Some([x, y]) = text.and_then(lengths) else { return [None, None] };
    let aspect = image.text("aspect ratio").or_else(|| header.lookup("aspect ratio"));
    let square_area = aspect.is_none_or(|text| match text.split_once(':') {
        Some((a, b)) => a.trim() == b.trim(),
        None => text.trim().parse::<f64>().is_ok_and(|ratio| ratio == 1.0),
    });
    let y = if x == y && !square_area { x * lines as f64 / columns as f64 } else { y };
    let [columns, lines] = [columns, lines].map(|n| usize::try_from(n).unwrap_or(usize::MAX));
    [spacing(x, columns), spacing(y, lines)]
}

/// Parses one length for both axes or two, and their unit \[m\].
fn lengths(text: &str) -> Option<[f64; 2]> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let number = |word: &str| word.parse::<f64>().ok();
    match words[..] {
        [x, y, unit] => Some([number(x)? * units::length(unit)?, number(y)? * units::length(unit)?]),
        [both, unit] => Some([number(both)? * units::length(unit)?; 2]),
        _ => None,
    }
}

#[cfg(test)]
#[path = "nanoscope_tests.rs"]
mod tests;
