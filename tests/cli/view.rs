//! The viewer in a real X window, driven as a hand drives it.

use crate::display::{Display, wait_for};
use crate::sandbox::{SMALL, Sandbox, outcome};
use image::RgbImage;
use std::process::{Child, Stdio};

const ESCAPE: u32 = 0xff1b;
const SHIFT: u32 = 0xffe1;

/// Quick to compute.
/// Through one window, at the centres of pixels.
const QUICK: [&str; 6] = ["--tolerance", "1e-1", "--windows", "1x1", "--size", "320x240"];

/// The viewer of `scene` on `display`.
fn view(sandbox: &Sandbox, display: &Display, more: &[&str]) -> Child {
    let arguments = [&["view", "--samples", "1"], more, &SMALL, &QUICK].concat();
    let mut command = sandbox.command(arguments);
    command.env("DISPLAY", &display.name).env("DIFFRACT_VALIDATION", "1");
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// A key by its letter.
fn letter(c: char) -> u32 {
    c.into()
}

/// Whether `shown` is `expected` where nothing stands on the picture: its lower edge has notes.
fn same(shown: &RgbImage, expected: &RgbImage) -> bool {
    const NOTES: u32 = 100;
    let rows = expected.height().saturating_sub(NOTES);
    let pixels = |p: &RgbImage| -> Vec<u8> { p.as_raw()[..(rows * p.width() * 3) as usize].to_vec() };
    shown.dimensions() == expected.dimensions() && rows > 0 && pixels(shown) == pixels(expected)
}

/// The picture that a saved one says to be: the command in its text, run, and how it was called.
fn told(sandbox: &Sandbox, saved: &str) -> (RgbImage, String) {
    let file = std::fs::File::open(sandbox.path(saved)).unwrap();
    let reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let texts = reader.info().utf8_text.iter().map(|t| t.get_text().unwrap());
    let command =
        texts.filter_map(|t| t.split_once("diffract render ").map(|c| c.1.to_owned())).next().unwrap();
    let words: Vec<&str> = command.split(' ').collect();
    let output = words.iter().position(|w| *w == "-o").unwrap();
    assert_eq!(words[output + 1], saved);
    let arguments = [&["render"], &words[..output], &["-o", "told.png"]].concat();
    sandbox.run(arguments).done();
    (image::open(sandbox.path("told.png")).unwrap().to_rgb8(), command)
}

/// Presses S and waits for the picture.
fn save(sandbox: &Sandbox, display: &Display, name: &str, held: &[u32]) -> RgbImage {
    display.key(letter('s'), held);
    wait_for(name, || sandbox.path(name).is_file().then_some(()));
    image::open(sandbox.path(name)).unwrap().to_rgb8()
}

#[test]
fn the_window_shows_and_saves_what_render_draws_through_drags_keys_drops_and_sizes() {
    let (sandbox, display) = (Sandbox::with_small_surface(), Display::new());
    sandbox.run2(&["surface", "synth", "blaze", "-o", "blaze.png"], &["--patch", "5um"]).done();
    let square =
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0.5\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    sandbox.write("square.obj", square);
    let program = view(&sandbox, &display, &["sphere"]);
    let window = display.window();
    wait_for("the size", || display.look(window).filter(|p| p.dimensions() == (320, 240)));
    for key in ['p', 'b', 'l'] {
        display.key(letter(key), &[]);
    }
    let shows = |expected: &RgbImage, what: &str| {
        wait_for(what, || display.look(window).filter(|shown| same(shown, expected)));
    };
    // At first, what `render` draws without a word about camera and lights.
    let plain = [&["render", "sphere", "--samples", "1", "-o", "plain.png"][..], &SMALL, &QUICK].concat();
    sandbox.run(plain).done();
    let plain = image::open(sandbox.path("plain.png")).unwrap().to_rgb8();
    shows(&plain, "the picture of render");
    assert!(save(&sandbox, &display, "diffract-001.png", &[]) == plain);

    // The hand: orbit, pan, zoom, light.
    display.drag(1, [150, 90], [200, 110]);
    display.drag(2, [150, 90], [160, 100]);
    display.click(4, [150, 90], 2);
    display.drag(3, [150, 90], [130, 120]);
    let moved = save(&sandbox, &display, "diffract-002.png", &[]);
    let (again, command) = told(&sandbox, "diffract-002.png");
    assert!(moved == again && moved != plain, "{command}");
    for option in ["--eye", "--target", "--light"] {
        assert!(command.contains(option), "{command}");
    }
    shows(&moved, "the saved picture");
    display.key(letter('r'), &[]);
    shows(&plain, "the picture of the start again");

    // Another size, and none at all for a while.
    display.resize(window, [1, 1]);
    display.resize(window, [360, 300]);
    let larger = [
        &["render", "sphere", "--samples", "1", "-o", "larger.png"][..],
        &SMALL,
        &QUICK[..4],
        &["--size", "360x300"],
    ];
    sandbox.run(larger.concat()).done();
    let larger = image::open(sandbox.path("larger.png")).unwrap().to_rgb8();
    shows(&larger, "the picture of the new size");
    display.hide_and_show(window);
    shows(&larger, "the picture after it was hidden");

    // Files dropped on the window: a height field, a mesh.
    display.drop_file(window, &sandbox.path("blaze.png"));
    wait_for("the surface in the title", || display.title(window).contains("blaze.png").then_some(()));
    display.drop_file(window, &sandbox.path("square.obj"));
    wait_for("the mesh in the title", || display.title(window).contains("square.obj").then_some(()));
    let shown_before = larger;
    wait_for("the new picture", || display.look(window).filter(|shown| !same(shown, &shown_before)));
    let mut number = 3;
    // The surface may still be in the making: what is saved says which one it shows.
    wait_for("the dropped files in a saved picture", || {
        let name = format!("diffract-{number:03}.png");
        number += 1;
        let dropped = save(&sandbox, &display, &name, &[SHIFT]);
        let (again, command) = told(&sandbox, &name);
        assert!(dropped == again, "{command}");
        (command.contains("square.obj") && command.contains("blaze.png")).then_some(())
    });
    let last = format!("diffract-{:03}", number - 1);
    wait_for("the EXR", || sandbox.path(format!("{last}.exr")).is_file().then_some(()));
    let radiance = |name: &str| image::open(sandbox.path(name)).unwrap().to_rgba32f();
    let (_, command) = told(&sandbox, &format!("{last}.png"));
    let words: Vec<&str> = command.split(' ').take_while(|w| *w != "-o").collect();
    sandbox.run([&["render"], &words[..], &["-o", "told.exr"]].concat()).done();
    assert!(radiance(&format!("{last}.exr")) == radiance("told.exr"), "{command}");

    display.close(window);
    assert_eq!(outcome(program).done(), "");
}

#[test]
fn a_split_shows_both_settings_and_errors_have_colours_and_escape_closes() {
    let (sandbox, display) = (Sandbox::with_small_surface(), Display::new());
    let program = view(&sandbox, &display, &["plate", "--terms", "2", "--present", "immediate"]);
    let window = display.window();
    let render = |name: &str, more: &[&str]| {
        sandbox
            .run([&["render", "plate", "--samples", "1", "-o", name][..], &SMALL, &QUICK[2..], more].concat())
            .done();
        image::open(sandbox.path(name)).unwrap().to_rgb8()
    };
    let own = render("own.png", &["--tolerance", "1e-1", "--terms", "2"]);
    let other = render("other.png", &["--tolerance", "1e-2", "--basis", "optimal"]);
    assert!(own != other);
    for key in ['p', 'b', 'l'] {
        display.key(letter(key), &[]);
    }
    wait_for("the picture", || display.look(window).filter(|shown| same(shown, &own)));
    display.key(letter('c'), &[]);
    // The names of both settings stand at the top, the line and its grip in the middle.
    let half = |shown: &RgbImage, expected: &RgbImage, columns: std::ops::Range<u32>| {
        shown.dimensions() == expected.dimensions()
            && columns.clone().all(|x| (60..140).all(|y| shown.get_pixel(x, y) == expected.get_pixel(x, y)))
    };
    wait_for("both settings", || {
        display.look(window).filter(|s| half(s, &own, 0..150) && half(s, &other, 170..320))
    });
    // Dragged to the right, the line leaves more of the own setting.
    display.drag(1, [160, 100], [240, 100]);
    wait_for("the moved split", || {
        display.look(window).filter(|s| half(s, &own, 0..230) && half(s, &other, 250..320))
    });
    display.key(letter('c'), &[]);
    wait_for("errors in false colour", || {
        let shown = display.look(window)?;
        let covered = other.get_pixel(256, 100) != other.get_pixel(0, 0);
        let colors = |p: &RgbImage| (250..262).map(|x| *p.get_pixel(x, 100)).collect::<Vec<_>>();
        (covered && colors(&shown) != colors(&other) && half(&shown, &own, 0..230)).then_some(())
    });
    // Escape ends the comparison first, then the program.
    display.key(ESCAPE, &[]);
    wait_for("the own setting alone", || display.look(window).filter(|shown| same(shown, &own)));
    display.key(ESCAPE, &[]);
    assert_eq!(outcome(program).done(), "");
}

#[test]
fn without_a_display_one_line_says_what_to_do_instead() {
    let sandbox = Sandbox::new();
    let line = sandbox.run(["view"]).refused(1);
    assert!(line.contains("no display") && line.contains("diffract render"), "{line}");
    let nowhere = Sandbox::new().with("DISPLAY", ":4711");
    let mut command = nowhere.command(["view"]);
    command.env("DISPLAY", ":4711");
    let child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let line = outcome(child).refused(1);
    assert!(line.contains("display") && line.contains("diffract render"), "{line}");
}

#[test]
fn a_display_that_vanishes_ends_the_program_with_exit_code_1() {
    let (sandbox, display) = (Sandbox::with_small_surface(), Display::new());
    let program = view(&sandbox, &display, &["plate"]);
    display.window();
    display.vanish();
    let ended = outcome(program);
    // The last word is that of the system's library of the display, which ends the program.
    assert!(ended.code == Some(1) && ended.stderr.contains("X server"), "{ended:?}");
}
