//! Ray of one pixel: its hit and the directions there.

use super::reflection::Reflection;
use super::surface_place::SurfacePlace;
use super::triangles::{Ray, Triangle};
use super::{RayObject, RayScene, RaySettings};
use crate::render::frame::View;
use crate::render::light_passes::LightPass;
use crate::scene::camera::pixel_centre;
use crate::scene::incident::mean_cosine;
use crate::scene::{Environment, Incident};
use glam::{DVec2, DVec3};

/// Data of a covered pixel.
pub(super) struct SeenPixel {
    /// ω_i; below the surface if the pixel is in shadow.
    pub light: DVec3,
    /// ω_r.
    pub view: DVec3,
    /// Same as [`Directions::footprints`](crate::render::directions::Directions::footprints).
    pub footprint: [f32; 4],
    /// Brightness of the light as a factor of that at distance 1 on the axis of a lamp.
    pub falloff: f32,
    /// Radiance of the surroundings in the mirrored direction, linear sRGB.
    pub mirrored: [f32; 3],
    /// Number of the object.
    pub object: u8,
}

/// Rays of one pass at pixels with the same light sample.
pub(super) struct RayFrame<'a> {
    /// Objects.
    pub scene: &'a RayScene<'a>,
    /// View of them.
    pub view: &'a View,
    /// Light, and the sample position in the pixels.
    pub pass: &'a LightPass,
    /// Requested data.
    pub settings: &'a RaySettings,
    /// Light of the pass.
    pub incident: Incident,
    /// Surroundings, if their mirrored radiance is requested.
    pub mirrored: Option<&'a Environment>,
}

/// Triangle seen by a pixel, and its side.
#[derive(Clone, Copy)]
struct Face<'a> {
    object: &'a RayObject<'a>,
    triangle: &'a Triangle,
    /// Unit normal of the triangle, toward the viewer.
    normal: DVec3,
    /// True if the back of the surface is seen.
    back: bool,
}

/// Directions at a point of a pixel.
#[derive(Clone, Copy)]
struct PlaceDirections {
    /// ω_r.
    view: DVec3,
    /// ω_i.
    light: DVec3,
    /// Mirrored direction of the viewer, in world space.
    mirrored: DVec3,
}

/// Directions half a pixel to the left and right, then above and below.
type Change = [[PlaceDirections; 2]; 2];

impl PlaceDirections {
    /// Returns (u, v).
    fn uv(&self) -> DVec2 {
        -(self.light + self.view).truncate()
    }
}

impl RayFrame<'_> {
    /// Returns the ray through the sample position in pixel number `pixel`, offset by `beside` \[pixels\].
    fn ray(&self, pixel: usize, beside: DVec2) -> Ray {
        let size = self.settings.size;
        let place = pixel_centre(pixel, size) + DVec2::from(self.pass.sample.jitter) + beside;
        let sight = self.view.camera.sight(place, size);
        Ray { origin: sight.origin, direction: sight.direction }
    }

    /// Returns a vector from `position` to the light. For a lamp its length is the distance.
    fn to_light(&self, position: DVec3) -> DVec3 {
        self.incident.place.map_or(self.incident.direction, |lamp| lamp.point - position)
    }

    /// Casts the ray of pixel number `pixel`; `None` if it hits nothing.
    pub fn pixel(&self, pixel: usize) -> Option<SeenPixel> {
        let RayScene { objects, triangles } = self.scene;
        let (triangle, crossing) = triangles.nearest(&self.ray(pixel, DVec2::ZERO))?;
        let object = &objects[triangle.object];
        let place = SurfacePlace::new(object, triangle, crossing.weights);
        let normal = triangle.normal().normalize();
        let normal =
            if normal.dot(self.view.camera.toward_viewer(place.position)) < 0.0 { -normal } else { normal };
        let face = Face { object, triangle, normal, back: place.frame.z_axis.dot(normal) < 0.0 };
        let seen = self.directions_at(&place, face.back);
        let change = self.change(pixel, &face);
        Some(SeenPixel {
            light: if self.in_shadow(&place, &face) { DVec3::NEG_Z } else { seen.light },
            view: self.to_viewer(seen.view, change.as_ref()),
            footprint: self.footprint(&place, &seen, change.as_ref()).map(|x| x as f32),
            falloff: self.incident.place.map_or(1.0, |lamp| lamp.falloff(place.position)) as f32,
            mirrored: self.mirrored_radiance(&face, &place, &seen, change.as_ref()).as_vec3().to_array(),
            object: triangle.object.min(u8::MAX.into()) as u8,
        })
    }

    /// Returns the directions at `place`, seen from the `back` or from the front.
    fn directions_at(&self, place: &SurfacePlace, back: bool) -> PlaceDirections {
        let to_viewer = self.view.camera.toward_viewer(place.position);
        PlaceDirections {
            view: place.direction(to_viewer, back),
            light: place.direction(self.to_light(place.position), back),
            mirrored: (-to_viewer.normalize()).reflect(place.frame.z_axis),
        }
    }

    /// Returns the directions half a pixel to the left and right, then above and below, on the plane of the triangle;
    /// `None` if one of these rays misses the plane.
    fn change(&self, pixel: usize, face: &Face<'_>) -> Option<Change> {
        let at = |beside: DVec2| {
            let crossing = face.triangle.crossing(&self.ray(pixel, beside)).filter(|c| c.distance > 0.0)?;
            let place = SurfacePlace::new(face.object, face.triangle, crossing.weights);
            Some(self.directions_at(&place, face.back))
        };
        let pair = |half: DVec2| Some([at(-half)?, at(half)?]);
        Some([pair(DVec2::X * 0.5)?, pair(DVec2::Y * 0.5)?])
    }

    /// Bounds the cosine from below by its change over the filter that shading averages over, as `to_viewer` of
    /// `geometry.frag` does. Without this bound the BRDF of a single sample diverges at a silhouette. With more samples
    /// the bound approaches 0.
    fn to_viewer(&self, view: DVec3, change: Option<&Change>) -> DVec3 {
        let slopes = change.map(|pairs| pairs.map(|[before, after]| after.view.z - before.view.z));
        let spread = self.pass.sample.footprint * slopes.map_or(0.0, |slopes| DVec2::from(slopes).length());
        if view.z > 0.0 && spread > view.z { DVec3 { z: spread.min(1.0), ..view } } else { view }
    }

    /// Returns du/dx, dv/dx, du/dy, dv/dy per pixel. If the light has an extent, returns a matrix square root of the
    /// sum of both covariances.
    fn footprint(&self, place: &SurfacePlace, seen: &PlaceDirections, change: Option<&Change>) -> [f64; 4] {
        let columns = change.map(|pairs| pairs.map(|[before, after]| after.uv() - before.uv()));
        let [right, down] = columns.unwrap_or_default();
        let mut variance = self.incident.variance / self.pass.sample.footprint.powi(2);
        if self.incident.place.is_some() {
            variance /= self.to_light(place.position).length_squared();
        }
        if variance <= 0.0 {
            return [right.x, right.y, down.x, down.y];
        }
        // Directions that vary across the light change (u, v) by its projection: variance · (1 − l lᵀ).
        let l = seen.light;
        let uu = right.x.powi(2) + down.x.powi(2) + variance * (1.0 - l.x * l.x);
        let uv = right.x * right.y + down.x * down.y - variance * l.x * l.y;
        let vv = right.y.powi(2) + down.y.powi(2) + variance * (1.0 - l.y * l.y);
        if self.pass.choices.is_some() {
            // A direction stands for a part of the surroundings whose outline is not known: its footprint is round.
            let radius = (0.5 * (uu + vv)).sqrt();
            return [radius, 0.0, 0.0, radius];
        }
        let u = uu.sqrt();
        let v = uv / u;
        [u, v, 0.0, (vv - v * v).max(0.0).sqrt()]
    }

    /// Tells if an object blocks the light between `place`, on `triangle`, and the light.
    fn in_shadow(&self, place: &SurfacePlace, face: &Face<'_>) -> bool {
        let ray = Ray { origin: place.position, direction: self.to_light(place.position) };
        let is_lamp = self.incident.place.is_some();
        let end = if is_lamp { 1.0 } else { f64::MAX };
        let facing = face.normal.dot(ray.direction);
        // A light whose middle is behind the surface shines on it with the part beside.
        let is_beside = !is_lamp && facing <= 0.0 && mean_cosine(facing, self.incident.mean) > 0.0;
        self.settings.shadows && !is_beside && self.scene.triangles.blocked(&ray, end, face.triangle)
    }

    /// Returns the radiance of the surroundings in the mirrored direction as the geometry pass computes it, if
    /// requested; 0 if the direction points into the surface.
    fn mirrored_radiance(
        &self,
        face: &Face<'_>,
        place: &SurfacePlace,
        seen: &PlaceDirections,
        change: Option<&Change>,
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
        let change = change
            .map(|pairs| pairs.map(|[before, after]| tangential(after.mirrored - before.mirrored) * sigma));
        let reflection = Reflection {
            frame,
            middle: tangential(seen.mirrored),
            change: change.unwrap_or_default(),
            spread,
        };
        reflection.radiance(environment) * self.pass.weight
    }
}
