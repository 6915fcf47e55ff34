//! Arrays of NumPy (.npy): two dimensions, rows from the top. Floating-point numbers are heights in metres, integers are codes.
//!
//! Format: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

use super::bytes::{Cursor, Number, Order, damaged, decode_text};
use super::format::Format;
use super::scan::{Block, Channel, Quantity, Scan, size};
use super::topography::Topography;
use crate::error::{Error, Result};
use crate::notes::PreparationRecord;
use crate::surface::transpose::transposed;
use std::io::{self, Write};

/// First bytes of a file.
pub const MAGIC: &[u8] = b"\x93NUMPY";

/// The format.
pub const FORMAT: Format = Format {
    name: "npy",
    title: "NumPy array",
    extensions: &["npy"],
    signature: |b| b.starts_with(MAGIC),
    is_by_name: false,
    read,
    facts: [
        "to be given",
        "floats: metres; integers: to be given",
        "NaN",
        "written, too; 64-bit floats in metres",
    ],
};

/// Reads the file in `bytes`.
///
/// # Errors
/// An array of other than two dimensions or of other than real numbers; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let mut cursor = Cursor::new(bytes, Order::Little).at(MAGIC.len());
    let version = cursor.u8()?;
    cursor.u8()?;
    let length = if version == 1 { usize::from(cursor.u16()?) } else { cursor.u32()? as usize };
    let header = decode_text(cursor.take(length)?);
    let data = cursor.take(cursor.left())?;
    let (number, order) = sample_type(&quoted(entry(&header, "descr")?)?)?;
    let shape = shape(entry(&header, "shape")?)?;
    let columns_first = entry(&header, "fortran_order")?.starts_with("True");
    let size = size(shape[1], shape[0])?;
    let mut block = Block::plain(data, number, order);
    if !number.is_float() {
        block.scale[0] = 1.0 / number.largest();
    }
    let decode = if columns_first {
        let columns = block.decode([size[1], size[0]])?;
        Box::new(move || Ok(transposed(size[1], &columns()?)))
    } else {
        block.decode(size)?
    };
    let code = Quantity::Code { largest: number.largest() };
    Ok(Scan::single(
        "NumPy array",
        Channel {
            name: "array".to_owned(),
            unit: if number.is_float() { "m" } else { "" }.to_owned(),
            size,
            spacing: [None, None],
            quantity: if number.is_float() { Quantity::Height } else { code },
            prepared: PreparationRecord::default(),
            decode,
        },
    ))
}

/// Returns the text after `'key':` in the dictionary of the header.
fn entry<'a>(header: &'a str, key: &str) -> Result<&'a str> {
    let missing = || damaged(format!("its header has no `{key}`"));
    let place =
        [format!("'{key}'"), format!("\"{key}\"")].iter().find_map(|k| Some(header.find(k)? + k.len()));
    let rest = header[place.ok_or_else(missing)?..].trim_start().strip_prefix(':');
    rest.map(str::trim_start).ok_or_else(missing)
}

fn quoted(text: &str) -> Result<String> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'));
    let inner = quote.and_then(|quote| text[1..].split_once(quote)).map(|(inner, _)| inner.to_owned());
    inner.ok_or_else(|| not_real("structures"))
}

fn sample_type(descr: &str) -> Result<(Number, Order)> {
    let (order, kind) = match descr.split_at_checked(1) {
        Some(("<" | "|" | "=", kind)) => (Order::Little, kind),
        Some((">", kind)) => (Order::Big, kind),
        _ => (Order::Little, descr),
    };
    let number = match kind {
        "f2" => Number::F16,
        "f4" => Number::F32,
        "f8" => Number::F64,
        "i1" => Number::I8,
        "u1" => Number::U8,
        "i2" => Number::I16,
        "u2" => Number::U16,
        "i4" => Number::I32,
        "u4" => Number::U32,
        "i8" => Number::I64,
        "u8" => Number::U64,
        _ => return Err(not_real(descr)),
    };
    Ok((number, order))
}

fn not_real(what: &str) -> Error {
    Error::input(format!("holds {what} and no plain numbers"), "save heights in metres as float64")
}

/// Parses the rows and columns.
fn shape(text: &str) -> Result<[u64; 2]> {
    let inner = text.strip_prefix('(').and_then(|text| text.split_once(')')).map(|(inner, _)| inner);
    let inner = inner.ok_or_else(|| damaged("its shape is none"))?;
    let sides = inner.split(',').map(str::trim).filter(|side| !side.is_empty()).map(str::parse::<u64>);
    let sides: Vec<u64> = sides.collect::<std::result::Result<_, _>>().map_err(damaged)?;
    match sides[..] {
        [rows, columns] => Ok([rows, columns]),
        _ => Err(Error::input(
            format!("holds an array of shape ({inner}), no image"),
            "save an array of rows and columns",
        )),
    }
}

/// Writes `scan` as float64 in metres.
///
/// # Errors
/// The file cannot be written.
pub fn write(scan: &Topography, file: &mut impl Write) -> io::Result<()> {
    let [columns, rows] = scan.size();
    write_header("<f8", &[rows, columns], file)?;
    scan.metres().try_for_each(|h| file.write_all(&h.to_le_bytes()))
}

/// Writes what stands before the numbers of an array of the type `descr` and of this `shape`, the last index running fastest.
///
/// # Errors
/// The file cannot be written.
pub fn write_header(descr: &str, shape: &[usize], file: &mut impl Write) -> io::Result<()> {
    /// Alignment of the data in the file \[bytes\].
    const ALIGNMENT: usize = 64;
    /// Magic, version and length of the header.
    const START: usize = 10;
    let shape: Vec<String> = shape.iter().map(usize::to_string).collect();
    let shape = shape.join(", ");
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
    let length = (START + header.len() + 1).next_multiple_of(ALIGNMENT) - START;
    header += &" ".repeat(length - 1 - header.len());
    header.push('\n');
    file.write_all(MAGIC)?;
    file.write_all(&[1, 0])?;
    file.write_all(&(length as u16).to_le_bytes())?;
    file.write_all(header.as_bytes())
}

#[cfg(test)]
#[path = "npy_tests.rs"]
mod tests;
