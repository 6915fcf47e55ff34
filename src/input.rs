//! Reading of untrusted files: only regular files of a sensible size.

use crate::error::{self, Error, Result};
use exr::math::Vec2;
use exr::meta::{BlockDescription, MetaData};
use image::{DynamicImage, ImageFormat, ImageReader};
use std::fmt;
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

/// Largest text input (tables, queries, scenes) \[bytes\]: about ten million numbers.
pub const MAX_TEXT: u64 = 256 << 20;

/// Opens a regular file of at most `limit` bytes; a folder, a pipe or a device is refused before it can block.
///
/// # Errors
/// Another kind of file at `path`; the message names it and the `expected` kind.
pub fn open(path: &Path, expected: &str, limit: u64) -> Result<File> {
    let place = path.display();
    let describe = |e: std::io::Error| {
        let reason = match e.kind() {
            std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
            std::io::ErrorKind::PermissionDenied => "it may not be read".to_owned(),
            _ => format!("it cannot be read: {}", error::cause(&e)),
        };
        Error::files(reason, format!("give {expected}")).caused_by(e).at(&place)
    };
    let metadata = std::fs::metadata(path).map_err(describe)?;
    if !metadata.is_file() {
        let what = if metadata.is_dir() { "it is a folder" } else { "it is not a regular file" };
        return Err(Error::input(what, format!("give {expected}")).at(&place));
    }
    if metadata.len() > limit {
        return Err(Error::input(
            format!("it has {} bytes, more than the {limit} that are read", metadata.len()),
            format!("give {expected}"),
        )
        .at(&place));
    }
    File::open(path).map_err(describe)
}

/// Reads the whole text of a file of at most [`MAX_TEXT`] bytes.
///
/// # Errors
/// Those of [`open`]; content that is not UTF-8.
pub fn read_text(path: &Path, expected: &str) -> Result<String> {
    // The file may grow while it is read, so the limit applies to the read bytes as well.
    text_of(open(path, expected, MAX_TEXT)?, expected).map_err(|e| e.at(path.display()))
}

/// Reads the whole text of a stream of at most [`MAX_TEXT`] bytes.
///
/// # Errors
/// A stream that cannot be read or is longer; content that is not UTF-8.
pub fn text_of(stream: impl Read, expected: &str) -> Result<String> {
    let mut text = String::new();
    stream.take(MAX_TEXT + 1).read_to_string(&mut text).map_err(|e| {
        let (what, remedy) = (format!("it is not text ({e})"), format!("give {expected}"));
        let is_not_text = e.kind() == std::io::ErrorKind::InvalidData;
        let error = if is_not_text { Error::input(what, remedy) } else { Error::files(what, remedy) };
        error.caused_by(e)
    })?;
    if text.len() as u64 > MAX_TEXT {
        return Err(Error::input(
            format!("it has more than the {MAX_TEXT} bytes that are read"),
            format!("give {expected}"),
        ));
    }
    Ok(text)
}

/// Requirements on a picture file.
#[derive(Clone, Copy, Debug)]
pub struct PictureFile {
    /// Formats.
    pub formats: &'static [ImageFormat],
    /// Words for a file of another format, as in `neither PNG nor TIFF`.
    pub names: &'static str,
    /// Words for the expected file, as in `a picture for the pigment`.
    pub expected: &'static str,
    /// Words for the use of the file, as in `a picture`.
    pub role: &'static str,
    /// Largest side \[pixels\].
    pub side: u32,
}

impl PictureFile {
    /// Reads the whole content of the file `path`.
    ///
    /// # Errors
    /// Those of [`open`].
    pub fn read(&self, path: &Path) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let file = open(path, self.expected, MAX_TEXT)?;
        file.take(MAX_TEXT).read_to_end(&mut bytes).map_err(|e| self.unreadable(e).at(path.display()))?;
        Ok(bytes)
    }

    /// Returns width and height of the picture in `bytes`, from its header.
    ///
    /// # Errors
    /// Another format or no header.
    pub fn size(&self, bytes: &[u8]) -> Result<[u32; 2]> {
        self.reader(bytes)?
            .into_dimensions()
            .map(|(width, height)| [width, height])
            .map_err(|e| self.refuse(&e).caused_by(e))
    }

    /// Decodes the picture in `bytes`.
    ///
    /// # Errors
    /// Another format, a larger side, damage.
    pub fn decode(&self, bytes: &[u8]) -> Result<DynamicImage> {
        let mut reader = self.reader(bytes)?;
        if reader.format() == Some(ImageFormat::OpenExr) {
            self.check_stored(bytes)?;
        }
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(self.side);
        limits.max_image_height = Some(self.side);
        reader.limits(limits);
        reader.decode().map_err(|e| self.refuse(&e).caused_by(e))
    }

    /// Fails for an EXR file that stores far more than its display window, or in blocks that are larger than the picture: its decoder
    /// allocates them without asking.
    fn check_stored(&self, bytes: &[u8]) -> Result<()> {
        /// Largest ratio of the stored pixels to those of the display window.
        const OVERSCAN: u64 = 4;
        /// Pixels of the largest tile in which a smaller picture may be stored.
        const TILE: u64 = 1 << 20;
        let meta = MetaData::read_from_buffered(bytes, false).map_err(|e| self.refuse(&e).caused_by(e))?;
        let area = |size: Vec2<usize>| (size.0 as u64).saturating_mul(size.1 as u64);
        for header in &meta.headers {
            let (shown, stored) =
                (area(header.shared_attributes.display_window.size), area(header.layer_size));
            let block = match header.blocks {
                BlockDescription::Tiles(tiles) => area(tiles.tile_size),
                BlockDescription::ScanLines => stored,
            };
            if stored > shown.saturating_mul(OVERSCAN) || block > stored.max(TILE) {
                let cause =
                    format!("it shows {shown} pixels and stores {stored}, in blocks of up to {block}");
                return Err(self.refuse(&cause));
            }
        }
        Ok(())
    }

    fn reader<'a>(&self, bytes: &'a [u8]) -> Result<ImageReader<Cursor<&'a [u8]>>> {
        let reader = ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|e| self.refuse(&e).caused_by(e))?;
        match reader.format() {
            Some(format) if self.formats.contains(&format) => Ok(reader),
            _ => Err(self.refuse(&self.names)),
        }
    }

    /// Returns the error for a content that is refused for `cause`.
    fn refuse(&self, cause: &dyn fmt::Display) -> Error {
        Error::input(self.refusal(cause), format!("give {}", self.expected))
    }

    /// Returns the error for a file that the system does not read.
    fn unreadable(&self, cause: std::io::Error) -> Error {
        Error::files(self.refusal(&cause), format!("give {}", self.expected)).caused_by(cause)
    }

    fn refusal(&self, cause: &dyn fmt::Display) -> String {
        format!("it cannot be read as {} ({cause})", self.role)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_missing_files_and_binary_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        assert!(read_text(folder.path(), "x").unwrap_err().to_string().contains("folder"));
        assert!(read_text(&folder.path().join("no"), "x").unwrap_err().to_string().contains("no such file"));
        let binary = folder.path().join("b");
        std::fs::write(&binary, [0xff, 0xfe, 0x00]).unwrap();
        assert!(read_text(&binary, "x").unwrap_err().to_string().contains("not text"));
        assert!(open(&binary, "x", 2).unwrap_err().to_string().contains("3 bytes"));
        assert!(
            read_text(Path::new("/dev/zero"), "x").unwrap_err().to_string().contains("not a regular file")
        );
    }
}
