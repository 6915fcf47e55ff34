//! Colour tables.

use crate::arrays::{Argument, Pairs, common_shape};
use crate::context::CoreContext;
use crate::errors::argument;
use crate::field::CoreField;
use crate::optics::CoreOptics;
use crate::work;
use diffract::SurfaceColours;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Number of values that are answered on the thread of the caller, with the interpreter's lock: less than a millisecond's.
const FEW: usize = 512;

/// Share by which a covariance of a matrix of rank one may exceed what is possible: its three numbers are rounded one by one.
const ROUNDING: f64 = 1e-9;

/// Colours of a surface in all directions, from a table.
#[pyclass(frozen, module = "diffract._diffract")]
pub struct CoreTable {
    colours: SurfaceColours,
}

#[pymethods]
impl CoreTable {
    /// Makes the table of `field` for footprints from `footprint` on, or takes it from the cache.
    #[new]
    fn new(
        py: Python<'_>,
        field: &CoreField,
        optics: &CoreOptics,
        footprint: f64,
        context: &CoreContext,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        if !(0.0..=0.5).contains(&footprint) {
            let remedy = "give a standard deviation of (u, v) from 0 to 0.5";
            return Err(argument("footprint", format_args!("is {footprint}"), remedy));
        }
        let (field, optics) = (field.field.clone(), optics.clone());
        let colours = work::run(py, context, progress, move |context, task| {
            SurfaceColours::new(&field, &optics.of(&field), footprint, context, task)
        })?;
        Ok(Self { colours })
    }

    /// Reads the table of an export.
    #[staticmethod]
    fn open(py: Python<'_>, folder: PathBuf, context: &CoreContext) -> PyResult<Self> {
        let colours = work::run(py, context, None, move |_, _| SurfaceColours::open(&folder))?;
        Ok(Self { colours })
    }

    /// Returns XYZ or linear sRGB over footprints: standard deviations of (u, v), or covariances of the shape (..., 2, 2).
    fn colours<'py>(
        &self,
        py: Python<'py>,
        light: &Bound<'py, PyAny>,
        view: &Bound<'py, PyAny>,
        footprint: &Bound<'py, PyAny>,
        is_covariance: bool,
        is_rgb: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (light, view) = (Argument::vectors("light", light)?, Argument::vectors("view", view)?);
        let name = if is_covariance { "covariance" } else { "footprint" };
        let footprint = match is_covariance {
            true => Argument::matrices(name, footprint)?,
            false => Argument::numbers(name, footprint)?,
        };
        let pairs = Pairs::new(&light, &view, common_shape(&[&light, &view, &footprint])?)?;
        let covariances: Vec<[f64; 3]> = match is_covariance {
            true => pairs.beside(&footprint)?.into_iter().map(|[uu, uv, _, vv]| [uu, uv, vv]).collect(),
            false => {
                pairs.beside(&footprint)?.into_iter().map(|[s]| [s * s.abs(), 0.0, s * s.abs()]).collect()
            }
        };
        if covariances
            .iter()
            .any(|[uu, uv, vv]| !(*uu >= 0.0 && *vv >= 0.0 && uv * uv <= uu * vv * (1.0 + ROUNDING)))
        {
            return Err(argument(
                name,
                "is negative or not a number",
                "give standard deviations, or covariances",
            ));
        }
        let asked: Vec<_> = pairs.pairs.iter().copied().zip(covariances).collect();
        let read = || {
            let mut colours = self.colours.xyz_over(&asked);
            if is_rgb {
                colours.iter_mut().for_each(|xyz| *xyz = diffract::linear_srgb(*xyz));
            }
            colours
        };
        let colours = if asked.len() <= FEW { read() } else { py.detach(read) };
        pairs.answer_colours(py, colours)
    }

    /// Size of the table \[bytes\].
    fn nbytes(&self) -> usize {
        self.colours.bytes()
    }

    /// Writes the table into a folder for other programs.
    fn export(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        context: &CoreContext,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let colours = self.colours.clone();
        work::run(py, context, progress, move |_, task| colours.save(&folder, task))
    }

    /// Reads every file of an export, and returns the relative error of its colours.
    #[staticmethod]
    fn check(py: Python<'_>, folder: PathBuf, context: &CoreContext) -> PyResult<f64> {
        work::run(py, context, None, move |_, _| diffract::check_export(&folder))
    }
}
