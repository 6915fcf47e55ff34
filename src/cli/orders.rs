//! `diffract orders`: directions and efficiencies of the orders of a periodic surface.

use super::evaluation;
use super::options::{ReflectanceOptions, SurfaceOptions, real};
use super::prepare;
use super::verbosity::detail;
use super::{say, write};
use crate::brdf::DiffractionOrder;
use crate::brdf::energy_map::excess_note;
use crate::brdf::mean::MeanBrdf;
use crate::error::{Error, Result};
use crate::files::Files;
use crate::optics::coherence::Beyond;
use crate::optics::geometry::{angles, direction};
use crate::scene::FarLight;
use crate::setup;
use crate::surface::HeightField;
use clap::Args;
use glam::DVec3;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

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
1/sqrt((m/Tx)^2 + (n/Ty)^2), empty for the specular order. Efficiencies are those of scalar theory; `surface info` \
says by how much they err. -v prints their sum.

Examples:
  diffract orders blaze --light 30,0 --wavelength 550nm
  diffract orders sinusoid --light 60,30 --wavelength 450nm --wavelength 650nm --material aluminium -o orders.csv
  diffract orders elaphe --light 30,0 --wavelength 550nm --least 1e-3"
)]
pub struct Arguments {
    /// Height field: a file or a built-in name
    surface_name: Option<OsString>,
    /// Direction of the light, in degrees from the normal and from +x toward +y
    #[arg(long, value_name = "THETA,PHI", value_parser = light, allow_hyphen_values = true)]
    light: FarLight,
    /// Wavelength of the light, as in 550nm; may be given several times
    #[arg(
        long, value_name = "LENGTH", value_parser = evaluation::wavelength, allow_hyphen_values = true,
        required = true
    )]
    wavelength: Vec<f64>,
    /// Smallest efficiency of an order that is written
    #[arg(long, value_name = "SHARE", value_parser = least, allow_hyphen_values = true, default_value = "1e-9")]
    least: f64,
    /// Output file, instead of stdout
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
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
    real(text, (0.0, 1.0), "share of the light")
}

/// Computes the orders and writes them.
pub fn run(arguments: &Arguments) -> Result<()> {
    Files::new()
        .reads(arguments.surface.files(arguments.surface_name.as_deref()).map(Path::new))
        .reads(arguments.surface_reflectance.files().map(Path::new))
        .writes(&arguments.output)
        .check()?;
    arguments.surface_reflectance.check()?;
    let field = arguments.surface.load(arguments.surface_name.as_deref(), None, "elaphe")?;
    if setup::beyond_of(&field) == Beyond::Alike {
        say(
            &"the edges of the patch do not meet: its copies have steps, whose light is in the orders; crop the patch to whole periods (--crop)",
        );
    }
    let shortest = arguments.wavelength.iter().copied().fold(f64::INFINITY, f64::min);
    prepare::warn_of_coarse_samples(&field, shortest);
    let cell = field.unit_cell()?;
    let light = direction(arguments.light.theta, arguments.light.phi);
    let mut table = write::Csv::new();
    table.row(["wavelength", "m", "n", "theta_r", "phi_r", "efficiency", "reflectance", "period"])?;
    for &wavelength in &arguments.wavelength {
        let orders = orders(&cell, arguments, light, wavelength)?;
        tell(&orders, arguments.least, &cell, wavelength);
        for order in orders.iter().filter(|order| is_written(order, arguments.least)) {
            table.row(cells(order, wavelength))?;
        }
    }
    write::text(arguments.output.as_deref(), &table.text()?)
}

/// Returns the orders of `cell`, with a progress bar.
fn orders(
    cell: &HeightField,
    arguments: &Arguments,
    light: DVec3,
    wavelength: f64,
) -> Result<Vec<DiffractionOrder>> {
    let reflectance = arguments.surface_reflectance.of_surface(None);
    let bar = prepare::progress_bar("orders");
    let progress = |done, of| prepare::show(&bar, "orders", done, of);
    let orders = MeanBrdf::in_sunlight(cell, reflectance).orders(light, wavelength, &progress)?;
    bar.finish_and_clear();
    Ok(orders)
}

/// Returns true for an order with light, of at least the share `least`.
fn is_written(order: &DiffractionOrder, least: f64) -> bool {
    order.efficiency > 0.0 && order.efficiency >= least
}

/// Tells the share of the light that all `orders` take, and that of those below `least`.
fn tell(orders: &[DiffractionOrder], least: f64, cell: &HeightField, wavelength: f64) {
    let lit = orders.iter().filter(|order| order.efficiency > 0.0);
    let (written, fainter): (Vec<_>, Vec<_>) = lit.partition(|order| is_written(order, least));
    let sum = |orders: &[&DiffractionOrder]| orders.iter().map(|order| order.efficiency).sum::<f64>();
    let [x, y] = cell.patch_size();
    let faint = match fainter.len() {
        0 => String::new(),
        count => format!("; {count} below {least:e} are left out, {:.1e} together", sum(&fainter)),
    };
    if let Some(note) = excess_note(orders.iter().map(|order| order.limit).fold(1.0, f64::max)) {
        say(&format_args!("{:.1} nm: {note}", wavelength * NM_PER_UM));
    }
    detail(&format_args!(
        "{:.1} nm: {} orders of a cell of {x:.4} x {y:.4} um take {:.4} of the light{faint}",
        wavelength * NM_PER_UM,
        written.len(),
        sum(&written)
    ));
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
