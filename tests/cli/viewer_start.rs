//! What a new user meets: the first window, scenes and files to choose from, and settings that are refused.

use crate::display::wait_for;
use crate::viewer::Viewer;

const SIZE: [&str; 2] = ["--size", "600x700"];

/// Whether the window shows a text that contains `part`.
fn says(viewer: &Viewer, part: &str) -> bool {
    viewer.words().iter().any(|word| word.text.contains(part))
}

#[test]
fn a_refused_file_leaves_the_surface_that_is_shown_and_its_error_stays_until_it_is_dismissed() {
    let viewer = Viewer::open(&[&["sphere"][..], &SIZE].concat());
    let (first, _) = viewer.shows("--surface small.png");
    viewer.sandbox.write("broken.png", "this is no picture");
    viewer.display.drop_file(viewer.window, &viewer.sandbox.path("broken.png"));
    let error = viewer.says("click to dismiss");
    assert!(error.contains("broken.png"), "{error}");
    wait_for("the surface that is shown", || {
        (viewer.row("height field").first()?.text == "small.png").then_some(())
    });
    assert_eq!(viewer.display.title(viewer.window), "diffract: sphere, small.png");
    let (again, command) = viewer.shows("--surface small.png");
    assert!(again == first, "{command}");
    viewer.says("saved ");
    assert!(says(&viewer, "click to dismiss"), "a saved picture does not mend a surface");
    viewer.press(&error);
    wait_for("the end of the error", || (!says(&viewer, "click to dismiss")).then_some(()));
    viewer.close();
}

#[test]
fn another_scene_keeps_the_surface_and_files_stay_in_the_list() {
    let viewer = Viewer::open(&[&["sphere"][..], &SIZE].concat());
    viewer.choose("scene", "plate");
    viewer.shows("plate --surface small.png");
    viewer.choose("height field", "sinusoid");
    viewer.shows("--surface sinusoid");
    viewer.choose("height field", "small.png");
    let (_, command) = viewer.shows("--surface small.png");
    assert!(command.contains("--height 0.1374"), "{command}");
    viewer.close();
}

#[test]
fn the_size_of_the_window_and_of_its_text_follows_the_scale_of_the_display() {
    let arguments = ["sphere", "--size", "500x400"];
    let viewer = Viewer::start(&arguments, &[("WINIT_X11_SCALE_FACTOR", "2")]);
    viewer.says("full quality");
    let shown = viewer.display.look(viewer.window).unwrap();
    assert_eq!(shown.dimensions(), (1000, 800));
    viewer.press("Keys  [F1]");
    viewer.find("left drag");
    viewer.close();
}
