//! The pigment below what a surface reflects: a texture from a picture file.

use crate::error::{Error, Result};
use crate::input;
use std::io::Read;
use std::path::Path;

/// Largest side of a pigment texture \[pixels\].
const MAX_PIGMENT: u32 = 8192;

/// A pigment texture, row by row from the top.
#[derive(Clone, Debug)]
pub struct Pigment {
    /// Width and height.
    pub size: [u32; 2],
    /// sRGB-encoded RGBA texels.
    pub texels: Vec<u8>,
}

impl Pigment {
    /// One white texel: no pigment texture.
    pub fn white() -> Self {
        Self { size: [1, 1], texels: vec![255; 4] }
    }

    /// Whether it is anything but white all over, as far as one texel tells.
    pub fn is_textured(&self) -> bool {
        self.size != [1, 1] || self.texels != [255; 4]
    }

    /// The picture in the file `path`.
    ///
    /// # Errors
    /// Where it is no PNG or TIFF of a sensible size.
    pub fn read(path: &Path) -> Result<Self> {
        let mut bytes = Vec::new();
        let file = input::open(path, PIGMENT, input::MAX_TEXT)?;
        file.take(input::MAX_TEXT).read_to_end(&mut bytes).map_err(|e| no_pigment(&e).at(path.display()))?;
        Self::from_bytes(&bytes).map_err(|e| e.at(path.display()))
    }

    /// The picture in the bytes of a file.
    ///
    /// # Errors
    /// Where it is no PNG or TIFF of a sensible size.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        use image::ImageFormat::{Png, Tiff};
        let mut reader = image::ImageReader::new(std::io::Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|e| no_pigment(&e))?;
        if !matches!(reader.format(), Some(Png | Tiff)) {
            return Err(no_pigment(&"neither PNG nor TIFF"));
        }
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(MAX_PIGMENT);
        limits.max_image_height = Some(MAX_PIGMENT);
        reader.limits(limits);
        let picture = reader.decode().map_err(|e| no_pigment(&e))?.to_rgba8();
        Ok(Self { size: [picture.width(), picture.height()], texels: picture.into_raw() })
    }
}

/// What a pigment texture is.
const PIGMENT: &str = "a PNG or TIFF picture for the pigment";

fn no_pigment(cause: &dyn std::fmt::Display) -> Error {
    Error::failed(format!("it cannot be read as a picture ({cause})"), format!("give {PIGMENT}"))
}
