//! Work area of the screen: what panels and docks leave of it for windows.

use winit::event_loop::ActiveEventLoop;

/// Height of a title bar \[points\].
const TITLE_BAR: f64 = 40.0;

/// Returns the size of a window \[pixels\]: `size` \[points\], or as much of it as the work area of the screen holds; `None` if
/// the screen is unknown, as on Wayland, where the compositor fits windows to it.
pub fn fitting(events: &ActiveEventLoop, size: [u32; 2]) -> Option<[u32; 2]> {
    let monitor = events.primary_monitor().or_else(|| events.available_monitors().next())?;
    let scale = monitor.scale_factor();
    let title_bar = if has_manager() { TITLE_BAR } else { 0.0 };
    let screen: [u32; 2] = monitor.size().into();
    Some(fitted(size, scale, screen, of_desktop(), title_bar))
}

/// Returns `size` \[points\] in pixels, or as much of it as both the `screen` and its `work_area` hold below a title bar.
fn fitted(
    size: [u32; 2],
    scale: f64,
    screen: [u32; 2],
    work_area: Option<[u32; 2]>,
    title_bar: f64,
) -> [u32; 2] {
    let work_area = work_area.unwrap_or(screen);
    let above = [0.0, title_bar * scale];
    [0, 1].map(|axis| {
        let room = f64::from(screen[axis].min(work_area[axis])) - above[axis];
        (f64::from(size[axis]) * scale).min(room).max(1.0).round() as u32
    })
}

/// Returns true if a window manager frames the windows of the X display.
#[cfg(target_os = "linux")]
fn has_manager() -> bool {
    property("_NET_SUPPORTING_WM_CHECK").is_some()
}

/// Returns the size of the work area that the window manager of the X display names \[pixels\].
#[cfg(target_os = "linux")]
fn of_desktop() -> Option<[u32; 2]> {
    match property("_NET_WORKAREA")?.as_slice() {
        [_, _, width, height, ..] if *width > 0 && *height > 0 => Some([*width, *height]),
        _ => None,
    }
}

/// Returns the numbers of a property of the root window; `None` if there is none, or no X display.
#[cfg(target_os = "linux")]
fn property(name: &str) -> Option<Vec<u32>> {
    use x11rb::connection::Connection;
    use x11rb::protocol::xproto::{AtomEnum, ConnectionExt};
    /// Words of the property that are read: enough for the first desktop.
    const WORDS: u32 = 4;
    let (connection, screen) = x11rb::connect(None).ok()?;
    let root = connection.setup().roots.get(screen)?.root;
    let atom = connection.intern_atom(true, name.as_bytes()).ok()?.reply().ok()?.atom;
    let reply = connection.get_property(false, root, atom, AtomEnum::ANY, 0, WORDS).ok()?.reply().ok()?;
    let words: Vec<u32> = reply.value32()?.collect();
    (!words.is_empty()).then_some(words)
}

#[cfg(not(target_os = "linux"))]
fn has_manager() -> bool {
    true
}

#[cfg(not(target_os = "linux"))]
fn of_desktop() -> Option<[u32; 2]> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_is_as_large_as_asked_for_or_as_the_work_area() {
        let usual = [1280, 800];
        let laptop = [1366, 768];
        assert_eq!(fitted(usual, 1.0, [1920, 1080], None, 40.0), usual);
        assert_eq!(fitted(usual, 1.0, laptop, None, 0.0), [1280, 768]);
        assert_eq!(fitted(usual, 1.0, laptop, Some([1366, 741]), 40.0), [1280, 701]);
        // The work area of two screens side by side.
        assert_eq!(fitted(usual, 2.0, [1920, 1080], Some([3840, 1050]), 40.0), [1920, 970]);
        assert_eq!(fitted([300, 200], 1.5, laptop, None, 40.0), [450, 300]);
    }
}
