//! `--method table` as a user meets it.

use crate::sandbox::Sandbox;

/// Directions around the mirror's, a degree apart.
fn queries() -> String {
    let row = |i: i32| format!("20,0,{},{}\n", 17.0 + f64::from(i % 7), 171.0 + 3.0 * f64::from(i / 7));
    format!("theta_i,phi_i,theta_r,phi_r\n{}", (0..49).map(row).collect::<String>())
}

/// ‖found − exact‖/‖exact‖.
fn error(found: &[f64], exact: &[f64]) -> f64 {
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let off: Vec<f64> = found.iter().zip(exact).map(|(f, e)| f - e).collect();
    norm(&off) / norm(exact)
}

fn ask(sandbox: &Sandbox, more: &[&str]) -> Vec<f64> {
    let words = ["bumps", "--queries", "q.csv", "--coherence", "gaussian:8um"];
    numbers(&sandbox.run2(&["eval"], &[&words[..], more].concat()).done())
}

/// X, Y, Z of every answer.
fn numbers(csv: &str) -> Vec<f64> {
    csv.lines()
        .skip(1)
        .flat_map(|line| line.split(',').skip(4).map(|x| x.parse().unwrap()).collect::<Vec<_>>())
        .collect()
}

#[test]
fn colours_agree_with_the_reference_and_come_from_the_cache_the_next_time() {
    let sandbox = Sandbox::new();
    sandbox.write("q.csv", queries());
    let exact = ask(&sandbox, &["--method", "reference"]);
    let table = ["--method", "table", "--tolerance", "2e-2"];
    let found = ask(&sandbox, &table);
    assert!(error(&found, &exact) <= 2e-2, "{}", error(&found, &exact));
    let kept = || {
        let files = std::fs::read_dir(sandbox.cache()).unwrap().flatten();
        files.filter(|f| f.file_name().to_string_lossy().ends_with(".colours")).count()
    };
    assert_eq!(kept(), 1);
    assert_eq!(ask(&sandbox, &table), found);
    assert_eq!(kept(), 1);
    // Another light makes another table.
    let other = ask(&sandbox, &[&table[..], &["--illuminant", "a"]].concat());
    assert!(other != found && kept() == 2);
}

#[test]
fn a_table_of_a_laser_agrees_with_the_reference() {
    let sandbox = Sandbox::new();
    sandbox.write("q.csv", queries());
    // Narrower than the distance of wavelengths in any sum.
    sandbox.write("laser.csv", "wavelength,power\n380,0\n632.75,0\n632.8,1\n632.85,0\n780,0\n");
    let laser = ["--illuminant", "laser.csv"];
    let exact = ask(&sandbox, &[&laser[..], &["--method", "reference"]].concat());
    let found = ask(&sandbox, &[&laser[..], &["--method", "table", "--tolerance", "1e-2"]].concat());
    assert!(error(&found, &exact) <= 1e-2, "{}", error(&found, &exact));
    let [x, y] = [0, 1].map(|i| exact.iter().skip(i).step_by(3).sum::<f64>());
    let pure = diffract::internals::optics::spectrum::observer(632.8);
    assert!((x / y / (pure.x / pure.y) - 1.0).abs() < 5e-3, "{}", x / y);
}

#[test]
fn what_a_table_cannot_do_is_refused_with_the_reason() {
    // Some devices would have room for a large one.
    let sandbox = Sandbox::new().with("DIFFRACT_DEVICE_MASK", "memory=4GiB");
    sandbox.write("q.csv", queries());
    sandbox.write("w.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n20,0,20,180,550\n");
    let refused = |code: i32, words: &[&str]| sandbox.run2(words, &["--method", "table"]).refused(code);
    for words in [
        &["eval", "blaze", "--queries", "w.csv"][..],
        &["brdf", "blaze", "--light", "30,0", "--wavelength", "550nm", "-o", "b.png"],
        &["peaks", "blaze", "--theta-i", "30", "--wavelengths", "500:600:50", "--angles", "0:10:1"],
    ] {
        assert!(refused(2, words).contains("single wavelength"), "{words:?}");
    }
    let queries = ["eval", "blaze", "--queries", "q.csv"];
    let with = |more: &[&'static str]| [&queries[..], more].concat();
    // A table is of the mean: not through one window, nor through repeats.
    for one in [&["--windows", "2x3"][..], &["--windows", "1x1"], &["--coherence", "repeats:3x3"]] {
        let line = refused(2, &with(one));
        assert!(line.contains("the mean over all windows") && line.contains("--method spectral"), "{line}");
    }
    assert!(refused(2, &with(&["--terms", "9"])).contains("--terms"));
    let exact = refused(2, &with(&["--tolerance", "5e-4"]));
    assert!(exact.contains("1e-3") && exact.contains("--method spectral"), "{exact}");
    let exact = refused(2, &["render", "plate", "--surface", "blaze", "--tolerance", "5e-4", "-o", "x.png"]);
    assert!(exact.contains("1e-3") && exact.contains("--windows 1x1"), "{exact}");
    let large = refused(1, &with(&["--coherence", "gaussian:500um", "--tolerance", "5e-3"]));
    assert!(large.contains("--tolerance") || large.contains("--coherence"), "{large}");
}

#[test]
fn a_profile_counts_three_samples_for_each_tap() {
    let sandbox = Sandbox::new();
    let words = "profile sphere --surface bumps --coherence gaussian:8um --tolerance 1e-1 --size 32x24 --frames 3 \
                 --method table --json p.json";
    sandbox.run(words.split_whitespace()).done();
    let json = String::from_utf8(sandbox.read("p.json")).unwrap();
    assert!(json.contains("\"method\": \"table\""), "{json}");
    let (_, rest) = json.split_once("\"samples_per_covered_pixel\": ").unwrap();
    let samples: f64 = rest.split([',', '\n']).next().unwrap().trim().parse().unwrap();
    assert!(samples >= 3.0 && samples <= 3.0 * diffract::internals::filter::MOST_OF_ROW as f64, "{samples}");
}

#[test]
fn a_patch_that_says_little_has_no_table_alike() {
    let sandbox = Sandbox::new();
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r\n20,0,40,180\n");
    // The patch is refused through any window and within any tolerance.
    let quick = ["--method", "table", "--coherence", "gaussian:8um", "--tolerance", "1e-1"];
    let ask = [&["eval", "xenopeltis", "--queries", "q.csv", "--beyond", "alike"], &quick[..]].concat();
    let e = sandbox.run2(&ask, &["--crop", "0.4um"]).refused(2);
    assert!(e.contains("0.362") && e.contains("a larger --crop") && e.contains("--beyond copies"), "{e}");
    sandbox.run2(&ask, &["--crop", "1.2um"]).done();
    let copies = [&ask[..4], &["--beyond", "copies", "--crop", "0.4um"], &quick].concat();
    sandbox.run(copies).done();
}
