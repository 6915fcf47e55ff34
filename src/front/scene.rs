//! Scenes of meshes with surfaces, lights and a camera.

use crate::error::{Error, Result};
use crate::scene::environment::{Environment, Placement};
use crate::scene::object::{MeshSource, Pose, Up, check_colors};
use crate::scene::{
    Background, Bounds, Camera, Corner, Grooves, Lens, Light, Mesh, Object, Scene, SceneOverrides,
};
use crate::surface::SurfaceSource;
use crate::task::Task;
use std::path::Path;

impl Scene {
    /// Opens a built-in scene by name, a scene file, or a mesh file that the camera and the lights of the scene `sphere` show.
    ///
    /// # Errors
    /// Fails for a name that is neither, and for a file that holds no scene; the message tells the place and the remedy.
    pub fn open(name: impl AsRef<Path>) -> Result<Self> {
        Self::open_telling(name.as_ref().as_os_str(), &SceneOverrides::default(), &Task::silent())
    }

    /// Returns a scene of `objects`, the first of which has the surface that pictures are drawn with, lit from 30° by a light of intensity 1 and seen from in front.
    ///
    /// # Errors
    /// Fails without an object.
    pub fn new(objects: Vec<Object>) -> Result<Self> {
        let Some(first) = objects.first() else {
            return Err(Error::usage("a scene without an object shows nothing", "give at least one"));
        };
        let meshes: Vec<&Mesh> = objects.iter().map(|object| &object.mesh).collect();
        let standing_bounds =
            if meshes.len() == 1 { first.mesh.bounds() } else { Bounds::enclosing(&meshes) };
        let mut scene = Self::open("plate")?;
        /// Distance of the camera from the middle, in radii: all is in sight under its angle of view.
        const DISTANCE: f32 = 4.0;
        scene.camera.target = standing_bounds.centre;
        scene.camera.distance = DISTANCE * standing_bounds.radius;
        Ok(Self { objects, standing_bounds, lights: vec![Light::point(30.0, 0.0, 1.0)], ..scene })
    }

    /// Returns the scene with a camera at `eye` that looks at `target` under the vertical angle of view `angle` \[degrees\]. Up is +z.
    ///
    /// # Errors
    /// Fails for an eye at the target, and an angle not within 1 to 170.
    pub fn with_camera(self, eye: [f64; 3], target: [f64; 3], angle: f64) -> Result<Self> {
        let [eye, target] = [eye, target].map(|place| place.map(|x| x as f32).into());
        Ok(Self {
            camera: Camera::looking(eye, target, Lens::perspective(angle.to_radians() as f32))?,
            ..self
        })
    }

    /// Returns the scene with these lights instead of its own.
    #[must_use]
    pub fn with_lights(self, lights: impl IntoIterator<Item = Light>) -> Self {
        Self { lights: lights.into_iter().collect(), ..self }
    }

    /// Returns the scene in surroundings: a built-in name such as `sky`, or an equirectangular .exr or .hdr picture, turned by `rotation` \[degrees\] and brightened by
    /// `stops`.
    ///
    /// # Errors
    /// Fails for a picture that cannot be read, and for numbers out of range.
    pub fn with_surroundings(self, name: &str, rotation: f64, stops: f64) -> Result<Self> {
        let mut environment = Environment::open(name)?;
        environment.placement = Placement::new(rotation, stops)?;
        Ok(Self { environment: Some(environment), ..self })
    }

    /// Returns the scene displayed after an exposure of so many `stops`.
    #[must_use]
    pub fn with_exposure(mut self, stops: f64) -> Self {
        (self.display.exposure, self.display.auto_exposure) = (stops, false);
        self
    }

    /// Returns the scene before a background of this linear sRGB, from 0 to 1 each, which makes pictures opaque.
    ///
    /// # Errors
    /// Fails for numbers out of range.
    pub fn with_background(mut self, color: [f64; 3]) -> Result<Self> {
        check_colors(color)?;
        (self.display.background, self.display.is_opaque) = (Background::Color(color.into()), true);
        Ok(self)
    }

    /// Returns the scene with or without shadows of the objects on each other and on themselves.
    #[must_use]
    pub fn with_shadows(self, shadows: bool) -> Self {
        Self { shadows, ..self }
    }
}

impl Object {
    /// Returns an object of `mesh` at the origin with a black pigment. The first object of a scene has the surface that a picture is drawn with; another one has none until
    /// [`Self::with_surface`].
    pub fn new(mesh: Mesh) -> Self {
        Self {
            mesh,
            mesh_source: MeshSource { name: "mesh".into(), up: Up::Z, part: None },
            pose: Pose::default(),
            surface: None,
            grooves: Grooves::Along,
            reflectance: None,
            base_color: glam::Vec3::ZERO,
            pigment: None,
            is_ground: false,
            mesh_notes: Vec::new(),
        }
    }

    /// Returns the object with the surface in a file or of a built-in name.
    #[must_use]
    pub fn with_surface(self, name: impl AsRef<Path>) -> Self {
        Self { surface: Some(SurfaceSource::named(name.as_ref().as_os_str())), ..self }
    }

    /// Returns the object with the x axis of its surface turned by `angle` \[degrees\] from the direction of growing u toward that of growing v.
    #[must_use]
    pub fn with_grooves_turned(self, angle: f64) -> Self {
        Self { grooves: Grooves::Turned(angle), ..self }
    }

    /// Returns the object with a pigment of this albedo, linear sRGB from 0 to 1.
    ///
    /// # Errors
    /// Fails for numbers out of range.
    pub fn with_pigment(self, albedo: [f64; 3]) -> Result<Self> {
        check_colors(albedo)?;
        Ok(Self { base_color: albedo.map(|c| c as f32).into(), ..self })
    }

    /// Returns the object `size` times as large, moved to `position`.
    ///
    /// # Errors
    /// Fails for coordinates beyond ±10⁹.
    pub fn placed(self, size: f64, position: [f64; 3]) -> Result<Self> {
        let mesh = self.mesh.moved(size as f32, position.map(|x| x as f32).into())?;
        Ok(Self { mesh, ..self })
    }
}

impl Mesh {
    /// Returns the mesh of triangles between `positions`, whose corners are listed in `indices`, three a triangle, counter-clockwise as seen from outside. Up is +z.
    /// `uvs` has the texture coordinates of each position, or is empty: then they are projected along the axes. Normals are smooth.
    ///
    /// # Errors
    /// Fails for an index out of range, a length that does not fit, coordinates that are not finite, and no triangle with an area.
    pub fn from_buffers(positions: &[[f32; 3]], indices: &[u32], uvs: &[[f32; 2]]) -> Result<Self> {
        let refused = |what: String| {
            Err(Error::input(what, "give three indices a triangle, and a pair of uv a position"))
        };
        if !indices.len().is_multiple_of(3) {
            return refused(format!("{} indices make no whole triangles", indices.len()));
        }
        if !uvs.is_empty() && uvs.len() != positions.len() {
            return refused(format!("{} positions have {} texture coordinates", positions.len(), uvs.len()));
        }
        if let Some(index) = indices.iter().find(|i| **i as usize >= positions.len()) {
            return refused(format!("there is no position {index} among {}", positions.len()));
        }
        let corner = |index: u32| Corner {
            position: positions[index as usize],
            normal: None,
            uv: uvs.get(index as usize).copied(),
        };
        let triangles = indices.chunks_exact(3).map(|of| [of[0], of[1], of[2]].map(corner));
        Self::from_triangles(triangles.collect())
    }
}

impl Light {
    /// Returns a point of the sky at these angles from up and around it \[degrees\].
    pub fn new(theta: f64, phi: f64, intensity: f64) -> Self {
        Self::point(theta, phi, intensity)
    }

    /// Parses a light in the words of `--light`: `40,90`, `sun:40,90`, `disc:5deg:40,90`, `sphere:0.1:0,0,2`, `rectangle:0.4x0.2:0,-1,1`, each with an optional spectrum
    /// behind `@`.
    ///
    /// # Errors
    /// Fails for another form, and for a spectrum that cannot be read.
    pub fn from_words(text: &str) -> Result<Self> {
        Self::parse(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_built_from_arrays() {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let uvs = square.map(|[x, y, _]| [x, y]);
        let mesh = Mesh::from_buffers(&square, &[0, 1, 2, 0, 2, 3], &uvs).unwrap();
        assert_eq!(mesh.triangle_count(), 2);
        let tile = Object::new(mesh.clone()).with_pigment([0.1, 0.2, 0.3]).unwrap();
        let other = Object::new(mesh.clone()).with_surface("blaze").placed(2.0, [3.0, 0.0, 0.0]).unwrap();
        let scene = Scene::new(vec![tile, other]).unwrap();
        let scene = scene.with_camera([0.5, -3.0, 3.0], [0.5, 0.5, 0.0], 35.0).unwrap();
        let scene =
            scene.with_lights([Light::new(20.0, 0.0, 1.0), Light::from_words("sun:40,90@a").unwrap()]);
        assert_eq!((scene.objects.len(), scene.lights.len()), (2, 2));
        assert!(scene.bounds().radius > 2.0);
        assert!(Scene::new(Vec::new()).is_err());
        assert!(Mesh::from_buffers(&square, &[0, 1], &[]).is_err(), "no whole triangle");
        assert!(Mesh::from_buffers(&square, &[0, 1, 4], &[]).is_err(), "no such position");
        assert!(Mesh::from_buffers(&square, &[0, 1, 2], &uvs[..1]).is_err(), "too few texture coordinates");
        assert!(Object::new(mesh).with_pigment([2.0, 0.0, 0.0]).is_err());
    }
}
