//! Arrays of directions, wavelengths and colours: of any shape, broadcast as numpy does.

use crate::errors::{argument, wrong_type};
use crate::units::micrometres;
use numpy::ndarray::{ArrayD, ArrayViewD, Axis, IxDyn};
use numpy::{IntoPyArray, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use std::collections::BTreeMap;

/// Largest difference of the square of a length from 1: directions in 32-bit floats are unit vectors.
const NEARLY_UNIT: f64 = 2e-6;
/// Words for what directions are.
const GIVE_DIRECTIONS: &str =
    "give unit vectors of the shape (..., 3), as diffract.direction(theta, phi) makes them";

/// Returns the argument called `name` as an array of 64-bit floats: as it is where it is one, else converted. Masked elements are NaN.
pub fn floats<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    static CONVERT: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    if let Ok(array) = value.cast_exact::<PyArrayDyn<f64>>()
        && is_aligned(array)
    {
        return Ok(array.readonly());
    }
    let py = value.py();
    let convert = CONVERT.import(py, "diffract._arrays", "floats")?;
    let array = convert.call1((name, value))?;
    let array = array.cast::<PyArrayDyn<f64>>().map_err(|_| wrong_type(name, "is no array of numbers"))?;
    Ok(array.readonly())
}

/// Returns true if each element stands where a float of the machine may: a column of a packed table may not.
fn is_aligned(array: &Bound<'_, PyArrayDyn<f64>>) -> bool {
    let size = align_of::<f64>();
    let is_multiple = |stride: &isize| stride.unsigned_abs().is_multiple_of(size);
    array.data().addr().is_multiple_of(size) && array.strides().iter().all(is_multiple)
}

/// Argument that takes part in broadcasting: its name, its array, and the axes at the end that belong to one element.
pub struct Argument<'py> {
    name: &'static str,
    array: PyReadonlyArrayDyn<'py, f64>,
    inner: usize,
}

impl<'py> Argument<'py> {
    /// Returns an argument of directions, of the shape (..., 3).
    pub fn vectors(name: &'static str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let array = floats(name, value)?;
        let shape = array.as_array().shape().to_vec();
        if shape.last() != Some(&3) {
            return Err(argument(name, format_args!("has the shape {}", in_words(&shape)), GIVE_DIRECTIONS));
        }
        Ok(Self { name, array, inner: 1 })
    }

    /// Returns an argument of numbers, of any shape.
    pub fn numbers(name: &'static str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        Ok(Self { name, array: floats(name, value)?, inner: 0 })
    }

    /// Returns an argument of symmetric 2 × 2 matrices, of the shape (..., 2, 2).
    pub fn matrices(name: &'static str, value: &Bound<'py, PyAny>) -> PyResult<Self> {
        let array = floats(name, value)?;
        let shape = array.as_array().shape().to_vec();
        if !shape.ends_with(&[2, 2]) {
            let what = format!("has the shape {}", in_words(&shape));
            return Err(argument(name, what, "give numbers, or covariances of the shape (..., 2, 2)"));
        }
        Ok(Self { name, array, inner: 2 })
    }

    /// Returns the shape without the axes of an element.
    fn outer(&self) -> Vec<usize> {
        let shape = self.array.as_array().shape().to_vec();
        shape[..shape.len() - self.inner].to_vec()
    }

    /// Returns all elements, broadcast to `shape` and in its order.
    fn elements<const N: usize>(&self, shape: &[usize]) -> PyResult<Vec<[f64; N]>> {
        let array = self.array.as_array();
        let mut whole = shape.to_vec();
        whole.extend(&array.shape()[array.ndim() - self.inner..]);
        let spread = array.broadcast(IxDyn(&whole)).ok_or_else(|| {
            argument(self.name, "does not fit the others", "give arrays of shapes that numpy broadcasts")
        })?;
        Ok(grouped(&spread))
    }
}

/// Returns the numbers of an array in their order, `N` at a time.
fn grouped<const N: usize>(array: &ArrayViewD<'_, f64>) -> Vec<[f64; N]> {
    let group = |numbers: &[f64]| <[f64; N]>::try_from(numbers).unwrap_or([f64::NAN; N]);
    match array.as_slice() {
        Some(numbers) => numbers.chunks_exact(N).map(group).collect(),
        None => array.iter().copied().collect::<Vec<_>>().chunks_exact(N).map(group).collect(),
    }
}

/// Returns `shape` as Python writes it.
fn in_words(shape: &[usize]) -> String {
    match shape {
        [only] => format!("({only},)"),
        _ => format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// Returns the shape that the `arguments` have together.
pub fn common_shape(arguments: &[&Argument<'_>]) -> PyResult<Vec<usize>> {
    let mut common: Vec<usize> = Vec::new();
    for (place, argument) in arguments.iter().enumerate() {
        let shape = argument.outer();
        let sides = common.len().max(shape.len());
        let side = |of: &[usize], axis: usize| (axis + of.len()).checked_sub(sides).map_or(1, |i| of[i]);
        let joined: Option<Vec<usize>> = (0..sides)
            .map(|axis| match (side(&common, axis), side(&shape, axis)) {
                (a, b) if a == b => Some(a),
                (1, b) => Some(b),
                (a, 1) => Some(a),
                _ => None,
            })
            .collect();
        let former =
            || arguments[..place].iter().map(|argument| argument.name).collect::<Vec<_>>().join(", ");
        common = joined.ok_or_else(|| {
            let what = format!(
                "of the shape {} does not fit {} of {}",
                in_words(&shape),
                former(),
                in_words(&common)
            );
            crate::errors::argument(argument.name, what, "give arrays of shapes that numpy broadcasts")
        })?;
    }
    Ok(common)
}

/// Pairs of directions to the light and to the viewer, in the order of a shape.
pub struct Pairs {
    /// Pairs of numbers.
    pub pairs: Vec<[[f64; 3]; 2]>,
    /// Places of these pairs in the shape; `None` for all. Others have a NaN.
    places: Option<Vec<usize>>,
    shape: Vec<usize>,
}

impl Pairs {
    /// Returns the pairs of `light` and `view`, broadcast to `shape`.
    pub fn new(light: &Argument<'_>, view: &Argument<'_>, shape: Vec<usize>) -> PyResult<Self> {
        let lights = unit(light.name, light.elements(&shape)?)?;
        let views = unit(view.name, view.elements(&shape)?)?;
        let pairs: Vec<_> = lights.into_iter().zip(views).map(|(light, view)| [light, view]).collect();
        let is_number = |pair: &[[f64; 3]; 2]| pair.iter().flatten().all(|x| !x.is_nan());
        if pairs.iter().all(is_number) {
            return Ok(Self { pairs, places: None, shape });
        }
        let (places, pairs) = pairs.into_iter().enumerate().filter(|(_, pair)| is_number(pair)).unzip();
        Ok(Self { pairs, places: Some(places), shape })
    }

    /// Returns the elements of another argument that belong to these pairs.
    pub fn beside<const N: usize>(&self, argument: &Argument<'_>) -> PyResult<Vec<[f64; N]>> {
        let all = argument.elements(&self.shape)?;
        Ok(match &self.places {
            Some(places) => places.iter().map(|place| all[*place]).collect(),
            None => all,
        })
    }

    /// Returns the answers `values` to these pairs in the shape, each an element of its own; NaN where a pair has one.
    pub fn answer<'py>(&self, py: Python<'py>, values: Vec<f64>) -> PyResult<Bound<'py, PyAny>> {
        shaped(py, self.placed(values, f64::NAN), &self.shape)
    }

    /// Returns the answers `values` of three numbers to these pairs in the shape, with a last axis of 3.
    pub fn answer_colours<'py>(&self, py: Python<'py>, values: Vec<[f64; 3]>) -> PyResult<Bound<'py, PyAny>> {
        let flat = self.placed(values, [f64::NAN; 3]).into_iter().flatten().collect();
        let mut shape = self.shape.clone();
        shape.push(3);
        shaped(py, flat, &shape)
    }

    fn placed<T: Copy>(&self, values: Vec<T>, missing: T) -> Vec<T> {
        let Some(places) = &self.places else { return values };
        let mut all = vec![missing; self.shape.iter().product()];
        places.iter().zip(values).for_each(|(place, value)| all[*place] = value);
        all
    }
}

/// Returns `numbers` as an array of this `shape`; a scalar of numpy for the shape ().
pub fn shaped<'py>(py: Python<'py>, numbers: Vec<f64>, shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let array = ArrayD::from_shape_vec(IxDyn(shape), numbers);
    let array = array.map_err(|e| argument("the answer", e, "report this as a bug of diffract"))?;
    let array = array.into_pyarray(py).into_any();
    if shape.is_empty() { array.get_item(pyo3::types::PyTuple::empty(py)) } else { Ok(array) }
}

/// Checks that `vectors` of the argument called `name` are unit vectors, or have NaN.
fn unit(name: &str, vectors: Vec<[f64; 3]>) -> PyResult<Vec<[f64; 3]>> {
    let squared = |[x, y, z]: &[f64; 3]| x * x + y * y + z * z;
    match vectors.iter().find(|vector| (squared(vector) - 1.0).abs() > NEARLY_UNIT) {
        Some(vector) => {
            let what = format!("has a vector of the length {}", squared(vector).sqrt());
            Err(argument(name, what, "divide it by its length"))
        }
        None => Ok(vectors),
    }
}

/// Returns the argument called `name` as one direction.
pub fn one_direction(name: &'static str, value: &Bound<'_, PyAny>) -> PyResult<[f64; 3]> {
    let vector = Argument::vectors(name, value)?;
    match unit(name, vector.elements(&[])?)?[..] {
        [vector] if vector.iter().all(|x| !x.is_nan()) => Ok(vector),
        _ => Err(argument(name, "is not a number", GIVE_DIRECTIONS)),
    }
}

/// Groups the places of `wavelengths` \[m\] by their number \[µm\], the shortest first. A wavelength that is NaN has no group.
pub fn by_wavelength(wavelengths: &[[f64; 1]]) -> Vec<(f64, Vec<usize>)> {
    let mut groups: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    let numbers = wavelengths.iter().enumerate().filter(|(_, [metres])| !metres.is_nan());
    numbers.for_each(|(place, [metres])| groups.entry(metres.to_bits()).or_default().push(place));
    groups.into_iter().map(|(bits, places)| (micrometres(f64::from_bits(bits)), places)).collect()
}

/// Returns unit vectors at polar angles `theta` and azimuths `phi` \[degrees\], broadcast.
#[pyfunction]
pub fn direction<'py>(
    py: Python<'py>,
    theta: &Bound<'py, PyAny>,
    phi: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let (theta, phi) = (Argument::numbers("theta", theta)?, Argument::numbers("phi", phi)?);
    let mut shape = common_shape(&[&theta, &phi])?;
    let angles = theta.elements::<1>(&shape)?.into_iter().zip(phi.elements::<1>(&shape)?);
    let vectors = angles.flat_map(|([theta], [phi])| diffract::direction(theta, phi)).collect();
    shape.push(3);
    shaped(py, vectors, &shape)
}

/// Returns colours of the shape (..., 3), each changed by `change`.
fn colours<'py>(
    name: &'static str,
    value: &Bound<'py, PyAny>,
    change: impl Fn([f64; 3]) -> [f64; 3],
) -> PyResult<Bound<'py, PyAny>> {
    let array = floats(name, value)?;
    let shape = array.as_array().shape().to_vec();
    if shape.last() != Some(&3) {
        let what = format!("has the shape {}", in_words(&shape));
        return Err(argument(name, what, "give colours of the shape (..., 3)"));
    }
    let changed = grouped(&array.as_array()).into_iter().flat_map(change).collect();
    shaped(value.py(), changed, &shape)
}

/// Returns linear sRGB of colours in XYZ.
#[pyfunction]
pub fn linear_srgb<'py>(xyz: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    colours("xyz", xyz, diffract::linear_srgb)
}

/// Returns the 8-bit sRGB that shows linear sRGB after an exposure of so many stops.
#[pyfunction]
pub fn srgb<'py>(linear: &Bound<'py, PyAny>, exposure: f64) -> PyResult<Bound<'py, PyAny>> {
    let shown = colours("linear", linear, |linear| diffract::display_srgb(linear, exposure).map(f64::from))?;
    shown.call_method1("astype", ("u1",))
}

/// Returns the view of a two-dimensional array row by row, from the top.
pub fn rows(name: &str, array: &PyReadonlyArrayDyn<'_, f64>) -> PyResult<([usize; 2], Vec<f64>)> {
    let view = array.as_array();
    if view.ndim() != 2 {
        let what = format!("has the shape {}", in_words(view.shape()));
        return Err(argument(name, what, "give an array of rows and columns"));
    }
    let size = [view.len_of(Axis(1)), view.len_of(Axis(0))];
    let heights = match view.as_slice() {
        Some(heights) => heights.to_vec(),
        None => view.iter().copied().collect(),
    };
    Ok((size, heights))
}
