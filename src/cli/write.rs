//! Results to files and to stdout.

use crate::error::{Error, Result};
use crate::output;
use crate::render::picture::Picture;
use image::{ExtendedColorType, ImageEncoder};
use std::io::Write;
use std::path::Path;

/// A picture file's format, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// 8-bit sRGB, as displayed over the background; alpha is the coverage.
    Png,
    /// Linear radiance, signed 32-bit float RGBA, before exposure; alpha is the coverage, and colours are premultiplied by it.
    Exr,
}

impl PictureFormat {
    /// The format that a file name asks for.
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

/// Writes `picture` whole or not at all.
pub fn picture(path: &Path, format: PictureFormat, picture: &Picture) -> Result<()> {
    let [width, height] = picture.size;
    output::write_atomically(path, |file| {
        let encoded = match format {
            PictureFormat::Png => image::codecs::png::PngEncoder::new(&mut *file).write_image(
                &codes(picture),
                width,
                height,
                ExtendedColorType::Rgba8,
            ),
            PictureFormat::Exr => image::codecs::openexr::OpenExrEncoder::new(&mut *file).write_image(
                bytemuck::cast_slice(&picture.radiance),
                width,
                height,
                ExtendedColorType::Rgba32F,
            ),
        };
        // Encoders wrap what the system says in words about their format; what is still to be written meets it again.
        encoded.map_err(|e| match file.flush() {
            Err(cause) => output::write_failed(path, &cause),
            Ok(()) => output::write_failed(path, &std::io::Error::other(e)),
        })
    })
}

/// RGBA of a PNG: what is displayed, over the background, and in alpha how much of each pixel the mesh covers. A program that drops alpha
/// shows the whole picture with smooth edges.
fn codes(picture: &Picture) -> Vec<u8> {
    let pixels = picture.display.iter().zip(&picture.radiance);
    pixels.flat_map(|(&[r, g, b, _], radiance)| [r, g, b, (radiance[3] * 255.0).round() as u8]).collect()
}

/// Writes a result to stdout. A closed pipe is not an error: the reader has what it wanted.
pub fn stdout(text: &str) -> Result<()> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::failed(format!("stdout cannot be written ({e})"), "check where it goes"))
        }
        _ => Ok(()),
    }
}

/// Writes a text result to the file `path`, whole or not at all, or to stdout.
pub fn text(path: Option<&Path>, text: &str) -> Result<()> {
    match path {
        None => stdout(text),
        Some(path) => output::write_atomically(path, |file| {
            file.write_all(text.as_bytes()).map_err(|e| output::write_failed(path, &e))
        }),
    }
}

/// Writes `report` as JSON to the file `path`.
pub fn json(path: &Path, report: &impl serde::Serialize) -> Result<()> {
    let json = serde_json::to_string_pretty(report).map_err(|e| {
        Error::failed(format!("the report is no JSON ({e})"), "report this as a bug of diffract")
    })?;
    text(Some(path), &(json + "\n"))
}
