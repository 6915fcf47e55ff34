//! Saves pictures together with the command that draws them.

use crate::error::{Error, Result};
use crate::output;
use crate::render::picture::Picture;
use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Text, WritableImage};
use std::path::{Path, PathBuf};

/// The first path of `diffract-001`, `diffract-002` … in `folder` that exists neither as PNG nor as EXR, without extension.
pub fn free_name(folder: &Path) -> PathBuf {
    let name = |number: u32| folder.join(format!("diffract-{number:03}"));
    let free = |path: &PathBuf| ["png", "exr"].iter().all(|e| !path.with_extension(e).exists());
    (1..).map(name).find(free).unwrap_or_else(|| name(0))
}

fn failed(path: &Path, e: &dyn std::fmt::Display) -> Error {
    Error::failed(format!("cannot be written ({e})"), "check the disk").at(path.display())
}

/// Writes the displayed `picture` as PNG, with `command` in a text chunk.
///
/// # Errors
/// Where the file cannot be written.
pub fn png(path: &Path, picture: &Picture, command: &str) -> Result<()> {
    let [width, height] = picture.size;
    let rgb: Vec<u8> = picture.display.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
    output::write_atomically(path, |file| {
        let mut encoder = png::Encoder::new(file, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        for (key, text) in texts(command) {
            encoder.add_itxt_chunk(key.to_owned(), text).map_err(|e| failed(path, &e))?;
        }
        let mut writer = encoder.write_header().map_err(|e| failed(path, &e))?;
        writer.write_image_data(&rgb).and_then(|()| writer.finish()).map_err(|e| failed(path, &e))
    })
}

/// Writes the radiance of `picture` as EXR, with `command` as a comment.
///
/// # Errors
/// Where the file cannot be written.
pub fn exr(path: &Path, picture: &Picture, command: &str) -> Result<()> {
    let [width, height] = picture.size.map(|n| n as usize);
    let [(_, software), (_, comment)] = texts(command);
    let mut attributes = LayerAttributes::named("");
    attributes.software_name = Text::new_or_none(&software);
    attributes.comments = Text::new_or_none(&comment);
    let channels = SpecificChannels::rgba(|at: exr::math::Vec2<usize>| {
        let [r, g, b, a] = picture.radiance[at.y() * width + at.x()];
        (r, g, b, a)
    });
    let image = Image::from_layer(Layer::new((width, height), attributes, Encoding::FAST_LOSSLESS, channels));
    output::write_atomically(path, |file| image.write().to_buffered(file).map_err(|e| failed(path, &e)))
}

/// Metadata of both formats: keys and texts.
fn texts(command: &str) -> [(&'static str, String); 2] {
    [
        ("Software", format!("diffract {}", env!("CARGO_PKG_VERSION"))),
        ("Comment", format!("The same picture: {command}")),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_free_and_pictures_carry_the_command() {
        let folder = tempfile::tempdir().unwrap();
        let first = free_name(folder.path());
        assert!(first.ends_with("diffract-001"));
        let picture = Picture {
            size: [2, 1],
            radiance: vec![[0.5, -0.25, 2.0, 1.0], [0.0; 4]],
            display: vec![[1, 2, 3, 255], [4, 5, 6, 255]],
        };
        let (as_png, as_exr) = (first.with_extension("png"), first.with_extension("exr"));
        png(&as_png, &picture, "diffract render 'plätze' -o a.png").unwrap();
        exr(&as_exr, &picture, "diffract render").unwrap();
        assert!(free_name(folder.path()).ends_with("diffract-002"));
        let read = image::open(&as_png).unwrap().to_rgb8();
        assert_eq!(read.as_raw(), &[1, 2, 3, 4, 5, 6]);
        let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&as_png).unwrap()));
        let info = reader.read_info().unwrap();
        let text: Vec<_> = info.info().utf8_text.iter().map(|t| t.get_text().unwrap()).collect();
        assert!(text.iter().any(|t| t.contains("'plätze'")), "{text:?}");
        let radiance = image::open(&as_exr).unwrap().to_rgba32f();
        assert_eq!(radiance.as_raw(), &[0.5, -0.25, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        let meta = exr::meta::MetaData::read_from_file(&as_exr, false).unwrap();
        let comment = meta.headers[0].own_attributes.comments.as_ref().map(ToString::to_string);
        assert!(comment.is_some_and(|c| c.contains("diffract render")));
    }
}
