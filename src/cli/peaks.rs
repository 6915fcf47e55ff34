//! `diffract peaks`: where each wavelength goes, against the grating equation.

use super::answers::{self, Answers};
use super::options::{self, DeviceOptions, Method, OpticsOptions, SurfaceOptions};
use super::range::Range;
use super::{say, write};
use crate::error::{Error, Result};
use crate::measure::peaks::{Peak, Statistics};
use crate::optics::geometry::{Pair, direction};
use crate::output;
use crate::render::evaluator::Query;
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Most evaluations: a software device makes them in minutes.
const MAX_EVALUATIONS: usize = 50_000_000;
/// Evaluations by the direct sum from which on a word of warning is due: minutes on a patch of 65 µm.
const MANY_SUMS: usize = 20_000;
/// Largest order that can be named.
const MAX_ORDER: u32 = 1000;
/// Where the light can stand \[degrees\]: in the horizon it reflects nothing.
const THETA_I: (f64, f64) = (-89.99, 89.99);
/// Fewest angles that can have a maximum inside.
const FEWEST_ANGLES: usize = 3;

/// Arguments of `peaks`.
#[derive(Args, Debug)]
#[command(
    after_help = "Angles are in degrees from the normal toward the axis, for the light and for the viewer, so the mirror
direction stands at minus theta-i. The answer is CSV: wavelength [nm], angle of the largest BRDF in the range [degrees],
period d = m wavelength/|sin angle + sin theta-i| [nm], response [1/sr]. Cells stay empty where nothing is reflected or,
in the mirror direction, every period fits.

Examples:
  diffract peaks blaze --theta-i -75 --angles 38:57:0.01
  diffract peaks elaphe --theta-i 75 --angles -40:-10:0.01 --wavelengths 400:700:5 -o fingers.csv --json fingers.json"
)]
pub struct Arguments {
    /// Height field: a file or a built-in name
    surface_name: Option<String>,
    /// Where the light stands, in degrees from the normal toward the axis
    #[arg(long, value_name = "DEG", value_parser = theta_i, allow_hyphen_values = true)]
    theta_i: f64,
    /// Wavelengths in nm
    #[arg(
        long, value_name = "LO:HI:STEP", value_parser = wavelengths, allow_hyphen_values = true,
        default_value = "380:780:1"
    )]
    wavelengths: Range,
    /// View angles to search, in degrees from the normal toward the axis
    #[arg(long, value_name = "LO:HI:STEP", value_parser = angles, allow_hyphen_values = true)]
    angles: Range,
    /// The axis of the plane of incidence
    #[arg(long, value_enum, default_value_t)]
    axis: Axis,
    /// Order of diffraction that the peak is taken for
    #[arg(long, value_name = "M", value_parser = order, allow_hyphen_values = true, default_value = "1")]
    order: u32,
    /// Where the table goes, instead of stdout
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write mean and standard deviation as JSON too
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    device: DeviceOptions,
}

/// An axis of the tangent frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
enum Axis {
    /// To the right in a height image
    #[default]
    X,
    /// Up in a height image
    Y,
}

impl Axis {
    /// Azimuth \[degrees\].
    fn azimuth(self) -> f64 {
        match self {
            Self::X => 0.0,
            Self::Y => 90.0,
        }
    }
}

fn theta_i(text: &str) -> Result<f64> {
    options::real(text, THETA_I, "angle of the light")
}

fn wavelengths(text: &str) -> Result<Range> {
    const NM_PER_UM: f64 = 1e3;
    let (low, high) = answers::WAVELENGTHS;
    Range::parse(text, (low * NM_PER_UM, high * NM_PER_UM), "wavelengths in nm")
}

fn angles(text: &str) -> Result<Range> {
    let range = Range::parse(text, (-90.0, 90.0), "angles in degrees")?;
    if range.count() < FEWEST_ANGLES {
        return Err(Error::usage(
            format!("`{text}` are {} angles, and a peak has two sides", range.count()),
            "give a smaller step or a wider range",
        ));
    }
    Ok(range)
}

fn order(text: &str) -> Result<u32> {
    text.trim().parse().ok().filter(|m| (1..=MAX_ORDER).contains(m)).ok_or_else(|| {
        Error::usage(
            format!("`{text}` is no order of diffraction"),
            format!("give a whole number from 1 to {MAX_ORDER}; the side is in the angles"),
        )
    })
}

/// What is said about all wavelengths, as JSON has it.
#[derive(Serialize)]
struct Report {
    theta_i: f64,
    axis: Axis,
    order: u32,
    /// Wavelengths that were asked for.
    wavelengths: usize,
    /// Those that have a period.
    with_period: usize,
    /// Those whose maximum lies inside the range of angles.
    clear: usize,
    /// Over those that have a period.
    period_nm: Summary,
}

/// `None` where there are too few wavelengths \[nm\].
#[derive(Serialize)]
struct Summary {
    mean: Option<f64>,
    standard_deviation: Option<f64>,
}

/// Searches and reports.
pub fn run(arguments: &Arguments) -> Result<()> {
    for path in [&arguments.output, &arguments.json].into_iter().flatten() {
        output::check(path)?;
    }
    let evaluations = arguments.wavelengths.count().saturating_mul(arguments.angles.count());
    if evaluations > MAX_EVALUATIONS {
        return Err(Error::usage(
            format!("{evaluations} evaluations are more than the {MAX_EVALUATIONS} that are made at once"),
            "give a larger step to --angles or --wavelengths",
        ));
    }
    let peaks = search(arguments, evaluations)?;
    write::text(arguments.output.as_deref(), &table(&peaks))?;
    let report = report(arguments, &peaks);
    say(&line(&report));
    match &arguments.json {
        Some(path) => write::json(path, &report),
        None => Ok(()),
    }
}

fn search(arguments: &Arguments, evaluations: usize) -> Result<Vec<Peak>> {
    let optics = &arguments.optics;
    answers::check_single_wavelengths(optics.method)?;
    let shading = optics.monochrome();
    let field = arguments.surface.load(arguments.surface_name.as_deref(), None, "elaphe")?;
    if optics.method == Method::Reference && evaluations > MANY_SUMS {
        say(&format_args!("{evaluations} direct sums take their time; --method spectral is faster"));
    }
    let wavelengths: Vec<f64> = arguments.wavelengths.values().iter().map(|nm| nm / 1e3).collect();
    let angles = arguments.angles.values();
    let mut answers =
        Answers::prepare(optics.method, &arguments.device.wish(), &field, &shading, wavelengths[0])?;
    answers.announce(evaluations);
    let azimuth = arguments.axis.azimuth();
    let light = direction(arguments.theta_i, azimuth);
    let pairs: Vec<Pair> = angles.iter().map(|&a| Pair::new(light, direction(a, azimuth))).collect();
    let mut peaks = Vec::with_capacity(wavelengths.len());
    // Whole wavelengths at a time, as many as make a submission worth it.
    for part in wavelengths.chunks((answers::AT_ONCE / angles.len()).max(1)) {
        let queries: Vec<Query> = part
            .iter()
            .flat_map(|&wavelength| {
                pairs.iter().map(move |&pair| Query { pair, wavelength: Some(wavelength) })
            })
            .collect();
        let responses: Vec<f64> = answers.brdf(&queries)?.iter().map(|f| f.x).collect();
        let sweeps = part.iter().zip(responses.chunks(angles.len()));
        peaks.extend(sweeps.map(|(&wavelength, responses)| {
            Peak::find(wavelength, arguments.theta_i, arguments.order, &angles, responses)
        }));
    }
    answers.finish()?;
    Ok(peaks)
}

/// The CSV.
fn table(peaks: &[Peak]) -> String {
    let cell = |value: Option<f64>| value.map(|x| x.to_string()).unwrap_or_default();
    let mut text = String::from("wavelength,angle,period,response\n");
    for peak in peaks {
        let (angle, period) = (cell(peak.angle), cell(peak.period.map(nanometres)));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{},{angle},{period},{:e}", nanometres(peak.wavelength), peak.response);
    }
    text
}

/// From µm, rounded where the conversion's last bits are.
fn nanometres(micrometres: f64) -> f64 {
    (micrometres * 1e12).round() / 1e9
}

fn report(arguments: &Arguments, peaks: &[Peak]) -> Report {
    let statistics = Statistics::of(peaks);
    Report {
        theta_i: arguments.theta_i,
        axis: arguments.axis,
        order: arguments.order,
        wavelengths: peaks.len(),
        with_period: statistics.count,
        clear: statistics.clear,
        period_nm: Summary {
            mean: statistics.mean.map(|d| d * 1e3),
            standard_deviation: statistics.deviation.map(|d| d * 1e3),
        },
    }
}

/// The report in a line.
fn line(report: &Report) -> String {
    let period = match (report.period_nm.mean, report.period_nm.standard_deviation) {
        (Some(mean), Some(deviation)) => format!("period {mean:.3} nm, standard deviation {deviation:.3} nm"),
        (Some(mean), None) => format!("period {mean:.3} nm"),
        (None, _) => "no period".to_owned(),
    };
    format!("{period}; {} of {} wavelengths have a clear peak in the range", report.clear, report.wavelengths)
}
