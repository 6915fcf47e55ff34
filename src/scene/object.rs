//! Objects of a scene: a mesh with its surface and its position. Options of the program change the first object of a scene alone.

use super::loaded_mesh::LoadedMesh;
use super::mesh::{Bounds, Mesh};
use super::mesh_file;
pub use super::up::Up;
use super::{primitives, snake};
use crate::error::{Error, Result};
use crate::optics::material::Material;
use crate::optics::reflectance::{Film, Reflectance};
use crate::surface::SurfaceSource;
use crate::surface::prepare::PreparationStep;
use crate::surface::synth;
use crate::task::Task;
use crate::units;
use glam::{EulerRot, Mat3, Vec3};
use std::path::{Path, PathBuf};

/// Largest number of objects of a scene.
pub const MAX_OBJECTS: usize = 64;

/// Object of a scene: a mesh with its place, its surface and its pigment.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Mesh in world coordinates.
    #[doc(hidden)]
    pub mesh: Mesh,
    /// Source of the mesh.
    #[doc(hidden)]
    pub mesh_source: MeshSource,
    /// Position, rotation and size.
    #[doc(hidden)]
    pub pose: Pose,
    /// Height field; `None`: nothing is diffracted, and the pigment is seen alone.
    #[doc(hidden)]
    pub surface: Option<SurfaceSource>,
    /// Orientation of the height field's patch on the mesh.
    #[doc(hidden)]
    pub grooves: Grooves,
    /// Reflectance of the surface, if the scene gives it.
    #[doc(hidden)]
    pub reflectance: Option<Reflectance>,
    /// Albedo of the pigment, linear sRGB.
    #[doc(hidden)]
    pub base_color: Vec3,
    /// Pigment texture, multiplied with the base colour.
    #[doc(hidden)]
    pub pigment: Option<PathBuf>,
    /// True for the ground, which shows shadows and casts none.
    #[doc(hidden)]
    pub is_ground: bool,
    /// Notes on the mesh file.
    #[doc(hidden)]
    pub mesh_notes: Vec<String>,
}

/// Placement of an object: its mesh is scaled by `size`, rotated about the world's x, y and z in this order, and moved to `position`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position of the mesh's origin.
    pub position: Vec3,
    /// Angles about x, y and z \[degrees\].
    pub rotation: [f64; 3],
    /// Factor of all lengths.
    pub size: f32,
}

impl Default for Pose {
    fn default() -> Self {
        Self { position: Vec3::ZERO, rotation: [0.0; 3], size: 1.0 }
    }
}

impl Pose {
    /// Moves the mesh to its place in the world.
    pub(super) fn place(&self, mesh: Mesh) -> Result<Mesh> {
        if *self == Self::default() {
            return Ok(mesh);
        }
        let [x, y, z] = self.rotation.map(|angle| angle.to_radians() as f32);
        let turn = Mat3::from_euler(EulerRot::ZYX, z, y, x);
        mesh.turned(|v| (turn * Vec3::from(v)).to_array()).moved(self.size, self.position)
    }
}

/// Orientation of the patch of a height field in the tangent frame of a mesh: T is the direction of growing u, B that of growing v.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Grooves {
    /// x along T.
    #[default]
    Along,
    /// x at an angle from T toward B \[degrees\].
    Turned(f64),
    /// x away from the middle of the texture, (0.5, 0.5): the lines of a grating whose heights vary along x are circles there.
    Radial,
    /// x at the angle from T toward B that a grey picture over (u, v) gives: black is 0, white a full turn.
    Map(PathBuf),
}

impl Grooves {
    /// Parses an angle with its unit, `radial`, or the name of a picture, relative to `folder`.
    ///
    /// # Errors
    /// Fails for a number that is no angle.
    pub fn parse(text: &str, folder: &Path) -> Result<Self> {
        match text {
            "radial" => Ok(Self::Radial),
            _ if text.ends_with("deg") || text.ends_with("rad") => Ok(Self::Turned(units::angle(text)?)),
            file => Ok(Self::Map(folder.join(file))),
        }
    }

    /// Returns the picture, if there is one.
    pub fn file(&self) -> Option<&PathBuf> {
        if let Self::Map(file) = self { Some(file) } else { None }
    }
}

#[doc(hidden)]
impl Object {
    /// Returns the ground of this `color` below everything within `bounds`, whose lowest point has the height `z`.
    ///
    /// # Errors
    /// A ground that reaches beyond ±10⁹.
    pub(super) fn ground(color: Vec3, bounds: Bounds, z: f32) -> Result<Self> {
        /// Radius of the ground relative to that of the objects on it: its edge stands behind the scene and not in it.
        const EXTENT: f32 = 4.0;
        let pose = Pose {
            position: bounds.centre.truncate().extend(z),
            size: EXTENT * bounds.radius,
            ..Pose::default()
        };
        Ok(Self {
            mesh: pose.place(primitives::ground())?,
            mesh_source: MeshSource { name: "ground".into(), up: Up::Z, part: None },
            pose,
            surface: None,
            grooves: Grooves::Along,
            reflectance: None,
            base_color: color,
            pigment: None,
            is_ground: true,
            mesh_notes: Vec::new(),
        })
    }

    /// Returns notes on mesh and material that a user should know, each with the name of its file.
    pub(super) fn notes(&self) -> impl Iterator<Item = String> {
        let mesh = self.mesh_source.name.display();
        // Without a surface there are no grooves.
        let direction = self.surface.as_ref().and_then(|_| self.mesh.note());
        let of_mesh = direction.into_iter().chain(self.mesh_notes.iter().map(String::as_str));
        of_mesh
            .map(move |note| format!("{mesh}: {note}"))
            .chain(self.reflectance.as_ref().and_then(Reflectance::note))
    }

    /// Returns the files of the object.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        let surface = self.surface.as_ref().filter(|surface| surface.kind().is_none());
        let material = self.reflectance.as_ref().and_then(Reflectance::file);
        [
            self.mesh_source.file(),
            surface.map(|surface| PathBuf::from(&surface.name)),
            self.grooves.file().cloned(),
            self.pigment.clone(),
            material,
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

impl MeshSource {
    /// Returns the mesh of this name in a scene file in `folder`.
    pub(super) fn named(name: &str, up: Option<Up>, part: Option<String>, folder: &Path) -> Self {
        let name = if BUILT_IN_MESHES.contains(&name) { name.into() } else { folder.join(name) };
        Self { up: up.unwrap_or_else(|| mesh_file::usual_up(&name)), name, part }
    }

    /// Returns the file; `None` for a built-in mesh.
    pub(super) fn file(&self) -> Option<PathBuf> {
        let is_built_in = self.name.to_str().is_some_and(|name| BUILT_IN_MESHES.contains(&name));
        (!is_built_in).then(|| self.name.clone())
    }
}

/// Returns the name of a surface in a scene file in `folder`: a generated surface, or a file.
pub(super) fn surface_name(name: &str, folder: &Path) -> PathBuf {
    if synth::SurfaceKind::from_name(name).is_some() { name.into() } else { folder.join(name) }
}

/// Fails unless every one of `channels` is within 0 to 1.
pub fn check_colors(channels: impl IntoIterator<Item = f64>) -> Result<()> {
    if channels.into_iter().all(|c| (0.0..=1.0).contains(&c)) {
        return Ok(());
    }
    Err(Error::input("a colour is not within 0 to 1", "give linear sRGB from 0 to 1"))
}

/// Source of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshSource {
    /// A built-in mesh, or a file.
    pub name: PathBuf,
    /// Axis of the file that points up.
    pub up: Up,
    /// Object, group or material of the file to select; `None`: all faces.
    pub part: Option<String>,
}

/// Meshes that scene files can name instead of a file.
pub(super) const BUILT_IN_MESHES: [&str; 4] = ["snake", "plate", "sphere", "disc"];

/// Returns the reflectance: a material of that name or in that file, below a film.
pub(super) fn reflectance(
    material: Option<&str>,
    film: Option<&str>,
    folder: &Path,
) -> Result<Option<Reflectance>> {
    let Some(name) = material else {
        return match film {
            None => Ok(None),
            Some(_) => {
                Err(Error::input("a film needs a material below it", "add `material`, as in \"glass\""))
            }
        };
    };
    let material = if Material::is_built_in(name) {
        Material::from_name_or_file(name)
    } else {
        Material::from_name_or_file(folder.join(name))
    };
    let film = film.map(Film::parse).transpose()?;
    Ok(Some(Reflectance::of_material(material?, film)))
}

/// Parses the steps of `prepare`, each as on the command line without the dashes.
pub(super) fn steps(words: &[String]) -> Result<Vec<PreparationStep>> {
    let step = |text: &String| PreparationStep::parse(text).map_err(|e| e.at("prepare"));
    let steps: Vec<PreparationStep> = words.iter().map(step).collect::<Result<_>>()?;
    Ok(steps.into_iter().filter(|step| !step.is_nothing()).collect())
}

/// Opens the mesh and turns it upright.
pub(super) fn open_mesh(source: &MeshSource, task: &Task) -> Result<LoadedMesh> {
    let MeshSource { name, up, part } = source;
    let built_in = match name.to_str() {
        Some("snake") => upright(snake::mesh()?, Up::Y),
        Some("plate") => primitives::plate(),
        Some("sphere") => upright(primitives::sphere(), Up::Y),
        Some("disc") => primitives::disc(),
        _ => {
            let loaded = mesh_file::load(name, part.as_deref(), task)?;
            return Ok(LoadedMesh { mesh: upright(loaded.mesh, *up), ..loaded });
        }
    };
    match part {
        None => Ok(LoadedMesh::new(built_in)),
        Some(part) => Err(Error::input(
            format!("the mesh {} has no part `{part}`", name.display()),
            "leave `part` away: files alone have parts",
        )),
    }
}

/// Turns a mesh so that its `up` becomes +z.
pub(super) fn upright(mesh: Mesh, up: Up) -> Mesh {
    match up {
        Up::Z => mesh,
        Up::Y => mesh.turned(|[x, y, z]| [x, -z, y]),
    }
}
