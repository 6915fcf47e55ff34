//! `diffract profile`: frame times, their parts, and the limits of the device.

mod report;

use super::benchmark::{BenchmarkOptions, BenchmarkScene, PictureErrors};
use super::console::Console;
use super::options::sample_pixels;
use super::progress::ProgressBar;
use super::{captions, prepare, write};
use crate::error::Result;
use crate::files::Files;
use crate::measure::profile::{measure, rates};
use clap::Args;
use report::ProfileReport;
use std::path::PathBuf;

/// Arguments of `profile`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  diffract profile
  diffract profile disc --windows 1x1 --tolerance 5e-2 --size 640x480 --error 2000
  diffract profile --frames 30 --json profile.json")]
pub struct Arguments {
    #[command(flatten)]
    pub benchmark: BenchmarkOptions,
    /// Write the numbers as JSON too
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub json: Option<PathBuf>,
    /// Frames to measure
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(3..=100_000), allow_hyphen_values = true)]
    pub frames: u32,
    /// Compare this many random pixels, or all, with f64 references: for the same directions, and for rays cast in f64
    #[arg(long, value_name = "N|all", value_parser = compared_pixels, allow_hyphen_values = true)]
    pub error: Option<usize>,
    /// Print the parts of the error
    #[arg(long, hide_short_help = true)]
    pub explain: bool,
}

/// Parses the number of pixels of `--error`.
fn compared_pixels(text: &str) -> Result<usize> {
    if text.trim() == "all" { Ok(usize::MAX) } else { sample_pixels(text) }
}

/// Measures the frame and reports.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let options = &arguments.benchmark;
    let console = &options.device.chosen(&options.cache.limited(console));
    let files = Files::new()
        .reads([&options.scene])
        .reads(options.surface.files(None))
        .reads(options.colour.files())
        .reads(options.optics.files())
        .reads(options.mesh.files())
        .writes(&arguments.json);
    files.check()?;
    let scene = BenchmarkScene::open(options, console)?;
    files.reads(&scene.scene.files).check()?;
    let report = profile(&scene, options, arguments)?;
    prepare::finish(console, &scene.device)?;
    let mut text = report.text();
    if arguments.explain {
        text += &report.budget_text();
    }
    console.write(&text)?;
    if let Some(path) = &arguments.json {
        write::json(path, &write::with_origin(&report, &captions::notes(&scene.field, console)))?;
    }
    Ok(())
}

fn profile(
    scene: &BenchmarkScene,
    options: &BenchmarkOptions,
    arguments: &Arguments,
) -> Result<ProfileReport> {
    let mut benchmark = scene.prepare(options)?;
    let bar = ProgressBar::new(&scene.console, "frames", "a smaller number of --frames");
    let frames = arguments.frames as usize;
    let times = measure(&mut benchmark.renderer, &scene.view, frames, f64::INFINITY, &bar.task())?;
    drop(bar);
    let rates = rates(&mut benchmark.renderer, scene.pixels())?;
    let errors = match arguments.error {
        Some(count) => scene.compare(&mut benchmark, count)?,
        None => PictureErrors::default(),
    };
    Ok(ProfileReport::new(scene, benchmark, &times, &rates, errors))
}
