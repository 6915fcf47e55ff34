//! Directions that pixels see, by rays in f64: the geometry of the reference, which shares no step with the passes that it judges.
//!
//! A ray leads through the place of a pixel at which a sample looks, and to the nearest triangle of all objects. Normal and tangent are interpolated there,
//! as the mesh defines them, and the vectors to viewer and light are taken into that frame; `surface.vert` takes them at the vertices. A footprint is the
//! difference across one pixel on the plane of the triangle.

mod reflection;
mod surface;
mod triangles;

use super::directions::Directions;
use super::frame::View;
use super::grooves::GrooveDirections;
use super::light_passes::LightPass;
use super::object::ObjectTextures;
use super::shading::Shading;
use crate::optics::coherence::Windows;
use crate::scene::{Environment, Incident, Mesh, Scene};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use reflection::Reflection;
use surface::SurfacePlace;
use triangles::{Ray, Triangle, Triangles};

/// Object that rays meet.
#[derive(Clone, Copy)]
pub struct RayObject<'a> {
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// How the patch lies on the mesh.
    pub grooves: &'a GrooveDirections,
    /// Whether it casts shadows, where lights do.
    pub casts_shadows: bool,
}

/// Returns the objects of `scene`, the first object first, with what was read for them.
pub fn objects<'a>(scene: &'a Scene, textures: &'a [ObjectTextures]) -> Vec<RayObject<'a>> {
    let casts = std::iter::once(true).chain(scene.objects.iter().map(|object| !object.is_ground));
    let object = |((mesh, textures), casts_shadows): ((_, &'a ObjectTextures), _)| RayObject {
        mesh,
        grooves: &textures.grooves,
        casts_shadows,
    };
    scene.meshes().zip(textures).zip(casts).map(object).collect()
}

/// Data that the directions of a frame hold beside the directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RaySettings {
    /// Width and height of the picture \[pixels\].
    pub size: [u32; 2],
    /// Whether footprints are computed.
    pub footprints: bool,
    /// Whether lights cast shadows.
    pub shadows: bool,
    /// Variance of (u, v) over which the specular order spreads, where surroundings are mirrored.
    pub specular_spread: Option<f64>,
}

impl RaySettings {
    /// Data that the reference of a picture of `size` pixels needs by `shading`: the mean over windows is averaged over footprints, and its specular
    /// order mirrors the surroundings.
    pub fn new(size: [u32; 2], shadows: bool, shading: &Shading) -> Self {
        let footprints = shading.windows == Windows::All;
        Self { size, footprints, shadows, specular_spread: shading.specular_spread().filter(|_| footprints) }
    }
}

/// Objects of a scene as rays meet them.
pub struct RayScene<'a> {
    objects: Vec<RayObject<'a>>,
    triangles: Triangles,
}

impl<'a> RayScene<'a> {
    /// Prepares `objects` for rays.
    pub fn new(objects: Vec<RayObject<'a>>) -> Self {
        let meshes = objects.iter().map(|object| (object.mesh, object.casts_shadows));
        Self { triangles: Triangles::new(meshes), objects }
    }

    /// Casts the rays of `pass` of `view`.
    pub fn directions(&self, view: &View, pass: &LightPass, settings: &RaySettings) -> Directions {
        let mirrors = settings.specular_spread.is_some() && view.is_surroundings(pass.light);
        let frame = RayFrame {
            scene: self,
            view,
            pass,
            settings,
            incident: view.incident(pass),
            eye: view.camera.eye().as_dvec3(),
            mirrored: view.environment.as_ref().filter(|_| mirrors),
        };
        let count = settings.size[0] as usize * settings.size[1] as usize;
        let seen: Vec<Option<SeenPixel>> =
            (0..count).into_par_iter().map(|pixel| frame.pixel(pixel)).collect();
        let of_all = |wanted: bool| if wanted { seen.as_slice() } else { &[] };
        let unit = |v: DVec3| v.as_vec3().extend(1.0).to_array();
        let each = |of: fn(&SeenPixel) -> DVec3| {
            seen.iter().map(|pixel| pixel.as_ref().map_or([0.0; 4], |pixel| unit(of(pixel)))).collect()
        };
        fn some<T: Default>(all: &[Option<SeenPixel>], of: impl Fn(&SeenPixel) -> T) -> Vec<T> {
            all.iter().map(|pixel| pixel.as_ref().map_or(T::default(), &of)).collect()
        }
        Directions {
            light_number: pass.light,
            light: each(|pixel| pixel.light),
            view: each(|pixel| pixel.view),
            footprints: some(of_all(settings.footprints), |pixel| pixel.footprint),
            filter: pass.sample.footprint,
            irradiance: frame.incident.irradiance.as_dvec3(),
            falloffs: some(of_all(view.has_lamps()), |pixel| pixel.falloff),
            mirrored: some(of_all(mirrors), |pixel| pixel.mirrored),
            objects: some(of_all(self.objects.len() > 1), |pixel| pixel.object),
        }
    }
}

/// Data of a pixel that an object covers.
struct SeenPixel {
    light: DVec3,
    view: DVec3,
    footprint: [f32; 4],
    falloff: f32,
    mirrored: [f32; 3],
    object: u8,
}

/// Rays of one pass.
struct RayFrame<'a> {
    scene: &'a RayScene<'a>,
    view: &'a View,
    pass: &'a LightPass,
    settings: &'a RaySettings,
    incident: Incident,
    eye: DVec3,
    /// Surroundings whose mirrored radiance is asked for.
    mirrored: Option<&'a Environment>,
}

/// Triangle that a pixel shows, and which side of it.
#[derive(Clone, Copy)]
struct Face<'a> {
    object: &'a RayObject<'a>,
    triangle: &'a Triangle,
    /// Unit normal of the triangle, toward the viewer.
    normal: DVec3,
    /// Whether the back of the surface is seen.
    back: bool,
}

/// Directions at a place of a pixel.
#[derive(Clone, Copy)]
struct PlaceDirections {
    /// ω_r.
    view: DVec3,
    /// ω_i.
    light: DVec3,
    /// Mirrored direction of the viewer, in the world.
    mirrored: DVec3,
}

impl PlaceDirections {
    fn uv(&self) -> DVec2 {
        -(self.light + self.view).truncate()
    }
}

impl RayFrame<'_> {
    /// Returns the ray through the place of pixel number `pixel` at which the sample looks, and `beside` it \[pixels\].
    fn ray(&self, pixel: usize, beside: DVec2) -> Ray {
        let size = self.settings.size;
        let corner = DVec2::new((pixel % size[0] as usize) as f64, (pixel / size[0] as usize) as f64);
        let place = corner + 0.5 + DVec2::from(self.pass.sample.jitter) + beside;
        Ray { origin: self.eye, direction: self.view.camera.ray(place, size) }
    }

    /// Returns a vector from `position` to the light; of a lamp as long as it is away.
    fn to_light(&self, position: DVec3) -> DVec3 {
        self.incident.place.map_or(self.incident.direction, |lamp| lamp.point - position)
    }

    fn pixel(&self, pixel: usize) -> Option<SeenPixel> {
        let RayScene { objects, triangles } = self.scene;
        let (triangle, crossing) = triangles.nearest(&self.ray(pixel, DVec2::ZERO))?;
        let object = &objects[triangle.object];
        let place = SurfacePlace::new(object, triangle, crossing.weights);
        let normal = triangle.normal().normalize();
        let normal = if normal.dot(self.eye - place.position) < 0.0 { -normal } else { normal };
        let face = Face { object, triangle, normal, back: place.frame.z_axis.dot(normal) < 0.0 };
        let seen = self.directions_at(&place, face.back);
        let change = self.change(pixel, &face);
        Some(SeenPixel {
            light: if self.in_shadow(&place, triangle) { DVec3::NEG_Z } else { seen.light },
            view: self.to_viewer(seen.view, change.as_ref()),
            footprint: self.footprint(&place, &seen, change.as_ref()).map(|x| x as f32),
            falloff: self.incident.place.map_or(1.0, |lamp| lamp.falloff(place.position)) as f32,
            mirrored: self.mirrored_radiance(&face, &place, &seen, change.as_ref()).as_vec3().to_array(),
            object: triangle.object.min(u8::MAX.into()) as u8,
        })
    }

    fn directions_at(&self, place: &SurfacePlace, back: bool) -> PlaceDirections {
        let to_eye = self.eye - place.position;
        PlaceDirections {
            view: place.direction(to_eye, back),
            light: place.direction(self.to_light(place.position), back),
            mirrored: (-to_eye.normalize()).reflect(place.frame.z_axis),
        }
    }

    /// Returns the directions half a pixel to the left and right, then above and below, on the plane of the triangle; `None` where one of these rays does
    /// not meet it.
    fn change(&self, pixel: usize, face: &Face<'_>) -> Option<[[PlaceDirections; 2]; 2]> {
        let at = |beside: DVec2| {
            let crossing = face.triangle.crossing(&self.ray(pixel, beside)).filter(|c| c.distance > 0.0)?;
            let place = SurfacePlace::new(face.object, face.triangle, crossing.weights);
            Some(self.directions_at(&place, face.back))
        };
        let pair = |half: DVec2| Some([at(-half)?, at(half)?]);
        Some([pair(DVec2::X * 0.5)?, pair(DVec2::Y * 0.5)?])
    }

    /// Bounds the cosine from below by how much it changes over the part of the pixel that shading averages over, as `to_viewer` of `geometry.frag` does: a
    /// rule of single samples, whose BRDF would have no bound at a silhouette. The more samples, the nearer the bound is to 0.
    fn to_viewer(&self, view: DVec3, change: Option<&[[PlaceDirections; 2]; 2]>) -> DVec3 {
        let slopes = change.map(|pairs| pairs.map(|[before, after]| after.view.z - before.view.z));
        let spread = self.pass.sample.footprint * slopes.map_or(0.0, |slopes| DVec2::from(slopes).length());
        if view.z > 0.0 && spread > view.z { DVec3 { z: spread.min(1.0), ..view } } else { view }
    }

    /// Returns du/dx, dv/dx, du/dy, dv/dy per pixel, or where the light has an extent the columns of a matrix of the same covariance together with it.
    fn footprint(
        &self,
        place: &SurfacePlace,
        seen: &PlaceDirections,
        change: Option<&[[PlaceDirections; 2]; 2]>,
    ) -> [f64; 4] {
        let columns = change.map(|pairs| pairs.map(|[before, after]| after.uv() - before.uv()));
        let [right, down] = columns.unwrap_or_default();
        let mut variance = self.incident.variance / self.pass.sample.footprint.powi(2);
        if self.incident.place.is_some() {
            variance /= self.to_light(place.position).length_squared();
        }
        if variance <= 0.0 {
            return [right.x, right.y, down.x, down.y];
        }
        // Directions that vary across the light change u and v by its projection: variance · (1 − l lᵀ).
        let l = seen.light;
        let uu = right.x.powi(2) + down.x.powi(2) + variance * (1.0 - l.x * l.x);
        let uv = right.x * right.y + down.x * down.y - variance * l.x * l.y;
        let vv = right.y.powi(2) + down.y.powi(2) + variance * (1.0 - l.y * l.y);
        let u = uu.sqrt();
        let v = uv / u;
        [u, v, 0.0, (vv - v * v).max(0.0).sqrt()]
    }

    /// Tells whether anything stands between `place`, on `triangle`, and the light.
    fn in_shadow(&self, place: &SurfacePlace, triangle: &Triangle) -> bool {
        let ray = Ray { origin: place.position, direction: self.to_light(place.position) };
        let end = if self.incident.place.is_some() { 1.0 } else { f64::MAX };
        self.settings.shadows && self.scene.triangles.blocked(&ray, end, triangle)
    }

    /// Returns the radiance of the surroundings in the mirrored direction as the pass draws them, where it is asked for; 0 where the direction leads into
    /// the surface.
    fn mirrored_radiance(
        &self,
        face: &Face<'_>,
        place: &SurfacePlace,
        seen: &PlaceDirections,
        change: Option<&[[PlaceDirections; 2]; 2]>,
    ) -> DVec3 {
        let Some((environment, spread)) = self.mirrored.zip(self.settings.specular_spread) else {
            return DVec3::ZERO;
        };
        if seen.mirrored.dot(face.normal) <= 0.0 {
            return DVec3::ZERO;
        }
        let mut frame = place.frame;
        frame.z_axis *= seen.mirrored.dot(frame.z_axis).signum();
        let tangential = |direction: DVec3| (frame.transpose() * direction).truncate();
        let sigma = self.pass.sample.footprint;
        let change = change.map(|pairs| {
            pairs.map(|[before, after]| tangential(after.mirrored - before.mirrored) * sigma)
        });
        let reflection = Reflection {
            frame,
            middle: tangential(seen.mirrored),
            change: change.unwrap_or_default(),
            spread,
        };
        reflection.radiance(environment) * self.pass.weight
    }
}
