//! Pigment below the reflecting surface: a texture from a picture file.

use crate::error::Result;
use crate::input::PictureFile;
use image::ImageFormat;
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
    /// Returns one white texel: no pigment texture.
    pub fn white() -> Self {
        Self { size: [1, 1], texels: vec![255; 4] }
    }

    /// Returns true unless the texture is a single white texel.
    pub fn is_textured(&self) -> bool {
        self.size != [1, 1] || self.texels != [255; 4]
    }

    /// Reads the picture in the file `path`.
    ///
    /// # Errors
    /// Fails if it is not a PNG or TIFF picture of a valid size.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_bytes(&PIGMENT.read(path)?).map_err(|e| e.at(path.display()))
    }

    /// Decodes the picture in the bytes of a file.
    ///
    /// # Errors
    /// Fails if it is not a PNG or TIFF picture of a valid size.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let picture = PIGMENT.decode(bytes)?.to_rgba8();
        Ok(Self { size: [picture.width(), picture.height()], texels: picture.into_raw() })
    }
}

/// Accepted files of a pigment texture.
const PIGMENT: PictureFile = PictureFile {
    formats: &[ImageFormat::Png, ImageFormat::Tiff],
    names: "neither PNG nor TIFF",
    expected: "a PNG or TIFF picture for the pigment",
    role: "a picture",
    side: MAX_PIGMENT,
};
