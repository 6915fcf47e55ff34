//! Every row of the panel that decides the picture, pressed and dragged: the picture that is saved then is the one that
//! `render` draws by the command in it, and that command says what was set.

use crate::viewer::Viewer;

/// Room for all of the panel.
const LARGE: [&str; 2] = ["--size", "640x790"];

#[test]
fn the_rows_of_the_optics_act_on_the_picture() {
    let viewer = Viewer::open(&[&["sphere"][..], &LARGE].concat());
    let (first, _) = viewer.shows("--basis optimal");

    viewer.press("table");
    let (by_table, command) = viewer.shows("--method table --filter point --windows 1x1");
    assert!(by_table != first, "{command}");
    viewer.says("of a colour table");
    viewer.press("all it sees");
    let (filtered, _) = viewer.shows("--filter pixel");
    assert!(filtered != by_table);
    viewer.press("its centre");
    viewer.drag("windows", 0, 24);
    let windows = viewer.row("windows");
    let count: u32 = windows[0].text.parse().unwrap();
    assert!(count > 1 && windows[1].text == "1", "{windows:?}");
    viewer.shows(&format!("--filter point --windows {count}x1"));

    viewer.press("spectral");
    let (again, _) = viewer.shows("--basis optimal");
    assert!(again == first);
    viewer.choose("basis", "chebyshev");
    viewer.shows("--basis chebyshev");
    viewer.choose("tolerance", "5 %");
    viewer.shows("--tolerance 5e-2");
    // The first of two rows with these words: terms, then wavelengths.
    let mut left = viewer.words();
    left.retain(|word| word.text == "from the tolerance");
    left.sort_by_key(|word| word.at[1]);
    viewer.display.click(1, left[1].at, 1);
    viewer.shows("--wavelengths 32");
    viewer.display.click(1, left[0].at, 1);
    viewer.shows("--terms 10");
    viewer.says("none: wavelengths are named");
    viewer.press("A");
    viewer.shows("--illuminant a");
    viewer.display.key('r'.into(), &[]);
    let (reset, command) = viewer.shows("--illuminant d65");
    assert!(reset == first, "{command}");
    viewer.close();
}

#[test]
fn coherence_is_a_window_or_repeats_and_what_cannot_be_together_says_so() {
    let viewer = Viewer::open(&[&["sphere"][..], &LARGE].concat());
    let (through_a_window, _) = viewer.shows("--coherence gaussian:4um");
    viewer.press("repeats");
    let (repeats, command) = viewer.shows("--coherence repeats:3x3");
    assert!(repeats != through_a_window, "{command}");
    viewer.says("where the orders are");
    // The hemisphere is drawn through the repeats, too: it is not black.
    let inset = |picture: &image::RgbImage| {
        (20..150)
            .flat_map(|x| (20..150).map(move |y| (x, y)))
            .filter(|(x, y)| picture.get_pixel(*x, *y).0.iter().any(|c| *c > 100))
            .count()
    };
    let shown = viewer.display.look(viewer.window).unwrap();
    assert!(inset(&shown) > 400, "{} bright pixels", inset(&shown));

    // No tables through repeats: the button does nothing, and the panel says why.
    viewer.says("tables are for a gaussian window");
    viewer.press("table");
    viewer.drag("copies", 1, 22);
    let copies = viewer.row("copies");
    let along_y = copies[1].text.strip_suffix(" in y").unwrap();
    assert!(along_y != "3" && copies[0].text == "3 in x", "{copies:?}");
    let (more, command) = viewer.shows(&format!("--coherence repeats:3x{along_y}"));
    assert!(more != repeats && !command.contains("--method"), "{command}");
    // Beside them, another setting through the same repeats.
    viewer.press("split");
    viewer.says("optimal, 1 %");
    viewer.press("alone");
    // What else decides them.
    viewer.drag("index", 0, 30);
    let index = viewer.row("index")[0].text.clone();
    assert_ne!(index, "1.50");
    viewer.shows(&format!("--ior {}", index.trim_end_matches('0')));

    viewer.press("gaussian");
    viewer.shows("--coherence gaussian:4um");
    viewer.press("table");
    viewer.shows("--method table");
    viewer.says("tables are for a gaussian window");
    viewer.press("repeats");
    viewer.drag("length", 0, 12);
    let (_, command) =
        viewer.save(&[]).1.split_once("--coherence ").map(|c| (c.0.to_owned(), c.1.to_owned())).unwrap();
    assert!(command.starts_with("gaussian:"), "{command}");
    viewer.close();
}

#[test]
fn lights_and_exposure_and_level_act_on_the_picture() {
    let viewer = Viewer::open(&[&["plate"][..], &LARGE].concat());
    let (first, _) = viewer.shows("--exposure 0");
    viewer.drag("exposure", 0, 20);
    let stops: f64 = viewer.row("exposure")[0].text.strip_suffix(" EV").unwrap().parse().unwrap();
    assert!(stops > 0.2, "{stops}");
    let (brighter, command) =
        viewer.save(&[]).1.split_once("--exposure ").map(|c| (c.0.len(), c.1.to_owned())).unwrap();
    assert!(brighter > 0 && !command.starts_with("0 "), "{command}");
    viewer.press("mean");
    viewer.shows("--level mean");
    viewer.press("add a light");
    viewer.says("remove");
    let lights = |command: &str| command.matches("--light ").count();
    let (two, command) = viewer.shows("--level mean");
    assert!(lights(&command) == 2 && two != first, "{command}");
    viewer.press("remove");
    let (_, command) = viewer.shows("--level mean");
    assert_eq!(lights(&command), 1, "{command}");
    viewer.close();
}
