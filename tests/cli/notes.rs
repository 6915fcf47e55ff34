//! Notes about the origin of results: program, command and preparation in every file with room for text, and read back from scans.

use crate::export::EXPORT;
use crate::sandbox::{SMALL, Sandbox};
use std::io::{Cursor, Read};

/// Steps of the tests, and the record of them.
const STEPS: [&str; 3] = ["--level", "plane", "--despike"];
const RECORD: &str = "level plane, despike";
/// Settings under which every command is quick.
const QUICK: [&str; 4] = ["--method", "reference", "--coherence", "gaussian:4um"];

/// Returns the text that the file `name` notes about its origin.
fn text(sandbox: &Sandbox, name: &str) -> String {
    let bytes = sandbox.read(name);
    match name.rsplit('.').next().unwrap() {
        "png" => {
            let reader = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
            let line =
                |chunk: &png::text_metadata::ITXtChunk| (chunk.keyword.clone(), chunk.get_text().unwrap());
            let lines = reader.info().utf8_text.iter().map(line);
            lines.map(|(name, value)| format!("{name}: {value}\n")).collect()
        }
        "exr" => {
            let meta = exr::meta::MetaData::read_from_file(sandbox.path(name), false).unwrap();
            meta.headers[0].own_attributes.comments.as_ref().unwrap().to_string()
        }
        "x3p" => {
            let mut xml = String::new();
            let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
            archive.by_name("main.xml").unwrap().read_to_string(&mut xml).unwrap();
            xml
        }
        _ => String::from_utf8_lossy(&bytes).replace(" = ", ": "),
    }
}

/// Fails unless the file `name` notes the version, a command that begins with `command`, and the preparation.
#[track_caller]
fn assert_noted(sandbox: &Sandbox, name: &str, command: &str) {
    let text = text(sandbox, name);
    for part in [
        format!("Software: diffract {}", env!("CARGO_PKG_VERSION")),
        format!("Command: {command}"),
        format!("Prepared: {RECORD}"),
    ] {
        assert!(text.contains(&part), "{name}: `{part}` is not in {text}");
    }
}

/// Returns the preparation that `surface info` tells of the file `name`.
fn record(sandbox: &Sandbox, name: &str, more: &[&str]) -> String {
    let json = sandbox.run2(&["surface", "info", "--json", name], more).done();
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    let steps: Vec<&str> =
        report["prepare"].as_array().unwrap().iter().map(|step| step.as_str().unwrap()).collect();
    assert_eq!(report["origin"]["prepared"], report["prepare"], "{json}");
    assert!(report["origin"]["command"].as_str().unwrap().starts_with("diffract surface info "), "{json}");
    assert!(report["origin"]["command"].as_str().unwrap().contains(name), "{json}");
    steps.join(", ")
}

#[test]
fn every_format_of_a_conversion_carries_the_preparation_on_and_the_next_one_adds_to_it() {
    let sandbox = Sandbox::with_small_surface();
    for extension in ["gsf", "gwy", "txt", "x3p", "tif"] {
        let [once, twice] = ["once", "twice"].map(|name| format!("{name}.{extension}"));
        sandbox.run2(&["surface", "convert", "-o", &once], &[&SMALL[1..6], &STEPS].concat()).done();
        assert_eq!(record(&sandbox, &once, &[]), RECORD, "{extension}");
        assert_eq!(record(&sandbox, &once, &["--invert"]), format!("{RECORD}, invert"), "{extension}");
        let told = sandbox.run(["surface", "info", once.as_str()]).done();
        assert!(told.contains(&format!("{:<26}{RECORD}\n", "prepared by")), "{told}");
        let text = text(&sandbox, &once).replace('\0', ": ");
        for part in ["Software: ", "Command: ", "diffract surface convert "] {
            assert!(text.contains(part), "{extension}: {part}");
        }
        sandbox.run(["surface", "convert", &once, "--crop", "1um", "-o", &twice]).done();
        assert_eq!(record(&sandbox, &twice, &[]), format!("{RECORD}, crop 1um"), "{extension}");
    }
}

#[test]
fn figures_and_pictures_carry_the_preparation() {
    let sandbox = Sandbox::with_small_surface();
    let prepared = [&SMALL[1..6], &STEPS, &QUICK].concat();
    for plot in ["map.svg", "map.png"] {
        let map = ["brdf", "--light", "30,0", "--wavelength", "550nm", "--size", "8x8", "--plot", plot];
        sandbox.run2(&map, &prepared).done();
        assert_noted(&sandbox, plot, "diffract brdf --light 30,0 --wavelength 550nm --size 8x8 ");
    }
    for picture in ["map.exr", "colour.png"] {
        let map = ["brdf", "--light", "30,0", "--wavelength", "550nm", "--size", "8x8", "-o", picture];
        sandbox.run2(&map, &prepared).done();
        assert_noted(&sandbox, picture, "diffract brdf ");
    }
    for plot in ["peaks.svg", "peaks.png"] {
        let peaks = ["peaks", "--theta-i", "30", "--angles=-10:10:5", "--wavelengths", "500:600:50"];
        let files = ["-o", "peaks.csv", "--json", "peaks.json", "--plot", plot];
        assert_eq!(sandbox.run2(&[&peaks[..], &files].concat(), &prepared).code, Some(0));
        assert_noted(&sandbox, plot, "diffract peaks ");
    }
    let report: serde_json::Value = serde_json::from_slice(&sandbox.read("peaks.json")).unwrap();
    assert_eq!(report["origin"]["prepared"], serde_json::json!(["level plane", "despike"]));
    for plot in ["page.svg", "page.png"] {
        sandbox.run2(&["surface", "info", "--plot", plot], &[&SMALL[1..6], &STEPS].concat()).done();
        assert_noted(&sandbox, plot, "diffract surface info ");
    }
}

#[test]
fn a_picture_of_a_scene_and_an_export_carry_the_preparation() {
    let sandbox = Sandbox::with_small_surface();
    for picture in ["a.png", "a.exr"] {
        let render = ["render", "sphere", "--size", "16x12", "--samples", "1", "--tolerance", "1e-1"];
        sandbox.run2(&[&render[..], &["-o", picture]].concat(), &[&SMALL[..], &STEPS].concat()).done();
        assert_noted(&sandbox, picture, "diffract render sphere ");
    }
    sandbox.run2(&EXPORT, &STEPS).done();
    let description: serde_json::Value =
        serde_json::from_slice(&sandbox.read("material/material.json")).unwrap();
    assert_eq!(description["prepared_by"], serde_json::json!(["level plane", "despike"]));
    sandbox.run(["export", "--check", "material"]).done();
}

#[test]
fn the_same_command_writes_the_same_notes() {
    let sandbox = Sandbox::with_small_surface();
    for extension in ["gsf", "gwy", "txt", "x3p", "tif"] {
        let [a, b] = ["a", "b"].map(|name| {
            let file = format!("{name}.{extension}");
            sandbox.run2(&["surface", "convert", "-o", &file], &[&SMALL[1..6], &STEPS].concat()).done();
            sandbox.read(&file)
        });
        assert!(a == b, "{extension}");
    }
}
