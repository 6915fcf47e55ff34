//! Orientation of the patch of a height field on a mesh, for the geometry pass. The twin of
//! [`GrooveDirections::turn_at`] is `groove_turn` of `shaders/geometry.frag`.

use crate::error::Result;
use crate::input::PictureFile;
use crate::scene::Grooves;
use glam::DVec2;
use half::f16;
use image::ImageFormat;
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::LazyLock;

/// Largest side of a map \[pixels\].
const MAX_MAP: u32 = 8192;

/// `GROOVES` of `shaders/geometry.frag`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Layout {
    /// x along T.
    Along = 0,
    /// x turned by a constant angle.
    Turned = 1,
    /// x away from the centre of the texture.
    Radial = 2,
    /// x turned by the angles of a map.
    Mapped = 3,
}

/// The directions of the patch's x in the tangent frame of a mesh.
#[derive(Clone, Debug)]
pub struct GrooveDirections {
    /// Rule that gives the directions.
    pub layout: Layout,
    /// Cosine and sine of the constant angle.
    pub turn: [f32; 2],
    /// Width and height of the map \[texels\].
    pub size: [u32; 2],
    /// Map: cosine and sine of each angle, row by row from the top.
    pub texels: Vec<[f16; 2]>,
}

impl GrooveDirections {
    /// Returns directions with x along T.
    pub fn along() -> &'static Self {
        static ALONG: LazyLock<GrooveDirections> = LazyLock::new(|| GrooveDirections {
            layout: Layout::Along,
            turn: [1.0, 0.0],
            size: [1, 1],
            texels: vec![direction(0.0)],
        });
        &ALONG
    }

    /// Returns the directions that `grooves` describes.
    ///
    /// # Errors
    /// Fails if a map cannot be read.
    pub fn of(grooves: &Grooves) -> Result<Self> {
        match grooves {
            Grooves::Along => Ok(Self::along().clone()),
            Grooves::Turned(angle) => {
                let (sin, cos) = angle.to_radians().sin_cos();
                Ok(Self { layout: Layout::Turned, turn: [cos as f32, sin as f32], ..Self::along().clone() })
            }
            Grooves::Radial => Ok(Self { layout: Layout::Radial, ..Self::along().clone() }),
            Grooves::Map(file) => Self::read(file),
        }
    }

    /// Returns the unit vector along the patch's x in the tangent frame at the texture coordinates `uv`.
    pub fn turn_at(&self, uv: DVec2) -> DVec2 {
        let turn = match self.layout {
            Layout::Along => DVec2::X,
            Layout::Turned => DVec2::new(self.turn[0].into(), self.turn[1].into()),
            Layout::Radial => uv - 0.5,
            Layout::Mapped => self.between_texels(uv),
        };
        turn.try_normalize().unwrap_or(DVec2::X)
    }

    /// Interpolates the map linearly at `uv`, whose v grows upward. The map repeats.
    fn between_texels(&self, uv: DVec2) -> DVec2 {
        let size = DVec2::new(self.size[0].into(), self.size[1].into());
        // Relative to the centre of the first texel.
        let place = DVec2::new(uv.x, 1.0 - uv.y) * size - 0.5;
        let (corner, share) = (place.floor(), place - place.floor());
        let texel = |right: f64, down: f64| {
            let [column, row] = [(corner.x + right).rem_euclid(size.x), (corner.y + down).rem_euclid(size.y)];
            let [cosine, sine] = self.texels[row as usize * self.size[0] as usize + column as usize];
            DVec2::new(cosine.to_f64(), sine.to_f64())
        };
        let along = |down| texel(0.0, down).lerp(texel(1.0, down), share.x);
        along(0.0).lerp(along(1.0), share.y)
    }

    fn read(path: &Path) -> Result<Self> {
        let decoded = MAP.decode(&MAP.read(path)?).map_err(|e| e.at(path.display()))?;
        let picture = decoded.into_luma16();
        let white = f64::from(u16::MAX);
        let texels = picture.pixels().map(|grey| direction(TAU * f64::from(grey.0[0]) / white)).collect();
        let size = [picture.width(), picture.height()];
        Ok(Self { layout: Layout::Mapped, size, texels, ..Self::along().clone() })
    }
}

fn direction(angle: f64) -> [f16; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos, sin].map(f16::from_f64)
}

/// Accepted files of a map of groove directions.
const MAP: PictureFile = PictureFile {
    formats: &[ImageFormat::Png, ImageFormat::Tiff],
    names: "neither PNG nor TIFF",
    expected: "a grey PNG or TIFF picture for the directions of the grooves",
    role: "a picture",
    side: MAX_MAP,
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_read_from_the_top_between_texels_and_repeats() {
        let texels = [0.0, 90.0, 180.0, 270.0].map(|angle: f64| direction(angle.to_radians())).to_vec();
        let map = GrooveDirections {
            layout: Layout::Mapped,
            size: [2, 2],
            texels,
            ..GrooveDirections::along().clone()
        };
        let near = |uv: [f64; 2], angle: f64| {
            let found = map.turn_at(uv.into());
            assert!((found - DVec2::from_angle(angle.to_radians())).length() < 1e-3, "{uv:?}: {found}");
        };
        // v grows upward, rows downward.
        near([0.25, 0.75], 0.0);
        near([0.75, 0.75], 90.0);
        near([0.25, 0.25], 180.0);
        near([1.75, -0.75], 270.0);
        near([0.5, 0.75], 45.0);
        near([1.0, 1.75], 45.0);
    }
}
