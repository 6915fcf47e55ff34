//! Peak angles and the grating equation.

use crate::sandbox::{Outcome, Sandbox};

/// The blaze's first order with light from the steep side and from the flat side, and the view angles that hold it from
/// 380 to 780 nm.
const SIDES: [(&str, &str); 2] = [("75", "-57:-38:0.01"), ("-75", "38:57:0.01")];
/// The blaze's period \[nm\].
const PERIOD: f64 = 2500.0;

fn peaks(sandbox: &Sandbox, surface: &str, theta_i: &str, angles: &str, more: &[&str]) -> Outcome {
    sandbox.run2(&["peaks", surface, "--theta-i", theta_i, "--angles", angles], more)
}

/// The lines of a run on stderr, without that on a slow machine which tells how much time is left.
fn said(outcome: &Outcome) -> Vec<String> {
    let lines = outcome.stderr.split_inclusive('\n');
    lines.filter(|line| !line.contains(": this takes about ")).map(str::to_owned).collect()
}

/// The table of a run that has to succeed with one line on stderr, and that line.
#[track_caller]
fn table(outcome: Outcome) -> (Vec<[f64; 4]>, String) {
    let said = said(&outcome);
    assert_eq!((outcome.code, said.len()), (Some(0), 1), "{outcome:?}");
    (rows(&outcome.stdout), said.concat())
}

/// wavelength, angle, period, response; NaN for empty cells.
#[track_caller]
fn rows(csv: &str) -> Vec<[f64; 4]> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("wavelength,angle,period,response"));
    let number = |cell: &str| if cell.is_empty() { f64::NAN } else { cell.parse().unwrap() };
    lines.map(|line| line.split(',').map(number).collect::<Vec<_>>().try_into().unwrap()).collect()
}

/// Largest deviation of one wavelength's period from `period`, and that of the mean, both relative.
fn deviations(rows: &[[f64; 4]], period: f64) -> (f64, f64) {
    let off = |d: f64| (d / period - 1.0).abs();
    let mean = rows.iter().map(|r| r[2]).sum::<f64>() / rows.len() as f64;
    (rows.iter().map(|r| off(r[2])).fold(0.0, f64::max), off(mean))
}

#[test]
fn the_blazes_period_comes_out_of_its_first_order_on_both_sides() {
    let sandbox = Sandbox::new();
    for (theta_i, angles) in SIDES {
        let outcome = peaks(&sandbox, "blaze", theta_i, angles, &["--json", "p.json"]);
        let (rows, line) = table(outcome);
        assert_eq!((rows.len(), rows[0][0], rows[400][0]), (401, 380.0, 780.0));
        let (worst, mean) = deviations(&rows, PERIOD);
        // The small-slope factor falls toward the horizon and moves the maximum of an order as wide as this one, 0.004 in u, toward the normal.
        assert!(worst < 1.2e-3 && mean < 2e-4, "{theta_i}: {worst:e}, {mean:e}");
        let (of_stam, _) = table(peaks(&sandbox, "blaze", theta_i, angles, &["--theory", "stam"]));
        let (worst, mean) = deviations(&of_stam, PERIOD);
        assert!(worst < 1e-3 && mean < 2e-4, "{theta_i} by Stam's theory: {worst:e}, {mean:e}");
        assert!(line.contains("401 of 401 wavelengths"), "{line}");
        // The same judgement has to tell a period that is a thousandth off.
        assert!(deviations(&rows, PERIOD * 1.001).1 > 2e-4);

        let json: serde_json::Value = serde_json::from_slice(&sandbox.read("p.json")).unwrap();
        let average = rows.iter().map(|r| r[2]).sum::<f64>() / rows.len() as f64;
        let variance = rows.iter().map(|r| (r[2] - average).powi(2)).sum::<f64>() / 400.0;
        let close = |value: &serde_json::Value, x: f64| (value.as_f64().unwrap() - x).abs() < 1e-6;
        assert!(close(&json["period_nm"]["mean"], average), "{json}");
        assert!(close(&json["period_nm"]["standard_deviation"], variance.sqrt()), "{json}");
        assert_eq!(
            (&json["clear"], &json["wavelengths"], &json["order"]),
            (&401.into(), &401.into(), &1.into())
        );
    }
}

#[test]
fn light_that_comes_in_the_other_way_is_brighter_in_the_blazes_first_order() {
    // The blaze rises along +x, so its facets lean toward -x and throw light there, away from the mirror direction at +75.
    let sandbox = Sandbox::new();
    let [away, toward] = SIDES.map(|(theta_i, angles)| {
        let more = ["--wavelengths", "550:550:1", "--coherence", "gaussian:30um"];
        table(peaks(&sandbox, "blaze", theta_i, angles, &more)).0[0][3]
    });
    assert!(toward > 3.0 * away, "{toward} {away}");
}

#[test]
fn the_reference_finds_the_same_angles_without_vulkan() {
    let sandbox = Sandbox::new();
    let no_vulkan = Sandbox::new().without_vulkan();
    let more = ["--wavelengths", "450:650:100", "--pixel-size", "95nm", "--coherence", "gaussian:40um"];
    let spectral = table(peaks(&sandbox, "blaze", "-75", "40:54:0.1", &more)).0;
    let by_sum = [&more[..], &["--method", "reference"]].concat();
    let (reference, _) = table(peaks(&no_vulkan, "blaze", "-75", "40:54:0.1", &by_sum));
    assert_eq!(reference.len(), 3);
    for (a, b) in spectral.iter().zip(&reference) {
        // Two neighbouring angles of the sweep can be as bright within the tolerance.
        assert!((a[1] - b[1]).abs() < 0.1001 && (a[3] / b[3] - 1.0).abs() < 2e-2, "{a:?} {b:?}");
        assert!((b[2] / PERIOD - 1.0).abs() < 5e-3, "{b:?}");
    }
    let of_window = [&more[..], &["--windows", "1x1"]].concat();
    let line = peaks(&no_vulkan, "blaze", "-75", "40:54:0.1", &of_window).refused(1);
    assert!(line.contains("mesa-vulkan-drivers"), "{line}");
}

#[test]
fn the_axis_turns_the_plane_of_incidence_and_the_order_multiplies_the_period() {
    let sandbox = Sandbox::new();
    let more = ["--wavelengths", "500:600:50", "--coherence", "gaussian:30um"];
    let ask = |angles: &str, own: &[&str]| {
        table(peaks(&sandbox, "blaze", "20", angles, &[&more[..], own].concat())).0
    };
    // The blaze is constant along y: nothing but the mirror's spot there, where there is no period.
    for row in ask("-30:-10:0.5", &["--axis", "y"]) {
        assert!(row[1] == -20.0 && row[2].is_nan() && row[3] > 0.0, "{row:?}");
    }
    let (first, third) = (ask("-40:-28:0.1", &[]), ask("-40:-28:0.1", &["--order", "3"]));
    for (a, b) in first.iter().zip(&third) {
        assert_eq!(a[1], b[1]);
        assert!((b[2] / a[2] - 3.0).abs() < 1e-9 && (a[2] / PERIOD - 1.0).abs() < 2e-2, "{a:?} {b:?}");
    }
}

#[test]
fn a_peak_at_an_end_is_not_clear_and_darkness_has_empty_cells() {
    let sandbox = Sandbox::new();
    let more = ["--wavelengths", "500:600:50", "--coherence", "gaussian:30um", "--method", "reference"];
    let (rows, line) = table(peaks(&sandbox, "flat", "30", "-29.5:-20:0.5", &more));
    assert!(rows.iter().all(|r| r[1] == -29.5), "{rows:?}");
    assert!(line.contains("0 of 3 wavelengths"), "{line}");
    // Samples 400 nm apart hold |u| up to 0.69 at 550 nm, and this range is beyond.
    let coarse = [&more[..], &["--pixel-size", "400nm"]].concat();
    let outcome = peaks(&sandbox, "flat", "60", "60:70:1", &coarse);
    assert!(outcome.stdout.lines().skip(1).all(|l| l.ends_with(",,,0e0")), "{outcome:?}");
    assert!(outcome.stderr.contains("no period"), "{outcome:?}");
}

#[test]
fn a_named_table_holds_what_stdout_would() {
    let sandbox = Sandbox::new();
    let more = ["--wavelengths", "550:550:1", "--coherence", "gaussian:10um", "--method", "reference"];
    let printed = peaks(&sandbox, "flat", "30", "-40:-20:1", &more).stdout;
    let named = peaks(&sandbox, "flat", "30", "-40:-20:1", &[&more[..], &["-o", "p.csv"]].concat());
    assert_eq!((named.code, named.stdout.as_str()), (Some(0), ""));
    assert_eq!(sandbox.read("p.csv"), printed.as_bytes());
    assert_eq!(rows(&printed)[0][1], -30.0);
}

#[test]
fn several_orders_say_the_same_period_each_from_its_own_angles() {
    let sandbox = Sandbox::new();
    let more = ["--wavelengths", "400:700:50", "--order", "3,1,2", "--period", "2.4um", "--json", "p.json"];
    let outcome = peaks(&sandbox, "blaze", "-75", "0:60:0.02", &more);
    assert_eq!((outcome.code, said(&outcome).len()), (Some(0), 3), "{outcome:?}");
    let mut lines = outcome.stdout.lines();
    assert_eq!(lines.next(), Some("wavelength,angle,period,response,order"));
    let mut seen = [0; 4];
    for line in lines {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert!((cells[2] / PERIOD - 1.0).abs() < 3e-3, "{line}");
        seen[cells[4] as usize] += 1;
    }
    assert_eq!(seen, [0, 7, 7, 7]);
    let json: serde_json::Value = serde_json::from_slice(&sandbox.read("p.json")).unwrap();
    assert_eq!([0, 1, 2].map(|i| json[i]["order"].as_i64()), [Some(1), Some(2), Some(3)]);
    let line = peaks(&sandbox, "blaze", "-75", "0:60:1", &["--order", "1,2"]).refused(2);
    assert!(line.contains("--period"), "{line}");
}

#[test]
fn windows_are_told_one_by_one_and_their_average_differs_from_each() {
    let sandbox = Sandbox::new();
    let surface = ["--coherence", "gaussian:20um", "--pixel-size", "120nm", "--basis", "optimal"];
    let more =
        [&surface[..], &["--wavelengths", "500:600:20", "--windows", "2x1", "--json", "p.json"]].concat();
    let outcome = peaks(&sandbox, "elaphe", "-75", "20:40:0.05", &more);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let said: Vec<&str> = outcome.stderr.lines().filter(|line| line.contains("period")).collect();
    assert!(
        said.len() == 3 && said[0].contains("window 1 of 2") && said[2].contains("all windows"),
        "{said:?}"
    );
    let json: serde_json::Value = serde_json::from_slice(&sandbox.read("p.json")).unwrap();
    let mean = |value: &serde_json::Value| value["period_nm"]["mean"].as_f64().unwrap();
    let (one, other, all) = (mean(&json["windows"][0]), mean(&json["windows"][1]), mean(&json));
    assert!(one != other && all != one && all != other, "{one} {other} {all}");
    // The jackknife over two windows is half their difference.
    let error = json["over_windows"]["standard_error_nm"].as_f64().unwrap();
    assert!((error - (one - other).abs() / 2.0).abs() < 1e-9, "{error} {one} {other}");
    assert!(
        said[2].contains("standard error") && json["over_windows"]["interval_95_nm"].is_null(),
        "{said:?}"
    );
}

#[test]
fn the_direct_sum_says_the_same_of_each_window() {
    let sandbox = Sandbox::new();
    let ask = |method: &str| {
        let more = ["--wavelengths", "550:550:1", "--coherence", "gaussian:20um", "--pixel-size", "120nm"];
        let more = [&more[..], &["--windows", "3x2", "--json", "p.json", "--method", method]].concat();
        let outcome = peaks(&sandbox, "elaphe", "-75", "26:36:0.5", &more);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let json: serde_json::Value = serde_json::from_slice(&sandbox.read("p.json")).unwrap();
        (rows(&outcome.stdout)[0], json["windows"].clone())
    };
    let ((of_device, windows), (of_sum, expected)) = (ask("spectral"), ask("reference"));
    assert_eq!(windows, expected);
    let distinct: std::collections::HashSet<String> =
        windows.as_array().unwrap().iter().map(|window| window["period_nm"]["mean"].to_string()).collect();
    assert!(distinct.len() > 2, "{windows}");
    // Twice the default tolerance: for the sum the surface moves by whole samples, on the device the window by any distance.
    assert_eq!(of_device[1], of_sum[1]);
    assert!((of_device[3] / of_sum[3] - 1.0).abs() < 2e-2, "{of_device:?} {of_sum:?}");
}

#[test]
fn the_mean_over_all_windows_has_the_standard_error_of_some_of_them() {
    let sandbox = Sandbox::new();
    let spread = |windows: &str, angles: &str| {
        let more = ["--wavelengths", "500:500:1", "--coherence", "gaussian:32um", "--pixel-size", "125nm"];
        let more = [&more[..], &["--json", "p.json", "--windows", windows]].concat();
        let outcome = peaks(&sandbox, "elaphe", "-75", angles, &more);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let json: serde_json::Value = serde_json::from_slice(&sandbox.read("p.json")).unwrap();
        (said(&outcome), json)
    };
    let ((lines, all), (_, some)) = (spread("all", "29:35:0.02"), spread("4x4", "29:35:0.02"));
    assert!(lines.len() == 1 && lines[0].contains("95 % within"), "{lines:?}");
    // The patch of 65 um has 10.5 windows of 8 um that are independent: 4 x 4 are looked at, and none is told alone.
    let number = |json: &serde_json::Value, name: &str| json["over_windows"][name].as_f64().unwrap();
    assert!((number(&all, "independent_windows") - 10.5).abs() < 0.1, "{all}");
    assert!(all["windows"].is_null(), "{all}");
    let errors = [&all, &some].map(|json| number(json, "standard_error_nm"));
    assert!(errors[0] > 1.0 && (errors[0] - errors[1]).abs() < 1e-9, "{errors:?}");
    let mean = |json: &serde_json::Value| json["period_nm"]["mean"].as_f64().unwrap();
    let interval: Vec<f64> = serde_json::from_value(all["over_windows"]["interval_95_nm"].clone()).unwrap();
    assert!((interval[0] + interval[1]) / 2.0 - mean(&all) < 1e-9, "{all}");
    assert!(interval[0] - 1e-9 < mean(&some) && mean(&some) < interval[1] + 1e-9, "{all} {some}");
    let (lines, coarse) = spread("all", "29:35:0.2");
    assert!(lines[0].contains("lie at the same angles: a smaller step of --angles"), "{lines:?}");
    assert!(coarse["over_windows"]["interval_95_nm"].is_null(), "{coarse}");
}

#[test]
fn the_figure_has_the_peaks_and_the_grating_equation() {
    let sandbox = Sandbox::new();
    let more = ["--wavelengths", "400:700:50", "--coherence", "gaussian:20um", "--plot", "p.svg"];
    table(peaks(&sandbox, "blaze", "-75", "38:57:0.5", &more));
    let svg = String::from_utf8(sandbox.read("p.svg")).unwrap();
    for words in
        ["wavelength [nm]", "largest response", "grating equation", "standard deviation", "BRDF [sr⁻¹]"]
    {
        assert!(svg.contains(words), "{words}");
    }
}

#[test]
fn grooves_that_do_not_fit_the_patch_go_on_alike_and_copies_of_them_are_told() {
    let sandbox = Sandbox::new();
    // 12.35 periods of 1.3 µm over 16.055 µm, whose edges are at one height.
    let (period, periods, samples) = (1.3, 12.35, 200u32);
    let pixel = period * periods / f64::from(samples) * 1e3;
    let height =
        |i: u32| (std::f64::consts::TAU * (periods * f64::from(i) / f64::from(samples) + 0.075)).sin();
    sandbox.write("g.png", crate::sandbox::grey_png(samples, 60, |x, _| (127.5 + 127.0 * height(x)) as u8));
    let file = ["g.png", "--pixel-size", &format!("{pixel}nm"), "--height", "100nm"];
    let info = sandbox.run2(&["surface", "info"], &file).done();
    assert!(info.contains("12.35 periods along x"), "{info}");
    let found = |more: &[&str]| {
        let ask =
            ["--theta-i", "60", "--angles=-45:-5:0.02", "--wavelengths", "450:650:50", "--json", "p.json"];
        let outcome = sandbox.run2(&["peaks"], &[&file[..], &ask, more].concat());
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let json: serde_json::Value = serde_json::from_slice(&sandbox.read("p.json")).unwrap();
        (json["period_nm"]["mean"].as_f64().unwrap(), json["shift_of_copies_nm"].as_f64(), outcome.stderr)
    };
    let (alike, shift, _) = found(&[]);
    assert!((alike / 1300.0 - 1.0).abs() < 5e-3 && shift.is_none(), "{alike}, {shift:?}");
    let (copies, shift, said) = found(&["--beyond", "copies"]);
    let shift = shift.unwrap();
    assert!((copies - 1300.0).abs() > 20.0 && (copies - 1300.0).abs() < 1.1 * shift, "{copies}, {shift}");
    assert!(said.contains("the patch holds 12.35 periods along x, and its copies 12"), "{said}");
}
