//! The rows of the panel that decide the picture, pressed and dragged: the picture that is saved then is the one that
//! `render` draws by the command in it, and that command says what was set.

use crate::display::wait_for;
use crate::viewer::Viewer;

/// Room for all of the panel.
const LARGE: [&str; 2] = ["--size", "600x1064"];

#[test]
fn windows_and_what_else_the_optics_has_act_on_the_picture() {
    let viewer = Viewer::open(&[&["sphere"][..], &LARGE].concat());
    let (first, _) = viewer.shows("--method table --windows all");
    viewer.says("of a colour table");
    viewer.press("one");
    let (speckled, command) = viewer.shows("--windows 1x1 --basis optimal");
    assert!(speckled != first, "{command}");
    viewer.press_in("windows", "mean"); // levels are called so, too
    let (again, _) = viewer.shows("--method table --windows all");
    assert!(again == first);
    viewer.press("one");
    viewer.shows("--windows 1x1 --basis optimal");
    viewer.choose("basis", "taylor");
    viewer.shows("--basis taylor");
    viewer.choose("tolerance", "5 %");
    viewer.shows("--tolerance 5e-2");
    // Two rows have this word: terms, then wavelengths.
    let mut free = viewer.words();
    free.retain(|word| word.text == "automatic");
    free.sort_by_key(|word| word.at[1]);
    viewer.display.click(1, free[1].at, 1);
    viewer.shows("--wavelengths 32");
    viewer.says("none: wavelengths are set by hand");
    viewer.display.click(1, free[0].at, 1);
    viewer.shows("--terms 10");
    viewer.press("A");
    viewer.shows("--illuminant a");
    viewer.display.key('r'.into(), &[]);
    let (reset, command) = viewer.shows("--illuminant d65");
    assert!(reset == first, "{command}");
    viewer.close();
}

#[test]
fn words_can_be_read_also_those_of_letters_that_were_not_there_at_first() {
    let viewer = Viewer::open(&[&["sphere"][..], &LARGE].concat());
    ["tolerance", "full quality"].into_iter().for_each(|text| viewer.reads(text));
    for name in ["ЖЩЮЯЖЩЮЯ.obj", "ψξθφψξθφ.obj"] {
        viewer.sandbox.write(name, "v -1 -1 0\nv 1 -1 0\nv 1 1 0.5\nv -1 1 0\nf 1 2 3 4\n");
        viewer.display.drop_file(viewer.window, &viewer.sandbox.path(name));
        viewer.reads(name);
    }
    viewer.close();
}

#[test]
fn coherence_is_a_window_or_repeats() {
    let viewer = Viewer::open(&[&["sphere"][..], &LARGE].concat());
    let (through_a_window, _) = viewer.shows("--coherence gaussian:4um");
    viewer.press("repeats");
    let (repeats, command) = viewer.shows("--coherence grating:3x3");
    assert!(repeats != through_a_window, "{command}");
    viewer.says("those of the grating's orders");
    // The hemisphere is of the repeats, too: orders on black, where a window leaves no black.
    let shown = viewer.display.look(viewer.window).unwrap();
    let inside = (30..140).flat_map(|x| (30..140).map(move |y| (x, y)));
    let levels: Vec<u8> = inside.map(|(x, y)| *shown.get_pixel(x, y).0.iter().max().unwrap()).collect();
    assert!(levels.iter().filter(|&&level| level > 100).count() > 200, "there are orders");

    let along_y = viewer.drag("copies", 2, 22);
    let (more, _) = viewer.shows(&format!("--coherence grating:3x{along_y}"));
    assert!(more != repeats);
    // What only the shading depends on.
    let index = viewer.drag("refractive index", 0, 30);
    let (reflecting, _) = viewer.shows_number("--ior", &index);
    assert!(reflecting != more);
    // Beside it, another setting through the same repeats.
    viewer.press("split");
    viewer.says("optimal, 3 %");
    viewer.press("off");
    // The rows below move up.
    let rows = || viewer.words().iter().filter(|word| word.text == "basis").count();
    wait_for("one setting", || (rows() == 1).then_some(()));
    viewer.press("gaussian");
    viewer.shows("--coherence gaussian:4um");
    let length = viewer.drag("length", 0, 20);
    viewer.shows_number("--coherence", &length);
    viewer.close();
}

#[test]
fn lights_and_exposure_and_level_act_on_the_picture() {
    let plate = ["plate", "--light", "40,180,2", "--environment", "sky"];
    let viewer = Viewer::open(&[&plate[..], &LARGE].concat());
    let stops = viewer.drag("exposure", 0, 24);
    let (first, _) = viewer.shows_number("--exposure", &stops);
    viewer.press_in("tone mapping", "none");
    let (hard, command) = viewer.shows("--tone none");
    assert!(hard != first, "{command}");
    viewer.press("mean");
    viewer.shows("--level mean");
    viewer.press("add a light");
    viewer.says("✖");
    let lights = |command: &str| command.matches("--light ").count();
    let (two, command) = viewer.shows("--level mean");
    assert!(lights(&command) == 2 && two != first, "{command}");
    // The first light gets a spectrum of its own.
    viewer.press_in("light 1", "λ");
    viewer.says("as the illuminant");
    viewer.press("LED");
    let (lit, command) = viewer.shows("--light 40,180,2@led");
    assert!(lights(&command) == 2 && lit != two, "{command}");
    viewer.press_in("light 1", "LED");
    viewer.press("as the illuminant");
    let (again, command) = viewer.shows("--level mean");
    assert!(again == two && !command.contains('@'), "{command}");
    viewer.press("✖");
    let (_, command) = viewer.shows("--level mean");
    assert_eq!(lights(&command), 1, "{command}");
    viewer.close();
}

#[test]
fn an_automatic_exposure_is_measured_once_and_a_reset_returns_to_it() {
    let viewer = Viewer::open(&[&["plate", "--exposure", "auto"][..], &LARGE].concat());
    let exposure = |command: &str| {
        let value = command.split("--exposure ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
        value.parse::<f64>().unwrap()
    };
    let (first, command) = viewer.shows("--method table");
    let measured = exposure(&command);
    // The scene's own is −5.
    assert!(measured != -5.0, "{command}");
    let stops = viewer.drag("exposure", 0, 24);
    viewer.shows_number("--exposure", &stops);
    viewer.display.key('r'.into(), &[]);
    let (again, command) = viewer.shows(&format!("--exposure {measured}"));
    assert!(again == first && exposure(&command) == measured, "{command}");
    viewer.close();
}
