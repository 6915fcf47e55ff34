//! What the window starts with.

use super::settings::{OpticsSettings, ViewSettings, placement};
use crate::error::Result;
use crate::optics::coherence::{Beyond, Coherence, Windows};
use crate::optics::reflectance::Reflectance;
use crate::scene::Scene;
use crate::spectra::amplitude::expansion::Basis;
use crate::surface::SurfaceSource;
use crate::vk::selection::DeviceChoice;
use ash::vk;
use std::path::Path;

/// Writes the command that draws the picture of settings of a scene. The words are the caller's.
pub type CommandLine = fn(&ViewSettings, &Scene, &Output<'_>) -> String;

/// What a command draws into files.
#[derive(Clone, Copy, Debug)]
pub struct Output<'a> {
    /// Pixels.
    pub size: [u32; 2],
    /// The file; of a turntable, its name without numbers.
    pub file: &'a str,
    /// Pictures of a turntable, where it is one.
    pub turntable: Option<u32>,
}

/// The window that was closed last, and the files that were opened in it and before. Where and in which words they are kept is the caller's.
#[derive(Clone, Copy, Debug)]
pub struct LastView {
    /// Whether there was one.
    pub is_kept: bool,
    /// Keeps the settings of a scene for the next window.
    pub keep: fn(&ViewSettings, &Scene) -> Result<()>,
    /// What a window that goes on with it starts with.
    pub open: fn() -> Result<Start>,
    /// The files that were opened lately, the newest first.
    pub recent: fn() -> Vec<String>,
    /// Keeps the list of files that were opened lately.
    pub keep_recent: fn(&[String]) -> Result<()>,
}

/// Scene files with all that a window sets. The words of their options are the caller's.
#[derive(Clone, Copy, Debug)]
pub struct SceneFiles {
    /// What a window of the scene of this name starts with.
    pub open: fn(&str) -> Result<Start>,
    /// Writes settings of a scene as a scene file.
    pub write: fn(&ViewSettings, &Scene, &Path) -> Result<()>,
}

/// The options of `diffract view`.
#[derive(Clone, Debug)]
pub struct Start {
    /// Name of the scene.
    pub name: String,
    /// The scene with the options applied.
    pub scene: Scene,
    /// The scene without the options.
    pub plain: Scene,
    /// The height field.
    pub surface: SurfaceSource,
    /// Positions of the coherence window.
    pub windows: Windows,
    /// How the surface goes on beyond the patch.
    pub beyond: Beyond,
    /// The basis.
    pub basis: Basis,
    /// Accepted relative error.
    pub tolerance: f64,
    /// Number of terms; `None` follows from the tolerance.
    pub terms: Option<usize>,
    /// Number of wavelengths; `None` follows from the tolerance.
    pub wavelengths: Option<usize>,
    /// What surrounds the patch.
    pub coherence: Coherence,
    /// What the surface reflects.
    pub reflectance: Reflectance,
    /// Spectrum of the light: a name or a file.
    pub illuminant: String,
    /// Whether the exposure is that which suits the first picture, instead of the scene's.
    pub measures_exposure: bool,
    /// Size of the window \[points: pixels at a scale of 1\].
    pub size: [u32; 2],
    /// Samples that each pixel of a still picture is the mean of.
    pub samples: u32,
    /// Frames a second to keep while something moves.
    pub fps: f64,
    /// Presentation mode.
    pub present: vk::PresentModeKHR,
    /// The device to use.
    pub device: DeviceChoice,
    /// Whether to enable validation layers.
    pub validation: bool,
    /// How the command of a saved picture is written.
    pub command_line: CommandLine,
    /// Scene files.
    pub scenes: SceneFiles,
    /// The window that was closed last.
    pub last: LastView,
}

impl Start {
    /// The settings to start with.
    pub fn settings(&self) -> ViewSettings {
        ViewSettings {
            scene: self.name.clone(),
            surface: self.surface.clone(),
            optics: OpticsSettings {
                windows: self.windows,
                basis: self.basis,
                tolerance: self.tolerance,
                terms: self.terms,
                wavelengths: self.wavelengths,
            },
            coherence: self.coherence,
            beyond: self.beyond,
            reflectance: self.reflectance.clone(),
            illuminant: self.illuminant.clone(),
            lights: self.scene.lights.clone(),
            surroundings: placement(&self.scene),
            exposure: self.scene.exposure,
            tone: self.scene.tone,
            base_color: self.scene.base_color,
            camera: self.scene.camera,
            samples: self.samples,
        }
    }
}
