//! `diffract profile`: what it counts. Times are never asserted.

use crate::sandbox::Sandbox;

/// The JSON of a profile of a small plate with `options`.
fn profile(sandbox: &Sandbox, options: &[&str]) -> String {
    let setting = [
        "profile",
        "sphere",
        "--surface",
        "bumps",
        "--coherence",
        "gaussian:8um",
        "--windows",
        "1x1",
        "--tolerance",
        "1e-1",
        "--size",
        "32x24",
        "--frames",
        "3",
        "--json",
        "p.json",
    ];
    sandbox.run([&setting[..], options].concat()).done();
    String::from_utf8(sandbox.read("p.json")).unwrap()
}

/// The number that stands behind `key`.
fn number(json: &str, key: &str) -> f64 {
    let (_, rest) =
        json.split_once(&format!("\"{key}\": ")).unwrap_or_else(|| panic!("{key} is missing: {json}"));
    rest.split([',', '\n', '}']).next().unwrap().trim().parse().unwrap()
}

#[test]
fn the_report_has_every_number_of_its_contract() {
    let sandbox = Sandbox::new();
    let json = profile(&sandbox, &[]);
    for key in
        ["fps", "samples_per_covered_pixel", "sample_rate", "sample_rate_fraction", "layers", "wavelengths"]
    {
        assert!(number(&json, key) > 0.0, "{key}: {json}");
    }
    for key in ["device", "driver", "method", "basis", "gpu_ms", "frame_ms"] {
        assert!(json.contains(&format!("\"{key}\": ")), "{key} is missing: {json}");
    }
    for key in ["min", "p50", "p95", "max"] {
        number(&json, key);
    }
}

#[test]
fn twice_the_wavelengths_are_counted_as_twice_the_samples() {
    let sandbox = Sandbox::new();
    let few = profile(&sandbox, &["--wavelengths", "20"]);
    let many = profile(&sandbox, &["--wavelengths", "40"]);
    let ratio = number(&many, "samples_per_covered_pixel") / number(&few, "samples_per_covered_pixel");
    // Beyond the band a ray ends between two nodes of the finer comb: no more than a few per cent.
    assert!((1.9..2.1).contains(&ratio), "{ratio}");
    assert!(number(&many, "wavelengths") > 1.9 * number(&few, "wavelengths"));
}

#[test]
fn a_profile_tells_the_error_beside_the_time_and_a_worse_setting_has_a_larger_one() {
    let sandbox = Sandbox::new();
    let good = profile(&sandbox, &["--error", "all"]);
    let part = profile(&sandbox, &["--error", "60"]);
    let few = profile(&sandbox, &["--error", "all", "--wavelengths", "6", "--terms", "4"]);
    assert!(number(&good, "relative_l2") < 0.1 && number(&good, "p99") < 1.0, "{good}");
    assert!(number(&few, "relative_l2") > 3.0 * number(&good, "relative_l2"), "{few}");
    assert!(number(&few, "flip") > number(&good, "flip") && !part.contains("flip"), "{few}");
    assert_eq!(number(&part, "pixels"), 60.0);
    assert!(number(&good, "sampling_error") > 0.0, "edges alone differ between one sample and four: {good}");
    assert!(number(&part, "relative_l2") < 0.1);
}

#[test]
fn errors_of_shading_of_geometry_and_of_the_whole_are_told_apart() {
    let sandbox = Sandbox::new();
    let relative = |json: &str, key: &str| {
        let (_, section) =
            json.split_once(&format!("\"{key}\": {{")).unwrap_or_else(|| panic!("{key}: {json}"));
        number(section.split('}').next().unwrap(), "relative_l2")
    };
    let good = profile(&sandbox, &["--error", "all"]);
    let few = profile(&sandbox, &["--error", "all", "--wavelengths", "6", "--terms", "4"]);
    // Geometry is the same however it is shaded.
    let [geometry, same] = [&good, &few].map(|json| relative(json, "geometry"));
    assert!(geometry > 0.0 && (geometry - same).abs() < 1e-9, "{geometry}, {same}");
    for json in [&good, &few] {
        let [shading, whole] = ["error", "whole"].map(|key| relative(json, key));
        assert!((whole - shading).abs() <= 1.5 * geometry, "{shading}, {geometry}, {whole}");
    }
    assert!(relative(&few, "whole") > 1.5 * relative(&good, "whole"), "{good}{few}");
    let none = profile(&sandbox, &[]);
    assert!(!none.contains("\"whole\"") && !none.contains("\"geometry\""), "{none}");
}
