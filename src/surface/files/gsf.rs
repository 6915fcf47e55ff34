//! Gwyddion simple field (.gsf): a text header, then 32-bit floats.
//!
//! Format: <http://gwyddion.net/documentation/user-guide-en/gsf.html>. `Name = value` lines, one to four NUL bytes up to
//! a multiple of four, then little-endian floats row by row from the top, in base SI units. NaN was not measured.

use super::bytes::{Number, Order, cut_short, damaged, decode_text};
use super::format::Format;
use super::scan::{Block, Channel, Scan, size, spacing};
use super::topography::Topography;
use super::units;
use crate::error::Result;
use crate::notes::{self, Notes, PreparationRecord};
use std::io::{self, Write};

/// First bytes of a file.
pub const MAGIC: &[u8] = b"Gwyddion Simple Field 1.0\n";

/// Alignment of the data in the file \[bytes\].
const ALIGNMENT: usize = 4;

/// The format.
pub const FORMAT: Format = Format {
    name: "gsf",
    title: "Gwyddion simple field",
    extensions: &["gsf"],
    signature: |b| b.starts_with(MAGIC),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "NaN", "written, too; 32-bit floats"],
};

/// Reads the file in `bytes`.
///
/// # Errors
/// A header without sizes; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let end = bytes.iter().position(|b| *b == 0).ok_or_else(cut_short)?;
    let header = decode_text(bytes.get(MAGIC.len()..end).ok_or_else(cut_short)?);
    let value = |name: &str| {
        let pair =
            |line: &'_ str| line.split_once('=').map(|(k, v)| (k.trim().to_owned(), v.trim().to_owned()));
        header.lines().filter_map(pair).find(|(key, _)| key == name).map(|(_, value)| value)
    };
    let count = |name: &str| {
        let value = value(name).ok_or_else(|| damaged(format!("{name} is missing")))?;
        value.parse::<u64>().map_err(|_| damaged(format!("{name} = {value} is no count")))
    };
    let size = size(count("XRes")?, count("YRes")?)?;
    let lateral = value("XYUnits").unwrap_or_default();
    let metres = units::length(&lateral);
    let side = |name: &str, count: usize| {
        let length = value(name)?.parse::<f64>().ok()?;
        spacing(length * metres?, count)
    };
    // One to four NUL bytes.
    let start = (end / ALIGNMENT + 1) * ALIGNMENT;
    let data = bytes.get(start..).ok_or_else(cut_short)?;
    let mut channel = Channel::stored(
        value("Title").unwrap_or_else(|| "Height".to_owned()),
        &value("ZUnits").unwrap_or_default(),
        size,
        [side("XReal", size[0]), side("YReal", size[1])],
        Block::plain(data, Number::F32, Order::Little),
    )?;
    channel.prepared = value(notes::PREPARED)
        .map_or_else(PreparationRecord::default, |text| PreparationRecord::parse(&text));
    Ok(Scan::single(FORMAT.title, channel))
}

/// Writes `scan` with heights in metres, of which 32-bit floats hold seven digits, and with `notes`.
///
/// # Errors
/// The file cannot be written to.
pub fn write(scan: &Topography, notes: &Notes, file: &mut impl Write) -> io::Result<()> {
    let [columns, rows] = scan.size();
    let [dx, dy] = scan.spacing();
    let (width, height) = (dx * columns as f64, dy * rows as f64);
    let mut header = MAGIC.to_vec();
    write!(header, "XRes = {columns}\nYRes = {rows}\nXReal = {width:e}\nYReal = {height:e}\n")?;
    header.extend(b"XYUnits = m\nZUnits = m\nTitle = Height\n");
    notes.entries().iter().try_for_each(|(name, value)| writeln!(header, "{name} = {value}"))?;
    let data = (header.len() / ALIGNMENT + 1) * ALIGNMENT;
    header.resize(data, 0);
    file.write_all(&header)?;
    scan.metres().try_for_each(|h| file.write_all(&(h as f32).to_le_bytes()))
}

#[cfg(test)]
#[path = "gsf_tests.rs"]
mod tests;
