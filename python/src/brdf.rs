//! The BRDF of a surface.

use crate::arrays::{Argument, Pairs, by_wavelength, common_shape, one_direction, shaped};
use crate::context::{CoreContext, is_fork};
use crate::errors::{argument, raised};
use crate::field::CoreField;
use crate::optics::CoreOptics;
use crate::units::micrometres;
use crate::work;
use diffract::{SurfaceBrdf, Task};
use numpy::IntoPyArray;
use numpy::ndarray::ArrayD;
use pyo3::prelude::*;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

/// Number of values that are answered at once on the thread of the caller: they take less than a millisecond.
const FEW: usize = 64;

/// BRDF of a surface under some optics.
#[pyclass(frozen, module = "diffract._diffract")]
pub struct CoreBrdf {
    brdf: SurfaceBrdf,
    /// False for methods that take long for each value.
    is_quick: bool,
    /// Octaves of wavelengths, and the colours, for which everything is made that an answer takes beyond its directions.
    ready: Arc<Mutex<BTreeSet<Prepared>>>,
}

/// Kind of answers: the first of each makes data that the later ones share.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Prepared {
    /// Wavelengths of an octave.
    Octave(i32),
    /// Colours.
    Colours,
}

impl Prepared {
    /// Returns the octave of a `wavelength` \[µm\].
    fn of(wavelength: f64) -> Self {
        /// Shortest wavelength of the octave of visible light \[µm\].
        const SHORTEST: f64 = 0.38;
        Self::Octave((SHORTEST / wavelength).log2().ceil().max(0.0) as i32)
    }
}

#[pymethods]
impl CoreBrdf {
    /// Makes the BRDF of `field`.
    #[new]
    fn new(
        py: Python<'_>,
        field: &CoreField,
        optics: &CoreOptics,
        is_quick: bool,
        shortest: f64,
        context: &CoreContext,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (field, optics, shortest) = (field.field.clone(), optics.clone(), micrometres(shortest));
        let brdf = work::run(py, context, progress, move |_, task| {
            SurfaceBrdf::with_shortest(&field, &optics.of(&field), shortest, task)
        })?;
        Ok(Self { brdf, is_quick, ready: Arc::default() })
    }

    /// Returns f \[1/sr\] at wavelengths \[m\].
    fn spectral<'py>(
        &self,
        py: Python<'py>,
        light: &Bound<'py, PyAny>,
        view: &Bound<'py, PyAny>,
        wavelength: &Bound<'py, PyAny>,
        context: &CoreContext,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (light, view) = (Argument::vectors("light", light)?, Argument::vectors("view", view)?);
        let wavelength = Argument::numbers("wavelength", wavelength)?;
        let shape = common_shape(&[&light, &view, &wavelength])?;
        let mut pairs = Pairs::new(&light, &view, shape)?;
        let groups = by_wavelength(&pairs.beside(&wavelength)?);
        let asked = std::mem::take(&mut pairs.pairs);
        let prepared: Vec<_> = groups.iter().map(|(wavelength, _)| Prepared::of(*wavelength)).collect();
        let (brdf, count) = (self.brdf.clone(), asked.len());
        let answer = move |task: &Task| spectral(&brdf, &asked, &groups, task);
        pairs.answer(py, self.answered(py, &prepared, count, context, progress, answer)?)
    }

    /// Returns XYZ of f \[1/sr\], or linear sRGB.
    fn colours<'py>(
        &self,
        py: Python<'py>,
        light: &Bound<'py, PyAny>,
        view: &Bound<'py, PyAny>,
        is_rgb: bool,
        context: &CoreContext,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (light, view) = (Argument::vectors("light", light)?, Argument::vectors("view", view)?);
        let shape = common_shape(&[&light, &view])?;
        let mut pairs = Pairs::new(&light, &view, shape)?;
        let (brdf, asked) = (self.brdf.clone(), std::mem::take(&mut pairs.pairs));
        let count = asked.len();
        let answer = move |task: &Task| in_parts(&asked, task, |part| brdf.xyz(part, task));
        let mut colours = self.answered(py, &[Prepared::Colours], count, context, progress, answer)?;
        if is_rgb {
            colours.iter_mut().for_each(|xyz| *xyz = diffract::linear_srgb(*xyz));
        }
        pairs.answer_colours(py, colours)
    }

    /// Returns the map of the hemisphere for light from `light`: (side, side, 3) of linear sRGB, or (side, side) at a wavelength \[m\]; NaN outside.
    fn map<'py>(
        &self,
        py: Python<'py>,
        light: &Bound<'py, PyAny>,
        side: u32,
        wavelength: Option<f64>,
        context: &CoreContext,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let light = one_direction("light", light)?;
        let (brdf, wavelength) = (self.brdf.clone(), wavelength.map(micrometres));
        let pixels =
            work::run(py, context, progress, move |_, task| brdf.map(light, side, wavelength, task))?;
        let channels = if wavelength.is_some() { 1 } else { 3 };
        let inside = |pixel: &[f32; 4]| if pixel[3] > 0.0 { *pixel } else { [f32::NAN; 4] };
        let numbers: Vec<f32> =
            pixels.iter().flat_map(|pixel| inside(pixel).into_iter().take(channels)).collect();
        let side = side as usize;
        let shape: &[usize] = if channels == 1 { &[side, side] } else { &[side, side, 3] };
        let map = ArrayD::from_shape_vec(shape, numbers);
        let map = map.map_err(|e| argument("the map", e, "report this as a bug of diffract"))?;
        Ok(map.into_pyarray(py).into_any())
    }
}

impl CoreBrdf {
    /// Returns what `answer` answers: at once if there are few values and everything else is `prepared`, else on a thread beside the interpreter.
    fn answered<T: Send + 'static>(
        &self,
        py: Python<'_>,
        prepared: &[Prepared],
        count: usize,
        context: &CoreContext,
        progress: Option<&Bound<'_, PyAny>>,
        answer: impl FnOnce(&Task) -> diffract::Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let is_ready = || {
            let ready = self.ready.lock().unwrap_or_else(PoisonError::into_inner);
            prepared.iter().all(|kind| ready.contains(kind))
        };
        if self.is_quick && count <= FEW && is_ready() && !is_fork() {
            return answer(&Task::silent()).map_err(raised);
        }
        let answered = work::run(py, context, progress, move |_, task| answer(task))?;
        self.ready.lock().unwrap_or_else(PoisonError::into_inner).extend(prepared);
        Ok(answered)
    }
}

/// Returns f of the pairs `asked` at the wavelengths of `groups`; NaN for a pair that is in none.
fn spectral(
    brdf: &SurfaceBrdf,
    asked: &[[[f64; 3]; 2]],
    groups: &[(f64, Vec<usize>)],
    task: &Task,
) -> diffract::Result<Vec<f64>> {
    let mut values = vec![f64::NAN; asked.len()];
    let mut done = 0;
    for (wavelength, places) in groups {
        let part: Vec<_> = places.iter().map(|place| asked[*place]).collect();
        let found = in_parts(&part, task, |part| brdf.spectral(part, *wavelength, task))?;
        places.iter().zip(found).for_each(|(place, value)| values[*place] = value);
        done += places.len();
        task.report("directions", done, asked.len())?;
    }
    Ok(values)
}

/// Returns the answers to all `pairs`, which `answer` gives part by part.
fn in_parts<T>(
    pairs: &[[[f64; 3]; 2]],
    task: &Task,
    mut answer: impl FnMut(&[[[f64; 3]; 2]]) -> diffract::Result<Vec<T>>,
) -> diffract::Result<Vec<T>> {
    /// Pairs between two reports.
    const AT_ONCE: usize = 4096;
    let mut answers = Vec::with_capacity(pairs.len());
    for part in pairs.chunks(AT_ONCE) {
        answers.extend(answer(part)?);
        task.check()?;
    }
    Ok(answers)
}

/// Returns `numbers` as an array of one axis.
pub fn column(py: Python<'_>, numbers: Vec<f64>) -> PyResult<Bound<'_, PyAny>> {
    let shape = [numbers.len()];
    shaped(py, numbers, &shape)
}
