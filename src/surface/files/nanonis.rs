//! Scans of Nanonis (.sxm): a header of tags, a mark, then 32-bit floats, channel by channel.
//!
//! The first line is the lowest if the scan went up; lines of a backward scan begin at their right end. Samples are in the unit of the
//! channel, NaN where a scan was stopped. Facts after Gwyddion's description and nanonispy2.

use super::bytes::{Number, Order, cut_short, damaged, decode_text};
use super::format::Format;
use super::header::{TextHeader, find};
use super::scan::{Block, Channel, Rows, Scan, size, spacing};
use crate::error::{Error, Result};

/// The format.
pub const FORMAT: Format = Format {
    name: "nanonis",
    title: "Nanonis",
    extensions: &["sxm"],
    signature: |b| b.starts_with(b":NANONIS_VERSION:"),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "NaN", "all channels, forward and backward"],
};

/// Mark between header and samples.
const MARK: &[u8] = b"\x1a\x04";

/// Reads the file in `bytes`.
///
/// # Errors
/// A header without sizes or channels; other numbers than floats; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let end = find(bytes, MARK).ok_or_else(cut_short)?;
    let text = decode_text(&bytes[..end]);
    let header = tags(&text);
    let words = |tag: &str| header.text("", tag).unwrap_or_default().split_whitespace(); // no words, if there is no such tag
    let order = match words("SCANIT_TYPE").collect::<Vec<_>>()[..] {
        ["FLOAT", "MSBFIRST"] => Order::Big,
        ["FLOAT", "LSBFIRST"] => Order::Little,
        ref other => {
            return Err(Error::input(
                format!("holds samples of the type `{}`, not FLOAT", other.join(" ")),
                "export it from Nanonis's viewer",
            ));
        }
    };
    let mut counts = words("SCAN_PIXELS").map(|word| word.parse::<u64>().unwrap_or(0)); // 0 is no size
    let size = size(counts.next().unwrap_or(0), counts.next().unwrap_or(0))?;
    let mut sides = words("SCAN_RANGE").map(|word| word.parse::<f64>().ok());
    let sides = [sides.next().flatten(), sides.next().flatten()];
    let spacing = [0, 1].map(|i| spacing(sides[i]?, size[i]));
    let rows = if header.text("", "SCAN_DIR") == Some("up") { Rows::BottomFirst } else { Rows::TopFirst };
    let mut rest = &bytes[end + MARK.len()..];
    let mut found = Vec::new();
    for (name, unit, is_backward) in channels(&text)? {
        let block = Block { rows, mirrored: is_backward, ..Block::plain(rest, Number::F32, order) };
        rest = rest.get(size[0] * size[1] * Number::F32.bytes()..).unwrap_or_default(); // an error of `stored`
        let name = format!("{name} ({})", if is_backward { "Backward" } else { "Forward" });
        found.push((name.clone(), Channel::stored(name, unit, size, spacing, block)));
    }
    Scan::of_readable(FORMAT.title, found)
}

/// Returns the first line behind every tag.
fn tags(text: &str) -> TextHeader {
    let mut header = TextHeader::default();
    for (line, next) in text.lines().zip(text.lines().skip(1)) {
        if let Some(tag) = line.trim().strip_prefix(':').and_then(|line| line.strip_suffix(':')) {
            header.insert("", tag, next);
        }
    }
    header
}

/// Returns name, unit and direction of every image, in their order in the file; true for backward.
fn channels(text: &str) -> Result<Vec<(&str, &str, bool)>> {
    let missing = || damaged("it has no table of channels");
    let mut lines = text.lines().map(str::trim).skip_while(|line| *line != ":DATA_INFO:").skip(1);
    let titles: Vec<&str> = lines.next().ok_or_else(missing)?.split_whitespace().collect();
    let column = |title: &str| titles.iter().position(|t| *t == title).ok_or_else(missing);
    let [name, unit, direction] = [column("Name")?, column("Unit")?, column("Direction")?];
    let mut found = Vec::new();
    for line in lines.take_while(|line| !line.is_empty() && !line.starts_with(':')) {
        let cells: Vec<&str> = line.split('\t').map(str::trim).collect();
        let cell = |i: usize| cells.get(i).copied().ok_or_else(missing);
        let image = |is_backward| Ok((cell(name)?, cell(unit)?, is_backward));
        match cell(direction)? {
            "both" => found.extend([image(false)?, image(true)?]),
            "forward" => found.push(image(false)?),
            "backward" => found.push(image(true)?),
            other => return Err(damaged(format!("a channel has the unknown direction `{other}`"))),
        }
    }
    Ok(found)
}

#[cfg(test)]
#[path = "nanonis_tests.rs"]
mod tests;
