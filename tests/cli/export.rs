//! Materials for other programs.

use crate::browser::Browser;
use crate::render::{deviation, exr};
use crate::sandbox::Sandbox;
use std::process::Command;

/// A small export of a small surface, which takes a second.
pub const EXPORT: [&str; 14] = [
    "export",
    "small.png",
    "--pixel-size",
    "83.3333333nm",
    "--height",
    "137.4nm",
    "-o",
    "material",
    "--coherence",
    "gaussian:8um",
    "--footprint",
    "0.05",
    "--tolerance",
    "5e-2",
];

/// The columns of the table of an export as a file of answers, the first multiplied by `factor`.
fn answers(sandbox: &Sandbox, factor: f64) -> String {
    let text = String::from_utf8(sandbox.read("material/conformance.csv")).unwrap();
    let line = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        format!("{},{},{}\n", numbers[13] * factor, numbers[14], numbers[15])
    };
    let rows: String = text.lines().skip(1).map(line).collect();
    format!("r,g,b\n{rows}")
}

#[test]
fn an_export_is_made_without_a_device_checked_and_refused_once_it_is_damaged() {
    let sandbox = Sandbox::with_small_surface().without_vulkan();
    let made = sandbox.run(EXPORT).done();
    assert!(
        made.contains("MB of texels for footprints from 0.050 on; against the exact mean of 1000 directions"),
        "{made}"
    );
    let checked = sandbox.run(["export", "--check", "material"]).done();
    assert_eq!(checked, format!("sound: {made}"));
    let description: serde_json::Value =
        serde_json::from_slice(&sandbox.read("material/material.json")).unwrap();
    assert_eq!(description["smallest_footprint"], 0.05);
    assert_eq!(description["coherence_length_um"], 8.0);
    assert!(description["command"].as_str().unwrap().starts_with("diffract export small.png"));
    // A former export is replaced by the same one.
    let texels = sandbox.read("material/table.ktx2");
    sandbox.run(EXPORT).done();
    assert!(sandbox.read("material/table.ktx2") == texels);
    sandbox.write("material/table.ktx2", &texels[..texels.len() - 1]);
    let line = sandbox.run(["export", "--check", "material"]).refused(1);
    assert!(line.contains("table.ktx2: it is truncated"), "{line}");
}

#[test]
fn answers_of_a_port_are_compared_with_the_table() {
    let sandbox = Sandbox::with_small_surface();
    sandbox.run(EXPORT).done();
    let check = ["export", "--check", "material", "--answers", "mine.csv"];
    sandbox.write("mine.csv", answers(&sandbox, 1.0));
    assert!(sandbox.run(check).done().starts_with("right: "));
    sandbox.write("mine.csv", answers(&sandbox, 1.05));
    let line = sandbox.run(check).refused(1);
    assert!(line.contains("mine.csv: the answers are not those of the table"), "{line}");
    sandbox.write("mine.csv", "r,g,b\n1,2,3\n");
    assert!(sandbox.run(check).refused(1).contains("1 answers to 1000 directions"));
}

#[test]
fn an_export_that_cannot_be_is_refused_before_any_work() {
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("file", "x");
    std::fs::create_dir(sandbox.path("other")).unwrap();
    sandbox.write("other/thesis.txt", "x");
    let before = sandbox.content();
    let refused = |more: &[&str], code: i32, what: &str| {
        let line = sandbox.run2(&EXPORT[..6], more).refused(code);
        assert!(line.contains(what), "{more:?}: {line}");
    };
    refused(&["-o", "file"], 2, "not a folder");
    refused(&["-o", "other"], 2, "other content");
    refused(&["-o", "none/material"], 1, "cannot create a folder in none");
    refused(&["-o", "m", "--footprint", "1"], 2, "footprint");
    refused(
        &["-o", "m", "--footprint", "0.2", "--coherence", "gaussian:8um", "--budget", "10B"],
        1,
        "10 bytes; allow more bytes",
    );
    refused(&["-o", "m", "--method", "spectral"], 2, "--method table");
    refused(&["-o", "m", "--windows", "1x1"], 2, "--windows all");
    refused(&["-o", "m", "--coherence", "grating:3x3", "--windows", "all"], 2, "--coherence gaussian:LENGTH");
    refused(&["--check", "other"], 2, "--check");
    assert!(sandbox.run(["export", "--check", "other"]).refused(1).contains("no such file"));
    assert_eq!(sandbox.content(), before);
    assert_eq!(sandbox.read("other/thesis.txt"), b"x");
}

#[test]
fn the_port_to_python_gives_the_colours_of_the_table() {
    let sandbox = Sandbox::with_small_surface();
    sandbox.run(EXPORT).done();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/integrations/python/diffract_material.py");
    let answered = Command::new("python3").arg(script).arg(sandbox.path("material")).output();
    let answered = answered.unwrap_or_else(|e| panic!("python3 does not run ({e}): install it"));
    assert!(answered.status.success(), "{}", String::from_utf8_lossy(&answered.stderr));
    sandbox.write("mine.csv", &answered.stdout);
    let line = sandbox.run(["export", "--check", "material", "--answers", "mine.csv"]).done();
    assert!(line.starts_with("right: "), "{line}");
}

/// Writes the page of [`EXPORT`] for footprints from `footprint` on into the sandbox and returns it.
fn page(sandbox: &Sandbox, footprint: &str) -> String {
    page_with(sandbox, footprint, &[])
}

/// The same with further words on the command line.
pub fn page_with(sandbox: &Sandbox, footprint: &str, more: &[&str]) -> String {
    let arguments = EXPORT.map(|word| match word {
        "-o" => "--html",
        "material" => "page.html",
        "0.05" => footprint,
        word => word,
    });
    sandbox.run2(&arguments, more).done();
    String::from_utf8(sandbox.read("page.html")).unwrap()
}

#[test]
fn a_page_is_one_file_that_loads_nothing() {
    let sandbox = Sandbox::with_small_surface().without_vulkan();
    let page = page(&sandbox, "0.05");
    assert!(page.len() < 10_000_000 && page.len() > 100_000, "{} bytes", page.len());
    for part in [
        "diffract_rgb",
        "webgl2",
        "prefers-color-scheme",
        "<h1 id=\"name\">small.png</h1>",
        "10.1111/cgf.12425",
        "data:image/png;base64,",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.contains("diffract export small.png --pixel-size 83.3333333nm --height 137.4nm --coherence gaussian:8um --footprint 0.05 --tolerance 5e-2 --html page.html"));
    for from_elsewhere in
        ["http:", "https:", "src=\"/", "url(", "import ", "fetch(", "XMLHttpRequest", "{{", "<link"]
    {
        assert!(!page.contains(from_elsewhere), "{from_elsewhere}");
    }
    let before = sandbox.content();
    let refused = |more: &[&str], code: i32, what: &str| {
        let line = sandbox.run2(&EXPORT[..6], more).refused(code);
        assert!(line.contains(what), "{more:?}: {line}");
    };
    refused(&["--html", "page.html", "--budget", "8MB"], 2, "--budget 6.7MB");
    refused(&["--html", "none/page.html"], 1, "none");
    refused(&["--html", "small.png"], 2, "small.png");
    assert_eq!(sandbox.content(), before);
}

/// Chromium without a window, with a profile in the sandbox.
pub fn chromium(sandbox: &Sandbox) -> Command {
    let mut command = Command::new("chromium");
    command.args([
        "--headless",
        "--no-sandbox",
        "--disable-gpu-sandbox",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--no-first-run",
        "--disable-background-networking",
        "--disable-dev-shm-usage",
        "--enable-logging=stderr",
        "--window-size=800,600",
    ]);
    command.arg(format!("--user-data-dir={}", sandbox.path("profile").display()));
    command
}

#[test]
fn a_browser_shows_the_colours_of_the_table_and_has_nothing_to_say() {
    let sandbox = Sandbox::with_small_surface().without_vulkan();
    let page = page(&sandbox, "0.05");
    let mut browser = Browser::with(&sandbox, &[]);
    browser.open(&sandbox, "page.html");
    let off = browser.deviation();
    eprintln!("{off:e}");
    assert!(off > 0.0 && off <= 2e-3, "{off:e}");
    assert!(browser.console.is_empty(), "{:?}", browser.console);
    // The page would tell of a shader that is wrong.
    let wrong = page.replace("pair.toward * diffract_source", "pair.toward.yx * diffract_source");
    assert!(wrong != page);
    sandbox.write("wrong.html", wrong);
    browser.open(&sandbox, "wrong.html");
    let off = browser.deviation();
    assert!(off > 5e-2, "{off:e}");
}

#[test]
fn a_browser_draws_the_plate_as_this_program_does() {
    /// Side of the picture [pixels].
    const SIDE: usize = 48;
    // The camera, the plate and the light of the page: a focal length of 3.2, an eye 4.75 from a plate of 2 * 0.86.
    const PITCH: f64 = -0.5;
    let (field_of_view, distance) = (2.0 * (1.0f64 / 3.2).atan().to_degrees(), 4.75 * 0.5 / 0.86);
    let (x, y) = (0.1f64, 0.45f64);
    let light = format!("{},{}", x.hypot(y).asin().to_degrees(), y.atan2(x).to_degrees());
    let sandbox = Sandbox::with_small_surface();
    page(&sandbox, "0");
    let mut browser = Browser::with(&sandbox, &[]);
    browser.open(&sandbox, "page.html");
    browser.value("element('around').checked = false");
    let state = format!("{{ shape: PLATE, yaw: 0, pitch: {PITCH}, light: [{x}, {y}] }}");
    let shown = browser.radiance(SIDE, &state);
    let scene = format!(
        "mesh = \"plate\"\nsurface = \"small.png\"\npixel_size = \"83.3333333nm\"\nheight = \"137.4nm\"\nlights = [\"{light}\"]\n\
         [camera]\neye = [0.0, {}, {}]\ntarget = [0.0, 0.0, 0.0]\nfield_of_view = \"{field_of_view}deg\"\n",
        distance * PITCH.sin(),
        distance * PITCH.cos()
    );
    sandbox.write("plate.toml", scene);
    let size = format!("{SIDE}x{SIDE}");
    let picture = [
        "render",
        "plate.toml",
        "--size",
        &size,
        "--samples",
        "1",
        "--coherence",
        "gaussian:8um",
        "--tolerance",
        "5e-2",
        "-o",
        "plate.exr",
    ];
    sandbox.run(picture).done();
    let ours = exr(&sandbox, "plate.exr").2;
    // The page's rows go up. Pixels at the edge are left out.
    let pairs = (0..SIDE * SIDE).map(|i| (shown[(SIDE - 1 - i / SIDE) * SIDE + i % SIDE], ours[i]));
    let (shown, ours): (Vec<_>, Vec<_>) = pairs.filter(|(a, b)| a[3] == 1.0 && b[3] == 1.0).unzip();
    assert!(shown.len() > SIDE * SIDE / 8, "{} pixels", shown.len());
    let off = deviation(&shown, &ours);
    eprintln!("{off:e} over {} pixels", shown.len());
    // 2.2e-4 is measured.
    assert!(off > 0.0 && off <= 2e-3, "{off:e}");
    // A picture that is upside down is another one.
    let turned: Vec<_> = shown.iter().rev().copied().collect();
    assert!(deviation(&turned, &ours) > 0.2);
}

#[test]
fn pictures_of_an_exported_table_are_those_of_the_surface_and_others_are_refused() {
    const PICTURE: [&str; 15] = [
        "render",
        "plate",
        "--surface",
        "small.png",
        "--pixel-size",
        "83.3333333nm",
        "--height",
        "137.4nm",
        "--coherence",
        "gaussian:8um",
        "--size",
        "48x36",
        "--samples",
        "1",
        "-o",
    ];
    let sandbox = Sandbox::with_small_surface();
    let exported = |footprint: &str| {
        let words = EXPORT.map(|word| if word == "0.05" { footprint } else { word });
        sandbox.run(words).done();
    };
    let refused = |more: &[&str], what: &str| {
        let line =
            sandbox.run2(&PICTURE, &[&["a.exr", "--table", "material"], more].concat()).refused_somehow(what);
        assert!(line.contains(what), "{more:?}: {line}");
    };
    let tolerance = ["--tolerance", "5e-2"];
    exported("0.05");
    refused(&tolerance, "it serves footprints from 5.00e-2 on");
    exported("0");
    sandbox.run2(&PICTURE, &["made.exr", "--tolerance", "5e-2"]).done();
    sandbox.run2(&PICTURE, &["read.exr", "--tolerance", "5e-2", "--table", "material"]).done();
    let off = deviation(&exr(&sandbox, "read.exr").2, &exr(&sandbox, "made.exr").2);
    eprintln!("{off:e}");
    // 1.3e-3 is measured: the table of the export holds R, and that of a picture does not.
    assert!(off > 0.0 && off <= 5e-3, "{off:e}");
    let other = |more: &[&str], what: &str| refused(&[&tolerance, more].concat(), what);
    other(&["--illuminant", "a"], "another illuminant");
    other(&["--beyond", "alike"], "beyond the patch");
    other(&["--invert"], "another surface");
    other(&["--material", "gold"], "another material");
    other(&["--method", "reference"], "--method table");
    refused(&["--tolerance", "1e-2"], "tolerance of 5e-2");
    let texels = sandbox.read("material/table.ktx2");
    sandbox.write("material/table.ktx2", &texels[..texels.len() - 1]);
    other(&[], "it is truncated");
    assert!(!sandbox.path("a.exr").exists());
}
