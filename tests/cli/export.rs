//! Materials for other programs.

use crate::sandbox::Sandbox;

/// A small export of a small surface, which takes a second.
const EXPORT: [&str; 14] = [
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
    let answered = std::process::Command::new("python3").arg(script).arg(sandbox.path("material")).output();
    let answered = answered.unwrap_or_else(|e| panic!("python3 does not run ({e}): install it"));
    assert!(answered.status.success(), "{}", String::from_utf8_lossy(&answered.stderr));
    sandbox.write("mine.csv", &answered.stdout);
    let line = sandbox.run(["export", "--check", "material", "--answers", "mine.csv"]).done();
    assert!(line.starts_with("right: "), "{line}");
}
