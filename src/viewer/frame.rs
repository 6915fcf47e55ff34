//! Frame of the scene: its data, the request for it, and the result.

use super::compare::Compare;
use super::inset::{Inset, InsetRequest};
use super::prepared::Prepared;
use super::quality::Quality;
use crate::error::Result;
use crate::render::frame::{Shown, View};
use crate::render::object::ObjectTextures;
use crate::render::sampling::Sampling;
use crate::scene::Scene;
use crate::vk::image::Image;
use std::sync::Arc;

/// Scene with its textures read, ready for upload.
pub struct LoadedScene {
    /// Scene.
    pub scene: Scene,
    /// Textures of its objects, the first object first.
    pub textures: Vec<ObjectTextures>,
}

impl LoadedScene {
    /// Reads the textures of `scene`.
    ///
    /// # Errors
    /// Fails if a texture cannot be read.
    pub fn of(scene: Scene) -> Result<Self> {
        Ok(Self { textures: ObjectTextures::of(&scene)?, scene })
    }
}

/// Frame to draw.
#[derive(Clone)]
pub struct FrameRequest {
    /// Mesh and pigment.
    pub loaded: Arc<LoadedScene>,
    /// Main setting, left of the split.
    pub full: Arc<Prepared>,
    /// Setting to compare with, right of the split.
    pub other: Option<Arc<Prepared>>,
    /// Resolution.
    pub quality: Quality,
    /// True if camera or lights are moving, or if no frame of their present positions is shown yet. Such a frame is
    /// finished before a newer request is taken, unless it takes too long and there is a lower resolution.
    pub moving: bool,
    /// True to draw even if the same picture is on the device already, as continuous drawing does.
    pub again: bool,
    /// Camera, lights, pigment.
    pub view: View,
    /// Display settings.
    pub shown: Shown,
    /// True if the exposure is to be measured instead of taken from `shown`.
    pub measured: bool,
    /// Size of the picture \[pixels\].
    pub size: [u32; 2],
    /// Mode of the comparison.
    pub compare: Compare,
    /// Samples to sum once the first one is shown.
    pub sampling: Sampling,
    /// Hemisphere inset, if requested.
    pub inset: Option<InsetRequest>,
}

impl FrameRequest {
    /// Returns true if `other` requests the same image at the same quality.
    pub fn shows_the_same_as(&self, other: &Self) -> bool {
        let number = |p: &Option<Arc<Prepared>>| p.as_ref().map(|p| p.number);
        Arc::ptr_eq(&self.loaded, &other.loaded)
            && self.full.number == other.full.number
            && number(&self.other) == number(&other.other)
            && self.compare == other.compare
            && self.quality == other.quality
            && self.moving == other.moving
            && self.size == other.size
            && self.inset == other.inset
            && self.sampling == other.sampling
            && self.shown == other.shown
            && self.measured == other.measured
            && self.view == other.view
    }

    /// Returns true if `frame` shows camera and lights as they are in this request, in a picture of the same size.
    pub fn is_seen_in(&self, frame: &RenderedFrame) -> bool {
        frame.view == self.view && frame.size == self.size
    }

    /// Returns true if an error measured on the picture of `other` is valid for this one too.
    pub fn has_the_radiance_of(&self, other: &Self) -> bool {
        self.view == other.view && self.full.number == other.full.number && self.size == other.size
    }
}

/// Motion of the scene while a frame was drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Camera or lights moved, and the frame had to keep to the time budget.
    Moving,
    /// Nothing moved, and the frame had no time limit.
    AtRest,
}

/// Frame on the device, ready to be presented.
#[derive(Clone)]
pub struct RenderedFrame {
    /// Pictures left and right of the split.
    pub images: [Arc<Image>; 2],
    /// Drawn size of each \[pixels\].
    pub sizes: [[u32; 2]; 2],
    /// Resolution of the frame.
    pub quality: Quality,
    /// Camera, lights and pigment.
    pub view: View,
    /// Size of the picture at full resolution \[pixels\].
    pub size: [u32; 2],
    /// Time on the device \[ms\]; 0 if only the display changed.
    pub gpu_ms: f64,
    /// Elapsed time \[ms\].
    pub wall_ms: f64,
    /// True for the first frame of its renderer, which includes one-off work of the driver.
    pub first: bool,
    /// Motion of the scene.
    pub pace: Pace,
    /// Number of samples in the mean.
    pub samples: u32,
    /// Cost of the whole picture, if it was counted.
    pub cost: Option<PictureCost>,
    /// Exposure \[stops\], if it was measured.
    pub exposure: Option<f64>,
    /// Hemisphere inset, if it was requested.
    pub inset: Option<Arc<Inset>>,
    /// Difference of the two pictures, if it is shown.
    pub difference: Option<f64>,
    /// [`Prepared::number`] of the displayed setting.
    pub number: u64,
}

/// Cost of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureCost {
    /// Fraction of the picture that the mesh covers.
    pub covered: f64,
    /// Wavelengths per covered pixel.
    pub wavelengths: f64,
    /// Texture samples per covered pixel.
    pub samples: f64,
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use glam::DVec3;

    /// Returns a request for a frame of the plate in its pigment.
    pub fn request() -> FrameRequest {
        let (settings, scene) = crate::viewer::settings_of_a_plate();
        FrameRequest {
            view: View::of(&scene, scene.lights.clone()),
            loaded: Arc::new(LoadedScene::of(scene).unwrap()),
            full: Arc::new(Prepared::pigment_alone().unwrap()),
            other: None,
            quality: Quality::WHOLE,
            moving: false,
            again: false,
            shown: Shown { exposure: settings.exposure, tone: settings.tone, background: DVec3::ZERO },
            measured: false,
            size: [64, 48],
            compare: Compare::Alone,
            sampling: Sampling { count: 4, seed: 1 },
            inset: None,
        }
    }
}
