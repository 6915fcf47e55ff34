//! The pigment below what a surface reflects: a texture from a picture file.

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
        Self::from_bytes(&PIGMENT.read(path)?).map_err(|e| e.at(path.display()))
    }

    /// The picture in the bytes of a file.
    ///
    /// # Errors
    /// Where it is no PNG or TIFF of a sensible size.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let picture = PIGMENT.decode(bytes)?.to_rgba8();
        Ok(Self { size: [picture.width(), picture.height()], texels: picture.into_raw() })
    }
}

/// What a pigment texture is.
const PIGMENT: PictureFile = PictureFile {
    formats: &[ImageFormat::Png, ImageFormat::Tiff],
    names: "neither PNG nor TIFF",
    expected: "a PNG or TIFF picture for the pigment",
    role: "a picture",
    side: MAX_PIGMENT,
};
