//! Projections of cameras.

use crate::error::{Error, Result};
use glam::{DMat4, DVec4};

/// Projection of a camera, its roll, and the shift of its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Perspective or orthographic projection.
    pub projection: LensProjection,
    /// Rotation of the camera about its axis, clockwise as its user sees it \[rad\].
    pub roll: f32,
    /// Offset of the picture's middle from the axis, to the right and up \[heights of the picture\].
    pub shift: [f32; 2],
}

/// Projection onto the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LensProjection {
    /// Lines of sight meet in the eye.
    Perspective {
        /// Vertical field of view of a picture without shift \[rad\].
        field_of_view: f32,
    },
    /// Lines of sight are parallel.
    Orthographic {
        /// Height of what the picture shows \[units of the scene\].
        height: f32,
    },
}

impl LensProjection {
    /// Returns the height of what the picture shows at `distance` from the eye.
    pub fn height_at(&self, distance: f32) -> f32 {
        match self {
            Self::Perspective { field_of_view } => 2.0 * distance * (field_of_view / 2.0).tan(),
            Self::Orthographic { height } => *height,
        }
    }
}

impl Lens {
    /// Largest shift \[heights of the picture\].
    const MOST_SHIFT: f32 = 100.0;

    /// Returns a lens of a vertical `field_of_view` \[rad\], without roll and shift.
    pub fn perspective(field_of_view: f32) -> Self {
        Self { projection: LensProjection::Perspective { field_of_view }, roll: 0.0, shift: [0.0; 2] }
    }

    /// Returns a lens whose lines of sight are parallel, for pictures of this `height` \[units of the scene\], without roll and shift.
    pub fn orthographic(height: f32) -> Self {
        Self { projection: LensProjection::Orthographic { height }, roll: 0.0, shift: [0.0; 2] }
    }

    /// Fails if a number is out of range.
    ///
    /// # Errors
    /// A field of view not within 1° to 170°, a height that is not positive, a roll or shift that is not finite or large.
    pub fn check(&self) -> Result<()> {
        match self.projection {
            LensProjection::Perspective { field_of_view }
                if !(1f32.to_radians()..=170f32.to_radians()).contains(&field_of_view) =>
            {
                return Err(Error::usage(
                    "the field of view is not within 1deg to 170deg",
                    "35deg is a good start",
                ));
            }
            LensProjection::Orthographic { height } if !(height > 0.0 && height.is_finite()) => {
                return Err(Error::usage(
                    "the height of an orthographic picture is not a positive number",
                    "give it in the scene's units, as in 2",
                ));
            }
            _ => {}
        }
        if !self.roll.is_finite() {
            return Err(Error::usage("the roll of the camera is no angle", "0deg is upright"));
        }
        if !self.shift.iter().all(|s| s.abs() <= Self::MOST_SHIFT) {
            return Err(Error::usage(
                format!(
                    "the shift of the lens is not within -{0} to {0} heights of the picture",
                    Self::MOST_SHIFT
                ),
                "0,0 is no shift",
            ));
        }
        Ok(())
    }

    /// Returns the matrix from the axes right, up and toward the viewer to Vulkan clip space (y down), for a picture of `size` pixels. What
    /// is `near` before the eye has depth 0, what is `far` has 1.
    pub(super) fn clip_from_view(&self, size: [u32; 2], near: f64, far: f64) -> DMat4 {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        // Clip space is two units wide and high.
        let shift = [-2.0 * f64::from(self.shift[0]) / aspect, 2.0 * f64::from(self.shift[1])];
        match self.projection {
            LensProjection::Perspective { field_of_view } => {
                let scale = 1.0 / (f64::from(field_of_view) / 2.0).tan();
                let depth = far / (near - far);
                DMat4::from_cols(
                    DVec4::new(scale / aspect, 0.0, 0.0, 0.0),
                    DVec4::new(0.0, -scale, 0.0, 0.0),
                    DVec4::new(-shift[0], -shift[1], depth, -1.0),
                    DVec4::new(0.0, 0.0, near * depth, 0.0),
                )
            }
            LensProjection::Orthographic { height } => {
                let scale = 2.0 / f64::from(height);
                let depth = 1.0 / (near - far);
                DMat4::from_cols(
                    DVec4::new(scale / aspect, 0.0, 0.0, 0.0),
                    DVec4::new(0.0, -scale, 0.0, 0.0),
                    DVec4::new(0.0, 0.0, depth, 0.0),
                    DVec4::new(shift[0], shift[1], near * depth, 1.0),
                )
            }
        }
    }
}
