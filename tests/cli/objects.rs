//! Scenes of several objects: pictures against the reference, in the window, and in files.

use crate::display::wait_for;
use crate::render::{deviation, exr};
use crate::sandbox::Sandbox;
use crate::viewer::Viewer;
use std::path::Path;

const CONTROL: u32 = 0xffe3;
const RETURN: u32 = 0xff0d;

const SCENE: &str = r#"
mesh = "sphere"
surface = "blaze"
base_color = [0.1, 0.1, 0.3]
ground = [0.5, 0.4, 0.3]
exposure = -1.0
lights = ["50,-60,2@led"]

[[objects]]
mesh = "plate"
up = "z"
position = [0.9, 1.4, 0.2]
rotation = ["80deg", "0deg", "20deg"]
size = 2.0
surface = "sinusoid"
grooves = "20deg"
material = "gold"
base_color = [0.3, 0.02, 0.02]

[camera]
eye = [0.8, -7.0, 2.2]
target = [0.2, 0.0, 0.0]
field_of_view = "30deg"
"#;

#[test]
fn a_picture_of_several_objects_is_that_of_the_reference_and_a_sequence_of_them_goes_on() {
    let sandbox = Sandbox::new();
    sandbox.write("two.toml", SCENE);
    let draw = |name: &str, more: &[&str]| {
        let scene =
            ["render", "two.toml", "--size", "48x36", "--samples", "2", "--coherence", "gaussian:16um"];
        sandbox.run2(&scene, &[&["-o", name], more].concat()).done();
        exr(&sandbox, name).2
    };
    let exact = draw("exact.exr", &["--method", "reference"]);
    let error = deviation(&draw("table.exr", &["--tolerance", "2e-2"]), &exact);
    eprintln!("by a table: {error:.4}");
    // The table has 2e-2 of it; the rest is what the device's interpolated directions and shadow maps differ from rays in f64.
    assert!(error < 3e-2, "{error}");
    // One object more or less is another picture, for a sequence, too.
    let quick = ["--coherence", "gaussian:16um", "--tolerance", "1e-1", "--size", "32x24", "--samples", "1"];
    let turn = ["--turntable", "40", "--frames", "0..1", "-o", "turn.png"];
    let sequence = || sandbox.run2(&["render", "two.toml"], &[&quick[..], &turn].concat());
    sequence().done();
    let told = sequence();
    assert!(told.code == Some(0) && told.stderr.contains("1 of 1 pictures are there already"), "{told:?}");
    sandbox.write("two.toml", SCENE.replace("size = 2.0", "size = 2.5"));
    let told = sequence().refused(2);
    assert!(told.contains("is not this picture under these settings"), "{told}");
}

#[test]
fn the_window_shows_several_objects_as_render_draws_them_and_saves_their_scene() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("two.toml");
    std::fs::write(&file, SCENE).unwrap();
    let viewer = Viewer::open(&[file.to_str().unwrap(), "--size", "640x480"]);
    let (picture, command, _) = viewer.save(&[]);
    assert!(picture == viewer.render(&command), "{command}");
    // A change of the first object leaves the others.
    viewer.display.drag(1, [100, 300], [140, 320]);
    let (turned, command) = viewer.shows("--eye");
    assert!(turned != picture && turned == viewer.render(&command), "{command}");
    viewer.display.key('s'.into(), &[CONTROL]);
    viewer.position_of("Save the scene with all settings");
    viewer.display.key(RETURN, &[]);
    let saved = ["scene.toml", "two-scene.toml"].map(|name| viewer.sandbox.path(name));
    let saved = wait_for("the scene file", || saved.iter().find(|path| path.is_file()).cloned());
    let size = command.split("--size ").nth(1).unwrap().split(' ').next().unwrap();
    let saved: &Path = &saved;
    viewer.sandbox.run(["render", saved.to_str().unwrap(), "--size", size, "-o", "again.png"]).done();
    let again = image::open(viewer.sandbox.path("again.png")).unwrap().to_rgb8();
    assert!(again == turned, "{}", std::fs::read_to_string(saved).unwrap());
    viewer.close();
}
