//! Orders and peaks of a surface, as columns of tables.

use crate::arrays::{by_wavelength, floats, one_direction};
use crate::brdf::column;
use crate::context::CoreContext;
use crate::errors::argument;
use crate::field::CoreField;
use crate::optics::CoreOptics;
use crate::units::{metres, micrometres};
use crate::work;
use diffract::{AngularPeak, GratingOrder, MeasuredPeriod, PeakSettings};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Returns the columns of the orders at all wavelengths \[m\], in their order.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python, each with a name")]
pub fn orders<'py>(
    field: &CoreField,
    py: Python<'py>,
    light: &Bound<'py, PyAny>,
    wavelengths: &Bound<'py, PyAny>,
    least: f64,
    optics: &CoreOptics,
    context: &CoreContext,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let light = one_direction("light", light)?;
    let asked: Vec<f64> = floats("wavelength", wavelengths)?.as_array().iter().copied().collect();
    if asked.iter().any(|metres| metres.is_nan()) {
        return Err(argument("wavelength", "is not a number", "give lengths in metres, as in 550e-9"));
    }
    let (field, optics) = (field.field.clone(), optics.clone());
    let groups = by_wavelength(&asked.iter().map(|metres| [*metres]).collect::<Vec<_>>());
    let found = work::run(py, context, progress, move |_, task| {
        let optics = optics.of(&field);
        let mut found: Vec<(usize, f64, Vec<GratingOrder>)> = Vec::new();
        for (wavelength, places) in groups {
            let orders = field.orders(&optics, light, wavelength, task)?;
            found.extend(places.into_iter().map(|place| (place, wavelength, orders.clone())));
        }
        found.sort_by_key(|(place, ..)| *place);
        Ok(found)
    })?;
    let is_written = |order: &GratingOrder| order.efficiency > 0.0 && order.efficiency >= least;
    let rows = found.into_iter().flat_map(|(_, wavelength, orders)| {
        orders.into_iter().filter(is_written).map(move |order| (wavelength, order))
    });
    order_columns(py, &rows.collect::<Vec<_>>())
}

/// Returns the columns of the peaks, the period, and those of the branches, in metres and degrees.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python, each with a name")]
pub fn peaks<'py>(
    field: &CoreField,
    py: Python<'py>,
    theta_i: f64,
    azimuth: f64,
    angles: &Bound<'py, PyAny>,
    wavelengths: &Bound<'py, PyAny>,
    order: u32,
    period: Option<f64>,
    over_windows: bool,
    optics: &CoreOptics,
    context: &CoreContext,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, Period, Vec<Period>)> {
    let list = |name: &str, value: &Bound<'py, PyAny>| -> PyResult<Vec<f64>> {
        Ok(floats(name, value)?.as_array().iter().copied().collect())
    };
    let wavelengths = list("wavelengths", wavelengths)?.into_iter().map(micrometres).collect();
    let settings = PeakSettings::new(theta_i, list("angles", angles)?)
        .with_azimuth(azimuth)
        .with_wavelengths(wavelengths)
        .with_order(order, period.map(micrometres))
        .with_error_over_windows(over_windows);
    let (field, optics) = (field.field.clone(), optics.clone());
    let found = work::run(py, context, progress, move |context, task| {
        field.peaks(&optics.of(&field), &settings, context, task)
    })?;
    let branches = found.branches.iter().map(in_metres).collect();
    Ok((peak_columns(py, &found.peaks)?, in_metres(&found.period), branches))
}

/// Mean, standard deviation, standard error and half of the 95 % interval of a period \[m\]; number of wavelengths.
type Period = ([Option<f64>; 4], usize);

fn in_metres(period: &MeasuredPeriod) -> Period {
    let MeasuredPeriod { mean, deviation, error, half_interval, wavelengths, .. } = *period;
    ([mean, deviation, error, half_interval].map(|length| length.map(metres)), wavelengths)
}

/// Returns the columns of `rows` of a wavelength \[µm\] and an order.
fn order_columns<'py>(py: Python<'py>, rows: &[(f64, GratingOrder)]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    let add = |name: &str, value: &dyn Fn(&(f64, GratingOrder)) -> f64| {
        columns.set_item(name, column(py, rows.iter().map(value).collect())?)
    };
    add("wavelength", &|(wavelength, _)| metres(*wavelength))?;
    add("m", &|(_, order)| order.numbers[0] as f64)?;
    add("n", &|(_, order)| order.numbers[1] as f64)?;
    add("theta", &|(_, order)| order.angles[0])?;
    add("phi", &|(_, order)| order.angles[1])?;
    add("efficiency", &|(_, order)| order.efficiency)?;
    add("reflectance", &|(_, order)| order.reflectance)?;
    add("period", &|(_, order)| order.period.map_or(f64::NAN, metres))?;
    Ok(columns)
}

/// Returns the columns of `peaks`.
fn peak_columns<'py>(py: Python<'py>, peaks: &[AngularPeak]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    let add = |name: &str, value: &dyn Fn(&AngularPeak) -> f64| {
        columns.set_item(name, column(py, peaks.iter().map(value).collect())?)
    };
    add("wavelength", &|peak| metres(peak.wavelength))?;
    add("angle", &|peak| peak.angle.unwrap_or(f64::NAN))?;
    add("period", &|peak| peak.period.map_or(f64::NAN, metres))?;
    add("response", &|peak| peak.response)?;
    add("is_clear", &|peak| f64::from(u8::from(peak.is_clear)))?;
    add("branch", &|peak| peak.branch.map_or(-1.0, |branch| branch as f64))?;
    Ok(columns)
}
