//! `diffract surface`: statistics of height fields, conversion of formats, and generated surfaces.

mod compare;
mod convert;
mod formula;
mod report;

pub(super) mod describe;
mod hemisphere;
pub(super) mod plot;
#[cfg(test)]
mod worked_example;

use super::captions;
use super::console::Console;
use super::options::{self, FigureOptions, SurfaceOptions, seed};
use super::remedies::in_options;
use crate::cli::progress::surface_task;
use crate::error::{Error, Result};
use crate::figure::{self, FigureStyle};
use crate::files::Files;
use crate::notes::Notes;
use crate::optics::material::Material;
use crate::optics::polarisation::Polarisation;
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::Illuminant;
use crate::optics::surface_report::SurfaceReport;
use crate::optics::theory::Theory;
use crate::optics::validity::{LightColour, ScalarTheory};
use crate::surface::files::write::ScanFormat;
use crate::surface::files::{Topography, image};
use crate::surface::synth::{self, Spec, SurfaceKind};
use crate::surface::{HeightField, Statistics, SurfaceSource};
use crate::{output, units};
use clap::builder::{OsStringValueParser, TypedValueParser};
use clap::{Args, Subcommand};
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

/// Commands about a surface.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Statistics of a height field, and the cost of its optics
    Info(Box<Info>),
    /// Statistics and predicted colours of several height fields beside each other
    Compare(Box<compare::CompareArguments>),
    /// Write a height field, prepared if asked, in another format
    Convert(convert::Convert),
    /// Write a generated height field to a file
    Synth(Synth),
}

/// Arguments of `surface info`.
#[derive(Args, Debug)]
#[command(after_help = "Example:
  diffract surface info scan.png --pixel-size 48.83nm --height 434.7nm --level plane --crop 40um --plot scan.svg")]
pub struct Info {
    /// Height field: a file or a built-in name; several are described one after the other
    surface_names: Vec<OsString>,
    /// Print samples, spacing_m, height_range_m, mean_m, rms_m, invalid, channels and statistics as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    surface: SurfaceOptions,
    /// Material of the surface, for the errors of scalar theory: as in `render` [default: refractive index 1.5]
    #[arg(long, value_name = "NAME|FILE", value_parser = OsStringValueParser::new().try_map(Material::from_name_or_file))]
    material: Option<Material>,
    /// Spectrum of the light, for the errors of scalar theory: d65, d50, a, e, led, or a CSV file of wavelength in nm and power
    #[arg(long, value_name = "NAME|FILE", value_parser = OsStringValueParser::new().try_map(Illuminant::from_name_or_file), default_value = "d65")]
    illuminant: Illuminant,
    /// Polarisation of the light, for the errors of scalar theory: te (along the grooves), tm (across them) or none [default: none]
    #[arg(long, value_name = "te|tm|none", value_parser = Polarisation::from_name)]
    polarisation: Option<Polarisation>,
    /// Theory whose errors are told: small-slope or stam, as in `render` [default: small-slope]
    #[arg(long, value_name = "small-slope|stam", value_parser = Theory::from_name)]
    theory: Option<Theory>,
    /// Draw a figure of the heights, profiles, spectra, distributions and the predicted colours: .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    figure: FigureOptions,
}

/// Arguments of `surface synth`.
#[derive(Args, Debug)]
#[command(after_help = "Example:
  diffract surface synth elaphe --seed 7 -o skin.png      prints the options that read it back
  diffract surface synth lamellar --duty 0.4 --flank 50nm -o lines.gsf
  diffract surface synth --profile '0.15 if x < 0.5 else 0' --period 2um -o steps.gsf")]
pub struct Synth {
    /// flat, sinusoid, blaze, lamellar, bumps, elaphe, xenopeltis, cd, dvd, brushed or tulip
    #[arg(value_parser = kind, required_unless_present = "profile")]
    kind: Option<SurfaceKind>,
    /// A grating whose profile is a formula instead: heights in micrometres over x, from 0 to 1 in each period, as in '0.1*sin(6.2832*x)' or '0.15 if x < 0.5 else 0'
    #[arg(long, value_name = "FORMULA", allow_hyphen_values = true, conflicts_with_all = ["kind", "duty", "flank"])]
    profile: Option<String>,
    /// Output file: .png or .tif, 16-bit grey; .gsf, 32-bit floats; .gwy, .npy, .txt or .x3p, every digit
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Seed of a random surface
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
    /// Width of the ridges of a lamellar grating at half of their height, over the period
    #[arg(long, value_name = "SHARE", value_parser = duty, allow_hyphen_values = true)]
    duty: Option<f64>,
    /// Width of the flanks of a lamellar grating, as in 50nm; 0nm for upright ones
    #[arg(long, value_name = "LENGTH", value_parser = flank, allow_hyphen_values = true)]
    flank: Option<f64>,
}

fn duty(text: &str) -> Result<f64> {
    options::real(text, (0.0, 1.0), "share of a period")
}

fn flank(text: &str) -> Result<f64> {
    options::length_within(text, (0.0, 1e3), "width of a flank")
}

fn kind(name: &str) -> Result<SurfaceKind> {
    let known = SurfaceKind::ALL.map(SurfaceKind::name).join(", ");
    SurfaceKind::from_name(name).ok_or_else(|| {
        Error::usage(format!("there is no generated surface `{name}`"), format!("give one of {known}"))
    })
}

/// Runs a command about surfaces.
pub fn run(command: &Command, console: &Console) -> Result<()> {
    match command {
        Command::Info(arguments) => info(arguments, console),
        Command::Compare(arguments) => compare::run(arguments, console),
        Command::Convert(arguments) => convert::run(arguments, console),
        Command::Synth(arguments) => synthesise(arguments, console),
    }
}

impl Info {
    /// Returns the reflectance that the options ask for.
    fn reflectance(&self) -> Reflectance {
        let material = self.material.clone();
        let unpolarised = material.map_or_else(Reflectance::default, |m| Reflectance::of_material(m, None));
        unpolarised.polarised(self.polarisation.unwrap_or_default()).by(self.theory.unwrap_or_default())
    }

    /// Returns the errors of scalar theory for `field` in the light that the options name.
    fn scalar_theory(&self, field: &HeightField) -> Result<ScalarTheory> {
        ScalarTheory::of_field(field, &self.reflectance(), LightColour::Spectrum(&self.illuminant))
    }
}

/// Describes the height fields that the options name, or the default one.
fn info(arguments: &Info, console: &Console) -> Result<()> {
    if let Some(path) = &arguments.plot {
        figure::FigureFormat::of(path)?;
    }
    let style = arguments.figure.style(arguments.plot.is_some(), &plot::PANELS)?;
    let names = &arguments.surface_names;
    if names.len() > 1 && arguments.plot.is_some() {
        return Err(Error::usage("a figure is of one surface", "name one, or leave --plot away"));
    }
    if let Some(note) = arguments.material.as_ref().and_then(Material::note) {
        console.say(&note);
    }
    let material = arguments.reflectance().file();
    let files = names.iter().map(OsString::as_os_str).map(Some).chain(names.is_empty().then_some(None));
    for name in files.clone() {
        let read = arguments.surface.files(name);
        Files::new().reads(read).reads(&material).writes(&arguments.plot).check()?;
    }
    let mut described = Vec::new();
    let mut failed = Vec::new();
    for name in files {
        match describe(arguments, &style, name, console) {
            Ok(text) => described.push(text),
            Err(e) if names.len() > 1 => failed.push(e),
            Err(e) => return Err(e),
        }
    }
    let text = match (arguments.json, names.len()) {
        (true, 2..) => format!(
            "[\n{}\n]\n",
            described.iter().map(|text| text.trim_end()).collect::<Vec<_>>().join(",\n")
        ),
        _ => described.join("\n"),
    };
    console.write(&text)?;
    failed.iter().for_each(|e| console.print(&in_options(e)));
    match failed.len() {
        0 => Ok(()),
        count => Err(Error::input(
            format!("{count} of {} surfaces are not described", names.len()),
            "see the lines above",
        )),
    }
}

/// Describes the height field of this `name` as text or as JSON, and draws it.
fn describe(
    arguments: &Info,
    style: &FigureStyle,
    name: Option<&OsStr>,
    console: &Console,
) -> Result<String> {
    let source = arguments.surface.source(name, None, "elaphe")?;
    let scan = arguments.surface.read(&source, console)?;
    if arguments.json {
        return report(arguments, style, &source, scan, console);
    }
    let title = if arguments.surface_names.len() > 1 {
        format!("{}\n", source.name.display())
    } else {
        String::new()
    };
    let file: String =
        report::lines(&scan).iter().map(|(name, value)| format!("{name:<26}{value}\n")).collect();
    let task = surface_task(console);
    let field = source.prepare(scan.into_field()?, &task)?;
    let statistics = Statistics::of(&field, &task)?;
    let theory = arguments.scalar_theory(&field)?;
    if let Some(path) = &arguments.plot {
        let drawn = plot::figure(&source, &field, &statistics, &theory, console)?;
        drawn.save(path, style, &captions::notes(&field, console))?;
    }
    Ok(title + &file + &describe::text(&field, &statistics, &theory)?)
}

/// Returns the report as JSON. Without preparation steps it is about the heights of the file, including gaps.
fn report(
    arguments: &Info,
    style: &FigureStyle,
    source: &SurfaceSource,
    scan: Topography,
    console: &Console,
) -> Result<String> {
    let (origin, invalid) = (scan.origin().cloned(), scan.missing());
    let task = surface_task(console);
    let scan = if source.prepare.is_empty() {
        scan
    } else {
        Topography::of(source.prepare(scan.into_field()?, &task)?)
    };
    let notes = Notes::new(captions::own_command(console), scan.prepared());
    let report = SurfaceReport::new(&source.name, &scan, origin.as_ref(), invalid);
    let field = match scan.into_field() {
        Ok(field) => field,
        Err(e) if arguments.plot.is_none() => return report::json(&report.without_statistics(&e), &notes),
        Err(e) => return Err(e),
    };
    let statistics = Statistics::of(&field, &task)?;
    let theory = arguments.scalar_theory(&field)?;
    if let Some(path) = &arguments.plot {
        plot::figure(source, &field, &statistics, &theory, console)?.save(path, style, &notes)?;
    }
    report::json(&report.with_statistics(&field, statistics, theory)?, &notes)
}

fn synthesise(arguments: &Synth, console: &Console) -> Result<()> {
    let &Synth { seed, patch, pixel_size, period, height, duty, flank, output: ref path, .. } = arguments;
    output::check(path)?;
    let format = if image::is_named(path) { None } else { Some(ScanFormat::of(path)?) };
    let kind = arguments.kind.unwrap_or(SurfaceKind::Lamellar);
    let spec = Spec { kind, seed, patch, pixel_size, period, height, duty, flank };
    let field = match &arguments.profile {
        Some(formula) => formula::grating(formula, &spec)?,
        None => synth::generate(&spec)?,
    };
    if let Some(format) = format {
        return convert::save(path, format, &Topography::of(field), console);
    }
    // A flat field has code 0 all over: any height reads it back, and the option takes no zero.
    let full_height = Some(image::write(path, &field)?).filter(|h| *h > 0.0).unwrap_or(1e-3);
    let [dx, dy] = field.pixel_size();
    let [columns, rows] = [field.columns(), field.rows()];
    // Enough digits that the file read back has the same frequencies to a millionth.
    let options =
        format!("--pixel-size {:.7}nmx{:.7}nm --height {:.7}nm", dx * 1e3, dy * 1e3, full_height * 1e3);
    console.write(&format!("{}: {columns} x {rows} samples; read it with {options}\n", path.display()))
}
