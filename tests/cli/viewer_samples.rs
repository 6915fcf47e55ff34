//! Samples that are summed while nothing moves.

use crate::display::wait_for;
use crate::viewer::Viewer;

#[test]
fn a_still_picture_goes_on_to_its_samples_and_is_saved_as_their_mean() {
    let viewer = Viewer::open(&["sphere", "--size", "560x400", "--samples", "6", "--windows", "all"]);
    viewer.says("6 of 6 samples");
    let (picture, command, _) = viewer.save(&[]);
    assert!(command.contains(" --samples 6 "), "{command}");
    assert!(picture == viewer.render(&command), "{command}");
    let one = viewer.render(&command.replace("--samples 6", "--samples 1"));
    assert!(picture != one, "edges are smooth");
    // Brightness changes the display alone, and a drag begins the sum anew.
    viewer.display.key('-'.into(), &[]);
    viewer.shows_number("--exposure", &viewer.row("exposure")[0].text.replace(" EV", ""));
    viewer.display.drag(1, [105, 180], [130, 200]);
    let (_, turned) = viewer.shows("--eye");
    assert!(turned.contains(" --samples 6 "), "{turned}");
    viewer.says("6 of 6 samples");
    // What is inspected is one sample.
    viewer.display.key('i'.into(), &[]);
    viewer.display.click(1, [90, 200], 1);
    viewer.position_of("radiance");
    assert!(!viewer.words().iter().any(|word| word.text.contains("of 6 samples")));
    viewer.display.key('i'.into(), &[]);
    viewer.says("6 of 6 samples");
    viewer.close();
}

#[test]
fn a_picture_is_saved_while_the_hand_goes_on() {
    let viewer = Viewer::start(&["sphere", "--size", "560x400", "--samples", "100"], &[]);
    viewer.says("of 100 samples");
    let before = viewer.display.look(viewer.window).unwrap();
    viewer.display.key('s'.into(), &[]);
    viewer.says("saving diffract-001.png");
    viewer.display.drag(1, [105, 180], [130, 200]);
    let picture = |shown: &image::RgbImage| image::imageops::crop_imm(shown, 60, 150, 100, 100).to_image();
    wait_for("another view", || {
        let shown = viewer.display.look(viewer.window)?;
        (picture(&shown) != picture(&before)).then_some(())
    });
    assert!(!viewer.sandbox.path("diffract-001.png").exists(), "100 samples take longer than a drag");
    viewer.says("saved ");
    let command = viewer.sandbox.path("diffract-001.png");
    assert!(command.is_file());
    viewer.close();
}
