//! Settings at the start of the window.

use super::view_settings::ViewSettings;
use crate::context::Context;
use crate::error::Result;
use crate::scene::Scene;
use ash::vk;
use std::path::Path;
use std::sync::Arc;

/// Writes the command that draws the picture of settings of a scene. Supplied by the caller.
pub type CommandLine = fn(&ViewSettings, &Scene, &Output<'_>) -> String;

/// Output files of a command.
#[derive(Clone, Copy, Debug)]
pub struct Output<'a> {
    /// Size \[pixels\].
    pub size: [u32; 2],
    /// Path of the file; for a turntable, without the picture number.
    pub file: &'a str,
    /// Number of pictures of a turntable, if it is one.
    pub turntable: Option<u32>,
}

/// State kept from earlier windows: the last settings, and the recently opened files. The caller supplies storage and
/// format.
#[derive(Clone)]
pub struct LastView {
    /// True if a window was kept.
    pub is_kept: bool,
    /// Keeps the settings of a scene for the next window.
    pub keep: fn(&ViewSettings, &Scene) -> Result<()>,
    /// Returns the start settings of a window that restores the last one.
    pub open: Arc<dyn Fn() -> Result<Start> + Send + Sync>,
    /// Returns the recently opened files, newest first.
    pub recent: fn() -> Vec<String>,
    /// Keeps the list of recently opened files.
    pub keep_recent: fn(&[String]) -> Result<()>,
}

/// Returns the start settings of a window of the scene of a name. Supplied by the caller.
pub type OpenScene = dyn Fn(&str) -> Result<Start> + Send + Sync;

/// Reading and writing of scene files with all settings of a window. The caller supplies the format of their options.
#[derive(Clone)]
pub struct SceneFiles {
    /// Returns the start settings of a window of the scene of this name.
    pub open: Arc<OpenScene>,
    /// Writes the settings of a scene as a scene file.
    pub write: fn(&ViewSettings, &Scene, &Path) -> Result<()>,
}

/// Options of `diffract view`.
#[derive(Clone)]
pub struct Start {
    /// Settings of the picture.
    pub settings: ViewSettings,
    /// The scene without the options.
    pub plain: Scene,
    /// True if the exposure is measured on the first picture instead of taken from the scene.
    pub measures_exposure: bool,
    /// Size of the window \[points: pixels at a scale of 1\].
    pub size: [u32; 2],
    /// Target frame rate while something moves \[frames per second\].
    pub fps: f64,
    /// Presentation mode.
    pub present: vk::PresentModeKHR,
    /// Cache and choice of the device.
    pub context: Context,
    /// Writes the command of a saved picture.
    pub command_line: CommandLine,
    /// Scene files.
    pub scenes: SceneFiles,
    /// Last window, which can be restored.
    pub last: LastView,
}
