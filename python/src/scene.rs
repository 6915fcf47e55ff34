//! Scenes of meshes with surfaces, lights and a camera, and their pictures.

use crate::arrays::floats;
use crate::context::CoreContext;
use crate::errors::{argument, raised};
use crate::field::CoreField;
use crate::optics::CoreOptics;
use crate::work;
use diffract::{Light, Mesh, Object, PictureSettings, Scene};
use numpy::IntoPyArray;
use numpy::ndarray::{Array3, ArrayViewD};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Largest side of a picture \[pixels\].
const MAX_SIDE: u32 = 16_384;

/// Light of a scene.
#[pyclass(frozen, module = "diffract._diffract")]
pub struct CoreLight {
    light: Light,
}

#[pymethods]
impl CoreLight {
    /// Makes a point of the sky at these angles \[degrees\].
    #[staticmethod]
    fn point(theta: f64, phi: f64, intensity: f64) -> PyResult<Self> {
        if ![theta, phi, intensity].iter().all(|x| x.is_finite()) || intensity < 0.0 {
            return Err(argument(
                "the light",
                "is out of range",
                "give finite angles and an intensity of 0 or more",
            ));
        }
        Ok(Self { light: Light::new(theta, phi, intensity) })
    }

    /// Parses the words of the command line.
    #[staticmethod]
    fn from_words(words: &str) -> PyResult<Self> {
        Ok(Self { light: Light::from_words(words).map_err(raised)? })
    }

    fn __repr__(&self) -> String {
        format!("Light({:?})", self.light.to_string())
    }
}

/// Mesh of triangles.
#[pyclass(frozen, module = "diffract._diffract")]
pub struct CoreMesh {
    mesh: Mesh,
}

#[pymethods]
impl CoreMesh {
    /// Makes the mesh of `vertices` (n, 3), `faces` (m, 3) of their numbers, and texture coordinates `uv` (n, 2).
    #[new]
    fn new(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        uv: Option<&Bound<'_, PyAny>>,
        context: &CoreContext,
    ) -> PyResult<Self> {
        let vertices = table::<3>("vertices", vertices)?;
        let corners = table::<3>("faces", faces)?;
        let uvs = uv.map(|uv| table::<2>("uv", uv)).transpose()?.unwrap_or_default();
        let indices = corners.iter().flatten().map(|index| whole(*index, vertices.len()));
        let indices = indices.collect::<PyResult<Vec<u32>>>()?;
        let (positions, uvs) = (single(&vertices), single(&uvs));
        let mesh = work::run(py, context, None, move |_, _| Mesh::from_buffers(&positions, &indices, &uvs))?;
        Ok(Self { mesh })
    }

    /// Number of triangles.
    fn triangles(&self) -> usize {
        self.mesh.triangle_count()
    }
}

/// Object of a scene.
#[pyclass(frozen, module = "diffract._diffract")]
pub struct CoreObject {
    object: Object,
}

#[pymethods]
impl CoreObject {
    /// Makes an object of `mesh`.
    #[new]
    fn new(
        mesh: &CoreMesh,
        surface: Option<PathBuf>,
        pigment: [f64; 3],
        grooves: Option<f64>,
        size: f64,
        position: [f64; 3],
    ) -> PyResult<Self> {
        let object = Object::new(mesh.mesh.clone()).with_pigment(pigment).map_err(raised)?;
        let object = object.placed(size, position).map_err(raised)?;
        let object = grooves.map_or(object.clone(), |angle| object.with_grooves_turned(angle));
        let object = surface.map_or(object.clone(), |name| object.with_surface(name));
        Ok(Self { object })
    }
}

/// Scene.
#[pyclass(frozen, module = "diffract._diffract")]
pub struct CoreScene {
    scene: Scene,
}

#[pymethods]
impl CoreScene {
    /// Opens a built-in scene, a scene file or a mesh file.
    #[staticmethod]
    fn open(py: Python<'_>, name: PathBuf, context: &CoreContext) -> PyResult<Self> {
        let scene = work::run(py, context, None, move |_, _| Scene::open(&name))?;
        Ok(Self { scene })
    }

    /// Makes a scene of objects.
    #[staticmethod]
    fn of_objects(objects: Vec<PyRef<'_, CoreObject>>) -> PyResult<Self> {
        let objects = objects.iter().map(|object| object.object.clone()).collect();
        Ok(Self { scene: Scene::new(objects).map_err(raised)? })
    }

    /// Returns the scene with these lights.
    fn with_lights(&self, lights: Vec<PyRef<'_, CoreLight>>) -> Self {
        let lights: Vec<Light> = lights.iter().map(|light| light.light.clone()).collect();
        Self { scene: self.scene.clone().with_lights(lights) }
    }

    /// Returns the scene seen from `eye` toward `target` under a vertical `angle` \[degrees\].
    fn with_camera(&self, eye: [f64; 3], target: [f64; 3], angle: f64) -> PyResult<Self> {
        Ok(Self { scene: self.scene.clone().with_camera(eye, target, angle).map_err(raised)? })
    }

    /// Returns the scene in surroundings.
    fn with_surroundings(&self, name: &str, rotation: f64, stops: f64) -> PyResult<Self> {
        Ok(Self { scene: self.scene.clone().with_surroundings(name, rotation, stops).map_err(raised)? })
    }

    /// Returns the scene before a background of this linear sRGB.
    fn with_background(&self, color: [f64; 3]) -> PyResult<Self> {
        Ok(Self { scene: self.scene.clone().with_background(color).map_err(raised)? })
    }

    /// Returns the scene with or without shadows.
    fn with_shadows(&self, shadows: bool) -> Self {
        Self { scene: self.scene.clone().with_shadows(shadows) }
    }
}

/// Draws `scene` with `field` on its first object; returns linear radiance (H, W, 4).
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of Python, each with a name")]
pub fn render<'py>(
    py: Python<'py>,
    scene: &CoreScene,
    field: &CoreField,
    size: [u32; 2],
    samples: u32,
    optics: &CoreOptics,
    context: &CoreContext,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    if !size.iter().all(|side| (1..=MAX_SIDE).contains(side)) {
        let what = format!("is ({}, {})", size[0], size[1]);
        return Err(argument("size", what, "give a width and a height from 1 to 16384 pixels"));
    }
    if samples == 0 {
        return Err(argument("samples", "is 0", "give 1 or more"));
    }
    let (scene, field, optics) = (scene.scene.clone(), field.field.clone(), optics.clone());
    let picture = work::run(py, context, progress, move |context, task| {
        let optics = optics.of_scene(&field, &scene);
        let settings = PictureSettings::new(size).with_samples(samples).with_optics(&optics);
        diffract::draw(&scene, &field, &settings, context, task)
    })?;
    let flat = picture.radiance.into_iter().flatten().collect();
    let picture = Array3::from_shape_vec((size[1] as usize, size[0] as usize, 4), flat);
    let picture = picture.map_err(|e| argument("the picture", e, "report this as a bug of diffract"))?;
    Ok(picture.into_pyarray(py).into_any())
}

/// Returns the argument called `name` as rows of `N` finite numbers.
fn table<const N: usize>(name: &'static str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; N]>> {
    let array = floats(name, value)?;
    let view: ArrayViewD<'_, f64> = array.as_array();
    if view.ndim() != 2 || view.shape()[1] != N {
        let what = format!("has the shape {:?}", view.shape());
        return Err(argument(name, what, &format!("give an array of the shape (n, {N})")));
    }
    let flat: Vec<f64> = view.iter().copied().collect();
    if flat.iter().any(|x| !x.is_finite()) {
        return Err(argument(name, "has an element that is no finite number", "leave it out"));
    }
    Ok(flat.chunks_exact(N).map(|row| <[f64; N]>::try_from(row).unwrap_or([0.0; N])).collect())
}

/// Returns `rows` in 32-bit floats.
fn single<const N: usize>(rows: &[[f64; N]]) -> Vec<[f32; N]> {
    rows.iter().map(|row| row.map(|x| x as f32)).collect()
}

/// Returns the number of a vertex among `count`.
fn whole(index: f64, count: usize) -> PyResult<u32> {
    if index.fract() == 0.0 && index >= 0.0 && index < count as f64 {
        return Ok(index as u32);
    }
    let what = format!("has the number {index} of a vertex among {count}");
    Err(argument("faces", what, "give whole numbers from 0 on"))
}
