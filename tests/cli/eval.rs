//! BRDF numbers.

use crate::sandbox::{SMALL, Sandbox, TIMEOUT};
use std::process::Stdio;
use std::time::{Duration, Instant};

const QUERIES: &str = "name,theta_i,phi_i,theta_r,phi_r,wavelength
mirror,20,0,20,180,550
\"near, the mirror\",20,0,21,178,460
far,35,40,12,10,610
below,95,0,10,0,500
";

/// Runs eval on the small surface with `more` options.
fn eval(sandbox: &Sandbox, more: &[&str]) -> String {
    // One of the queries is below the horizon, which is told.
    sandbox.run2(&["eval", "-q"], &[&SMALL[..], more].concat()).done()
}

/// The last `columns` cells of each row.
fn answers(csv: &str, columns: usize) -> Vec<Vec<f64>> {
    let rows = csv.lines().skip(1).map(|line| {
        let mut last: Vec<f64> = line.rsplit(',').take(columns).map(|cell| cell.parse().unwrap()).collect();
        last.reverse();
        last
    });
    rows.collect()
}

/// ‖a − b‖/‖b‖ over all cells.
fn deviation(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = || a.iter().flatten().zip(b.iter().flatten());
    (pairs().map(|(a, b)| (a - b).powi(2)).sum::<f64>() / pairs().map(|(_, b)| b * b).sum::<f64>()).sqrt()
}

#[test]
fn the_mean_needs_no_vulkan_and_one_window_says_what_to_install() {
    let sandbox = Sandbox::with_small_surface().without_vulkan();
    sandbox.write("q.csv", QUERIES);
    for method in ["reference", "spectral"] {
        let csv = eval(&sandbox, &["--queries", "q.csv", "--method", method]);
        assert!(answers(&csv, 1)[0][0] > 0.0);
    }
    for windows in ["1x1", "2x1"] {
        let more = ["--queries", "q.csv", "--windows", windows];
        let line = sandbox.run2(&["eval", "-q"], &[&SMALL[..], &more].concat()).refused(1);
        assert!(line.contains("mesa-vulkan-drivers"), "{line}");
    }
}

#[test]
fn answers_repeat_every_column_and_add_the_brdf() {
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("q.csv", QUERIES);
    for method in ["reference", "spectral"] {
        let csv = eval(&sandbox, &["--queries", "q.csv", "--method", method]);
        assert!(csv.starts_with("name,theta_i,phi_i,theta_r,phi_r,wavelength,brdf\n"), "{csv}");
        for (asked, answered) in QUERIES.lines().zip(csv.lines()) {
            assert!(answered.starts_with(&format!("{asked},")), "{answered}");
        }
        assert_eq!(csv.lines().count(), QUERIES.lines().count());
        assert_eq!(answers(&csv, 1)[3], [0.0], "light from below");
    }
}

#[test]
fn without_wavelengths_the_answer_is_a_colour() {
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r\n20,0,20,180\n20,0,25,170\n");
    let ask = |more: &[&str]| eval(&sandbox, &[&["--queries", "q.csv"], more].concat());
    let spectral = ask(&["--tolerance", "1e-2"]);
    assert!(spectral.starts_with("theta_i,phi_i,theta_r,phi_r,X,Y,Z\n20,0,20,180,"), "{spectral}");
    let (spectral, reference) = (answers(&spectral, 3), answers(&ask(&["--method", "reference"]), 3));
    assert!(reference[0].iter().all(|&x| x > 0.0));
    assert!(deviation(&spectral, &reference) < 1e-2, "{spectral:?} {reference:?}");
    let bluer = answers(&ask(&["--method", "reference", "--illuminant", "a"]), 3);
    assert!(deviation(&bluer, &reference) > 1e-1, "illuminant A is no D65: {bluer:?}");
}

#[test]
fn spectral_agrees_with_the_reference_within_the_tolerance_and_another_surface_does_not() {
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("q.csv", QUERIES);
    let ask = |more: &[&str]| answers(&eval(&sandbox, &[&["--queries", "q.csv"], more].concat()), 1);
    let reference = ask(&["--method", "reference"]);
    for tolerance in ["1e-2", "1e-3"] {
        let error = deviation(&ask(&["--tolerance", tolerance]), &reference);
        assert!(error <= tolerance.parse().unwrap(), "{tolerance}: {error}");
    }
    let other = ask(&["--method", "reference", "--ior", "1.6"]);
    assert!(deviation(&other, &reference) > 1e-2);
}

#[test]
fn a_named_output_holds_what_stdout_would_and_nothing_else_appears() {
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("q.csv", QUERIES);
    let method = ["--queries", "q.csv", "--method", "reference"];
    let printed = eval(&sandbox, &method);
    let before = sandbox.content().len();
    let silent = eval(&sandbox, &[&method[..], &["-o", "answers.csv"]].concat());
    assert_eq!(silent, "");
    assert_eq!(sandbox.read("answers.csv"), printed.as_bytes());
    assert_eq!(sandbox.content().len(), before + 1);
}

#[test]
fn tables_from_spreadsheets_are_read() {
    let sandbox = Sandbox::with_small_surface();
    let rows = "\u{feff}theta_i, phi_i, theta_r, phi_r, wavelength\r\n20, 0, 20, 180, 550\r\n";
    sandbox.write("q.csv", rows);
    let csv = eval(&sandbox, &["--queries", "q.csv", "--method", "reference"]);
    assert_eq!(answers(&csv, 1).len(), 1);
}

#[test]
fn colours_through_repeats_agree_with_the_reference_by_a_comb_and_at_the_orders() {
    let sandbox = Sandbox::new();
    // In the plane, out of it, near and in the mirror direction.
    sandbox.write(
        "q.csv",
        "theta_i,phi_i,theta_r,phi_r\n30,0,20,180\n60,0,20,0\n60,0,20,40\n30,0,29,180\n30,0,30,180\n",
    );
    let ask = |copies: &str, more: &[&str]| -> Vec<Vec<f64>> {
        let start = ["eval", "blaze", "--queries", "q.csv", "--coherence", copies];
        let outcome = sandbox.run2(&start, more);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let row = |line: &str| line.split(',').skip(4).map(|cell| cell.parse().unwrap()).collect();
        outcome.stdout.lines().skip(1).map(row).collect()
    };
    // RMS over directions, each relative to its own colour.
    let deviation = |a: &[Vec<f64>], b: &[Vec<f64>]| {
        let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>();
        let one = |(a, b): (&Vec<f64>, &Vec<f64>)| {
            norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / norm(&mut b.iter().copied())
        };
        (a.iter().zip(b).map(one).sum::<f64>() / b.len() as f64).sqrt()
    };
    for copies in ["repeats:4x1", "repeats:300x1"] {
        let reference = ask(copies, &["--method", "reference"]);
        let device = deviation(&ask(copies, &[]), &reference);
        assert!(device < 1e-2, "{copies}: {device:e}");
        assert!(deviation(&ask("repeats:5x1", &[]), &reference) > 5e-2, "{copies}: another number");
    }
}

#[test]
fn windows_are_averaged_one_after_another_by_layers() {
    let sandbox = Sandbox::with_small_surface();
    // Far from the mirror direction, where every window has a speckle of its own.
    let row = |i: i32| format!("{},{},{},{}\n", 5 * i, 40 * i, 60 - 6 * i, 170 - 25 * i);
    sandbox.write("q.csv", format!("theta_i,phi_i,theta_r,phi_r\n{}", (0..9).map(row).collect::<String>()));
    let of = |more: &[&str]| -> Vec<f64> {
        let setting = [&["--queries", "q.csv"][..], &SMALL[..6], more].concat();
        let csv = sandbox.run2(&["eval"], &setting).done();
        let row = |line: &str| line.split(',').skip(4).map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
        csv.lines().skip(1).flat_map(row).collect()
    };
    // RMS over directions, each relative to its own colour.
    let error = |a: &[f64], b: &[f64]| {
        let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>();
        let one = |(a, b): (&[f64], &[f64])| {
            norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / norm(&mut b.iter().copied())
        };
        (a.chunks(3).zip(b.chunks(3)).map(one).sum::<f64>() / 9.0).sqrt()
    };
    for coherence in ["gaussian:2um", "repeats:3x2"] {
        let with = |more: &[&str]| of(&[&["--coherence", coherence][..], more].concat());
        let exact = with(&["--method", "reference", "--windows", "2x3"]);
        let found = error(&with(&["--windows", "2x3"]), &exact);
        assert!(found < 1e-2, "{coherence}: {found:e}");
        for other in ["1x1", "3x2"] {
            let wrong = error(&with(&["--windows", other]), &exact);
            assert!(wrong > 2e-2, "{coherence}: {other} windows differ by {wrong:e} only");
        }
    }
}

#[test]
fn a_thousand_repeats_are_right_at_their_orders_and_hardly_beside_them() {
    let sandbox = Sandbox::new();
    // sin θ = j λ/d at normal incidence along x, d = 2.5 µm. Through a patch of 2.5 µm a phase of 1e-10 is an angle of 1.9e-10°.
    let mut queries = String::from("theta_i,phi_i,theta_r,phi_r,wavelength\n");
    for order in 1..=3 {
        let angle = (f64::from(order) * 0.5 / 2.5).asin().to_degrees();
        for off in [-1e-7, -1.9e-10, 0.0, 1.9e-10, 1e-7] {
            for turn in [0, 180] {
                queries += &format!("0,0,{},{turn},500\n", angle + off);
            }
        }
    }
    sandbox.write("q.csv", queries);
    for repeats in ["repeats:1x1", "repeats:1000x1", "repeats:1x1000", "repeats:1000x1000"] {
        let ask = |method: &str| {
            let more = ["--queries", "q.csv", "--coherence", repeats, "--method", method];
            answers(&sandbox.run2(&["eval", "blaze"], &more).done(), 1)
        };
        let (exact, found) = (ask("reference"), ask("spectral"));
        assert!(found.iter().flatten().all(|x| x.is_finite() && *x >= 0.0), "{repeats}: {found:?}");
        assert!(deviation(&found, &exact) < 1e-2, "{repeats}: {found:?} for {exact:?}");
    }
}

#[test]
fn a_surface_that_32_bit_powers_cannot_hold_needs_no_option_and_taylor_by_name_is_refused() {
    let sandbox = Sandbox::new();
    sandbox.write("q.csv", QUERIES);
    let ask = |more: &[&str]| {
        let window = ["--coherence", "gaussian:6um", "--windows", "1x1", "--queries", "q.csv"];
        sandbox.run2(&["eval", "xenopeltis", "-q"], &[&window[..], more].concat())
    };
    let (by_default, reference) = (ask(&[]).done(), ask(&["--method", "reference"]).done());
    assert!(deviation(&answers(&by_default, 1), &answers(&reference, 1)) < 1e-2, "{by_default} {reference}");
    let line = ask(&["--basis", "taylor"]).refused(1);
    assert!(line.contains("--basis optimal"), "{line}");
}

#[test]
fn a_basis_is_refused_with_the_mean_by_every_command_of_single_directions() {
    let sandbox = Sandbox::with_small_surface();
    sandbox.write("q.csv", QUERIES);
    for words in [
        &["eval", "flat", "--queries", "q.csv"][..],
        &["brdf", "flat", "--light", "30,0", "-o", "m.png"],
        &["peaks", "flat", "--theta-i", "30", "--angles", "0:9:1"],
    ] {
        let line = sandbox.run2(words, &["--basis", "optimal"]).refused(2);
        assert!(line.contains("--windows 1x1"), "{words:?}: {line}");
    }
}

#[test]
fn a_material_reflects_at_every_wavelength_what_fresnel_says() {
    let sandbox = Sandbox::new();
    sandbox.write("queries.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n0,0,0,0,450\n0,0,0,0,650\n");
    let values = |more: &[&str]| -> Vec<f64> {
        let ask = ["eval", "--queries", "queries.csv", "--surface", "flat", "--method", "reference"];
        let out = sandbox.run2(&ask, more).done();
        out.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect()
    };
    // Straight at a mirror everything but R is the same.
    let (plain, gold) = (values(&["--ior", "1.5"]), values(&["--material", "gold"]));
    let normal = |n: f64, k: f64| ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
    // Between the rows of Johnson and Christy: 430.5 and 450.9 nm, 616.8 and 659.5 nm.
    let between =
        |a: [f64; 2], b: [f64; 2], t: f64| normal(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]));
    let expected = [
        between([1.45, 1.948], [1.38, 1.914], 19.5 / 20.4),
        between([0.21, 3.272], [0.14, 3.697], 33.2 / 42.7),
    ];
    for (i, expected) in expected.iter().enumerate() {
        assert!((gold[i] / plain[i] * 0.04 / expected - 1.0).abs() < 1e-9, "{gold:?} {plain:?}");
    }
    // A quarter wave of 1.5 on 2.25 reflects nothing at 450 nm.
    let coated = values(&["--ior", "2.25", "--film", "75nm:1.5"]);
    assert!(coated[0] < 1e-12 * plain[0] && coated[1] > 1e-3 * plain[1], "{coated:?}");
    let refused = sandbox.run2(&["eval", "--queries", "queries.csv"], &["--ior", "2", "--material", "gold"]);
    refused.refused(2);
}

#[test]
fn polarised_light_has_fresnel_s_reflectance_of_its_field() {
    let sandbox = Sandbox::new();
    sandbox.write("queries.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n50,0,50,180,550\n");
    let ask = ["eval", "--queries", "queries.csv", "--surface", "flat", "--method", "reference"];
    let value = |more: &[&str]| -> f64 {
        let out = sandbox.run2(&ask, more).done();
        out.lines().nth(1).unwrap().rsplit(',').next().unwrap().parse().unwrap()
    };
    // Fresnel's equations by the sine and the tangent law.
    let (i, t) = (50f64.to_radians(), (50f64.to_radians().sin() / 1.5).asin());
    let te = ((i - t).sin() / (i + t).sin()).powi(2);
    let tm = ((i - t).tan() / (i + t).tan()).powi(2);
    let plain = value(&[]);
    for (name, expected) in [("te", te), ("tm", tm), ("none", 0.5 * (te + tm))] {
        let found = value(&["--polarisation", name]) / plain * 0.5 * (te + tm);
        assert!((found / expected - 1.0).abs() < 1e-9, "{name}: {found} {expected}");
    }
    let refused = |more: &[&str]| sandbox.run2(&ask, more).refused(2);
    refused(&["--polarisation", "s"]);
    refused(&["--polarisation", "te", "--reflectance", "schlick"]);
    value(&["--polarisation", "none", "--reflectance", "schlick"]);
}

#[test]
fn questions_that_would_be_taken_for_others_are_refused_and_directions_below_the_horizon_are_told() {
    let sandbox = Sandbox::with_small_surface().without_vulkan();
    let queries = |text: &str| sandbox.write("q.csv", text);
    let eval = |more: &[&str]| sandbox.run2(&["eval", "blaze", "--queries", "q.csv"], more);
    for name in ["wavelenght", "Wavelength", "wavelengths", "wave length"] {
        queries(&format!("theta_i,phi_i,theta_r,phi_r,{name}\n0,0,10,0,550\n"));
        let line = eval(&[]).refused(1);
        assert!(line.contains(name) && line.contains("do you mean `wavelength`?"), "{line}");
    }
    queries("theta_i,phi_i,theta_r,phi_r,wavelength\n0,0,10,0,550\n");
    let line = eval(&["--illuminant", "a"]).refused(2);
    assert!(line.contains("--illuminant") && line.contains("single wavelength"), "{line}");
    queries("theta_i,phi_i,theta_r,phi_r,wavelength\n0,0,10,0,550\n0,0,120,0,550\n95,0,10,0,550\n");
    let told = eval(&[]);
    assert!(told.code == Some(0) && told.stderr.contains("2 of 3 queries"), "{}", told.stderr);
}

#[test]
fn heights_that_no_surface_has_are_refused_at_once() {
    let sandbox = Sandbox::new().without_vulkan();
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r\n30,0,20,0\n0,0,10,40\n");
    // Heights of a checkerboard \[m\].
    let board = |height: f64| -> String {
        let row =
            |y: u32| (0..8).map(|x| format!("{:e} ", height * f64::from((x + y) % 2))).collect::<String>();
        (0..8).map(|y| row(y) + "\n").collect()
    };
    for (height, said) in [
        (1e-3, "terms in z, more than 4096"),
        (0.5, "terms in z, more than 4096"),
        (1e10, "more than a kilometre"),
        (1e300, "more than a kilometre"),
    ] {
        sandbox.write("high.txt", board(height));
        let eval = "eval high.txt --pixel-size 100nm --queries q.csv".split(' ');
        let outcome = sandbox.run(eval);
        // A question about the unit may come before it.
        let last = outcome.stderr.lines().last().unwrap_or_default();
        assert!(outcome.code == Some(1) && outcome.stdout.is_empty(), "{height}: {outcome:?}");
        assert!(last.contains(said) && last.contains("check the") && last.len() < 300, "{height}: {last}");
    }
}

#[test]
fn work_of_many_minutes_says_so_after_some_seconds_and_names_what_is_shorter() {
    let sandbox = Sandbox::new();
    let rows: String = (0..40_000).map(|i| format!("30,0,{},180\n", f64::from(i) / 500.0)).collect();
    sandbox.write("q.csv", format!("theta_i,phi_i,theta_r,phi_r\n{rows}"));
    let words = [
        "eval",
        "elaphe",
        "--queries",
        "q.csv",
        "--method",
        "reference",
        "--windows",
        "1x1",
        "--theory",
        "stam",
    ];
    let told = std::fs::File::create(sandbox.path("told.txt")).unwrap();
    let mut command = sandbox.command(words);
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(told).spawn().unwrap();
    let begun = Instant::now();
    let line = loop {
        let text = String::from_utf8(sandbox.read("told.txt")).unwrap();
        if text.contains("more; ") || begun.elapsed() > TIMEOUT || child.try_wait().unwrap().is_some() {
            break text;
        }
        std::thread::sleep(Duration::from_millis(100));
    };
    let _ = child.kill();
    child.wait().unwrap();
    assert!(line.contains("directions: this takes about") && line.contains("is shorter"), "{line}");
}
