//! What is in a height field, and generated ones.

use crate::sandbox::Sandbox;

const KINDS: [&str; 11] = [
    "flat",
    "sinusoid",
    "blaze",
    "lamellar",
    "bumps",
    "elaphe",
    "xenopeltis",
    "cd",
    "dvd",
    "brushed",
    "tulip",
];

/// The number of `row` in the answer of `surface info`.
fn row<'a>(info: &'a str, name: &str) -> &'a str {
    let line = info.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}: {info}"));
    line[name.len()..].trim()
}

/// Returns the length of the first period that `info` tells, and its uncertainty \[µm\].
fn dominant_period(info: &str) -> [f64; 2] {
    let period = row(info, "dominant period").replace("um ± ", "");
    [0, 1].map(|i| period.split(' ').nth(i).unwrap().parse::<f64>().unwrap())
}

/// Writes a small surface of `kind` and returns the options that the program says to read it with.
fn synth(sandbox: &Sandbox, kind: &str, file: &str, more: &[&str]) -> Vec<String> {
    let said = sandbox.run2(&["surface", "synth", kind, "--patch", "9um", "-o", file], more).done();
    let (_, options) = said.trim_end().split_once("read it with ").unwrap();
    options.split(' ').map(str::to_owned).collect()
}

#[test]
fn info_describes_every_built_in_surface() {
    let sandbox = Sandbox::new();
    for kind in KINDS {
        let info = sandbox.run(["surface", "info", kind]).done();
        assert!(row(&info, "samples").contains(" x "), "{info}");
        assert_eq!(row(&info, "directions held at 380 nm"), "all", "{kind}");
        assert!(!info.contains("inf") && !info.contains("NaN"), "{info}");
    }
    assert_eq!(sandbox.run(["surface", "info"]).done(), sandbox.run(["surface", "info", "elaphe"]).done());
}

#[test]
fn every_generated_surface_is_read_back_with_the_printed_options() {
    let sandbox = Sandbox::new();
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n20,0,20,180,550\n");
    for (kind, extension) in KINDS.iter().zip(["png", "tif", "tiff"].iter().cycle()) {
        let file = format!("{kind}.{extension}");
        let options = synth(&sandbox, kind, &file, &[]);
        let options: Vec<&str> = options.iter().map(String::as_str).collect();
        let info = sandbox.run2(&["surface", "info", &file], &options).done();
        let height = row(&info, "height range").split(' ').next().unwrap();
        let written = if *kind == "flat" { "0" } else { options[3].strip_suffix("nm").unwrap() };
        let error = height.parse::<f64>().unwrap() - written.parse::<f64>().unwrap();
        assert!(error.abs() < 0.06, "{kind}: {height} {options:?}");
        let ask = ["--queries", "q.csv", "--method", "reference"];
        let csv = sandbox.run2(&["eval", &file], &[&options[..], &ask].concat()).done();
        assert!(!csv.contains("NaN"), "{kind}: {csv}");
    }
}

#[test]
fn a_generated_surface_is_written_in_every_format_with_its_heights() {
    let sandbox = Sandbox::new();
    let info = |name: &str, more: &[&str]| -> serde_json::Value {
        let said = sandbox.run([&["surface", "info", name, "--json"], more].concat()).done();
        serde_json::from_str(&said).unwrap()
    };
    let exact = info("blaze", &["--crop", "9um"]);
    for file in ["s.gsf", "s.gwy", "s.npy", "s.txt", "s.x3p"] {
        let said = sandbox.run(["surface", "synth", "blaze", "-o", file]).done();
        let read_back = said.trim_end().rsplit_once("read it with ").map_or("", |(_, options)| options);
        let options: Vec<&str> = read_back.split(' ').filter(|word| !word.is_empty()).collect();
        let found = info(file, &[&["--crop", "9um"], &options[..]].concat());
        assert_eq!(found["samples"], exact["samples"], "{file}");
        let rms = |value: &serde_json::Value| value["rms_m"].as_f64().unwrap();
        assert!((rms(&found) / rms(&exact) - 1.0).abs() < 1e-6, "{file}");
    }
    sandbox.run(["surface", "synth", "blaze", "-o", "s.doc"]).refused(2);
}

#[test]
fn the_options_of_synth_decide_period_height_and_spacing() {
    let sandbox = Sandbox::new();
    let more = ["--period", "3um", "--height", "300nm", "--pixel-size", "50nm"];
    let options = synth(&sandbox, "sinusoid", "s.png", &more);
    let options: Vec<&str> = options.iter().map(String::as_str).collect();
    let info = sandbox.run2(&["surface", "info", "s.png"], &options).done();
    assert_eq!(row(&info, "samples"), "180 x 180");
    assert!(
        row(&info, "height range").starts_with("300.0 nm") || row(&info, "height range").starts_with("299.")
    );
    let [length, uncertainty] = dominant_period(&info);
    assert!((length - 3.0).abs() < 2.0 * uncertainty && uncertainty < 0.02, "{info}");
}

#[test]
fn one_seed_is_one_surface_and_two_seeds_are_two() {
    let sandbox = Sandbox::new();
    for kind in ["elaphe", "xenopeltis", "cd", "dvd", "brushed", "tulip"] {
        for (file, seed) in [("a.png", "1"), ("b.png", "1"), ("c.png", "2")] {
            synth(&sandbox, kind, file, &["--seed", seed]);
        }
        synth(&sandbox, kind, "d.png", &[]);
        assert_eq!(sandbox.read("a.png"), sandbox.read("b.png"), "{kind}");
        assert_ne!(sandbox.read("a.png"), sandbox.read("c.png"), "{kind}");
        assert_eq!(sandbox.read("a.png"), sandbox.read("d.png"), "{kind}: the default seed is 1");
        let info = |seed| sandbox.run(["surface", "info", kind, "--seed", seed]).done();
        assert_ne!(info("1"), info("2"), "{kind}");
    }
}

#[test]
fn levelling_takes_the_mean_and_the_slope_away() {
    let sandbox = Sandbox::new();
    let info = |level| sandbox.run(["surface", "info", "blaze", "--level", level]).done();
    let mean =
        |info: &str| row(info, "mean, RMS roughness").split(' ').next().unwrap().parse::<f64>().unwrap();
    assert!(mean(&info("none")) > 100.0);
    assert!(mean(&info("mean")).abs() < 0.1);
    assert_ne!(row(&info("plane"), "height range"), row(&info("mean"), "height range"));
}

#[test]
fn steps_act_in_the_order_of_the_command_line_and_are_told() {
    let sandbox = Sandbox::new();
    let info = |steps: &[&str]| sandbox.run2(&["surface", "info", "blaze"], steps).done();
    let mean =
        |info: &str| row(info, "mean, RMS roughness").split(' ').next().unwrap().parse::<f64>().unwrap();
    // A crop of one and a half periods from the left has another mean than the whole.
    let levelled_first = info(&["--level", "mean", "--crop", "3.75umx20um+0um+0um"]);
    let cropped_first = info(&["--crop", "3.75umx20um+0um+0um", "--level", "mean"]);
    assert!(mean(&levelled_first).abs() > 10.0 && mean(&cropped_first).abs() < 0.1);
    assert_eq!(row(&levelled_first, "prepared by"), "level mean, crop 3.75umx20um+0um+0um");
    assert_eq!(row(&cropped_first, "prepared by"), "crop 3.75umx20um+0um+0um, level mean");
    assert_eq!(row(&info(&["--level", "none"]), "prepared by"), "none");
    let more = info(&[
        "--despike",
        "--destripe",
        "--deconvolve-tip",
        "10nm",
        "--invert",
        "--resample",
        "50nm",
        "--tile",
        "mirror",
    ]);
    assert_eq!(
        row(&more, "prepared by"),
        "despike, destripe, deconvolve-tip 10nm, invert, resample 50nm, tile mirror"
    );
    assert_eq!(row(&more, "samples"), "800 x 800");
    let e = sandbox.run(["surface", "info", "blaze", "--crop", "1mm"]).refused(1);
    assert!(e.contains("crop 1mm: the field of 20um x 20um"), "{e}");
}

#[test]
fn info_tells_what_a_cropped_blaze_lacks_and_draws_a_page() {
    let sandbox = Sandbox::new();
    let info = sandbox.run(["surface", "info", "blaze", "--crop", "11um", "--plot", "page.svg"]).done();
    assert!(row(&info, "tiles").starts_with("no: the left and right edges do not meet"), "{info}");
    let [length, uncertainty] = dominant_period(&info);
    assert!((length - 2.5).abs() <= 2.0 * uncertainty && uncertainty < 0.05, "{info}");
    let theory = row(&info, "scalar theory");
    assert!(theory.contains(" %") && theory.contains("blaze on dielectric, period 4.8 λ"), "{theory}");
    assert!(info.contains("\nnote                      seams: copies do not join"), "{info}");
    let page = String::from_utf8(sandbox.read("page.svg")).unwrap();
    assert!(page.contains("Power spectrum") && page.contains("Prepared by: crop 11um"), "no page");
    sandbox.run(["surface", "info", "--plot", "page.png"]).done();
    assert!(sandbox.read("page.png").starts_with(b"\x89PNG"));
}

#[test]
fn a_period_that_varies_is_the_same_after_any_levelling_and_in_any_part() {
    let sandbox = Sandbox::new();
    // Periods of 1.2 µm that wander by a tenth, on a bowl, at 0.1 µm a sample.
    let phase = |x: f64| 5.2 * x + 1.0 * (0.31 * x).sin() + 0.5 * (0.83 * x + 1.0).sin();
    let height = |x: f64, y: f64| 0.12 * phase(x).sin() + 0.002 * (x - 20.0).powi(2) + 0.01 * y;
    let rows = (0..160).map(|j| {
        let cells = (0..400).map(|i| format!("{:.5}", height(f64::from(i) * 0.1, f64::from(j) * 0.1)));
        cells.collect::<Vec<_>>().join(" ")
    });
    let heights = rows.collect::<Vec<_>>().join("\n");
    sandbox.write(
        "ridges.txt",
        format!("# Channel: Height\n# Width: 40 um\n# Height: 16 um\n# Value units: um\n{heights}\n"),
    );
    let found = |steps: &[&str]| {
        let read = ["surface", "info", "ridges.txt", "--json"];
        let json = sandbox.run2(&read, steps).done();
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let period = &json["statistics"]["periods"][0];
        assert!(period["method"] == "band" || period["method"] == "line", "{steps:?}: {json}");
        ["length_m", "length_spread_m"].map(|name| 1e6 * period[name].as_f64().unwrap())
    };
    let [length, spread] = found(&[]);
    assert!((length - 1.2).abs() < 0.06 && (0.003..0.09).contains(&spread), "{length} ± {spread}");
    for steps in [["--level", "plane"], ["--level", "polynomial:2"], ["--level", "polynomial:4"]] {
        let [other, _] = found(&steps);
        assert!((other - length).abs() < 0.1 * spread, "{steps:?}: {other}, and not {length} ± {spread}");
    }
    for crop in ["30umx16um+0um+0um", "30umx16um+10um+0um"] {
        let [other, _] = found(&["--crop", crop]);
        assert!((other - length).abs() < 2.0 * spread, "{crop}: {other}, and not {length} ± {spread}");
    }
}

#[test]
fn a_scan_of_one_sample_or_one_line_is_a_surface() {
    let sandbox = Sandbox::new();
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n20,0,20,180,550\n");
    for (columns, rows) in [(1, 1), (1, 40), (40, 1)] {
        sandbox.write("thin.png", crate::sandbox::grey_png(columns, rows, |x, y| (x * 5 + y * 3) as u8));
        let options = ["thin.png", "--pixel-size", "90nm", "--height", "100nm"];
        sandbox.run2(&["surface", "info"], &options).done();
        let ask = ["--queries", "q.csv", "--coherence", "gaussian:4um", "--method"];
        for method in ["reference", "spectral"] {
            let csv = sandbox.run2(&["eval"], &[&options[..], &ask, &[method]].concat()).done();
            let brdf: f64 = csv.trim_end().rsplit(',').next().unwrap().parse().unwrap();
            assert!(brdf.is_finite() && brdf >= 0.0, "{columns} x {rows}, {method}: {csv}");
        }
    }
}

#[test]
fn info_tells_what_scalar_theory_errs_by_on_a_material() {
    let sandbox = Sandbox::new();
    let of = |arguments: &[&str]| {
        let info = sandbox.run2(&["surface", "info"], arguments).done();
        row(&info, "scalar theory").to_owned()
    };
    let long = ["sinusoid", "--height", "100nm", "--material"];
    let [metal, glass] = ["aluminium", "glass"].map(|m| of(&[&long[..], &[m]].concat()));
    assert!(
        metal.starts_with("diffracted orders err by ") && metal.contains("sinusoid on metal, period 3.8 λ"),
        "{metal}"
    );
    assert!(glass.contains(" % at 75°") && glass.contains("on dielectric"), "{glass}");
    assert_ne!(metal, glass);
    assert!(of(&["dvd"]).starts_with("not known: RMS slopes in two directions"));
    assert!(of(&["elaphe"]).contains("along the grooves left out"));
    let te = of(&[&long[..], &["glass", "--polarisation", "te"]].concat());
    assert!(te.contains("dielectric in TE light") && te != glass, "{te}");
    let json = sandbox.run(["surface", "info", "sinusoid", "--json", "--material", "aluminium"]).done();
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    let theory = &report["scalar_theory"];
    assert!(theory["line"].as_str().unwrap().starts_with("diffracted orders err by "), "{theory}");
    assert!((theory["grooves"]["period_m"].as_f64().unwrap() / 2e-6 - 1.0).abs() < 1e-3, "{theory}");
    let errors = theory["errors"].as_array().unwrap();
    assert_eq!(errors[0]["angle_deg"], 0.0);
    assert!(errors.iter().all(|e| ["mean", "te", "tm"].iter().all(|name| e[name].as_f64().unwrap() > 0.0)));
    let refused = sandbox.run(["surface", "info", "--material", "no.csv"]).refused(1);
    assert!(refused.contains("no.csv"), "{refused}");
}

#[test]
fn a_height_that_no_surface_has_is_questioned_whoever_says_it() {
    let sandbox = Sandbox::with_small_surface();
    let questioned = |words: &[&str]| {
        let outcome = sandbox.run2(&["surface", "info"], words);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        outcome.stderr.contains("is the full height right that was given?")
    };
    assert!(questioned(&["elaphe", "--height", "434.7um"]));
    assert!(!questioned(&["elaphe", "--height", "434.7nm"]));
    let small = ["small.png", "--pixel-size", "83nm", "--height"];
    assert!(questioned(&[&small[..], &["137um"]].concat()));
    assert!(!questioned(&[&small[..], &["137nm"]].concat()));
}

#[test]
fn heights_that_32_bit_floats_round_are_told_by_the_formats_that_have_them_alone() {
    let sandbox = Sandbox::new();
    let rows: String = (0..4).map(|i| format!("{}\t{}\n", 1.0 + f64::from(i) * 1e-7, 1.0 + 3e-8)).collect();
    sandbox.write(
        "high.txt",
        format!("# Channel: Topo\n# Width: 20 nm\n# Height: 80 nm\n# Value units: m\n{rows}"),
    );
    let told = |output: &str, more: &[&str]| {
        let outcome = sandbox.run2(&["surface", "convert", "high.txt", "-o", output], more);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        outcome.stderr.contains("32-bit floats round the heights")
    };
    assert!(told("a.gsf", &[]) && told("a.tif", &[]));
    assert!(!told("a.npy", &[]) && !told("a.gsf", &["--level", "mean"]));
}

#[test]
fn the_corner_of_a_crop_may_be_zero_in_any_form() {
    let sandbox = Sandbox::new();
    // The command is noted as it was given.
    let cropped = |crop: &str| {
        let json = sandbox.run(["surface", "info", "blaze", "--json", "--crop", crop]).done();
        json.split_once("\"command\"").unwrap().0.to_owned()
    };
    let expected = cropped("10um+0um+1um");
    for crop in ["10um+0.0um+1um", "10um+0 nm+1um", "10um+0e0mm+1000nm"] {
        assert_eq!(cropped(crop), expected, "{crop}");
    }
    sandbox.run(["surface", "info", "blaze", "--crop", "0.0um+0um+1um"]).refused(2);
}

#[test]
fn surfaces_are_compared_in_a_row_each_with_the_numbers_of_the_other_commands() {
    let sandbox = Sandbox::new();
    for (name, height) in [("a.gsf", "100nm"), ("b.gsf", "140nm")] {
        let make = ["surface", "synth", "sinusoid", "--patch", "12um", "--height", height, "-o", name];
        assert_eq!(sandbox.run(make).code, Some(0));
    }
    let ask = ["--aspecular", "25,60", "--aperture", "0deg", "--illuminant", "d50"];
    let compare = ["surface", "compare", "a.gsf", "b.gsf", "--plot", "c.svg"];
    let csv = sandbox.run2(&compare, &ask).done();
    let lines: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    let cell = |row: usize, name: &str| {
        let place = lines[0].iter().position(|column| *column == name).unwrap_or_else(|| panic!("{csv}"));
        lines[row][place]
    };
    let number = |row: usize, name: &str| cell(row, name).parse::<f64>().unwrap();
    assert_eq!((cell(1, "surface"), cell(2, "surface"), lines.len()), ("a.gsf", "b.gsf", 3));
    assert!((number(1, "range") - 100.0).abs() < 1.0 && (number(2, "range") - 140.0).abs() < 1.5, "{csv}");
    assert!((number(2, "Sq") / number(1, "Sq") - 1.4).abs() < 1e-3, "{csv}");
    assert_eq!((cell(1, "method"), number(1, "dE_45as25")), ("line", 0.0));
    assert!(number(2, "dE_45as25") > 0.5, "{csv}");
    let info: serde_json::Value =
        serde_json::from_str(&sandbox.run(["surface", "info", "b.gsf", "--json"]).done()).unwrap();
    let period = info["statistics"]["periods"][0]["length_m"].as_f64().unwrap();
    assert!((number(2, "period") / (1e9 * period) - 1.0).abs() < 1e-5, "{csv}");
    let colour = sandbox.run2(&["colour", "b.gsf", "--light", "45"], &ask).done();
    let read: Vec<f64> =
        colour.lines().nth(1).unwrap().split(',').skip(8).take(3).map(|x| x.parse().unwrap()).collect();
    for (name, value) in ["L_45as25", "a_45as25", "b_45as25"].into_iter().zip(read) {
        assert!((number(2, name) - value).abs() < 2e-3, "{name}: {csv}");
    }
    let svg = String::from_utf8(sandbox.read("c.svg")).unwrap();
    assert!(svg.contains("a.gsf") && svg.contains("b.gsf"));
}

#[test]
fn a_folder_is_compared_without_what_is_no_height_field() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("scans")).unwrap();
    for name in ["scans/b.gsf", "scans/a.gsf"] {
        let make = ["surface", "synth", "sinusoid", "--patch", "6um", "-o", name];
        assert_eq!(sandbox.run(make).code, Some(0));
    }
    sandbox.write("scans/notes.txt", "nothing");
    sandbox.write("scans/page.html", "nothing");
    let outcome = sandbox.run(["surface", "compare", "scans", "--aspecular", "45", "--aperture", "0deg"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let names: Vec<&str> =
        outcome.stdout.lines().skip(1).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(names, ["scans/a.gsf", "scans/b.gsf"]);
    assert!(outcome.stderr.contains("left out: scans/notes.txt"), "{outcome:?}");
    assert!(!outcome.stderr.contains("page.html"), "{outcome:?}");
    let no_scan = sandbox.run(["surface", "compare", "scans/notes.txt"]);
    assert_ne!(no_scan.code, Some(0));
    std::fs::create_dir(sandbox.path("empty")).unwrap();
    assert!(sandbox.run(["surface", "compare", "empty"]).stderr.contains("holds no height fields"));
}

#[test]
fn a_grating_is_made_of_ridges_or_of_a_formula() {
    let sandbox = Sandbox::new();
    let synth = |words: &[&str]| sandbox.run2(&["surface", "synth"], words);
    synth(&["lamellar", "--duty", "0.5", "--period", "2um", "-o", "a.npy"]).done();
    synth(&["--profile", "0.2 if x < 0.5 else 0", "--period", "2um", "-o", "b.npy"]).done();
    assert!(sandbox.read("a.npy") == sandbox.read("b.npy"), "both are the same samples");
    for (words, part) in [
        (&["blaze", "--profile", "x", "-o", "c.npy"][..], "--profile"),
        (&["--profile", "y", "-o", "c.npy"], "not of x alone"),
        (&["blaze", "--duty", "0.5", "-o", "c.npy"], "take lamellar"),
        (&["-o", "c.npy"], "KIND"),
    ] {
        let line = synth(words).refused(2);
        assert!(line.contains(part), "{line}");
    }
}
