//! A frame of the scene: what it is drawn from, how it is asked for, what comes back.

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

/// A scene with its textures read, ready for upload.
pub struct LoadedScene {
    /// The scene.
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

/// A frame to draw.
#[derive(Clone)]
pub struct FrameRequest {
    /// Mesh and pigment.
    pub loaded: Arc<LoadedScene>,
    /// The user's setting.
    pub own: Arc<Prepared>,
    /// The setting to compare with.
    pub other: Option<Arc<Prepared>>,
    /// A cheaper setting that replaces `own` at this quality.
    pub lighter: Option<Arc<Prepared>>,
    /// How much of the work is done.
    pub quality: Quality,
    /// Whether camera or lights are moving. Such a frame is finished before a newer request is taken, unless it takes too
    /// long.
    pub moving: bool,
    /// Whether to draw even if the same picture is on the device already.
    pub again: bool,
    /// Camera, lights, pigment.
    pub view: View,
    /// How it is displayed.
    pub shown: Shown,
    /// Whether its exposure is to be measured, and not that of `shown`.
    pub measured: bool,
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// What is shown right of the split.
    pub compare: Compare,
    /// Samples that are summed once the first one is shown.
    pub sampling: Sampling,
    /// The BRDF over the hemisphere, if that is to be shown.
    pub inset: Option<InsetRequest>,
}

impl FrameRequest {
    /// Whether `other` asks for the same image at the same quality.
    pub fn shows_the_same_as(&self, other: &Self) -> bool {
        let number = |p: &Option<Arc<Prepared>>| p.as_ref().map(|p| p.number);
        Arc::ptr_eq(&self.loaded, &other.loaded)
            && self.own.number == other.own.number
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

    /// Whether an error that was measured on the picture of `other` holds for this one too.
    pub fn has_the_radiance_of(&self, other: &Self) -> bool {
        self.view == other.view && self.own.number == other.own.number && self.size == other.size
    }
}

/// State of the scene while a frame was drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Camera or lights moved, and the frame had to keep to the budget.
    Moving,
    /// Nothing moved, and the frame took the time that it needed.
    AtRest,
}

/// A frame on the device, ready to be presented.
#[derive(Clone)]
pub struct RenderedFrame {
    /// The picture, and the one right of the split.
    pub images: [Arc<Image>; 2],
    /// Pixels drawn of each.
    pub sizes: [[u32; 2]; 2],
    /// How much of the work was done.
    pub quality: Quality,
    /// Time on the device \[ms\]; 0 when only the display changed.
    pub gpu_ms: f64,
    /// Elapsed time \[ms\].
    pub wall_ms: f64,
    /// Whether it is the first frame of its painter, which includes one-off work of the driver.
    pub first: bool,
    /// State of the scene for which it was drawn.
    pub pace: Pace,
    /// Samples that it is the mean of.
    pub samples: u32,
    /// Cost of the whole picture, if it was counted.
    pub cost: Option<PictureCost>,
    /// The exposure \[stops\], where it was measured.
    pub exposure: Option<f64>,
    /// The hemisphere, if it was asked for.
    pub inset: Option<Arc<Inset>>,
    /// How far the two pictures are apart, where their difference is shown.
    pub difference: Option<f64>,
    /// [`Prepared::number`] of the setting shown.
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

    /// A frame of the plate in its pigment.
    pub fn request() -> FrameRequest {
        let (settings, scene) = crate::viewer::settings_of_a_plate();
        FrameRequest {
            view: View::of(&scene, scene.lights.clone()),
            loaded: Arc::new(LoadedScene::of(scene).unwrap()),
            own: Arc::new(Prepared::pigment_alone().unwrap()),
            other: None,
            lighter: None,
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
