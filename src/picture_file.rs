//! The one writer of pictures: PNG as displayed, EXR linear, both with notes about their origin.

use crate::error::{Error, Result};
use crate::notes::{self, Notes};
use crate::output;
use crate::render::renderer::Picture;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder, Text,
    WritableImage,
};
use std::fs::File;
use std::io::{BufReader, BufWriter, Error as IoError, Seek, Write};
use std::path::Path;

/// Format of a picture file, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// 8-bit sRGB, as displayed over the background; alpha is the coverage, or 1 before an environment map or a background that was asked for.
    Png,
    /// Linear radiance, signed 32-bit float RGBA, before exposure; alpha is the coverage, and colours are premultiplied by it.
    Exr,
}

impl PictureFormat {
    /// Returns the format of a file name's extension.
    ///
    /// # Errors
    /// Neither .png nor .exr.
    pub fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(Error::usage(
                format!("{}: the format of the picture is not clear", path.display()),
                "name it .png or .exr",
            )),
        }
    }
}

/// Writes `picture` to `path`, whole or not at all. The same picture and notes give the same bytes.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, format: PictureFormat, picture: &Picture, notes: &Notes) -> Result<()> {
    written(path, |file| match format {
        PictureFormat::Png => png(file, picture, notes),
        PictureFormat::Exr => exr(file, picture, None, notes),
    })
}

/// Writes `picture` to `path` as an EXR whose channel Z has the `distances` of its pixels.
///
/// # Errors
/// A file that cannot be written.
pub fn write_with_distances(path: &Path, picture: &Picture, distances: &[f32], notes: &Notes) -> Result<()> {
    written(path, |file| exr(file, picture, Some(distances), notes))
}

/// Writes what `encode` encodes to `path`, whole or not at all.
fn written(
    path: &Path,
    encode: impl FnOnce(&mut BufWriter<&mut File>) -> std::result::Result<(), IoError>,
) -> Result<()> {
    output::write_atomically(path, |file| {
        let encoded = encode(file);
        // Encoders wrap the system's error in words about their format; flushing the rest returns that error again.
        encoded.map_err(|e| match file.flush() {
            Err(cause) => output::write_failed(path, cause),
            Ok(()) => output::write_failed(path, e),
        })
    })
}

/// Writes `picture` to `path` in the format of its extension, without notes.
///
/// # Errors
/// Those of [`PictureFormat::of`] and [`write()`].
pub fn save(path: impl AsRef<Path>, picture: &Picture) -> Result<()> {
    let path = path.as_ref();
    write(path, PictureFormat::of(path)?, picture, &Notes::default())
}

/// Returns the note `name` of the picture file `path`; `None` if there is none, or if the file is no picture that can be read.
pub fn note(path: &Path, name: &str) -> Option<String> {
    notes::value(&text_of(path)?, name).map(str::to_owned)
}

/// Returns all text of a picture file of this `format` with these `notes`, in the form of [`text_of`].
pub fn text(format: PictureFormat, notes: &Notes) -> String {
    match format {
        PictureFormat::Png => notes.text(),
        PictureFormat::Exr => notes::ascii(&notes.text()),
    }
}

/// Returns all text of the picture file `path`; `None` if the file is no picture that can be read.
pub fn text_of(path: &Path) -> Option<String> {
    match PictureFormat::of(path).ok()? {
        PictureFormat::Png => {
            let reader = png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
            let line = |chunk: &png::text_metadata::ITXtChunk| {
                Some(format!("{}: {}", chunk.keyword, chunk.get_text().ok()?))
            };
            let lines: Option<Vec<String>> = reader.info().utf8_text.iter().map(line).collect();
            Some(lines?.join("\n"))
        }
        PictureFormat::Exr => {
            let meta = exr::meta::MetaData::read_from_file(path, false).ok()?;
            Some(meta.headers.first()?.own_attributes.comments.as_ref()?.to_string())
        }
    }
}

/// Returns the pixels of `picture` as a file of this `format` stores them.
pub fn pixels(format: PictureFormat, picture: &Picture) -> Vec<u8> {
    match format {
        PictureFormat::Png => codes(picture),
        PictureFormat::Exr => bytemuck::cast_slice(&picture.radiance).to_vec(),
    }
}

/// Quotes `word` for a shell.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:+=@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

fn png(file: &mut impl Write, picture: &Picture, notes: &Notes) -> std::result::Result<(), IoError> {
    let [width, height] = picture.size;
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    notes.add_to_png(&mut encoder)?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&codes(picture))?;
    Ok(writer.finish()?)
}

/// Returns the RGBA of a PNG: the displayed colour over the background, and in alpha the coverage of each pixel by the mesh. A program that
/// drops alpha shows the whole picture with smooth edges. An environment map and a background that was asked for are opaque: every program shows them.
fn codes(picture: &Picture) -> Vec<u8> {
    let pixels = picture.display.iter().zip(&picture.radiance);
    let alpha = |coverage: f32| if picture.is_opaque { 255 } else { (coverage * 255.0).round() as u8 };
    pixels.flat_map(|(&[r, g, b, _], radiance)| [r, g, b, alpha(radiance[3])]).collect()
}

/// Encodes an EXR; `distances` of the pixels become its channel Z.
fn exr(
    file: &mut (impl Write + Seek),
    picture: &Picture,
    distances: Option<&[f32]>,
    notes: &Notes,
) -> std::result::Result<(), IoError> {
    let [width, height] = picture.size.map(|n| n as usize);
    let mut attributes = LayerAttributes::named("");
    attributes.software_name = Text::new_or_none(notes::software());
    // In one attribute: the library writes custom attributes in an order that changes from run to run.
    attributes.comments = Text::new_or_none(text(PictureFormat::Exr, notes));
    // In alphabetic order, as the format wants them.
    let number = |name: &str, samples| AnyChannel::new(name, FlatSamples::F32(samples));
    let color = |at: usize| picture.radiance.iter().map(|pixel| pixel[at]).collect();
    let mut channels =
        vec![number("A", color(3)), number("B", color(2)), number("G", color(1)), number("R", color(0))];
    channels.extend(distances.map(|distances| number("Z", distances.to_vec())));
    let channels = AnyChannels::sort(channels.into());
    // In order: tiles are compressed by several threads, and would be written in the order in which they finish.
    let encoding = Encoding { line_order: LineOrder::Increasing, ..Encoding::FAST_LOSSLESS };
    let image = Image::from_layer(Layer::new((width, height), attributes, encoding, channels));
    image.write().to_buffered(file).map_err(IoError::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(size: [u32; 2]) -> Picture {
        let count = (size[0] * size[1]) as usize;
        let number = |i: usize| (i as f32 * 0.37).sin();
        Picture {
            size,
            radiance: (0..count).map(|i| [number(i), -number(i + 1), 2.0, (i % 5) as f32 / 4.0]).collect(),
            display: (0..count).map(|i| [i as u8, (i / 7) as u8, 3, 255]).collect(),
            is_opaque: false,
        }
    }

    fn notes() -> Notes {
        Notes {
            command: "diffract render 'plätze' --surface 鱗.png".to_owned(),
            prepared: notes::PreparationRecord::parse("level plane, despike"),
            more: vec![
                ("Surface".to_owned(), "a hash".to_owned()),
                ("Tolerance".to_owned(), "1e-2".to_owned()),
            ],
        }
    }

    #[test]
    fn both_formats_hold_the_pixels_and_carry_every_note() {
        let folder = tempfile::tempdir().unwrap();
        let (as_png, as_exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
        let picture = picture([5, 3]);
        write(&as_png, PictureFormat::of(&as_png).unwrap(), &picture, &notes()).unwrap();
        write(&as_exr, PictureFormat::of(&as_exr).unwrap(), &picture, &notes()).unwrap();
        let image::DynamicImage::ImageRgba8(pixels) = image::open(&as_png).unwrap() else { panic!("RGBA") };
        assert!(pixels.pixels().zip(&picture.display).all(|(a, b)| a.0[..3] == b[..3]));
        // Alpha is the coverage.
        assert!(pixels.pixels().zip(&picture.radiance).all(|(a, b)| a.0[3] == (b[3] * 255.0).round() as u8));
        let radiance = image::open(&as_exr).unwrap().to_rgba32f();
        assert_eq!(radiance.as_raw(), bytemuck::cast_slice::<_, f32>(&picture.radiance));

        let reader = png::Decoder::new(BufReader::new(File::open(&as_png).unwrap()));
        let info = reader.read_info().unwrap();
        let said: Vec<_> =
            info.info().utf8_text.iter().map(|t| (t.keyword.clone(), t.get_text().unwrap())).collect();
        assert_eq!(said, notes().entries());
        let meta = exr::meta::MetaData::read_from_file(&as_exr, false).unwrap();
        let attributes = &meta.headers[0].own_attributes;
        assert!(attributes.software_name.as_ref().unwrap().to_string().starts_with("diffract "));
        let comments = attributes.comments.as_ref().unwrap().to_string();
        for path in [&as_png, &as_exr] {
            assert_eq!(note(path, "Surface").as_deref(), Some("a hash"));
            assert_eq!(note(path, "Prepared").as_deref(), Some("level plane, despike"));
            assert_eq!(note(path, "Sur"), None);
            let format = PictureFormat::of(path).unwrap();
            assert_eq!(text_of(path), Some(text(format, &notes())));
            std::fs::write(path, "no picture").unwrap();
            assert_eq!((note(path, "Surface"), text_of(path)), (None, None));
        }
        for part in ["diffract render 'pl\\u{e4}tze'", "\\u{9c57}.png", "\nSurface: a hash\nTolerance: 1e-2"]
        {
            assert!(comments.contains(part), "{comments}");
        }
    }

    #[test]
    fn an_exr_of_many_tiles_has_the_same_bytes_every_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        // 12 × 9 tiles, enough for threads to overtake each other.
        let picture = picture([740, 530]);
        let bytes = || {
            write(&path, PictureFormat::Exr, &picture, &notes()).unwrap();
            std::fs::read(&path).unwrap()
        };
        let first = bytes();
        for again in 0..6 {
            assert!(bytes() == first, "writing {again}");
        }
    }

    #[test]
    fn other_names_are_refused() {
        for name in ["a", "a.jpg", "png", "a.png.gz"] {
            assert_eq!(
                PictureFormat::of(Path::new(name)).unwrap_err().kind(),
                crate::error::ErrorKind::Usage,
                "{name}"
            );
        }
        assert_eq!(PictureFormat::of(Path::new("A.PNG")).unwrap(), PictureFormat::Png);
    }
}
