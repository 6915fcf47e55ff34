//! How the patch of a height field lies on a mesh, for the geometry pass: its twin is `groove_turn` of `shaders/geometry.frag`.

use crate::error::Result;
use crate::input::PictureFile;
use crate::scene::Grooves;
use half::f16;
use image::ImageFormat;
use std::f64::consts::TAU;
use std::path::Path;

/// Largest side of a map \[pixels\].
const MAX_MAP: u32 = 8192;

/// `GROOVES` of `shaders/geometry.frag`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Layout {
    /// x along T.
    Along = 0,
    /// x turned by one angle.
    Turned = 1,
    /// x away from the middle of the texture.
    Radial = 2,
    /// x turned by the angles of a map.
    Mapped = 3,
}

/// The directions of the patch's x in the tangent frame of a mesh.
#[derive(Clone, Debug)]
pub struct GrooveDirections {
    /// What they follow from.
    pub layout: Layout,
    /// Cosine and sine of the one angle.
    pub turn: [f32; 2],
    /// Width and height of the map.
    pub size: [u32; 2],
    /// The map: cosine and sine of each angle, row by row from the top.
    pub texels: Vec<[f16; 2]>,
}

impl GrooveDirections {
    /// x along T.
    pub fn along() -> Self {
        Self { layout: Layout::Along, turn: [1.0, 0.0], size: [1, 1], texels: vec![direction(0.0)] }
    }

    /// As `grooves` says.
    ///
    /// # Errors
    /// A map that cannot be read.
    pub fn of(grooves: &Grooves) -> Result<Self> {
        match grooves {
            Grooves::Along => Ok(Self::along()),
            Grooves::Turned(angle) => {
                let (sin, cos) = angle.to_radians().sin_cos();
                Ok(Self { layout: Layout::Turned, turn: [cos as f32, sin as f32], ..Self::along() })
            }
            Grooves::Radial => Ok(Self { layout: Layout::Radial, ..Self::along() }),
            Grooves::Map(file) => Self::read(file),
        }
    }

    fn read(path: &Path) -> Result<Self> {
        let decoded = MAP.decode(&MAP.read(path)?).map_err(|e| e.at(path.display()))?;
        let picture = decoded.into_luma16();
        let white = f64::from(u16::MAX);
        let texels = picture.pixels().map(|grey| direction(TAU * f64::from(grey.0[0]) / white)).collect();
        let size = [picture.width(), picture.height()];
        Ok(Self { layout: Layout::Mapped, size, texels, ..Self::along() })
    }
}

fn direction(angle: f64) -> [f16; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos, sin].map(f16::from_f64)
}

/// What a map of groove directions is.
const MAP: PictureFile = PictureFile {
    formats: &[ImageFormat::Png, ImageFormat::Tiff],
    names: "neither PNG nor TIFF",
    expected: "a grey PNG or TIFF picture for the directions of the grooves",
    role: "a picture",
    side: MAX_MAP,
};
