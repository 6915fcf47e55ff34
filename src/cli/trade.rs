//! `diffract trade`: speed against accuracy, measured over many settings.

use super::options::{CacheOptions, DeviceOptions, SurfaceOptions, check_lights, coherence, ior, tolerance};
use super::stage::{Exact, References, Stage, shown};
use super::{baselines, prepare, profile, say, write};
use crate::error::{Error, Result};
use crate::files::Files;
use crate::measure::error::PixelErrors;
use crate::measure::profile::measure;
use crate::measure::trade::{self, GRATING, Row, THESIS};
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::Illuminant;
use crate::render::picture::Painter;
use crate::render::shading::Shading;
use crate::scene::Light;
use crate::{output, units};
use clap::{Args, Parser};
use std::path::{Path, PathBuf};

/// Arguments of `trade`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  diffract trade --quick -o trade
  diffract trade sphere --surface blaze -o trade
  diffract trade --fps 15 --tolerance 1e-2 -o trade    the last line is the setting that keeps both

The folder gets trade.csv, trade.md, trade.svg and trade.png. A second run goes on where the first was stopped; \
delete trade.csv to measure anew.")]
pub struct Arguments {
    /// snake, plate, sphere, disc, a scene file (.toml) or a mesh (.obj)
    #[arg(default_value = "snake")]
    scene: String,
    /// Folder for the results; made where it is missing
    #[arg(short = 'o', long, alias = "output", value_name = "DIR")]
    folder: PathBuf,
    /// Fewer settings and a smaller picture
    #[arg(long)]
    quick: bool,
    /// Width and height in pixels [default: 640x480, with --quick 320x240]
    #[arg(long, value_name = "WxH", value_parser = units::size, allow_hyphen_values = true)]
    size: Option<[u32; 2]>,
    /// A light instead of the scene's, in degrees from up and around it; up to four
    #[arg(long, value_name = "THETA,PHI[,INTENSITY]", value_parser = units::light, allow_hyphen_values = true)]
    light: Vec<Light>,
    /// Ask for the setting that keeps this relative L2 error
    #[arg(long, value_name = "E", value_parser = tolerance, allow_hyphen_values = true)]
    tolerance: Option<f64>,
    /// Ask for the setting that keeps this frame rate
    #[arg(long, value_name = "F", value_parser = profile::fps, allow_hyphen_values = true)]
    fps: Option<f64>,
    /// What surrounds the patch: gaussian:LENGTH or repeats:NxM
    #[arg(long, value_name = "KIND", value_parser = coherence, default_value = "gaussian:65um")]
    coherence: Coherence,
    /// Refractive index of the surface
    #[arg(long, value_name = "N", value_parser = ior, allow_hyphen_values = true, default_value = "1.5")]
    ior: f64,
    /// The light's spectrum: d65, a, e, or a CSV file of wavelength in nm and power
    #[arg(long, value_name = "NAME|FILE", default_value = "d65")]
    illuminant: String,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    cache: CacheOptions,
}

/// The options of a setting, parsed by the same words as those of `profile`.
#[derive(Parser, Debug)]
struct Words {
    #[command(flatten)]
    profile: profile::Arguments,
}

/// What a sweep leaves.
const FILES: [&str; 4] = ["trade.csv", "trade.md", "trade.svg", "trade.png"];
/// Frames of a setting, and the seconds beyond which no more are drawn.
const FRAMES: usize = 9;
const SECONDS: f64 = 3.0;
/// The longest CSV that is read back \[bytes\].
const LONGEST: u64 = 16 << 20;

/// Measures, and writes the results.
pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.cache.apply();
    check_lights(&arguments.light)?;
    let folder = &arguments.folder;
    let file = |name: &str| folder.join(name);
    if folder.as_os_str().is_empty() {
        return Err(Error::usage("--folder: the name is empty", "give the results a folder"));
    }
    let stage = Stage::set(&setting(arguments, "")?)?;
    // Nothing is made before there is something to write.
    if folder.exists() {
        let illuminant = Some(&arguments.illuminant).filter(|name| !Illuminant::is_built_in(name));
        Files::new()
            .reads([&arguments.scene])
            .reads(arguments.surface.files(None))
            .reads(illuminant)
            .reads(&stage.scene.files)
            .writes(FILES.map(file))
            .check()?;
    }
    let store = |rows: &[Row]| {
        std::fs::create_dir_all(folder).map_err(|e| output::write_failed(folder, &e))?;
        write::text(Some(&file("trade.csv")), &trade::csv(rows)?)
    };
    let frame = frame_key(arguments, &stage);
    let mut rows = read_rows(&file("trade.csv"), &frame);
    let mut impossible = Vec::new();
    let settings = settings(arguments.quick);
    let bar = prepare::progress_bar("settings");
    bar.set_length(settings.len() as u64);
    let mut references = References::default();
    for (done, flags) in settings.iter().enumerate() {
        bar.set_position(done as u64);
        if rows.iter().any(|row| row.flags == *flags) {
            continue;
        }
        match measured(&stage, arguments, flags, &frame, &mut references) {
            Ok(row) => {
                rows.push(row);
                store(&rows)?;
            }
            Err(error) => impossible.push((flags.clone(), error.to_string())),
        }
    }
    // What is compared with comes last: without a setting of its own there is nothing to compare.
    for series in [GRATING, THESIS] {
        if !rows.is_empty() && !rows.iter().any(|row| row.series == series) {
            let own = setting(arguments, "--tolerance 1e-1")?;
            match baselines::measured(series, &stage, &own, &mut references) {
                Ok(None) => {}
                Ok(Some(row)) => {
                    rows.push(Row { frame: frame.clone(), ..row });
                    store(&rows)?;
                }
                Err(error) => impossible.push((series.to_owned(), error.to_string())),
            }
        }
    }
    bar.finish_and_clear();
    prepare::finish(&stage.device)?;
    if rows.is_empty() {
        let why = impossible.first().map_or(String::new(), |(_, why)| why.clone());
        return Err(Error::failed(
            format!("no setting could be measured: {why}"),
            "see `diffract trade --help`",
        ));
    }
    let heading = heading(arguments, &stage, &rows);
    write::text(Some(&file("trade.md")), &trade::markdown(&rows, &heading, &impossible))?;
    let figure = trade::figure(&rows, "Speed against accuracy", &heading);
    figure.save(&file("trade.svg"))?;
    figure.save(&file("trade.png"))?;
    let asked = match (arguments.tolerance, arguments.fps) {
        (None, None) => String::new(),
        (error, fps) => trade::wanted(&rows, error, fps),
    };
    write::stdout(&format!("{heading}\n{}{asked}", trade::advice(&rows)))
}

/// The settings of a sweep: each basis over tolerances, and off the beaten path by terms and by wavelengths.
fn settings(quick: bool) -> Vec<String> {
    let mut all = Vec::new();
    let tolerances: &[&str] =
        if quick { &["1e-1", "1e-2", "1e-3"] } else { &["2e-1", "1e-1", "3e-2", "1e-2", "3e-3", "1e-3"] };
    let bases: &[&str] = if quick { &["taylor", "optimal"] } else { &["taylor", "chebyshev", "optimal"] };
    for basis in bases {
        all.extend(tolerances.iter().map(|e| format!("--basis {basis} --tolerance {e}")));
    }
    let table: &[&str] = if quick { &["1e-1", "2e-2"] } else { &["1e-1", "5e-2", "2e-2", "1e-2"] };
    all.extend(table.iter().map(|e| format!("--method table --tolerance {e}")));
    if quick {
        return all;
    }
    all.push("--basis taylor --terms 37 --wavelengths 81".to_owned());
    for terms in [4, 6, 8, 12, 16] {
        all.extend(["taylor", "optimal"].map(|basis| format!("--basis {basis} --terms {terms}")));
    }
    for wavelengths in [16, 31, 41, 81, 161] {
        all.push(format!("--basis optimal --wavelengths {wavelengths}"));
    }
    all.push("--method table --tolerance 2e-2 --windows 2x2".to_owned());
    all
}

/// The arguments of `profile` for a setting of `flags`.
fn setting(arguments: &Arguments, flags: &str) -> Result<profile::Arguments> {
    let words =
        Words::try_parse_from(std::iter::once("trade").chain(flags.split_whitespace())).map_err(|e| {
            let said = e.to_string();
            let line = said.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
            Error::usage(line, "leave it to a version of diffract that knows it")
        })?;
    let size = arguments.size.unwrap_or(if arguments.quick { [320, 240] } else { [640, 480] });
    let mut own = words.profile;
    (own.optics.coherence, own.optics.ior) = (arguments.coherence, arguments.ior);
    own.colour.illuminant.clone_from(&arguments.illuminant);
    Ok(profile::Arguments {
        scene: arguments.scene.clone(),
        size,
        light: arguments.light.clone(),
        surface: arguments.surface.clone(),
        device: arguments.device.clone(),
        ..own
    })
}

fn measured(
    stage: &Stage,
    arguments: &Arguments,
    flags: &str,
    frame: &str,
    references: &mut References,
) -> Result<Row> {
    let own = setting(arguments, flags)?;
    let shading: Shading = own.optics.for_pictures(&own.colour)?;
    let (mut painter, what, cost, directions) = stage.prepare(&own, &shading)?;
    let exact = references.of(stage, &shading, &directions)?;
    let series = match what.method {
        "spectral" => format!("spectral, {}", own.optics.basis_of_pictures().name()),
        other => other.to_owned(),
    };
    Ok(Row {
        frame: frame.to_owned(),
        flags: flags.to_owned(),
        series,
        terms: what.terms,
        layers: what.layers,
        kernel: what.kernel,
        wavelengths: cost.wavelengths_per_pixel(),
        samples: cost.samples_per_pixel(),
        ..row(stage, &mut painter, exact)?
    })
}

/// What `painter` takes for the frame, and how far its picture is from the `exact` one.
pub fn row(stage: &Stage, painter: &mut Painter, exact: &Exact) -> Result<Row> {
    let times = measure(painter, &stage.view, FRAMES, SECONDS, &|_, _| Ok(()))?;
    let picture = painter.paint(&stage.view, stage.scene.exposure, stage.scene.background)?;
    let errors = PixelErrors::of(&shown(&picture, &exact.pixels), &exact.colors, stage.scene.exposure);
    Ok(Row {
        frame_ms: times.frame.p50,
        fastest_ms: times.frame.min,
        gpu_ms: times.gpu.p50,
        spread: times.spread,
        relative_l2: errors.relative_l2,
        p99: errors.p99,
        flip: stage.seen(&picture, &exact.pixels, &exact.colors),
        ..Row::default()
    })
}

/// A short name of everything that two runs have to share for their rows to be comparable.
fn frame_key(arguments: &Arguments, stage: &Stage) -> String {
    let candidate = stage.device.candidate();
    let mut hasher = blake3::Hasher::new();
    let words = format!(
        "{} {:?} {} {} {} {:?} {:?} {:?} {} {}",
        env!("CARGO_PKG_VERSION"),
        arguments.coherence,
        arguments.ior,
        arguments.illuminant,
        arguments.scene,
        stage.size,
        stage.view,
        stage.field.pixel_size(),
        candidate.name,
        candidate.driver
    );
    hasher.update(words.as_bytes());
    hasher.update(bytemuck::cast_slice(stage.field.heights()));
    hasher.finalize().to_hex()[..16].to_owned()
}

fn read_rows(path: &Path, frame: &str) -> Vec<Row> {
    let small = std::fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() <= LONGEST);
    let text = if small { std::fs::read_to_string(path).unwrap_or_default() } else { String::new() };
    let rows = trade::rows_of(&text, frame);
    if !rows.is_empty() {
        say(&format_args!("{} settings are taken from {}", rows.len(), path.display()));
    }
    rows
}

fn heading(arguments: &Arguments, stage: &Stage, rows: &[Row]) -> String {
    let candidate = stage.device.candidate();
    let [width, height] = stage.size;
    let noisy = rows.iter().filter(|row| row.spread > profile::NOISY).count();
    let noise = match noisy {
        0 => String::new(),
        n => format!(" The machine was too noisy to tell the times of {n} of {} settings.", rows.len()),
    };
    format!(
        "{}, {width} x {height} pixels, {} light(s), on {}, {}. Errors against the f64 reference of the same directions.{noise}",
        arguments.scene,
        stage.view.lights.len(),
        candidate.name,
        candidate.driver,
    )
}
