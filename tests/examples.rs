//! The programs in `examples/`: what they print and draw, against numbers that are computed here from formulas and tables alone.
//!
//! `cargo test` builds them; before `cargo test --test examples` alone, `cargo build --examples` does.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on has failed")]

use image::{ImageBuffer, Luma};
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The gratings of the examples: h = a sin(2πx/d), a = 0.1 µm, d = 2 µm.
const AMPLITUDE: f64 = 0.1;
const PERIOD: f64 = 2.0;
/// Refractive index of the surfaces.
const IOR: f64 = 1.5;

/// What the example `name` prints when it is given `arguments`.
fn run(name: &str, arguments: &[&Path]) -> String {
    let tests = std::env::current_exe().unwrap();
    let program: PathBuf = tests.ancestors().nth(2).unwrap().join("examples").join(name);
    assert!(program.is_file(), "{} is not built: cargo build --examples", program.display());
    let outcome = Command::new(program).args(arguments).output().unwrap();
    let [stdout, stderr] = [outcome.stdout, outcome.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(outcome.status.success() && stderr.is_empty(), "{name}: {stderr}");
    stdout
}

/// J_m(x) by Bessel's integral, whose trapezoidal sum converges faster than any power.
fn bessel(m: i32, x: f64) -> f64 {
    const STEPS: i32 = 256;
    let term = |i: i32| {
        let t = TAU * f64::from(i) / f64::from(STEPS);
        (f64::from(m) * t - x * t.sin()).cos()
    };
    (0..STEPS).map(term).sum::<f64>() / f64::from(STEPS)
}

/// |B|² of the small-slope approximation for directions of direction cosine `x_i` to the light and `x_r` to the viewer along the grating, in the plane across it.
fn kernel(x_i: f64, x_r: f64) -> f64 {
    let squared = IOR * IOR;
    let [c_i, c_r] = [x_i, x_r].map(|x| (1.0 - x * x).sqrt());
    let [q_i, q_r] = [x_i, x_r].map(|x| (squared - x * x).sqrt());
    // Wave vectors −x_i and x_r point to the same side (1) or to opposite ones.
    let cos = if x_i * x_r > 0.0 { -1.0 } else { 1.0 };
    let ss = (squared - 1.0) * cos / ((c_i + q_i) * (c_r + q_r));
    let pp = (squared - 1.0) * (q_i * q_r * cos - squared * (x_i * x_r).abs())
        / ((squared * c_i + q_i) * (squared * c_r + q_r));
    0.5 * (ss * ss + pp * pp)
}

/// Directional albedo of the sinusoid over the reflectance of a plane, for light of direction cosine `x`.
fn excess(a: f64, x: f64, wavelength: f64) -> f64 {
    let c_i = (1.0 - x * x).sqrt();
    let share = |m: i32| {
        let x_r = -x + f64::from(m) * wavelength / PERIOD;
        if x_r.abs() >= 1.0 {
            return 0.0;
        }
        let c_r = (1.0 - x_r * x_r).sqrt();
        let w = c_i + c_r;
        4.0 * c_i * c_r * kernel(x, x_r) * bessel(m, TAU / wavelength * w * a).powi(2) / (w * w)
    };
    (-8..=8).map(share).sum::<f64>() / kernel(x, -x)
}

/// f cos θ_i \[sr⁻¹\] of the sinusoid of amplitude `a` \[µm\] under a coherence window of standard deviation `sigma` \[µm\], for light
/// 30° from the normal and a viewer `angle` degrees from it on the other side, without a limit of energy: 4 cos² θ_i cos θ_r |B|² Σ_m J_m²(kwa) γ̂(f − m/d)/(λ w)².
fn cosine_weighted(a: f64, sigma: f64, angle: f64, wavelength: f64) -> f64 {
    let (light, view) = (30f64.to_radians(), angle.to_radians());
    let w = light.cos() + view.cos();
    let frequency = (light.sin() - view.sin()) / wavelength;
    let order = |m: i32| {
        let off = frequency - f64::from(m) / PERIOD;
        bessel(m, TAU / wavelength * w * a).powi(2)
            * 4.0
            * PI
            * sigma.powi(2)
            * (-(TAU * sigma * off).powi(2)).exp()
    };
    let power: f64 = (-8..=8).map(order).sum();
    let (x_i, x_r) = (light.sin(), -view.sin());
    4.0 * light.cos().powi(2) * view.cos() * kernel(x_i, x_r) * power / (wavelength * w).powi(2)
}

/// f \[sr⁻¹\] of the sinusoid within the limit of energy; see [`cosine_weighted`].
fn limited(a: f64, sigma: f64, angle: f64, wavelength: f64) -> f64 {
    let free = cosine_weighted(a, sigma, angle, wavelength) / 30f64.to_radians().cos();
    let [of_light, of_view] = [30.0, -angle].map(|angle| excess(a, angle.to_radians().sin(), wavelength));
    free / of_light.max(of_view).max(1.0)
}

#[test]
fn a_brdf_value_of_a_height_image_is_that_of_a_sinusoidal_grating() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scan.png");
    let code = |column: u32| {
        let x = 0.1 * (f64::from(column) + 0.5);
        ((0.5 + 0.5 * (TAU * x / PERIOD).sin()) * f64::from(u16::MAX)).round() as u16
    };
    ImageBuffer::from_fn(200, 8, |column, _| Luma([code(column)])).save(&file).unwrap();
    let printed = run("brdf_value", &[&file]);
    let value: f64 = printed.split(' ').next().unwrap().parse().unwrap();
    let deviation = |amplitude: f64| (value / limited(amplitude, 65.0 / 4.0, 13.0, 0.55) - 1.0).abs();
    // What is printed, and heights in 65 536 steps.
    assert!(deviation(AMPLITUDE) < 1e-4, "{printed}: {:e}", deviation(AMPLITUDE));
    assert!(deviation(1.01 * AMPLITUDE) > 1e-3, "a hundredth of the height has to be seen");
}

/// The values of a table in `assets/spectra` at `wavelength` \[nm\], linear between its rows.
fn tabulated(name: &str, wavelength: f64) -> Vec<f64> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/spectra").join(name);
    let text = std::fs::read_to_string(path).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let next = rows.iter().position(|row| row[0] > wavelength).unwrap();
    let (low, high) = (&rows[next - 1], &rows[next]);
    let share = (wavelength - low[0]) / (high[0] - low[0]);
    low.iter().zip(high).skip(1).map(|(a, b)| a + share * (b - a)).collect()
}

#[test]
fn a_colour_table_has_the_colours_of_a_sinusoidal_grating_within_its_tolerance() {
    let printed = run("color_table", &[]);
    let wavelengths: Vec<f64> = (0..400).map(|i| 380.5 + f64::from(i)).collect();
    let light: Vec<f64> = wavelengths.iter().map(|&l| tabulated("d65.csv", l)[0]).collect();
    let observer: Vec<Vec<f64>> = wavelengths.iter().map(|&l| tabulated("cie-1931-2deg.csv", l)).collect();
    let white: f64 = light.iter().zip(&observer).map(|(s, xyz)| s * xyz[1]).sum();
    /// Largest limit of energy anywhere on this surface. The table reads it between directions, so that it may act on a direction whose own light has no excess.
    const LIMIT: f64 = 1.03;
    let deviation = |amplitude: f64| {
        let (mut error, mut norm) = (0.0, 0.0);
        for line in printed.lines().skip(1) {
            let (angle, colour) = line.split_once(" degrees: ").unwrap();
            let colour: Vec<f64> = colour.split(' ').map(|number| number.parse().unwrap()).collect();
            let angle: f64 = angle.parse().unwrap();
            let brdf = |l: &f64| cosine_weighted(amplitude, 5.0, angle, l * 1e-3) / 30f64.to_radians().cos();
            let response: Vec<f64> = wavelengths.iter().map(brdf).collect();
            let free = [0, 1, 2].map(|channel| {
                let part = |i: usize| light[i] * observer[i][channel] * response[i] / white;
                (0..wavelengths.len()).map(part).sum::<f64>()
            });
            let scale = colour.iter().zip(free).map(|(value, free)| value * free).sum::<f64>()
                / free.iter().map(|free| free * free).sum::<f64>();
            let scale = scale.clamp(1.0 / LIMIT, 1.0);
            for (value, free) in colour.iter().zip(free) {
                error += (value - scale * free).powi(2);
                norm += free.powi(2);
            }
        }
        (error / norm).sqrt()
    };
    assert_eq!(printed.lines().count(), 6, "{printed}");
    assert!(deviation(AMPLITUDE) < 1e-2, "{printed}: {:e}", deviation(AMPLITUDE));
    assert!(deviation(1.05 * AMPLITUDE) > 1e-2, "a twentieth of the height has to be seen");
}

#[test]
fn a_surface_of_one_s_own_sends_each_wavelength_where_the_grating_equation_says() {
    let printed = run("surface", &[]);
    let lines: Vec<&str> = printed.lines().collect();
    for (line, wavelength) in lines.iter().zip([0.65, 0.55, 0.45]) {
        let angle: f64 = line.split(' ').nth_back(1).unwrap().parse().unwrap();
        // Order (1, 1) of the square lattice: |(u, v)| = √2 λ/d.
        let expected = (2f64.sqrt() * wavelength / 1.5f64).asin().to_degrees();
        assert!((angle - expected).abs() < 0.02, "{line}: {expected:.3} expected");
    }
    // 25°, 31° and 37° are the directions of blue, green and red.
    let strongest = lines[3..].iter().map(|line| {
        let code = line.split('#').nth(1).unwrap();
        let channel = |i: usize| u8::from_str_radix(&code[2 * i..2 * i + 2], 16).unwrap();
        (0..3).max_by_key(|&i| channel(i)).unwrap()
    });
    assert_eq!(strongest.collect::<Vec<_>>(), [2, 1, 0], "{printed}");
}

#[cfg(feature = "vulkan")]
#[test]
fn work_tells_how_far_it_is_and_ends_when_it_is_cancelled() {
    let whole = run("progress", &[]);
    let told = whole.lines().filter(|line| line.starts_with("orders: ")).count();
    assert!(told > 10 && whole.lines().last().unwrap().starts_with("a table of "), "{whole}");
    let cancelled = run("progress", &[Path::new("0")]);
    assert_eq!(cancelled.lines().last(), Some("cancelled"), "{cancelled}");
    assert!(cancelled.lines().count() < told);
}

#[test]
fn a_picture_is_the_one_that_the_program_draws() {
    let folder = tempfile::tempdir().unwrap();
    let [by_example, by_program] = ["example.png", "program.png"].map(|name| folder.path().join(name));
    run("picture", &[&by_example]);
    let words = ["render", "--size", "320x240", "--tolerance", "5e-2", "--quiet", "-o"];
    let program = Command::new(env!("CARGO_BIN_EXE_diffract")).args(words).arg(&by_program).status();
    assert!(program.unwrap().success());
    let [drawn, expected] = [by_example, by_program].map(|path| image::open(path).unwrap().to_rgb8());
    assert!(drawn == expected);
    let coloured =
        |pixel: &&image::Rgb<u8>| pixel.0.iter().max().unwrap() - pixel.0.iter().min().unwrap() > 40;
    let share = drawn.pixels().filter(coloured).count() as f64 / f64::from(320 * 240);
    assert!(share > 0.05, "the snake shines in colours: {share}");
    let [corner, middle] = [[2, 2], [150, 150]].map(|[x, y]| drawn.get_pixel(x, y).0);
    assert!(corner != middle, "the snake stands before a background");
}

#[cfg(feature = "vulkan")]
#[test]
fn the_error_of_a_picture_is_that_of_the_pixels_that_the_exact_one_covers() {
    let folder = tempfile::tempdir().unwrap();
    let [picture, exact] = ["picture.exr", "exact.exr"].map(|name| folder.path().join(name));
    let write = |path: &Path, left: [f32; 4], right: [f32; 4]| {
        ImageBuffer::from_fn(2, 1, |x, _| image::Rgba(if x == 0 { left } else { right })).save(path).unwrap();
    };
    write(&picture, [1.0, 2.0, 2.3, 1.0], [5.0, 6.0, 7.0, 1.0]);
    // The right pixel is not one of those that were computed.
    write(&exact, [1.0, 2.0, 2.0, 1.0], [0.0; 4]);
    // ‖(0, 0, 0.3)‖/‖(1, 2, 2)‖.
    assert_eq!(run("picture_error", &[&picture, &exact]), "1 pixels: relative L2 0.1000 ± 0.0000\n");
    write(&exact, [1.0, 2.0, 2.0, 1.0], [5.0, 6.0, 8.0, 1.0]);
    // ‖(0, 0, 0.3, 0, 0, −1)‖/‖(1, 2, 2, 5, 6, 8)‖ = √(1.09/134).
    assert!(run("picture_error", &[&picture, &exact]).starts_with("2 pixels: relative L2 0.0902"));
}

#[test]
fn the_readme_has_the_text_of_the_shortest_example() {
    let [readme, example] = [include_str!("../README.md"), include_str!("../examples/brdf_value.rs")];
    let program = &example[example.find("use diffract").unwrap()..];
    assert!(readme.contains(&format!("```rust\n{program}```\n")), "copy it there:\n{program}");
}
