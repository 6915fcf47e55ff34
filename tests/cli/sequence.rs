//! Sequences of pictures in numbered files.

use crate::sandbox::{Outcome, SMALL, Sandbox};
use std::fs;
use std::time::SystemTime;

/// Settings under which a picture is quick to make.
const QUICK: [&str; 6] = ["--size", "16x12", "--tolerance", "1e-1", "--samples", "2"];

fn render(sandbox: &Sandbox, more: &[&str]) -> Outcome {
    sandbox.run2(&[&["render", "plate"], &SMALL[..], &QUICK].concat(), more)
}

/// The pixels of a picture file.
fn pixels(sandbox: &Sandbox, name: &str) -> image::Rgba32FImage {
    image::open(sandbox.path(name)).unwrap_or_else(|e| panic!("{name}: {e}")).to_rgba32f()
}

fn written(sandbox: &Sandbox, name: &str) -> SystemTime {
    fs::metadata(sandbox.path(name)).unwrap().modified().unwrap()
}

/// Names of the files in the folder, in order.
fn names(sandbox: &Sandbox) -> Vec<String> {
    sandbox.content().keys().map(|name| name.to_string_lossy().into_owned()).collect()
}

#[test]
fn a_turntable_begins_with_the_plain_picture_and_goes_on_around_it() {
    let sandbox = Sandbox::with_small_surface();
    assert_eq!(render(&sandbox, &["-o", "plain.exr"]).done(), "");
    assert_eq!(render(&sandbox, &["--turntable", "3", "-o", "turn.exr"]).done(), "");
    assert_eq!(
        names(&sandbox),
        ["plain.exr", "small.png", "turn-0000.exr", "turn-0001.exr", "turn-0002.exr"]
    );
    let [first, second, third] = [0, 1, 2].map(|frame| pixels(&sandbox, &format!("turn-000{frame}.exr")));
    assert!(first == pixels(&sandbox, "plain.exr"), "the first picture is not the plain one");
    assert!(first != second && second != third && third != first);
    // What a picture says of itself draws it again, alone.
    let said = |name: &str| {
        let meta = exr::meta::MetaData::read_from_file(sandbox.path(name), false).unwrap();
        meta.headers[0].own_attributes.comments.as_ref().unwrap().to_string()
    };
    assert!(said("turn-0001.exr").contains(" --turntable 3 --frames 1..2\n"), "{}", said("turn-0001.exr"));
    let whole = sandbox.read("turn-0001.exr");
    fs::remove_file(sandbox.path("turn-0001.exr")).unwrap();
    render(&sandbox, &["--turntable", "3", "--frames", "1..2", "-o", "turn.exr"]).done();
    assert!(sandbox.read("turn-0001.exr") == whole, "a part of the sequence is another sequence");
}

#[test]
fn a_light_sweep_turns_the_light_and_a_second_run_draws_what_is_missing_alone() {
    let sandbox = Sandbox::with_small_surface();
    let sweep = |more: &[&str]| {
        render(&sandbox, &[&["--light", "40,10,2", "--light-sweep", "4", "-o", "sun.png"], more].concat())
    };
    let name = |frame: u32| format!("sun-000{frame}.png");
    sweep(&["--frames", "0..2"]).done();
    assert_eq!(names(&sandbox), ["small.png", "sun-0000.png", "sun-0001.png"]);
    let before = [0, 1].map(|frame| written(&sandbox, &name(frame)));
    let told = sweep(&[]);
    assert!(told.code == Some(0) && told.stderr.contains("2 of 4 pictures are there already"), "{told:?}");
    assert_eq!(
        [0, 1].map(|frame| written(&sandbox, &name(frame))),
        before,
        "finished pictures are drawn anew"
    );
    let drawn: Vec<_> = (0..4).map(|frame| pixels(&sandbox, &name(frame))).collect();
    assert!((1..4).all(|frame| drawn[frame] != drawn[frame - 1]), "the light does not move");
    // The light of the third picture is where 180 degrees put it.
    render(&sandbox, &["--light", "40,190,2", "-o", "plain.png"]).done();
    assert!(pixels(&sandbox, "plain.png") == drawn[2]);
    // Nothing is left to do, and no device is needed for it.
    let all = sandbox.content();
    assert_eq!(sweep(&["-q", "--device", "7"]).done(), "");
    assert_eq!(sandbox.content(), all);
}

#[test]
fn pictures_of_other_settings_are_neither_kept_nor_written_over() {
    let sandbox = Sandbox::with_small_surface();
    let turn = ["--turntable", "2", "-o", "turn.png"];
    render(&sandbox, &turn).done();
    fs::copy(sandbox.path("turn-0001.png"), sandbox.path("kept.png")).unwrap();
    let before = sandbox.content();
    for more in [
        &["--exposure", "1"][..],
        &["--seed", "2"],
        &["--ior", "1.4"],
        &["--light", "30,0"],
        &["--shadows", "off"],
        &["--environment", "studio"],
    ] {
        let line = render(&sandbox, &[&turn, more].concat()).refused(2);
        assert!(line.contains("turn-0000.png") && line.contains("another name"), "{more:?}: {line}");
    }
    // Another sequence begins with the same picture and goes on otherwise.
    render(&sandbox, &["--turntable", "3", "-o", "turn.png"]).refused(2);
    assert_eq!(sandbox.content(), before);
    // What the inputs hold counts, and not what they are called.
    let mut upside_down = image::open(sandbox.path("small.png")).unwrap();
    upside_down.invert();
    upside_down.save(sandbox.path("small.png")).unwrap();
    render(&sandbox, &turn).refused(2);
    sandbox.write("small.png", before[std::ffi::OsStr::new("small.png")].as_ref().unwrap());
    render(&sandbox, &[&turn[..], &["-q"]].concat()).done();
    // Neither is a picture of another place in the sequence, or what is no picture.
    for wrong in [sandbox.read("turn-0000.png"), b"no picture".to_vec()] {
        sandbox.write("turn-0001.png", wrong);
        assert!(render(&sandbox, &turn).refused(2).contains("turn-0001.png"));
    }
}

#[test]
fn a_damaged_picture_is_drawn_again_and_said() {
    let sandbox = Sandbox::with_small_surface();
    for name in ["turn.exr", "turn.png"] {
        let turn = ["--turntable", "2", "-o", name];
        render(&sandbox, &turn).done();
        let damaged = name.replace('.', "-0001.");
        let whole = sandbox.read(&damaged);
        let mut changed = whole.clone();
        let place = whole.len() - whole.len() / 8;
        changed[place] ^= 1;
        // The notes of so small a PNG are longer than its pixels; without them the file could be anybody's.
        let kept = if name.ends_with("exr") { whole.len() / 2 } else { whole.len() - 60 };
        for wrong in [&whole[..kept], &changed] {
            sandbox.write(&damaged, wrong);
            let told = render(&sandbox, &turn);
            assert!(told.code == Some(0) && told.stderr.contains(&damaged), "{told:?}");
            assert!(told.stderr.contains("is damaged and is drawn again"), "{told:?}");
            assert!(told.stderr.contains("1 of 2 pictures are there already"), "{told:?}");
            assert!(sandbox.read(&damaged) == whole, "{damaged} is another picture");
        }
        assert!(!render(&sandbox, &turn).stderr.contains("damaged"));
    }
}

#[test]
fn one_automatic_exposure_serves_all_pictures_whichever_part_is_drawn() {
    let sandbox = Sandbox::with_small_surface();
    let sweep = ["--light", "40,10,2", "--light-sweep", "3", "--exposure", "auto", "-o", "sun.png"];
    let told = render(&sandbox, &sweep);
    assert!(told.code == Some(0) && told.stderr.matches("exposure ").count() == 1, "{told:?}");
    let whole = sandbox.read("sun-0002.png");
    fs::remove_file(sandbox.path("sun-0002.png")).unwrap();
    let again = render(&sandbox, &[&sweep[..], &["--frames", "2..3"]].concat());
    assert_eq!(again.stderr, told.stderr, "the part measures another exposure");
    assert!(sandbox.read("sun-0002.png") == whole, "a part of the sequence is another sequence");
    // Another tone and an exposure that is named make other sequences.
    let sweep = ["--light", "40,10,2", "--light-sweep", "3", "-o", "sun.png"];
    for more in [&["--exposure", "auto", "--tone", "none"][..], &["--exposure", "0"], &[]] {
        render(&sandbox, &[&sweep[..], more].concat()).refused(2);
    }
}

#[test]
fn sequences_that_cannot_be_meant_are_refused_before_any_work() {
    let sandbox = Sandbox::with_small_surface();
    let dark = "mesh = \"plate\"\nsurface = \"blaze\"\nlights = []\n[camera]\neye = [0, 0, 3]\n\
                target = [0, 0, 0]\nfield_of_view = \"35deg\"\n";
    sandbox.write("dark.toml", dark);
    fs::copy(sandbox.path("small.png"), sandbox.path("small-0001.png")).unwrap();
    let before = sandbox.content();
    for (words, said) in [
        (&["plate", "--turntable", "4", "--light-sweep", "4", "-o", "a.png"][..], "give one of them"),
        (&["plate", "--frames", "0..4", "-o", "a.png"], "add --turntable N or --light-sweep N"),
        (&["plate", "--turntable", "4", "--frames", "2..5", "-o", "a.png"], "end at 4 at most"),
        (&["plate", "--turntable", "4", "--frames", "2..2", "-o", "a.png"], "as in 0..24"),
        (&["dark.toml", "--light-sweep", "4", "-o", "a.png"], "add a light"),
        (&["plate", "--turntable", "4", "--surface", "small-0001.png", "-o", "small.png"], "is the input"),
        (&["plate", "--turntable", "4", "-o", "none/a.png"], "none"),
    ] {
        let line = sandbox.run2(&["render"], words).refused_somehow(&format!("{words:?}"));
        assert!(line.contains(said), "{words:?}: {line}");
    }
    assert_eq!(sandbox.content(), before);
    assert!(sandbox.cache().read_dir().is_err(), "something was computed");
}
