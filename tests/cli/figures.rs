//! Figures in the styles of papers and slides.

use crate::sandbox::{SMALL, Sandbox};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use std::io::Cursor;

/// A figure of heights, which takes no device.
fn page(sandbox: &Sandbox, plot: &str, style: &[&str]) {
    sandbox.run2(&["surface", "info", "--plot", plot], &[&SMALL[1..6], style].concat()).done();
}

/// Returns the width of a PNG in pixels and in millimetres, as it says.
fn width(sandbox: &Sandbox, name: &str) -> (u32, f64) {
    let reader = png::Decoder::new(Cursor::new(sandbox.read(name))).read_info().unwrap();
    let (pixels, per_metre) = (reader.info().width, reader.info().pixel_dims.unwrap().xppu);
    (pixels, f64::from(pixels) / f64::from(per_metre) * 1e3)
}

#[test]
fn a_figure_has_the_width_the_letters_and_the_panels_that_are_asked_for() {
    let sandbox = Sandbox::with_small_surface();
    let style = ["--width", "85mm", "--font-size", "7pt", "--panels", "profiles,heights", "--no-caption"];
    page(&sandbox, "column.svg", &style);
    let svg = String::from_utf8(sandbox.read("column.svg")).unwrap();
    assert!(svg.contains("width=\"85.000mm\""), "{}", &svg[..200]);
    // Letters of 12 in lengths of which 12 are 7 pt.
    let inner: f64 = svg.split("viewBox=\"0 0 ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((12.0 * 85.0 / inner - 7.0 * 25.4 / 72.0).abs() < 1e-3, "{inner}");
    let place = |word: &str| svg.find(word);
    assert!(place("Profiles") < place(">Heights<") && place(">Heights<").is_some());
    assert!(place("Power spectrum").is_none() && place("Scalar theory").is_none() && place("Sdq").is_none());
    page(&sandbox, "column.png", &[&style[..], &["--dpi", "300"]].concat());
    let (pixels, millimetres) = width(&sandbox, "column.png");
    assert!(pixels == 1004 && (millimetres - 85.0).abs() < 0.1, "{pixels}, {millimetres}");
    page(&sandbox, "screen.png", &["--width", "800px", "--panels", "heights"]);
    assert_eq!(width(&sandbox, "screen.png").0, 800);
}

#[test]
fn a_dark_figure_is_dark_and_a_light_one_white() {
    let sandbox = Sandbox::with_small_surface();
    for (theme, ground) in [("light", [255; 3]), ("dark", [0x1b, 0x1e, 0x22])] {
        page(&sandbox, "page.png", &["--theme", theme, "--panels", "heights", "--width", "85mm"]);
        let picture = image::load_from_memory(&sandbox.read("page.png")).unwrap().to_rgb8();
        assert_eq!(picture.get_pixel(2, 2).0, ground, "{theme}");
    }
}

#[test]
fn a_style_without_a_figure_and_panels_that_are_not_there_are_refused() {
    let sandbox = Sandbox::with_small_surface();
    let info = |more: &[&str]| sandbox.run2(&["surface", "info"], &[&SMALL[1..6], more].concat()).refused(2);
    assert!(info(&["--width", "85mm"]).contains("add --plot"));
    let line = info(&["--plot", "a.svg", "--panels", "heights,widths"]);
    assert!(line.contains("no panel `widths`") && line.contains("slope-distribution"), "{line}");
    assert!(info(&["--plot", "a.svg", "--width", "20mm", "--font-size", "30pt"]).contains("no room"));
    for bad in [["--width", "85"], ["--font-size", "7"], ["--dpi", "0"], ["--theme", "grey"]] {
        sandbox.run2(&["surface", "info", "--plot", "a.svg"], &[&SMALL[1..6], &bad].concat()).refused(2);
    }
}

#[test]
fn a_hemisphere_is_full_to_its_rim() {
    let sandbox = Sandbox::with_small_surface();
    let map =
        ["brdf", "--light", "30,0", "--wavelength", "550nm", "--size", "16x16", "--method", "reference"];
    sandbox.run2(&[&map[..], &["--plot", "map.svg"]].concat(), &SMALL[1..]).done();
    let svg = String::from_utf8(sandbox.read("map.svg")).unwrap();
    assert!(svg.contains("<clipPath id=\"c0\"><circle"), "the circle cuts the pixels");
    let encoded = svg.split("base64,").nth(1).unwrap().split('"').next().unwrap();
    let picture = image::load_from_memory(&BASE64_STANDARD.decode(encoded).unwrap()).unwrap().to_rgba8();
    // Distance from the middle to the nearest point of a pixel, in pixels.
    let nearest = |x: u32, y: u32| {
        let [x, y] = [x, y].map(|i| ((f64::from(i) - 7.5).abs() - 0.5).max(0.0));
        x.hypot(y)
    };
    let inside = picture.enumerate_pixels().filter(|(x, y, _)| nearest(*x, *y) < 8.0);
    assert!(inside.into_iter().all(|(.., pixel)| pixel.0[3] == 255));
}
