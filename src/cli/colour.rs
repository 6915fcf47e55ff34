//! `diffract colour`: what a multi-angle spectrophotometer reads of a surface.

use super::options::{CacheOptions, ColourOptions, DeviceOptions, OpticsOptions, SurfaceOptions};
use super::{captions, evaluation, prepare, write};
use crate::brdf::Brdf;
use crate::error::{Error, Result};
use crate::files::Files;
use crate::optics::color::{adapted_to_d65, display, xyz_to_linear_srgb};
use crate::optics::color_difference::lab_under;
use crate::optics::geometry::{Pair, direction};
use crate::optics::spectrum::{Illuminant, LONGEST, SHORTEST};
use crate::setup::SourceSettings;
use crate::units;
use clap::Args;
use glam::{DQuat, DVec2, DVec3};
use serde::Serialize;
use std::f64::consts::PI;
use std::ffi::OsString;
use std::path::PathBuf;

/// Distance of the wavelengths of a spectrum \[µm\], that of CIE's tables for spectrophotometers.
const STEP: f64 = 5e-3;
/// Directions in an aperture.
const IN_APERTURE: u32 = 64;
/// Largest full angle of an aperture \[degrees\].
const WIDEST: f64 = 30.0;
/// Most geometries of one call.
const MOST_GEOMETRIES: usize = 1000;

/// Arguments of `colour`.
#[derive(Args, Debug)]
#[command(
    after_help = "An aspecular angle is that from the mirror direction of the light toward the light, in the plane of incidence: with the \
light at 45 degrees, 45 looks straight down (45/0), and 15, 45, 110 are the angles of ASTM E2194 for metallic paint.

The answer is CSV, a row for each direction of view: aspecular [degrees], empty for --view; theta_i, phi_i, theta_r, phi_r [degrees]; X, Y, Z of \
the radiance factor, where a white diffuse surface has Y = 100; L, a, b, CIELAB under the white of the illuminant; srgb, as a display shows \
it, adapted to its white. 2 degree observer, CIE 1931.

Examples:
  diffract colour cd --light 45 --illuminant d50
  diffract colour elaphe --light 45 --aspecular -15,15,25,45,75,110 --aperture 2deg -o colours.csv
  diffract colour blaze --light 30,0 --view 0,0 --view 10,180 --spectrum spectra.csv --json colours.json"
)]
pub struct Arguments {
    /// Height field: a file or a built-in name
    surface_name: Option<OsString>,
    /// Direction of the light, in degrees from the normal, and from +x toward +y
    #[arg(long, value_name = "THETA[,PHI]", value_parser = angles, allow_hyphen_values = true)]
    light: [f64; 2],
    /// Directions of view by their angle from the mirror direction toward the light, in degrees
    #[arg(
        long,
        value_name = "DEG[,DEG...]",
        value_delimiter = ',',
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
    #[arg(long, value_name = "FILE")]
    spectrum: Option<PathBuf>,
    /// Output file, instead of stdout
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the answer as JSON too
    #[arg(long, value_name = "FILE")]
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
fn angles(text: &str) -> Result<[f64; 2]> {
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

/// Parses the full angle of an aperture \[degrees\].
fn aperture(text: &str) -> Result<f64> {
    let degrees = units::angle(text)?;
    if (0.0..=WIDEST).contains(&degrees) {
        return Ok(degrees);
    }
    Err(Error::usage(format!("an aperture of '{text}'"), format!("give 0deg to {WIDEST}deg")))
}

/// A direction of view, and the answer to it.
#[derive(Clone, Debug, Serialize)]
struct Reading {
    /// Angle from the mirror direction toward the light \[degrees\]; `None` for a view by its own direction.
    aspecular: Option<f64>,
    theta_i: f64,
    phi_i: f64,
    theta_r: f64,
    phi_r: f64,
    /// XYZ of the radiance factor; Y is 100 for a white diffuse surface.
    xyz: [f64; 3],
    /// CIELAB under the white of the illuminant.
    lab: [f64; 3],
    /// Colour on a display, as in #80ff00.
    srgb: String,
}

/// Everything, for JSON.
#[derive(Serialize)]
struct Readings<'a> {
    illuminant: &'a str,
    /// XYZ of the white; Y is 100.
    white: [f64; 3],
    observer: &'static str,
    aperture_deg: f64,
    readings: &'a [Reading],
}

/// Computes the colours and writes them.
pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.cache.apply();
    Files::new()
        .reads(arguments.surface.files(arguments.surface_name.as_deref()))
        .reads(arguments.colour.files())
        .reads(arguments.optics.files())
        .writes([&arguments.output, &arguments.json, &arguments.spectrum].into_iter().flatten())
        .check()?;
    if arguments.spectrum.is_some() {
        evaluation::check_single_wavelengths(arguments.optics.method())?;
    }
    let mut readings = readings(arguments)?;
    let field = arguments.surface.load(arguments.surface_name.as_deref(), None, "elaphe")?;
    let optics = arguments.optics.for_directions(&arguments.colour, &field)?;
    let illuminant = optics.illuminant.clone();
    let cones: Vec<Cone> = readings.iter().map(|reading| Cone::of(reading, arguments.aperture)).collect();
    let wavelengths = if arguments.spectrum.is_some() { wavelengths() } else { Vec::new() };
    let settings = SourceSettings { shortest: SHORTEST, ..SourceSettings::new(optics) };
    let mut colours = vec![DVec3::ZERO; cones.len()];
    let mut spectra = vec![vec![0.0; cones.len()]; wavelengths.len()];
    prepare::for_each_window(&field, &settings, &arguments.device.wish(), |brdf, share| {
        let count: usize = cones.iter().map(|cone| cone.pairs.len()).sum();
        let bar = evaluation::bar(count * (1 + wavelengths.len()));
        for (place, cone) in cones.iter().enumerate() {
            colours[place] += cone.mean(brdf, None, &bar)? * share;
            for (spectrum, wavelength) in spectra.iter_mut().zip(&wavelengths) {
                spectrum[place] += cone.mean(brdf, Some(*wavelength), &bar)?.x * share;
            }
        }
        bar.finish_and_clear();
        Ok(())
    })?;
    let white = illuminant.white();
    for (reading, f) in readings.iter_mut().zip(&colours) {
        reading.answer(PI * *f, white);
    }
    if let Some(path) = &arguments.spectrum {
        write::text(Some(path), &spectrum_table(&readings, &wavelengths, &spectra)?)?;
    }
    if let Some(path) = &arguments.json {
        let report = Readings::new(&readings, &illuminant, white, arguments.aperture);
        write::json(path, &write::with_origin(&report, &captions::notes(&field)))?;
    }
    write::text(arguments.output.as_deref(), &table(&readings)?)
}

/// Returns the geometries that are asked for, unanswered.
fn readings(arguments: &Arguments) -> Result<Vec<Reading>> {
    let [theta_i, phi_i] = arguments.light;
    let unanswered = |aspecular: Option<f64>, [theta_r, phi_r]: [f64; 2]| Reading {
        aspecular,
        theta_i,
        phi_i,
        theta_r,
        phi_r,
        xyz: [0.0; 3],
        lab: [0.0; 3],
        srgb: String::new(),
    };
    let asked: Vec<Reading> = if arguments.view.is_empty() {
        // Signed in the plane of incidence, where the light is at theta_i and the mirror direction at −theta_i.
        arguments.aspecular.iter().map(|angle| unanswered(Some(*angle), [angle - theta_i, phi_i])).collect()
    } else {
        arguments.view.iter().map(|view| unanswered(None, *view)).collect()
    };
    if asked.len() > MOST_GEOMETRIES {
        return Err(Error::usage(
            format!("{} directions are too many", asked.len()),
            format!("give at most {MOST_GEOMETRIES}, or use `diffract eval`"),
        ));
    }
    let below: Vec<String> = asked.iter().filter(|r| r.theta_r.abs() >= 90.0).map(Reading::name).collect();
    if !below.is_empty() {
        return Err(Error::usage(
            format!("the directions {} are below the horizon", below.join(", ")),
            format!(
                "with the light at {theta_i} degrees, aspecular angles reach from {} to {}",
                theta_i - 90.0,
                theta_i + 90.0
            ),
        ));
    }
    Ok(asked)
}

/// Returns the wavelengths of a spectrum \[µm\].
fn wavelengths() -> Vec<f64> {
    let count = ((LONGEST - SHORTEST) / STEP).round() as usize;
    (0..=count).map(|n| SHORTEST + STEP * n as f64).collect()
}

/// Directions over which a detector averages.
struct Cone {
    pairs: Vec<Pair>,
    /// Standard deviation of the Gaussian of (u, v) that each direction stands for.
    deviation: f64,
}

impl Cone {
    /// Returns the cone around the view of `reading`, `aperture` degrees across. The directions are spread evenly over it along a spiral
    /// (Vogel 1979), and each stands for a Gaussian as wide as its share of the cone.
    fn of(reading: &Reading, aperture: f64) -> Self {
        let light = direction(reading.theta_i, reading.phi_i);
        let middle = direction(reading.theta_r, reading.phi_r);
        let radius = (0.5 * aperture).to_radians();
        if radius == 0.0 {
            return Self { pairs: vec![Pair::new(light, middle)], deviation: 0.0 };
        }
        let golden = PI * (3.0 - 5f64.sqrt());
        let turn = DQuat::from_rotation_arc(DVec3::Z, middle);
        let view = |n: u32| {
            let share = (f64::from(n) + 0.5) / f64::from(IN_APERTURE);
            // Evenly over the solid angle: 1 − cos grows evenly.
            let cosine = 1.0 - share * (1.0 - radius.cos());
            let across = DVec2::from_angle(golden * f64::from(n)) * (1.0 - cosine * cosine).max(0.0).sqrt();
            turn * across.extend(cosine)
        };
        let spacing = radius * (PI / f64::from(IN_APERTURE)).sqrt();
        Self {
            pairs: (0..IN_APERTURE).map(|n| Pair::new(light, view(n))).collect(),
            // Variance of a square cell along each axis.
            deviation: spacing / 12f64.sqrt(),
        }
    }

    /// Returns the mean of f \[sr⁻¹\] over the cone, at `wavelength` \[µm\] or as XYZ.
    fn mean(
        &self,
        brdf: &mut dyn Brdf,
        wavelength: Option<f64>,
        bar: &indicatif::ProgressBar,
    ) -> Result<DVec3> {
        brdf.average_over(self.deviation);
        let found = evaluation::ask(brdf, &self.pairs, wavelength, bar)?;
        Ok(found.iter().sum::<DVec3>() / found.len() as f64)
    }
}

impl Reading {
    /// Returns the geometry in words.
    fn name(&self) -> String {
        match self.aspecular {
            Some(angle) => format!("{}as{angle}", self.theta_i),
            None => format!("{},{}", self.theta_r, self.phi_r),
        }
    }

    /// Enters the colour of the radiance factor `factor`, XYZ in terms of the `white`.
    fn answer(&mut self, factor: DVec3, white: DVec3) {
        self.xyz = (100.0 * factor).to_array();
        self.lab = lab_under(factor, white).to_array();
        let [r, g, b] = display(xyz_to_linear_srgb(adapted_to_d65(factor, white)), 0.0);
        self.srgb = format!("#{r:02x}{g:02x}{b:02x}");
    }
}

impl<'a> Readings<'a> {
    fn new(readings: &'a [Reading], illuminant: &'a Illuminant, white: DVec3, aperture: f64) -> Readings<'a> {
        Readings {
            illuminant: match illuminant {
                Illuminant::D50 => "d50",
                Illuminant::D65 => "d65",
                Illuminant::A => "a",
                Illuminant::E => "e",
                Illuminant::Led => "led",
                Illuminant::Table(_) => "file",
            },
            white: (100.0 * white).to_array(),
            observer: "CIE 1931 2 degree",
            aperture_deg: aperture,
            readings,
        }
    }
}

/// Returns the CSV of the colours.
fn table(readings: &[Reading]) -> Result<String> {
    let mut table = write::Csv::new();
    table.row(["aspecular", "theta_i", "phi_i", "theta_r", "phi_r", "X", "Y", "Z", "L", "a", "b", "srgb"])?;
    for r in readings {
        let aspecular = r.aspecular.map(|angle| angle.to_string()).unwrap_or_default();
        let mut cells = vec![aspecular];
        cells.extend([r.theta_i, r.phi_i, r.theta_r, r.phi_r].map(|x| x.to_string()));
        cells.extend(r.xyz.iter().chain(&r.lab).map(|x| format!("{x:.4}")));
        cells.push(r.srgb.clone());
        table.row(cells)?;
    }
    table.text()
}

/// Returns the CSV of the radiance factors: a row for each wavelength \[nm\].
fn spectrum_table(readings: &[Reading], wavelengths: &[f64], spectra: &[Vec<f64>]) -> Result<String> {
    let mut table = write::Csv::new();
    table.row(std::iter::once("wavelength".to_owned()).chain(readings.iter().map(Reading::name)))?;
    for (wavelength, spectrum) in wavelengths.iter().zip(spectra) {
        let cells = spectrum.iter().map(|f| format!("{:e}", PI * f));
        table.row(std::iter::once(format!("{:.0}", 1e3 * wavelength)).chain(cells))?;
    }
    table.text()
}
