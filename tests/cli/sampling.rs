//! What is told of a surface whose samples are too far apart for some directions: the words, the numbers, and how often.

use crate::sandbox::{Outcome, Sandbox};

const DARK: &str = "beyond that the surface is taken as dark";

/// A sandbox with 20 × 20 heights in `c.png` and queries of colours and of single wavelengths.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox
        .run(["surface", "synth", "bumps", "--patch", "3um", "--pixel-size", "150nm", "-o", "c.png"])
        .done();
    sandbox.write("colours.csv", "theta_i,phi_i,theta_r,phi_r\n20,0,25,180\n");
    sandbox.write("green.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n20,0,25,180,550\n20,0,25,180,610\n");
    sandbox
}

/// Runs `command` (a space between words) on the heights `spacing` apart.
fn run(sandbox: &Sandbox, command: &str, spacing: &str) -> Outcome {
    let mut words: Vec<&str> = command.split(' ').collect();
    words.extend(["--pixel-size", spacing, "--height", "137nm"]);
    sandbox.run(words)
}

/// What was told of the samples, which is all that the run said on stderr.
fn told(sandbox: &Sandbox, command: &str, spacing: &str) -> Vec<String> {
    let outcome = run(sandbox, command, spacing);
    assert_eq!(outcome.code, Some(0), "{command}: {outcome:?}");
    let (told, others): (Vec<&str>, Vec<&str>) = outcome.stderr.lines().partition(|line| line.contains(DARK));
    assert!(others.iter().all(|line| line.contains("period")), "{command}: {others:?}");
    told.into_iter().map(str::to_owned).collect()
}

const WINDOW: &str = "--coherence gaussian:4um --tolerance 1e-1";

#[test]
fn samples_beyond_a_quarter_of_the_shortest_wavelength_are_told_with_what_they_hold() {
    let sandbox = sandbox();
    let eval = |queries: &str| format!("eval c.png --queries {queries} --method reference {WINDOW}");
    let line = |spacing: &str, held: &str, at: &str, needed: &str| {
        vec![format!(
            "diffract: samples {spacing} nm apart hold {held} at {at} nm (2 needs {needed} nm); {DARK}"
        )]
    };
    // |u| = λ/(2 dx) at the shortest wavelength that is asked for, and λ/4 holds all.
    for (spacing, colours, green) in [
        ("80nm", vec![], vec![]),
        ("95nm", vec![], vec![]),
        ("97.66nm", line("97.7", "|u| up to 1.95", "380", "95.0"), vec![]),
        ("137.5nm", line("137.5", "|u| up to 1.38", "380", "95.0"), vec![]),
        (
            "150nm",
            line("150.0", "|u| up to 1.27", "380", "95.0"),
            line("150.0", "|u| up to 1.83", "550", "137.5"),
        ),
        (
            "80nmx150nm",
            line("150.0", "|v| up to 1.27", "380", "95.0"),
            line("150.0", "|v| up to 1.83", "550", "137.5"),
        ),
        (
            "400nmx80nm",
            line("400.0", "|u| up to 0.47", "380", "95.0"),
            line("400.0", "|u| up to 0.69", "550", "137.5"),
        ),
    ] {
        assert_eq!(told(&sandbox, &eval("colours.csv"), spacing), colours, "{spacing}");
        assert_eq!(told(&sandbox, &eval("green.csv"), spacing), green, "{spacing}");
    }
}

#[test]
fn info_says_the_same_of_a_surface() {
    let sandbox = sandbox();
    for (spacing, held) in [
        ("80nm", "all"),
        ("95nm", "all"),
        ("97.66nm", "|u| up to 1.95; all need 95.0 nm between samples"),
        ("80nmx190nm", "|v| up to 1.00; all need 95.0 nm between samples"),
    ] {
        let info = run(&sandbox, "surface info c.png", spacing).done();
        let row = info.lines().find_map(|line| line.strip_prefix("directions held at 380 nm"));
        assert_eq!(row.map(str::trim), Some(held), "{spacing}: {info}");
    }
}

#[test]
fn every_command_that_shades_tells_it_and_tells_it_once() {
    let sandbox = sandbox();
    let surface = format!("--surface c.png {WINDOW}");
    for command in [
        format!("eval c.png --queries colours.csv {WINDOW}"),
        format!("eval c.png --queries colours.csv --windows 2x2 {WINDOW}"),
        format!("eval c.png --queries colours.csv --method table {WINDOW}"),
        "eval c.png --queries colours.csv --coherence repeats:2x2".to_owned(),
        format!("brdf c.png --size 8x8 --light 20,0 -o b.exr {WINDOW}"),
        format!("peaks c.png --theta-i 30 --wavelengths 380:390:10 --angles 0:10:5 --axis x {WINDOW}"),
        format!("render plate {surface} --size 8x6 -o r.png"),
        format!("render plate {surface} --size 8x6 -o r.png --windows 1x1"),
        format!("render plate {surface} --size 4x3 -o r.png --method reference"),
        format!("profile plate {surface} --size 8x6 --frames 3 --error 5"),
    ] {
        assert_eq!(told(&sandbox, &command, "80nm").len(), 0, "{command}");
        let lines = told(&sandbox, &command, "150nm");
        assert!(
            lines.len() == 1 && lines[0].contains("hold |u| up to 1.27 at 380 nm"),
            "{command}: {lines:?}"
        );
    }
}
