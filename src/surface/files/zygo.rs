//! Height maps of Zygo's interferometers, MetroPro (.dat): a binary header, intensities, then 32-bit integers from the top.
//!
//! A height is the integer times wavelength, interferometric factor and obliquity over the codes of a wavelength, which the field of the
//! phase resolution chooses. Format: Zygo, *MetroPro Reference Guide*, OMP-0347. Most numbers have their most significant byte first.

use super::bytes::{Cursor, Number, Order, cut_short, damaged};
use super::format::Format;
use super::scan::{Block, Channel, Scan, size, spacing};
use crate::error::{Error, Result};

/// The format.
pub const FORMAT: Format = Format {
    name: "zygo",
    title: "Zygo MetroPro",
    extensions: &["dat"],
    signature: |b| b.starts_with(b"\x88\x1b\x03") && b.get(3).is_some_and(|b| (0x6f..=0x71).contains(b)),
    is_by_name: false,
    read,
    facts: [
        "yes, if the instrument was calibrated",
        "yes",
        "the reserved codes",
        "formats 1 to 3 of the header",
    ],
};

/// Least code of samples that were not measured.
const INVALID: f64 = 2_147_483_640.0;
/// Codes of a wavelength by the phase resolution.
const CODES: [f64; 3] = [4096.0, 32_768.0, 131_072.0];

/// Reads the file in `bytes`.
///
/// # Errors
/// A file of intensities alone; an unknown phase resolution; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let from = |place: usize| Cursor::new(bytes, Order::Big).at(place);
    let header = from(6).u32()? as usize;
    let mut pictures = from(52);
    let pictures = [pictures.u16()?, pictures.u16()?, pictures.u16()?]; // columns, rows and their number
    let intensities = pictures.iter().fold(2, |bytes: usize, n| bytes.saturating_mul(usize::from(*n)));
    let [columns, rows] = [from(68).u16()?, from(70).u16()?];
    let [interferometric, wavelength] = [from(164).f32()?, from(168).f32()?];
    let obliquity = from(176).f32()?;
    let lateral = from(184).f32()?;
    let resolution = from(218).i16()?;
    let sign = if from(SIGN).i16()? == 0 { 1.0 } else { -1.0 };
    if columns == 0 && rows == 0 {
        return Err(Error::input(
            "holds intensities and no heights",
            "choose a file with a measured surface",
        ));
    }
    let codes = usize::try_from(resolution)
        .ok()
        .and_then(|i| CODES.get(i))
        .ok_or_else(|| damaged(format!("its phase resolution is {resolution} instead of 0, 1 or 2")))?;
    let size = size(u64::from(columns), u64::from(rows))?;
    let data = bytes.get(header.saturating_add(intensities)..).ok_or_else(cut_short)?;
    let block = Block {
        scale: [sign * interferometric * wavelength * obliquity / codes, 0.0],
        missing_from: Some(INVALID),
        ..Block::plain(data, Number::I32, Order::Big)
    };
    Ok(Scan::single(FORMAT.title, Channel::stored("Phase", "m", size, [spacing(lateral, 1); 2], block)?))
}

/// Offset of the field that turns heights upside down \[bytes\].
const SIGN: usize = 232;

#[cfg(test)]
#[path = "zygo_tests.rs"]
mod tests;
