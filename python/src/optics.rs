//! Settings of light and material.

use crate::errors::{argument, raised};
use crate::inside;
use crate::units::micrometres;
use diffract::{Beyond, HeightField, Optics, Polarisation, Theory};
use pyo3::prelude::*;

/// Settings of the optics, some of which follow from the surface. That takes a while: ask on the thread of the work.
#[derive(Clone)]
#[pyclass(frozen, module = "diffract._diffract")]
pub struct CoreOptics {
    optics: Optics,
    /// Continuation that the user names; `None` for the one that suits the surface.
    beyond: Option<Beyond>,
    /// True if the user names a material, which then comes before that of a scene.
    names_material: bool,
}

/// Material that the user names.
#[derive(FromPyObject)]
enum Material {
    Index(f64),
    Name(String),
}

/// Coherence that the user names: the length \[m\], or the copies of a finite grating.
#[derive(FromPyObject)]
enum Coherence {
    Length(f64),
    Copies(u32, u32),
}

#[pymethods]
impl CoreOptics {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python, each with a name")]
    fn new(
        coherence: Option<Coherence>,
        material: Option<Material>,
        film: Option<(f64, f64)>,
        polarisation: Option<&str>,
        theory: Option<&str>,
        beyond: Option<&str>,
        illuminant: Option<&str>,
        tolerance: Option<f64>,
        method: Option<&str>,
        windows: Option<&str>,
    ) -> PyResult<Self> {
        let names_material = material.is_some() || film.is_some();
        let optics = with_material(Optics::new(), material, film)?;
        let optics = optics.with_theory(named("theory", theory, THEORIES)?.unwrap_or_default());
        let polarisation = named("polarisation", polarisation, POLARISATIONS)?.unwrap_or_default();
        let optics = optics.with_polarisation(polarisation);
        let optics =
            illuminant.map_or(Ok(optics.clone()), |name| optics.with_illuminant(name)).map_err(raised)?;
        let optics = with_tolerance(optics, tolerance)?;
        let optics =
            if named("method", method, METHODS)? == Some(true) { optics.by_reference() } else { optics };
        let optics = match named("windows", windows, WINDOWS)? {
            Some(true) => optics.through_one_window(),
            _ => optics,
        };
        let optics = with_coherence(optics, coherence)?;
        Ok(Self { optics, beyond: named("beyond", beyond, CONTINUATIONS)?, names_material })
    }
}

const THEORIES: &[(&str, Theory)] = &[("small-slope", Theory::SmallSlope), ("stam", Theory::Stam)];
const POLARISATIONS: &[(&str, Polarisation)] =
    &[("none", Polarisation::None), ("te", Polarisation::Te), ("tm", Polarisation::Tm)];
const CONTINUATIONS: &[(&str, Beyond)] = &[("copies", Beyond::Copies), ("alike", Beyond::Alike)];
/// Names, and whether each is the reference.
const METHODS: &[(&str, bool)] = &[("spectral", false), ("reference", true)];
/// Names, and whether each is one window.
const WINDOWS: &[(&str, bool)] = &[("all", false), ("one", true)];

/// Returns what the argument called `argument_name` names, if it is given.
fn named<T: Copy>(argument_name: &str, name: Option<&str>, known: &[(&str, T)]) -> PyResult<Option<T>> {
    let Some(name) = name else { return Ok(None) };
    let found = known.iter().find(|(known, _)| *known == name);
    let names = || known.iter().map(|(name, _)| format!("{name:?}")).collect::<Vec<_>>().join(" or ");
    found.map(|(_, value)| Some(*value)).ok_or_else(|| {
        argument(argument_name, format_args!("has no value {name:?}"), &format!("give {}", names()))
    })
}

fn with_material(optics: Optics, material: Option<Material>, film: Option<(f64, f64)>) -> PyResult<Optics> {
    let name = match material {
        Some(Material::Index(index)) if !(1.0..=10.0).contains(&index) => {
            let remedy =
                "give an index from 1 to 10, the name of a material, or a file of wavelength, n and k";
            return Err(argument("material", format_args!("has no index {index}"), remedy));
        }
        Some(Material::Index(index)) if film.is_none() => return Ok(optics.with_refractive_index(index)),
        Some(Material::Index(index)) => {
            let what = format!("has the index {index} below a film");
            return Err(argument("material", what, "name a material, such as \"glass\""));
        }
        Some(Material::Name(name)) => name,
        None if film.is_none() => return Ok(optics),
        None => {
            return Err(argument("film", "has no material below it", "name a material, such as \"glass\""));
        }
    };
    let with = match film {
        Some((thickness, index)) => {
            optics.with_coated_material(&name, &format!("{}um:{index}", micrometres(thickness)))
        }
        None => optics.with_material(&name),
    };
    with.map_err(raised)
}

fn with_tolerance(optics: Optics, tolerance: Option<f64>) -> PyResult<Optics> {
    const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-6..=1.0;
    match tolerance {
        Some(tolerance) if TOLERANCES.contains(&tolerance) => Ok(optics.with_tolerance(tolerance)),
        Some(tolerance) => {
            Err(argument("tolerance", format_args!("is {tolerance}"), "give a relative error from 1e-6 to 1"))
        }
        None => Ok(optics),
    }
}

fn with_coherence(optics: Optics, coherence: Option<Coherence>) -> PyResult<Optics> {
    const LENGTHS: std::ops::RangeInclusive<f64> = 0.01..=1e5;
    match coherence {
        Some(Coherence::Length(metres)) if LENGTHS.contains(&micrometres(metres)) => {
            Ok(optics.with_coherence_length(micrometres(metres)))
        }
        Some(Coherence::Length(metres)) => Err(argument(
            "coherence",
            format_args!("is {metres} m"),
            "give a length from 10 nm to 100 mm, in metres",
        )),
        Some(Coherence::Copies(x, y)) if (1..=10_000).contains(&x) && (1..=10_000).contains(&y) => {
            Ok(optics.with_copies([x, y]))
        }
        Some(Coherence::Copies(x, y)) => Err(argument(
            "coherence",
            format_args!("is ({x}, {y})"),
            "give 1 to 10000 copies along each side",
        )),
        None => Ok(optics),
    }
}

impl CoreOptics {
    /// Returns the settings for `field`.
    pub fn of(&self, field: &HeightField) -> Optics {
        self.optics.clone().with_beyond(self.beyond.unwrap_or_else(|| field.continuation()))
    }

    /// Returns the settings for `field` on the first object of `scene`, which may have a material.
    pub fn of_scene(&self, field: &HeightField, scene: &diffract::Scene) -> Optics {
        let optics = self.of(field);
        if self.names_material { optics } else { inside::with_material_of(optics, scene) }
    }
}
