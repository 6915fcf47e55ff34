//! What a window does when the device or its own surface is lost.

use crate::viewer::Viewer;

/// The command that the program says to draw the picture by.
fn command(line: &str) -> String {
    let command =
        line.split_once("draw the same picture with: diffract render ").unwrap_or_else(|| panic!("{line}")).1;
    command.to_owned()
}

#[test]
fn a_lost_device_ends_the_program_and_the_scene_is_not_lost() {
    // In the middle of uploads, and of frames.
    for lost_at in ["submission=25", "submission=300"] {
        let viewer = Viewer::start(
            &["sphere", "--size", "700x500", "--light", "20,10"],
            &[("DIFFRACT_DEVICE_MASK", lost_at)],
        );
        let (mut viewer, space) = (viewer, u32::from(' '));
        // Continuous frames come to any number of submissions.
        let mut pressed = false;
        while viewer.program.try_wait().unwrap().is_none() {
            if !pressed && viewer.words().iter().any(|word| word.text == "full quality") {
                viewer.display.key(space, &[]);
                pressed = true;
            }
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
        let (ended, sandbox) = viewer.end();
        let line = ended.refused(1);
        assert!(line.contains("device has been lost") || line.contains("DEVICE_LOST"), "{line}");
        let command = command(&line);
        assert!(command.contains("--light 20,10,"), "{command}");
        sandbox.run([&["render"][..], &command.split(' ').collect::<Vec<_>>()].concat()).done();
        assert!(sandbox.path("picture.png").is_file());
    }
}

#[test]
fn a_lost_surface_is_made_anew() {
    for lost_at in ["acquisition=1", "acquisition=4"] {
        let arguments = ["sphere", "--size", "700x500"];
        let viewer = Viewer::start(&arguments, &[("DIFFRACT_DEVICE_MASK", lost_at)]);
        viewer.says("full quality");
        let (first, _, _) = viewer.save(&[]);
        viewer.display.drag(1, [170, 230], [215, 260]);
        let (moved, command) = viewer.shows("--illuminant d65");
        assert!(moved != first, "{command}");
        viewer.close();
    }
}

#[test]
fn a_window_that_another_program_destroys_ends_in_one_line() {
    let viewer = Viewer::open(&["sphere", "--size", "700x500", "--light", "20,10"]);
    // In the middle of frames.
    viewer.display.key(u32::from(' '), &[]);
    viewer.display.destroy(viewer.window);
    let line = viewer.end().0.refused(1);
    assert!(line.contains("another program has destroyed the window"), "{line}");
    assert!(command(&line).contains("--light 20,10,"), "{line}");
}

#[test]
fn a_compositor_that_is_gone_leads_to_x11_or_is_named() {
    let gone = [("WAYLAND_DISPLAY", "wayland-77"), ("XDG_RUNTIME_DIR", "/nowhere")];
    let viewer = Viewer::start(&["sphere", "--size", "700x500"], &gone);
    viewer.says("full quality");
    let mut command = viewer.sandbox.command(["view", "sphere"]);
    command.envs(gone).env_remove("DISPLAY");
    let output = command.output().unwrap();
    let line = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), line.lines().count()), (Some(1), 1), "{line}");
    assert!(line.contains("/nowhere/wayland-77") && line.contains("DISPLAY"), "{line}");
    viewer.close();
}
