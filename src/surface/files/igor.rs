//! Igor binary waves (.ibw) of Asylum Research's microscopes.
//!
//! Format: WaveMetrics, Technical Note 003 (version 5 of the file, which alone can hold images). x runs fastest, the first row is
//! the bottom, and the third dimension counts channels. One data unit serves all of them, so that a channel's label decides
//! what it is.

use super::bytes::{Cursor, Number, Order, damaged, text};
use super::format::Format;
use super::scan::{Block, Channel, Quantity, Rows, Scan, size, spacing};
use super::units;
use crate::error::{Error, Result};
use crate::notes::PreparationRecord;
use std::borrow::Cow;

/// Bytes of the file's and the wave's header, over which the check sum is taken.
const HEADERS: usize = 384;
/// Version of files that can hold images.
const VERSION: u16 = 5;
/// Bytes of a dimension label.
const LABEL: usize = 32;
/// Largest number of channels of a wave; microscopes have at most a few dozen.
const MOST_CHANNELS: u64 = 1024;

/// First letters of the names of Asylum's channels, and the unit of their samples, whatever the data unit says.
const ASYLUM: [(&str, &str); 10] = [
    ("Height", "m"),
    ("ZSensor", "m"),
    ("Deflection", "m"),
    ("Amplitude", "m"),
    ("Phase", "deg"),
    ("Current", "A"),
    ("Frequency", "Hz"),
    ("Capacitance", "F"),
    ("Potential", "V"),
    ("UserIn", "V"),
];

/// Returns the byte order of an Igor binary wave of a known version; `None` if `bytes` are no such wave.
pub fn recognise(bytes: &[u8]) -> Option<Order> {
    let &[a, b, ..] = bytes else { return None };
    let (order, version) = match (a, b) {
        (0, version) => (Order::Big, version),
        (version, 0) => (Order::Little, version),
        _ => return None,
    };
    // The 16-bit numbers of the two headers sum to zero.
    let headers = match version {
        1 => 118,
        2 => 126,
        3 => 130,
        5 => HEADERS,
        _ => return None,
    };
    let numbers = Number::I16.decode(bytes.get(..headers)?, order);
    let sum = numbers.iter().fold(0_i16, |sum, x| sum.wrapping_add(*x as i16));
    (sum == 0).then_some(order)
}

/// Contents of the headers that are read.
struct IgorWave {
    number: Number,
    dimensions: [u64; 4],
    /// Scaling of `x` and `y`.
    steps: [f64; 2],
    data_unit: String,
    lateral_units: [String; 2],
    /// Lengths of formula, note, extended units and labels behind the data.
    tail: [usize; 11],
}

/// The format.
pub const FORMAT: Format = Format {
    name: "igor",
    title: "Igor (Asylum Research)",
    extensions: &["ibw"],
    signature: |b| recognise(b).is_some(),
    is_by_name: true,
    read,
    facts: ["yes", "yes", "NaN", "version 5, several channels, both byte orders"],
};

/// Reads the file in `bytes`.
///
/// # Errors
/// Another version, a wave that is no image, fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let order = recognise(bytes)
        .ok_or_else(|| damaged("the check sum of its header is wrong, or it is cut short"))?;
    let mut cursor = Cursor::new(bytes, order);
    if cursor.u16()? != VERSION {
        return Err(Error::input("holds a single line and no image", "choose an image file"));
    }
    let wave = header(&mut cursor)?;
    let [columns, rows, channels, more] = wave.dimensions;
    if more > 1 || rows == 0 {
        return Err(Error::input("holds no image", "choose a file with an image in it"));
    }
    let size = size(columns, rows)?;
    let channels = channels.max(1);
    if channels > MOST_CHANNELS {
        return Err(damaged(format!("it has {channels} channels")));
    }
    let plane = size[0] * size[1] * wave.number.bytes();
    let mut rest = cursor.at(HEADERS);
    let data = rest.take(plane.saturating_mul(channels as usize))?;
    let tail = Tail::read(&mut rest, &wave)?;
    check_axes(&wave, &tail)?;
    let layers = data.chunks_exact(plane).enumerate();
    let channels =
        layers.map(|(i, layer)| channel(layer, i, order, size, &wave, &tail)).collect::<Result<_>>()?;
    Ok(Scan::new("Igor binary wave", channels))
}

/// Fails for curves in columns: the columns have names, or the axes are other quantities than lengths.
fn check_axes(wave: &IgorWave, tail: &Tail) -> Result<()> {
    let choose = "choose an image file";
    if tail.has_named_columns {
        return Err(Error::input(
            "holds curves in columns with names, such as a force curve, and no image",
            choose,
        ));
    }
    let units = wave.lateral_units.iter().chain(&tail.lateral_units);
    match units.into_iter().find(|unit| units::is_of_another_quantity(unit)) {
        Some(unit) => Err(Error::input(format!("has an axis in {unit}, which is no length"), choose)),
        None => Ok(()),
    }
}

fn header(cursor: &mut Cursor) -> Result<IgorWave> {
    // File header: version, check sum, size of the wave, then the lengths of the parts behind the data.
    cursor.take(2 + 4)?;
    let mut tail = [0; 11];
    for length in &mut tail {
        *length = cursor.u32()? as usize;
    }
    cursor.take(3 * 4)?; // text indices and options, which images have not
    // Wave header: 16 bytes of pointers, dates and the count of points.
    cursor.take(16)?;
    let kind = cursor.u16()?;
    cursor.take(2 + 6 + 2 + 32 + 4 + 4)?; // lock, padding, version, name, padding, folder
    let mut dimensions = [0; 4];
    for count in &mut dimensions {
        *count = u64::from(cursor.u32()?);
    }
    let steps = [cursor.f64()?, cursor.f64()?];
    cursor.take(2 * 8 + 4 * 8)?; // the other steps, and where the dimensions start
    let data_unit = cursor.text(4)?;
    let lateral_units = [cursor.text(4)?, cursor.text(4)?];
    let number = sample_type(kind)?;
    Ok(IgorWave { number, dimensions, steps, data_unit, lateral_units, tail })
}

fn sample_type(kind: u16) -> Result<Number> {
    /// Bit of complex numbers, and of unsigned integers.
    const COMPLEX: u16 = 0x01;
    const UNSIGNED: u16 = 0x40;
    Ok(match kind {
        0x02 => Number::F32,
        0x04 => Number::F64,
        0x08 => Number::I8,
        0x10 => Number::I16,
        0x20 => Number::I32,
        0x80 => Number::I64,
        _ if kind == 0x08 | UNSIGNED => Number::U8,
        _ if kind == 0x10 | UNSIGNED => Number::U16,
        _ if kind == 0x20 | UNSIGNED => Number::U32,
        _ if kind == 0x80 | UNSIGNED => Number::U64,
        _ if kind & COMPLEX != 0 => {
            return Err(Error::input("holds complex numbers", "choose an image of heights"));
        }
        _ => return Err(damaged(format!("its samples have the unknown type {kind:#x}"))),
    })
}

/// Contents of the file behind the data.
struct Tail {
    note: String,
    data_unit: String,
    lateral_units: [String; 2],
    labels: Vec<String>,
    /// True if every column has a name in addition to that of the dimension.
    has_named_columns: bool,
}

impl Tail {
    fn read(rest: &mut Cursor, wave: &IgorWave) -> Result<Self> {
        let [formula, note, data_unit, x, y, z, t, labels_x, labels_y, labels_z, _] = wave.tail;
        rest.take(formula)?;
        let note = text(rest.take(note)?);
        let data_unit = text(rest.take(data_unit)?);
        let lateral_units = [text(rest.take(x)?), text(rest.take(y)?)];
        for skipped in [z, t, labels_x, labels_y] {
            rest.take(skipped)?;
        }
        // The first label names the dimension, each of the others a channel.
        let labels = rest.take(labels_z)?.chunks(LABEL).skip(1).map(text).collect();
        Ok(Self { note, data_unit, lateral_units, labels, has_named_columns: labels_y > LABEL })
    }
}

fn channel<'a>(
    layer: &'a [u8],
    i: usize,
    order: Order,
    size: [usize; 2],
    wave: &IgorWave,
    tail: &Tail,
) -> Result<Channel<'a>> {
    let label = tail.labels.get(i).filter(|label| !label.is_empty());
    let wave_unit = if tail.data_unit.is_empty() { &wave.data_unit } else { &tail.data_unit };
    let unit = label.and_then(|label| asylum_unit(label, &tail.note)).unwrap_or_else(|| wave_unit.clone());
    let height = units::length(&unit);
    let step = |i: usize| {
        let short = &wave.lateral_units[i];
        let unit = if tail.lateral_units[i].is_empty() { short } else { &tail.lateral_units[i] };
        spacing(wave.steps[i] * units::length(unit)?, 1)
    };
    let block = Block {
        bytes: Cow::Borrowed(layer),
        scale: [height.unwrap_or(1.0), 0.0],
        rows: Rows::BottomFirst,
        ..Block::plain(layer, wave.number, order)
    };
    Ok(Channel {
        name: label.cloned().unwrap_or_else(|| format!("Channel {}", i + 1)),
        unit,
        size,
        spacing: [step(0), step(1)],
        quantity: if height.is_some() { Quantity::Height } else { Quantity::Other },
        prepared: PreparationRecord::default(),
        decode: block.decode(size)?,
    })
}

/// Returns the unit of Asylum's channel `label`: from a line of the note, otherwise from its name. `None` without a note: the wave is not
/// Asylum's.
fn asylum_unit(label: &str, note: &str) -> Option<String> {
    if note.is_empty() {
        return None;
    }
    let name = label.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches("Mod");
    let name = name.strip_suffix("Retrace").or_else(|| name.strip_suffix("Trace")).unwrap_or(name);
    let key = format!("{name}Unit");
    let lines = note.split(['\r', '\n']).filter_map(|line| line.split_once(':'));
    if let Some((_, unit)) = lines.into_iter().find(|(k, _)| k.trim() == key) {
        return Some(unit.trim().to_owned());
    }
    let name = name.strip_prefix("DAC").or_else(|| name.strip_prefix("Nap")).unwrap_or(name);
    ASYLUM.iter().find(|(start, _)| name.starts_with(start)).map(|(_, unit)| (*unit).to_owned())
}

#[cfg(test)]
#[path = "igor_tests.rs"]
mod tests;
