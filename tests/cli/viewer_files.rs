//! Files in the window: scenes that are saved and opened again, files that were opened lately, the next file of a folder.

use crate::display::wait_for;
use crate::viewer::Viewer;

const CONTROL: u32 = 0xffe3;
const RETURN: u32 = 0xff0d;
const PAGE_UP: u32 = 0xff55;
const PAGE_DOWN: u32 = 0xff56;
const SIZE: [&str; 2] = ["--size", "600x700"];

#[test]
fn a_saved_scene_is_the_picture_for_render_and_for_another_window() {
    let viewer = Viewer::open(&[&["sphere"][..], &SIZE].concat());
    viewer.display.drag(1, [110, 300], [150, 330]);
    viewer.display.key('+'.into(), &[]);
    viewer.choose("tone mapping", "neutral");
    let (picture, command, _) = viewer.save(&[]);
    viewer.display.key('s'.into(), &[CONTROL]);
    viewer.position_of("Save the scene with all settings");
    viewer.display.key(RETURN, &[]);
    let file = viewer.sandbox.path("scene.toml");
    wait_for("the scene file", || file.is_file().then_some(()));
    let size = command.split("--size ").nth(1).unwrap().split(' ').next().unwrap();
    viewer.sandbox.run(["render", "scene.toml", "--size", size, "-o", "again.png"]).done();
    let again = image::open(viewer.sandbox.path("again.png")).unwrap().to_rgb8();
    assert!(again == picture, "{}", std::fs::read_to_string(&file).unwrap());
    // An option stands before that of the scene.
    viewer.sandbox.run(["render", "scene.toml", "--size", size, "--exposure", "-3", "-o", "dark.png"]).done();
    assert!(image::open(viewer.sandbox.path("dark.png")).unwrap().to_rgb8() != picture);
    // Another scene, and back by the file.
    viewer.choose("scene", "plate");
    viewer.shows("plate --surface small.png");
    viewer.display.drop_file(viewer.window, &file);
    wait_for("the scene of the file", || {
        viewer.display.title(viewer.window).contains("scene.toml").then_some(())
    });
    let (opened, command) = wait_for("the same picture", || {
        let (opened, command, _) = viewer.save(&[]);
        (opened == picture).then_some((opened, command))
    });
    assert!(opened == viewer.render(&command), "{command}");
    viewer.close();
}

#[test]
fn keys_lead_through_the_files_of_a_folder_and_past_a_broken_one() {
    let viewer = Viewer::open(&[&["sphere"][..], &SIZE].concat());
    let shows = |name: &str| {
        wait_for(name, || {
            let title = viewer.display.title(viewer.window);
            (title == format!("diffract: sphere, {name}")).then_some(())
        });
    };
    std::fs::copy(viewer.sandbox.path("small.png"), viewer.sandbox.path("small10.png")).unwrap();
    viewer.sandbox.write("small2.png", "this is no picture");
    viewer.display.key(PAGE_DOWN, &[]);
    viewer.says("small2.png");
    viewer.says("click to dismiss");
    shows("small.png");
    viewer.display.key(PAGE_DOWN, &[]);
    shows("small10.png");
    viewer.says("of ");
    // Pictures that were saved meanwhile would be files of the folder, too.
    viewer.display.key(PAGE_UP, &[]);
    viewer.says("small2.png");
    let recent = std::fs::read_to_string(viewer.sandbox.state().join("recent.json")).unwrap();
    let names: Vec<String> = serde_json::from_str(&recent).unwrap();
    assert!(names[0].ends_with("/small10.png") && names[1].ends_with("/small.png"), "{recent}");
    viewer.close();
}
