//! The window: winit events, a panel of egui, and the frames drawn by `render`.
//!
//! Four kinds of threads run in addition to the window's thread: `worker` prepares layers and colour tables,
//! `render_thread` draws the scene, `error_probe` measures errors, `inspector` evaluates the reference for a pixel.
//! They reply by events; the window's thread never waits for them.

mod app;
pub mod atlas;
mod changes;
mod commands;
mod compare;
mod controls;
mod difference;
pub mod error_probe;
mod event;
mod file_pane;
mod files;
mod folder;
mod frame;
mod frame_renderer;
mod framing;
mod graph;
#[allow(unsafe_code, reason = "hands Vulkan objects to the panel's renderer")]
pub mod gui;
mod hemisphere;
mod input;
mod inset;
mod inspector;
mod inspector_pane;
mod job_queue;
mod layout;
mod light_handles;
mod model;
mod orbit;
mod overlay;
mod palette_pane;
mod panel;
mod prepared;
mod presenter;
mod quality;
mod render_thread;
mod save;
mod start;
mod style;
mod surface_pane;
mod surface_window;
mod text_dump;
mod view_settings;
mod viewer_window;
mod worker;

#[cfg(test)]
mod hand;
#[cfg(test)]
pub(crate) use panel::rows::ALL as ROWS;
pub use start::{CommandLine, LastView, Output, SceneFiles, Start};
#[cfg(test)]
pub(crate) use view_settings::tests::settings as settings_of_a_plate;
pub use view_settings::{ViewSettings, placement};

use crate::error::{Error, Remedy, Result};
use crate::vk::instance::Instance;
use std::sync::Arc;
use winit::event_loop::EventLoop;

/// Opens the window; returns the validation messages when it is closed.
///
/// # Errors
/// Fails if there is no display or no device that can present, or if the device is lost.
pub fn run(start: Start) -> Result<Vec<String>> {
    check_display(|name| std::env::var_os(name).is_some_and(|v| !v.is_empty()))?;
    let no_display = |e: &dyn std::fmt::Display| {
        let cause = without_source(&e.to_string());
        Error::device(format!("the display cannot be opened ({cause})"), Remedy::PictureFile)
    };
    let events = EventLoop::with_user_event().build().map_err(|e| no_display(&e))?;
    let mut app = app::App::new(start, events.create_proxy());
    let ended = events.run_app(&mut app);
    let (instance, result) = app.end();
    result?;
    ended.map_err(|e| no_display(&e))?;
    Ok(instance.map(|i: Arc<Instance>| i.messages()).unwrap_or_default())
}

/// Returns a message of winit without the source location in front of it, as in `os error at …/mod.rs:7: no such
/// display`.
fn without_source(message: &str) -> String {
    let behind = message
        .rsplit_once(".rs:")
        .map(|(_, behind)| behind.trim_start_matches(|c: char| c.is_ascii_digit()));
    behind.and_then(|behind| behind.strip_prefix(": ")).unwrap_or(message).to_owned()
}

/// Fails if the environment names no display. `named` returns true if a variable is set.
fn check_display(named: impl Fn(&str) -> bool) -> Result<()> {
    let anywhere_else = cfg!(any(windows, target_os = "macos"));
    if anywhere_else || ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(named) {
        return Ok(());
    }
    Err(Error::device(
        "there is no display for a window: neither DISPLAY nor WAYLAND_DISPLAY is set",
        Remedy::PictureFile,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_display_the_error_names_the_other_way() {
        let e = check_display(|_| false);
        if cfg!(target_os = "linux") {
            let e = e.unwrap_err();
            assert!(
                e.kind() == crate::error::ErrorKind::Device && e.remedies() == [Remedy::PictureFile],
                "{e}"
            );
        }
        assert!(check_display(|name| name == "WAYLAND_DISPLAY").is_ok());
    }
}
