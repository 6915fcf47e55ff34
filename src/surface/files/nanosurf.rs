//! Files of Nanosurf's microscopes (.nid, .ezd): a text header, `#!`, then blocks of integers.
//!
//! The section `DataSet` names the sections of all blocks, whose integers stand one after the other and span the range of the block's
//! third dimension. The first line is the lowest. Facts after Gwyddion's description and NSFopen.

use super::bytes::{Number, Order, cut_short, damaged, decode_text};
use super::format::Format;
use super::header::{TextHeader, find};
use super::scan::{Block, Channel, Rows, Scan, size, spacing};
use super::units;
use crate::error::Result;

/// The format.
pub const FORMAT: Format = Format {
    name: "nanosurf",
    title: "Nanosurf",
    extensions: &["nid", "ezd"],
    signature: |b| b.starts_with(b"[DataSet]\r\n") || b.starts_with(b"[DataSet]\n"),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "", "8, 16 and 32 bits, forward and backward; spectra are left out"],
};

/// Line behind which the integers begin.
const MARK: &[u8] = b"\n#!";
/// Largest number of groups, and of channels of one.
const MOST: u64 = 1000;

/// Reads the file in `bytes`.
///
/// # Errors
/// A header without blocks; no block that is whole; a file of spectra alone.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let end = find(bytes, MARK).ok_or_else(cut_short)?;
    let header = TextHeader::parse(&decode_text(&bytes[..end]), '=');
    let mut place = end + MARK.len();
    let mut found = Vec::new();
    for group in 0..header.count("DataSet", "GroupCount")?.min(MOST) {
        // A group may be empty.
        let count = header.count("DataSet", &format!("Gr{group}-Count")).unwrap_or(0);
        let section = |i: u64| header.text("DataSet", &format!("Gr{group}-Ch{i}"));
        for section in (0..count.min(MOST)).filter_map(section) {
            let block = NanosurfBlock::read(&header, section)?;
            let data = bytes.get(place..).unwrap_or_default(); // an error of `channel`
            place = place.saturating_add(block.bytes());
            if block.is_image() {
                found.push((block.name.clone(), block.channel(data)));
            }
        }
    }
    Scan::of_readable(FORMAT.title, found)
}

/// Description of one block.
struct NanosurfBlock {
    name: String,
    counts: [u64; 2],
    /// Width and height \[m\]; `None` for other quantities.
    sides: [Option<f64>; 2],
    unit: String,
    /// Lowest value and range.
    range: [f64; 2],
    number: Number,
    order: Order,
}

impl NanosurfBlock {
    fn read(header: &TextHeader, section: &str) -> Result<Self> {
        let text = |key: &str| header.text(section, key).unwrap_or_default(); // optional
        let is_signed = text("SaveSign") != "Unsigned";
        let number = match (header.count(section, "SaveBits")?, is_signed) {
            (8, true) => Number::I8,
            (16, true) => Number::I16,
            (32, true) => Number::I32,
            (8, false) => Number::U8,
            (16, false) => Number::U16,
            (32, false) => Number::U32,
            (bits, _) => return Err(damaged(format!("its samples have {bits} bits"))),
        };
        let side = |i: usize| {
            let unit = units::length(text(&format!("Dim{i}Unit")))?;
            Some(header.number(section, &format!("Dim{i}Range"))? * unit)
        };
        let quantity = text("Dim2Name");
        let name = match text("Frame") {
            "" => quantity.to_owned(),
            frame => format!("{quantity} {}", frame.strip_prefix("Scan ").unwrap_or(frame)),
        };
        Ok(Self {
            name,
            counts: [header.count(section, "Points")?, header.count(section, "Lines")?],
            sides: [side(0), side(1)],
            unit: text("Dim2Unit").to_owned(),
            range: [header.number(section, "Dim2Min").unwrap_or(0.0), header.required(section, "Dim2Range")?],
            number,
            order: if text("SaveOrder") == "Motorola" { Order::Big } else { Order::Little },
        })
    }

    /// Returns the number of bytes of the block.
    fn bytes(&self) -> usize {
        let count = self.counts[0].saturating_mul(self.counts[1]);
        usize::try_from(count).unwrap_or(usize::MAX).saturating_mul(self.number.bytes())
    }

    /// Returns true for an image; spectra have one line, or a line for each point.
    fn is_image(&self) -> bool {
        self.sides[1].is_some() && self.counts[1] > 1
    }

    fn channel<'a>(&self, data: &'a [u8]) -> Result<Channel<'a>> {
        let size = size(self.counts[0], self.counts[1])?;
        let codes = f64::from(self.number.bytes() as u32 * 8).exp2();
        let [low, range] = self.range;
        // The lowest code is the lowest value.
        let zero = if matches!(self.number, Number::I8 | Number::I16 | Number::I32) { 0.5 } else { 0.0 };
        let block = Block {
            scale: [range / codes, range * zero + low],
            rows: Rows::BottomFirst,
            ..Block::plain(data, self.number, self.order)
        };
        let spacing = [0, 1].map(|i| spacing(self.sides[i]?, size[i]));
        Channel::stored(self.name.as_str(), &self.unit, size, spacing, block)
    }
}

#[cfg(test)]
#[path = "nanosurf_tests.rs"]
mod tests;
