//! `diffract surface`: what is in a height field, and generated ones.

mod describe;
mod plot;
#[cfg(test)]
mod worked_example;

use super::options::{SurfaceOptions, seed};
use super::write;
use crate::error::{Error, Result};
use crate::figure;
use crate::surface::synth::{self, Kind, Spec};
use crate::surface::{Statistics, image_file};
use crate::{output, units};
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// What to do with a surface.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// What is in a height field, and what it will cost
    Info(Info),
    /// Write a generated height field to a PNG or TIFF file
    Synth(Synth),
}

/// Arguments of `surface info`.
#[derive(Args, Debug)]
#[command(after_help = "Example:
  diffract surface info scan.png --pixel-size 97.66nm --height 434.7nm --level plane --crop 40um --plot scan.svg")]
pub struct Info {
    /// Height field: a file or a built-in name
    surface_name: Option<String>,
    #[command(flatten)]
    surface: SurfaceOptions,
    /// A figure of the heights, a profile, the spectrum and the distributions: .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
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

/// Runs `surface info` or `surface synth`.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::Info(arguments) => {
            if let Some(path) = &arguments.plot {
                figure::Format::of(path)?;
                output::check(path)?;
            }
            let source = arguments.surface.source(arguments.surface_name.as_deref(), None, "elaphe")?;
            let field = source.load()?;
            let statistics = Statistics::of(&field)?;
            if let Some(path) = &arguments.plot {
                plot::figure(&source, &field, &statistics)?.save(path)?;
            }
            write::stdout(&describe::text(&source, &field, &statistics)?)
        }
        Command::Synth(arguments) => synthesise(arguments),
    }
}

fn synthesise(arguments: &Synth) -> Result<()> {
    let &Synth { kind, seed, patch, pixel_size, period, height, output: ref path } = arguments;
    output::check(path)?;
    let field = synth::generate(&Spec { kind, seed, patch, pixel_size, period, height })?;
    // A flat field has code 0 all over: every height reads it back, and an option takes none of zero.
    let full_height = Some(image_file::write(path, &field)?).filter(|h| *h > 0.0).unwrap_or(1e-3);
    let [dx, dy] = field.pixel_size();
    let [columns, rows] = [field.columns(), field.rows()];
    // Enough digits that the file read back has the same frequencies to a millionth.
    let options =
        format!("--pixel-size {:.7}nmx{:.7}nm --height {:.7}nm", dx * 1e3, dy * 1e3, full_height * 1e3);
    write::stdout(&format!("{}: {columns} x {rows} samples; read it with {options}\n", path.display()))
}
