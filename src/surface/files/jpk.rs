//! Images of JPK's microscopes (.jpk, .jpk-qi-image): a TIFF whose pages are channels, and whose private tags have their scales.
//!
//! A page has slots, each of which converts the stored numbers to one quantity; the default slot is the one that JPK's program shows. The
//! first line is the lowest unless the grid is reflected. Facts after Gwyddion's description and SurfaceTopography.

use super::bytes::{cut_short, damaged};
use super::format::Format;
use super::scan::{Channel, Quantity, Scan, flip, size, spacing};
use super::tiff_tags::TiffDirectory;
use super::{tiff, units};
use crate::error::{Error, Result};
use crate::notes::PreparationRecord;
use ::tiff::decoder::Decoder;
use std::io::Cursor;

/// The format.
pub const FORMAT: Format = Format {
    name: "jpk",
    title: "JPK images",
    extensions: &["jpk", "jpk-qi-image"],
    signature: |b| TiffDirectory::all(b).first().is_some_and(|page| page.value(SIDES[0]).is_some()),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "", "all channels, by their default slot; files of force curves are refused"],
};

/// Tags of columns and rows of an image, of TIFF itself.
const COUNTS: [u16; 2] = [256, 257];
/// Tags of width and height of the grid \[m\], on the first page.
const SIDES: [u16; 2] = [0x8042, 0x8043];
/// Tag of a page whose first line is the highest.
const REFLECTED: u16 = 0x8045;
/// Tags of the name of a channel: for programs, and for people.
const NAMES: [u16; 2] = [0x8050, 0x8052];
/// Tag of a channel of lines that were scanned backwards.
const RETRACE: u16 = 0x8051;
/// Tag of the number of slots, which every channel has.
const SLOTS: u16 = 0x8080;
/// Tag of the name of the default slot.
const DEFAULT_SLOT: u16 = 0x8081;
/// Tag of the name of the first slot.
const FIRST_SLOT: u16 = 0x8090;
/// Distance of the tags of neighbouring slots.
const SLOT_STEP: u16 = 0x30;
/// Largest number of slots, which leaves their tags below 65536.
const MOST_SLOTS: u16 = 600;
/// Distances of the tags of a slot from that of its name: unit, type of scaling, factor, offset.
const UNIT: u16 = 0x12;
const SCALING: u16 = 0x13;
const FACTOR: u16 = 0x14;
const OFFSET: u16 = 0x15;

/// Reads the file in `bytes`.
///
/// # Errors
/// A file without channels; pages that are damaged.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let pages = TiffDirectory::all(bytes);
    let first = pages.first().ok_or_else(cut_short)?;
    let sides = SIDES.map(|tag| first.number(tag));
    let has_channel = |(_, page): &(usize, &TiffDirectory)| page.number(SLOTS).is_some();
    let found = pages.iter().enumerate().filter(has_channel);
    Scan::of_readable(
        FORMAT.title,
        found.map(|(i, page)| (name(page), channel(bytes, i, page, sides))).collect(),
    )
}

fn name(page: &TiffDirectory) -> String {
    let name = page.text(NAMES[1]).or_else(|| page.text(NAMES[0])).unwrap_or_else(|| "unnamed".to_owned());
    if page.number(RETRACE).is_some_and(|x| x != 0.0) { format!("{name} (retrace)") } else { name }
}

/// Returns the channel of page `i`, of a grid with the `sides` \[m\].
fn channel<'a>(
    bytes: &'a [u8],
    i: usize,
    page: &TiffDirectory<'a>,
    sides: [Option<f64>; 2],
) -> Result<Channel<'a>> {
    let [columns, rows] = COUNTS.map(|tag| page.number(tag).unwrap_or(0.0) as u64);
    let size = size(columns, rows)?;
    let slot = JpkSlot::of_page(page)?;
    let is_reflected = page.number(REFLECTED).is_some_and(|x| x != 0.0);
    let metres = units::length(&slot.unit);
    let decode = move || {
        let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(tiff::explain)?;
        decoder.seek_to_image(i).map_err(tiff::explain)?;
        let (mut samples, _) = tiff::numbers(decoder, size, bytes.len())?;
        let unit = metres.unwrap_or(1.0);
        samples.iter_mut().for_each(|x| *x = (*x * slot.factor + slot.offset) * unit);
        if !is_reflected {
            flip(&mut samples, size[0]);
        }
        Ok(samples)
    };
    Ok(Channel {
        name: name(page),
        unit: slot.unit,
        size,
        spacing: [0, 1].map(|i| spacing(sides[i]?, size[i])),
        quantity: if metres.is_some() { Quantity::Height } else { Quantity::Other },
        prepared: PreparationRecord::default(),
        decode: Box::new(decode),
    })
}

/// Conversion of stored numbers.
struct JpkSlot {
    factor: f64,
    offset: f64,
    unit: String,
}

impl JpkSlot {
    /// Returns the default slot of a channel.
    fn of_page(page: &TiffDirectory) -> Result<Self> {
        let count = page.number(SLOTS).map_or(0, |count| count as u16).min(MOST_SLOTS);
        let default = page.text(DEFAULT_SLOT).ok_or_else(|| damaged("it names no default slot"))?;
        let tag = (0..count).map(|i| FIRST_SLOT + i * SLOT_STEP);
        let tag = tag.into_iter().find(|tag| page.text(*tag).as_deref() == Some(default.as_str()));
        let tag = tag.ok_or_else(|| damaged(format!("its default slot `{default}` is missing")))?;
        let number = |at: u16| page.number(tag + at).filter(|x| x.is_finite());
        let unit = page.text(tag + UNIT).unwrap_or_default(); // raw numbers have none
        match page.text(tag + SCALING).as_deref() {
            Some("NullScaling") => Ok(Self { factor: 1.0, offset: 0.0, unit }),
            Some("LinearScaling") => {
                let [factor, offset] = [number(FACTOR), number(OFFSET)];
                let factor = factor.ok_or_else(|| damaged(format!("the slot `{default}` has no factor")))?;
                Ok(Self { factor, offset: offset.unwrap_or(0.0), unit })
            }
            other => Err(Error::input(
                format!("its slot `{default}` is scaled by `{}`, not linearly", other.unwrap_or_default()),
                "export the channel from the program of the microscope",
            )),
        }
    }
}

#[cfg(test)]
#[path = "jpk_tests.rs"]
mod tests;
