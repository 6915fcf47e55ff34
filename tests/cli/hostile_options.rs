//! Values without a meaning, for every option of every command.

use crate::sandbox::{Sandbox, grey_png};
use crate::usage::COMMANDS;

/// What no option that takes a number takes.
const NO_NUMBER: &[&str] =
    &["", " ", "x", "nan", "NaN", "inf", "-inf", "1e999", "0x10", "\u{661}", "1 2", "--", "\n"];
const NO_LENGTH: &[&str] = &[
    "5", "0nm", "-0nm", "-5nm", "nm", "NaNnm", "infum", "-infnm", "1e999nm", "1e-300nm", "1e300m", "2m",
    "12parsec", "1,5nm", "5nm5", "5 n m",
];
const NO_PAIR: &[&str] = &["5nmx", "x5nm", "5nmx5nmx5nm", "0nmx5nm", "5nmx-5nm", "5x5nm"];
const NO_COUNTS: &[&str] = &[
    "3",
    "x",
    "0x3",
    "3x0",
    "3x",
    "x3",
    "-1x4",
    "4x-1",
    "+3x3",
    "3.0x3",
    "1e2x1",
    "3x3x3",
    "99999999999x1",
    "65536x1",
];

const NO_RANGE: &[&str] = &[
    ":",
    "::",
    "400:700",
    "400:700:",
    "400:700:1:1",
    ":700:1",
    "700:400:1",
    "400:700:0",
    "400:700:-1",
    "nan:700:1",
    "400:inf:1",
    "400:700:nan",
    "400:700:1e-9",
    "700:400:-1",
    "-700:-400:1",
    "400-700",
];

const NO_TRIPLE: &[&str] =
    &["1", "1,2", "1,2,", "1,2,3,4", "1,2,x", "nan,0,0", "0,inf,0", "1;2;3", "1,2,3um"];

/// Each option with values that it has to refuse, beside what its kind refuses.
const BAD: &[(&str, &[&[&str]])] = &[
    ("--tolerance", &[NO_NUMBER, &["0", "-0", "-1", "2", "1e-9", "1um", "1,5", "5e-324"]]),
    (
        "--terms",
        &[NO_NUMBER, &["0", "-1", "1.5", "129", "1e1", "18446744073709551616", "-9223372036854775808"]],
    ),
    // A count for colours, a range for peaks.
    (
        "--wavelengths",
        &[
            NO_NUMBER,
            NO_RANGE,
            &["0", "3", "-1", "4097", "16.5", "99999999999999999999", "9:500:1", "380nm:780nm:1nm"],
        ],
    ),
    ("--angles", &[NO_NUMBER, NO_RANGE, &["30", "-91:0:1", "0:91:1", "0:1:1", "5:5:1", "-90:90:0.0001"]]),
    ("--width", &[NO_NUMBER, NO_LENGTH, &["85", "0mm", "-85mm", "1mm", "3000mm", "85um", "85mmx85mm"]]),
    ("--font-size", &[NO_NUMBER, &["7", "0pt", "-7pt", "pt", "nanpt", "101pt", "7px"]]),
    ("--dpi", &[NO_NUMBER, &["0", "-300", "9", "4801", "300dpi"]]),
    ("--theme", &[&["", " ", "Light", "grey", "-dark", "light,dark"]]),
    ("--panels", &[&["", " ", ",", "everything", "heights,,", "-heights"]]),
    ("--no-caption", &[&["x", "-1"]]),
    ("--theta-i", &[NO_NUMBER, &["90", "-90", "400", "30deg", "1,5"]]),
    ("--axis", &[&["", " ", "nan", "z", "X", "-x", "xy"]]),
    (
        "--compare",
        &[&[
            "",
            " ",
            "spectral",
            "a,b",
            "spectral,",
            ",",
            "spectral,reference,taylor",
            "laser:3um,spectral",
            "spectral,repeats:0x1",
        ]],
    ),
    (
        "--plot",
        &[&["", "none/plot.png", ".", "/dev/zero", "grey.png/plot.png", "plot.gif", "plot", "folder.png"]],
    ),
    ("--order", &[NO_NUMBER, &["0", "-1", "1.5", "1001", "99999999999999999999"]]),
    ("--wavelength", &[NO_NUMBER, NO_LENGTH, &["5nm", "1mm", "400nmx500nm"]]),
    ("--ior", &[NO_NUMBER, &["0", "-1.5", "0.99", "11", "glass", "1,5", "1.5+0.1i"]]),
    ("--polarisation", &[&["", " ", "TE", "te,tm", "s", "0"]]),
    ("--reflectance", &[&["", " ", "Fresnel", "fresnel,schlick", "cook-torrance", "0.04"]]),
    ("--theory", &[&["", " ", "Stam", "small_slope", "small-slope,stam", "kirchhoff", "1"]]),
    ("--shadows", &[&["", " ", "yes", "true", "1", "ON"]]),
    ("--environment", &[&["", " ", "night", "none/sky.hdr", "folder.png", "grey.png", "Sky"]]),
    ("--rotate-environment", &[NO_NUMBER, &["90", "90um", "nandeg", "infdeg"]]),
    ("--environment-exposure", &[NO_NUMBER, &["41", "-41", "1EV", "1e9"]]),
    ("--material", &[&["", " ", "unobtainium", "none/gold.csv", "folder.png", "grey.png", "1.5"]]),
    (
        "--film",
        &[&[
            "",
            "120nm",
            ":1.7",
            "120:1.7",
            "0nm:1.7",
            "-1um:1.7",
            "3um:1.7",
            "120nm:0.9",
            "120nm:11",
            "120nm:nan",
        ]],
    ),
    // `brdf` takes a number alone.
    ("--exposure", &[NO_NUMBER, &["41", "-41", "1EV", "1e9", "Auto", "automatic", "auto,1", "-auto"]]),
    ("--tone", &[NO_NUMBER, &["filmic", "Neutral", "NONE", "neutral,none", "1"]]),
    ("--seed", &[NO_NUMBER, &["-1", "1.5", "1e3", "18446744073709551616"]]),
    (
        "--light",
        &[
            NO_NUMBER,
            &[
                "30", "30,", ",", "1,2,3,4", "91,0", "-1,0", "0,361", "0,0,0", "0,0,-1", "0,0,1e7", "NaN,0",
                "0,inf", "30deg,0",
            ],
        ],
    ),
    ("--aspecular", &[NO_NUMBER, &["200", "-60", "25,", "25;45", "25deg"]]),
    ("--view", &[NO_NUMBER, &["90", "-90,0", "0,361", "1,2,3", "30deg"]]),
    ("--geometry", &[&["", " ", "E2194", "45", "d8", "e2194,e2539"]]),
    ("--aperture", &[NO_NUMBER, &["2", "-1deg", "31deg", "2um", "nandeg"]]),
    ("--spectrum", &[&["", "none/out.csv", ".", "..", "/", "/dev/zero", "grey.png/out.csv", "folder.png"]]),
    // One value, of two.
    ("--sweep", &[NO_NUMBER, NO_RANGE, &["wavelength", "colour"]]),
    ("--least", &[NO_NUMBER, &["-1", "-1e-9", "1.5", "101%", "1e9"]]),
    ("--size", &[NO_NUMBER, NO_COUNTS, &["16385x1", "1280 720"]]),
    ("--windows", &[NO_NUMBER, NO_COUNTS, &["65x1"]]),
    (
        "--coherence",
        &[
            NO_NUMBER,
            &[
                "gaussian",
                "gaussian:",
                "gaussian:65",
                "gaussian:0um",
                "gaussian:-1um",
                "gaussian:nan",
                "gaussian:infum",
                "gaussian:1m",
                "gaussian:1nm",
                "repeats:0x1",
                "repeats:3",
                "repeats:10001x1",
                "laser:3um",
                ":",
            ],
        ],
    ),
    ("--pixel-size", &[NO_NUMBER, NO_LENGTH, NO_PAIR]),
    ("--height", &[NO_NUMBER, NO_LENGTH, &["5nmx5nm"]]),
    ("--profile", &[&["", "y", "x+", "(x", "1/0*x", "0.1 0.2", "x<0.5?1:0", "x; x"]]),
    ("--duty", &[NO_NUMBER, &["-0.1", "1.1", "40nm"]]),
    ("--flank", &[NO_NUMBER, NO_LENGTH, &["5nmx5nm", "2m", "-1nm"]]),
    ("--period", &[NO_NUMBER, NO_LENGTH, &["5nmx5nm", "1m"]]),
    ("--patch", &[NO_NUMBER, NO_LENGTH, NO_PAIR, &["1nm", "1m"]]),
    ("--present", &[NO_NUMBER, &["vsync", "FIFO"]]),
    ("--grooves", &[&["", " ", "xdeg", "deg", "nandeg", "infdeg", "1,5deg"]]), // others are names of files
    ("--scale", &[NO_NUMBER, NO_LENGTH, &["5nmx5nm"]]),
    ("--up", &[NO_NUMBER, &["Y", "y", "-z"]]), // y: the plate is no file
    ("--eye", &[NO_NUMBER, NO_TRIPLE, &["0,0,1e10"]]),
    ("--target", &[NO_NUMBER, NO_TRIPLE]),
    ("--field-of-view", &[NO_NUMBER, &["35", "0deg", "-35deg", "171deg", "35um", "nandeg"]]),
    ("--orthographic", &[NO_NUMBER, &["0", "-1", "35deg", "2m", "1,2"]]),
    ("--roll", &[NO_NUMBER, &["35", "35um", "nandeg", "infdeg"]]),
    ("--lens-shift", &[NO_NUMBER, &["0.1", "1,2,3", "0,101", "-101,0"]]),
    ("--depth", &[&["x", ""]]), // takes no value, and the scene is named already
    ("--background", &[NO_NUMBER, NO_TRIPLE, &["-0.1,0,0", "0,0,1.1", "sky"]]),
    ("--base-color", &[NO_NUMBER, NO_TRIPLE, &["-0.1,0,0", "0,0,1.1"]]),
    (
        "--level",
        &[NO_NUMBER, &["top", "Mean", "none,mean", "polynomial", "polynomial:0", "polynomial:13", "rows:2"]],
    ),
    ("--despike", &[&["x", ""]]), // takes no value, and the surface is named already
    ("--destripe", &[&["x", ""]]), // the same
    ("--deconvolve-tip", &[NO_NUMBER, NO_LENGTH, &["5nmx5nm"]]),
    ("--invert", &[&["x", ""]]), // the same
    ("--crop", &[NO_NUMBER, NO_LENGTH, NO_PAIR, &["2um", "90nm+2um+0um", "90nm+0um", "90nm+0um+0um+0um"]]),
    ("--resample", &[NO_NUMBER, NO_LENGTH, NO_PAIR, &["0.01nm"]]),
    ("--rotate", &[NO_NUMBER, &["30", "361deg", "30um", "Auto", "auto,30deg"]]),
    ("--taper", &[NO_NUMBER, NO_LENGTH, &["2um", "5nmx5nm"]]),
    ("--tile", &[NO_NUMBER, &["mirrors", "mirror:5um", "blend:", "blend:0um", "blend:2um"]]),
    ("--plot", &[&["", "none/out.png", ".", "/dev/zero", "grey.png/out.png", "out.gif", "out"]]),
    ("--beyond", &[NO_NUMBER, &["copy", "COPIES", "copies,alike", "none"]]),
    ("--method", &[NO_NUMBER, &["guess", "SPECTRAL"]]),
    ("--basis", &[NO_NUMBER, &["fourier"]]),
    ("--illuminant", &[NO_NUMBER, &["d55", "missing.csv", ".", "/dev/zero", "grey.png"]]),
    ("--surface", &[NO_NUMBER, &["nothing", "nothing.png", ".", "/dev/zero", "q.csv", "grey.png/x.png"]]),
    ("--cache-size", &[NO_NUMBER, &["500", "-1MB", "2gib", "8388609TiB", "1e400GB", "infMiB"]]),
    ("--footprint", &[NO_NUMBER, &["-0.1", "-1", "2.1", "0.02um"]]),
    ("--budget", &[NO_NUMBER, &["500", "-1MB", "8mb per", "1e400GB", "1B"]]),
    ("--check", &[&["", "nothing", ".", "grey.png", "folder.png", "/dev/zero"]]),
    ("--table", &[&["", "nothing", ".", "grey.png", "folder.png", "/dev/zero"]]),
    ("--html", &[&["", "none/out.html", ".", "..", "/", "/dev/zero", "grey.png/out.html", "folder.png"]]),
    ("--mesh", &[&["", "nothing", ".", "grey.png", "folder.png", "/dev/zero", "none/of.obj"]]),
    ("--answers", &[&["", "nothing.csv", ".", "grey.png"]]), // there is nothing to check
    ("--channel", &[&["", " ", "phase", "0", "2", "-1", "1.0"]]),
    ("--device", &[&["", " ", "nothing", "7", "-1", "99999999999999999999", "\n"]]),
    ("--folder", &[&["", "/dev/zero", "grey.png", "grey.png/trade"]]),
    ("--fps", &[NO_NUMBER, &["0", "-15", "1e6", "15fps"]]),
    ("--explain", &[&["--explain"]]), // twice
    ("--quick", &[&["--quick"]]),     // twice
    ("--queries", &[&["", "nothing.csv", ".", "/dev/zero", "grey.png"]]),
    // A count for profile, a range for render, where there is no sequence to take a part of.
    ("--frames", &[NO_NUMBER, &["0", "2", "-3", "1e3", "100001", "0..2", "2..2", "3..2", "..", "0..=2"]]),
    ("--turntable", &[NO_NUMBER, &["0", "-3", "1.5", "1e3", "10001"]]),
    ("--light-sweep", &[NO_NUMBER, &["0", "-3", "1.5", "1e3", "10001"]]),
    ("--samples", &[NO_NUMBER, &["0", "-3", "1.5", "1e3", "4097"]]),
    ("--sample-pixels", &[NO_NUMBER, &["0", "-3", "1.5", "1e3", "268435457", "10"]]), // 10: not with spectral
    ("--error", &[NO_NUMBER, &["0", "-3", "1.5", "1e3", "268435457", "ALL", "some"]]),
    ("--json", &[&["", "none/out.json", ".", "/dev/zero", "grey.png/out.json"]]),
    ("--output", &[&["", "none/out.png", ".", "..", "/", "/dev/zero", "grey.png/out.png", "folder.png"]]),
];

/// Arguments with which each command runs, and succeeds where a device is there.
fn sound(command: &[&str]) -> Vec<&'static str> {
    const SURFACE: [&str; 6] = ["--surface", "grey.png", "--pixel-size", "90nm", "--height", "100nm"];
    const OPTICS: [&str; 4] = ["--coherence", "gaussian:4um", "--tolerance", "1e-1"];
    match command {
        ["view"] => [&["plate", "--size", "64x48"][..], &SURFACE, &OPTICS].concat(),
        ["render"] => [&["plate", "--size", "4x4", "--output", "out.png"][..], &SURFACE, &OPTICS].concat(),
        ["eval"] => [&["--queries", "q.csv", "--output", "out.png"][..], &SURFACE, &OPTICS].concat(),
        ["export"] => [&["--output", "material", "--html", "page.html"][..], &SURFACE, &OPTICS].concat(),
        ["brdf"] => {
            let own = ["--light", "30,0", "--size", "4x4", "--output", "out.png"];
            [&own[..], &SURFACE, &OPTICS].concat()
        }
        ["colour"] => {
            let own = ["--light", "45", "--aspecular", "25,60", "--output", "out.png"];
            [&own[..], &SURFACE, &OPTICS].concat()
        }
        ["orders"] => {
            let own = ["--light", "30,0", "--wavelength", "550nm", "--output", "out.png"];
            [&own[..], &SURFACE].concat()
        }
        ["peaks"] => {
            let own = ["--theta-i", "30", "--angles", "-40:-20:1", "--wavelengths", "500:600:50"];
            [&own[..], &["--output", "out.png"], &SURFACE, &OPTICS].concat()
        }
        ["profile"] => [&["plate", "--size", "4x4", "--frames", "3"][..], &SURFACE, &OPTICS].concat(),
        ["trade"] => {
            let own = ["plate", "--quick", "--size", "4x4", "--folder", "trade"];
            [&own[..], &SURFACE, &OPTICS[..2]].concat()
        }
        ["surface", "info"] => SURFACE.to_vec(),
        ["surface", "compare"] => {
            [&["grey.png", "--aspecular", "25,60", "--aperture", "0deg"], &SURFACE[2..], &OPTICS].concat()
        }
        ["surface", "convert"] => [&SURFACE[..], &["--output", "out.gsf"]].concat(),
        ["surface", "synth"] => vec!["blaze", "--output", "out.png"],
        ["lights"] => vec!["sky", "--output", "out.png"],
        ["completions"] => vec!["bash"],
        ["manual"] => vec!["folder.png"],
        _ => vec![],
    }
}

/// The long options in the help of `command`.
fn options(sandbox: &Sandbox, command: &[&str]) -> Vec<String> {
    let help = sandbox.run2(command, &["--help"]).done();
    let lines = help.lines().filter_map(|line| {
        let line = line.trim_start();
        let line = line.strip_prefix("-o, ").or_else(|| line.strip_prefix("-h, ")).unwrap_or(line);
        line.starts_with("--").then(|| line.split([' ', '=']).next().unwrap_or_default().to_owned())
    });
    lines.filter(|option| option != "--help").collect()
}

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("grey.png", grey_png(12, 12, |x, y| (x * 20 + y) as u8));
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n20,0,20,180,550\n");
    std::fs::create_dir(sandbox.path("folder.png")).unwrap();
    sandbox.write("folder.png/notes.txt", "x");
    sandbox
}

#[test]
fn the_sound_arguments_of_these_tests_are_sound() {
    let sandbox = sandbox();
    for (command, _) in COMMANDS.iter().filter(|(command, _)| *command != ["surface"]) {
        let outcome = sandbox.run2(command, &sound(command));
        match *command {
            // Everything else was found good before the display was missed.
            ["view"] => assert!(outcome.refused(1).contains("no display")),
            // A summary.
            ["peaks"] => assert_eq!((outcome.code, outcome.stderr.lines().count()), (Some(0), 1)),
            // That edges do not meet, the sum, and by how much it errs.
            ["orders"] => assert_eq!((outcome.code, outcome.stderr.lines().count()), (Some(0), 3)),
            _ => drop(outcome.done()),
        }
    }
}

#[test]
fn every_option_refuses_what_has_no_meaning() {
    let sandbox = sandbox();
    let before = sandbox.content();
    for (command, _) in COMMANDS.iter().filter(|(command, _)| *command != ["surface"]) {
        for option in options(&sandbox, command) {
            let (_, lists) = BAD
                .iter()
                .find(|(name, _)| *name == option)
                .unwrap_or_else(|| panic!("{command:?} {option} has no bad values in these tests"));
            let mut arguments = sound(command);
            if let Some(place) = arguments.iter().position(|a| *a == option) {
                arguments.drain(place..place + 2);
            }
            // A direction of these may be an angle alone, on either side of the normal.
            let takes_angles = matches!(*command, ["colour"] | ["surface", "compare"]);
            let is_sound =
                |value: &str| takes_angles && option == "--light" && ["30", "-1,0"].contains(&value);
            for value in lists.iter().copied().flatten().filter(|value| !is_sound(value)) {
                let what = format!("{command:?} {option} {value:?}");
                let line = sandbox.run2(command, &[&arguments[..], &[&option, value]].concat());
                // A device is looked for when there is a window.
                let in_window = *command == ["view"] && option == "--device";
                assert!(in_window || !line.stderr.contains("no display"), "{what} is taken");
                let listed = *command == ["devices"]; // lists the devices before it says that the wish is none
                if !listed {
                    line.refused_somehow(&what);
                }
                assert!(
                    matches!(line.code, Some(1 | 2)) && line.stderr.lines().count() == 1,
                    "{what}: {line:?}"
                );
                assert_eq!(sandbox.content(), before, "{what}");
                // With an equals sign, too, a value that starts with a minus reaches its option.
                if value.starts_with('-') && !listed {
                    let joined = format!("{option}={value}");
                    let line = sandbox.run2(command, &[&arguments[..], &[&joined]].concat());
                    line.refused_somehow(&joined);
                }
            }
        }
    }
}

#[test]
fn a_refused_number_is_named_with_its_option() {
    let sandbox = sandbox();
    for (option, value) in [
        ("--tolerance", "-1"),
        ("--terms", "-3"),
        ("--ior", "-1.5"),
        ("--height", "-5nm"),
        ("--pixel-size", "80"),
        ("--seed", "-7"),
        ("--light", "-10,0"),
        ("--size", "-4x4"),
        ("--coherence", "gaussian:-65um"),
        ("--exposure", "-99"),
    ] {
        let line = sandbox.run(["render", "plate", "-o", "out.png", option, value]).refused(2);
        let number = value.rsplit(':').next().unwrap();
        assert!(line.contains(option) && line.contains(number), "{line}");
        assert!(line.contains("`diffract render --help`"), "{line}");
    }
}

#[test]
fn a_picture_of_an_unknown_format_is_refused_before_work() {
    let sandbox = sandbox();
    for output in ["out", "out.gif", "out.jpeg", ".png", "out.png.", "out.png/", "out.p\u{148}g"] {
        sandbox.run2(&["render", "plate", "--surface", "grey.png", "-o"], &[output]).refused(2);
        sandbox.run2(&["surface", "synth", "blaze", "-o"], &[output]).refused(2);
    }
    assert!(sandbox.cache().read_dir().is_err(), "nothing was computed");
}

#[test]
fn absurd_but_sound_wishes_end_with_advice() {
    let sandbox = sandbox();
    let before = sandbox.content();
    for more in [
        &["--windows", "1x1", "--coherence", "gaussian:100mm"][..],
        &["--height", "1m"],
        &["--tolerance", "1e-6", "--height", "3um"],
    ] {
        let mut arguments = sound(&["render"]);
        for option in more.iter().filter(|a| a.starts_with("--")) {
            if let Some(place) = arguments.iter().position(|a| a == option) {
                arguments.drain(place..place + 2);
            }
        }
        let outcome = sandbox.run2(&["render"], &[&arguments[..], more].concat());
        outcome.without_questions().refused_somehow(&format!("{more:?}"));
        assert_eq!(sandbox.content(), before, "{more:?}");
    }
}
