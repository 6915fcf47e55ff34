//! Files that are missing, damaged, of another kind, or no files at all.

use crate::sandbox::{SMALL, Sandbox, encoded, grey_png};
use std::fs;
use std::path::Path;

const QUERY: &str = "theta_i,phi_i,theta_r,phi_r,wavelength\n20,0,20,180,550\n";
const SCENE: &str = "mesh = \"plate\"\nsurface = \"flat\"\nlights = [\"40,180,2\"]\n[camera]\neye = [1.1, -0.9, 1.5]\n\
                     target = [0, 0, 0]\nfield_of_view = \"35deg\"\n";

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("q.csv", QUERY);
    sandbox.write("scene.toml", SCENE);
    sandbox
}

/// Every way to hand `file` to the program as an input, each beside sound inputs.
fn uses(file: &str) -> Vec<Vec<&str>> {
    let units = ["--pixel-size", "90nm", "--height", "100nm"];
    let small = ["--coherence", "gaussian:4um", "--tolerance", "1e-1"];
    let out = ["-o", "out.png"];
    vec![
        [&["surface", "info", file][..], &units].concat(),
        [&["eval", file, "--queries", "q.csv", "--method", "reference"][..], &units, &out].concat(),
        [&["eval", "--queries", file, "--method", "reference"][..], &SMALL, &out].concat(),
        [&["render", "plate", "--surface", file, "--size", "4x4"][..], &units, &small, &out].concat(),
        [&["render", file, "--surface", "bumps", "--size", "4x4"][..], &small, &out].concat(),
        [&["render", "plate", "--illuminant", file, "--surface", "bumps", "--size", "4x4"][..], &small, &out]
            .concat(),
    ]
}

/// Asserts that `arguments` are refused in one line and leave nothing.
#[track_caller]
fn refused(sandbox: &Sandbox, arguments: &[&str]) -> String {
    let before = sandbox.content();
    let line = sandbox.run(arguments).refused_somehow(&format!("{arguments:?}"));
    assert_eq!(sandbox.content(), before, "{arguments:?}");
    line
}

#[test]
fn what_is_no_sound_file_is_refused_everywhere() {
    let sandbox = sandbox();
    for extension in ["png", "toml", "obj", "csv"] {
        let name = |kind: &str| format!("{kind}.{extension}");
        sandbox.write(&name("empty"), "");
        sandbox.write(&name("binary"), [0u8, 255, 254, 0, 137, 10, 13, 10, 26].repeat(50));
        sandbox.write(&name("text"), "one two three\n");
        sandbox.write(&name("long"), vec![b'9'; 1 << 20]);
        fs::create_dir(sandbox.path(name("folder"))).unwrap();
        for kind in ["missing", "empty", "binary", "text", "long", "folder"] {
            let file = name(kind);
            for arguments in uses(&file) {
                let line = refused(&sandbox, &arguments);
                assert!(line.len() < 1000, "{file}: {} characters", line.len());
            }
        }
    }
}

#[cfg(unix)]
#[test]
fn devices_pipes_and_links_that_lead_nowhere_are_refused_without_waiting() {
    let sandbox = sandbox();
    for extension in ["png", "toml", "obj", "csv"] {
        let [pipe, lost, around, zero] =
            ["pipe", "lost", "around", "zero"].map(|n| format!("{n}.{extension}"));
        let made = std::process::Command::new("mkfifo").arg(sandbox.path(&pipe)).status().unwrap();
        assert!(made.success());
        let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, sandbox.path(name)).unwrap();
        link("nowhere", &lost);
        link(&around, &around);
        link("/dev/zero", &zero);
        for file in [&pipe, &lost, &around, &zero] {
            for arguments in uses(file) {
                refused(&sandbox, &arguments);
            }
        }
    }
}

#[cfg(unix)]
#[test]
fn files_that_may_not_be_read_are_refused() {
    use std::os::unix::fs::PermissionsExt;
    let sandbox = sandbox();
    for extension in ["png", "toml", "obj", "csv"] {
        let file = format!("closed.{extension}");
        sandbox.write(&file, "x");
        fs::set_permissions(sandbox.path(&file), fs::Permissions::from_mode(0o0)).unwrap();
        for arguments in uses(&file) {
            refused(&sandbox, &arguments); // an administrator reads it, and then it is no sound file
        }
    }
}

#[test]
fn height_images_that_are_cut_coloured_or_of_another_kind_are_refused() {
    let sandbox = sandbox();
    let whole = sandbox.read("small.png");
    let coloured = image::RgbImage::from_fn(9, 9, |x, _| image::Rgb([x as u8, 7, 7]));
    let with_palette = image::Rgb32FImage::from_pixel(3, 3, image::Rgb([0.5; 3]));
    let mut float = std::io::Cursor::new(Vec::new());
    image::DynamicImage::from(with_palette).write_to(&mut float, image::ImageFormat::Tiff).unwrap();
    let mut wide = grey_png(2, 2, |_, _| 0);
    wide[16..20].copy_from_slice(&0x7fff_ffff_u32.to_be_bytes()); // says that it is two thousand million wide
    let mut none = grey_png(2, 2, |_, _| 0);
    none[16..20].copy_from_slice(&0_u32.to_be_bytes());
    let bad: [(&str, Vec<u8>); 8] = [
        ("half", whole[..whole.len() / 2].to_vec()),
        ("head", whole[..40].to_vec()),
        (
            "flipped",
            whole.iter().enumerate().map(|(i, b)| if i == whole.len() / 2 { !b } else { *b }).collect(),
        ),
        ("coloured", encoded(coloured.into())),
        ("float", float.into_inner()),
        ("wide", wide),
        ("none", none),
        ("too-long", grey_png(16_385, 1, |_, _| 9)),
    ];
    for (name, bytes) in &bad {
        let file = format!("{name}.png");
        sandbox.write(&file, bytes);
        for arguments in [0, 1, 3].map(|i| uses(&file).swap_remove(i)) {
            let line = refused(&sandbox, &arguments);
            assert!(line.contains(&file), "{line}");
        }
    }
}

#[test]
fn bad_rows_of_queries_are_refused_by_line() {
    let sandbox = sandbox();
    let header = "theta_i,phi_i,theta_r,phi_r,wavelength";
    for (rows, part) in [
        (format!("{header}\n20,0,20,180,550\n20,0,x,180,550\n"), "line 3"),
        (format!("{header}\n20,0,20,180\n"), "line 2"),
        (format!("{header}\n20,0,20,180,550,7\n"), "line 2"),
        (format!("{header}\n20,0,,180,550\n"), "line 2"),
        (format!("{header}\n20,0,nan,180,550\n"), "line 2"),
        (format!("{header}\n20,0,1e999,180,550\n"), "line 2"),
        (format!("{header}\n20,0,20,180,0\n"), "line 2"),
        (format!("{header}\n20,0,20,180,-550\n"), "-550"),
        (format!("{header}\n20,0,20,180,1e300\n"), "line 2"),
        (format!("{header}\n20,0,20,180,550nm\n"), "550nm"),
        (format!("{header}\n20;0;20;180;550\n"), "line 2"),
        (format!("{header}\n"), "no queries"),
        ("theta_i,phi_i,theta_r,wavelength\n1,2,3,4\n".to_owned(), "phi_r"),
        (format!("{header},theta_i\n1,2,3,4,5,6\n"), "theta_i"),
        ("20,0,20,180,550\n".to_owned(), "theta_i"),
        (format!("{header}\n\"20,0,20,180,550\n"), "line 2"),
        (format!("{header}\n20,0,{},180,550\n", "9".repeat(400)), "line 2"),
        (format!("{header}\n20,0,{},180,550\n", "x".repeat(100_000)), "line 2"),
    ] {
        sandbox.write("bad.csv", &rows);
        let line = refused(&sandbox, &uses("bad.csv")[2]);
        assert!(line.contains("bad.csv") && line.contains(part), "`{part}` is missing in: {line}");
        assert!(line.len() < 1000, "{} characters", line.len());
    }
}

#[test]
fn bad_scenes_are_refused_by_name() {
    let sandbox = sandbox();
    let with = |old: &str, new: &str| {
        assert!(SCENE.contains(old), "{old}");
        SCENE.replacen(old, new, 1)
    };
    for (scene, part) in [
        (format!("colour = 3\n{SCENE}"), "colour"),
        (with("mesh = \"plate\"", "mesh = 3"), "line 1"),
        (with("mesh = \"plate\"\n", ""), "mesh"),
        (with("\"plate\"", "\"missing.obj\""), "missing.obj"),
        (with("\"plate\"", "\"/dev/zero\""), "/dev/zero"),
        (with("\"plate\"", "\"\""), ""),
        (with("\"flat\"", "\"missing.png\""), "missing.png"),
        (with("\"flat\"", "\"/dev/zero\""), "/dev/zero"),
        (with("\"40,180,2\"", "\"40\""), "40"),
        (with("\"40,180,2\"", "40"), "line 3"),
        (with("35deg", "35"), "35"),
        (with("35deg", "0deg"), "field of view"),
        (with("35deg", "NaNdeg"), ""),
        (with("35deg", "180deg"), "field of view"),
        (with("[1.1, -0.9, 1.5]", "[0, 0, 0]"), "two"),
        (with("[1.1, -0.9, 1.5]", "[nan, 0, 0]"), ""),
        (with("[1.1, -0.9, 1.5]", "[inf, 0, 0]"), ""),
        (with("[1.1, -0.9, 1.5]", "[1e300, 0, 0]"), ""),
        (with("[1.1, -0.9, 1.5]", "[1, 2]"), "line 5"),
        (format!("exposure = nan\n{SCENE}"), "exposure"),
        (format!("exposure = 1e9\n{SCENE}"), "exposure"),
        (format!("tone = \"filmic\"\n{SCENE}"), "none or neutral"),
        (format!("tone = 1\n{SCENE}"), "line 1"),
        (format!("base_color = [2, 0, 0]\n{SCENE}"), "colour"),
        (format!("background = [nan, 0, 0]\n{SCENE}"), "colour"),
        (format!("up = \"x\"\n{SCENE}"), "line 1"),
        (format!("pixel_size = \"5\"\n{SCENE}"), "5"),
        (format!("height = \"-5nm\"\n{SCENE}"), "-5nm"),
        (format!("pigment = \"missing.png\"\n{SCENE}"), "missing.png"),
        (format!("pigment = \"/dev/zero\"\n{SCENE}"), "/dev/zero"),
        (format!("pigment = \"q.csv\"\n{SCENE}"), "q.csv"),
        (format!("exposure = \"bright\"\n{SCENE}"), "\"auto\""),
        (
            format!("{SCENE}[[objects]]\nmesh = \"disc\"\nsurface = \"cd\"\nheight = \"1m\"\n"),
            "object 1: the heights",
        ),
        (format!("{SCENE}[options]\nseed = 18446744073709551616\n"), "18446744073709551615"),
        (format!("{SCENE}[options]\ntolerance = 1e300\n"), "`1e300`"),
        (format!("{SCENE}[options]\nsamples = true\n"), "`samples` is a boolean"),
        (format!("{SCENE}["), "line"),
        (format!("{}{SCENE}", "[".repeat(100_000)), "line 1"),
        ("\u{0}".to_owned(), ""),
    ] {
        sandbox.write("bad.toml", &scene);
        let small = ["--coherence", "gaussian:4um", "--tolerance", "1e-1", "--size", "4x4", "-o", "out.png"];
        let line = refused(&sandbox, &[&["render", "bad.toml"][..], &small].concat());
        assert!(line.contains(part), "`{part}` is missing in: {line}");
        assert!(line.contains("bad.toml") || !part.is_empty(), "{line}");
        assert!(line.len() < 1000, "{} characters", line.len());
    }
}

#[test]
fn bad_meshes_are_refused_by_name() {
    let sandbox = sandbox();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for mesh in [
        corners.to_owned(),
        format!("{corners}f 1 2 4\n"),
        format!("{corners}f 1 2 0\n"),
        format!("{corners}f 1 2 -9\n"),
        format!("{corners}f 1 2 99999999999999999999\n"),
        format!("{corners}f 1 2\n"),
        format!("{corners}f 1 1 1\n"),
        "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
        "v 0 0 1e999\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
        "v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
        "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n".to_owned(),
        "glTF\n".to_owned(),
    ] {
        sandbox.write("bad.obj", &mesh);
        let line = refused(&sandbox, &uses("bad.obj")[4]);
        assert!(line.contains("bad.obj"), "{line}");
    }
}

#[test]
fn bad_spectra_are_refused_by_name() {
    let sandbox = sandbox();
    for spectrum in [
        "380,1\n",
        "wavelength,power\n380,x\n780,1\n",
        "380,-1\n780,1\n",
        "380,0\n780,0\n",
        "380,nan\n780,1\n",
        "780,1\n380,1\n",
        "380,1e999\n780,1\n",
        "10,1\n20,1\n",
    ] {
        sandbox.write("bad.csv", spectrum);
        let line = refused(&sandbox, &uses("bad.csv")[5]);
        assert!(line.contains("bad.csv"), "{spectrum:?}: {line}");
    }
}

/// Commands that write `output`, quick ones.
fn writers(output: &str) -> [Vec<&str>; 3] {
    let render = ["render", "plate", "--size", "4x4", "--tolerance", "1e-1", "-o", output];
    let eval = ["eval", "--queries", "q.csv", "--method", "reference", "-o", output];
    [
        [&render[..], &SMALL].concat(),
        [&eval[..], &SMALL].concat(),
        vec!["surface", "synth", "blaze", "--patch", "5um", "-o", output],
    ]
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_to_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let sandbox = sandbox();
    let folder = sandbox.path("closed");
    fs::create_dir(&folder).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    let everything_allowed = fs::write(folder.join("try"), "").is_ok(); // an administrator
    for arguments in writers("closed/out.png") {
        if !everything_allowed {
            refused(&sandbox, &arguments);
        }
    }
    for output in ["/proc/out.png", "missing/out.png", "q.csv/out.png", "closed", "/dev/zero"] {
        for arguments in writers(output) {
            refused(&sandbox, &arguments);
        }
    }
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn a_name_that_is_too_long_is_refused() {
    let sandbox = sandbox();
    let name = format!("{}.png", "n".repeat(300));
    for arguments in writers(&name).iter().chain(&uses(&name)) {
        let line = refused(&sandbox, arguments);
        assert!(line.len() < 2000, "{} characters", line.len());
    }
}

#[cfg(unix)]
#[test]
fn names_with_spaces_line_breaks_and_other_bytes_are_names() {
    use std::os::unix::ffi::OsStrExt;
    let sandbox = sandbox();
    for name in [
        &b"with space.csv"[..],
        b"line\nbreak.csv",
        b"escape\x1b[31m.csv",
        b"\xff\xfe.csv",
        b"-dash.csv",
        "µ.csv".as_bytes(),
    ] {
        let name = Path::new(std::ffi::OsStr::from_bytes(name));
        let path = Path::new("./").join(name);
        fs::copy(sandbox.path("q.csv"), sandbox.path(name)).unwrap();
        let output = path.with_extension("out");
        let arguments = |queries: &Path| {
            let words = ["eval", "--method", "reference"].iter().chain(&SMALL).map(std::ffi::OsString::from);
            let paths = ["--queries".into(), queries.into(), "-o".into(), output.clone().into()];
            words.chain(paths).collect::<Vec<_>>()
        };
        sandbox.run(arguments(&path)).done();
        assert!(fs::read(sandbox.path(&output)).unwrap().starts_with(b"theta_i"), "{name:?}");
        sandbox.run(arguments(&path.with_extension("missing"))).refused(1);
    }
    let odd = |bytes: &[u8]| std::ffi::OsStr::from_bytes(bytes).to_owned();
    let (scene, mesh, light) = (odd(b"\xffs.toml"), odd(b"\xffm.obj"), odd(b"\xffl.csv"));
    fs::write(sandbox.path(&scene), SCENE).unwrap();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    fs::write(sandbox.path(&mesh), triangle).unwrap();
    fs::write(sandbox.path(&light), "380,1\n780,1\n").unwrap();
    for read in [scene, mesh] {
        let words =
            ["render", "--size", "4x4", "--coherence", "gaussian:4um", "--tolerance", "1e-1", "-o", "o.png"];
        let more = [read, "--surface".into(), "flat".into(), "--illuminant".into(), light.clone()];
        sandbox.run(words.map(std::ffi::OsString::from).into_iter().chain(more)).done();
    }
    let shown = "skin\nof a snake.png";
    fs::copy(sandbox.path("small.png"), sandbox.path(shown)).unwrap();
    sandbox.run(["surface", "info", shown, "--pixel-size", "90nm", "--height", "100nm"]).done();
    let line = sandbox.run(["surface", "info", shown]).refused(2);
    assert!(line.contains("skin of a snake.png"), "{line}");
}

#[test]
fn a_file_that_is_missing_is_told_in_words_by_every_command() {
    let sandbox = Sandbox::new();
    for words in [
        &["render", "none.obj", "-o", "a.png"][..],
        &["render", "none.toml", "-o", "a.png"],
        &["render", "plate", "--environment", "none.hdr", "-o", "a.png"],
        &["render", "plate", "--illuminant", "none.csv", "-o", "a.png"],
        &["render", "plate", "--material", "none.csv", "-o", "a.png"],
        &["render", "plate", "--table", "none", "-o", "a.png"],
        &["eval", "flat", "--queries", "none.csv"],
        &["surface", "info", "none.gsf"],
        &["export", "--check", "none"],
        &["surface", "synth", "flat", "-o", "none/a.png"],
    ] {
        let line = sandbox.run(words).refused_somehow(words[0]);
        assert!(line.contains("no such file") || line.contains("does not exist"), "{words:?}: {line}");
        assert!(!line.contains("os error"), "{words:?}: {line}");
    }
}
