//! `diffract trade`: its files, its numbers, and that it goes on where it was stopped. Times are never asserted.

use crate::sandbox::{Outcome, Sandbox};

const SETTING: [&str; 9] =
    ["trade", "plate", "--quick", "--size", "16x16", "--surface", "bumps", "--coherence", "gaussian:6um"];

fn trade(sandbox: &Sandbox, folder: &str) -> Outcome {
    sandbox.run2(&SETTING, &["-o", folder])
}

/// The columns `names` of a CSV, row by row.
fn columns(sandbox: &Sandbox, file: &str, names: &[&str]) -> Vec<Vec<String>> {
    let bytes = sandbox.read(file);
    let mut reader = csv::Reader::from_reader(bytes.as_slice());
    let header = reader.headers().unwrap().clone();
    let places: Vec<usize> =
        names.iter().map(|name| header.iter().position(|h| h == *name).unwrap()).collect();
    reader
        .records()
        .map(|row| places.iter().map(|&i| row.as_ref().unwrap()[i].to_owned()).collect())
        .collect()
}

#[test]
fn two_sweeps_give_the_same_errors_and_every_file() {
    let sandbox = Sandbox::new();
    let advice = trade(&sandbox, "a").done();
    trade(&sandbox, "b").done();
    let errors = ["flags", "relative_l2", "p99", "flip", "samples", "terms"];
    let found = columns(&sandbox, "a/trade.csv", &errors);
    assert_eq!(found, columns(&sandbox, "b/trade.csv", &errors), "bit by bit");
    assert!(found.len() >= 8, "{found:?}");
    for (flags, largest) in [
        ("--windows 1x1 --basis taylor --tolerance 1e-1", 1e-1),
        ("--windows 1x1 --basis optimal --tolerance 1e-2", 1e-2),
    ] {
        let row = found.iter().find(|row| row[0] == flags).unwrap();
        assert!(row[1].parse::<f64>().unwrap() <= largest, "{row:?}");
    }
    let last: Vec<&str> = advice.lines().rev().take(7).collect();
    assert!(last[0].starts_with("60 fps: ") && last[6].starts_with("error 1e-1: --"), "{advice}");
    let report = String::from_utf8(sandbox.read("a/trade.md")).unwrap();
    assert!(
        report.contains("\nCommand: diffract trade plate ") && report.contains("\nPrepared: none\n"),
        "{report}"
    );
    for (file, start) in [
        ("trade.md", &b"# Speed"[..]),
        ("trade.svg", b"<svg"),
        ("trade.png", b"\x89PNG"),
        ("trade.csv", b"frame"),
    ] {
        assert!(sandbox.read(&format!("a/{file}")).starts_with(start), "{file}");
    }
}

#[test]
fn a_sweep_goes_on_where_it_was_stopped() {
    let sandbox = Sandbox::new();
    trade(&sandbox, "a").done();
    let whole = String::from_utf8(sandbox.read("a/trade.csv")).unwrap();
    let kept: Vec<&str> = whole.lines().take(5).collect();
    sandbox.write("a/trade.csv", kept.join("\n") + "\n");
    let again = trade(&sandbox, "a");
    assert_eq!(again.code, Some(0), "{again:?}");
    assert!(again.stderr.contains("4 settings are taken from"), "{again:?}");
    let both = String::from_utf8(sandbox.read("a/trade.csv")).unwrap();
    assert_eq!(both.lines().count(), whole.lines().count());
    assert!(both.lines().zip(&kept).all(|(a, b)| a == *b), "what was measured stays");
    let asked = sandbox.run2(&SETTING, &["-o", "a", "--tolerance", "2e-3", "--fps", "0.001"]);
    assert!(asked.stdout.lines().last().unwrap().starts_with("asked for: --"), "{asked:?}");
    // Rows of another frame are not taken.
    let other = sandbox.run2(&SETTING, &["-o", "a", "--ior", "1.6"]).done();
    assert!(other.contains("error 1e-1"));
}
