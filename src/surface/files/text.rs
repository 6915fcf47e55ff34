//! Matrices of heights as text (.txt, .csv): a line for each row, from the top.
//!
//! The scales that programs write in front of a matrix are read, too. Without them a matrix is in metres and has no lateral scale.
//! Gwyddion's export begins with four lines of comment: the channel, the width, the height and the unit of the values, with words
//! in the language of the program.

use super::bytes::damaged;
use super::format::{Format, no_signature};
use super::scan::{Channel, Quantity, Scan, size, spacing};
use super::table::{self, TextTable};
use super::text_head::TextHead;
use super::topography::Topography;
use super::{profile, units, xyz};
use crate::error::{Error, Result};
use crate::notes::{self, Notes};
use std::io::{self, Write};

/// First bytes of Wyko's text format, which holds more than a matrix.
const WYKO_MAGIC: &[u8] = b"Wyko ASCII";

/// The format.
pub const FORMAT: Format = Format {
    name: "text",
    title: "matrix",
    extensions: &["txt", "csv", "asc"],
    signature: no_signature,
    is_by_name: false,
    read,
    facts: [
        "the header of Gwyddion, SPIP, Nova, Keyence or ESRI, or to be given",
        "the header's unit, or metres",
        "`nan`, `BAD`, an empty field, the header's number or mask",
        "written with Gwyddion's header and every digit; decimal commas, quotes, UTF-16",
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
    let table = table::parse(&table::decoded(bytes))?;
    let head = TextHead::read(&table.head);
    if head.counts.is_none()
        && let Some(scan) = points(&table)
    {
        return Ok(scan);
    }
    // Lines with the sizes of an image stand in front of a matrix.
    let has_sizes = head.counts.is_some() || head.sides.iter().chain(&head.spacing).any(Option::is_some);
    if !has_sizes && let Some(scan) = profile::read(&table)? {
        return Ok(scan);
    }
    let is_narrow = table.columns == 2 && !has_sizes && table.numbers.len() > 4;
    let TextTable { mut columns, mut numbers, head: lines, titled } = table;
    if titled {
        return Err(Error::input(
            "is a table with named columns and neither a matrix nor a profile, whose places grow from row to row",
            "write a line for each row of heights, or a column of places and one of heights",
        ));
    }
    let matrices = if head.has_mask { 2 } else { 1 };
    if let Some([counted, rows]) = head.counts {
        // Lines may be broken anywhere.
        if counted.saturating_mul(rows).saturating_mul(matrices) != numbers.len() as u64 {
            return Err(damaged(format!("it holds {} numbers instead of {counted} x {rows}", numbers.len())));
        }
        columns = counted as usize;
    }
    let size = size(columns as u64, numbers.len() as u64 / columns.max(1) as u64 / matrices)?;
    let mask = numbers.split_off(size[0] * size[1]);
    let comments: Vec<&str> = lines.iter().filter_map(|line| line.strip_prefix('#')).collect();
    let prepared = notes::preparation(&comments.join("\n"));
    let spacing = [0, 1].map(|i| head.spacing[i].or_else(|| spacing(head.sides[i]?, size[i])));
    let metres = units::length(&head.unit);
    let quantity = if metres.is_some() { Quantity::Height } else { Quantity::Other };
    numbers.iter_mut().filter(|x| Some(**x) == head.missing).for_each(|x| *x = f64::NAN);
    numbers.iter_mut().zip(mask).filter(|(_, m)| *m != 0.0).for_each(|(x, _)| *x = f64::NAN);
    let factor = metres.unwrap_or(1.0) * head.factor;
    if factor != 1.0 {
        numbers.iter_mut().for_each(|x| *x *= factor);
    }
    let decode = Box::new(move || Ok(numbers));
    let (name, unit) = (head.name, head.unit);
    let mut scan =
        Scan::single(head.format, Channel { name, unit, size, spacing, quantity, prepared, decode });
    if is_narrow {
        scan.notes.push(
            "the two columns are heights of a matrix, because the first does not grow as the places of a profile do: is that meant?"
                .to_owned(),
        );
    }
    Ok(scan)
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
