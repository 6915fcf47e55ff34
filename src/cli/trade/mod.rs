//! `diffract trade`: speed against accuracy, measured over many settings.

mod baselines;
mod figure;

pub use figure::figure;

use super::benchmark::{BenchmarkOptions, BenchmarkScene, References, TimingLimits, fps, is_impossible};
use super::console::Console;
use super::options::{
    CacheOptions, DeviceOptions, FigureOptions, MeshOptions, SurfaceOptions, coherence, ior, tolerance,
};
use super::progress::ProgressBar;
use super::remedies::in_options;
use super::{captions, prepare, write};
use crate::error::{Error, Result};
use crate::figure::FigureStyle;
use crate::files::Files;
use crate::measure::profile::NOISY;
use crate::measure::trade::{self, GRATING, Measurement, THESIS};
use crate::optics::coherence::Coherence;
use crate::optics::spectrum::Illuminant;
use crate::scene::{Light, SceneOverrides};
use crate::task::Progress;
use crate::{input, output, units};
use baselines::Baselines;
use clap::{Args, Parser};
use std::ffi::OsString;
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
    /// snake, plate, sphere, disc, cd, skin, a scene file (.toml) or a mesh (.obj, .gltf, .glb, .ply, .stl)
    #[arg(default_value = "snake")]
    scene: OsString,
    /// Folder for the results; created if it is missing
    #[arg(short = 'o', long, alias = "output", value_name = "DIR")]
    folder: PathBuf,
    /// Fewer settings and a smaller picture
    #[arg(long)]
    quick: bool,
    /// Width and height in pixels [default: 640x480, with --quick 320x240]
    #[arg(long, value_name = "WxH", value_parser = units::size, allow_hyphen_values = true)]
    size: Option<[u32; 2]>,
    /// A light instead of the scene's, in degrees from up and around it; may be given several times
    #[arg(long, value_name = "[KIND:]THETA,PHI[,INTENSITY]", value_parser = Light::parse, allow_hyphen_values = true)]
    light: Vec<Light>,
    #[command(flatten)]
    mesh: MeshOptions,
    /// Print the fastest setting that keeps this relative L2 error
    #[arg(long, value_name = "E", value_parser = tolerance, allow_hyphen_values = true)]
    tolerance: Option<f64>,
    /// Print the most accurate setting that keeps this frame rate
    #[arg(long, value_name = "F", value_parser = fps, allow_hyphen_values = true)]
    fps: Option<f64>,
    /// Coherence of the light: gaussian:LENGTH or grating:NxM
    #[arg(long, value_name = "KIND", value_parser = coherence, default_value = "gaussian:65um", hide_short_help = true)]
    coherence: Coherence,
    /// Refractive index of the surface
    #[arg(long, value_name = "N", value_parser = ior, allow_hyphen_values = true, default_value = "1.5", hide_short_help = true)]
    ior: f64,
    /// Spectrum of the light: d65, d50, a, e, led, or a CSV file of wavelength in nm and power
    #[arg(long, value_name = "NAME|FILE", default_value = "d65", hide_short_help = true)]
    illuminant: OsString,
    #[command(flatten)]
    figure: FigureOptions,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    cache: CacheOptions,
}

/// Options of a setting as a command line.
#[derive(Parser, Debug)]
struct SettingLine {
    #[command(flatten)]
    options: BenchmarkOptions,
}

/// Names of the files of a sweep.
const FILES: [&str; 4] = ["trade.csv", "trade.md", "trade.svg", "trade.png"];
/// Timing of each setting.
const LIMITS: TimingLimits = TimingLimits { frames: 9, seconds: 3.0 };

/// Measures the settings and writes the results.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let console = &arguments.device.chosen(&arguments.cache.limited(console));
    if arguments.folder.as_os_str().is_empty() {
        return Err(Error::usage("--folder: the name is empty", "give the results a folder"));
    }
    let style = arguments.figure.style(true, &figure::PANELS)?;
    let mut sweep = TradeSweep::open(arguments, console)?;
    sweep.measure_settings()?;
    sweep.measure_baselines()?;
    prepare::finish(console, &sweep.scene.device)?;
    sweep.report(&style)
}

/// Sweep in progress.
struct TradeSweep<'a> {
    arguments: &'a Arguments,
    scene: BenchmarkScene,
    // See `Measurement::frame`.
    frame: String,
    references: References,
    rows: Vec<Measurement>,
    // Settings that cannot be drawn here, with the reason.
    impossible: Vec<(String, String)>,
}

impl<'a> TradeSweep<'a> {
    /// Opens the scene, and reads the rows of a sweep that was interrupted.
    fn open(arguments: &'a Arguments, console: &Console) -> Result<Self> {
        let scene = BenchmarkScene::open(&setting(arguments, "")?, console)?;
        // The folder is made when there is something to write.
        if arguments.folder.exists() {
            let illuminant = Some(&arguments.illuminant).filter(|name| !Illuminant::is_built_in(name));
            Files::new()
                .reads([&arguments.scene])
                .reads(arguments.surface.files(None))
                .reads(illuminant)
                .reads(&scene.scene.files)
                .writes(FILES.map(|name| arguments.folder.join(name)))
                .check()?;
        }
        let frame = frame_key(arguments, &scene);
        let rows = read_rows(&arguments.folder.join("trade.csv"), &frame, console)?;
        let (references, impossible) = (References::default(), Vec::new());
        Ok(Self { arguments, scene, frame, references, rows, impossible })
    }

    fn file(&self, name: &str) -> PathBuf {
        self.arguments.folder.join(name)
    }

    /// Adds a row and writes all rows, so that an interrupted sweep can be continued.
    fn add(&mut self, row: Measurement) -> Result<()> {
        self.rows.push(row);
        let folder = &self.arguments.folder;
        std::fs::create_dir_all(folder).map_err(|e| output::write_failed(folder, e))?;
        write::file(&self.file("trade.csv"), &trade::csv(&self.rows)?)
    }

    fn measure_settings(&mut self) -> Result<()> {
        let settings = settings(self.arguments.quick);
        let bar = ProgressBar::new(&self.scene.console, "settings", "--quick");
        let count = settings.len();
        for (done, flags) in settings.into_iter().enumerate() {
            bar.show(&Progress { stage: "settings", done, of: count });
            if self.rows.iter().any(|row| row.flags == flags) {
                continue;
            }
            match self.measure(&flags) {
                Ok(row) => self.add(row)?,
                Err(error) if is_impossible(&error) => self.impossible.push((flags, in_options(&error))),
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn measure(&mut self, flags: &str) -> Result<Measurement> {
        let options = setting(self.arguments, flags)?;
        let mut benchmark = self.scene.prepare(&options)?;
        let exact = self.references.of(&self.scene, &benchmark.optics, &benchmark.directions)?;
        let measured = self.scene.measure(&mut benchmark.renderer, exact, LIMITS)?;
        let (summary, cost) = (benchmark.summary, benchmark.cost);
        let series = match summary.method {
            "spectral" => format!("spectral, {}", options.optics.basis_of_pictures().name()),
            other => other.to_owned(),
        };
        Ok(Measurement {
            frame: self.frame.clone(),
            flags: flags.to_owned(),
            series,
            terms: summary.terms,
            layers: summary.layers,
            kernel: summary.kernel,
            wavelengths: cost.wavelengths_per_pixel(),
            samples: cost.samples_per_pixel(),
            promised: benchmark.optics.promised_of_one_sample().unwrap_or(0.0),
            ..measured
        })
    }

    /// Measures the baselines, after the settings: without a setting there is nothing to compare.
    fn measure_baselines(&mut self) -> Result<()> {
        for series in [GRATING, THESIS] {
            if self.rows.is_empty() || self.rows.iter().any(|row| row.series == series) {
                continue;
            }
            let options = setting(self.arguments, "--windows 1x1 --tolerance 1e-1")?;
            let baselines = Baselines { scene: &self.scene, options: &options, limits: LIMITS };
            match baselines.measure(series, &mut self.references) {
                Ok(None) => {}
                Ok(Some(row)) => self.add(Measurement { frame: self.frame.clone(), ..row })?,
                Err(error) if is_impossible(&error) => {
                    self.impossible.push((series.to_owned(), in_options(&error)));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Writes table and plot, and prints the advice.
    fn report(&self, style: &FigureStyle) -> Result<()> {
        if self.rows.is_empty() {
            let why = self.impossible.first().map_or("", |(_, why)| why);
            return Err(Error::limit(
                format!("no setting could be measured: {why}"),
                "see `diffract trade --help`",
            ));
        }
        let (rows, heading) = (&self.rows, self.heading());
        let notes = captions::notes(&self.scene.field, &self.scene.console);
        let table = trade::markdown(rows, &heading, &self.impossible);
        write::file(&self.file("trade.md"), &format!("{table}\n```text\n{}\n```\n", notes.text()))?;
        let figure = figure(rows, "Speed against accuracy", &heading);
        figure.save(&self.file("trade.svg"), style, &notes)?;
        figure.save(&self.file("trade.png"), style, &notes)?;
        let wanted = match (self.arguments.tolerance, self.arguments.fps) {
            (None, None) => String::new(),
            (error, fps) => trade::wanted(rows, error, fps),
        };
        self.scene.console.write(&format!("{heading}\n{}{wanted}", trade::advice(rows)))
    }

    fn heading(&self) -> String {
        let candidate = self.scene.device.candidate();
        let [width, height] = self.scene.size;
        let noisy = self.rows.iter().filter(|row| row.spread > NOISY).count();
        let noise = match noisy {
            0 => String::new(),
            n => format!(
                " The times of {n} of {} settings are unreliable: the machine was busy.",
                self.rows.len()
            ),
        };
        format!(
            "{}, {width} x {height} pixels, {} light(s), on {}, {}. Errors against the f64 reference of the same directions.{noise}",
            self.arguments.scene.display(),
            self.scene.view.light_count(),
            candidate.name,
            candidate.driver,
        )
    }
}

/// Returns the settings of a sweep: tables and one window by each basis over tolerances, then some over numbers of terms.
fn settings(quick: bool) -> Vec<String> {
    let tables: &[&str] = if quick { &["1e-1", "2e-2", "1e-2"] } else { &["1e-1", "5e-2", "2e-2", "1e-2"] };
    let windows: &[&str] =
        if quick { &["1e-1", "1e-2"] } else { &["2e-1", "1e-1", "3e-2", "1e-2", "3e-3", "1e-3"] };
    let mut all: Vec<String> = tables.iter().map(|e| format!("--method table --tolerance {e}")).collect();
    for basis in ["optimal", "taylor"] {
        all.extend(windows.iter().map(|e| format!("--windows 1x1 --basis {basis} --tolerance {e}")));
    }
    if quick {
        return all;
    }
    all.push("--windows 1x1 --basis taylor --terms 37 --wavelengths 81".to_owned());
    for terms in [4, 6, 8, 12, 16] {
        all.extend(
            ["taylor", "optimal"].map(|basis| format!("--windows 1x1 --basis {basis} --terms {terms}")),
        );
    }
    all
}

/// Returns the options of a setting: `flags` on the frame of `arguments`.
fn setting(arguments: &Arguments, flags: &str) -> Result<BenchmarkOptions> {
    let line = SettingLine::try_parse_from(std::iter::once("trade").chain(flags.split_whitespace()));
    let mut options = line
        .map_err(|e| {
            let text = e.to_string();
            let first = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
            Error::usage(first.to_owned(), "leave it to a version of diffract that knows it")
        })?
        .options;
    options.optics.coherence = arguments.coherence;
    options.optics.surface_reflectance.ior = Some(arguments.ior);
    options.colour.illuminant.clone_from(&arguments.illuminant);
    let size = arguments.size.unwrap_or(if arguments.quick { [320, 240] } else { [640, 480] });
    Ok(BenchmarkOptions {
        scene: arguments.scene.clone(),
        size,
        light: arguments.light.clone(),
        mesh: arguments.mesh.clone(),
        surface: arguments.surface.clone(),
        device: arguments.device.clone(),
        cache: arguments.cache,
        ..options
    })
}

/// Returns a hash of everything that two runs must share for their measurements to be comparable.
fn frame_key(arguments: &Arguments, scene: &BenchmarkScene) -> String {
    let candidate = scene.device.candidate();
    let mut hasher = blake3::Hasher::new();
    let key = format!(
        "{} {:?} {} {} {} {:?} {:?} {:?} {} {}",
        env!("CARGO_PKG_VERSION"),
        arguments.coherence,
        arguments.ior,
        arguments.illuminant.display(),
        arguments.scene.display(),
        scene.size,
        scene.view,
        scene.field.pixel_size(),
        candidate.name,
        candidate.driver
    );
    hasher.update(key.as_bytes());
    if scene.scene.overrides != SceneOverrides::default() {
        hasher.update(format!("{:?}", scene.scene.overrides).as_bytes());
    }
    hasher.update(bytemuck::cast_slice(scene.field.heights()));
    hasher.finalize().to_hex()[..16].to_owned()
}

/// Reads the measurements of `frame` from the file `path`; none if there is no such file.
fn read_rows(path: &Path, frame: &str, console: &Console) -> Result<Vec<Measurement>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let rows = trade::from_csv(&input::read_text(path, "another folder, or remove this file")?, frame);
    if !rows.is_empty() {
        console.say(&format_args!("{} settings are taken from {}", rows.len(), path.display()));
    }
    Ok(rows)
}
