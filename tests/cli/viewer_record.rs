//! What the window records and how fine its colours are from near: the pictures are those of `diffract render`.

use crate::display::wait_for;
use crate::viewer::Viewer;

const ESCAPE: u32 = 0xff1b;
const SIZE: [&str; 2] = ["--size", "500x320"];
/// On the sphere, left of the panel and below the hemisphere.
const MIDDLE: [i16; 2] = [100, 240];

#[test]
fn from_near_the_colours_are_as_fine_as_those_of_a_picture_from_there() {
    let table = ["sphere", "--method", "table", "--coherence", "gaussian:80um"];
    let viewer = Viewer::open(&[&table[..], &SIZE].concat());
    let tables = || {
        let kept = std::fs::read_dir(viewer.sandbox.cache()).unwrap();
        kept.filter(|file| file.as_ref().unwrap().path().extension().is_some_and(|e| e == "colours")).count()
    };
    let before = tables();
    // Away and back: from afar a coarser table does, which the window takes as `render` does.
    for (button, turns) in [(5, 12), (4, 12)] {
        viewer.display.click(button, MIDDLE, turns);
        let (picture, command, _) = viewer.save(&[]);
        assert!(command.contains("--eye"), "{command}");
        assert!(picture == viewer.render(&command), "{turns} turns of button {button}: {command}");
        assert!(tables() > before, "it was drawn from the table of the first view");
    }
    viewer.close();
}

#[test]
fn a_turntable_is_recorded_picture_by_picture_until_it_is_stopped() {
    let viewer = Viewer::open(&[&["sphere"][..], &SIZE].concat());
    let file = |n: u32| viewer.sandbox.path(format!("diffract-turn-001/turn-{n:04}.png"));
    viewer.display.key('t'.into(), &[]);
    wait_for("two pictures", || file(1).is_file().then_some(()));
    viewer.display.key(ESCAPE, &[]);
    viewer.says("recorded ");
    let (_, command, _) = viewer.save(&[]);
    let words: Vec<&str> = command.split(' ').collect();
    let output = words.iter().position(|word| *word == "-o").unwrap();
    let turn = ["--turntable", "120", "--frames", "0..2", "-o", "told.png"];
    viewer.sandbox.run([&["render"], &words[..output], &turn].concat()).done();
    for n in 0..2 {
        let told = viewer.sandbox.path(format!("told-{n:04}.png"));
        let [recorded, told] = [file(n), told].map(|path| image::open(path).unwrap().to_rgb8());
        assert!(recorded == told, "picture {n} of {command}");
    }
    // What is stopped leaves whole pictures, and the window goes on.
    let left = std::fs::read_dir(file(0).parent().unwrap()).unwrap().count();
    assert!((2..120).contains(&left), "{left} pictures");
    viewer.close();
}
