//! BCR and BCRF files (.bcr, .bcrf): a text header of fixed length, then integers or floats from the top.
//!
//! The header is Latin-1 or UTF-16. A height is the stored number times `bit2nm` plus `zmin` in the unit of heights, nanometres by default.
//! Facts after Image Metrology's description of the format and Gwyddion's.

use super::bytes::{Number, Order, cut_short};
use super::format::Format;
use super::header::TextHeader;
use super::scan::{Block, Channel, Scan, size, spacing};
use super::{table, units};
use crate::error::Result;

/// The format.
pub const FORMAT: Format = Format {
    name: "bcr",
    title: "BCR-STM, BCRF",
    extensions: &["bcr", "bcrf"],
    signature: |b| width(b).is_some(),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "the reserved number", "16-bit integers and 32-bit floats, both byte orders"],
};

/// First characters of a file.
const MAGIC: &str = "fileformat = bcr";
/// Characters of a header that does not tell its length.
const HEADER: usize = 2048;
/// Integer of a sample that was not measured.
const INVALID: f64 = 32_767.0;
/// Least float of samples that were not measured; their number has seven digits of the largest one.
const INVALID_FLOAT: f64 = 1.7e38;

/// Returns the bytes of a character of the header; `None` for a file of another format.
fn width(bytes: &[u8]) -> Option<usize> {
    let first = &bytes[..bytes.len().min(2 * MAGIC.len() + 2)];
    let begins = table::decoded(first).trim_start_matches('\u{feff}').starts_with(MAGIC);
    begins.then(|| if table::wide_order(first).is_some() { 2 } else { 1 })
}

/// Reads the file in `bytes`.
///
/// # Errors
/// A header without sizes; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let width = width(bytes).unwrap_or(1);
    let parse = |characters: usize| {
        let bytes = &bytes[..characters.saturating_mul(width).min(bytes.len())];
        TextHeader::parse(table::decoded(bytes).trim_start_matches('\u{feff}'), '=')
    };
    let length = parse(HEADER).number("", "headersize").map_or(HEADER, |length| length as usize);
    let header = parse(length);
    let is_integer = header.text("", "fileformat").is_some_and(|format| format.starts_with("bcrstm"));
    let size = size(header.count("", "xpixels")?, header.count("", "ypixels")?)?;
    let metres = |key: &str| units::length(header.text("", key).unwrap_or("nm"));
    let axes = [("xlength", "xunit", 0), ("ylength", "yunit", 1)];
    let spacing = axes.map(|(side, unit, i)| spacing(header.number("", side)? * metres(unit)?, size[i]));
    let factor = header.number("", "bit2nm").filter(|factor| is_integer && *factor > 0.0).unwrap_or(1.0);
    let order = if header.number("", "intelmode") == Some(0.0) { Order::Big } else { Order::Little };
    let number = if is_integer { Number::I16 } else { Number::F32 };
    let data = bytes.get(length.saturating_mul(width)..).ok_or_else(cut_short)?;
    let has_gaps = header.number("", "voidpixels").is_some_and(|count| count != 0.0);
    let block = Block {
        scale: [factor, 0.0],
        missing_from: has_gaps.then_some(if is_integer { INVALID } else { INVALID_FLOAT }),
        ..Block::plain(data, number, order)
    };
    let unit = header.text("", "zunit").unwrap_or("nm");
    let mut channel = Channel::stored("Height", unit, size, spacing, block)?;
    // The lowest height, where the header tells it.
    if let Some(low) = header.number("", "zmin").filter(|low| *low > 0.0) {
        let low = low * units::length(unit).unwrap_or(1.0);
        channel = channel.changed(move |mut samples| {
            let least = samples.iter().copied().fold(f64::INFINITY, f64::min);
            samples.iter_mut().for_each(|x| *x += low - least);
            samples
        });
    }
    Ok(Scan::single(FORMAT.title, channel))
}

#[cfg(test)]
#[path = "bcr_tests.rs"]
mod tests;
