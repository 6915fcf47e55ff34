//! The window: winit events, a panel of egui, and the frames that `render` draws.
//!
//! Three threads beside the window's own: `worker` makes layers, `studio` draws the scene, `judge` measures errors. They
//! say what they have done by events; the window's thread never waits for them.

mod app;
pub mod atlas;
mod compare;
mod easel;
mod graph;
#[allow(unsafe_code, reason = "hands Vulkan objects to the panel's renderer")]
pub mod gui;
mod hand;
mod inset;
mod judge;
mod live;
mod model;
mod orbit;
mod overlay;
mod pace;
mod panel;
mod save;
mod screen;
mod settings;
mod studio;
mod style;
mod words;
mod worker;

use crate::error::{Error, Result};
use crate::expansion::Basis;
use crate::optics::coherence::Coherence;
use crate::render::color_table::Filter;
use crate::render::pigment::Pigment;
use crate::render::resources::Reads;
use crate::scene::Scene;
use crate::surface::Source;
use crate::vk::instance::Instance;
use crate::vk::selection::Wish;
use ash::vk;
use settings::{Optics, Settings};
use std::sync::Arc;
use studio::Stage;
use winit::event_loop::EventLoop;

/// Everything that the command line says.
#[derive(Clone, Debug)]
pub struct Start {
    /// Name of the scene.
    pub name: String,
    /// The scene, options applied.
    pub scene: Scene,
    /// The scene as it is without options.
    pub plain: Scene,
    /// The height field.
    pub surface: Source,
    /// By which method.
    pub method: Reads,
    /// What a pixel of a colour table shows.
    pub filter: Filter,
    /// Window centres that a colour table averages over.
    pub windows: [u32; 2],
    /// The basis.
    pub basis: Basis,
    /// Relative error that the user accepts.
    pub tolerance: f64,
    /// Terms, where the user names them.
    pub terms: Option<usize>,
    /// Wavelengths, where the user names them.
    pub wavelengths: Option<usize>,
    /// What surrounds the patch.
    pub coherence: Coherence,
    /// Refractive index.
    pub ior: f64,
    /// The light's spectrum: a name or a file.
    pub illuminant: String,
    /// Size of the window \[pixels\].
    pub size: [u32; 2],
    /// Frames a second that are wanted while something moves.
    pub fps: f64,
    /// How frames are presented.
    pub present: vk::PresentModeKHR,
    /// Which device.
    pub wish: Wish,
    /// Whether validation listens.
    pub validation: bool,
}

/// Opens the window and returns when it is closed, with what validation had to say.
///
/// # Errors
/// No display, no device that shows windows, a device that is lost.
pub fn run(start: Start) -> Result<Vec<String>> {
    check_display(|name| std::env::var_os(name).is_some_and(|v| !v.is_empty()))?;
    let no_display = |e: &dyn std::fmt::Display| {
        let cause = without_source(&e.to_string());
        Error::failed(format!("the display cannot be opened ({cause})"), RENDER)
    };
    let events = EventLoop::with_user_event().build().map_err(|e| no_display(&e))?;
    let mut app = app::App::new(start, events.create_proxy());
    let ended = events.run_app(&mut app);
    let (instance, result) = app.end();
    result?;
    ended.map_err(|e| no_display(&e))?;
    Ok(instance.map(|i: Arc<Instance>| i.messages()).unwrap_or_default())
}

/// A message of winit without the place in its sources that it names in front, as in `os error at …/mod.rs:7: no such display`.
fn without_source(message: &str) -> String {
    let behind = message
        .rsplit_once(".rs:")
        .map(|(_, behind)| behind.trim_start_matches(|c: char| c.is_ascii_digit()));
    behind.and_then(|behind| behind.strip_prefix(": ")).unwrap_or(message).to_owned()
}

/// What to do without a window.
const RENDER: &str = "draw into a file with `diffract render -o picture.png` instead";

/// Fails where no display is named in the environment, which `named` reads.
fn check_display(named: impl Fn(&str) -> bool) -> Result<()> {
    let anywhere_else = cfg!(any(windows, target_os = "macos"));
    if anywhere_else || ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(named) {
        return Ok(());
    }
    Err(Error::failed("there is no display for a window: neither DISPLAY nor WAYLAND_DISPLAY is set", RENDER))
}

impl Start {
    fn settings(&self) -> Settings {
        Settings {
            scene: self.name.clone(),
            surface: self.surface.clone(),
            optics: Optics {
                method: self.method,
                filter: self.filter,
                windows: self.windows,
                basis: self.basis,
                tolerance: self.tolerance,
                terms: self.terms,
                wavelengths: self.wavelengths,
            },
            coherence: self.coherence,
            ior: self.ior,
            illuminant: self.illuminant.clone(),
            lights: self.scene.lights.clone(),
            exposure: self.scene.exposure,
            base_color: self.scene.base_color,
            camera: self.scene.camera,
        }
    }
}

impl Stage {
    /// The stage of `scene`.
    ///
    /// # Errors
    /// Where its pigment texture cannot be read.
    pub fn of(scene: Scene) -> Result<Self> {
        let pigment = scene.pigment.as_deref().map(Pigment::read).transpose()?.unwrap_or_else(Pigment::white);
        Ok(Self { scene, pigment })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_display_the_error_names_the_other_way() {
        let e = check_display(|_| false);
        if cfg!(target_os = "linux") {
            let e = e.unwrap_err();
            assert!(e.exit_code() == 1 && e.to_string().contains("diffract render"), "{e}");
        }
        assert!(check_display(|name| name == "WAYLAND_DISPLAY").is_ok());
    }
}
