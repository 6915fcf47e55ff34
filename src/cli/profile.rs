//! `diffract profile`: how long a frame takes, what it does in that time, and what the device could do.

use super::options::{
    ColourOptions, DeviceOptions, Method, OpticsOptions, SurfaceOptions, check_lights, lights_of,
    sample_pixels,
};
use super::{prepare, write};
use crate::error::{Error, Result};
use crate::measure::cost::Cost;
use crate::measure::error::{self, PixelErrors};
use crate::measure::profile::{Summary, Times, measure};
use crate::optics::spectrum::SHORTEST;
use crate::output;
use crate::precompute::Layers;
use crate::render::frame::View;
use crate::render::picture::{Directions, Painter};
use crate::render::reference_picture::{covered, displayed, reference_pixels};
use crate::render::resources::Pigment;
use crate::render::shading::Shading;
use crate::scene::{Light, Scene};
use crate::surface::HeightField;
use crate::units;
use crate::vk::device::Device;
use clap::Args;
use glam::DVec3;
use serde::Serialize;
use std::path::PathBuf;

/// Frames a second of the thesis' shader on the GPU of its day.
const TARGET_FPS: (f64, f64) = (5.0, 15.0);
/// A spread of medians beyond this means that the machine was busy with something else.
const NOISY: f64 = 1.15;

/// Arguments of `profile`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// snake, plate, sphere, disc, a scene file (.toml) or a mesh (.obj)
    #[arg(default_value = "snake")]
    scene: String,
    /// Write the numbers as JSON too
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Frames to measure
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(3..=100_000), allow_hyphen_values = true)]
    frames: u32,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = units::size, allow_hyphen_values = true, default_value = "640x480")]
    size: [u32; 2],
    /// A light instead of the scene's, in degrees from up and around it; up to four
    #[arg(long, value_name = "THETA,PHI[,INTENSITY]", value_parser = units::light, allow_hyphen_values = true)]
    light: Vec<Light>,
    /// Compare so many random pixels with the f64 reference too, or `all`
    #[arg(long, value_name = "N|all", value_parser = compared, allow_hyphen_values = true)]
    error: Option<usize>,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    colour: ColourOptions,
    #[command(flatten)]
    device: DeviceOptions,
}

/// How many pixels `--error` means.
fn compared(text: &str) -> Result<usize> {
    if text.trim() == "all" { Ok(usize::MAX) } else { sample_pixels(text) }
}

/// The report, as JSON has it.
#[derive(Serialize)]
struct Report {
    device: String,
    driver: String,
    size: [u32; 2],
    method: &'static str,
    basis: &'static str,
    tolerance: f64,
    terms: usize,
    layers: usize,
    kernel: String,
    wavelengths: f64,
    covered: f64,
    gpu_ms: Milliseconds,
    shade_ms: Milliseconds,
    display_ms: Milliseconds,
    frame_ms: Milliseconds,
    fps: f64,
    samples_per_covered_pixel: f64,
    sample_rate: f64,
    sample_rate_fraction: f64,
    spread: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<PixelErrors>,
    #[serde(skip_serializing_if = "Option::is_none")]
    flip: Option<f64>,
}

#[derive(Serialize)]
struct Milliseconds {
    min: f64,
    p50: f64,
    p95: f64,
    max: f64,
}

impl From<Summary> for Milliseconds {
    fn from(s: Summary) -> Self {
        Self { min: s.min, p50: s.p50, p95: s.p95, max: s.max }
    }
}

/// Measures and reports.
pub fn run(arguments: &Arguments) -> Result<()> {
    if arguments.optics.method == Method::Reference {
        return Err(Error::usage("--method reference has no frames to time", "use --method spectral"));
    }
    check_lights(&arguments.light)?;
    if let Some(path) = &arguments.json {
        output::check(path)?;
    }
    let shading = arguments.optics.shading(&arguments.colour)?;
    let scene = Scene::open(&arguments.scene)?;
    let field = arguments.surface.load(None, Some(&scene), "elaphe")?;
    let device = prepare::device(&arguments.device.wish())?;
    let layers = prepare::layers(&field, &shading, SHORTEST, &device)?;
    let view = View::of(&scene, lights_of(&arguments.light, &scene));
    let mut painter = Painter::new(
        &device,
        &layers,
        &shading,
        &scene.mesh,
        &Pigment::white(),
        arguments.size,
        view.lights.len(),
    )?;
    let directions =
        (0..view.lights.len()).map(|light| painter.directions(&view, light)).collect::<Result<Vec<_>>>()?;
    let cost = Cost::of(&layers, painter.combs(), &directions);
    let bar = prepare::progress_bar("frames");
    let pixels = arguments.size[0] as usize * arguments.size[1] as usize;
    let times = measure(&mut painter, &view, arguments.frames as usize, pixels, &|done, of| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        Ok(())
    })?;
    bar.finish_and_clear();
    let (error, flip) = match arguments.error {
        Some(count) => compare(&mut painter, &view, &field, &shading, &directions, &scene, count)?,
        None => (None, None),
    };
    drop(painter);
    prepare::finish(&device)?;
    let report = Report { error, flip, ..report(arguments, &device, &layers, &cost, &times, pixels) };
    write::stdout(&text(&report))?;
    if let Some(path) = &arguments.json {
        write::json(path, &report)?;
    }
    Ok(())
}

/// Errors of what `painter` shows at `count` random pixels, and what an observer sees of them where that is every pixel.
fn compare(
    painter: &mut Painter,
    view: &View,
    field: &HeightField,
    shading: &Shading,
    directions: &[Directions],
    scene: &Scene,
    count: usize,
) -> Result<(Option<PixelErrors>, Option<f64>)> {
    let picture = painter.paint(view, scene.exposure, scene.background)?;
    let pixels = error::sample(&covered(directions), count);
    let bar = prepare::progress_bar("reference");
    let exact = reference_pixels(field, shading, view, directions, &pixels, &|done, of| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        Ok(())
    });
    bar.finish_and_clear();
    let shown = |&i: &usize| {
        let [r, g, b, _] = picture.radiance[i];
        DVec3::new(r.into(), g.into(), b.into())
    };
    let exact = exact?;
    let errors = PixelErrors::of(&pixels.iter().map(shown).collect::<Vec<_>>(), &exact, scene.exposure);
    let whole = count >= covered(directions).len();
    let flip = whole.then(|| {
        let mut radiance = vec![[0.0; 4]; picture.radiance.len()];
        for (&pixel, color) in pixels.iter().zip(&exact) {
            radiance[pixel] = color.as_vec3().extend(1.0).to_array();
        }
        error::flip(&picture.display, &displayed(&radiance, scene.exposure, scene.background), picture.size)
    });
    Ok((Some(errors), flip))
}

fn report(
    arguments: &Arguments,
    device: &Device,
    layers: &Layers,
    cost: &Cost,
    times: &Times,
    pixels: usize,
) -> Report {
    let candidate = device.candidate();
    let reached = cost.samples as f64 / (times.shade.p50 * 1e-3);
    Report {
        device: candidate.name.clone(),
        driver: candidate.driver.clone(),
        size: arguments.size,
        method: "spectral",
        basis: arguments.optics.basis.name(),
        tolerance: arguments.optics.tolerance,
        terms: layers.terms,
        layers: layers.pairs(),
        kernel: format!("{:?}", layers.interpolation.kernel).to_lowercase(),
        wavelengths: cost.wavelengths_per_pixel(),
        covered: cost.covered as f64 / pixels as f64,
        gpu_ms: times.gpu.into(),
        shade_ms: times.shade.into(),
        display_ms: times.display.into(),
        frame_ms: times.frame.into(),
        fps: 1e3 / times.frame.p50,
        samples_per_covered_pixel: cost.samples_per_pixel(),
        sample_rate: times.sample_rate,
        sample_rate_fraction: reached / times.sample_rate,
        spread: times.spread,
        error: None,
        flip: None,
    }
}

fn text(r: &Report) -> String {
    let ms = |m: &Milliseconds| format!("{:.1} / {:.1} / {:.1} / {:.1} ms", m.min, m.p50, m.p95, m.max);
    let verdict = match r.fps {
        fps if fps < TARGET_FPS.0 => "below the 5 to 15 fps of the thesis",
        fps if fps <= TARGET_FPS.1 => "within the 5 to 15 fps of the thesis",
        _ => "above the 5 to 15 fps of the thesis",
    };
    let mut lines = vec![
        ("device", format!("{}, {}", r.device, r.driver)),
        ("picture", format!("{} x {}, {:.1} % covered", r.size[0], r.size[1], r.covered * 100.0)),
        (
            "setting",
            format!(
                "{}, {}, {} terms in {} layers, {} kernel, {:.1} wavelengths a covered pixel, tolerance {:.0e}",
                r.method, r.basis, r.terms, r.layers, r.kernel, r.wavelengths, r.tolerance
            ),
        ),
        ("frame (min/p50/p95/max)", ms(&r.frame_ms)),
        ("device: shading", ms(&r.shade_ms)),
        ("device: display", ms(&r.display_ms)),
        ("frames a second", format!("{:.2}, {verdict}", r.fps)),
        ("samples", format!("{:.0} a covered pixel", r.samples_per_covered_pixel)),
        (
            "sample rate",
            format!(
                "{:.0} M/s are possible here, {:.0} % of it are used",
                r.sample_rate * 1e-6,
                r.sample_rate_fraction * 100.0
            ),
        ),
    ];
    if let Some(e) = &r.error {
        lines.push((
            "error",
            format!(
                "{:.1e} ± {:.0e} relative L2, 99 % of pixels within {:.1e} of their own value ({} pixels against f64)",
                e.relative_l2, e.relative_l2_interval, e.p99, e.pixels
            ),
        ));
    }
    if let Some(flip) = r.flip {
        lines.push(("seen", format!("FLIP {flip:.1e} (0 is no visible difference, 1 the largest)")));
    }
    if r.spread > NOISY {
        lines.push((
            "warning",
            format!("the machine was busy: medians differ by a factor of {:.2}", r.spread),
        ));
    }
    lines.iter().map(|(name, value)| format!("{name:<26}{value}\n")).collect()
}
