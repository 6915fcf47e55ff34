//! `diffract surface`: what is in a height field, other formats of it, and generated ones.

mod convert;
mod report;

use super::options::{SurfaceOptions, seed};
use super::write;
use crate::error::{Error, Result};
use crate::expansion::HeightScale;
use crate::expansion::taylor::{F32_ROUNDOFF, terms_for, thesis_bound};
use crate::optics::sampling;
use crate::optics::spectrum::SHORTEST;
use crate::precompute::layers::largest_z;
use crate::surface::files::{Topography, image};
use crate::surface::synth::{self, Kind, Spec};
use crate::surface::{HeightField, Level, Statistics};
use crate::{output, units};
use clap::{Args, Subcommand};
use std::ffi::OsString;
use std::path::PathBuf;

/// What to do with a surface.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// What is in a height field, and what it will cost
    Info(Info),
    /// Write a height field in another format, heights unchanged
    Convert(convert::Convert),
    /// Write a generated height field to a PNG or TIFF file
    Synth(Synth),
}

/// Arguments of `surface info`.
#[derive(Args, Debug)]
pub struct Info {
    /// Height field: a file or a built-in name
    surface_name: Option<OsString>,
    /// Print samples, spacing_m, height_range_m, mean_m, rms_m, invalid and channels as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    surface: SurfaceOptions,
}

/// Arguments of `surface synth`.
#[derive(Args, Debug)]
#[command(after_help = "Example:
  diffract surface synth elaphe --seed 7 -o skin.png      prints the options that read it back")]
pub struct Synth {
    /// flat, sinusoid, blaze, bumps, elaphe or xenopeltis
    #[arg(value_parser = kind)]
    kind: Kind,
    /// Where it goes: .png or .tif, 16-bit grey
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Which one of the many skins of one kind
    #[arg(long, value_name = "N", value_parser = seed, allow_hyphen_values = true, default_value = "1")]
    seed: u64,
    /// Side of the patch, rounded to whole periods, as in 20um or 20umx10um
    #[arg(long, value_name = "LENGTH", value_parser = units::length_pair, allow_hyphen_values = true)]
    patch: Option<[f64; 2]>,
    /// Largest distance between samples
    #[arg(long, value_name = "LENGTH", value_parser = units::length_pair, allow_hyphen_values = true)]
    pixel_size: Option<[f64; 2]>,
    /// Period along x
    #[arg(long, value_name = "LENGTH", value_parser = units::length, allow_hyphen_values = true)]
    period: Option<f64>,
    /// Full height
    #[arg(long, value_name = "LENGTH", value_parser = units::length, allow_hyphen_values = true)]
    height: Option<f64>,
}

fn kind(name: &str) -> Result<Kind> {
    let known = Kind::ALL.map(Kind::name).join(", ");
    Kind::from_name(name).ok_or_else(|| {
        Error::usage(format!("there is no generated surface `{name}`"), format!("give one of {known}"))
    })
}

/// Runs a command about surfaces.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::Info(arguments) => info(arguments),
        Command::Convert(arguments) => convert::run(arguments),
        Command::Synth(arguments) => synthesise(arguments),
    }
}

fn info(arguments: &Info) -> Result<()> {
    let source = arguments.surface.source(arguments.surface_name.as_deref(), None, "elaphe")?;
    let scan = arguments.surface.read(&source)?;
    if !arguments.json {
        let file: String =
            report::lines(&scan).iter().map(|(name, value)| format!("{name:<26}{value}\n")).collect();
        return write::stdout(&(file + &describe(&source.prepare(scan.into_field()?)?)));
    }
    let (origin, invalid) = (scan.origin().cloned(), scan.missing());
    let scan = match source.level {
        Level::None => scan,
        _ => Topography::of(source.prepare(scan.into_field()?)?),
    };
    write::stdout(&report::Report::of(&scan, origin.as_ref(), invalid).json()?)
}

fn synthesise(arguments: &Synth) -> Result<()> {
    let &Synth { kind, seed, patch, pixel_size, period, height, output: ref path } = arguments;
    output::check(path)?;
    let field = synth::generate(&Spec { kind, seed, patch, pixel_size, period, height })?;
    // A flat field has code 0 all over: every height reads it back, and an option takes none of zero.
    let full_height = Some(image::write(path, &field)?).filter(|h| *h > 0.0).unwrap_or(1e-3);
    let [dx, dy] = field.pixel_size();
    let [columns, rows] = [field.columns(), field.rows()];
    // Enough digits that the file read back has the same frequencies to a millionth.
    let options =
        format!("--pixel-size {:.7}nmx{:.7}nm --height {:.7}nm", dx * 1e3, dy * 1e3, full_height * 1e3);
    write::stdout(&format!("{}: {columns} x {rows} samples; read it with {options}\n", path.display()))
}

/// The numbers of a height field, for reading by eye.
fn describe(field: &HeightField) -> String {
    let s = Statistics::of(field);
    let nm = |x: f64| format!("{:.1} nm", x * 1e3);
    let pair =
        |[x, y]: [f64; 2], unit: &str, factor: f64| format!("{:.4} x {:.4} {unit}", x * factor, y * factor);
    let period = |p: Option<f64>| p.map_or("none found".to_owned(), |p| format!("{p:.3} um"));
    let mut lines = vec![
        ("samples", format!("{} x {}", s.samples[0], s.samples[1])),
        ("spacing", pair(s.pixel_size, "nm", 1e3)),
        ("patch", pair(s.patch_size, "um", 1.0)),
        ("height range", format!("{} ({} to {})", nm(s.range.1 - s.range.0), nm(s.range.0), nm(s.range.1))),
        ("mean, RMS roughness", format!("{}, {}", nm(s.mean), nm(s.roughness))),
        ("distinct heights", s.levels.to_string()),
        ("beyond 3 sigma", format!("{:.2} %", s.outliers * 100.0)),
        ("period along x, y", format!("{}, {}", period(s.period[0]), period(s.period[1]))),
        ("holds frequencies to", pair(s.largest_frequency, "1/um", 1.0)),
    ];
    let held = sampling::limit(s.pixel_size, SHORTEST).map_or("all".to_owned(), |limit| {
        format!("|{}| up to {:.2}; all need {} between samples", limit.axis, limit.largest, nm(limit.needed))
    });
    lines.push(("directions held at 380 nm", held));
    let half_range = HeightScale::of(field).half_range;
    let x = largest_z(SHORTEST) * half_range;
    lines.push(("largest phase k|w|a", format!("{x:.2}")));
    for tolerance in [1e-1, 1e-2, 1e-3, 1e-4] {
        let bound = match terms_for(x, tolerance, F32_ROUNDOFF) {
            Ok(terms) => {
                let thesis = (1..=4096).find(|&n| thesis_bound(2.0 * x, n - 1) <= tolerance);
                let thesis = thesis.map_or("more than 4096".to_owned(), |n| n.to_string());
                format!("{terms} terms (tight bound, centred; the thesis' bound asks for {thesis})")
            }
            Err(_) => "not in 32-bit floats".to_owned(),
        };
        lines.push(("taylor", format!("sup error {tolerance:.0e}: {bound}")));
    }
    lines.iter().map(|(name, value)| format!("{name:<26}{value}\n")).collect()
}
