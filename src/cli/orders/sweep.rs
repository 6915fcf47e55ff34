//! Efficiencies of the orders over a range of wavelengths, angles of incidence or heights, in both polarisations.

use super::{Arguments, NM_PER_UM, excess_of_sum, is_written, rounded};
use crate::brdf::DiffractionOrder;
use crate::brdf::energy_map::excess_note;
use crate::brdf::mean::MeanBrdf;
use crate::cli::console::Console;
use crate::cli::progress::ProgressBar;
use crate::cli::range::Range;
use crate::cli::{evaluation, prepare, write};
use crate::error::{Error, Result};
use crate::optics::geometry::{angles, direction};
use crate::optics::polarisation::Polarisation;
use crate::optics::reflectance::{DielectricLaw, Reflectance};
use crate::optics::validity::{AngleErrors, LightColour, ScalarTheory};
use crate::surface::HeightField;
use crate::surface::statistics::Relief;
use crate::task::{Progress, Task};

/// Largest height of a sweep \[nm\].
const HIGHEST: f64 = 1e5;

/// Quantity that a sweep changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SweptQuantity {
    /// Wavelength \[nm\].
    Wavelength,
    /// Angle of incidence \[degrees\].
    Angle,
    /// Difference between the highest and the lowest point of the surface \[nm\].
    Height,
}

impl SweptQuantity {
    const ALL: [Self; 3] = [Self::Wavelength, Self::Angle, Self::Height];

    /// Returns the name on the command line.
    fn name(self) -> &'static str {
        match self {
            Self::Wavelength => "wavelength",
            Self::Angle => "angle",
            Self::Height => "height",
        }
    }

    /// Returns the label of an axis.
    pub fn label(self) -> &'static str {
        match self {
            Self::Wavelength => "wavelength [nm]",
            Self::Angle => "angle of incidence [°]",
            Self::Height => "height [nm]",
        }
    }

    /// Returns the least and the largest value.
    fn limits(self) -> (f64, f64) {
        match self {
            Self::Wavelength => {
                let (low, high) = evaluation::WAVELENGTHS;
                (low * NM_PER_UM, high * NM_PER_UM)
            }
            Self::Angle => (-89.0, 89.0),
            Self::Height => (0.0, HIGHEST),
        }
    }
}

/// Values of one quantity.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    pub quantity: SweptQuantity,
    range: Range,
}

impl Sweep {
    /// Parses a quantity and its `LO:HI:STEP`.
    pub fn parse(words: &[String]) -> Result<Self> {
        let [name, range] = words else {
            return Err(Error::usage(
                "a sweep has a quantity and a range",
                "give both, as in --sweep wavelength 400:700:5",
            ));
        };
        let quantity = SweptQuantity::ALL.into_iter().find(|quantity| quantity.name() == name);
        let quantity = quantity.ok_or_else(|| {
            Error::usage(
                format!("there is no sweep of `{name}`"),
                "give wavelength (nm), angle (degrees) or height (nm)",
            )
        })?;
        Ok(Self { quantity, range: Range::parse(range, quantity.limits(), quantity.label())? })
    }

    /// Returns every point for which orders are computed, a run of the sweep for each wavelength of `arguments`, on a surface that is `height`
    /// \[µm\] high.
    fn points(&self, arguments: &Arguments, height: f64) -> Vec<Vec<Conditions>> {
        let [theta, phi] = arguments.light.map_or([0.0; 2], |light| [light.theta, light.phi]);
        let run = |wavelength: f64| -> Vec<Conditions> {
            let fixed = Conditions { wavelength, theta, phi, height };
            let at = |value: f64| match self.quantity {
                SweptQuantity::Wavelength => Conditions { wavelength: value / NM_PER_UM, ..fixed },
                SweptQuantity::Angle => Conditions { theta: value, ..fixed },
                SweptQuantity::Height => Conditions { height: value / NM_PER_UM, ..fixed },
            };
            self.range.values().into_iter().map(at).collect()
        };
        match self.quantity {
            SweptQuantity::Wavelength => vec![run(0.0)],
            _ => arguments.wavelength.iter().map(|&wavelength| run(wavelength)).collect(),
        }
    }
}

/// Light and height for which orders are computed.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// \[µm\].
    pub wavelength: f64,
    /// Angle of incidence \[degrees\]; negative on the other side of the normal.
    pub theta: f64,
    /// Azimuth of the light \[degrees\].
    pub phi: f64,
    /// Difference between the highest and the lowest point \[µm\].
    pub height: f64,
}

impl Conditions {
    /// Returns the value of a quantity in its unit.
    pub fn value(&self, quantity: SweptQuantity) -> f64 {
        match quantity {
            SweptQuantity::Wavelength => rounded(self.wavelength * NM_PER_UM),
            SweptQuantity::Angle => self.theta,
            SweptQuantity::Height => rounded(self.height * NM_PER_UM),
        }
    }
}

/// Order in light of both polarisations.
#[derive(Clone, Copy, Debug)]
pub struct PolarisedOrder {
    /// The order in unpolarised light.
    pub mean: DiffractionOrder,
    /// Efficiencies in TE and TM light; `None` by Schlick's approximation, which knows no polarisation.
    pub polarised: Option<[f64; 2]>,
}

/// Orders at one point of a sweep.
pub struct SweepPoint {
    pub conditions: Conditions,
    /// Orders with light, of at least the share that is asked for.
    pub orders: Vec<PolarisedOrder>,
    /// Sum of the efficiencies of all orders.
    pub sum: f64,
    /// Largest divisor by which the theory is limited.
    limit: f64,
    /// Errors of the theory; `None` where they are not known.
    errors: Option<AngleErrors>,
}

/// Computes the orders over the sweep; returns a run for each wavelength.
pub fn of(
    arguments: &Arguments,
    sweep: &Sweep,
    field: &HeightField,
    cell: &HeightField,
    reflectance: &Reflectance,
    console: &Console,
) -> Result<Vec<Vec<SweepPoint>>> {
    let (low, high) = field.range();
    let height = high - low;
    if sweep.quantity == SweptQuantity::Height && height == 0.0 {
        return Err(Error::usage("a flat surface has no heights to change", "name another surface"));
    }
    let points = sweep.points(arguments, height);
    for wavelength in points.iter().flatten().map(|at| at.wavelength) {
        reflectance.check_wavelength(wavelength)?;
    }
    let shortest = points.iter().flatten().map(|at| at.wavelength).fold(f64::INFINITY, f64::min);
    prepare::warn_of_coarse_samples(console, field, shortest);
    let count = points.iter().map(Vec::len).sum();
    let bar = ProgressBar::new(console, "orders", "a range with larger steps");
    let mut done = 0;
    let mut stretched: Option<StretchedSurface> = None;
    let mut of_point = |conditions: &Conditions| -> Result<SweepPoint> {
        bar.show(&Progress { stage: "orders", done, of: count });
        done += 1;
        let scale = if height > 0.0 { conditions.height / height } else { 1.0 };
        // Only a sweep of heights has more than one.
        let surface = match stretched.take().filter(|surface| surface.scale == scale) {
            Some(surface) => surface,
            None => StretchedSurface::of(field, cell, scale)?,
        };
        point(*conditions, stretched.insert(surface), reflectance, arguments.least)
    };
    points.iter().map(|run| run.iter().map(&mut of_point).collect()).collect()
}

/// Surface whose heights are multiplied by a factor.
struct StretchedSurface {
    scale: f64,
    cell: HeightField,
    relief: Relief,
}

impl StretchedSurface {
    fn of(field: &HeightField, cell: &HeightField, scale: f64) -> Result<Self> {
        Ok(Self { scale, cell: scaled(cell, scale)?, relief: Relief::of(&scaled(field, scale)?)? })
    }
}

/// Returns `field` with heights multiplied by `scale`.
fn scaled(field: &HeightField, scale: f64) -> Result<HeightField> {
    let heights = field.heights().iter().map(|h| h * scale).collect();
    HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights)
}

/// Computes the orders of `surface` under one set of conditions.
fn point(
    conditions: Conditions,
    surface: &StretchedSurface,
    reflectance: &Reflectance,
    least: f64,
) -> Result<SweepPoint> {
    let Conditions { wavelength, theta, phi, .. } = conditions;
    let light = direction(theta, phi);
    let in_light = |polarisation: Polarisation| {
        let reflectance = reflectance.clone().polarised(polarisation);
        MeanBrdf::in_sunlight(&surface.cell, reflectance).orders(light, wavelength, &Task::silent())
    };
    let mean = in_light(Polarisation::None)?;
    let is_polarised = reflectance.law() != DielectricLaw::Schlick;
    let polarised = is_polarised
        .then(|| Ok::<_, Error>([in_light(Polarisation::Te)?, in_light(Polarisation::Tm)?]))
        .transpose()?;
    let both =
        |place: usize| polarised.as_ref().map(|lists| lists.each_ref().map(|list| list[place].efficiency));
    let orders = mean.iter().enumerate().filter(|(_, order)| is_written(order, least));
    let theory = ScalarTheory::new(surface.relief, reflectance, LightColour::Wavelength(wavelength));
    Ok(SweepPoint {
        conditions,
        orders: orders
            .map(|(place, order)| PolarisedOrder { mean: *order, polarised: both(place) })
            .collect(),
        sum: mean.iter().map(|order| order.efficiency).sum(),
        limit: mean.iter().map(|order| order.limit).fold(1.0, f64::max),
        errors: theory.at_angle(theta.abs()),
    })
}

/// Returns the CSV of a sweep: a row for each order at each point.
pub fn table(runs: &[Vec<SweepPoint>]) -> write::Csv {
    let mut table = write::Csv::new();
    table.row([
        "wavelength",
        "theta_i",
        "height",
        "m",
        "n",
        "theta_r",
        "phi_r",
        "te",
        "tm",
        "mean",
        "error_te",
        "error_tm",
        "error_mean",
    ]);
    let share = |share: Option<f64>| share.map_or_else(String::new, |share| format!("{share:.9e}"));
    let error = |error: Option<f64>| error.map_or_else(String::new, |error| format!("{error:.4}"));
    for point in runs.iter().flatten() {
        let given = [SweptQuantity::Wavelength, SweptQuantity::Angle, SweptQuantity::Height];
        let errors = point.errors;
        for PolarisedOrder { mean, polarised } in &point.orders {
            let (theta, phi) = angles(mean.view);
            let mut cells: Vec<String> =
                given.iter().map(|quantity| point.conditions.value(*quantity).to_string()).collect();
            cells.extend(mean.numbers.map(|number| number.to_string()));
            cells.extend([theta, phi].map(|angle| format!("{angle:.6}")));
            cells.extend([share(polarised.map(|p| p[0])), share(polarised.map(|p| p[1]))]);
            cells.push(share(Some(mean.efficiency)));
            cells.extend([errors.map(|e| e.te), errors.map(|e| e.tm), errors.map(|e| e.mean)].map(error));
            table.row(cells);
        }
    }
    table
}

/// Tells what share of the light all orders take over the sweep, and where the theory sends too much.
pub fn tell(sweep: &Sweep, runs: &[Vec<SweepPoint>], console: &Console) {
    let points = || runs.iter().flatten();
    let sums = points().map(|point| point.sum);
    let (least, most) = sums.fold((f64::INFINITY, 0.0f64), |(low, high), sum| (low.min(sum), high.max(sum)));
    console.say(&format_args!(
        "{} points; all orders together take {least:.4} to {most:.4} of the light",
        points().count()
    ));
    if let Some(excess) = excess_of_sum(most) {
        console.say(&excess);
    }
    let limit = points().map(|point| point.limit).fold(1.0, f64::max);
    if let Some(note) = excess_note(limit) {
        console.say(&note);
    }
    let unknown: Vec<f64> = points()
        .filter(|point| point.errors.is_none())
        .map(|point| point.conditions.value(sweep.quantity))
        .collect();
    if let (Some(first), Some(last)) = (unknown.first(), unknown.last()) {
        console.say(&format_args!(
            "the theory's error is not known at {} of the points, between {first} and {last} (empty cells; `surface info` says why)",
            unknown.len()
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_names_its_quantity_and_range() {
        let parse = |name: &str, range: &str| Sweep::parse(&[name.to_owned(), range.to_owned()]);
        assert_eq!(parse("angle", "-60:60:5").unwrap().range.count(), 25);
        for (name, range, reason) in [
            ("colour", "400:700:5", "no sweep of `colour`"),
            ("angle", "-90:60:5", "out of bounds"),
            ("height", "-1:60:5", "out of bounds"),
            ("wavelength", "1:60:5", "out of bounds"),
            ("wavelength", "400", "three numbers"),
        ] {
            let error = parse(name, range).unwrap_err().to_string();
            assert!(error.contains(reason), "{name} {range}: {error}");
        }
    }
}
