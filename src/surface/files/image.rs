//! Height images: grey PNG and TIFF files of 8 and 16 bits, read and written.
//!
//! Black is height 0, the format's largest code is the full height, row 0 is the top. Nothing is decoded before its size is
//! known and found to fit.

use super::super::{HeightField, MAX_SIDE};
use super::format::Format;
use super::scan::{Channel, Quantity, Scan};
use crate::error::{self, Error, Result};
use crate::notes::PreparationRecord;
use crate::{memory, output};
use image::error::{ImageError, LimitErrorKind};
use image::{ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageFormat, Limits, codecs};
use std::io::Cursor;
use std::path::Path;

/// First bytes of a PNG.
pub const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// The largest code of a 16-bit image.
const LARGEST_CODE: f64 = u16::MAX as f64;

/// Memory of a decoder beside the picture itself: a compressed block, a colour profile, a comment \[bytes\].
const DECODER_ROOM: u64 = 64 << 20;

/// Remedy for a file whose pixels are no plain grey codes.
const EXPORT_GREY: &str = "export it as 8- or 16-bit grey PNG or TIFF";

/// The format.
pub const FORMAT: Format = Format {
    name: "png",
    title: "PNG",
    extensions: &["png"],
    signature: |b| b.starts_with(PNG_MAGIC),
    is_by_name: true,
    read,
    facts: ["to be given", "to be given", "", "8 and 16 bits"],
};

/// Reads the image in `bytes`, an 8- or 16-bit PNG or TIFF, grey or with equal colour channels; alpha is ignored. Only the first page of
/// several is read. The orientation that the file asks for is applied.
///
/// # Errors
/// A file that is damaged, of another format or pixel type, coloured, larger than [`MAX_SIDE`] on a side or than the memory.
pub fn read(bytes: &[u8]) -> Result<Scan<'_>> {
    let (format, image) = decode(bytes)?;
    let size = [image.width() as usize, image.height() as usize];
    let largest = match image.color() {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => f64::from(u8::MAX),
        _ => LARGEST_CODE,
    };
    let codes = grey_codes(&image)?;
    let channel = Channel {
        name: "grey".to_owned(),
        unit: String::new(),
        size,
        spacing: [None, None],
        quantity: Quantity::Code { largest },
        prepared: PreparationRecord::default(),
        decode: Box::new(move || Ok(codes)),
    };
    Ok(Scan::single(if format == ImageFormat::Png { "PNG" } else { "TIFF" }, channel))
}

/// Writes `field` as a 16-bit grey image, PNG or TIFF by the extension of `path`, and returns the full height \[µm\], that of the largest
/// code. The lowest height becomes code 0, the highest 65535; a flat field is code 0 all over and has full height 0. The file appears whole
/// or not at all.
///
/// # Errors
/// Another extension; heights too far apart for a number; a place that cannot be written to.
pub fn write(path: &Path, field: &HeightField) -> Result<f64> {
    let format = format_by_extension(path)?;
    let (low, high) = field.range();
    let full_height = high - low;
    if !full_height.is_finite() {
        return Err(Error::input("the heights are too far apart for a number", "scale them down"));
    }
    // Dividing first keeps the product finite and the highest height exactly at the largest code.
    let code = |h: &f64| ((h - low) / full_height * LARGEST_CODE).round() as u16;
    let codes: Vec<u16> = if full_height > 0.0 {
        field.heights().iter().map(code).collect()
    } else {
        vec![0; field.heights().len()]
    };
    let (columns, rows) = (field.columns() as u32, field.rows() as u32); // at most MAX_SIDE
    let picture = image::ImageBuffer::from_raw(columns, rows, codes)
        .ok_or_else(|| Error::bug("the heights do not fill their grid"))?;
    let picture = DynamicImage::ImageLuma16(picture);
    output::write_atomically(path, |file| {
        picture.write_to(file, format).map_err(|e| match e {
            ImageError::IoError(e) => output::write_failed(path, e),
            e => Error::bug(format!("cannot write: {e}")).caused_by(e).at(path.display()),
        })
    })?;
    Ok(full_height)
}

/// Returns true if the extension of `path` is that of an image.
pub fn is_named(path: &Path) -> bool {
    format_by_extension(path).is_ok()
}

fn format_by_extension(path: &Path) -> Result<ImageFormat> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("png") => Ok(ImageFormat::Png),
        Some("tif" | "tiff") => Ok(ImageFormat::Tiff),
        _ => Err(Error::usage(
            format!("{}: the name does not end like a height image", path.display()),
            "end it in .png, .tif or .tiff",
        )),
    }
}

/// Returns true if `bytes` begin with the mark of a TIFF, of 32 or 64 bits (BigTIFF), in either byte order.
pub fn is_tiff(bytes: &[u8]) -> bool {
    [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| bytes.starts_with(*magic))
}

/// Decodes the picture, after all checks that need no decoding.
fn decode(bytes: &[u8]) -> Result<(ImageFormat, DynamicImage)> {
    let reader = Cursor::new(bytes);
    if is_tiff(bytes) {
        let decoder = codecs::tiff::TiffDecoder::new(reader).map_err(explain)?;
        return Ok((ImageFormat::Tiff, decode_with(decoder)?));
    }
    if !bytes.starts_with(PNG_MAGIC) {
        return Err(Error::input("is neither a PNG nor a TIFF image", EXPORT_GREY));
    }
    let decoder = codecs::png::PngDecoder::with_limits(reader, limits(DECODER_ROOM)).map_err(explain)?;
    Ok((ImageFormat::Png, decode_with(decoder)?))
}

fn decode_with(mut decoder: impl ImageDecoder) -> Result<DynamicImage> {
    let (columns, rows) = decoder.dimensions();
    if columns as usize > MAX_SIDE || rows as usize > MAX_SIDE {
        return Err(too_large(&format!("{columns} x {rows} pixels")));
    }
    if matches!(decoder.color_type(), ColorType::Rgb32F | ColorType::Rgba32F) {
        return Err(float_colours());
    }
    if matches!(decoder.original_color_type(), ExtendedColorType::Cmyk8 | ExtendedColorType::Cmyk16) {
        return Err(Error::input("holds printing colours (CMYK), not heights", EXPORT_GREY));
    }
    let decoded = decoder.total_bytes();
    let heights = u64::from(columns) * u64::from(rows) * size_of::<f64>() as u64;
    memory::ensure_room(decoded.saturating_add(heights), &format!("an image of {columns} x {rows} pixels"))?;
    let orientation = decoder.orientation().map_err(explain)?;
    // Decoders count the picture's buffer too, twice if they convert it.
    decoder.set_limits(limits(decoded.saturating_mul(2) + DECODER_ROOM)).map_err(explain)?;
    let mut image = DynamicImage::from_decoder(decoder).map_err(explain)?;
    image.apply_orientation(orientation);
    Ok(image)
}

fn limits(bytes: u64) -> Limits {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    limits.max_alloc = Some(bytes);
    limits
}

/// Returns every pixel's grey as a share of the format's largest code, row by row.
fn grey_codes(image: &DynamicImage) -> Result<Vec<f64>> {
    match image {
        DynamicImage::ImageLuma8(p) => shares(p, 1, 1, p.width()),
        DynamicImage::ImageLumaA8(p) => shares(p, 2, 1, p.width()),
        DynamicImage::ImageRgb8(p) => shares(p, 3, 3, p.width()),
        DynamicImage::ImageRgba8(p) => shares(p, 4, 3, p.width()),
        DynamicImage::ImageLuma16(p) => shares(p, 1, 1, p.width()),
        DynamicImage::ImageLumaA16(p) => shares(p, 2, 1, p.width()),
        DynamicImage::ImageRgb16(p) => shares(p, 3, 3, p.width()),
        DynamicImage::ImageRgba16(p) => shares(p, 4, 3, p.width()),
        _ => Err(float_colours()),
    }
}

/// Returns the first of `channels` samples of every pixel as a share of the largest code, if the first `colours` are equal.
fn shares<S: IntegerSample>(
    samples: &[S],
    channels: usize,
    colours: usize,
    columns: u32,
) -> Result<Vec<f64>> {
    let share = |(i, pixel): (usize, &[S])| {
        let grey = pixel[0];
        if pixel[..colours].iter().all(|&c| c == grey) {
            return Ok(grey.into() / S::LARGEST);
        }
        let codes: Vec<String> = pixel[..colours].iter().map(|&c| c.into().to_string()).collect();
        let (column, row) = (i % columns as usize, i / columns as usize);
        Err(Error::input(
            format!("the pixel at column {column}, row {row} is coloured ({})", codes.join(", ")),
            "a height image is grey; ".to_owned() + EXPORT_GREY,
        ))
    };
    // Reserves all at once: a vector that grows by doubling takes half as much again.
    let mut shares = Vec::with_capacity(samples.len() / channels);
    for pixel in samples.chunks_exact(channels).enumerate() {
        shares.push(share(pixel)?);
    }
    Ok(shares)
}

/// A sample of an integer image.
trait IntegerSample: Copy + PartialEq + Into<f64> {
    /// The code of white.
    const LARGEST: f64;
}

impl IntegerSample for u8 {
    const LARGEST: f64 = u8::MAX as f64;
}

impl IntegerSample for u16 {
    const LARGEST: f64 = LARGEST_CODE;
}

fn float_colours() -> Error {
    Error::input("holds colours in 32-bit floats, which are no heights", "export the heights as one channel")
}

fn too_large(what: &str) -> Error {
    Error::input(format!("{what} are more than {MAX_SIDE} on a side"), "crop it or average it down")
}

/// Converts a decoder's message into an error of this program.
fn explain(cause: ImageError) -> Error {
    let error = match &cause {
        ImageError::Unsupported(_) => Error::input(format!("cannot be used: {cause}"), EXPORT_GREY),
        ImageError::Limits(e) if matches!(e.kind(), LimitErrorKind::DimensionError) => {
            too_large("its pixels")
        }
        ImageError::Limits(_) => {
            Error::input("takes more memory to decode than its pixels explain", "save the image again")
        }
        ImageError::IoError(e) => Error::input(
            format!("is cut short or cannot be read: {}", error::cause(e)),
            "save or copy the image again",
        ),
        _ => Error::input(format!("is damaged: {cause}"), "save or copy the image again"),
    };
    error.caused_by(cause)
}

#[cfg(test)]
#[path = "image_tests.rs"]
mod tests;
