//! Matrices of heights as text (.txt, .csv): a line for each row, from the top.
//!
//! Gwyddion's export begins with four lines of comment: the channel, the width, the height and the unit of the values, with words
//! in the language of the program. Without them a matrix is in metres and has no lateral scale.

use super::bytes::decode_text;
use super::format::{Format, no_signature};
use super::scan::{Channel, Quantity, Scan, size, spacing};
use super::table::{self, TextTable};
use super::topography::Topography;
use super::{units, xyz};
use crate::error::{Error, Result};
use crate::notes::{self, Notes};
use std::io::{self, Write};

/// Fields of the head of Gwyddion's export.
struct GwyddionHead {
    name: String,
    /// Width and height of the whole image \[m\].
    sides: [f64; 2],
    unit: String,
}

/// First bytes of Wyko's text format, which holds more than a matrix.
const WYKO_MAGIC: &[u8] = b"Wyko ASCII";

/// The format.
pub const FORMAT: Format = Format {
    name: "text",
    title: "matrix",
    extensions: &["txt", "csv"],
    signature: no_signature,
    is_by_name: false,
    read,
    facts: [
        "Gwyddion's header, or to be given",
        "the header's unit, or metres",
        "`nan`, `BAD`, an empty field",
        "written with Gwyddion's header and every digit",
    ],
};

/// Reads the file in `bytes`.
///
/// # Errors
/// Those of [`table::parse`]; too many numbers on a side.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    if bytes.starts_with(WYKO_MAGIC) {
        return Err(Error::input(
            "is a Wyko ASCII file, whose blocks are not read",
            "export it as .sur, .x3p or a plain matrix of heights",
        ));
    }
    let table = table::parse(&decode_text(bytes))?;
    if let Some(scan) = points(&table) {
        return Ok(scan);
    }
    let TextTable { columns, mut numbers, head, titled } = table;
    if titled {
        return Err(Error::input(
            "is a table with named columns and no matrix",
            "write a line for each row of heights",
        ));
    }
    let rows = numbers.len() / columns;
    let size = size(columns as u64, rows as u64)?;
    let comments: Vec<&str> = head.iter().filter_map(|line| line.strip_prefix('#')).collect();
    let prepared = notes::preparation(&comments.join("\n"));
    let head = gwyddion(&head);
    let format = if head.is_some() { "Gwyddion text" } else { "text" };
    let spacing = head.as_ref().map_or([None, None], |h| [0, 1].map(|i| spacing(h.sides[i], size[i])));
    let (name, unit) = head.map_or_else(|| ("matrix".to_owned(), "m".to_owned()), |h| (h.name, h.unit));
    let metres = units::length(&unit);
    let quantity = if metres.is_some() { Quantity::Height } else { Quantity::Other };
    if let Some(metres) = metres.filter(|m| *m != 1.0) {
        numbers.iter_mut().for_each(|x| *x *= metres);
    }
    let decode = Box::new(move || Ok(numbers));
    Ok(Scan::single(format, Channel { name, unit, size, spacing, quantity, prepared, decode }))
}

/// Returns the grid of points that a table of three columns may be, one at every node. No matrix of heights is such a grid by chance.
fn points(table: &TextTable) -> Option<Scan<'static>> {
    let mut scan = xyz::grid(table).ok()?; // no grid: a matrix of three columns
    let [columns, rows] = scan.channels.first()?.size;
    if columns < 2 || rows < 2 || columns * rows * 3 != table.numbers.len() {
        return None;
    }
    scan.notes.push("the three columns are x, y and height of a grid of points, in metres".to_owned());
    Some(scan)
}

/// Parses the four lines of Gwyddion's export, which are recognised by the two lengths.
fn gwyddion(head: &[String]) -> Option<GwyddionHead> {
    let entries: Vec<&str> =
        head.iter().filter_map(|line| Some(line.strip_prefix('#')?.split_once(':')?.1.trim())).collect();
    let found = entries.windows(4).find_map(|lines| match lines {
        [name, width, height, unit] => {
            Some(((*name).to_owned(), units::measured_length(width)?, units::measured_length(height)?, unit))
        }
        _ => None,
    });
    let (name, width, height, unit) = found?;
    Some(GwyddionHead { name, sides: [width, height], unit: (*unit).to_owned() })
}

/// Writes `scan` as Gwyddion exports it, with every digit that heights in metres have, and `notes` as more comments.
///
/// # Errors
/// The file cannot be written to.
pub fn write(scan: &Topography, notes: &Notes, file: &mut impl Write) -> io::Result<()> {
    let [columns, rows] = scan.size();
    let [width, height] = [(0, columns), (1, rows)].map(|(i, n)| scan.spacing()[i] * n as f64 * 1e6);
    writeln!(
        file,
        "# Channel: Height\n# Width: {width} \u{b5}m\n# Height: {height} \u{b5}m\n# Value units: m"
    )?;
    notes.entries().iter().try_for_each(|(name, value)| writeln!(file, "# {name}: {value}"))?;
    for (i, h) in scan.metres().enumerate() {
        let end = if (i + 1) % columns == 0 { '\n' } else { '\t' };
        if h.is_nan() {
            write!(file, "nan{end}")?;
        } else {
            write!(file, "{h:e}{end}")?;
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "text_tests.rs"]
mod tests;
