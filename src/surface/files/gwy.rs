//! Gwyddion's native files (.gwy): a tree of named and typed components, some of which are data fields.
//!
//! Format: <http://gwyddion.net/documentation/user-guide-en/gwyfile-format.html>. All numbers are little-endian. A data field stands at
//! `/N/data` with its title at `/N/data/title`; rows run from the top; units are base SI. A mask at `/N/mask` marks samples for Gwyddion's
//! tools and does not make them invalid.

use super::bytes::{Cursor, Number, Order, damaged, decode_text};
use super::format::Format;
use super::scan::{Block, Channel, Scan, size, spacing};
use super::{Topography, units};
use crate::error::{Error, Result};
use crate::notes::{self, Notes, PreparationRecord};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// First bytes of a file of Gwyddion 2.
pub const MAGIC: &[u8] = b"GWYP";
/// First bytes of a file of Gwyddion 1.
pub const OLD_MAGIC: &[u8] = b"GWYO";

/// The format.
pub const FORMAT: Format = Format {
    name: "gwy",
    title: "Gwyddion 2",
    extensions: &["gwy"],
    signature: |b| b.starts_with(MAGIC) || b.starts_with(OLD_MAGIC),
    is_by_name: false,
    read,
    facts: [
        "yes",
        "yes",
        "",
        "written, too; 64-bit floats; several channels; masks mark samples for Gwyddion's tools and take nothing away; Gwyddion 1 is refused",
    ],
};

/// Reads the file in `bytes`.
///
/// # Errors
/// A file of Gwyddion 1, one without data fields, one whose sizes contradict each other.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    if bytes.starts_with(OLD_MAGIC) {
        return Err(Error::input("is of Gwyddion 1 (GWYO)", "open it with Gwyddion 2 and save it again"));
    }
    let mut cursor = Cursor::new(bytes, Order::Little).at(MAGIC.len());
    let container = object(&mut cursor)?;
    let mut fields = BTreeMap::new();
    let mut titles = BTreeMap::new();
    let mut records = BTreeMap::new();
    components(container.body, |key, value| {
        let mut parts = key.split('/');
        let (root, number) = (parts.next(), parts.next().and_then(|n| n.parse::<u32>().ok()));
        match (root, number, parts.next(), parts.next(), value) {
            (Some(""), Some(n), Some("data"), None, GwyValue::Object(object))
                if object.name == "GwyDataField" =>
            {
                fields.insert(n, object.body);
            }
            (Some(""), Some(n), Some("data"), Some("title"), GwyValue::Text(title)) => {
                titles.insert(n, decode_text(title));
            }
            (Some(""), Some(n), Some("meta"), None, GwyValue::Object(meta)) => {
                records.insert(n, record(&meta));
            }
            _ => {}
        }
    })?;
    if fields.is_empty() {
        return Err(Error::input("holds no data field", "choose a file with an image in it"));
    }
    let channels = fields.into_iter().map(|(n, body)| {
        let name = titles.remove(&n).unwrap_or_else(|| format!("/{n}/data"));
        let prepared = records.remove(&n).unwrap_or_default();
        (name.clone(), field(body, name, prepared))
    });
    Scan::of_readable("Gwyddion", channels.collect())
}

/// Reads the data field in `body`, whose heights were `prepared`.
fn field(body: &[u8], name: String, prepared: PreparationRecord) -> Result<Channel<'_>> {
    let mut counts = [None; 2];
    let mut sides = [None; 2];
    let mut unit_names = [String::new(), String::new()];
    let mut data = None;
    components(body, |key, value| match (key, value) {
        ("xres", GwyValue::Int(n)) => counts[0] = u64::try_from(n).ok(),
        ("yres", GwyValue::Int(n)) => counts[1] = u64::try_from(n).ok(),
        ("xreal", GwyValue::Double(x)) => sides[0] = Some(x),
        ("yreal", GwyValue::Double(x)) => sides[1] = Some(x),
        ("si_unit_xy", GwyValue::Object(unit)) => unit_names[0] = unit_name(&unit),
        ("si_unit_z", GwyValue::Object(unit)) => unit_names[1] = unit_name(&unit),
        ("data", GwyValue::Doubles(bytes)) => data = Some(bytes),
        _ => {}
    })?;
    let (Some(columns), Some(rows), Some(data)) = (counts[0], counts[1], data) else {
        return Err(damaged(format!("the data field `{name}` has no size or no data")));
    };
    let size = size(columns, rows)?;
    let [lateral, unit] = unit_names;
    let metres = units::length(&lateral);
    let side = |i: usize| spacing(sides[i]? * metres?, size[i]);
    let block = Block::plain(data, Number::F64, Order::Little);
    Ok(Channel { prepared, ..Channel::stored(name, &unit, size, [side(0), side(1)], block)? })
}

/// Returns the text of a `GwySIUnit`.
fn unit_name(unit: &GwyObject) -> String {
    text_in(unit, "unitstr")
}

/// Returns the preparation that the metadata of a channel note.
fn record(meta: &GwyObject) -> PreparationRecord {
    PreparationRecord::parse(&text_in(meta, notes::PREPARED))
}

/// Returns the text of the component `name`; empty if there is none, or if the object is damaged.
fn text_in(object: &GwyObject, name: &str) -> String {
    let mut found = String::new();
    // A damaged object has no text; its heights are read with errors.
    let _ = components(object.body, |key, value| match value {
        GwyValue::Text(text) if key == name => found = decode_text(text),
        _ => {}
    });
    found
}

/// An object: its type and the bytes of its components.
struct GwyObject<'a> {
    name: String,
    body: &'a [u8],
}

fn object<'a>(cursor: &mut Cursor<'a>) -> Result<GwyObject<'a>> {
    let name = decode_text(string(cursor)?);
    let length = cursor.u32()? as usize;
    Ok(GwyObject { name, body: cursor.take(length)? })
}

/// Value of a component, of the types that are read here.
enum GwyValue<'a> {
    Int(i64),
    Double(f64),
    Text(&'a [u8]),
    Doubles(&'a [u8]),
    Object(GwyObject<'a>),
    Unused,
}

/// Calls `each` with the name and value of every component in `body`.
fn components<'a>(body: &'a [u8], mut each: impl FnMut(&str, GwyValue<'a>)) -> Result<()> {
    let mut cursor = Cursor::new(body, Order::Little);
    while cursor.left() > 0 {
        let key = decode_text(string(&mut cursor)?);
        let kind = cursor.u8()?;
        let value = value(&mut cursor, kind)?;
        each(&key, value);
    }
    Ok(())
}

fn value<'a>(cursor: &mut Cursor<'a>, kind: u8) -> Result<GwyValue<'a>> {
    let many = |cursor: &mut Cursor<'a>, width: usize| {
        let count = cursor.u32()? as usize;
        cursor.take(count.saturating_mul(width))
    };
    Ok(match kind {
        b'b' | b'c' => cursor.u8().map(|_| GwyValue::Unused)?,
        b'i' => GwyValue::Int(i64::from(cursor.i32()?)),
        b'q' => cursor.take(8).map(|_| GwyValue::Unused)?,
        b'd' => GwyValue::Double(cursor.f64()?),
        b's' => GwyValue::Text(string(cursor)?),
        b'o' => GwyValue::Object(object(cursor)?),
        b'C' => many(cursor, 1).map(|_| GwyValue::Unused)?,
        b'I' => many(cursor, 4).map(|_| GwyValue::Unused)?,
        b'Q' => many(cursor, 8).map(|_| GwyValue::Unused)?,
        b'D' => GwyValue::Doubles(many(cursor, 8)?),
        b'S' => {
            for _ in 0..cursor.u32()? {
                string(cursor)?;
            }
            GwyValue::Unused
        }
        b'O' => {
            for _ in 0..cursor.u32()? {
                object(cursor)?;
            }
            GwyValue::Unused
        }
        _ => return Err(damaged(format!("a component has the unknown type {kind:#x}"))),
    })
}

/// Reads the bytes up to the next NUL, which is skipped.
fn string<'a>(cursor: &mut Cursor<'a>) -> Result<&'a [u8]> {
    let rest = cursor.clone().take(cursor.left())?;
    let end = rest.iter().position(|b| *b == 0).ok_or_else(super::bytes::cut_short)?;
    let text = cursor.take(end)?;
    cursor.take(1)?;
    Ok(text)
}

/// Writes `scan` as the only data field, with heights in metres, and `notes` as its metadata.
///
/// # Errors
/// The file cannot be written to; more samples than the format counts.
pub fn write(scan: &Topography, notes: &Notes, file: &mut impl Write) -> io::Result<()> {
    const KEY: &[u8] = b"/0/data\0o";
    let [columns, rows] = scan.size();
    let [dx, dy] = scan.spacing();
    let count = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let metre = object_of("GwySIUnit", count(METRE.len())?, METRE);
    let field = [
        component("xres", b'i', &count(columns)?.to_le_bytes()),
        component("yres", b'i', &count(rows)?.to_le_bytes()),
        component("xreal", b'd', &(dx * columns as f64).to_le_bytes()),
        component("yreal", b'd', &(dy * rows as f64).to_le_bytes()),
        component("si_unit_xy", b'o', &metre),
        component("si_unit_z", b'o', &metre),
        // The numbers follow.
        component("data", b'D', &count(columns * rows)?.to_le_bytes()),
    ]
    .concat();
    let numbers = columns * rows * size_of::<f64>();
    let field = object_of("GwyDataField", count(field.len() + numbers)?, &field);
    let title = text_component("/0/data/title", "Height");
    let meta: Vec<u8> =
        notes.entries().iter().flat_map(|(name, value)| text_component(name, value)).collect();
    let meta = component("/0/meta", b'o', &object_of("GwyContainer", count(meta.len())?, &meta));
    let container = [&title, &meta, KEY, &field].concat();
    file.write_all(MAGIC)?;
    file.write_all(&object_of("GwyContainer", count(container.len() + numbers)?, &container))?;
    scan.metres().try_for_each(|h| file.write_all(&h.to_le_bytes()))
}

/// Components of a `GwySIUnit` for the metre.
const METRE: &[u8] = b"unitstr\0sm\0";

/// Encodes a component, or its beginning.
fn component(key: &str, kind: u8, value: &[u8]) -> Vec<u8> {
    [key.as_bytes(), &[0, kind], value].concat()
}

/// Encodes a component of text.
fn text_component(key: &str, text: &str) -> Vec<u8> {
    component(key, b's', &[text.as_bytes(), &[0]].concat())
}

/// Encodes an object whose components take `length` bytes and begin with `body`.
fn object_of(name: &str, length: u32, body: &[u8]) -> Vec<u8> {
    [name.as_bytes(), &[0], &length.to_le_bytes()[..], body].concat()
}

#[cfg(test)]
#[path = "gwy_tests.rs"]
mod tests;
