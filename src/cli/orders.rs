//! `diffract orders`: directions and efficiencies of the orders of a periodic surface.

mod figure;
mod sweep;

use super::answer::{AskedSurface, TableAnswer};
use super::console::Console;
use super::options::{FigureOptions, ReflectanceOptions, SurfaceOptions, share};
use super::progress::ProgressBar;
use super::{captions, evaluation, prepare, write};
use crate::brdf::DiffractionOrder;
use crate::brdf::energy_map::excess_note;
use crate::brdf::mean::MeanBrdf;
use crate::error::{Error, Result};
use crate::figure::{FigureFormat, FigureStyle};
use crate::files::Files;
use crate::optics::coherence::Beyond;
use crate::optics::geometry::{angles, direction};
use crate::optics::reflectance::Reflectance;
use crate::optics::validity::{LightColour, ScalarTheory};
use crate::scene::FarLight;
use crate::surface::HeightField;
use crate::surface::statistics::{Relief, joining};
use clap::Args;
use glam::DVec3;
use serde::Serialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use sweep::{Sweep, SweptQuantity};

/// Nanometres in a micrometre.
const NM_PER_UM: f64 = 1e3;

/// Arguments of `orders`.
#[derive(Args, Debug)]
#[command(
    after_help = "The surface goes on beyond the patch as copies of it. Orders are counted from the smallest period by \
which the heights repeat, m along x and n along y: (u, v) = (m wavelength/Tx, n wavelength/Ty), which is minus the sum of the directions to the light and to the viewer.

The answer is CSV, a row for each order above the horizon: wavelength [nm]; m and n; theta_r and phi_r, its \
direction [degrees]; efficiency, the share of the incident light that it takes; reflectance, with which Stam's factor \
would give the efficiency, by --theory stam R at the half vector; period [nm] of the grating whose first order it is, \
1/sqrt((m/Tx)^2 + (n/Ty)^2), empty for the specular order. stderr has the sum of the efficiencies and, because they are \
those of scalar theory, by how much they err.

--sweep computes the orders over a range, in unpolarised, TE and TM light: of wavelengths [nm]; of the angle of incidence [degrees], negative beyond the normal, in the \
plane of --light's PHI; or of heights [nm] from the lowest point to the highest, to which the surface is stretched. Its rows have wavelength, theta_i and \
height; m, n, theta_r and phi_r; te, tm and mean, the efficiencies; and error_te, error_tm and error_mean, the shares of the diffracted light that the \
theory puts elsewhere, from rigorous computations, empty where none was made.

Examples:
  diffract orders blaze --light 30,0 --wavelength 550nm
  diffract orders sinusoid --light 60,30 --wavelength 450nm --wavelength 650nm --material aluminium -o orders.csv
  diffract orders elaphe --light 30,0 --wavelength 550nm --least 1e-3
  diffract orders blaze --light 30,0 --sweep wavelength 400:700:5 --plot efficiencies.svg
  diffract orders sinusoid --wavelength 550nm --sweep angle -60:60:2 --material aluminium -o angles.csv"
)]
pub struct Arguments {
    /// Height field: a file or a built-in name
    surface_name: Option<OsString>,
    /// Direction of the light, in degrees from the normal and from +x toward +y
    #[arg(long, value_name = "THETA,PHI", value_parser = light, allow_hyphen_values = true, required_unless_present = "sweep")]
    light: Option<FarLight>,
    /// Wavelength of the light, as in 550nm; may be given several times
    #[arg(
        long, value_name = "LENGTH", value_parser = evaluation::wavelength, allow_hyphen_values = true,
        required_unless_present = "sweep"
    )]
    wavelength: Vec<f64>,
    /// Compute the orders over a range: of wavelength (nm), angle (of incidence, degrees) or height (nm), as in --sweep wavelength 400:700:5
    #[arg(long, num_args = 2, value_names = ["QUANTITY", "LO:HI:STEP"], allow_hyphen_values = true)]
    sweep: Option<Vec<String>>,
    /// Draw the efficiencies of a sweep as SVG or PNG
    #[arg(long, value_name = "FILE", requires = "sweep")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    figure: FigureOptions,
    /// Smallest efficiency of an order that is written
    #[arg(long, value_name = "SHARE", value_parser = least, allow_hyphen_values = true, default_value = "1e-9")]
    least: f64,
    /// Output file, instead of stdout
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the answer as JSON too: input, settings, and a row for each of the table
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    json: Option<PathBuf>,
    #[command(flatten)]
    surface: SurfaceOptions,
    #[command(flatten)]
    surface_reflectance: ReflectanceOptions,
}

/// Parses the direction of a light that is a point of the sky.
fn light(text: &str) -> Result<FarLight> {
    let light = FarLight::parse(text)?;
    if light.size > 0.0 || light.intensity != 1.0 || light.theta >= 90.0 {
        return Err(Error::usage(
            format!("'{text}' is no direction of light"),
            "give THETA,PHI with THETA below 90, as in 30,0",
        ));
    }
    Ok(light)
}

fn least(text: &str) -> Result<f64> {
    share(text, (0.0, 1.0), "share of the light")
}

/// Computes the orders and writes them.
pub fn run(arguments: &Arguments, console: &Console) -> Result<()> {
    arguments.plot.as_deref().map(FigureFormat::of).transpose()?;
    let style = arguments.figure.style(arguments.plot.is_some(), &figure::PANELS)?;
    Files::new()
        .reads(arguments.surface.files(arguments.surface_name.as_deref()).map(Path::new))
        .reads(arguments.surface_reflectance.files().map(Path::new))
        .writes([&arguments.output, &arguments.json, &arguments.plot].into_iter().flatten())
        .check()?;
    arguments.surface_reflectance.check()?;
    arguments.surface_reflectance.tell(console);
    let sweep = arguments.sweep.as_deref().map(Sweep::parse).transpose()?;
    if let Some(sweep) = &sweep {
        arguments.check_sweep(sweep)?;
    }
    let reflectance = arguments.surface_reflectance.of_surface(None);
    for &wavelength in &arguments.wavelength {
        reflectance.check_wavelength(wavelength)?;
    }
    let field = arguments.surface.load(arguments.surface_name.as_deref(), None, "elaphe", console)?;
    tell_of_broken_copies(&field, console)?;
    let cell = field.unit_cell()?;
    match &sweep {
        Some(sweep) => run_sweep(arguments, sweep, &field, &cell, &reflectance, &style, console),
        None => run_single(arguments, &field, &cell, &reflectance, console),
    }
}

/// Tells what copies of the patch of `field` break, if they do: its light is in the orders.
fn tell_of_broken_copies(field: &HeightField, console: &Console) -> Result<()> {
    let tiling = joining(field)?;
    let broken = tiling.broken_in_words();
    if !broken.is_empty() {
        console.say(&format_args!(
            "the patch holds {}: its copies break the grooves, whose orders move to whole periods; crop the patch to whole periods (--crop)",
            broken.join(" and ")
        ));
    } else if Beyond::across(&tiling) == Beyond::Alike {
        console.say(
            &"the edges of the patch do not meet: its copies have steps, whose light is in the orders; crop the patch to whole periods (--crop)",
        );
    }
    Ok(())
}

/// Returns what is said of efficiencies that add up to `sum`; `None` where the surface sends no more light than it gets.
fn excess_of_sum(sum: f64) -> Option<&'static str> {
    /// Sum above 1 that is more than rounding.
    const ABOVE_ONE: f64 = 1.0 + 1e-6;
    (sum > ABOVE_ONE).then_some(
        "this is more light than falls on the surface, because the theory does not hold here; `--theory small-slope` is limited to what a flat surface reflects",
    )
}

/// Computes the orders at the wavelengths of `arguments` and writes them.
fn run_single(
    arguments: &Arguments,
    field: &HeightField,
    cell: &HeightField,
    reflectance: &Reflectance,
    console: &Console,
) -> Result<()> {
    let shortest = arguments.wavelength.iter().copied().fold(f64::INFINITY, f64::min);
    prepare::warn_of_coarse_samples(console, field, shortest);
    let light = arguments.light.map_or(DVec3::Z, |light| direction(light.theta, light.phi));
    let mut table = write::Csv::new();
    table.row(["wavelength", "m", "n", "theta_r", "phi_r", "efficiency", "reflectance", "period"]);
    let relief = Relief::of(field)?;
    for &wavelength in &arguments.wavelength {
        let orders = orders(cell, reflectance, light, wavelength, console)?;
        let told = EfficiencySums::of(&orders, arguments.least);
        let theory = ScalarTheory::new(relief, reflectance, LightColour::Wavelength(wavelength));
        told.tell(cell, &format!("{:.1} nm", wavelength * NM_PER_UM), &theory, console);
        for order in orders.iter().filter(|order| is_written(order, arguments.least)) {
            table.row(cells(order, wavelength));
        }
    }
    arguments.write(&table, field, reflectance, console)
}

/// Computes the orders over a sweep, and writes and draws them.
fn run_sweep(
    arguments: &Arguments,
    sweep: &Sweep,
    field: &HeightField,
    cell: &HeightField,
    reflectance: &Reflectance,
    style: &FigureStyle,
    console: &Console,
) -> Result<()> {
    let runs = sweep::of(arguments, sweep, field, cell, reflectance, console)?;
    sweep::tell(sweep, &runs, console);
    arguments.write(&sweep::table(&runs), field, reflectance, console)?;
    match &arguments.plot {
        Some(path) => {
            let drawn = figure::figure(arguments, sweep, field, reflectance, &runs);
            drawn.save(path, style, &captions::notes(field, console))
        }
        None => Ok(()),
    }
}

/// Settings of the orders in the JSON.
#[derive(Serialize)]
struct OrderSettings {
    /// Polar angle and azimuth of the light; absent where a sweep has them.
    light_deg: Option<[f64; 2]>,
    reflectance: String,
    theory: &'static str,
}

impl Arguments {
    /// Writes the table of the orders of `field`, as CSV and as JSON.
    fn write(
        &self,
        table: &write::Csv,
        field: &HeightField,
        reflectance: &Reflectance,
        console: &Console,
    ) -> Result<()> {
        write::result(self.output.as_deref(), &table.text()?, console)?;
        let Some(path) = &self.json else { return Ok(()) };
        let name = self.surface.name(self.surface_name.as_deref());
        let settings = OrderSettings {
            light_deg: self.light.map(|light| [light.theta, light.phi]),
            reflectance: reflectance.to_string(),
            theory: reflectance.theory().name(),
        };
        let notes = captions::notes(field, console);
        write::json(path, &TableAnswer::new(AskedSurface::new(name, field), settings, table, &notes))
    }

    /// Checks that the options leave open what `sweep` changes, and nothing else.
    fn check_sweep(&self, sweep: &Sweep) -> Result<()> {
        let refused = |what: &'static str, remedy: &'static str| Err(Error::usage(what, remedy));
        match (sweep.quantity, self.wavelength.is_empty()) {
            (SweptQuantity::Wavelength, false) => {
                return refused(
                    "a sweep of the wavelength has wavelengths already",
                    "leave --wavelength away",
                );
            }
            (SweptQuantity::Angle | SweptQuantity::Height, true) => {
                return refused("the orders need a wavelength", "add --wavelength, as in --wavelength 550nm");
            }
            _ => {}
        }
        if self.light.is_none() && sweep.quantity != SweptQuantity::Angle {
            return refused("the orders need a direction of light", "add --light, as in --light 30,0");
        }
        if self.surface_reflectance.polarisation.is_some() {
            return refused(
                "a sweep has light of both polarisations already",
                "leave --polarisation away; its columns are te, tm and mean",
            );
        }
        Ok(())
    }
}

/// Returns the orders of `cell`, with a progress bar.
fn orders(
    cell: &HeightField,
    reflectance: &Reflectance,
    light: DVec3,
    wavelength: f64,
    console: &Console,
) -> Result<Vec<DiffractionOrder>> {
    let bar = ProgressBar::new(console, "orders", "a part of the surface (--crop)");
    MeanBrdf::in_sunlight(cell, reflectance.clone()).orders(light, wavelength, &bar.task())
}

/// Returns true for an order with light, of at least the share `least`.
fn is_written(order: &DiffractionOrder, least: f64) -> bool {
    order.efficiency > 0.0 && order.efficiency >= least
}

/// Sums over the orders of one wavelength.
struct EfficiencySums {
    /// Number of orders that are written, and their efficiency.
    written: (usize, f64),
    /// Number of orders with less light than that, and their efficiency.
    fainter: (usize, f64),
    /// Smallest efficiency of an order that is written.
    least: f64,
    /// Largest divisor by which the theory is limited.
    limit: f64,
}

impl EfficiencySums {
    /// Returns the sums over `orders`, of which those with an efficiency of `least` or more are written.
    fn of(orders: &[DiffractionOrder], least: f64) -> Self {
        let lit = orders.iter().filter(|order| order.efficiency > 0.0);
        let (written, fainter): (Vec<_>, Vec<_>) = lit.partition(|order| is_written(order, least));
        let sum = |orders: &[&DiffractionOrder]| {
            (orders.len(), orders.iter().map(|order| order.efficiency).sum::<f64>())
        };
        let limit = orders.iter().map(|order| order.limit).fold(1.0, f64::max);
        Self { written: sum(&written), fainter: sum(&fainter), least, limit }
    }

    /// Tells the share of the light of this `wavelength` that the orders of `cell` take, and by how much they err.
    fn tell(&self, cell: &HeightField, wavelength: &str, theory: &ScalarTheory, console: &Console) {
        let [x, y] = cell.patch_size();
        let (count, share) = self.written;
        let faint = match self.fainter {
            (0, _) => String::new(),
            (fainter, share) => {
                format!("; {fainter} below {:e} are left out, {share:.1e} together", self.least)
            }
        };
        console.say(&format_args!(
            "{wavelength}: {count} orders of a cell of {x:.4} x {y:.4} um take {share:.4} of the light{faint}"
        ));
        if let Some(excess) = excess_of_sum(share + self.fainter.1) {
            console.say(&format_args!("{wavelength}: {excess}"));
        }
        if let Some(note) = excess_note(self.limit) {
            console.say(&format_args!("{wavelength}: {note}"));
        }
        console.say(&format_args!("{wavelength}: scalar theory: {}", theory.line()));
    }
}

/// Returns the cells of a row.
fn cells(order: &DiffractionOrder, wavelength: f64) -> [String; 8] {
    let [m, n] = order.numbers;
    let (theta, phi) = angles(order.view);
    [
        format!("{}", rounded(wavelength * NM_PER_UM)),
        m.to_string(),
        n.to_string(),
        format!("{theta:.6}"),
        format!("{phi:.6}"),
        format!("{:.9e}", order.efficiency),
        format!("{:.9e}", order.reflectance),
        order.period.map_or(String::new(), |period| format!("{:.6}", period * NM_PER_UM)),
    ]
}

/// Returns `nanometres` without the rounding of its conversion.
fn rounded(nanometres: f64) -> f64 {
    (nanometres * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_directions_above_the_horizon() {
        assert_eq!(light("30,-90").unwrap().theta, 30.0);
        for bad in ["90,0", "30", "sun:30,0", "disc:2deg:30,0", "30,0,2", "-30,0"] {
            assert!(light(bad).is_err(), "{bad}");
        }
        for bad in ["-1e-3", "2", "nan", ""] {
            assert!(least(bad).is_err(), "{bad}");
        }
    }
}
