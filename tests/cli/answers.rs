//! Answers as JSON, directions from stdin, and several surfaces at once.

use crate::sandbox::{SMALL, Sandbox, outcome};
use serde_json::Value;
use std::io::Write;
use std::process::Stdio;

/// The JSON of the file `name`.
fn json(sandbox: &Sandbox, name: &str) -> Value {
    serde_json::from_slice(&sandbox.read(name)).unwrap()
}

/// Compares the rows of `answer` with the table `csv`, cell by cell.
fn assert_rows_are_those_of(answer: &Value, csv: &str) {
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let rows = answer["rows"].as_array().unwrap();
    assert_eq!(rows.len(), lines.clone().count());
    assert!(!rows.is_empty(), "{csv}");
    for (row, cells) in rows.iter().zip(lines) {
        for (name, cell) in header.iter().zip(cells) {
            let expected: Option<f64> = cell.parse().ok();
            assert_eq!(row[*name].as_f64(), expected, "{name}: {row}");
        }
    }
    let origin = answer["origin"]["command"].as_str().unwrap();
    assert!(origin.starts_with("diffract ") && answer["input"]["samples"][0].as_u64() > Some(1), "{origin}");
}

#[test]
fn json_holds_input_settings_and_the_rows_of_the_table() {
    let sandbox = Sandbox::with_small_surface();
    let run = |words: &[&str]| sandbox.run([words, &["--quiet", "--json", "a.json"]].concat()).done();
    let csv = run(&["orders", "blaze", "--light", "30,0", "--wavelength", "550nm"]);
    let orders = json(&sandbox, "a.json");
    assert_rows_are_those_of(&orders, &csv);
    assert_eq!(orders["settings"]["light_deg"], serde_json::json!([30.0, 0.0]));
    assert_eq!(orders["input"]["surface"], "blaze");
    let csv = run(&["orders", "blaze", "--light", "30,0", "--sweep", "wavelength", "500:520:10"]);
    assert_rows_are_those_of(&json(&sandbox, "a.json"), &csv);
    let words = ["peaks", "blaze", "--theta-i", "0", "--angles", "8:20:0.5", "--wavelengths", "500:520:10"];
    let csv = run(&words);
    let peaks = json(&sandbox, "a.json");
    assert_rows_are_those_of(&peaks, &csv);
    assert!(peaks["period_nm"]["mean"].as_f64() > Some(2000.0) && peaks["settings"]["tolerance"] == 1e-2);
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n30,0,17.3,180,550\n0,0,0,0,450\n");
    let csv = run(&[&["eval", "--queries", "q.csv"][..], &SMALL].concat());
    let eval = json(&sandbox, "a.json");
    assert_rows_are_those_of(&eval, &csv);
    assert_eq!(eval["settings"]["coherence"]["Gaussian"]["length"], 4.0);
    let words = ["brdf", "blaze", "--light", "30,0", "--wavelength", "550nm", "--size", "8x8"];
    run(&words);
    let map = json(&sandbox, "a.json");
    sandbox.run([&words[..], &["--quiet", "-o", "m.csv"]].concat()).done();
    assert_rows_are_those_of(&map, &String::from_utf8(sandbox.read("m.csv")).unwrap());
    assert_eq!(map["settings"]["wavelength_nm"], 550.0);
}

#[test]
fn directions_come_from_stdin_and_have_semicolons_and_decimal_commas() {
    let sandbox = Sandbox::new();
    let queries = "theta_i;phi_i;theta_r;phi_r;wavelength\n30,5;0;17,25;180;550\n";
    sandbox.write("q.csv", queries);
    let from_file = sandbox.run(["eval", "blaze", "--queries", "q.csv"]).done();
    for name in ["-", "/dev/stdin"] {
        let mut command = sandbox.command(["eval", "blaze", "--queries", name]);
        let pipes = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = pipes.spawn().unwrap();
        child.stdin.take().unwrap().write_all(queries.as_bytes()).unwrap();
        assert_eq!(outcome(child).done(), from_file, "{name}");
    }
    let value = from_file.lines().nth(1).unwrap().rsplit(';').next().unwrap().parse::<f64>().unwrap();
    sandbox.write("plain.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n30.5,0,17.25,180,550\n");
    let plain = sandbox.run(["eval", "blaze", "--queries", "plain.csv"]).done();
    assert_eq!(plain.trim_end().rsplit(',').next().unwrap().parse::<f64>().unwrap(), value);
    assert!(value > 0.0);
    let nothing = sandbox.run(["eval", "blaze", "--queries", "-"]).refused(1);
    assert!(nothing.contains("stdin"), "{nothing}");
}

#[test]
fn several_surfaces_are_described_one_after_the_other_and_bad_ones_named_at_the_end() {
    let sandbox = Sandbox::new();
    let one = sandbox.run(["surface", "info", "blaze"]).done();
    let both = sandbox.run(["surface", "info", "blaze", "sinusoid"]).done();
    assert!(both.starts_with(&format!("blaze\n{one}\nsinusoid\n")), "{both}");
    let words = ["surface", "info", "blaze", "sinusoid", "--json"];
    let array: Value = serde_json::from_str(&sandbox.run(words).done()).unwrap();
    let names: Vec<_> = array.as_array().unwrap().iter().map(|report| &report["surface"]).collect();
    assert_eq!(names, ["blaze", "sinusoid"]);
    let outcome = sandbox.run(["surface", "info", "nowhere.gwy", "blaze"]);
    assert_eq!(outcome.code, Some(1));
    assert!(outcome.stdout.starts_with("blaze\n"), "{outcome:?}");
    let said: Vec<&str> = outcome.stderr.lines().collect();
    assert!(said[0].contains("nowhere.gwy: there is no such file") && said[1].contains("1 of 2"), "{said:?}");
    let refused = sandbox.run(["surface", "info", "blaze", "sinusoid", "--plot", "a.svg"]).refused(2);
    assert!(refused.contains("one surface"), "{refused}");
}

#[test]
fn a_result_that_is_not_wanted_goes_nowhere() {
    let sandbox = Sandbox::new();
    let words = ["orders", "blaze", "--light", "30,0", "--wavelength", "550nm", "--quiet"];
    let both = ["-o", "/dev/null", "--json", "/dev/null"];
    assert_eq!(sandbox.run2(&words, &both).done(), "");
    sandbox.run2(&words, &["-o", "/dev/null", "--json", "a.json"]).done();
    assert!(json(&sandbox, "a.json")["rows"].as_array().unwrap().len() > 1);
}

#[test]
fn devices_are_listed_as_json() {
    let list: Value = serde_json::from_str(&Sandbox::new().run(["devices", "--json"]).done()).unwrap();
    let chosen = list["chosen"].as_u64().unwrap() as usize;
    let device = &list["devices"][chosen];
    assert!(
        device["memory_bytes"].as_u64() > Some(0) && device["missing"] == serde_json::json!([]),
        "{list}"
    );
}
