//! Maps of the hemisphere.

use crate::maps::fresnel;
use crate::sandbox::Sandbox;

/// Pixels on a side of the maps here.
const SIDE: usize = 64;
/// A window that makes spots a few pixels wide.
const WINDOW: [&str; 4] = ["--coherence", "gaussian:8um", "--size", "64x64"];

type Map = Vec<[f32; 4]>;

/// The EXR map of a run that has to succeed in silence.
#[track_caller]
fn map(sandbox: &Sandbox, surface: &str, light: &str, more: &[&str]) -> Map {
    map_by(sandbox, surface, light, &[&WINDOW[..], more].concat())
}

/// The same by all of these words.
#[track_caller]
fn map_by(sandbox: &Sandbox, surface: &str, light: &str, words: &[&str]) -> Map {
    let arguments = ["brdf", surface, "-o", "m.exr", "--light", light];
    assert_eq!(sandbox.run2(&arguments, words).done(), "");
    match image::open(sandbox.path("m.exr")).unwrap() {
        image::DynamicImage::ImageRgba32F(p) if p.width() == p.height() => p.pixels().map(|p| p.0).collect(),
        other => panic!("{:?} {}x{}", other.color(), other.width(), other.height()),
    }
}

/// s_x, s_y of a pixel, as the contract has it.
fn place(index: usize) -> [f64; 2] {
    let (i, j) = ((index % SIDE) as f64, (index / SIDE) as f64);
    let n = SIDE as f64;
    [2.0 * (i + 0.5) / n - 1.0, 1.0 - 2.0 * (j + 0.5) / n]
}

/// Where the brightest pixel among those that `keep` takes stands.
fn brightest(map: &Map, keep: impl Fn([f64; 2]) -> bool) -> [f64; 2] {
    let green = |i: &usize| map[*i][1];
    let inside = (0..map.len()).filter(|&i| keep(place(i)));
    place(inside.max_by(|a, b| green(a).total_cmp(&green(b))).unwrap())
}

/// Whether `at` is within one and a half pixels of `expected`.
fn stands(at: [f64; 2], expected: [f64; 2]) -> bool {
    (at[0] - expected[0]).hypot(at[1] - expected[1]) < 3.0 / SIDE as f64
}

/// ‖a − b‖/‖b‖ over all colours; alpha, equal by the contract, would only dilute it.
fn deviation(a: &Map, b: &Map) -> f64 {
    let colours = |map: &Map| map.iter().flat_map(|p| [p[0], p[1], p[2]]).collect::<Vec<f32>>();
    let (a, b) = (colours(a), colours(b));
    let pairs = || a.iter().zip(&b);
    let square = |x: f32| f64::from(x).powi(2);
    (pairs().map(|(a, b)| square(a - b)).sum::<f64>() / pairs().map(|(_, b)| square(*b)).sum::<f64>()).sqrt()
}

#[test]
fn a_mirrors_spot_stands_opposite_the_light() {
    let sandbox = Sandbox::new();
    for (light, tangential) in [
        ("30,0", [0.5, 0.0]),
        ("30,90", [0.0, 0.5]),
        (
            "45,200",
            [
                45f64.to_radians().sin() * 200f64.to_radians().cos(),
                45f64.to_radians().sin() * 200f64.to_radians().sin(),
            ],
        ),
    ] {
        let spot = brightest(&map(&sandbox, "flat", light, &["--wavelength", "550nm"]), |_| true);
        assert!(stands(spot, tangential.map(|s| -s)), "{light}: {spot:?}");
        assert!(!stands(spot, tangential), "{light}: the check takes the light's own side");
    }
}

#[test]
fn a_blazes_orders_stand_along_x_and_its_brightest_leans_to_minus_x() {
    let sandbox = Sandbox::new();
    // Wavelength over period is 0.22; a facet's mirror direction lies at about s_x = -0.2.
    let map = map(&sandbox, "blaze", "0,0", &["--wavelength", "550nm"]);
    assert!(stands(brightest(&map, |_| true), [-0.22, 0.0]));
    for order in [-2.0f64, -1.0, 0.0, 1.0] {
        let x = 0.22 * order;
        let spot = brightest(&map, |[s_x, s_y]| (s_x - x).abs() < 0.11 && s_y.abs() < 0.9);
        assert!(stands(spot, [x, 0.0]), "order at {x}: {spot:?}");
    }
}

#[test]
fn outside_the_disc_everything_is_0_and_inside_alpha_is_1() {
    let sandbox = Sandbox::new();
    let colour = map(&sandbox, "blaze", "30,0", &[]);
    for (index, pixel) in colour.iter().enumerate() {
        let [x, y] = place(index);
        if x * x + y * y < 1.0 {
            assert!(pixel[3] == 1.0 && pixel.iter().all(|c| c.is_finite()), "{x} {y}: {pixel:?}");
        } else {
            assert_eq!(*pixel, [0.0; 4], "{x} {y}");
        }
    }
    assert!(colour.iter().any(|p| p[..3].iter().any(|&c| c < 0.0)), "no colour lies outside sRGB");
    let grey = map(&sandbox, "blaze", "30,0", &["--wavelength", "550nm"]);
    assert!(grey.iter().all(|p| p[0] == p[1] && p[1] == p[2]));
}

/// Answers of `eval` on blaze to `directions` (s_x, s_y), light from 30°, at 550 nm.
fn answers(sandbox: &Sandbox, directions: &[[f64; 2]], more: &[&str]) -> Vec<f64> {
    let row = |[x, y]: &[f64; 2]| {
        let (theta, phi) = (x.hypot(*y).asin().to_degrees(), y.atan2(*x).to_degrees());
        format!("30,0,{theta},{phi},550\n")
    };
    let rows: String = directions.iter().map(row).collect();
    sandbox.write("q.csv", format!("theta_i,phi_i,theta_r,phi_r,wavelength\n{rows}"));
    let csv = sandbox.run2(&["eval", "blaze", "--queries", "q.csv"], more).done();
    csv.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect()
}

#[test]
fn a_pixel_is_the_average_of_what_eval_says_of_its_directions() {
    let sandbox = Sandbox::new();
    let pixel = 2.0 / SIDE as f64;
    // On three orders.
    for index in [31 * SIDE + 8, 31 * SIDE + 15, 32 * SIDE + 23] {
        let [x, y] = place(index);
        for (more, gaussian) in [(&["--method", "reference"][..], true), (&["--windows", "1x1"], false)] {
            // A Gaussian of half a pixel, to six standard deviations, or the pixel.
            let (parts, last) = if gaussian { (8.0, 24) } else { (33.0, 16) };
            let offset = |i: i32| f64::from(i) / parts * pixel;
            let weight = |i: i32| if gaussian { (-2.0 * (f64::from(i) / parts).powi(2)).exp() } else { 1.0 };
            let places = || (-last..=last).flat_map(|j| (-last..=last).map(move |i| (i, j)));
            let directions: Vec<_> = places().map(|(i, j)| [x + offset(i), y + offset(j)]).collect();
            let coherence = [more, &["--coherence", "gaussian:24um"]].concat();
            let found = answers(&sandbox, &directions, &coherence);
            let (mut sum, mut norm) = (0.0, 0.0);
            for ((i, j), f) in places().zip(found) {
                sum += weight(i) * weight(j) * f;
                norm += weight(i) * weight(j);
            }
            let words = [&["--size", "64x64", "--wavelength", "550nm"], &coherence[..]].concat();
            let grey = map_by(&sandbox, "blaze", "30,0", &words);
            // The factor is that of the middle of the pixel, half a pixel from an order.
            let off = f64::from(grey[index][0]) / (sum / norm) - 1.0;
            assert!(off.abs() < 4e-2, "{more:?} {index}: {} for {}", grey[index][0], sum / norm);
        }
    }
}

#[test]
fn a_table_averages_over_a_pixel_as_the_reference_of_the_mean_does() {
    let sandbox = Sandbox::new();
    // Orders of blue light are a seventh of a pixel wide.
    let ask = |method: &str| {
        let words =
            ["--size", "32x32", "--coherence", "gaussian:24um", "--method", method, "--tolerance", "1e-2"];
        map_by(&sandbox, "blaze", "30,0", &words)
    };
    let (table, reference) = (ask("table"), ask("reference"));
    let apart = deviation(&table, &reference);
    // One sample of few orders through the taps of a footprint errs by as much.
    assert!(apart < 5e-2, "{apart}");
    assert!(energy(&reference, |_| true) > 1e-2, "there is something to see");
}

#[test]
fn heights_that_no_series_follows_have_a_map_and_a_figure_by_direct_sums() {
    let sandbox = Sandbox::new();
    let rows: String = (0..8)
        .map(|j| (0..8).map(|i| format!("{} ", (i * 5 + j * 3) % 8 * 100)).collect::<String>() + "\n")
        .collect();
    sandbox.write("high.txt", rows);
    let words = "brdf high.txt --pixel-size 100nm --height 400um --method reference --theory stam --wavelength 550nm --light 30,0 \
                 --size 6x6 --plot high.svg";
    let outcome = sandbox.run(words.split_whitespace());
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
}

#[test]
fn the_albedo_of_a_map_is_the_sum_over_the_orders_at_any_size() {
    let sandbox = Sandbox::new();
    let outcome =
        sandbox.run(["orders", "blaze", "--light", "30,0", "--wavelength", "550nm", "--least", "0"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let orders = outcome.stdout;
    let efficiency = |line: &str| line.split(',').nth(5).unwrap().parse::<f64>().unwrap();
    let sum: f64 = orders.lines().skip(1).map(efficiency).sum();
    let ask = |more: &[&str]| {
        let start = ["brdf", "blaze", "--light", "30,0", "--wavelength", "550nm", "--plot", "m.svg"];
        sandbox.run2(&start, more).done();
        let figure = String::from_utf8(sandbox.read("m.svg")).unwrap();
        let words = figure.split("Albedo").nth(1).unwrap();
        let number = words.split(|c: char| !c.is_ascii_digit() && c != '.').find(|w| w.starts_with("0."));
        number.unwrap().trim_end_matches('.').parse::<f64>().unwrap()
    };
    for size in ["20x20", "64x64", "100x100"] {
        assert!(
            (ask(&["--size", size]) / sum - 1.0).abs() < 2e-3,
            "{size}: {} for {sum}",
            ask(&["--size", size])
        );
    }
    // Orders of a millimetre are far narrower than a pixel, whose values add up to the same but for those at the rim.
    let words = ["--size", "64x64", "--wavelength", "550nm", "--coherence", "gaussian:1mm"];
    let narrow = map_by(&sandbox, "blaze", "30,0", &words);
    let whole = energy(&narrow, |_| true);
    assert!((whole / sum - 1.0).abs() < 3e-2, "{whole} for {sum}");
}

#[test]
fn csv_and_npy_hold_the_numbers_of_the_exr() {
    let sandbox = Sandbox::new();
    for (more, names) in [(&[][..], "r,g,b"), (&["--wavelength", "550nm"], "brdf")] {
        let exr = map(&sandbox, "blaze", "30,40", more);
        let channels = names.split(',').count();
        for name in ["m.csv", "m.npy"] {
            let arguments = ["brdf", "blaze", "-o", name, "--light", "30,40"];
            assert_eq!(sandbox.run2(&arguments, &[&WINDOW[..], more].concat()).done(), "");
        }
        let csv = String::from_utf8(sandbox.read("m.csv")).unwrap();
        let mut lines = csv.lines();
        assert_eq!(lines.next().unwrap(), format!("x,y,theta_r,phi_r,{names}"));
        let inside: Vec<usize> = (0..exr.len()).filter(|&i| exr[i][3] > 0.0).collect();
        let rows: Vec<Vec<f64>> =
            lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
        assert_eq!(rows.len(), inside.len());
        for (row, &index) in rows.iter().zip(&inside) {
            assert_eq!(row[..2], place(index));
            let toward = diffract::internals::optics::geometry::direction(row[2], row[3]);
            assert!((toward.x - row[0]).hypot(toward.y - row[1]) < 1e-12);
            let values: Vec<f32> = row[4..].iter().map(|x| *x as f32).collect();
            assert_eq!(values, exr[index][..channels]);
        }
        let npy = sandbox.read("m.npy");
        let begin = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
        let header = std::str::from_utf8(&npy[10..begin]).unwrap();
        let shape = if channels == 3 { "(64, 64, 3)" } else { "(64, 64)" };
        let expected = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
        assert!(npy.starts_with(b"\x93NUMPY\x01\x00") && begin % 64 == 0 && header.ends_with('\n'));
        assert_eq!(header.trim_end(), expected);
        let values: Vec<f32> =
            npy[begin..].as_chunks().0.iter().map(|four| f32::from_le_bytes(*four)).collect();
        assert_eq!(values.len(), exr.len() * channels);
        for (pixel, values) in exr.iter().zip(values.chunks(channels)) {
            if pixel[3] > 0.0 {
                assert_eq!(values, &pixel[..channels]);
            } else {
                assert!(values.iter().all(|x| x.is_nan()));
            }
        }
    }
    let line = sandbox.run(["brdf", "blaze", "--light", "30,0", "-o", "m.txt"]).refused(2);
    assert!(line.contains(".csv or .npy"), "{line}");
}

#[test]
fn spectral_agrees_with_the_reference_and_another_wavelength_does_not() {
    let sandbox = Sandbox::new();
    let ask = |more: &[&str]| map(&sandbox, "blaze", "30,40", more);
    let reference = ask(&["--wavelength", "550nm", "--method", "reference"]);
    assert!(deviation(&ask(&["--wavelength", "550nm"]), &reference) < 1e-2);
    assert!(deviation(&ask(&["--wavelength", "560nm"]), &reference) > 1e-2);
}

#[test]
fn several_lights_are_summed_with_their_intensities() {
    let sandbox = Sandbox::new();
    let ask = |light: &str, more: &[&str]| map(&sandbox, "blaze", light, more);
    let (one, other) = (ask("30,0", &[]), ask("50,120", &[]));
    let both = ask("30,0", &["--light", "50,120,2"]);
    let sum = |weight: f32| -> Map {
        let cell = |a: &[f32; 4], b: &[f32; 4]| {
            [0, 1, 2, 3].map(|c| if c == 3 { a[c] } else { a[c] + weight * b[c] })
        };
        one.iter().zip(&other).map(|(a, b)| cell(a, b)).collect()
    };
    assert!(deviation(&both, &sum(2.0)) < 1e-5);
    assert!(deviation(&both, &sum(1.0)) > 1e-2);
}

#[test]
fn a_png_is_the_exr_as_displayed_at_the_exposure() {
    let sandbox = Sandbox::new();
    let linear = map(&sandbox, "blaze", "30,0", &[]);
    let arguments = ["brdf", "blaze", "--light", "30,0", "-o", "m.png", "--exposure", "-3"];
    sandbox.run2(&arguments, &WINDOW).done();
    let shown = image::open(sandbox.path("m.png")).unwrap().to_rgb8();
    for (pixel, linear) in shown.pixels().zip(&linear) {
        let [r, g, b, _] = linear.map(f64::from);
        assert_eq!(pixel.0, diffract::internals::optics::color::display(glam::DVec3::new(r, g, b), -3.0));
    }
    assert!(shown.pixels().any(|p| p.0 != [0; 3] && p.0 != [255; 3]));
}

#[test]
fn a_map_has_to_be_square_and_of_a_known_format() {
    let sandbox = Sandbox::new();
    for more in
        [&["-o", "m.png", "--size", "64x32"][..], &["-o", "m.gif"], &["-o", "m.png", "--size", "16385x16385"]]
    {
        sandbox.run2(&["brdf", "flat", "--light", "30,0"], more).refused(2);
    }
}

/// ∫ f cos θ_r dω_r over the pixels of a map that `keep` takes: cos θ dω is the area on the disc of direction cosines.
fn energy(map: &Map, keep: impl Fn([f64; 2]) -> bool) -> f64 {
    let kept = map.iter().enumerate().filter(|(index, _)| keep(place(*index)));
    // A map is a square of 2 by 2.
    kept.map(|(_, p)| f64::from(p[0])).sum::<f64>() * 4.0 / map.len() as f64
}

#[test]
fn the_energy_of_a_map_is_that_of_the_closed_forms() {
    let sandbox = Sandbox::new();
    let ask = |surface: &str| map(&sandbox, surface, "0,0", &["--wavelength", "550nm", "--theory", "stam"]);
    // The reflectance at normal incidence; over the mirror's spot, 0.04 wide, G/w² and R hardly change.
    let flat = energy(&ask("flat"), |_| true);
    assert!((flat / 0.04 - 1.0).abs() < 5e-3, "{flat}");
    // The orders of a sinusoid of d = 2 µm: R G/w² J_m²(k|w|a), with u = mλ/d.
    let spacing = 0.55 / 2.0;
    let closed = |m: i32, amplitude: f64| {
        let u = f64::from(m) * spacing;
        let cos = (1.0 - u * u).sqrt();
        let w = 1.0 + cos;
        // (1 + ω_i·ω_r)²/(cos θ_i cos θ_r w²) is 1/cos θ_r at normal incidence; cos θ_h = |(u,v,w)|/2.
        let reflectance = fresnel((u * u + w * w).sqrt() / 2.0);
        reflectance / cos * bessel(m, std::f64::consts::TAU / 0.55 * w * amplitude).powi(2)
    };
    let sinusoid = ask("sinusoid");
    let deviation = |amplitude: f64| {
        let order = |m: i32| {
            let near = |[s_x, _]: [f64; 2]| (s_x + f64::from(m) * spacing).abs() < spacing / 2.0;
            (energy(&sinusoid, near) - closed(m, amplitude)).abs() / 0.04
        };
        (-3..=3).map(order).fold(0.0, f64::max)
    };
    assert!(deviation(0.1) < 5e-3, "{}", deviation(0.1));
    assert!(deviation(0.103) > 1e-2, "an amplitude three hundredths off: {}", deviation(0.103));
}

/// J_m(x) = ∫ cos(mτ − x sin τ) dτ/2π, by the trapezoid rule, which is exact for a periodic function this smooth.
fn bessel(m: i32, x: f64) -> f64 {
    let term = |i: i32| {
        let t = f64::from(i) * std::f64::consts::TAU / 64.0;
        (f64::from(m) * t - x * t.sin()).cos()
    };
    (0..64).map(term).sum::<f64>() / 64.0
}

#[test]
fn a_figure_says_angles_scale_and_settings_and_is_drawn_beside_the_map() {
    let sandbox = Sandbox::new();
    let ask = |more: &[&str]| {
        let start = ["brdf", "blaze", "--light", "30,0", "--light", "50,120,2", "--plot", "m.svg"];
        assert_eq!(sandbox.run2(&start, &[&WINDOW[..], more].concat()).done(), "");
        String::from_utf8(sandbox.read("m.svg")).unwrap()
    };
    let one = ask(&["--wavelength", "550nm", "-o", "m.exr"]);
    for words in [
        "BRDF [sr⁻¹]",
        "550 nm",
        "60°",
        "330°",
        "sin θ = 0.2",
        "gaussian 8 µm",
        "intensity 2",
        "blaze",
        "Albedo",
    ] {
        assert!(one.contains(words), "{words}");
    }
    assert!(sandbox.path("m.exr").exists(), "the map itself is written, too");
    let colour = ask(&["--exposure", "1"]);
    assert!(colour.contains("Colour at +1 EV") && colour.contains("luminance"), "colour and its values");
    assert_eq!(colour.matches("<image").count(), 3, "two maps and a colour bar");
}

#[test]
fn compare_tells_methods_apart_from_equal_ones() {
    let sandbox = Sandbox::new();
    let deviation = |pair: &str| -> f64 {
        let start = ["brdf", "blaze", "--light", "30,0", "--wavelength", "550nm", "--plot", "m.svg"];
        // Bases are of one window.
        let more = ["--compare", pair, "--windows", "1x1", "--coherence", "gaussian:8um", "--size", "16x16"];
        let outcome = sandbox.run2(&start, &more);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let line = outcome.stderr.lines().last().unwrap_or_default().to_owned();
        line.rsplit(' ').next().unwrap().parse().unwrap()
    };
    assert_eq!(deviation("spectral,spectral"), 0.0);
    assert!((1e-9..1e-2).contains(&deviation("spectral,optimal")));
    assert!((1e-9..1e-2).contains(&deviation("spectral,reference")));
    assert!(deviation("gaussian:8um,gaussian:9um") > 1e-2);
    let alone = ["brdf", "flat", "--light", "30,0", "-o", "m.png", "--compare", "spectral,reference"];
    sandbox.run(alone).refused(2);
    sandbox.run(["brdf", "flat", "--light", "30,0"]).refused(2);
}

#[test]
fn repeats_agree_with_the_reference_and_another_number_of_copies_does_not() {
    let sandbox = Sandbox::new();
    let ask = |copies: &str, more: &[&str]| -> Map {
        let start =
            ["brdf", "bumps", "--light", "30,0", "-o", "m.exr", "--size", "48x48", "--coherence", copies];
        let own = ["--pixel-size", "180nm", "--wavelength", "760nm"];
        let outcome = sandbox.run2(&start, &[&own[..], more].concat());
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let picture = image::open(sandbox.path("m.exr")).unwrap().to_rgba32f();
        picture.pixels().map(|p| p.0).collect()
    };
    let reference = ask("repeats:2x1", &["--method", "reference"]);
    assert!(reference.iter().any(|p| p[0] > 0.1), "there is something to see");
    assert!(deviation(&ask("repeats:2x1", &[]), &reference) < 1e-2);
    // Orders of more copies are narrower, and a pixel sees the whole of each: maps differ by their edges alone.
    assert!(deviation(&ask("repeats:1x1", &[]), &reference) > 3e-2);
}
