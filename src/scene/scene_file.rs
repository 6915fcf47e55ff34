//! Scene files: TOML, with the built-in scenes as examples (`assets/scenes`).

use super::camera::Camera;
use super::light::{Light, MAX_LIGHTS};
use super::{Mesh, obj, primitives, snake};
use crate::error::{Error, Result};
use crate::input;
use crate::units;
use glam::{DVec3, Vec3};
use serde::Deserialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Names of the built-in scenes; the first is the default.
pub const BUILT_IN: [(&str, &str); 4] = [
    ("snake", include_str!("../../assets/scenes/snake.toml")),
    ("plate", include_str!("../../assets/scenes/plate.toml")),
    ("sphere", include_str!("../../assets/scenes/sphere.toml")),
    ("disc", include_str!("../../assets/scenes/disc.toml")),
];

/// A scene: everything that a picture shows, before any option changes it.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The mesh, in a world whose up is +z.
    pub mesh: Mesh,
    /// The surface: a built-in name or a file.
    pub surface: OsString,
    /// Distance between samples of a surface file, where the scene gives it \[µm\].
    pub pixel_size: Option<[f64; 2]>,
    /// Height of the file's largest code, where the scene gives it \[µm\].
    pub full_height: Option<f64>,
    /// The camera.
    pub camera: Camera,
    /// The lights, at most [`MAX_LIGHTS`].
    pub lights: Vec<Light>,
    /// Albedo of the pigment, linear sRGB.
    pub base_color: Vec3,
    /// Pigment texture, multiplied with the base colour.
    pub pigment: Option<PathBuf>,
    /// Exposure of the display \[stops\].
    pub exposure: f64,
    /// What is displayed where nothing is covered, linear sRGB.
    pub background: DVec3,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    mesh: String,
    #[serde(default)]
    up: Up,
    surface: String,
    pixel_size: Option<String>,
    height: Option<String>,
    #[serde(default = "black")]
    base_color: [f32; 3],
    pigment: Option<PathBuf>,
    #[serde(default)]
    exposure: f64,
    #[serde(default = "dark_grey")]
    background: [f64; 3],
    camera: FileCamera,
    lights: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileCamera {
    eye: [f32; 3],
    target: [f32; 3],
    field_of_view: String,
}

/// Which axis of the mesh file points up.
#[derive(Clone, Copy, Deserialize, Default, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
enum Up {
    #[default]
    Y,
    Z,
}

fn black() -> [f32; 3] {
    [0.0; 3]
}

fn dark_grey() -> [f64; 3] {
    [0.01; 3]
}

impl Scene {
    /// A built-in scene by name, a scene file, or an OBJ file shown by the sphere's camera and lights.
    ///
    /// # Errors
    /// A name that is neither, or a file that does not hold a scene; says where and what to do.
    pub fn open(name: &str) -> Result<Self> {
        if let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
            return Self::parse(text, Path::new("")).map_err(|e| e.at(format!("scene {name}")));
        }
        let path = Path::new(name);
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        match extension.as_str() {
            "obj" => Self::of_mesh(path),
            "toml" => {
                let text = input::read_text(path, "a scene file")?;
                let folder = path.parent().unwrap_or(Path::new(""));
                Self::parse(&text, folder).map_err(|e| e.at(path.display()))
            }
            _ => Err(Error::usage(
                format!("there is no scene `{name}`"),
                format!("give one of {} or a .toml or .obj file", BUILT_IN.map(|b| b.0).join(", ")),
            )),
        }
    }

    fn of_mesh(path: &Path) -> Result<Self> {
        let mut scene = Self::open("sphere")?;
        scene.mesh = upright(obj::load(path)?, Up::Y);
        let bounds = scene.mesh.bounds();
        /// A little air around the mesh.
        const AIR: f32 = 1.1;
        scene.camera.target = bounds.centre;
        scene.camera.distance = AIR * bounds.radius / (scene.camera.field_of_view / 2.0).sin();
        Ok(scene)
    }

    /// The scene in the text of a scene file; names of files in it start from `folder`.
    ///
    /// # Errors
    /// As [`Scene::open`].
    pub fn parse(text: &str, folder: &Path) -> Result<Self> {
        let file: File = toml::from_str(text).map_err(|e| {
            let line =
                e.span().map_or(0, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
            Error::failed(format!("line {line}: {}", e.message()), "see assets/scenes for whole examples")
        })?;
        let numbers = file.base_color.iter().map(|&c| f64::from(c)).chain(file.background);
        if !numbers.clone().all(|c| (0.0..=1.0).contains(&c)) {
            return Err(Error::failed("a colour is not within 0 to 1", "give linear sRGB from 0 to 1"));
        }
        if !(-40.0..=40.0).contains(&file.exposure) {
            return Err(Error::failed("the exposure is not within -40 to 40 stops", "0 is a good start"));
        }
        if file.lights.len() > MAX_LIGHTS {
            return Err(Error::failed(
                format!("there are {} lights", file.lights.len()),
                format!("give at most {MAX_LIGHTS}"),
            ));
        }
        let lights = file.lights.iter().map(|l| units::light(l)).collect::<Result<Vec<_>>>()?;
        let field_of_view = units::angle(&file.camera.field_of_view)?.to_radians() as f32;
        let built_in_surface = crate::surface::synth::Kind::from_name(&file.surface).is_some();
        let surface =
            if built_in_surface { file.surface.into() } else { folder.join(&file.surface).into_os_string() };
        Ok(Self {
            mesh: open_mesh(&file.mesh, file.up, folder)?,
            surface,
            pixel_size: file.pixel_size.as_deref().map(units::length_pair).transpose()?,
            full_height: file.height.as_deref().map(units::length).transpose()?,
            camera: Camera::looking(file.camera.eye.into(), file.camera.target.into(), field_of_view)?,
            lights,
            base_color: file.base_color.into(),
            pigment: file.pigment.map(|p| folder.join(p)),
            exposure: file.exposure,
            background: file.background.into(),
        })
    }
}

fn open_mesh(name: &str, up: Up, folder: &Path) -> Result<Mesh> {
    match name {
        "snake" => Ok(upright(snake::mesh()?, Up::Y)),
        "plate" => Ok(primitives::plate()),
        "sphere" => Ok(upright(primitives::sphere(), Up::Y)),
        "disc" => Ok(primitives::disc()),
        file => Ok(upright(obj::load(&folder.join(file))?, up)),
    }
}

/// Turns a mesh so that its `up` becomes +z.
fn upright(mesh: Mesh, up: Up) -> Mesh {
    match up {
        Up::Z => mesh,
        Up::Y => mesh.turned(|[x, y, z]| [x, -z, y]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_scene_opens_and_stands_upright() {
        for (name, _) in BUILT_IN {
            let scene = Scene::open(name).unwrap();
            assert!(!scene.lights.is_empty() && scene.mesh.triangle_count() > 0, "{name}");
        }
        let plate = Scene::open("plate").unwrap();
        assert_eq!(plate.mesh.vertices()[0].normal, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn wrong_scenes_are_refused_by_line() {
        let wrong = |text: &str| Scene::parse(text, Path::new("")).unwrap_err().to_string();
        assert!(wrong("mesh = 3\n").contains("line 1"), "{}", wrong("mesh = 3\n"));
        let plate = BUILT_IN[1].1;
        assert!(wrong(&format!("unknown = 1\n{plate}")).contains("unknown"));
        assert!(Scene::open("nothing").is_err());
        assert!(Scene::open("nothing.toml").unwrap_err().to_string().contains("no such file"));
    }
}
