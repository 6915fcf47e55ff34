//! `diffract profile`: how long a frame takes, what it does in that time, and what the device could do.

use super::options::{
    CacheOptions, ColourOptions, DeviceOptions, FilterOptions, OpticsOptions, SurfaceOptions, check_lights,
    real, sample_pixels,
};
use super::stage::{Setting, Stage};
use super::{choice, prepare, write};
use crate::error::Result;
use crate::files::Files;
use crate::measure::budget::Budget;
use crate::measure::cost::Cost;
use crate::measure::error::PixelErrors;
use crate::measure::profile::{Bound, Rates, Summary, Times, measure, rates};
use crate::scene::Light;
use crate::units;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Frames a second of the thesis' shader on the GPU of its day.
const TARGET_FPS: (f64, f64) = (5.0, 15.0);
/// A spread of medians beyond this means that the machine was busy with something else.
pub const NOISY: f64 = 1.15;

/// Arguments of `profile`.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    /// snake, plate, sphere, disc, a scene file (.toml) or a mesh (.obj)
    #[arg(default_value = "snake")]
    pub scene: String,
    /// Write the numbers as JSON too
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Frames to measure
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(3..=100_000), allow_hyphen_values = true)]
    pub frames: u32,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = units::size, allow_hyphen_values = true, default_value = "640x480")]
    pub size: [u32; 2],
    /// A light instead of the scene's, in degrees from up and around it; up to four
    #[arg(long, value_name = "THETA,PHI[,INTENSITY]", value_parser = units::light, allow_hyphen_values = true)]
    pub light: Vec<Light>,
    /// Compare so many random pixels with the f64 reference too, or `all`
    #[arg(long, value_name = "N|all", value_parser = compared, allow_hyphen_values = true)]
    pub error: Option<usize>,
    /// Choose the most accurate setting that keeps this frame rate; what is named stays
    #[arg(long, value_name = "F", value_parser = fps, allow_hyphen_values = true)]
    pub fps: Option<f64>,
    /// Print where the error comes from
    #[arg(long)]
    pub explain: bool,
    #[command(flatten)]
    pub surface: SurfaceOptions,
    #[command(flatten)]
    pub optics: OpticsOptions,
    #[command(flatten)]
    pub filter: FilterOptions,
    #[command(flatten)]
    pub colour: ColourOptions,
    #[command(flatten)]
    pub device: DeviceOptions,
    #[command(flatten)]
    pub cache: CacheOptions,
}

/// How many pixels `--error` means.
fn compared(text: &str) -> Result<usize> {
    if text.trim() == "all" { Ok(usize::MAX) } else { sample_pixels(text) }
}

/// A frame rate.
pub fn fps(text: &str) -> Result<f64> {
    real(text, (1e-3, 1e5), "frame rate")
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
    geometry_ms: Milliseconds,
    shade_ms: Milliseconds,
    display_ms: Milliseconds,
    record_ms: Milliseconds,
    frame_ms: Milliseconds,
    fps: f64,
    samples_per_covered_pixel: f64,
    sample_rate: f64,
    scattered_sample_rate: f64,
    sample_rate_fraction: f64,
    bound_by: Bound,
    spread: f64,
    noisy: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<PixelErrors>,
    #[serde(skip_serializing_if = "Option::is_none")]
    flip: Option<f64>,
    budget: Budget,
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
    arguments.cache.apply();
    check_lights(&arguments.light)?;
    let files = Files::new()
        .reads([&arguments.scene])
        .reads(arguments.surface.files(None))
        .reads(arguments.colour.files())
        .writes(&arguments.json);
    files.check()?;
    let stage = Stage::set(arguments)?;
    files.reads(&stage.scene.files).check()?;
    let choice = arguments.fps.map(|fps| choice::keeping(fps, &stage, arguments)).transpose()?;
    let report = profile(&stage, choice.as_ref().map_or(arguments, |choice| &choice.arguments))?;
    prepare::finish(&stage.device)?;
    let budget = if arguments.explain { explained(&report) } else { String::new() };
    let chosen = choice.map_or_else(String::new, |choice| {
        let keeps = if choice.keeps { "keeps it" } else { "is the fastest here and does not keep it" };
        format!(
            "{:<26}{} frames a second: {} {keeps}\n",
            "asked for",
            arguments.fps.unwrap_or(0.0),
            choice.flags
        )
    });
    write::stdout(&(text(&report) + &chosen + &budget))?;
    if let Some(path) = &arguments.json {
        write::json(path, &report)?;
    }
    Ok(())
}

/// Where the error comes from, and beside it what was measured.
fn explained(report: &Report) -> String {
    let measured = match &report.error {
        Some(e) => format!("{:.1e} ± {:.0e} over {} pixels", e.relative_l2, e.relative_l2_interval, e.pixels),
        None => "not asked for: --error 2000".to_owned(),
    };
    format!("{}{:<26}{measured}\n", report.budget.to_text(), "measured")
}

fn profile(stage: &Stage, arguments: &Arguments) -> Result<Report> {
    let shading = arguments.optics.for_pictures(&arguments.colour)?;
    let (mut painter, setting, cost, directions) = stage.prepare(arguments, &shading)?;
    let bar = prepare::progress_bar("frames");
    let times = measure(&mut painter, &stage.view, arguments.frames as usize, f64::INFINITY, &|done, of| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        Ok(())
    })?;
    bar.finish_and_clear();
    let rates = rates(&mut painter, stage.pixels())?;
    let (error, flip) = match arguments.error {
        Some(count) => stage.compare(&mut painter, &shading, &directions, count)?,
        None => (None, None),
    };
    let report = report(stage, arguments, setting, &cost, &times, &rates);
    Ok(Report { error, flip, ..report })
}

fn report(
    stage: &Stage,
    arguments: &Arguments,
    setting: Setting,
    cost: &Cost,
    times: &Times,
    rates: &Rates,
) -> Report {
    let candidate = stage.device.candidate();
    let reached = cost.samples as f64 / (times.shade.p50 * 1e-3);
    Report {
        device: candidate.name.clone(),
        driver: candidate.driver.clone(),
        size: stage.size,
        method: setting.method,
        basis: setting.basis.name(),
        tolerance: arguments.optics.tolerance(),
        terms: setting.terms,
        layers: setting.layers,
        kernel: setting.kernel,
        wavelengths: cost.wavelengths_per_pixel(),
        covered: cost.covered as f64 / stage.pixels() as f64,
        gpu_ms: times.gpu.into(),
        geometry_ms: times.geometry.into(),
        shade_ms: times.shade.into(),
        display_ms: times.display.into(),
        record_ms: times.record.into(),
        frame_ms: times.frame.into(),
        fps: 1e3 / times.frame.p50,
        samples_per_covered_pixel: cost.samples_per_pixel(),
        sample_rate: rates.coherent,
        scattered_sample_rate: rates.scattered,
        sample_rate_fraction: reached / rates.coherent,
        bound_by: Bound::of(times, cost.samples, rates),
        spread: times.spread,
        noisy: times.spread > NOISY,
        error: None,
        flip: None,
        budget: setting.budget,
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
            match r.method {
                "table" => format!("table, {} layers, {}, tolerance {:.0e}", r.layers, r.kernel, r.tolerance),
                method => format!(
                    "{method}, {}, {} terms in {} layers, {}, {:.1} wavelengths a covered pixel, tolerance {:.0e}",
                    r.basis, r.terms, r.layers, r.kernel, r.wavelengths, r.tolerance
                ),
            },
        ),
        ("frame (min/p50/p95/max)", ms(&r.frame_ms)),
        ("device: mesh", ms(&r.geometry_ms)),
        ("device: shading", ms(&r.shade_ms)),
        ("device: display", ms(&r.display_ms)),
        ("CPU: recording", ms(&r.record_ms)),
        ("frames a second", format!("{:.2}, {verdict}", r.fps)),
        ("samples", format!("{:.0} a covered pixel", r.samples_per_covered_pixel)),
        (
            "sample rate",
            format!(
                "{:.0} M/s are possible here side by side, {:.0} M/s scattered; the frame reaches {:.0} M/s, {:.0} % of the \
                 first",
                r.sample_rate * 1e-6,
                r.scattered_sample_rate * 1e-6,
                r.sample_rate * r.sample_rate_fraction * 1e-6,
                r.sample_rate_fraction * 100.0
            ),
        ),
        (
            "bound by",
            match r.bound_by {
                Bound::Samples => "reading the layers",
                Bound::Arithmetic => "the arithmetic between the reads",
                Bound::Fill => "drawing the mesh and the display, not the shading",
                Bound::Cpu => "the CPU: recording, submitting, waiting",
            }
            .to_owned(),
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
    if r.noisy {
        lines.push((
            "warning",
            format!(
                "too noisy to tell: the medians of three parts of the series differ by a factor of {:.2}",
                r.spread
            ),
        ));
    }
    lines.iter().map(|(name, value)| format!("{name:<26}{value}\n")).collect()
}
