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
mod guesses;
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
mod work_area;
mod worker;

#[cfg(test)]
mod hand;
mod threads;
#[cfg(test)]
pub(crate) use panel::rows::ALL as ROWS;
pub use start::{CommandLine, LastView, Output, SceneFiles, Start};
#[cfg(test)]
pub(crate) use view_settings::tests::settings as settings_of_a_plate;
pub use view_settings::{ViewSettings, placement};

use crate::error::{Error, Remedy, Result};
use crate::vk::instance::Instance;
#[cfg(target_os = "linux")]
use std::ffi::OsString;
#[cfg(target_os = "linux")]
use std::path::PathBuf;
use std::sync::Arc;
use winit::event_loop::EventLoop;

/// Opens the window; returns the validation messages when it is closed.
///
/// # Errors
/// Fails if there is no display or no device that can present, or if the device is lost.
pub fn run(start: Start) -> Result<Vec<String>> {
    let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    check_display(|name| variable(name).is_some())?;
    let no_display = |e: &dyn std::fmt::Display| {
        let cause = without_source(&e.to_string());
        Error::device(format!("the display cannot be opened ({cause})"), Remedy::PictureFile)
    };
    let mut builder = EventLoop::with_user_event();
    #[cfg(target_os = "linux")]
    if let Some(socket) = silent_compositor(variable) {
        use winit::platform::x11::EventLoopBuilderExtX11;
        if variable("DISPLAY").is_none() {
            let what = format!("no Wayland compositor answers at {}", socket.display());
            return Err(
                Error::device(what, "set WAYLAND_DISPLAY, or DISPLAY for X11").or(Remedy::PictureFile)
            );
        }
        builder.with_x11();
    }
    let events = builder.build().map_err(|e| no_display(&e))?;
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

/// Returns the socket of the Wayland compositor that the environment names, if nothing answers there. `variable` returns the
/// value of a variable that is set.
#[cfg(target_os = "linux")]
fn silent_compositor(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    if variable("WAYLAND_SOCKET").is_some() {
        return None; // already open
    }
    let name = variable("WAYLAND_DISPLAY")?;
    let socket = PathBuf::from(variable("XDG_RUNTIME_DIR").unwrap_or_default()).join(name);
    std::os::unix::net::UnixStream::connect(&socket).is_err().then_some(socket)
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

    #[cfg(target_os = "linux")]
    #[test]
    fn a_compositor_that_does_not_answer_is_found_out() {
        let folder = tempfile::tempdir().unwrap();
        let listener = std::os::unix::net::UnixListener::bind(folder.path().join("wayland-0")).unwrap();
        let found = |display: &str| {
            silent_compositor(|name| match name {
                "WAYLAND_DISPLAY" => Some(display.into()),
                "XDG_RUNTIME_DIR" => Some(folder.path().into()),
                _ => None,
            })
        };
        assert_eq!(found("wayland-0"), None);
        assert_eq!(found("wayland-7"), Some(folder.path().join("wayland-7")));
        // A path of its own.
        assert_eq!(found("/nowhere/wayland-0"), Some("/nowhere/wayland-0".into()));
        drop(listener);
        assert!(found("wayland-0").is_some(), "the file of the socket stays");
        assert_eq!(silent_compositor(|_| None), None);
    }
}
