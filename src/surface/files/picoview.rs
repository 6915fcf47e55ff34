//! Images of PicoView, of Agilent's, Keysight's and Molecular Imaging's microscopes (.mi): lines of keys, then the channels' integers.
//!
//! Keys take 14 characters. `bufferLabel` begins the description of a channel, `data` ends the header. Integers span the channel's
//! `bufferRange` to either side of zero; the first line is the lowest. Facts after Gwyddion's description and SurfaceTopography.

use super::bytes::{Number, Order, cut_short, decode_text};
use super::format::Format;
use super::header::{TextHeader, find};
use super::scan::{Block, Channel, Rows, Scan, size, spacing};
use crate::error::{Error, Result};

/// The format.
pub const FORMAT: Format = Format {
    name: "picoview",
    title: "PicoView (Agilent, Keysight)",
    extensions: &["mi"],
    signature: |b| b.starts_with(b"fileType  "),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "", "16 and 32 bits, several channels; spectra and text are refused"],
};

/// Characters of a key.
const KEY: usize = 14;
/// Line with which the header ends.
const MARK: &[u8] = b"\ndata  ";

/// Reads the file in `bytes`.
///
/// # Errors
/// Spectra; samples as text; a header without sizes; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let end = find(bytes, MARK).ok_or_else(cut_short)?;
    let start = end + 1 + find(&bytes[end + 1..], b"\n").ok_or_else(cut_short)? + 1;
    let text = decode_text(&bytes[..start]);
    let mut header = TextHeader::default();
    let mut labels = Vec::new();
    for line in text.lines() {
        let Some((key, value)) = line.split_at_checked(KEY).filter(|_| !line.starts_with(' ')) else {
            continue;
        };
        if key.trim() == "bufferLabel" {
            labels.push(value.trim());
        }
        header.insert(&section(labels.len()), key, value);
    }
    if header.text("", "fileType") != Some("Image") {
        return Err(Error::input("holds spectra and no image", "choose an image file"));
    }
    let number = match header.text(&section(labels.len()), "data").unwrap_or("BINARY") {
        "BINARY" => Number::I16,
        "BINARY_32" => Number::I32,
        other => {
            return Err(Error::input(
                format!("holds its samples as `{other}`, not as BINARY or BINARY_32"),
                "save it again in binary form",
            ));
        }
    };
    let size = size(header.count("", "xPixels")?, header.count("", "yPixels")?)?;
    let spacing = [("xLength", 0), ("yLength", 1)].map(|(key, i)| spacing(header.number("", key)?, size[i]));
    let mut rest = &bytes[start..];
    let mut found = Vec::new();
    for (i, label) in labels.into_iter().enumerate() {
        let section = section(i + 1);
        let range = header.required(&section, "bufferRange");
        let unit = header.text(&section, "bufferUnit").unwrap_or_default(); // plain numbers
        let channel = range.and_then(|range| {
            let block = Block {
                // The lowest code is the range below zero.
                scale: [range / (number.largest() + 1.0), 0.0],
                rows: Rows::BottomFirst,
                ..Block::plain(rest, number, Order::Little)
            };
            Channel::stored(label, unit, size, spacing, block)
        });
        found.push((label.to_owned(), channel));
        rest = rest.get(size[0] * size[1] * number.bytes()..).unwrap_or_default(); // an error of `stored`
    }
    Scan::of_readable(FORMAT.title, found)
}

/// Returns the section of the values of channel `i`, from 1; that of the whole file for 0.
fn section(i: usize) -> String {
    if i == 0 { String::new() } else { i.to_string() }
}

#[cfg(test)]
#[path = "picoview_tests.rs"]
mod tests;
