//! Colours by angle.

use crate::sandbox::Sandbox;
use std::f64::consts::{PI, TAU};

/// Returns the rows of a CSV as text, without the header, which has to be `header`.
#[track_caller]
fn rows(csv: &str, header: &str) -> Vec<Vec<String>> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some(header));
    lines.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

const HEADER: &str = "aspecular,theta_i,phi_i,theta_r,phi_r,X,Y,Z,L,a,b,srgb";

fn numbers(row: &[String]) -> Vec<f64> {
    row.iter().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect()
}

#[test]
fn colours_are_those_of_the_spectrum_and_of_eval() {
    let sandbox = Sandbox::new();
    let ask = ["colour", "elaphe", "--crop", "20um", "--light", "45,10", "--illuminant", "d50"];
    let more = ["--aspecular", "-15,25,110", "--spectrum", "s.csv", "--json", "c.json"];
    let found = rows(&sandbox.run2(&ask, &more).done(), HEADER);
    assert_eq!(found.len(), 3);
    let angles: Vec<Vec<f64>> = found.iter().map(|row| numbers(&row[..5])).collect();
    assert_eq!(angles[0], [-15.0, 45.0, 10.0, -60.0, 10.0]);
    assert_eq!(angles[2], [110.0, 45.0, 10.0, 65.0, 10.0]);

    // The same directions by `eval`, whose numbers are the BRDF.
    let queries: String = angles.iter().map(|a| format!("{},{},{},{}\n", a[1], a[2], a[3], a[4])).collect();
    sandbox.write("q.csv", format!("theta_i,phi_i,theta_r,phi_r\n{queries}"));
    let eval = ["eval", "elaphe", "--crop", "20um", "--queries", "q.csv", "--illuminant", "d50"];
    let by_eval = rows(&sandbox.run(eval).done(), "theta_i,phi_i,theta_r,phi_r,X,Y,Z");
    let spectra =
        rows(&String::from_utf8(sandbox.read("s.csv")).unwrap(), "wavelength,45as-15,45as25,45as110");
    assert_eq!((spectra.len(), spectra[0][0].as_str(), spectra[80][0].as_str()), (81, "380", "780"));
    for (place, row) in found.iter().enumerate() {
        let [xyz, lab] = [5, 8].map(|from| numbers(&row[from..from + 3]));
        let exact = numbers(&by_eval[place][4..]);
        for (x, f) in xyz.iter().zip(&exact) {
            assert!((x - 100.0 * PI * f).abs() < 2e-3 * xyz[1] + 1e-4, "{xyz:?}, {exact:?}");
        }
        // CIE 15:2004, 8.2.1, under D50 (0.3457, 0.3585).
        let white = [0.9642, 1.0, 0.8251];
        let [fx, fy, fz] = [0, 1, 2].map(|i| {
            let t: f64 = xyz[i] / 100.0 / white[i];
            if t > 216.0 / 24389.0 { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 }
        });
        for (found, exact) in lab.iter().zip([116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)]) {
            assert!((found - exact).abs() < 0.05, "{lab:?}: {exact}");
        }
        // The luminance of the spectrum: at 555 nm, where the eye sees best, it is about the mean.
        let green: f64 = spectra[35][place + 1].parse().unwrap();
        assert!((0.2..5.0).contains(&(green / (xyz[1] / 100.0))), "{green}, {xyz:?}");
    }
    let json: serde_json::Value = serde_json::from_slice(&sandbox.read("c.json")).unwrap();
    assert_eq!((&json["illuminant"], json["readings"].as_array().unwrap().len()), (&"d50".into(), 3));
    assert!((json["readings"][1]["xyz"][1].as_f64().unwrap() - numbers(&found[1])[6]).abs() < 1e-3);
}

#[test]
fn named_geometries_are_their_directions_and_the_figure_has_a_chip_for_each() {
    let sandbox = Sandbox::new();
    let ask = ["colour", "elaphe", "--crop", "15um"];
    let by_name =
        sandbox.run2(&ask, &["--geometry", "e2194", "--plot", "c.svg", "--spectrum", "s.csv"]).done();
    let by_angles = sandbox.run2(&ask, &["--light", "45", "--aspecular", "15,45,110"]).done();
    assert_eq!(by_name, by_angles);
    let svg = String::from_utf8(sandbox.read("c.svg")).unwrap();
    for row in rows(&by_name, HEADER) {
        assert!(svg.contains(&row[11]) && svg.contains(&format!("45as{}", row[0])), "{row:?}");
    }
    for words in ["Hue and chroma", "Lightness", "Spectra", "aspecular angle [°]", "illuminant d65"] {
        assert!(svg.contains(words), "{words}");
    }
    let both = sandbox.run2(&ask, &["--geometry", "e2194", "--light", "45"]).refused(2);
    assert!(both.contains("--geometry"), "{both}");
    assert!(sandbox.run2(&ask, &["--geometry", "d8"]).refused(2).contains("e2539"));
}

#[test]
fn an_aperture_averages_over_its_cone() {
    let sandbox = Sandbox::new();
    let ask = ["colour", "blaze", "--light", "45"];
    let luminance = |more: &[&str]| numbers(&rows(&sandbox.run2(&ask, more).done(), HEADER)[0])[6];
    let narrow = luminance(&["--view", "-20", "--aperture", "4deg"]);
    // The mean over single directions of a cone of 4 degrees around (-20, 0): rings that weigh as they are wide.
    const RINGS: usize = 20;
    let rings = (0..RINGS).map(|ring| 2.0 * (ring as f64 + 0.5) / RINGS as f64);
    let cone: Vec<[f64; 2]> =
        rings.flat_map(|radius| (0..64).map(move |turn| [radius, TAU * f64::from(turn) / 64.0])).collect();
    let queries: String = cone
        .iter()
        .map(|[radius, turn]| {
            let (sin, cos) = (-20f64).to_radians().sin_cos();
            let across = [turn.cos(), turn.sin()].map(|x| radius.to_radians().sin() * x);
            let up = radius.to_radians().cos();
            let [x, y, z] = [across[0] * cos + up * sin, across[1], up * cos - across[0] * sin];
            format!("45,0,{},{}\n", z.acos().to_degrees(), y.atan2(x).to_degrees())
        })
        .collect();
    sandbox.write("cone.csv", format!("theta_i,phi_i,theta_r,phi_r\n{queries}"));
    let csv = sandbox.run(["eval", "blaze", "--queries", "cone.csv"]).done();
    let all: Vec<f64> =
        csv.lines().skip(1).map(|line| numbers(&[line.split(',').nth(5).unwrap().to_owned()])[0]).collect();
    let weighted = |of: &dyn Fn(usize) -> f64| (0..all.len()).map(|i| cone[i][0] * of(i)).sum::<f64>();
    let exact = 100.0 * PI * weighted(&|i| all[i]) / weighted(&|_| 1.0);
    // The cone's edge cuts through a steep flank of the blue order.
    assert!((narrow / exact - 1.0).abs() < 0.01, "{narrow}, {exact}");
}

#[test]
fn directions_below_the_horizon_and_other_nonsense_are_refused_with_the_remedy() {
    let sandbox = Sandbox::new();
    let refused = |more: &[&str]| sandbox.run2(&["colour", "blaze"], more).refused(2);
    let e = refused(&["--light", "45", "--aspecular", "15,140"]);
    assert!(e.contains("45as140") && e.contains("from -45 to 135"), "{e}");
    assert!(refused(&["--light", "95"]).contains("THETA below 90"));
    assert!(refused(&["--light", "45", "--aperture", "40deg"]).contains("30deg"));
    refused(&["--light", "45", "--aspecular", "15", "--view", "0"]);
    refused(&[]);
}
