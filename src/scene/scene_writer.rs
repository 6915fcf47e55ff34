//! Scenes as the text of a scene file, which reads as the same scene.

use super::environment;
use super::object::{Grooves, Object};
use super::scene_document::{
    Angle, CameraDocument, EnvironmentDocument, Exactly, ObjectDocument, SceneDocument, SceneExposure,
    ToneName,
};
use super::scene_file::Scene;
use super::scene_options::OptionValue;
use super::{Camera, Lens, LensProjection};
use crate::error::{Error, Result};
use crate::optics::material::Material;
use crate::optics::reflectance::Reflectance;
use crate::surface::synth::SurfaceKind;
use glam::Vec3;
use std::path::Path;

impl ObjectDocument {
    /// Returns the document of `object` in a scene file in `folder`.
    fn of(object: &Object, folder: &Path) -> Result<Self> {
        let path = |path: &Path| named_from(path, folder);
        let surface = object.surface.as_ref();
        let [material, film] = reflecting(object.reflectance.as_ref(), folder)?;
        Ok(Self {
            mesh: path(&object.mesh_source.name)?,
            up: Some(object.mesh_source.up),
            part: object.mesh_source.part.clone(),
            position: Exactly(object.pose.position.to_array()),
            rotation: Exactly(object.pose.rotation.map(Angle)),
            size: object.pose.size,
            surface: surface.map(|surface| path(Path::new(&surface.name))).transpose()?,
            pixel_size: surface.and_then(|surface| surface.pixel_size).map(micrometres),
            height: surface.and_then(|surface| surface.height).map(|height| format!("{height}um")),
            prepare: surface.map_or(Vec::new(), |s| s.prepare.iter().map(ToString::to_string).collect()),
            grooves: grooves(&object.grooves, folder)?,
            material,
            film,
            base_color: Some(Exactly(object.base_color.to_array())),
            pigment: object.pigment.as_deref().map(path).transpose()?,
        })
    }
}

/// Returns the material and film of a scene file in `folder`.
fn reflecting(reflectance: Option<&Reflectance>, folder: &Path) -> Result<[Option<String>; 2]> {
    match reflectance {
        Some(Reflectance::Fresnel { material, film, .. }) if material.constant_index().is_none() => {
            let name = &material.name;
            let is_built_in = Material::is_built_in(name);
            let name = if is_built_in { name.clone() } else { named_from(Path::new(name), folder)? };
            Ok([Some(name), film.as_ref().map(ToString::to_string)])
        }
        _ => Ok([None, None]),
    }
}

/// Writes the orientation of the patch in the form of a scene file in `folder`.
fn grooves(grooves: &Grooves, folder: &Path) -> Result<Option<String>> {
    Ok(match grooves {
        Grooves::Along => None,
        Grooves::Turned(angle) => Some(format!("{angle}deg")),
        Grooves::Radial => Some("radial".to_owned()),
        Grooves::Map(file) => Some(named_from(file, folder)?),
    })
}

/// Returns a pair of lengths \[µm\] with its unit.
fn micrometres([x, y]: [f64; 2]) -> String {
    format!("{x}umx{y}um")
}

#[doc(hidden)]
impl Scene {
    /// Writes the text of a scene file in `folder` that reads as this scene. Names of files in the folder are relative to it, others
    /// absolute.
    ///
    /// # Errors
    /// Names of files that are not UTF-8.
    pub fn to_toml(&self, folder: &Path) -> Result<String> {
        let path = |path: &Path| named_from(path, folder);
        let main = ObjectDocument::of(self.main_object(), folder)?;
        let [ground, others]: [Vec<&Object>; 2] = [true, false]
            .map(|is_ground| self.objects.iter().skip(1).filter(|o| o.is_ground == is_ground).collect());
        let options = self.options.iter().map(|[name, value]| {
            let is_file = Path::new(value).is_file();
            let value = if is_file { path(Path::new(value))? } else { value.clone() };
            Ok((name.clone(), OptionValue::Text(value)))
        });
        let file = SceneDocument {
            scale: Some(format!("{} m", significant(self.unit))),
            mesh: main.mesh,
            up: main.up,
            part: main.part,
            surface: main.surface.unwrap_or_else(|| SurfaceKind::Flat.name().to_owned()),
            pixel_size: main.pixel_size,
            height: main.height,
            prepare: main.prepare,
            base_color: main.base_color,
            pigment: main.pigment,
            grooves: main.grooves,
            material: main.material,
            film: main.film,
            ground: ground.first().map(|ground| Exactly(ground.base_color.to_array())),
            exposure: SceneExposure { stops: self.display.exposure, is_auto: self.display.auto_exposure },
            tone: ToneName(self.display.tone),
            background: self.display.background,
            shadows: self.shadows,
            lights: self.lights.iter().map(|light| light.to_text(path)).collect::<Result<_>>()?,
            environment: self
                .environment
                .as_ref()
                .map(|surroundings| {
                    let name = &surroundings.name;
                    let is_built_in = environment::is_built_in(name);
                    let name = if is_built_in { name.clone() } else { path(Path::new(name))? };
                    let (rotation, exposure) = (
                        Some(format!("{}deg", surroundings.placement.rotation)),
                        surroundings.placement.exposure,
                    );
                    Ok::<_, Error>(EnvironmentDocument { name, rotation, exposure })
                })
                .transpose()?,
            camera: camera_document(&self.camera),
            objects: others.into_iter().map(|o| ObjectDocument::of(o, folder)).collect::<Result<_>>()?,
            options: options.collect::<Result<_>>()?,
        };
        toml::to_string(&file)
            .map_err(|e| Error::bug(format!("the scene cannot be written ({e})")).caused_by(e))
    }
}

/// Returns the name of a file relative to `folder`, if it lies there; a name of something built in is returned unchanged.
fn named_from(path: &Path, folder: &Path) -> Result<String> {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let named = if path.is_file() {
        let from_root = absolute(path);
        from_root.strip_prefix(absolute(folder)).map(Path::to_owned).unwrap_or(from_root)
    } else {
        path.to_owned()
    };
    named
        .to_str()
        .map(str::to_owned)
        .ok_or_else(|| Error::input(format!("the name {} is not UTF-8", path.display()), "rename the file"))
}

/// Rounds `x` to twelve digits, without the rounding of lengths on the way to metres and back.
fn significant(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// Converts an angle \[rad\] to degrees, with as many digits as reading back the same angle needs.
fn degrees(radians: f32) -> f64 {
    let exact = f64::from(radians).to_degrees();
    let rounded = |digits: i32| {
        let factor = 10f64.powi(digits);
        (exact * factor).round() / factor
    };
    (0..12).map(rounded).find(|degrees| degrees.to_radians() as f32 == radians).unwrap_or(exact)
}

/// Returns `camera` as a scene file has it.
fn camera_document(camera: &Camera) -> CameraDocument {
    let Lens { projection, roll, shift } = camera.lens;
    let (field_of_view, height) = match projection {
        LensProjection::Perspective { field_of_view } => {
            (Some(format!("{}deg", degrees(field_of_view))), None)
        }
        LensProjection::Orthographic { height } => (None, Some(height)),
    };
    CameraDocument {
        eye: Exactly(eye_of(camera).to_array()),
        target: Exactly(camera.target.to_array()),
        field_of_view,
        height,
        roll: (roll != 0.0).then(|| format!("{}deg", degrees(roll))),
        shift: (shift != [0.0; 2]).then_some(Exactly(shift)),
    }
}

/// Returns an eye that makes `camera` when it is read again. The eye that follows from a camera's angles may be off in the last bits.
fn eye_of(camera: &Camera) -> Vec3 {
    /// Offsets of a coordinate that are tried, in units in the last place.
    const STEPS: [i32; 5] = [0, 1, -1, 2, -2];
    let eye = camera.eye();
    let moved = |x: f32, steps: i32| {
        (0..steps.abs()).fold(x, |x, _| if steps > 0 { x.next_up() } else { x.next_down() })
    };
    let near = (0..STEPS.len().pow(3)).map(|i| [i, i / STEPS.len(), i / STEPS.len().pow(2)]);
    let near = near.map(|places| places.map(|place| STEPS[place % STEPS.len()]));
    let mut eyes = near.map(|[i, j, k]| Vec3::new(moved(eye.x, i), moved(eye.y, j), moved(eye.z, k)));
    let reads_the_same =
        |eye: &Vec3| Camera::looking(*eye, camera.target, camera.lens).is_ok_and(|read| read == *camera);
    eyes.find(reads_the_same).unwrap_or(eye)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::color::Tone;
    use crate::optics::reflectance::Film;
    use crate::scene::Background;
    use crate::scene::environment::Placement;
    use crate::scene::scene_file::BUILT_IN;
    use crate::scene::{Environment, Light};
    use crate::surface::SurfaceSource;
    use crate::surface::prepare::PreparationStep;

    fn read(text: &str, folder: &Path) -> Scene {
        Scene::parse(text, folder).unwrap_or_else(|e| panic!("{e} in\n{text}"))
    }

    /// Returns the debug text of a scene without its mesh.
    fn described(scene: &Scene) -> String {
        let mut plain = Scene { files: Vec::new(), unit: 0.0, ..scene.clone() };
        plain.main_object_mut().mesh = crate::scene::primitives::plate();
        format!("{plain:?}")
    }

    #[test]
    fn every_built_in_scene_reads_as_itself_and_writes_as_itself() {
        for (name, _) in BUILT_IN {
            let scene = Scene::open(name).unwrap();
            let text = scene.to_toml(Path::new("")).unwrap();
            let again = read(&text, Path::new(""));
            assert_eq!(described(&again), described(&scene), "{name}");
            assert!(
                (again.unit / scene.unit - 1.0).abs() < 1e-12
                    && again.main_object().mesh.vertices() == scene.main_object().mesh.vertices()
            );
            assert_eq!(again.to_toml(Path::new("")).unwrap(), text, "{name}");
        }
    }

    #[test]
    fn everything_that_can_be_set_is_kept_and_files_move_with_their_folder() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let mesh = file("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
        let (scan, spectrum) = (file("a scan.png", "x"), file("lamp.csv", "400,1\n700,1\n"));
        let mut scene = Scene::open(&mesh).unwrap();
        let object = scene.main_object_mut();
        object.surface = Some(SurfaceSource {
            name: scan.clone().into(),
            pixel_size: Some([0.1, 0.097_66]),
            height: Some(0.4347),
            prepare: ["level rows", "crop 40um", "invert"]
                .map(|step| PreparationStep::parse(step).unwrap())
                .to_vec(),
            ..SurfaceSource::built_in(SurfaceKind::Flat)
        });
        object.base_color = Vec3::new(0.1, 0.7, 0.3);
        (scene.display.exposure, scene.display.tone) = (-1.5, Tone::Neutral);
        scene.display.background = Background::Color(glam::DVec3::new(0.25, 0.5, 1.0));
        scene.lights = ["sun:30,-40,2.5@led", "sphere:0.1:0.2,0.3,1,60W@lamp.csv"]
            .map(|light| Light::parse_in(light, folder.path()).unwrap())
            .to_vec();
        scene.environment =
            Some(Environment::open("studio").unwrap().placed(Placement { rotation: 40.5, exposure: -2.0 }));
        scene.shadows = false;
        scene.unit = 0.104;
        let material = Material::from_name_or_file("gold").unwrap();
        scene.main_object_mut().reflectance =
            Some(Reflectance::of_material(material, Some(Film::parse("120nm:1.7").unwrap())));
        let spectrum_name = spectrum.to_str().unwrap().to_owned();
        scene.options = [["illuminant", &spectrum_name], ["tolerance", "2e-2"], ["windows", "all"]]
            .map(|pair| pair.map(str::to_owned))
            .to_vec();
        let several = [
            "mesh = \"square.obj\"\nup = \"y\"\nsurface = \"flat\"\nground = [0.5, 0.4, 0.3]\nlights = []",
            "[camera]\neye = [1.0, 0.0, 1.5]\ntarget = [0.02, 0.0, 0.0]\nfield_of_view = \"35deg\"",
            "[[objects]]\nmesh = \"plate\"\nup = \"z\"\nposition = [0.1, 2.3, -1.7]\nrotation = [\"12.3deg\", \"0deg\", \"-7deg\"]",
            "size = 0.3\nsurface = \"a scan.png\"\npixel_size = \"0.1um\"\nheight = \"0.43um\"\nprepare = [\"invert\"]",
            "grooves = \"lamp.csv\"\nmaterial = \"silver\"\nfilm = \"100nm:1.5\"\nbase_color = [0.1, 0.2, 0.3]",
            "[[objects]]\nmesh = \"sphere\"\ngrooves = \"radial\"\npigment = \"a scan.png\"",
        ];
        let several = read(&several.join("\n"), folder.path());
        scene.objects.extend(several.objects.into_iter().skip(1));
        scene.standing_bounds = several.standing_bounds;
        scene.main_object_mut().grooves = Grooves::Turned(12.5);
        for step in 0..40u16 {
            let x = f32::from(step);
            scene.camera.phi = 0.13 * x;
            scene.camera.theta = 0.07 * x + 0.05;
            scene.camera.lens = match step % 4 {
                0 => Lens::perspective(0.1 + 0.03 * x),
                1 => Lens { roll: 0.17 * x - 3.0, ..Lens::perspective(0.6) },
                2 => Lens { shift: [0.07 * x, -0.3], ..Lens::orthographic(0.1 + 0.3 * x) },
                _ => Lens::orthographic(2.0),
            };
            scene.camera =
                Camera::looking(scene.camera.eye(), scene.camera.target, scene.camera.lens).unwrap();
            let text = scene.to_toml(folder.path()).unwrap();
            let again = read(&text, folder.path());
            assert_eq!(described(&again), described(&scene), "{text}");
            assert!(
                text.contains("surface = \"a scan.png\"") && text.contains("mesh = \"square.obj\""),
                "{text}"
            );
        }
        // From another folder, files are named from the root.
        let elsewhere = tempfile::tempdir().unwrap();
        let text = scene.to_toml(elsewhere.path()).unwrap();
        assert_eq!(read(&text, elsewhere.path()).main_object().surface, scene.main_object().surface);
    }

    #[test]
    fn a_written_scene_reads_as_an_equal_scene() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [
            ("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n"),
            ("lamp.csv", "400,1\n700,1\n"),
            ("scan.png", "x"),
        ] {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let text = r#"
            scale = "104mm"
            mesh = "square.obj"
            surface = "scan.png"
            pixel_size = "0.1umx0.2um"
            height = "0.4347um"
            prepare = ["level rows", "crop 40um"]
            base_color = [0.1, 0.7, 0.3]
            pigment = "scan.png"
            grooves = "12.5deg"
            material = "gold"
            film = "120nm:1.7"
            ground = [0.5, 0.4, 0.3]
            exposure = "auto"
            tone = "neutral"
            background = "surroundings"
            shadows = false
            lights = ["sun:30,-40,2.5@lamp.csv", "rectangle:0.4x0.2:0,-1,1"]
            environment = { name = "studio", rotation = "40.5deg", exposure = -2 }
            camera = { eye = [1.0, 0.0, 1.5], target = [0.02, 0.0, 0.0], field_of_view = "35deg" }
            options = { tolerance = 0.02, seed = 18446744073709551615, illuminant = "lamp.csv" }
            [[objects]]
            mesh = "plate"
            up = "z"
            position = [0.1, 2.3, -1.7]
            rotation = ["12.3deg", "0deg", "-7deg"]
            size = 0.3
            surface = "blaze"
            height = "0.43um"
            [[objects]]
            mesh = "sphere"
            grooves = "radial"
        "#;
        let scene = read(text, folder.path());
        let written = scene.to_toml(folder.path()).unwrap();
        let again = read(&written, folder.path());
        assert!(again == scene, "{written}");
        assert!(again.display.auto_exposure && again.objects.len() == 4, "{written}");
        let moved = written.replace("position = [0.1,", "position = [0.2,");
        assert!(moved != written && read(&moved, folder.path()) != scene, "{written}");
    }
}
