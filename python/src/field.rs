//! Height fields.

use crate::arrays::{floats, rows};
use crate::context::CoreContext;
use crate::errors::{argument, raised};
use crate::inside::{self, Origin, ReadField};
use crate::optics::CoreOptics;
use crate::units::{metres, micrometres};
use crate::work::{self, warn};
use diffract::{HeightField, ReadSettings, Spec, SurfaceKind};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyBytes;
use std::path::PathBuf;

/// Micrometres of a metre.
const UM: f64 = 1e6;

/// Height field and its origin.
#[pyclass(frozen, module = "diffract._diffract")]
pub struct CoreField {
    /// The heights.
    pub field: HeightField,
    origin: Origin,
    /// Heights \[m\] as an array that may only be read; made when they are asked for first.
    metres: PyOnceLock<Py<PyAny>>,
}

/// Everything of a field that a pickle holds: heights \[µm\] as bytes, columns and rows, pixel size \[µm\], steps, name.
type State<'py> = (Bound<'py, PyBytes>, [usize; 2], [f64; 2], Vec<String>, String);

impl CoreField {
    fn new(field: HeightField, origin: Origin) -> Self {
        Self { field, origin, metres: PyOnceLock::new() }
    }

    /// Returns a field that was read, and warns of what a user should know.
    fn told(py: Python<'_>, ReadField { field, origin, warnings }: ReadField) -> PyResult<Self> {
        warnings.iter().try_for_each(|warning| warn(py, &format!("{}: {warning}", origin.name.display())))?;
        Ok(Self::new(field, origin))
    }
}

#[pymethods]
impl CoreField {
    /// Makes a field of an array of heights \[m\].
    #[staticmethod]
    fn from_heights(
        py: Python<'_>,
        heights: &Bound<'_, PyAny>,
        pixel_size: [f64; 2],
        context: &CoreContext,
    ) -> PyResult<Self> {
        let (size, heights) = rows("heights", &floats("heights", heights)?)?;
        let pixel_size = pixel_size.map(micrometres);
        let read = work::run(py, context, None, move |_, _| inside::from_metres(size, pixel_size, heights))?;
        Self::told(py, read)
    }

    /// Reads a file.
    #[staticmethod]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        channel: Option<String>,
        pixel_size: Option<[f64; 2]>,
        height: Option<f64>,
        context: &CoreContext,
    ) -> PyResult<Self> {
        let read = work::run(py, context, None, move |_, task| {
            let mut settings = ReadSettings::new();
            settings.channel = channel.as_deref();
            settings.pixel_size = pixel_size.map(|sizes| sizes.map(micrometres));
            settings.height = height.map(micrometres);
            inside::read(&path, &settings, task)
        })?;
        Self::told(py, read)
    }

    /// Generates a surface.
    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python, each with a name")]
    fn generate(
        py: Python<'_>,
        kind: &str,
        seed: u64,
        patch: Option<[f64; 2]>,
        pixel_size: Option<[f64; 2]>,
        period: Option<f64>,
        height: Option<f64>,
        duty: Option<f64>,
        flank: Option<f64>,
        context: &CoreContext,
    ) -> PyResult<Self> {
        let named = SurfaceKind::ALL.into_iter().find(|known| known.name() == kind);
        let Some(named) = named else {
            let known = SurfaceKind::ALL.map(SurfaceKind::name).join(", ");
            return Err(argument(
                "kind",
                format_args!("has no value {kind:?}"),
                &format!("give one of {known}"),
            ));
        };
        let mut spec = Spec::new(named).with_seed(seed);
        spec.patch = patch.map(|sides| sides.map(micrometres));
        spec.pixel_size = pixel_size.map(|sizes| sizes.map(micrometres));
        spec.period = period.map(micrometres);
        spec.height = height.map(micrometres);
        spec.duty = duty;
        spec.flank = flank.map(micrometres);
        let field = work::run(py, context, None, move |_, _| HeightField::generate(&spec))?;
        let warnings = inside::questions(&field);
        Self::told(py, ReadField { field, origin: Origin::computed(kind), warnings })
    }

    /// Makes the field that a pickle describes.
    #[staticmethod]
    fn from_state(
        heights: &[u8],
        size: [usize; 2],
        pixel_size: [f64; 2],
        steps: Vec<String>,
        name: &str,
    ) -> PyResult<Self> {
        let floats = heights.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let field = HeightField::new(size[0], size[1], pixel_size, floats).map_err(raised)?;
        Ok(Self::new(inside::with_steps(field, &steps), Origin::computed(name)))
    }

    /// Returns everything that a pickle holds.
    fn state<'py>(&self, py: Python<'py>) -> State<'py> {
        let bytes: Vec<u8> = self.field.heights().iter().flat_map(|height| height.to_le_bytes()).collect();
        let size = [self.field.columns(), self.field.rows()];
        (PyBytes::new(py, &bytes), size, self.field.pixel_size(), inside::steps(&self.field), self.name())
    }

    /// Returns a view of the heights \[m\], which may only be read.
    fn heights<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let all = self.metres.get_or_try_init(py, || -> PyResult<Py<PyAny>> {
            let metres = self.field.heights().iter().map(|height| height / UM).collect();
            let array = Array2::from_shape_vec((self.field.rows(), self.field.columns()), metres);
            let array = array.map_err(|e| argument("heights", e, "report this as a bug of diffract"))?;
            let array = array.into_pyarray(py);
            array.readwrite().make_nonwriteable();
            Ok(array.into_any().unbind())
        })?;
        all.bind(py).call_method0("view")
    }

    /// Number of columns and of rows.
    fn size(&self) -> [usize; 2] {
        [self.field.columns(), self.field.rows()]
    }

    /// Distance of samples along x and y \[m\].
    fn pixel_size(&self) -> [f64; 2] {
        self.field.pixel_size().map(metres)
    }

    /// Sides of the patch along x and y \[m\].
    fn patch_size(&self) -> [f64; 2] {
        self.field.patch_size().map(metres)
    }

    /// Lowest and highest height \[m\].
    fn range(&self) -> (f64, f64) {
        let (low, high) = self.field.range();
        (low / UM, high / UM)
    }

    /// Name of the file or of the surface.
    fn name(&self) -> String {
        self.origin.name.to_string_lossy().into_owned()
    }

    /// Steps that prepared the heights.
    fn steps(&self) -> Vec<String> {
        inside::steps(&self.field)
    }

    /// Returns true if both have the same heights and scales.
    fn equals(&self, other: &Self) -> bool {
        let grid = |of: &Self| (of.size(), of.field.pixel_size());
        grid(self) == grid(other) && self.field.heights() == other.field.heights()
    }

    /// Returns the field after the steps, in words.
    fn prepare(&self, py: Python<'_>, steps: Vec<String>, context: &CoreContext) -> PyResult<Self> {
        let field = self.field.clone();
        let prepared = work::run(py, context, None, move |_, task| {
            field.prepare(&steps.iter().map(String::as_str).collect::<Vec<_>>(), task)
        })?;
        Ok(Self::new(prepared, self.origin.prepared()))
    }

    /// Returns the report as JSON.
    fn report(&self, py: Python<'_>, optics: &CoreOptics, context: &CoreContext) -> PyResult<String> {
        let (field, origin, optics) = (self.field.clone(), self.origin.clone(), optics.clone());
        work::run(py, context, None, move |_, task| inside::report(&field, &origin, &optics.of(&field), task))
    }

    /// Writes the field to a file.
    fn save(&self, py: Python<'_>, path: PathBuf, context: &CoreContext) -> PyResult<()> {
        let field = self.field.clone();
        work::run(py, context, None, move |_, _| field.save(&path))
    }

    /// Returns a picture of the heights as a PNG.
    fn preview<'py>(&self, py: Python<'py>, most: usize) -> PyResult<Bound<'py, PyBytes>> {
        let png = py.detach(|| self.field.preview(most)).map_err(raised)?;
        Ok(PyBytes::new(py, &png))
    }
}
