//! Images of WSxM (.stp, .top, .tom): a text header, then numbers from the lower right corner on.
//!
//! Floats are in the unit of `Z Amplitude`; 16-bit integers span that amplitude between the lowest and the highest. Facts after Gwyddion's
//! description and SurfaceTopography.

use super::bytes::{Number, Order, cut_short, damaged, decode_text};
use super::format::Format;
use super::header::{TextHeader, find};
use super::scan::{Block, Channel, Rows, Scan, size, spacing};
use super::units;
use crate::error::{Error, Result};

/// The format.
pub const FORMAT: Format = Format {
    name: "wsxm",
    title: "WSxM",
    extensions: &["stp", "top", "tom"],
    signature: |b| b.starts_with(b"WSxM file copyright"),
    is_by_name: false,
    read,
    facts: ["yes", "yes", "NaN", "16-bit integers, floats and doubles; curves are refused"],
};

/// Section of most values.
const GENERAL: &str = "General Info";
/// Largest length of a header; real ones have a few kilobytes \[bytes\].
const LONGEST_HEADER: usize = 1 << 20;

/// Reads the file in `bytes`.
///
/// # Errors
/// A file of curves; a header without sizes; fewer samples than the header promises.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let end = find(&bytes[..bytes.len().min(LONGEST_HEADER)], b"[Header end]").ok_or_else(cut_short)?;
    let text = decode_text(&bytes[..end]);
    if text.lines().nth(1).is_none_or(|line| line.trim() != "SxM Image file") {
        return Err(Error::input("holds curves and no image", "choose a .stp or .top file"));
    }
    let header = TextHeader::parse(&text, ':');
    let size = size(header.count(GENERAL, "Number of columns")?, header.count(GENERAL, "Number of rows")?)?;
    let (amplitude, unit) = header
        .text(GENERAL, "Z Amplitude")
        .and_then(units::number_with_unit)
        .ok_or_else(|| damaged("its Z Amplitude is missing"))?;
    let number = match header.text(GENERAL, "Image Data Type").unwrap_or("short") {
        "short" | "integer" | "int" => Number::I16,
        "float" => Number::F32,
        "double" => Number::F64,
        other => return Err(damaged(format!("its samples have the unknown type `{other}`"))),
    };
    let start = end + find(&bytes[end..], b"\n").ok_or_else(cut_short)? + 1;
    let block = Block {
        rows: Rows::BottomFirst,
        mirrored: true,
        ..Block::plain(bytes.get(start..).ok_or_else(cut_short)?, number, Order::Little)
    };
    let side = |key: &str| header.text("Control", key).and_then(units::measured_length);
    let x = side("X Amplitude");
    // A square scan may have one amplitude.
    let sides = [x, side("Y Amplitude").or(x)];
    let spacing = [0, 1].map(|i| spacing(sides[i]?, size[i]));
    let name = header.text(GENERAL, "Acquisition channel").unwrap_or("Topography");
    let mut channel = Channel::stored(name, unit, size, spacing, block)?;
    if number == Number::I16 {
        let amplitude = amplitude * units::length(unit).unwrap_or(1.0);
        channel = channel.changed(move |samples| spanning(samples, amplitude));
    }
    Ok(Scan::single(FORMAT.title, channel))
}

/// Returns `samples` times the factor by which they span `amplitude`; equal ones as they are.
fn spanning(mut samples: Vec<f64>, amplitude: f64) -> Vec<f64> {
    let low = samples.iter().copied().fold(f64::INFINITY, f64::min);
    let high = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if high > low {
        samples.iter_mut().for_each(|x| *x *= amplitude / (high - low));
    }
    samples
}

#[cfg(test)]
#[path = "wsxm_tests.rs"]
mod tests;
