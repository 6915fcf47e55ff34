//! Scene files: TOML, with the built-in scenes as examples (`assets/scenes`).

use super::Mesh;
use super::camera::Camera;
use super::display_settings::DisplaySettings;
use super::environment::{self, Environment, Placement};
use super::light::Light;
use super::loaded_mesh::LoadedMesh;
use super::mesh::Bounds;
use super::mesh_file;
use super::object::{
    BUILT_IN_MESHES, Grooves, MAX_OBJECTS, MeshSource, Object, Pose, Up, check_colors, open_mesh,
    reflectance, steps, surface_name,
};
use super::scene_document::{Angle, EnvironmentDocument, Exactly, ObjectDocument, SceneDocument};
use super::scene_options::{self, FileOptions};
use crate::error::{Error, Remedy, Result};
use crate::input;
use crate::surface::SurfaceSource;
use crate::surface::files;
use crate::surface::synth::SurfaceKind;
use crate::task::Task;
use crate::units;
use glam::Vec3;
use serde::Deserialize;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Names of the built-in scenes; the first is the default.
pub const BUILT_IN: [(&str, &str); 6] = [
    ("snake", include_str!("../../assets/scenes/snake.toml")),
    ("plate", include_str!("../../assets/scenes/plate.toml")),
    ("sphere", include_str!("../../assets/scenes/sphere.toml")),
    ("disc", include_str!("../../assets/scenes/disc.toml")),
    ("cd", include_str!("../../assets/scenes/cd.toml")),
    ("skin", include_str!("../../assets/scenes/skin.toml")),
];

/// Default length of a unit of scenes, as of OBJ files \[um\]: a metre.
const UNIT: f64 = 1e6;
/// Metres in the unit of parsed lengths.
const METRES_PER_MICROMETRE: f64 = 1e-6;

/// Scene: objects, lights, surroundings, camera and display.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Objects in a world whose up is +z, the ground last. Options of the program change the first one.
    #[doc(hidden)]
    pub objects: Vec<Object>,
    /// The camera.
    #[doc(hidden)]
    pub camera: Camera,
    /// The lights.
    #[doc(hidden)]
    pub lights: Vec<Light>,
    /// Environment map that lights the scene beside the lights.
    #[doc(hidden)]
    pub environment: Option<Environment>,
    /// True if objects cast shadows on each other and on themselves.
    #[doc(hidden)]
    pub shadows: bool,
    /// Display of the radiance.
    #[doc(hidden)]
    pub display: DisplaySettings,
    /// Length of one unit of the scene's coordinates \[m\].
    #[doc(hidden)]
    pub unit: f64,
    /// Options of the program that draws the scene, by name, with their values: parameters of the computation. They are not checked yet.
    #[doc(hidden)]
    pub options: Vec<[String; 2]>,
    /// Files of the scene: the scene file, and those of mesh, surface and pigment.
    #[doc(hidden)]
    pub files: Vec<PathBuf>,
    /// Settings that options gave when the scene was opened.
    #[doc(hidden)]
    pub overrides: SceneOverrides,
    /// Bounding sphere of everything but the ground, if there are several objects. It is stored because each frame needs it and meshes may
    /// have many vertices.
    #[doc(hidden)]
    pub standing_bounds: Bounds,
}

/// Settings of the main object and of the unit that options give instead of the scene's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneOverrides {
    /// Length of one unit of the scene's coordinates \[µm\].
    pub scale: Option<f64>,
    /// Axis of the mesh file that points up.
    pub up: Option<Up>,
    /// Orientation of the height field's patch on the mesh.
    pub grooves: Option<Grooves>,
}

impl EnvironmentDocument {
    /// Opens the environment map; names of files are relative to `folder`.
    fn open(&self, folder: &Path) -> Result<Environment> {
        let name = if environment::is_built_in(&self.name) {
            self.name.clone().into()
        } else {
            folder.join(&self.name).into_os_string()
        };
        let mut environment = Environment::open(name)?;
        let rotation = self.rotation.as_deref().map_or(Ok(0.0), units::angle)?;
        environment.placement = Placement::new(rotation, self.exposure)?;
        Ok(environment)
    }
}

impl ObjectDocument {
    /// Opens the object; names of files are relative to `folder`.
    fn open(self, folder: &Path, task: &Task) -> Result<Object> {
        let named_color = self.base_color.map(|Exactly(color)| color);
        check_colors(named_color.into_iter().flatten().map(f64::from))?;
        let pose = Pose {
            position: self.position.0.into(),
            rotation: self.rotation.0.map(|Angle(angle)| angle),
            size: self.size,
        };
        if !(pose.position.is_finite() && pose.size.is_finite() && pose.size > 0.0) {
            return Err(Error::input(
                "an object has no place or size",
                "give finite numbers, and a size above 0",
            ));
        }
        let mesh_source = MeshSource::named(&self.mesh, self.up, self.part, folder);
        let surface = self.surface.as_deref().map(|name| -> Result<SurfaceSource> {
            Ok(SurfaceSource {
                name: surface_name(name, folder).into_os_string(),
                pixel_size: self.pixel_size.as_deref().map(units::length_pair).transpose()?,
                height: self.height.as_deref().map(units::length).transpose()?,
                channel: None,
                prepare: steps(&self.prepare)?,
                seed: 1,
            })
        });
        let LoadedMesh { mesh, color, notes } = open_mesh(&mesh_source, task)?;
        Ok(Object {
            mesh: pose.place(mesh)?,
            mesh_source,
            pose,
            surface: surface.transpose()?,
            grooves: self
                .grooves
                .as_deref()
                .map_or(Ok(Grooves::Along), |text| Grooves::parse(text, folder))?,
            reflectance: reflectance(self.material.as_deref(), self.film.as_deref(), folder)?,
            base_color: named_color.map(Vec3::from).or(color).unwrap_or(Vec3::ZERO),
            pigment: self.pigment.map(|p| folder.join(p)),
            is_ground: false,
            mesh_notes: notes,
        })
    }
}

#[doc(hidden)]
impl Scene {
    /// Opens a scene like [`Scene::open`], with `overrides` and with reports to `task` while a mesh file is read.
    ///
    /// # Errors
    /// Those of [`Scene::open`], and a cancelled task; `up` of a mesh that is no file.
    pub fn open_telling(name: &OsStr, overrides: &SceneOverrides, task: &Task) -> Result<Self> {
        if let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
            let scene = Self::read(text, Path::new(""), overrides, task);
            return scene.map_err(|e| e.at(format!("scene {}", name.display())));
        }
        let path = Path::new(name);
        if mesh_file::extension(path).is_some() {
            return Self::of_mesh(path, overrides, task);
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        if extension != "toml" {
            return Err(no_scene(name, &extension));
        }
        let text = input::read_text(path, "a scene file")?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut scene = Self::read(&text, folder, overrides, task).map_err(|e| e.at(path.display()))?;
        scene.files.push(path.to_owned());
        Ok(scene)
    }

    /// Returns the scene of a mesh file alone: the lights of the built-in sphere, and a camera that sees all of the mesh. A unit of a glTF file is a metre.
    fn of_mesh(path: &Path, overrides: &SceneOverrides, task: &Task) -> Result<Self> {
        let mut scene = Self::open("sphere")?;
        let object = scene.main_object_mut();
        let up = overrides.up.unwrap_or_else(|| mesh_file::usual_up(path));
        object.mesh_source = MeshSource { name: path.to_owned(), up, part: None };
        let LoadedMesh { mesh, color, notes } = open_mesh(&object.mesh_source, task)?;
        object.base_color = color.unwrap_or(object.base_color);
        (object.mesh, object.mesh_notes) = (mesh, notes);
        let bounds = object.mesh.bounds();
        scene.files.push(path.to_owned());
        /// Radius of the framed sphere relative to that of the mesh.
        const AIR: f32 = 1.1;
        scene.camera.target = bounds.centre;
        // The cone of half the field of view touches the sphere.
        let half_view = (scene.camera.height_at(1.0) / 2.0).atan();
        scene.camera.distance = AIR * bounds.radius / half_view.sin();
        if let Some("gltf" | "glb") = mesh_file::extension(path) {
            scene.unit = 1.0;
        }
        Ok(scene.overridden(overrides))
    }

    /// Returns the scene with the scale and the grooves of `overrides`; its mesh stands upright by them already.
    fn overridden(mut self, overrides: &SceneOverrides) -> Self {
        if let Some(scale) = overrides.scale {
            self.unit = scale * METRES_PER_MICROMETRE;
        }
        if let Some(grooves) = &overrides.grooves {
            self.files.extend(grooves.file().cloned());
            self.main_object_mut().grooves = grooves.clone();
        }
        self.overrides = overrides.clone();
        self
    }

    /// Returns notes on meshes and materials that a user should know.
    pub fn notes(&self) -> Vec<String> {
        self.objects.iter().filter(|object| !object.is_ground).flat_map(Object::notes).collect()
    }

    /// Parses the text of a scene file; names of files in it are relative to `folder`.
    ///
    /// # Errors
    /// See [`Scene::open`].
    pub fn parse(text: &str, folder: &Path) -> Result<Self> {
        Self::read(text, folder, &SceneOverrides::default(), &Task::silent())
    }

    fn read(text: &str, folder: &Path, overrides: &SceneOverrides, task: &Task) -> Result<Self> {
        let mut file: SceneDocument = toml::from_str(text).map_err(|e| {
            let line =
                e.span().map_or(0, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
            Error::input(format!("line {line}: {}", e.message()), remedy(e.message())).caused_by(e)
        })?;
        if overrides.up.is_some() {
            if BUILT_IN_MESHES.contains(&file.mesh.as_str()) {
                let what = format!("the mesh {} is built in and stands upright", file.mesh);
                return Err(Error::usage(what, "leave `up` away: it is about mesh files"));
            }
            file.up = overrides.up;
        }
        let background = file.background.color().to_array();
        let ground = file.ground.map(|Exactly(color)| color);
        check_colors(ground.unwrap_or_default().map(f64::from).into_iter().chain(background))?;
        if !(-40.0..=40.0).contains(&file.exposure.stops) {
            return Err(Error::input("the exposure is not within -40 to 40 stops", "0 is a good start"));
        }
        let lights = file.lights.iter().map(|l| Light::parse_in(l, folder)).collect::<Result<Vec<_>>>()?;
        let environment_file = file.environment.as_ref().filter(|e| !environment::is_built_in(&e.name));
        let environment_file = environment_file.map(|e| folder.join(&e.name));
        let spectra = lights.iter().filter_map(|light| light.spectrum.as_ref()?.file().map(PathBuf::from));
        let (objects, standing_bounds) = objects(file.main_object(), file.objects, ground, folder, task)?;
        let scene = Self {
            files: objects.iter().flat_map(Object::files).chain(environment_file).chain(spectra).collect(),
            objects,
            standing_bounds,
            options: scene_options::words(file.options, folder)?,
            camera: file.camera.camera()?,
            lights,
            environment: file.environment.as_ref().map(|e| e.open(folder)).transpose()?,
            shadows: file.shadows,
            display: DisplaySettings {
                exposure: file.exposure.stops,
                auto_exposure: file.exposure.is_auto,
                tone: file.tone.0,
                background: file.background,
                is_opaque: false,
            },
            unit: file.scale.as_deref().map_or(Ok(UNIT), units::length)? * METRES_PER_MICROMETRE,
            overrides: SceneOverrides::default(),
        };
        Ok(scene.overridden(overrides))
    }
}

#[doc(hidden)]
impl Scene {
    /// Returns the object that options of the program change: the first.
    ///
    /// # Panics
    /// Panics if there are no objects; a scene file has at least one.
    pub fn main_object(&self) -> &Object {
        &self.objects[0]
    }

    /// See [`Self::main_object`].
    ///
    /// # Panics
    /// Panics if there are no objects.
    pub fn main_object_mut(&mut self) -> &mut Object {
        &mut self.objects[0]
    }

    /// Returns the surface of the main object; a flat one if it has none.
    pub fn main_surface(&self) -> SurfaceSource {
        let surface = self.main_object().surface.clone();
        surface.unwrap_or_else(|| SurfaceSource::built_in(SurfaceKind::Flat))
    }

    /// Returns the bounding sphere of everything but the ground.
    pub fn bounds(&self) -> Bounds {
        if let [only] = self.objects.as_slice() { only.mesh.bounds() } else { self.standing_bounds }
    }

    /// Returns the meshes of all objects.
    pub fn meshes(&self) -> impl Iterator<Item = &Mesh> {
        self.objects.iter().map(|object| &object.mesh)
    }

    /// Returns the meshes of everything but the ground.
    pub fn standing(&self) -> Vec<&Mesh> {
        self.objects.iter().filter(|object| !object.is_ground).map(|object| &object.mesh).collect()
    }

    /// Returns the distance from `centre` to the farthest point of all objects.
    pub fn reach(&self, centre: Vec3) -> f32 {
        let far = |mesh: &Mesh| mesh.bounds().centre.distance(centre) + mesh.bounds().radius;
        self.meshes().skip(1).map(far).fold(self.bounds().radius, f32::max)
    }
}

/// Opens the objects of a scene file, the ground last, if it has a color. Returns them with the bounding sphere of all but the ground.
fn objects(
    main: ObjectDocument,
    others: Vec<ObjectDocument>,
    ground: Option<[f32; 3]>,
    folder: &Path,
    task: &Task,
) -> Result<(Vec<Object>, Bounds)> {
    if others.len() + 2 > MAX_OBJECTS {
        return Err(Error::input(
            format!("there are {} objects", others.len()),
            format!("give at most {}", MAX_OBJECTS - 2),
        ));
    }
    let mut objects = vec![main.open(folder, task)?];
    for (i, object) in others.into_iter().enumerate() {
        objects.push(object.open(folder, task).map_err(|e| e.at(format!("object {}", i + 1)))?);
    }
    let meshes: Vec<&Mesh> = objects.iter().map(|object| &object.mesh).collect();
    let bounds = Bounds::enclosing(&meshes);
    if let Some(color) = ground {
        let lowest =
            |mesh: &Mesh| mesh.vertices().iter().map(|v| v.position[2]).fold(f32::INFINITY, f32::min);
        let z = meshes.into_iter().map(lowest).fold(f32::INFINITY, f32::min);
        objects.push(Object::ground(color.into(), bounds, z)?);
    }
    Ok((objects, bounds))
}

/// Returns the error for a `name` that is no scene. That of a surface has its own remedy.
fn no_scene(name: &OsStr, extension: &str) -> Error {
    let is_kind = name.to_str().and_then(SurfaceKind::from_name).is_some();
    if is_kind || files::is_extension(extension) {
        let what = format!("`{}` is a surface and no scene", name.display());
        return Error::usage(what, Remedy::SurfaceOnScene);
    }
    Error::usage(
        format!("there is no scene `{}`", name.display()),
        format!(
            "give one of {}, a scene file (.toml) or a mesh (.obj, .gltf, .glb, .ply, .stl)",
            BUILT_IN.map(|b| b.0).join(", ")
        ),
    )
}

/// Returns the remedy for an error of the TOML parser: for an unknown key, the known key that resembles it.
fn remedy(message: &str) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let unknown = quoted.next().filter(|_| message.starts_with("unknown field"));
    let resembling = unknown.and_then(|key| {
        let distance = |known: &&str| strsim::damerau_levenshtein(key, known);
        quoted.min_by_key(distance).filter(|known| distance(known) <= 1 + known.len() / 4)
    });
    match resembling {
        Some(known) => format!("do you mean `{known}`? See assets/scenes for whole examples"),
        None => "see assets/scenes for whole examples".to_owned(),
    }
}

/// Reads only the options of the scene file called `name`; a built-in scene and a mesh have none.
///
/// # Errors
/// A file that cannot be read or is no TOML.
pub fn options_of(name: &OsStr) -> Result<Vec<[String; 2]>> {
    let path = Path::new(name);
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    if !extension.eq_ignore_ascii_case("toml") {
        return Ok(Vec::new());
    }
    let text = input::read_text(path, "a scene file")?;
    #[derive(Deserialize)]
    struct OptionsAlone {
        #[serde(default)]
        options: FileOptions,
    }
    // Errors in the rest are reported when the scene is opened.
    let Ok(OptionsAlone { options }) = toml::from_str(&text) else { return Ok(Vec::new()) };
    scene_options::words(options, path.parent().unwrap_or(Path::new(""))).map_err(|e| e.at(path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::color::Tone;
    use crate::scene::Background;

    #[test]
    fn an_exposure_is_a_number_or_auto() {
        let plate = BUILT_IN[1].1;
        let with = |exposure: &str| {
            let rest: Vec<&str> = plate.lines().filter(|line| !line.starts_with("exposure")).collect();
            Scene::parse(&format!("exposure = {exposure}\n{}", rest.join("\n")), Path::new(""))
        };
        let read = |exposure: &str| {
            with(exposure).map(|scene| (scene.display.exposure, scene.display.auto_exposure)).unwrap()
        };
        assert_eq!([read("2"), read("-1.5"), read("\"auto\"")], [(2.0, false), (-1.5, false), (0.0, true)]);
        for wrong in ["\"Auto\"", "true", "[1]", "41", "1e300"] {
            let e = with(wrong).map(|_| ()).unwrap_err().to_string();
            assert!(e.contains("exposure") && e.contains("; "), "{wrong}: {e}");
        }
    }

    #[test]
    fn every_built_in_scene_opens_and_stands_upright() {
        for (name, _) in BUILT_IN {
            let scene = Scene::open(name).unwrap();
            assert!(!scene.lights.is_empty() && scene.main_object().mesh.triangle_count() > 0, "{name}");
        }
        let plate = Scene::open("plate").unwrap();
        assert_eq!(plate.main_object().mesh.vertices()[0].normal, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn the_scenes_of_the_project_and_of_its_documents_are_read() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let texts = |folder: &str, extension: &str| -> Vec<String> {
            let files = std::fs::read_dir(root.join(folder)).unwrap().map(|entry| entry.unwrap().path());
            let files = files.filter(|file| file.extension().is_some_and(|e| e == extension));
            files.map(|file| std::fs::read_to_string(file).unwrap()).collect()
        };
        // Scenes that a command of a document writes.
        let written = |document: String| -> Vec<String> {
            let scenes = document.split(".toml <<'END'\n").skip(1);
            scenes.map(|rest| rest.split("\nEND\n").next().unwrap_or_default().to_owned()).collect()
        };
        let mut scenes = texts("assets/scenes", "toml");
        let (files, documents) = (scenes.len(), texts("docs", "md").into_iter().flat_map(written));
        scenes.extend(documents);
        assert!(files >= BUILT_IN.len() && scenes.len() >= files + 4, "{files} of {} scenes", scenes.len());
        for scene in scenes {
            // The meshes of documents are made by their commands.
            let is_of_file = |line: &&str| line.starts_with("mesh = ") && line.contains(".obj\"");
            let own = scene.lines().find(is_of_file).map(str::to_owned);
            let text = own.map_or(scene.clone(), |line| scene.replace(&line, "mesh = \"plate\""));
            Scene::parse(&text, Path::new("")).unwrap_or_else(|e| panic!("{e} in\n{scene}"));
        }
    }

    #[test]
    fn a_scene_says_how_long_its_unit_is_or_it_is_a_metre() {
        let plate = BUILT_IN[1].1;
        let unscaled: String = plate
            .lines()
            .filter(|line| !line.starts_with("scale"))
            .map(|line| line.to_owned() + "\n")
            .collect();
        let unit = |line: &str| Scene::parse(&format!("{line}\n{unscaled}"), Path::new("")).map(|s| s.unit);
        assert_eq!(unit("").unwrap(), 1.0);
        assert_eq!(unit("scale = \"1 m\"").unwrap(), 1.0);
        assert!((unit("scale = \"60mm\"").unwrap() - 0.06).abs() < 1e-15);
        for wrong in ["scale = \"1\"", "scale = \"0 m\"", "scale = \"-1 m\"", "scale = 1"] {
            assert!(unit(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn settings_of_options_stand_in_place_of_those_of_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = folder.path().join("a.stl");
        let corners = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 2\n";
        let text = format!("solid a\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\nendsolid\n");
        std::fs::write(&mesh, text).unwrap();
        let open = |name: &Path, overrides: &SceneOverrides| {
            Scene::open_telling(name.as_os_str(), overrides, &Task::silent()).unwrap()
        };
        let highest = |scene: &Scene| {
            scene
                .main_object()
                .mesh
                .vertices()
                .iter()
                .map(|v| v.position[2])
                .fold(f32::NEG_INFINITY, f32::max)
        };
        let plain = open(&mesh, &SceneOverrides::default());
        assert_eq!((highest(&plain), &plain.main_object().grooves), (2.0, &Grooves::Along));
        assert!(plain.notes()[0].contains("a.stl: without texture coordinates"), "{:?}", plain.notes());
        let overrides = SceneOverrides { scale: Some(2e3), up: Some(Up::Y), grooves: Some(Grooves::Radial) };
        let scene_file = folder.path().join("a.toml");
        let document = BUILT_IN[1].1.replace("mesh = \"plate\"", "mesh = \"a.stl\"");
        std::fs::write(&scene_file, format!("grooves = \"3deg\"\n{document}")).unwrap();
        for name in [&mesh, &scene_file] {
            let scene = open(name, &overrides);
            assert_eq!((highest(&scene), &scene.main_object().grooves), (1.0, &Grooves::Radial));
            assert!((scene.unit - 2e-3).abs() < 1e-15 && scene.overrides == overrides);
        }
        let built_in = Scene::open_telling("plate".as_ref(), &overrides, &Task::silent());
        assert!(built_in.map(|_| ()).unwrap_err().to_string().contains("leave `up` away"));
    }

    #[test]
    fn a_mesh_of_colours_is_the_pigment_unless_the_scene_names_another() {
        let folder = tempfile::tempdir().unwrap();
        let mesh =
            "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";
        for (name, text) in [("a.obj", mesh), ("a.mtl", "newmtl a\nKd 0.25 0.5 1\n")] {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let plate = BUILT_IN[1].1.replace("mesh = \"plate\"", "mesh = \"a.obj\"");
        let without: String = plate
            .lines()
            .filter(|line| !line.starts_with("base_color"))
            .map(|line| line.to_owned() + "\n")
            .collect();
        let color = |text: &str| Scene::parse(text, folder.path()).unwrap().main_object().base_color;
        let painted = Vec3::new(0.25, 0.5, 1.0);
        assert_eq!(color(&without), painted);
        assert_ne!(color(&plate), painted);
        assert_eq!(Scene::open(folder.path().join("a.obj")).unwrap().main_object().base_color, painted);
    }

    #[test]
    fn a_scene_prepares_its_surface_in_the_order_that_it_gives() {
        let plate = BUILT_IN[1].1;
        let with = |steps: &str| Scene::parse(&format!("prepare = {steps}\n{plate}"), Path::new(""));
        let steps_of = |scene: Scene| scene.main_object().surface.clone().unwrap().prepare;
        let steps = steps_of(with("[\"level rows\", \"crop 40um\", \"level none\", \"invert\"]").unwrap());
        assert_eq!(crate::surface::prepare::describe(&steps), "level rows, crop 40um, invert");
        assert!(steps_of(Scene::parse(plate, Path::new("")).unwrap()).is_empty());
        for (wrong, said) in
            [("[\"level top\"]", "prepare: there is no level `top`"), ("\"invert\"", "line 1")]
        {
            assert!(with(wrong).unwrap_err().to_string().contains(said), "{wrong}");
        }
    }

    #[test]
    fn a_scene_stands_before_a_colour_or_before_its_surroundings() {
        let plate = BUILT_IN[1].1.replace("background = [0.02, 0.021, 0.023]\n", "");
        let scene = |line: &str| Scene::parse(&format!("{line}\n{plate}"), Path::new(""));
        let background = |line: &str| scene(line).unwrap().display.background;
        assert_eq!(background(""), Background::default());
        assert_eq!(
            background("background = [0.1, 0.2, 0.3]"),
            Background::Color(glam::DVec3::new(0.1, 0.2, 0.3))
        );
        assert_eq!(background("background = \"surroundings\""), Background::Surroundings);
        for wrong in ["background = \"sky\"", "background = 1", "background = [1, 2]"] {
            assert!(scene(wrong).unwrap_err().to_string().contains("line 1"), "{wrong}");
        }
    }

    #[test]
    fn a_scene_names_a_tone_or_has_none() {
        let plate = BUILT_IN[1].1.replace("tone = \"neutral\"\n", "");
        let tone =
            |line: &str| Scene::parse(&format!("{line}\n{plate}"), Path::new("")).map(|s| s.display.tone);
        assert_eq!(tone("").unwrap(), Tone::None);
        assert_eq!(tone("tone = \"none\"").unwrap(), Tone::None);
        assert_eq!(tone("tone = \"neutral\"").unwrap(), Tone::Neutral);
        for wrong in ["tone = \"filmic\"", "tone = \"Neutral\"", "tone = \"\""] {
            let said = tone(wrong).unwrap_err().to_string();
            assert!(said.contains("line 1") && said.contains("none or neutral"), "{wrong}: {said}");
        }
        assert!(tone("tone = 1").is_err());
    }

    #[test]
    fn objects_stand_where_their_pose_says_and_the_ground_below_them() {
        let plate = BUILT_IN[1].1;
        let object = "[[objects]]\nmesh = \"plate\"\nposition = [3.0, 0.0, 2.0]\nsize = 2.0\nrotation = [\"0deg\", \"90deg\", \"0deg\"]\n";
        let scene = |head: &str, more: &str| Scene::parse(&format!("{head}\n{plate}\n{more}"), Path::new(""));
        let two =
            scene("ground = [0.5, 0.5, 0.5]\ngrooves = \"30deg\"", &format!("{object}grooves = \"radial\""))
                .unwrap();
        assert_eq!(two.main_object().grooves, Grooves::Turned(30.0));
        let [_, other, ground] = two.objects.as_slice() else { panic!("{} objects", two.objects.len()) };
        assert!(other.grooves == Grooves::Radial && other.surface.is_none() && !other.is_ground);
        // The plate's x leads down now, and its normal along x.
        let corner = other.mesh.vertices().iter().find(|v| v.uv == [1.0, 1.0]).unwrap();
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(near(corner.position, [3.0, 1.0, 1.0]), "{corner:?}");
        assert!(near(corner.normal, [1.0, 0.0, 0.0]), "{corner:?}");
        let lowest = ground.mesh.vertices()[0].position[2];
        assert!(ground.is_ground && lowest == 0.0, "{lowest}");
        // The framed bounds leave out the ground; the drawn scene reaches farther.
        let bounds = two.bounds();
        assert!(bounds.radius < 3.0 && two.reach(bounds.centre) > 3.0 * bounds.radius);
        for (head, more, said) in [
            ("", "[[objects]]\nmesh = \"plate\"\nsize = 0.0", "object 1: an object has no place or size"),
            ("", "[[objects]]\nmesh = \"plate\"\nsurfac = \"blaze\"", "do you mean `surface`?"),
            ("", "[[objects]]\nmesh = \"plate\"\nrotation = [\"1deg\"]", "1 numbers where 3 belong"),
            ("", "[[objects]]\nmesh = \"plate\"\nrotation = [\"1\", \"0deg\", \"0deg\"]", "write 1deg"),
            ("", "[[objects]]\nmesh = \"plate\"\nsize = 1e30", "object 1: the mesh stands beyond 1e9"),
            (
                "",
                "[[objects]]\nmesh = \"plate\"\nsize = 1e-40\nposition = [1.0, 0.0, 0.0]",
                "all of it in one place",
            ),
            (
                "ground = [1.0, 1.0, 1.0]",
                "[[objects]]\nmesh = \"plate\"\nsize = 1.9e9",
                "the mesh stands beyond 1e9",
            ),
            ("ground = [2.0, 0.0, 0.0]", "", "a colour is not within 0 to 1"),
            ("", &"[[objects]]\nmesh = \"plate\"\n".repeat(63), "there are 63 objects"),
        ] {
            let error = scene(head, more).unwrap_err().to_string();
            assert!(error.contains(said), "{more}: {error}");
        }
    }

    #[test]
    fn wrong_scenes_are_refused_by_line() {
        let wrong = |text: &str| Scene::parse(text, Path::new("")).unwrap_err().to_string();
        assert!(wrong("mesh = 3\n").contains("line 1"), "{}", wrong("mesh = 3\n"));
        let plate = BUILT_IN[1].1;
        assert!(wrong(&format!("unknown = 1\n{plate}")).contains("unknown"));
        for (key, meant) in
            [("exposur", "`exposure`"), ("base_colour", "`base_color`"), ("light", "`lights`")]
        {
            let said = wrong(&format!("{key} = 1\n{plate}"));
            assert!(said.contains("line 1") && said.contains(&format!("do you mean {meant}?")), "{said}");
        }
        assert!(!wrong(&format!("zzz = 1\n{plate}")).contains("do you mean"));
        for (three, other, count) in [
            ("eye = [1.0,", "eye = [9.0, 1.0,", 4),
            ("target = [0.02,", "target = [", 2),
            ("base_color = [0.06,", "base_color = [0.1, 0.1, 0.06,", 5),
            ("background = [0.02,", "background = [", 2),
        ] {
            let changed = plate.replace(three, other);
            let said = wrong(&changed);
            assert!(changed != plate && said.contains(&format!("{count} numbers where 3 belong")), "{said}");
        }
        assert!(Scene::open("nothing").is_err());
        assert!(Scene::open("nothing.toml").unwrap_err().to_string().contains("no such file"));
    }
}
