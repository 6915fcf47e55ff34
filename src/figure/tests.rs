use super::*;

fn decoded(png: &[u8]) -> image::RgbImage {
    image::load_from_memory(png).unwrap().to_rgb8()
}

fn heights(map: ColorMap, largest: f64) -> ColorScale {
    ColorScale { axis: Axis::linear("height [nm]", 0.0, largest), map }
}

fn colors() -> Raster {
    Raster::values(2, &[0.0, 1.0, 2.0, 3.0], heights(ColorMap::Magma, 3.0))
}

#[test]
fn a_figure_holds_its_words_and_hostile_ones_are_still_xml() {
    let panel = Panel::new(Axis::linear("a<b & \"c\"", 0.0, 1.0), Axis::log("y", 1.0, 10.0))
        .titled("panel")
        .named("<script>", Mark::line(vec![[0.0, 1.0], [f64::NAN, 2.0], [1.0, 0.0]], palette::BLUE))
        .mark(Mark::note([0.5, 3.0], "note\u{0}"));
    let figure = Figure::new("title").row(vec![panel]).caption("caption & more");
    let svg = figure.svg(&FigureStyle::default(), &Notes::default()).unwrap();
    for word in ["title", "panel", "&lt;script&gt;", "a&lt;b &amp; &quot;c&quot;", "caption &amp; more"] {
        assert!(svg.contains(word), "{word}");
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert!(!figure.png(&FigureStyle::default(), &Notes::default()).unwrap().is_empty());
}

#[test]
fn a_raster_fills_its_panel_with_the_first_row_at_the_top() {
    let panel = Panel::new(Axis::linear("", 0.0, 2.0), Axis::linear("", 0.0, 2.0)).over(colors());
    let picture =
        decoded(&Figure::new("").row(vec![panel]).png(&FigureStyle::default(), &Notes::default()).unwrap());
    let [lowest, highest] = [ColorMap::Magma.at(0.0), ColorMap::Magma.at(1.0)];
    let place = |color: Color| {
        let at: Vec<_> = picture.enumerate_pixels().filter(|(.., p)| p.0 == color.0).collect();
        let n = at.len() as f64;
        let sum = at.iter().fold((0.0, 0.0), |s, (x, y, _)| (s.0 + f64::from(*x), s.1 + f64::from(*y)));
        (at.len(), sum.0 / n, sum.1 / n)
    };
    let (first, last) = (place(lowest), place(highest));
    assert!(first.0 > 10_000 && last.0 > 10_000, "{first:?} {last:?}");
    assert!(first.1 < last.1 && first.2 < last.2, "first left above, last right below: {first:?} {last:?}");
}

#[test]
fn marks_stand_where_their_axes_say() {
    let dot =
        |at: [f64; 2], color| Mark::Points { points: vec![at], color, shape: MarkShape::Disc, radius: 6.0 };
    let panel = Panel::new(Axis::linear("", 0.0, 1.0), Axis::log("", 1.0, 100.0))
        .mark(dot([0.25, 10.0], palette::BLUE))
        .mark(dot([0.75, 31.622_776], palette::GREEN))
        .mark(dot([2.0, 10.0], palette::VERMILION));
    let picture =
        decoded(&Figure::new("").row(vec![panel]).png(&FigureStyle::default(), &Notes::default()).unwrap());
    let centre = |color: Color| {
        let at: Vec<_> = picture.enumerate_pixels().filter(|(.., p)| p.0 == color.0).collect();
        let n = at.len() as f64;
        let sum = at.iter().fold([0.0, 0.0], |s, (x, y, _)| [s[0] + f64::from(*x), s[1] + f64::from(*y)]);
        (at.len(), [sum[0] / n, sum[1] / n])
    };
    let (blue, green) = (centre(palette::BLUE), centre(palette::GREEN));
    assert!(blue.0 > 100 && green.0 > 100);
    // The pixels of the frame mark the box.
    let ink: Vec<_> = picture.enumerate_pixels().filter(|(.., p)| p.0 == INK.0).collect();
    let (left, right) = (ink.iter().map(|p| p.0).min().unwrap(), ink.iter().map(|p| p.0).max().unwrap());
    let width = f64::from(right - left);
    assert!(((green.1[0] - blue.1[0]) / width - 0.5).abs() < 0.02, "half the width apart");
    assert!(green.1[1] < blue.1[1], "a larger y is higher");
    assert_eq!(centre(palette::VERMILION).0, 0, "what is outside is not drawn");
}

#[test]
fn the_hemisphere_has_its_angles_and_a_scale() {
    let panel = Panel::hemisphere(colors()).with_scale_bar(0.25, "Δ sin θ = 0.25").titled("map");
    let svg = Figure::new("").row(vec![panel]).svg(&FigureStyle::default(), &Notes::default()).unwrap();
    for word in ["30°", "330°", "60°", "sin θ = 0.25", "height [nm]"] {
        assert!(svg.contains(word), "{word}");
    }
}

#[test]
fn files_have_the_format_of_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let figure = Figure::new("t").row(vec![Panel::hemisphere(colors())]);
    let [svg, png] = ["f.svg", "f.PNG"].map(|name| folder.path().join(name));
    figure.save(&svg, &FigureStyle::default(), &Notes::default()).unwrap();
    figure.save(&png, &FigureStyle::default(), &Notes::default()).unwrap();
    assert!(std::fs::read_to_string(svg).unwrap().starts_with("<svg"));
    assert_eq!(std::fs::read(png).unwrap()[..4], *b"\x89PNG");
    assert_eq!(
        figure
            .save(&folder.path().join("f.pdf"), &FigureStyle::default(), &Notes::default())
            .unwrap_err()
            .kind(),
        crate::error::ErrorKind::Usage
    );
}

/// Writes figures with all there is into the folder `DIFFRACT_GALLERY`, to be looked at.
#[test]
fn everything_can_stand_in_one_figure() {
    let wave = |n: usize, f: f64| -> Vec<[f64; 2]> {
        (0..n).map(|i| i as f64 / n as f64).map(|x| [x, (f * x).sin().abs() + 0.01]).collect()
    };
    let side = 256;
    let bumps: Vec<f64> = (0..side * side)
        .map(|i| {
            let c = |j: usize| 2.0 * (j as f64 + 0.5) / side as f64 - 1.0;
            let (x, y) = (c(i % side), -c(i / side));
            let inside = x * x + y * y < 1.0;
            if inside { (-80.0 * ((x - 0.4).powi(2) + y * y)).exp() * 300.0 } else { f64::NAN }
        })
        .collect();
    let series = Panel::new(Axis::linear("wavelength [nm]", 0.0, 1.0), Axis::log("error", 1e-3, 2.0))
        .titled("Lines, points and a band")
        .named("band", Mark::Band { points: vec![[0.0, 0.1, 0.3], [1.0, 0.2, 1.0]], color: palette::SKY })
        .named("a line", Mark::line(wave(200, 9.0), palette::BLUE))
        .named("a dashed one", Mark::dashed(wave(200, 5.0), palette::VERMILION))
        .named("rings", Mark::points(wave(9, 3.0), palette::GREEN, MarkShape::Ring))
        .named("diamonds", Mark::points(wave(7, 2.0), palette::PURPLE, MarkShape::Diamond))
        .mark(Mark::note([0.5, 0.01], "a note at (0.5, 0.01)"));
    let log = ColorScale::decades("BRDF [sr⁻¹]", 5.0, &bumps);
    let map = Panel::hemisphere(Raster::values(side, &bumps, log))
        .titled("A hemisphere")
        .with_scale_bar(0.25, "Δ sin θ = 0.25")
        .mark(Mark::points(vec![[0.5, 0.0]], palette::ORANGE, MarkShape::Cross));
    let field = Panel {
        frame: PlotFrame::Box { equal: true },
        ..Panel::new(Axis::linear("x [µm]", 0.0, 65.0), Axis::linear("y [µm]", 0.0, 65.0))
    }
    .over(Raster::values(side, &bumps, heights(ColorMap::Viridis, bumps.iter().copied().fold(0.0, f64::max))))
    .titled("A field")
    .with_scale_bar(10.0, "10 µm");
    let figure = Figure::new("A figure with everything")
        .row(vec![series, map])
        .row(vec![field])
        .caption("Figure 1. A caption says what is seen, at which settings, and is wrapped where the page ends: σ = 16.25 µm, θ = 30°, λ = 550 nm, basis optimal, tolerance 10⁻².\nAnd has a second paragraph.");
    let (svg, png) = (
        figure.svg(&FigureStyle::default(), &Notes::default()).unwrap(),
        figure.png(&FigureStyle::default(), &Notes::default()).unwrap(),
    );
    assert!(svg.matches("<path").count() > 20 && decoded(&png).width() > 2000);
    if let Some(folder) = std::env::var_os("DIFFRACT_GALLERY") {
        std::fs::write(Path::new(&folder).join("gallery.png"), png).unwrap();
    }
}
