//! `diffract peaks`: peak angles of each wavelength, against the grating equation.

mod copies;
mod figure;
mod report;
mod sweep;

use super::answer::{AskedOptics, AskedSurface, TableAnswer};
use super::console::Console;
use super::options::{self, CacheOptions, DeviceOptions, FigureOptions, OpticsOptions, SurfaceOptions};
use super::range::Range;
use super::{captions, evaluation, write};
use crate::error::{Error, Result};
use crate::figure::FigureFormat;
use crate::files::Files;
use crate::measure::order_peaks::{OrderPeaks, spread_over_windows};
use crate::measure::peaks::Sought;
use crate::measure::sweep::{AngleSweep, SweepPlane, independent_windows};
use crate::optics::coherence::Windows;
use crate::units;
use clap::{Args, ValueEnum};
use copies::CopiedPeriods;
use report::PeaksReport;
use serde::Serialize;
use std::ffi::OsString;
use std::path::PathBuf;

/// Nanometres in a micrometre.
const NM_PER_UM: f64 = 1e3;
/// Largest number of evaluations: a software device makes them in minutes.
const MAX_EVALUATIONS: usize = 50_000_000;
/// Largest order.
const MAX_ORDER: u32 = 1000;
/// Largest number of orders in one search.
const MAX_ORDERS: usize = 6;
/// Periods that diffract light \[µm\].
const PERIODS: (f64, f64) = (0.01, 1e4);
/// Range of polar angles of the light \[degrees\]: grazing light reflects nothing.
const THETA_I: (f64, f64) = (-89.99, 89.99);
/// Smallest number of angles that can have a maximum inside.
const FEWEST_ANGLES: usize = 3;

/// Arguments of `peaks`.
#[derive(Args, Debug)]
#[command(
    after_help = "Angles are in degrees from the normal toward the axis, for the light and for the viewer, so the mirror \
direction stands at minus theta-i. The answer is CSV: wavelength [nm], angle of the largest BRDF in the range [degrees], \
period d = m wavelength/|sin angle + sin theta-i| [nm], response [1/sr]. Cells stay empty where nothing is reflected or, \
in the mirror direction, every period fits. Where the largest response changes from one branch of maxima to another, each \
is followed over the wavelengths and has a period of its own, and a column `branch` names the largest one. One order has \
the whole range of angles; of several, each has what is at most half an order away from where --period sends it, and a \
column `order`. The standard error over windows is that of the mean over the surface, by the jackknife over windows: over \
a few of them for --windows all, over those that are asked for with --windows NxM, which also prints the period of each \
window alone. --method reference --windows all has none.

Examples:
  diffract peaks blaze --theta-i -75 --angles 38:57:0.01
  diffract peaks blaze --theta-i -75 --angles 0:60:0.05 --order 1,2,3 --period 2.5um --plot orders.png
  diffract peaks elaphe --theta-i 75 --angles -40:-10:0.01 --wavelengths 400:700:5 -o fingers.csv --json fingers.json"
)]
pub struct Arguments {
    /// Height field: a file or a built-in name
    surface_name: Option<OsString>,
    /// Direction of the light, in degrees from the normal: positive toward the axis, where the mirror direction is negative
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
    /// Axis of the plane of incidence
    #[arg(long, value_enum, default_value_t, hide_short_help = true)]
    axis: TangentAxis,
    /// Order of diffraction assumed for the peak; several, as in 1,2,3, need --period
    #[arg(long, value_name = "M[,M...]", value_parser = orders, allow_hyphen_values = true, default_value = "1")]
    order: OrderList,
    /// Expected period, as in 2.5um: its grating equation is drawn, and separates several orders
    #[arg(long, value_name = "LENGTH", value_parser = period, allow_hyphen_values = true)]
    period: Option<f64>,
    /// Output file for the table, instead of stdout
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write mean and standard deviation as JSON too
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    json: Option<PathBuf>,
    /// Draw a labelled figure of responses, peaks and the grating equation: .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    figure: FigureOptions,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    optics: OpticsOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    cache: CacheOptions,
}

/// An axis of the tangent frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
enum TangentAxis {
    /// To the right in a height image
    #[default]
    X,
    /// Up in a height image
    Y,
}

impl TangentAxis {
    /// Returns the azimuth \[degrees\].
    fn azimuth(self) -> f64 {
        match self {
            Self::X => 0.0,
            Self::Y => 90.0,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
        }
    }
}

impl Arguments {
    /// Returns the directions of the sweep.
    fn plane(&self) -> SweepPlane {
        SweepPlane {
            theta_i: self.theta_i,
            azimuth: self.axis.azimuth(),
            wavelengths: self.wavelengths.values().into_iter().map(units::micrometres).collect(),
            angles: self.angles.values(),
        }
    }
}

fn theta_i(text: &str) -> Result<f64> {
    options::real(text, THETA_I, "angle of the light")
}

fn wavelengths(text: &str) -> Result<Range> {
    let (low, high) = evaluation::WAVELENGTHS;
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

/// Orders of diffraction, each once.
#[derive(Clone, Debug)]
struct OrderList(Vec<u32>);

fn orders(text: &str) -> Result<OrderList> {
    let one = |word: &str| {
        word.trim().parse().ok().filter(|m| (1..=MAX_ORDER).contains(m)).ok_or_else(|| {
            Error::usage(
                format!("`{text}` is no order of diffraction"),
                format!("give a whole number from 1 to {MAX_ORDER}, or several as in 1,2,3; the side is in the angles"),
            )
        })
    };
    let mut orders = text.split(',').map(one).collect::<Result<Vec<u32>>>()?;
    orders.sort_unstable();
    orders.dedup();
    if orders.len() > MAX_ORDERS {
        return Err(Error::usage(
            format!("{} orders are too many", orders.len()),
            format!("give at most {MAX_ORDERS}"),
        ));
    }
    Ok(OrderList(orders))
}

fn period(text: &str) -> Result<f64> {
    options::length_within(text, PERIODS, "period")
}

/// Searches the peaks and reports them.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    let console = &arguments.device.chosen(&arguments.cache.limited(console));
    arguments.plot.as_deref().map(FigureFormat::of).transpose()?;
    let style = arguments.figure.style(arguments.plot.is_some(), &figure::PANELS)?;
    Files::new()
        .reads(arguments.surface.files(arguments.surface_name.as_deref()))
        .writes([&arguments.output, &arguments.json, &arguments.plot].into_iter().flatten())
        .check()?;
    evaluation::check_single_wavelengths(arguments.optics.method())?;
    if arguments.order.0.len() > 1 && arguments.period.is_none() {
        return Err(Error::usage(
            "several orders cannot be told apart without a period",
            "add --period, as in --period 2.5um, or name one order",
        ));
    }
    let evaluations = arguments.wavelengths.count().saturating_mul(arguments.angles.count());
    if evaluations > MAX_EVALUATIONS {
        return Err(Error::usage(
            format!("{evaluations} evaluations are more than the {MAX_EVALUATIONS} that are made at once"),
            "give a larger step to --angles or --wavelengths",
        ));
    }
    let field = arguments.surface.load(arguments.surface_name.as_deref(), None, "elaphe", console)?;
    let optics = arguments.optics.for_wavelengths(&field, console)?;
    for nanometres in arguments.wavelengths.values() {
        optics.reflectance.check_wavelength(nanometres / NM_PER_UM)?;
    }
    let (sweep, alone) = sweep::of(&arguments.plane(), &optics, &field, console)?;
    let mut found = searched(arguments, &sweep);
    let asked: &[AngleSweep] = if arguments.optics.windows() == Windows::All { &[] } else { &alone };
    for of in &mut found {
        of.find_branches(&sweep, asked);
    }
    spread_over_windows(independent_windows(&optics, &field), &alone, &mut found);
    let windows: Vec<Vec<OrderPeaks>> = asked.iter().map(|one| searched(arguments, one)).collect();
    write::result(arguments.output.as_deref(), &report::table(&found).text()?, console)?;
    tell(&found, &windows, console);
    let copies = CopiedPeriods::of(&optics, &field)?;
    if let Some(copies) = &copies {
        console.say(copies);
    }
    let notes = captions::notes(&field, console);
    if let Some(path) = &arguments.plot {
        figure::figure(arguments, &field, &sweep, &found).save(path, &style, &notes)?;
    }
    let Some(path) = &arguments.json else { return Ok(()) };
    let shift = copies.as_ref().map(CopiedPeriods::relative_shift);
    let reports = reports(arguments, &found, &windows, shift);
    let name = arguments.surface.name(arguments.surface_name.as_deref());
    let (input, settings) = (AskedSurface::new(name, &field), AskedOptics::new(&optics));
    let documents: Vec<_> = reports
        .iter()
        .zip(&found)
        .map(|(report, of)| {
            let rows = report::table(std::slice::from_ref(of));
            PeaksDocument { report, answer: TableAnswer::new(input.clone(), settings.clone(), &rows, &notes) }
        })
        .collect();
    match &documents[..] {
        [only] => write::json(path, only),
        all => write::json(path, &all),
    }
}

/// Peaks of an order as JSON: the summary, then the answer with a row for each wavelength.
#[derive(Serialize)]
struct PeaksDocument<'a> {
    #[serde(flatten)]
    report: &'a PeaksReport,
    #[serde(flatten)]
    answer: TableAnswer<'a, AskedOptics>,
}

/// Finds the peaks of every requested order.
fn searched(arguments: &Arguments, sweep: &AngleSweep) -> Vec<OrderPeaks> {
    let orders = &arguments.order.0;
    // A single order is searched in the whole range.
    let apart = arguments.period.filter(|_| orders.len() > 1);
    let sought = |&order| Sought { theta_i: arguments.theta_i, order, period: apart };
    orders.iter().map(|order| OrderPeaks::new(sought(order), sweep)).collect()
}

/// Standard deviation over mean from which on wavelengths cannot all belong to the same order: the second order gives half the period of
/// the first.
const SCATTERED: f64 = 0.1;

/// Prints the periods, a line each on stderr.
fn tell(found: &[OrderPeaks], windows: &[Vec<OrderPeaks>], console: &Console) {
    for (i, of) in found.iter().enumerate() {
        let order = of.sought.order;
        let which = if found.len() > 1 { format!("order {order}: ") } else { String::new() };
        if of.branches.is_empty() {
            for (window, alone) in windows.iter().enumerate() {
                console.say(&format_args!(
                    "{which}window {} of {}: {}",
                    window + 1,
                    windows.len(),
                    alone[i].line()
                ));
            }
            let average = if windows.is_empty() { "" } else { "all windows: " };
            console.say(&format_args!("{which}{average}{}", of.line()));
        } else {
            of.lines().iter().for_each(|line| console.say(&format_args!("{which}{line}")));
        }
        let (mean, deviation) = (of.statistics.mean.unwrap_or(0.0), of.statistics.deviation.unwrap_or(0.0));
        if deviation > SCATTERED * mean {
            console.say(
                &"the brightest directions are not all of one order: narrow --angles, or give two --order and --period",
            );
        }
    }
}

/// Returns a report for each order, with the shift of the period by copies, relative to it.
fn reports(
    arguments: &Arguments,
    found: &[OrderPeaks],
    windows: &[Vec<OrderPeaks>],
    shift: Option<f64>,
) -> Vec<PeaksReport> {
    let report = |(i, of): (usize, &OrderPeaks)| {
        let alone: Vec<&OrderPeaks> = windows.iter().map(|window| &window[i]).collect();
        PeaksReport::new(arguments.theta_i, arguments.axis, of, &alone).with_shift(shift)
    };
    found.iter().enumerate().map(report).collect()
}
