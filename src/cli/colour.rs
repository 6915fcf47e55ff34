//! `diffract colour`: what a multi-angle spectrophotometer reads of a surface.

mod figure;
mod geometry;
pub(super) mod readings;

use super::console::Console;
use super::options::{
    CacheOptions, ColourOptions, DeviceOptions, FigureOptions, OpticsOptions, SurfaceOptions, real,
};
use super::{captions, evaluation, write};
use crate::error::{Error, Result};
use crate::figure::FigureFormat;
use crate::files::Files;
use crate::optics::spectrum::Illuminant;
use crate::units;
use clap::Args;
use figure::ColourFigure;
use geometry::NamedGeometry;
use glam::DVec3;
use readings::{AngleReading, Detector, wavelengths};
use serde::Serialize;
use std::borrow::Cow;
use std::f64::consts::PI;
use std::ffi::OsString;
use std::path::PathBuf;

/// Largest full angle of an aperture \[degrees\].
const WIDEST: f64 = 30.0;
/// Most geometries of one call.
const MOST_GEOMETRIES: usize = 1000;

/// Arguments of `colour`.
#[derive(Args, Debug)]
#[command(
    after_help = "An aspecular angle is that from the mirror direction of the light toward the light, in the plane of incidence: with the \
light at 45 degrees, 45 looks straight down (45/0).

Named geometries: 45/0 (CIE 15); e2194 (ASTM E2194, metallic paint: 45as15, 45as45, 45as110); e2539 (ASTM E2539, interference \
pigments: 45as-15, 45as15, 45as25, 45as45, 45as75, 45as110, 15as-15, 15as15).

The answer is CSV, a row for each direction of view: aspecular [degrees], empty for --view; theta_i, phi_i, theta_r, phi_r [degrees]; X, Y, Z of \
the radiance factor, where a white diffuse surface has Y = 100; L, a, b, CIELAB under the white of the illuminant; srgb, as a display shows \
it, adapted to its white. 2 degree observer, CIE 1931.

Examples:
  diffract colour cd --geometry e2539 --illuminant d50 --plot cd.svg
  diffract colour elaphe --light 45 --aspecular -15,15,25,45,75,110 --aperture 2deg -o colours.csv
  diffract colour blaze --light 30,0 --view 0,0 --view 10,180 --spectrum spectra.csv --json colours.json"
)]
pub struct Arguments {
    /// Height field: a file or a built-in name
    surface_name: Option<OsString>,
    /// Direction of the light, in degrees from the normal, and from +x toward +y
    #[arg(long, value_name = "THETA[,PHI]", value_parser = angles, allow_hyphen_values = true, required_unless_present = "geometry")]
    light: Option<[f64; 2]>,
    /// Directions of light and view of an instrument, instead of --light and --aspecular: 45/0, e2194 or e2539
    #[arg(long, value_name = "NAME", value_parser = NamedGeometry::from_name, conflicts_with_all = ["light", "aspecular", "view"])]
    geometry: Option<NamedGeometry>,
    /// Directions of view by their angle from the mirror direction toward the light, in degrees
    #[arg(
        long,
        value_name = "DEG[,DEG...]",
        value_delimiter = ',',
        value_parser = aspecular,
        allow_hyphen_values = true,
        default_value = "15,25,45,75,110",
        conflicts_with = "view"
    )]
    aspecular: Vec<f64>,
    /// Direction of view, instead of --aspecular; may be given several times
    #[arg(long, value_name = "THETA[,PHI]", value_parser = angles, allow_hyphen_values = true)]
    view: Vec<[f64; 2]>,
    /// Full angle of the cone of directions that the detector averages over, as in 2deg
    #[arg(long, value_name = "ANGLE", value_parser = aperture, default_value = "0deg")]
    aperture: f64,
    /// Write the radiance factors every 5 nm too: CSV, a column for each direction
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    spectrum: Option<PathBuf>,
    /// Output file, instead of stdout
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw the colours in CIELAB as SVG or PNG, and with --spectrum the spectra
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    figure: FigureOptions,
    /// Write the answer as JSON too
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    json: Option<PathBuf>,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    colour: ColourOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    cache: CacheOptions,
}

/// Parses `THETA` or `THETA,PHI` \[degrees\].
pub(super) fn angles(text: &str) -> Result<[f64; 2]> {
    let refused = || {
        Error::usage(
            format!("'{text}' is no direction"),
            "give THETA or THETA,PHI in degrees, THETA below 90, as in 45 or 45,90",
        )
    };
    let fields: Option<Vec<f64>> = text.split(',').map(|field| units::number(field.trim())).collect();
    match fields.as_deref() {
        Some([theta]) if theta.abs() < 90.0 => Ok([*theta, 0.0]),
        Some([theta, phi]) if theta.abs() < 90.0 && phi.abs() <= 360.0 => Ok([*theta, *phi]),
        _ => Err(refused()),
    }
}

/// Parses an angle from the mirror direction \[degrees\].
pub(super) fn aspecular(text: &str) -> Result<f64> {
    real(text, (-180.0, 180.0), "aspecular angle in degrees")
}

/// Parses the full angle of an aperture \[degrees\].
pub(super) fn aperture(text: &str) -> Result<f64> {
    let degrees = units::angle(text)?;
    if (0.0..=WIDEST).contains(&degrees) {
        return Ok(degrees);
    }
    Err(Error::usage(format!("an aperture of '{text}'"), format!("give 0deg to {WIDEST}deg")))
}

/// Everything, for JSON.
#[derive(Serialize)]
struct AngleReadings<'a> {
    illuminant: Cow<'a, str>,
    /// XYZ of the white; Y is 100.
    white: [f64; 3],
    observer: &'static str,
    aperture_deg: f64,
    readings: &'a [AngleReading],
}

/// Computes the colours and writes them.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let console = &arguments.device.chosen(&arguments.cache.limited(console));
    arguments.plot.as_deref().map(FigureFormat::of).transpose()?;
    let style =
        arguments.figure.style(arguments.plot.is_some(), figure::panels(arguments.spectrum.is_some()))?;
    Files::new()
        .reads(arguments.surface.files(arguments.surface_name.as_deref()))
        .reads(arguments.colour.files())
        .reads(arguments.optics.files())
        .writes(
            [&arguments.output, &arguments.json, &arguments.spectrum, &arguments.plot].into_iter().flatten(),
        )
        .check()?;
    if arguments.spectrum.is_some() {
        evaluation::check_single_wavelengths(arguments.optics.method())?;
    }
    let mut readings = asked(arguments)?;
    let field = arguments.surface.load(arguments.surface_name.as_deref(), None, "elaphe", console)?;
    let optics = arguments.optics.for_directions(&arguments.colour, &field, console)?;
    let illuminant = optics.illuminant.clone();
    let white = illuminant.white();
    let wavelengths = if arguments.spectrum.is_some() { wavelengths() } else { Vec::new() };
    let detector = Detector { aperture: arguments.aperture, wavelengths: &wavelengths };
    let spectra = detector.read(&mut readings, &field, optics, console)?;
    if let Some(path) = &arguments.spectrum {
        write::file(path, &spectrum_table(&readings, &wavelengths, &spectra)?)?;
    }
    let notes = captions::notes(&field, console);
    if let Some(path) = &arguments.json {
        let report = AngleReadings::new(&readings, &illuminant, white, arguments.aperture);
        write::json(path, &write::with_origin(&report, &notes))?;
    }
    write::result(arguments.output.as_deref(), &table(&readings)?, console)?;
    let drawn = ColourFigure {
        arguments,
        field: &field,
        readings: &readings,
        wavelengths: &wavelengths,
        spectra: &spectra,
    };
    arguments.plot.as_deref().map_or(Ok(()), |path| drawn.draw().save(path, &style, &notes))
}

/// Returns the geometries that are asked for, unanswered.
fn asked(arguments: &Arguments) -> Result<Vec<AngleReading>> {
    let light = arguments.light.unwrap_or_default();
    let asked: Vec<AngleReading> = match &arguments.geometry {
        Some(named) => {
            named.aspecular().map(|(theta, angle)| AngleReading::aspecular([theta, 0.0], angle)).collect()
        }
        None if arguments.view.is_empty() => {
            arguments.aspecular.iter().map(|angle| AngleReading::aspecular(light, *angle)).collect()
        }
        None => arguments.view.iter().map(|view| AngleReading::unanswered(light, *view)).collect(),
    };
    if asked.len() > MOST_GEOMETRIES {
        return Err(Error::usage(
            format!("{} directions are too many", asked.len()),
            format!("give at most {MOST_GEOMETRIES}, or use `diffract eval`"),
        ));
    }
    let below: Vec<String> =
        asked.iter().filter(|r| r.theta_r.abs() >= 90.0).map(AngleReading::name).collect();
    if !below.is_empty() {
        return Err(Error::usage(
            format!("the directions {} are below the horizon", below.join(", ")),
            format!(
                "with the light at {} degrees, aspecular angles reach from {} to {}",
                light[0],
                light[0] - 90.0,
                light[0] + 90.0
            ),
        ));
    }
    Ok(asked)
}

impl<'a> AngleReadings<'a> {
    fn new(
        readings: &'a [AngleReading],
        illuminant: &'a Illuminant,
        white: DVec3,
        aperture: f64,
    ) -> AngleReadings<'a> {
        AngleReadings {
            illuminant: illuminant.name(),
            white: (100.0 * white).to_array(),
            observer: "CIE 1931 2 degree",
            aperture_deg: aperture,
            readings,
        }
    }
}

/// Returns the CSV of the colours.
fn table(readings: &[AngleReading]) -> Result<String> {
    let mut table = write::Csv::new();
    table.row(["aspecular", "theta_i", "phi_i", "theta_r", "phi_r", "X", "Y", "Z", "L", "a", "b", "srgb"]);
    for r in readings {
        let aspecular = r.aspecular.map(|angle| angle.to_string()).unwrap_or_default();
        let mut cells = vec![aspecular];
        cells.extend([r.theta_i, r.phi_i, r.theta_r, r.phi_r].map(|x| x.to_string()));
        cells.extend(r.xyz.iter().chain(&r.lab).map(|x| format!("{x:.4}")));
        cells.push(r.srgb.clone());
        table.row(cells);
    }
    table.text()
}

/// Returns the CSV of the radiance factors: a row for each wavelength \[nm\].
fn spectrum_table(readings: &[AngleReading], wavelengths: &[f64], spectra: &[Vec<f64>]) -> Result<String> {
    let mut table = write::Csv::new();
    table.row(std::iter::once("wavelength".to_owned()).chain(readings.iter().map(AngleReading::name)));
    for (wavelength, spectrum) in wavelengths.iter().zip(spectra) {
        let cells = spectrum.iter().map(|f| format!("{:e}", PI * f));
        table.row(std::iter::once(format!("{:.0}", 1e3 * wavelength)).chain(cells));
    }
    table.text()
}
