//! One page about a height field: the heights, profiles, the spectrum, the predicted colours, and the distributions of heights and slopes.

use super::hemisphere;
use crate::cli::console::Console;
use crate::error::Result;
use crate::figure::{Axis, AxisScale, ColorMap, ColorScale, Figure, Mark, Panel, Raster, palette};
use crate::optics::spectrum::{LONGEST, SHORTEST};
use crate::optics::validity::ScalarTheory;
use crate::surface::statistics::height_spectrum::{SurfaceSpectrum, analysed_part};
use crate::surface::statistics::plot_grid::{self, PlotGrid, histogram};
use crate::surface::statistics::slopes::gradients;
use crate::surface::{HeightField, Statistics, SurfaceSource};

/// The longest side of a picture in the page \[pixels\]; a finer one is not visible.
const MOST_PIXELS: usize = 600;
/// Bins of the histograms.
const BINS: usize = 120;
/// Names of the panels, in the order in which they stand in the page.
pub const PANELS: [&str; 8] = [
    "heights",
    "power",
    "colours-above",
    "colours-aside",
    "profiles",
    "spectrum",
    "height-distribution",
    "slope-distribution",
];
/// Panels \[px\].
const PANEL: [f64; 2] = [600.0, 470.0];

/// Returns the page of `field`, which `source` gave.
pub fn figure(
    source: &SurfaceSource,
    field: &HeightField,
    statistics: &Statistics,
    theory: &ScalarTheory,
    console: &Console,
) -> Result<Figure> {
    let spectrum = SurfaceSpectrum::windowed(&analysed_part(field))?;
    let name = std::path::Path::new(&source.name)
        .file_name()
        .map_or(source.name.to_string_lossy().into_owned(), |n| n.to_string_lossy().into_owned());
    let mut figure = Figure::new(format!("{name}: heights, spectrum, colours and distributions"))
        .panel_size(PANEL[0], PANEL[1])
        .row(vec![heights(field, statistics), power(&spectrum)]);
    // Without colours the page is still useful.
    let colours = match hemisphere::panels(field, statistics, console) {
        Ok((panels, words)) => {
            figure = figure.row(panels);
            words
        }
        Err(e) if e.is_too_large() => format!("No colours: {e}."),
        Err(e) => return Err(e),
    };
    Ok(figure
        .row(vec![profile(field), radial(&spectrum, statistics)])
        .row(vec![height_histogram(field, statistics), slope_histogram(field, statistics)])
        .caption(caption(field, statistics, theory) + "\n" + &colours))
}

fn caption(field: &HeightField, statistics: &Statistics, theory: &ScalarTheory) -> String {
    let [width, height] = field.patch_size();
    let h = &statistics.heights;
    format!(
        "{} × {} samples over {width:.2} µm × {height:.2} µm. Prepared by: {}. Sq {:.1} nm, Sa {:.1} nm, Ssk {:.2}, Sku {:.2}, Sdq {:.3}. Tiles: {}.\n\
         Scalar theory: {}.",
        field.columns(),
        field.rows(),
        field.prepared(),
        h.sq * 1e3,
        h.sa * 1e3,
        h.ssk,
        h.sku,
        statistics.slopes.sdq,
        statistics.tiling.verdict.words(),
        theory.line()
    )
}

/// Draws the heights in false colour, over the range of almost all of them, so that dust does not take the colours.
fn heights(field: &HeightField, statistics: &Statistics) -> Panel {
    let [width, height] = field.patch_size();
    let grid = PlotGrid::of_heights(field, MOST_PIXELS);
    let [low, high] = grid.core();
    let scale = ColorScale { axis: Axis::linear("height [nm]", low, high), map: ColorMap::Viridis };
    let bar = scale_bar(width);
    let mut panel = Panel::new(
        Axis::linear("x [µm]", -width / 2.0, width / 2.0),
        Axis::linear("y [µm]", -height / 2.0, height / 2.0),
    )
    .to_scale()
    .over(Raster::values(grid.size[0], &grid.values, scale))
    .titled("Heights")
    .called("heights")
    .with_scale_bar(bar, format!("{bar} µm"));
    if let Some(period) = statistics.periods.first() {
        let (sin, cos) = period.direction.to_radians().sin_cos();
        let reach = 0.12 * width.min(height);
        let at = [0.5 * width - 1.6 * reach, 0.5 * height - 1.6 * reach];
        let arrow =
            vec![[at[0] - reach * cos, at[1] - reach * sin], [at[0] + reach * cos, at[1] + reach * sin]];
        panel = panel.named(
            format!("wave vector of the strongest period, {:.3} µm", period.length),
            Mark::Line { points: arrow, color: palette::VERMILION, width: 2.4, dashed: false },
        );
    }
    panel
}

/// Draws the power spectrum over both halves, with the circles of the orders that light from straight above sends to the horizon.
fn power(spectrum: &SurfaceSpectrum) -> Panel {
    let side = plot_grid::side_of_power(spectrum, SHORTEST);
    let grid = PlotGrid::of_power(spectrum, side, MOST_PIXELS);
    /// Decades below the peak that are shown.
    const DECADES: f64 = 7.0;
    let scale = ColorScale::decades("power density [nm² µm²]", DECADES, &grid.values);
    let axis = |name: &str| Axis::linear(format!("{name} [1/µm]"), -side, side);
    let circle = |radius: f64| -> Vec<[f64; 2]> {
        (0..=180)
            .map(|n| (f64::from(n) * 2.0).to_radians())
            .map(|a| [radius * a.cos(), radius * a.sin()])
            .collect()
    };
    let visible = |wavelength: f64, color| Mark::Line {
        points: circle(1.0 / wavelength),
        color,
        width: 1.6,
        dashed: true,
    };
    Panel::new(axis("f_x"), axis("f_y"))
        .to_scale()
        .over(Raster::values(grid.size[0], &grid.values, scale))
        .titled("Power spectrum")
        .called("power")
        .named("seen at normal incidence: within 1/λ at 380 nm", visible(SHORTEST, palette::SKY))
        .named("at 780 nm", visible(LONGEST, palette::VERMILION))
}

/// Draws two profiles through the middle.
fn profile(field: &HeightField) -> Panel {
    let (columns, rows) = (field.columns(), field.rows());
    let along_x: Vec<[f64; 2]> =
        field.row(rows / 2).iter().enumerate().map(|(c, h)| [field.x(c), h * 1e3]).collect();
    let along_y: Vec<[f64; 2]> =
        (0..rows).rev().map(|r| [field.y(r), field.row(r)[columns / 2] * 1e3]).collect();
    let all = || along_x.iter().chain(&along_y);
    let x = Axis::fit("position [µm]", AxisScale::Linear, all().map(|p| p[0]));
    let y = Axis::fit("height [nm]", AxisScale::Linear, all().map(|p| p[1]));
    Panel::new(x, y)
        .titled("Profiles through the middle")
        .called("profiles")
        .named("along x", thin(along_x, palette::BLUE))
        .named("along y", thin(along_y, palette::VERMILION))
}

fn thin(points: Vec<[f64; 2]>, color: palette::Color) -> Mark {
    Mark::Line { points, color, width: 1.3, dashed: false }
}

/// Draws the spectrum averaged over directions, the band that light sees, and the noise.
fn radial(spectrum: &SurfaceSpectrum, statistics: &Statistics) -> Panel {
    let rings: Vec<[f64; 2]> = spectrum.radial().iter().map(|[f, s]| [*f, s * 1e6]).collect();
    let x = Axis::fit("|f| [1/µm]", AxisScale::Log, rings.iter().map(|p| p[0]));
    let noise = {
        let [columns, rows] = spectrum.samples;
        let power = statistics.noise.powi(2) / (columns * rows) as f64;
        power * spectrum.patch[0] * spectrum.patch[1] * 1e6
    };
    let y = Axis::fit("power density [nm² µm²]", AxisScale::Log, rings.iter().map(|p| p[1].max(1e-12)));
    let (low, high) = (y.low, y.high);
    let upright = |f: f64| vec![[f, low], [f, high]];
    let mut panel = Panel::new(x, y)
        .titled("Spectrum averaged over directions")
        .called("spectrum")
        .named(
            "light sees up to 2/λ",
            Mark::Band {
                points: vec![[rings.first().map_or(0.1, |p| p[0]), low, high], [2.0 / SHORTEST, low, high]],
                color: palette::SKY,
            },
        )
        .named("power", thin(rings, palette::BLUE));
    if noise > low {
        panel =
            panel.named("noise at most", Mark::dashed(vec![[1e-9, noise], [1e9, noise]], palette::ORANGE));
    }
    for (n, period) in statistics.periods.iter().enumerate() {
        let mark = Mark::Line {
            points: upright(1.0 / period.length),
            color: palette::VERMILION,
            width: 1.2,
            dashed: n > 0,
        };
        panel = if n == 0 {
            panel.named(format!("period {:.3} µm", period.length), mark)
        } else {
            panel.mark(mark)
        };
    }
    panel
}

fn height_histogram(field: &HeightField, statistics: &Statistics) -> Panel {
    let h = &statistics.heights;
    let [low, high] = h.range.map(|h| h * 1e3);
    // Bins of whole codes, if there are codes: other bins would hold one code or two in turn.
    let step = h.quantisation.map_or(0.0, |step| step * 1e3);
    let width = if step > 0.0 {
        ((high - low) / BINS as f64 / step).ceil().max(1.0) * step
    } else {
        (high - low) / BINS as f64
    };
    let bars = histogram(field.heights().iter().map(|h| h * 1e3), [low - step / 2.0, high], width, BINS);
    let most = bars.iter().map(|b| b[2]).fold(0.0, f64::max);
    let (mean, sigma) = (h.mean * 1e3, h.sq * 1e3);
    let normal =
        |x: f64| (-0.5 * ((x - mean) / sigma).powi(2)).exp() / (sigma * std::f64::consts::TAU.sqrt());
    let curve: Vec<[f64; 2]> =
        (0..=200).map(|i| low + (high - low) * f64::from(i) / 200.0).map(|x| [x, normal(x)]).collect();
    Panel::new(
        Axis::fit("height [nm]", AxisScale::Linear, [low, high]),
        Axis::linear("probability density [1/nm]", 0.0, 1.08 * most),
    )
    .titled("Distribution of heights")
    .called("height-distribution")
    .named("heights", Mark::Band { points: bars, color: palette::BLUE })
    .named("normal distribution of the same Sq", Mark::dashed(curve, palette::VERMILION))
}

/// Draws the distribution of slopes.
fn slope_histogram(field: &HeightField, statistics: &Statistics) -> Panel {
    // A few steep facets would press all others into the first bins.
    let last = (1.6 * statistics.slopes.angle_95).min(statistics.slopes.angle_max).max(1e-3);
    let [dx, dy] = field.pixel_size();
    // Gradient of one height code between neighbouring samples.
    let of_code = statistics.heights.quantisation.map_or(0.0, |step| step / dx.min(dy));
    let is_coarse = of_code > last.to_radians().tan() / BINS as f64;
    let (bars, name) = if is_coarse {
        let degrees = of_code.atan().to_degrees();
        (
            bars_of_codes(&gradients(field), of_code, last),
            format!("slopes, in steps of a height code, {degrees:.2}°"),
        )
    } else {
        let angles = gradients(field).into_iter().map(|g| g.atan().to_degrees());
        (histogram(angles, [0.0, last], last / BINS as f64, BINS), "slopes".to_owned())
    };
    let most = bars.iter().map(|b| b[2]).fold(0.0, f64::max);
    let (upright, rms) = (|x: f64| vec![[x, 0.0], [x, most]], statistics.slopes.sdq.atan().to_degrees());
    Panel::new(
        Axis::linear("slope angle [°]", 0.0, last),
        Axis::linear("probability density [1/°]", 0.0, 1.08 * most),
    )
    .titled("Distribution of slopes")
    .called("slope-distribution")
    .named(name, Mark::Band { points: bars, color: palette::GREEN })
    .named(format!("RMS gradient Sdq, {rms:.1}°"), Mark::line(upright(rms), palette::VERMILION))
    .named(
        format!("95 % below {:.1}°", statistics.slopes.angle_95),
        Mark::dashed(upright(statistics.slopes.angle_95), palette::ORANGE),
    )
}

/// Returns the density of slope angles up to `last` \[degrees\] as the outline of a band, in bins around whole multiples of the gradient `of_code`.
fn bars_of_codes(gradients: &[f64], of_code: f64, last: f64) -> Vec<[f64; 3]> {
    let bins = (last.to_radians().tan() / of_code + 0.5).ceil() as usize;
    let mut counts = vec![0.0; bins];
    for gradient in gradients {
        if let Some(count) = counts.get_mut((gradient / of_code + 0.5) as usize) {
            *count += 1.0;
        }
    }
    let angle = |edge: f64| (edge.max(0.0) * of_code).atan().to_degrees();
    let bar = |(bin, count): (usize, &f64)| {
        let edges = [bin as f64 - 0.5, bin as f64 + 0.5].map(angle);
        let density = count / (gradients.len() as f64 * (edges[1] - edges[0]));
        edges.map(|edge| [edge.min(last), 0.0, density])
    };
    counts.iter().enumerate().flat_map(bar).collect()
}

/// Returns a round length \[µm\] of about a quarter of `width`.
pub fn scale_bar(width: f64) -> f64 {
    let power = 10f64.powf((width / 4.0).log10().floor());
    let digit = [5.0, 2.0, 1.0].into_iter().find(|d| d * power <= width / 4.0).unwrap_or(1.0);
    let length = digit * power;
    if power < 1.0 { (length * 1e6).round() / 1e6 } else { length }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::FigureStyle;
    use crate::notes::Notes;
    use crate::optics::validity::LightColour;
    use crate::surface::synth::{Spec, SurfaceKind, generate};
    use crate::task::Task;

    #[test]
    fn the_page_of_every_built_in_surface_has_all_panels_and_no_number_that_is_none() {
        let console = &Console::silent();
        for kind in SurfaceKind::ALL {
            let source = SurfaceSource::built_in(kind);
            // One at its own size, the others as small patches.
            let field = match kind {
                SurfaceKind::Elaphe => source.load(&Task::silent()).unwrap(),
                _ => generate(&Spec::new(kind).with_patch([6.0; 2])).unwrap(),
            };
            let theory = {
                let green = LightColour::Wavelength(0.55);
                ScalarTheory::of_field(&field, &Default::default(), green).unwrap()
            };
            let svg =
                figure(&source, &field, &Statistics::of(&field, &Task::silent()).unwrap(), &theory, console)
                    .unwrap()
                    .svg(&FigureStyle::default(), &Notes::default())
                    .unwrap();
            for word in [
                "Heights",
                "Power spectrum",
                "Profiles",
                "averaged over directions",
                "of heights",
                "of slopes",
                "Colours, light from straight above",
                "mirror direction",
            ] {
                assert!(svg.contains(word), "{kind:?}: {word}");
            }
            // Pictures are letters, too.
            let words: String =
                svg.split("base64,").map(|part| part.split_once('"').map_or(part, |p| p.1)).collect();
            assert!(!words.contains("NaN") && !words.contains("inf"), "{kind:?}");
        }
    }

    #[test]
    fn slopes_of_few_height_codes_are_no_comb() {
        // A smooth surface of 16 codes, whose gradients are multiples of a code over the distance of samples.
        let height = |i: usize| 0.5 * ((i % 64) as f64 * 0.31).sin() + 0.5 * ((i / 64) as f64 * 0.23).sin();
        let codes: Vec<f64> = (0..64 * 64).map(|i| (7.5 * height(i)).round() * 0.02).collect();
        let field = HeightField::new(64, 64, [0.1, 0.1], codes).unwrap();
        let bars = bars_of_codes(&gradients(&field), 0.2, 26.5);
        let area: f64 = bars.chunks(2).map(|bar| (bar[1][0] - bar[0][0]) * bar[0][2]).sum();
        assert!((area - 1.0).abs() < 0.01, "{area}");
        assert!(bars.iter().all(|bar| bar[2] > 0.0), "{bars:?}");
    }

    #[test]
    fn scale_bars_are_round() {
        assert_eq!([65.0, 20.0, 2.0, 0.9, 900.0].map(scale_bar), [10.0, 5.0, 0.5, 0.2, 200.0]);
    }
}
