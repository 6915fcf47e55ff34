//! Orders of periodic surfaces, against closed forms.

use crate::sandbox::Sandbox;
use diffract::internals::optics::geometry::direction;
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A row of the answer.
#[derive(Clone, Copy, Debug)]
struct Order {
    view: DVec3,
    efficiency: f64,
    reflectance: f64,
    period: Option<f64>,
}

/// The rows of an answer by wavelength [nm], m and n.
fn rows(csv: &str) -> BTreeMap<(i64, i64, i64), Order> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("wavelength,m,n,theta_r,phi_r,efficiency,reflectance,period"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), 8, "{line}");
        let number = |i: usize| cells[i].parse::<f64>().unwrap();
        let order = Order {
            view: direction(number(3), number(4)),
            efficiency: number(5),
            reflectance: number(6),
            period: (!cells[7].is_empty()).then(|| number(7)),
        };
        ((number(0) as i64, number(1) as i64, number(2) as i64), order)
    };
    lines.map(row).collect()
}

/// J_m(x) = (1/π) ∫ cos(mτ − x sin τ) dτ over 0 … π, by the midpoint rule, which converges at once for periodic integrands.
fn bessel(m: i64, x: f64) -> f64 {
    const STEPS: usize = 400;
    let at = |i: usize| {
        let t = PI * (i as f64 + 0.5) / STEPS as f64;
        (m as f64 * t - x * t.sin()).cos()
    };
    (0..STEPS).map(at).sum::<f64>() / STEPS as f64
}

/// G/w² of B.13: the share of an order is this times |c_m|².
fn factor(light: DVec3, view: DVec3) -> f64 {
    (1.0 + light.dot(view)).powi(2) / (light.z * view.z * (light.z + view.z).powi(2))
}

/// ω_r at (u, v), and k|w| there; `None` below the horizon.
fn view(light: DVec3, [u, v]: [f64; 2], wavelength: f64) -> Option<(DVec3, f64)> {
    let (x, y) = (-light.x - u, -light.y - v);
    let z = 1.0 - x * x - y * y;
    (z > 0.0).then(|| (DVec3::new(x, y, z.sqrt()), TAU / wavelength * (light.z + z.sqrt())))
}

/// Compares `found` with the `power` |c_mn|²(k|w|) of a surface of periods `period` [µm]; returns the largest deviation of an efficiency over its reflectance.
fn deviation(
    found: &BTreeMap<(i64, i64, i64), Order>,
    light: DVec3,
    wavelength: f64,
    period: [f64; 2],
    power: &dyn Fn(i64, i64, f64) -> f64,
) -> f64 {
    let nm = (wavelength * 1e3).round() as i64;
    let mut worst: f64 = 0.0;
    for (m, n) in (-12..=12).flat_map(|n| (-12..=12).map(move |m| (m, n))) {
        let uv = [m as f64 * wavelength / period[0], n as f64 * wavelength / period[1]];
        let order = found.get(&(nm, m, n));
        let Some((view, z)) = view(light, uv, wavelength) else {
            assert!(order.is_none(), "{m},{n} does not propagate");
            continue;
        };
        let expected = factor(light, view) * power(m, n, z);
        let efficiency = order.map_or(0.0, |order| {
            assert!((order.view - view).length() < 1e-7, "{m},{n}: {:?} {view}", order.view);
            let frequency = (m as f64 / period[0]).hypot(n as f64 / period[1]);
            assert_eq!(order.period.is_none(), (m, n) == (0, 0));
            assert!(order.period.is_none_or(|period| (period * frequency / 1e3 - 1.0).abs() < 1e-6));
            order.efficiency / order.reflectance
        });
        worst = worst.max((efficiency - expected).abs());
    }
    worst
}

#[test]
fn orders_of_a_sinusoid_take_squared_bessel_functions_in_and_out_of_its_plane() {
    let sandbox = Sandbox::new().without_vulkan();
    for (theta, phi) in [(0.0, 0.0), (45.0, 0.0), (60.0, 30.0), (75.0, 120.0)] {
        let light = format!("{theta},{phi}");
        let arguments = ["orders", "-q", "sinusoid", "--light", &light, "--wavelength", "550nm"];
        let csv = sandbox.run2(&arguments, &["--wavelength", "650nm", "--theory", "stam"]).done();
        let found = rows(&csv);
        let light = direction(theta, phi);
        for wavelength in [0.55, 0.65] {
            // 2 µm and an amplitude of 0.1 µm are those of the built-in surface, which its samples miss by a part in 10⁶.
            let off = |amplitude: f64| {
                let power = |m: i64, n: i64, z: f64| {
                    if n == 0 { bessel(m, z * amplitude).powi(2) } else { 0.0 }
                };
                deviation(&found, light, wavelength, [2.0, 20.0 / 216.0], &power)
            };
            assert!(off(0.1) < 1e-6, "{theta} {phi}: {:e}", off(0.1));
            assert!(off(0.101) > 1e-4, "{:e}", off(0.101));
        }
    }
}

/// Returns |B|² of a refractive index of 1.5 by the formulas of the small-slope approximation, for directions in the plane x, z.
fn kernel(light: DVec3, view: DVec3) -> f64 {
    const N2: f64 = 2.25;
    let [q_i, q_r] = [light, view].map(|d| (N2 - d.x * d.x).sqrt());
    // The wave vectors in the plane, −x of the light and x of the viewer, point to the same side or to opposite ones.
    let (cos, sines) = ((-light.x * view.x).signum(), (light.x * view.x).abs());
    let ss = (N2 - 1.0) * cos / ((light.z + q_i) * (view.z + q_r));
    let pp = (N2 - 1.0) * (q_i * q_r * cos - N2 * sines) / ((N2 * light.z + q_i) * (N2 * view.z + q_r));
    0.5 * (ss * ss + pp * pp)
}

#[test]
fn by_default_orders_have_the_factor_of_the_small_slope_approximation_and_add_up_to_at_most_all_light() {
    let sandbox = Sandbox::new().without_vulkan();
    let light = direction(60.0, 0.0);
    let of = |more: &[&str]| {
        let arguments =
            ["orders", "-q", "sinusoid", "--light", "60,0", "--wavelength", "550nm", "--height", "20nm"];
        rows(&sandbox.run2(&arguments, more).done())
    };
    let (small_slope, stam) = (of(&[]), of(&["--theory", "stam"]));
    assert_eq!(small_slope.len(), stam.len());
    let mut different = 0;
    for (order, other) in small_slope.values().zip(stam.values()) {
        let half = 0.5 * (1.0 + light.dot(order.view));
        let factor = 4.0 * light.z * order.view.z * kernel(light, order.view);
        // Stam's has R G; the ratio of the efficiencies is that of the factors.
        let of_stam = other.reflectance * 4.0 * half * half / (light.z * order.view.z);
        let ratio = order.efficiency / other.efficiency;
        // So shallow a surface has nearly the albedo of a flat one: the limit of energy takes less than this.
        assert!((ratio / (factor / of_stam) - 1.0).abs() < 5e-3, "{ratio} {factor} {of_stam}");
        different += usize::from((ratio - 1.0).abs() > 0.02);
    }
    assert!(different > 0, "the theories do not differ");
    // Grazing light on silver: Stam's theory makes light.
    let sum = |more: &[&str]| {
        let arguments =
            ["orders", "bumps", "--light", "80,20", "--wavelength", "550nm", "--material", "silver"];
        let outcome = sandbox.run2(&arguments, more);
        let sum: f64 = rows(&outcome.stdout).values().map(|order| order.efficiency).sum();
        let told = format!("take {sum:.4} of the light");
        assert!(outcome.stderr.contains(&told), "{told}: {}", outcome.stderr);
        (sum, outcome.stderr)
    };
    let ((limited, why), (free, warned)) = (sum(&[]), sum(&["--theory", "stam"]));
    assert!(limited <= 1.0 && limited > 0.8 && free > 1.2, "{limited} {free}");
    let above = "more light than falls on the surface";
    assert!(warned.contains(above) && !why.contains(above) && why.contains("is limited"), "{warned}{why}");
    assert!(why.contains("550.0 nm: scalar theory: not known: RMS slopes in two directions"), "{why}");
}

#[test]
fn wavelengths_beyond_what_is_known_of_a_material_are_refused() {
    let sandbox = Sandbox::new().without_vulkan();
    let orders = ["orders", "blaze", "--light", "30,0", "--wavelength"];
    // Johnson and Christy's table as it is shipped ends here; Schott's data sheet begins at 310 nm.
    for (material, wavelength) in
        [("silver", "320nm"), ("gold", "5um"), ("glass", "50nm"), ("keratin", "1um")]
    {
        let line = sandbox.run2(&orders, &[wavelength, "--material", material]).refused(2);
        assert!(line.contains(&format!("the refractive index of {material} is known from")), "{line}");
    }
    assert_eq!(sandbox.run2(&orders, &["320nm", "--ior", "1.5"]).code, Some(0));
    sandbox.write("q.csv", "theta_i,phi_i,theta_r,phi_r,wavelength\n30,0,20,0,550\n30,0,20,0,320\n");
    let line = sandbox.run("eval blaze --queries q.csv --material silver".split(' ')).refused(2);
    assert!(line.contains("not at 320.0 nm"), "{line}");
    // Columns have the names that they are read by.
    sandbox.write("swapped.csv", "wavelength,k,n\n300,3.5,0.05\n900,3.5,0.05\n");
    let line = sandbox.run2(&orders, &["550nm", "--material", "swapped.csv"]).refused(1);
    assert!(line.contains("the columns wavelength (nm or µm), n and k"), "{line}");
}

#[test]
fn orders_of_a_blaze_lean_to_the_side_of_its_facets() {
    let sandbox = Sandbox::new().without_vulkan();
    // The limit of energy of the default theory has words of its own.
    let arguments = ["orders", "-q", "blaze", "--light", "0,0", "--wavelength", "550nm", "--theory", "stam"];
    let found = rows(&sandbox.run(arguments).done());
    let order = |m: i64| found[&(550, m, 0)];
    assert!(order(1).efficiency > 100.0 * order(-1).efficiency, "{:?} {:?}", order(1), order(-1));
    assert!(order(1).view.x < 0.0, "u = mλ/d and the light is at the normal");
    let bright = rows(&sandbox.run2(&arguments, &["--least", "1e-3"]).done());
    let expected = found.values().filter(|order| order.efficiency >= 1e-3).count();
    assert!(bright.len() == expected && expected < found.len());
}

/// A surface of 24 × 20 samples, 0.1 µm apart: a sinusoid along x plus one along y, as heights in metres.
fn crossed() -> String {
    let height = |i: usize| {
        let (x, y) = ((i % 24) as f64 / 24.0, (i / 24) as f64 / 20.0);
        1e-6 * (0.05 * (TAU * x).sin() + 0.03 * (TAU * y).cos())
    };
    let rows = (0..20).map(|row| {
        let cells: Vec<String> = (0..24).map(|column| format!("{:e}", height(row * 24 + column))).collect();
        cells.join(" ") + "\n"
    });
    rows.collect()
}

#[test]
fn orders_of_crossed_sinusoids_are_products_and_their_reflectance_is_schlicks() {
    let sandbox = Sandbox::new().without_vulkan();
    sandbox.write("crossed.txt", crossed());
    let arguments = [
        "orders",
        "-q",
        "crossed.txt",
        "--pixel-size",
        "100nm",
        "--light",
        "25,70",
        "--wavelength",
        "450nm",
        "--reflectance",
        "schlick",
        "-o",
        "orders.csv",
    ];
    assert_eq!(sandbox.run(arguments).done(), "");
    let csv = String::from_utf8(sandbox.read("orders.csv")).unwrap();
    let (found, light) = (rows(&csv), direction(25.0, 70.0));
    let power = |m: i64, n: i64, z: f64| (bessel(m, z * 0.05) * bessel(n, z * 0.03)).powi(2);
    let off = deviation(&found, light, 0.45, [2.4, 2.0], &power);
    // Heights are read with the digits of the file; the samples alias orders 20 apart.
    assert!(off < 1e-6, "{off:e}");
    let turned = deviation(&found, light, 0.45, [2.4, 2.0], &|m, n, z| power(n, m, z));
    assert!(turned > 1e-2, "{turned:e}");
    for order in found.values() {
        let half = ((light + order.view).length() / 2.0).min(1.0);
        let schlick = 0.04 + 0.96 * (1.0 - half).powi(5);
        // Angles are written to 10⁻⁶ degrees.
        assert!((order.reflectance - schlick).abs() < 1e-7);
    }
}

#[test]
fn all_orders_together_take_what_the_material_reflects() {
    let sandbox = Sandbox::new().without_vulkan();
    let sum = |surface: &str, light: &str, more: &[&str]| {
        let arguments = ["orders", "-q", surface, "--light", light, "--wavelength", "550nm"];
        let found = rows(&sandbox.run2(&arguments, more).done());
        found.values().map(|order| order.efficiency / order.reflectance).sum::<f64>()
    };
    // A mirror sends everything into the specular order; order m of a grating takes G/w² |c_m|², and G/w² is 1 + O(θ_r²).
    assert!((sum("flat", "70,20", &[]) - 1.0).abs() < 1e-12);
    for (height, allowed) in [("50nm", 2e-3), ("198nm", 1e-2)] {
        let all = sum("sinusoid", "0,0", &["--height", height, "--theory", "stam"]);
        assert!((all - 1.0).abs() < allowed, "{height}: {all}");
    }
    let flat = ["orders", "-q", "flat", "--light", "0,0", "--wavelength", "550nm", "--material"];
    let silver = rows(&sandbox.run2(&flat, &["silver"]).done())[&(550, 0, 0)];
    let glass = rows(&sandbox.run2(&flat, &["glass"]).done())[&(550, 0, 0)];
    assert!(silver.efficiency > 0.9 && (0.03..0.06).contains(&glass.efficiency), "{silver:?} {glass:?}");
}

#[test]
fn a_patch_whose_edges_do_not_meet_is_told_and_lights_that_are_no_direction_are_refused() {
    let sandbox = Sandbox::new().without_vulkan();
    let steep: String = (0..20)
        .map(|row| {
            (0..20).map(|column| format!("{:e} ", 1e-8 * f64::from(row + column))).collect::<String>() + "\n"
        })
        .collect();
    sandbox.write("steep.txt", steep);
    let outcome =
        sandbox.run("orders steep.txt --pixel-size 100nm --light 0,0 --wavelength 550nm".split(' '));
    assert_eq!(outcome.code, Some(0));
    assert!(outcome.stderr.contains("edges of the patch do not meet"), "{}", outcome.stderr);
    assert!(rows(&outcome.stdout).len() > 20);
    for light in ["90,0", "sun:30,0", "30,0,2"] {
        let arguments = ["orders", "-q", "blaze", "--wavelength", "550nm", "--light", light];
        assert!(sandbox.run(arguments).refused(2).contains("no direction of light"), "{light}");
    }
    let told = sandbox.run("orders blaze --light 0,0 --wavelength 550nm --least 1e-2".split(' '));
    assert!(told.stderr.contains("550.0 nm: ") && told.stderr.contains("are left out"), "{}", told.stderr);
}

/// The rows of a sweep: numbers by the names of the columns, NaN for an empty cell.
fn swept(sandbox: &Sandbox, arguments: &[&str]) -> (Vec<BTreeMap<String, f64>>, String) {
    let outcome = sandbox.run2(&["orders"], arguments);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let mut lines = outcome.stdout.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |line: &str| {
        let cells =
            line.split(',').map(|cell| if cell.is_empty() { f64::NAN } else { cell.parse().unwrap() });
        names.iter().map(|name| (*name).to_owned()).zip(cells).collect()
    };
    (lines.map(row).collect(), outcome.stderr)
}

#[test]
fn sweeps_are_the_orders_of_each_point_in_each_polarisation() {
    let sandbox = Sandbox::new();
    let surface = ["sinusoid", "--material", "aluminium"];
    let all = |more: &[&str]| swept(&sandbox, &[&surface[..], more].concat()).0;
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-8 * a.abs().max(b.abs()) + 1e-15;
    let single = |light: &str, wavelength: &str, polarisation: &str| {
        let ask = ["--light", light, "--wavelength", wavelength, "--polarisation", polarisation];
        rows(&sandbox.run2(&["orders"], &[&surface[..], &ask].concat()).stdout)
    };
    let by_wavelength = all(&["--light", "30,0", "--sweep", "wavelength", "450:650:100"]);
    let by_angle = all(&["--wavelength", "550nm", "--sweep", "angle", "-30:30:30"]);
    for (found, light, wavelength) in
        [(&by_wavelength, "30,0", 650), (&by_angle, "30,0", 550), (&by_angle, "30,180", 550)]
    {
        let theta = if light == "30,180" { -30.0 } else { 30.0 };
        let here =
            |row: &&BTreeMap<String, f64>| row["wavelength"] == wavelength as f64 && row["theta_i"] == theta;
        for (polarisation, column) in [("te", "te"), ("tm", "tm"), ("none", "mean")] {
            let expected = single(light, &format!("{wavelength}nm"), polarisation);
            let found: Vec<_> = found.iter().filter(here).collect();
            assert!(found.len() >= 5 && found.len() == expected.len(), "{} {}", found.len(), expected.len());
            for row in found {
                let order = expected[&(wavelength, row["m"] as i64, row["n"] as i64)];
                assert!(close(row[column], order.efficiency), "{column} {row:?} {order:?}");
            }
        }
    }
    // The factor of te and tm differ, and their mean is that of unpolarised light.
    let grazing = &by_wavelength[0];
    assert!((grazing["te"] / grazing["tm"] - 1.0).abs() > 1e-3, "{grazing:?}");
}

#[test]
fn a_sweep_of_heights_follows_bessel_functions_and_names_its_error() {
    let sandbox = Sandbox::new();
    let more =
        ["--light", "0,0", "--wavelength", "600nm", "--sweep", "height", "0:300:100", "--theory", "stam"];
    // 16 samples a period: the highest and the lowest are among them.
    let row: Vec<String> = (0..64).map(|i| format!("{:.12}", (TAU * f64::from(i) / 16.0).sin())).collect();
    let header = "# Channel: Height\n# Width: 8 um\n# Height: 500 nm\n# Value units: nm\n";
    sandbox.write("wave.txt", header.to_owned() + &format!("{}\n", row.join(" ")).repeat(4));
    let (found, said) = swept(&sandbox, &[&["wave.txt", "--plot", "s.svg"], &more[..]].concat());
    assert!(said.contains("4 points; all orders together take"), "{said}");
    let of = |height: f64, m: f64| {
        found.iter().find(|row| row["height"] == height && row["m"] == m && row["n"] == 0.0)
    };
    assert!(of(0.0, 1.0).is_none() && of(0.0, 0.0).is_some(), "{found:?}");
    let flat = of(0.0, 0.0).unwrap()["mean"];
    for height in [100.0, 200.0, 300.0] {
        // |c_0|² = J_0²(2 k a) of a sinusoid of amplitude a.
        let phase = TAU / 600.0 * height;
        let specular = of(height, 0.0).unwrap();
        assert!((specular["mean"] / flat / bessel(0, phase).powi(2) - 1.0).abs() < 1e-6, "{specular:?}");
        let (te, tm, mean) = (specular["te"], specular["tm"], specular["mean"]);
        assert!((0.5 * (te + tm) / mean - 1.0).abs() < 1e-9, "{specular:?}");
        let error = of(height, 1.0).unwrap()["error_mean"];
        assert!(error > 0.0 && error < 0.2, "{error}");
    }
    let svg = String::from_utf8(sandbox.read("s.svg")).unwrap();
    for words in ["Unpolarised, 600 nm", "TE, 600 nm", "TM, 600 nm", "order −1", "efficiency", "height [nm]"]
    {
        assert!(svg.contains(words), "{words}");
    }
}

#[test]
fn a_sweep_takes_the_place_of_one_option_and_refuses_it() {
    let sandbox = Sandbox::new();
    for (arguments, reason) in [
        (
            &["--light", "30,0", "--wavelength", "550nm", "--sweep", "wavelength", "400:700:50"][..],
            "leave --wavelength",
        ),
        (&["--light", "30,0", "--sweep", "angle", "0:60:5"], "add --wavelength"),
        (&["--wavelength", "550nm", "--sweep", "height", "0:60:5"], "add --light"),
        (&["--light", "30,0", "--sweep", "height", "0:60"], "three numbers"),
        (&["--light", "30,0", "--sweep", "colour", "0:60:1"], "no sweep of"),
        (&["--light", "30,0", "--wavelength", "550nm", "--plot", "a.svg"], "--sweep"),
    ] {
        let outcome = sandbox.run2(&["orders", "blaze"], arguments);
        assert!(outcome.code == Some(2) && outcome.stderr.contains(reason), "{arguments:?}: {outcome:?}");
    }
}

#[test]
fn a_share_may_be_written_in_percent() {
    let sandbox = Sandbox::new();
    let least = |share: &str| {
        sandbox.run(["orders", "blaze", "--light", "30,0", "--wavelength", "550nm", "--least", share])
    };
    let [number, percent] = ["0.01", "1%"].map(|share| least(share).stdout);
    assert!(number.lines().count() > 1 && number == percent, "{number}\n{percent}");
    assert!(least("101%").refused(2).contains("percent"));
}

#[test]
fn a_patch_without_a_whole_number_of_periods_says_so_and_not_that_its_edges_do_not_meet() {
    let sandbox = Sandbox::new().without_vulkan();
    // The edges are at one height, and on opposite flanks.
    let at = |i: u32| 50.0 * (TAU * 12.35 * f64::from(i) / 200.0 + TAU * 0.075).sin();
    let row: Vec<String> = (0..200).map(|i| format!("{:.6}", at(i))).collect();
    let header = "# Channel: Height\n# Width: 16 um\n# Height: 1 um\n# Value units: nm\n";
    sandbox.write("wave.txt", header.to_owned() + &format!("{}\n", row.join(" ")).repeat(60));
    let ask = ["orders", "wave.txt", "--light", "0,0", "--wavelength", "550nm", "--least", "1%"];
    let said = sandbox.run(ask).stderr;
    assert!(
        said.contains("the patch holds 12.35 periods along x") && !said.contains("do not meet"),
        "{said}"
    );
}
