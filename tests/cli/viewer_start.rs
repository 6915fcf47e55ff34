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
fn a_window_offers_to_continue_the_one_that_was_closed_last() {
    let state = tempfile::tempdir().unwrap();
    let folder = state.path().to_str().unwrap();
    let start = || {
        let viewer = Viewer::start(&[&["sphere"][..], &SIZE].concat(), &[("XDG_STATE_HOME", folder)]);
        viewer.says("full quality");
        viewer
    };
    let offer = "Continue the last window";
    let first = start();
    assert!(!says(&first, offer), "there was none");
    first.choose("scene", "plate");
    first.shows("plate --surface small.png");
    first.choose("height field", "sinusoid");
    let (_, command) = first.shows("plate --surface sinusoid");
    first.close();
    // A window in which nothing is set does not take its place.
    start().close();
    let second = start();
    second.press(offer);
    let (_, again) = second.shows("plate --surface sinusoid");
    let settings = |command: &str| command.split(" -o ").next().map(str::to_owned);
    assert_eq!(settings(&again), settings(&command));
    assert!(!says(&second, offer), "it is continued");
    second.close();
}

#[test]
fn the_size_of_the_window_and_of_its_text_follows_the_scale_of_the_display() {
    let arguments = ["sphere", "--size", "500x400"];
    let viewer = Viewer::start(&arguments, &[("WINIT_X11_SCALE_FACTOR", "2")]);
    viewer.says("full quality");
    let shown = viewer.display.look(viewer.window).unwrap();
    assert_eq!(shown.dimensions(), (1000, 800));
    viewer.press("Keys  [F1]");
    viewer.position_of("left drag");
    viewer.close();
}
