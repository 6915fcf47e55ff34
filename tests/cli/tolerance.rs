//! Refusals of a tolerance, which name the least that works.

use crate::sandbox::{Outcome, Sandbox};

/// Returns the tolerance that the `refusal` names.
#[track_caller]
fn named(refusal: &str) -> &str {
    let rest = refusal.split_once("use --tolerance ").unwrap_or_else(|| panic!("none is named: {refusal}")).1;
    rest.split([',', '\n']).next().unwrap()
}

/// Runs `words` at `tolerance`.
fn at(sandbox: &Sandbox, words: &[&str], tolerance: &str) -> Outcome {
    sandbox.run2(words, &["--tolerance", tolerance])
}

/// Checks that `words` are refused at `tolerance`, and done at the tolerance that the refusal names and not at a smaller one of one digit.
#[track_caller]
fn check(sandbox: &Sandbox, words: &[&str], tolerance: &str) {
    let line = at(sandbox, words, tolerance).refused(1);
    let least = named(&line);
    assert_eq!(at(sandbox, words, least).code, Some(0), "{line}");
    let (digit, decade) = least.split_once('e').unwrap();
    let digit: u32 = digit.parse().unwrap();
    if digit > 1 {
        at(sandbox, words, &format!("{}e{decade}", digit - 1)).refused(1);
    }
}

/// A surface that is too high for the tolerances below.
const HIGH: [&str; 7] =
    ["small.png", "--pixel-size", "83.3333333nm", "--coherence", "gaussian:4um", "--height", "4um"];

#[test]
fn a_table_that_is_refused_names_the_least_tolerance_that_works() {
    let sandbox = Sandbox::with_small_surface();
    check(&sandbox, &[&["export"], &HIGH[..], &["-o", "material"]].concat(), "1e-2");
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r\n30,0,20,180\n");
    check(&sandbox, &[&["eval"], &HIGH[..], &["--method", "table", "--queries", "q.csv"]].concat(), "1e-2");
}

#[test]
fn a_series_that_is_refused_names_the_least_tolerance_that_works_or_none() {
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r\n30,0,20,180\n");
    let eval = |height| {
        let words = ["eval", HIGH[0], HIGH[1], HIGH[2], HIGH[3], HIGH[4], "--height", height];
        [&words[..], &["--windows", "1x1", "--basis", "taylor", "--queries", "q.csv"]].concat()
    };
    check(&sandbox, &eval("800nm"), "1e-3");
    let line = at(&sandbox, &eval("1.5um"), "1e-3").refused(1);
    assert!(!line.contains("tolerance 1") && line.contains("--basis optimal"), "{line}");
}
