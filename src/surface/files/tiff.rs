//! TIFF images of any real numbers, with the distance of samples if their tags give it.
//!
//! Unsigned integers of 8 and 16 bits are height images (`image`). Other integers are codes as well; floating-point numbers are heights in
//! metres. Resolution tags, ImageJ's description and the description that this program writes give the distance of samples. Orientation
//! tags are applied.

use super::bytes::damaged;
use super::format::Format;
use super::scan::{Channel, Quantity, Scan, size, spacing};
use super::topography::Topography;
use super::{image, units};
use crate::error::{self, Error, Result};
use crate::memory;
use crate::notes::{self, Notes};
use ::tiff::decoder::ifd::Value;
use ::tiff::decoder::{Decoder, DecodingResult, Limits};
use ::tiff::encoder::{Rational, TiffEncoder, colortype};
use ::tiff::tags::{PhotometricInterpretation, ResolutionUnit, Tag};
use ::tiff::{ColorType, TiffError};
use std::io::{Cursor, Seek, Write};

/// Largest distance of samples in resolution tags \[m\]; larger ones are the size of a print, not of the surface.
const COARSEST: f64 = 10e-6;

/// First words of the description of a TIFF of this program.
const OWN: &str = "heights in metres; distance of samples in metres: ";

/// The format.
pub const FORMAT: Format = Format {
    name: "tiff",
    title: "TIFF",
    extensions: &["tif", "tiff"],
    signature: image::is_tiff,
    is_by_name: true,
    read,
    facts: [
        "resolution tags finer than 10 µm, ImageJ's description",
        "floats: metres; integers: to be given",
        "NaN",
        "classic and BigTIFF; written as 32-bit floats with both scales",
    ],
};

/// Reads the file in `bytes`; only the first page of several is read.
///
/// # Errors
/// A file that is damaged; colours; a size that no height field has.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    if !image::is_tiff(bytes) {
        // The name alone says that it is a TIFF: a PNG perhaps.
        return image::read(bytes);
    }
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(explain)?;
    let white_is_zero = PhotometricInterpretation::WhiteIsZero.to_u16();
    if decoder.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).map_err(explain)?
        == Some(white_is_zero)
    {
        return Err(Error::input(
            "counts from white (WhiteIsZero)",
            "save it with black as the lowest value",
        ));
    }
    let more = decoder.more_images();
    let (columns, rows) = decoder.dimensions().map_err(explain)?;
    let size = size(u64::from(columns), u64::from(rows))?;
    let distances = distances(&mut decoder);
    let orientation = orientation(&mut decoder);
    let distances = if turned(orientation) { [distances[1], distances[0]] } else { distances };
    let grey = matches!(decoder.colortype(), Ok(ColorType::Gray(8 | 16 | 32 | 64)));
    let formats =
        decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).map_err(explain)?.unwrap_or_default();
    let bits = decoder.find_tag_unsigned_vec::<u16>(Tag::BitsPerSample).map_err(explain)?.unwrap_or_default();
    /// Value of SampleFormat for unsigned integers; the default.
    const UNSIGNED: u16 = 1;
    let unsigned = formats.first().is_none_or(|f| *f == UNSIGNED);
    if !grey || unsigned && bits.first().is_none_or(|b| *b <= 16) {
        let marks = CodeMarks::read(&mut decoder);
        let mut scan = image::read(bytes)?;
        for mut channel in std::mem::take(&mut scan.channels) {
            channel.spacing = distances;
            if let Quantity::Code { largest } = channel.quantity {
                let bound = marks.bound(largest);
                scan.notes.extend(bound.map(|bound| bounded(bound, largest)));
                channel.quantity = Quantity::Code { largest: bound.unwrap_or(largest) };
                channel = channel.changed(move |shares| marks.applied(shares, largest, bound));
            }
            scan.channels.push(channel);
        }
        scan.notes.extend(more.then(|| PAGES.to_owned()));
        return Ok(scan);
    }
    let unit = value_unit(&mut decoder);
    let prepared = notes::preparation(&description(&mut decoder));
    let marks = CodeMarks::read(&mut decoder);
    let (mut samples, largest) = numbers(decoder, size, bytes.len())?;
    samples.iter_mut().filter(|x| Some(**x) == marks.missing).for_each(|x| *x = f64::NAN);
    let (samples, size) = oriented(samples, size, orientation);
    let metres = units::length(&unit);
    let (quantity, factor) = match metres {
        _ if largest.is_finite() => (Quantity::Code { largest }, 1.0 / largest),
        Some(metres) => (Quantity::Height, metres),
        None => (Quantity::Other, 1.0),
    };
    let mut scan = Scan::single(
        "TIFF",
        Channel {
            name: "grey".to_owned(),
            unit: if largest.is_finite() { String::new() } else { unit },
            size,
            spacing: distances,
            quantity,
            prepared,
            decode: Box::new(move || Ok(samples.into_iter().map(|x| x * factor).collect())),
        },
    );
    scan.notes.extend(more.then(|| PAGES.to_owned()));
    Ok(scan)
}

/// Codes with a meaning by the tags of a file.
#[derive(Clone, Copy, Debug)]
struct CodeMarks {
    /// Number of a sample that was not measured (GDAL's tag).
    missing: Option<f64>,
    /// Largest code of a camera of fewer bits than the samples have.
    largest: Option<f64>,
}

impl CodeMarks {
    fn read(decoder: &mut Decoder<Cursor<&[u8]>>) -> Self {
        /// Tag of the largest number of samples of any type; that of unsigned ones is `MaxSampleValue`.
        const LARGEST: Tag = Tag::SMaxSampleValue;
        let missing = decoder.get_tag_ascii_string(Tag::GdalNodata).ok(); // most files have none
        let largest = [Tag::MaxSampleValue, LARGEST].into_iter().find_map(|tag| {
            decoder.find_tag_unsigned::<u32>(tag).ok().flatten() // most files have none
        });
        Self {
            missing: missing.and_then(|text| text.trim_matches(['\0', ' ']).parse().ok()),
            // Other numbers are the highest code of this picture.
            largest: largest.filter(|n| n.checked_add(1).is_some_and(u32::is_power_of_two)).map(f64::from),
        }
    }

    /// Returns the largest code, if it is below the `largest` of the type of samples.
    fn bound(&self, largest: f64) -> Option<f64> {
        self.largest.filter(|bound| *bound > 0.0 && *bound < largest)
    }

    /// Returns `shares` of the `largest` number of the type as shares of `bound`, NaN for samples that were not measured.
    fn applied(&self, shares: Vec<f64>, largest: f64, bound: Option<f64>) -> Vec<f64> {
        let factor = bound.map_or(1.0, |bound| largest / bound);
        let is_missing = |share: f64| self.missing == Some((share * largest).round());
        shares.into_iter().map(|x| if is_missing(x) { f64::NAN } else { x * factor }).collect()
    }
}

/// Returns the note for codes that end below the `largest` of their type.
fn bounded(bound: f64, largest: f64) -> String {
    format!("the largest code is {bound} by the file's tag, not {largest}")
}

/// Returns the distance of samples along `axis` \[m\] in a description in OME-XML; micrometres are the default unit.
fn ome(text: &str, axis: char) -> Option<f64> {
    let tag = text.split_once("Pixels ")?.1.split_once('>')?.0.replace('\'', "\"");
    let tag = format!(" {tag}");
    let attribute =
        |name: String| Some(tag.split_once(&format!(" {name}=\""))?.1.split_once('"')?.0.to_owned());
    let unit = attribute(format!("PhysicalSize{axis}Unit")).unwrap_or_else(|| "um".to_owned());
    let unit = unit.replace("&#181;", "\u{b5}").replace("&#xB5;", "\u{b5}");
    spacing(attribute(format!("PhysicalSize{axis}"))?.parse::<f64>().ok()? * units::length(&unit)?, 1)
}

/// Note for a file of several pages.
const PAGES: &str = "the file has several pages, of which the first was read";

/// Returns the value of `key` in the description that ImageJ writes, with its escaped letters decoded.
fn image_j(text: &str, key: &str) -> Option<String> {
    let value =
        text.strip_prefix("ImageJ")?.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='))?;
    Some(value.trim().replace("\\u00B5", "\u{b5}").replace("\\u00b5", "\u{b5}"))
}

/// Returns the description of the image; empty if there is none.
fn description(decoder: &mut Decoder<Cursor<&[u8]>>) -> String {
    decoder.get_tag_ascii_string(Tag::ImageDescription).unwrap_or_default() // most files have none
}

/// Returns the unit of the samples: that of ImageJ's description, else metres.
fn value_unit(decoder: &mut Decoder<Cursor<&[u8]>>) -> String {
    image_j(&description(decoder), "vunit").unwrap_or_else(|| "m".to_owned())
}

/// Converts the decoder's message into an error of this program.
pub fn explain(cause: TiffError) -> Error {
    let error = match &cause {
        TiffError::UnsupportedError(_) => {
            Error::input(format!("cannot be used: {cause}"), "export it as grey TIFF without compression")
        }
        TiffError::LimitsExceeded => {
            Error::input("takes more memory to decode than its pixels explain", "save the image again")
        }
        TiffError::IoError(e) => Error::input(
            format!("is cut short or cannot be read: {}", error::cause(e)),
            "save or copy the image again",
        ),
        _ => damaged(&cause),
    };
    error.caused_by(cause)
}

/// Decodes all samples. Returns the largest number of their type as well; infinity for floating-point numbers.
///
/// # Errors
/// A picture that is damaged, or of more or fewer numbers than `size` says; no room.
pub fn numbers(decoder: Decoder<Cursor<&[u8]>>, size: [usize; 2], length: usize) -> Result<(Vec<f64>, f64)> {
    /// Bytes of the widest sample.
    const WIDEST: usize = 8;
    let [columns, rows] = size;
    let count = columns * rows;
    memory::ensure_room((count * 2 * WIDEST) as u64, &format!("an image of {columns} x {rows} pixels"))?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = count * WIDEST;
    limits.intermediate_buffer_size = count * WIDEST + length;
    limits.ifd_value_size = length;
    let samples = decoder.with_limits(limits).read_image().map_err(explain)?;
    let float = f64::INFINITY;
    let (samples, largest) = match samples {
        DecodingResult::U8(s) => (s.into_iter().map(f64::from).collect(), f64::from(u8::MAX)),
        DecodingResult::U16(s) => (s.into_iter().map(f64::from).collect(), f64::from(u16::MAX)),
        DecodingResult::U32(s) => (s.into_iter().map(f64::from).collect(), f64::from(u32::MAX)),
        DecodingResult::U64(s) => (s.into_iter().map(|x| x as f64).collect(), u64::MAX as f64),
        DecodingResult::I8(s) => (s.into_iter().map(f64::from).collect(), f64::from(i8::MAX)),
        DecodingResult::I16(s) => (s.into_iter().map(f64::from).collect(), f64::from(i16::MAX)),
        DecodingResult::I32(s) => (s.into_iter().map(f64::from).collect(), f64::from(i32::MAX)),
        DecodingResult::I64(s) => (s.into_iter().map(|x| x as f64).collect(), i64::MAX as f64),
        DecodingResult::F16(s) => (s.into_iter().map(f64::from).collect(), float),
        DecodingResult::F32(s) => (s.into_iter().map(f64::from).collect(), float),
        DecodingResult::F64(s) => (s, float),
    };
    if samples.len() != count {
        return Err(damaged(format!("it holds {} samples instead of {count}", samples.len())));
    }
    Ok((samples, largest))
}

/// Returns the orientation tag: 1 to 8, 1 if there is none.
fn orientation(decoder: &mut Decoder<Cursor<&[u8]>>) -> u16 {
    let tag = decoder.find_tag_unsigned::<u16>(Tag::Orientation).ok().flatten();
    tag.filter(|o| (1..=8).contains(o)).unwrap_or(1)
}

/// Returns true if an orientation exchanges rows and columns.
fn turned(orientation: u16) -> bool {
    orientation >= 5
}

/// Returns samples and size after applying `orientation` (TIFF 6.0, tag 274: the sides of row 0 and column 0).
fn oriented(samples: Vec<f64>, [columns, rows]: [usize; 2], orientation: u16) -> (Vec<f64>, [usize; 2]) {
    if orientation == 1 {
        return (samples, [columns, rows]);
    }
    let size = if turned(orientation) { [rows, columns] } else { [columns, rows] };
    let (last_column, last_row) = (columns - 1, rows - 1);
    let stored = |row: usize, column: usize| {
        let (r, c) = match orientation {
            2 => (row, last_column - column),
            3 => (last_row - row, last_column - column),
            4 => (last_row - row, column),
            5 => (column, row),
            6 => (last_row - column, row),
            7 => (last_row - column, last_column - row),
            _ => (column, last_column - row),
        };
        samples[r * columns + c]
    };
    let shown = (0..size[1]).flat_map(|row| (0..size[0]).map(move |column| (row, column)));
    (shown.map(|(row, column)| stored(row, column)).collect(), size)
}

/// Returns the distances of samples and lines \[m\]: those of this program's description, or of the resolution tags.
fn distances(decoder: &mut Decoder<Cursor<&[u8]>>) -> [Option<f64>; 2] {
    let text = description(decoder);
    let first = text.lines().next().unwrap_or_default();
    if let Some((x, y)) = first.strip_prefix(OWN).and_then(|rest| rest.trim().split_once(" x ")) {
        return [x, y].map(|d| spacing(d.parse().ok()?, 1));
    }
    if text.contains("OME")
        && let [Some(x), Some(y)] = ['X', 'Y'].map(|axis| ome(&text, axis))
    {
        return [Some(x), Some(y)];
    }
    let resolution_unit = decoder.find_tag_unsigned::<u16>(Tag::ResolutionUnit).ok().flatten();
    // ImageJ writes pixels per ImageJ unit; `yunit` is present only if it differs.
    let x = image_j(&text, "unit");
    let y = image_j(&text, "yunit").or_else(|| x.clone());
    let axis = |named: Option<String>| match (named.as_deref().and_then(units::length), resolution_unit) {
        (Some(unit), _) => Some((unit, f64::INFINITY)),
        (None, None | Some(2)) => Some((0.0254, COARSEST)),
        (None, Some(3)) => Some((0.01, COARSEST)),
        (None, Some(_)) => None,
    };
    [(Tag::XResolution, axis(x)), (Tag::YResolution, axis(y))].map(|(tag, unit)| {
        let (unit, coarsest) = unit?;
        let resolution = match decoder.find_tag(tag).ok()?? {
            Value::Rational(n, d) => f64::from(n) / f64::from(d),
            Value::Float(x) => f64::from(x),
            Value::Double(x) => x,
            _ => return None,
        };
        spacing(unit / resolution, 1).filter(|d| *d <= coarsest)
    })
}

/// Writes `scan` as 32-bit floats in metres, with the distance of samples in the resolution tags and, exactly, in the
/// description, before `notes`.
///
/// # Errors
/// The file cannot be written to.
pub fn write(scan: &Topography, notes: &Notes, file: &mut (impl Write + Seek)) -> Result<()> {
    let [columns, rows] = scan.size().map(|n| n as u32); // at most MAX_SIDE
    let [dx, dy] = scan.spacing();
    let heights: Vec<f32> = scan.metres().map(|h| h as f32).collect();
    let write = || {
        let mut encoder = TiffEncoder::new(file)?;
        let mut image = encoder.new_image::<colortype::Gray32Float>(columns, rows)?;
        image.resolution_unit(ResolutionUnit::Centimeter);
        image.x_resolution(rational(0.01 / dx));
        image.y_resolution(rational(0.01 / dy));
        let description = format!("{OWN}{dx:e} x {dy:e}\n{}", notes::ascii(&notes.text()));
        image.encoder().write_tag(Tag::ImageDescription, description.as_str())?;
        image.write_data(&heights)
    };
    write().map_err(|e: TiffError| {
        let cause = if let TiffError::IoError(e) = &e { error::cause(e) } else { e.to_string() };
        Error::files(format!("cannot write: {cause}"), "check the free space").caused_by(e)
    })
}

/// Returns the best fraction of 32-bit numbers for `x`, by its continued fraction.
fn rational(x: f64) -> Rational {
    const LARGEST: f64 = u32::MAX as f64;
    let (mut before, mut now) = ([0.0, 1.0], [1.0, 0.0]);
    let x = x.clamp(1.0 / LARGEST, LARGEST);
    let mut rest = x;
    loop {
        let whole = rest.floor();
        let next = [whole * now[0] + before[0], whole * now[1] + before[1]];
        if next.iter().any(|n| *n > LARGEST) {
            break;
        }
        (before, now) = (now, next);
        // A smaller remainder is rounding.
        if (now[0] / now[1] - x).abs() <= f64::EPSILON * x || rest == whole {
            break;
        }
        rest = 1.0 / (rest - whole);
    }
    Rational { n: now[0] as u32, d: now[1].max(1.0) as u32 }
}

#[cfg(test)]
#[path = "tiff_tests.rs"]
mod tests;
