//! Depth maps of lights: their side, and the matrices from the world to their clip space.

use crate::scene::Incident;
use glam::{DVec3, Mat4, Vec3, Vec4};

/// Margin around the sphere, so that nothing is cut off at the edge of the map.
const ROOM: f32 = 1.02;
/// Texels across a pixel at the centre of the scene, if the limits of the side allow. A pixel at a shadow's edge is on its
/// wrong side with the probability of being within a texel of it. Two samples of a scene of two objects, 48 × 36 pixels,
/// erred by 0.030 with six texels and err by 0.009 with eight (relative L2 from rays in f64).
const TEXELS_PER_PIXEL: f32 = 8.0;
/// Smallest side of a map \[texels\].
const SMALLEST: f32 = 256.0;
/// Largest side of a map \[texels\]. Two cores of lavapipe draw mesh and shadows at 640 × 480 pixels in 128 ms with a map of
/// this side and in 60 ms with one of 16 texels.
const LARGEST: f32 = 2048.0;
/// Sides per doubling, so that a camera that comes closer rarely needs new maps.
const PER_OCTAVE: f32 = 4.0;

/// Bounding sphere of the scene, which depth maps cover, in pictures of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowSphere {
    /// Centre in the world.
    pub centre: Vec3,
    /// Radius.
    pub radius: f32,
    /// Width of a pixel at the centre.
    pub pixel: f32,
    /// Width of a pixel at the nearest point of the sphere; 0 if the viewer is inside.
    pub nearest_pixel: f32,
}

impl ShadowSphere {
    /// Returns the side of the depth maps \[texels\].
    pub fn side(&self) -> u32 {
        let texels = TEXELS_PER_PIXEL * self.diameter() / self.pixel.max(f32::MIN_POSITIVE);
        let rounded = ((texels.log2() * PER_OCTAVE).ceil() / PER_OCTAVE).exp2();
        rounded.clamp(SMALLEST, LARGEST).round() as u32
    }

    /// Returns the side of the depth maps of many directions, each of which gives a small part of the light \[texels\].
    pub fn side_of_many(&self) -> u32 {
        /// 32 maps of this side take 32 MiB.
        const LARGEST_OF_MANY: u32 = 512;
        self.side().min(LARGEST_OF_MANY)
    }

    /// Returns the width of a map of parallel light.
    fn diameter(&self) -> f32 {
        2.0 * ROOM * self.radius.max(f32::MIN_POSITIVE)
    }

    /// Returns true if a pixel hides the penumbrae of a light between these ends, its samples that are farthest apart: the
    /// penumbra of the nearest point on the farthest, and a texel of the map, are together smaller than a pixel anywhere
    /// on the sphere.
    pub fn hides_penumbrae_between(&self, one: &Incident, other: &Incident) -> bool {
        let angle = match (one.place, other.place) {
            (Some(one), Some(other)) => {
                let nearest = [one, other].map(|end| end.point.distance(self.centre.as_dvec3()));
                let distance = nearest[0].min(nearest[1]) - f64::from(self.radius);
                if distance > 0.0 { one.point.distance(other.point) / distance } else { f64::INFINITY }
            }
            _ => one.direction.distance(other.direction),
        };
        let texel = self.diameter() / self.side() as f32;
        angle * f64::from(self.diameter()) + f64::from(texel) < f64::from(self.nearest_pixel)
    }

    /// Returns the offset in clip space of a map that is shifted by `jitter` \[texels\] against the mesh, so that its
    /// texels blur over many samples.
    fn offset(&self, jitter: [f64; 2]) -> [f32; 2] {
        jitter.map(|texels| (2.0 * texels / f64::from(self.side())) as f32)
    }

    /// Returns the matrix from the world to the clip space of the depth map of a light in this `direction`, shifted by
    /// `jitter` \[texels\].
    pub fn clip_from_world(&self, direction: DVec3, jitter: [f64; 2]) -> Mat4 {
        let Self { centre, radius, .. } = *self;
        let toward = direction.as_vec3();
        let (x, y) = toward.any_orthonormal_pair();
        let scale = 1.0 / (ROOM * radius.max(f32::MIN_POSITIVE));
        let moved = self.offset(jitter);
        // Depth grows from 0, nearest to the light, to 1.
        let rows = [
            (x * scale).extend(moved[0] - scale * x.dot(centre)),
            (y * scale).extend(moved[1] - scale * y.dot(centre)),
            (toward * (-0.5 * scale)).extend(0.5 + 0.5 * scale * toward.dot(centre)),
            Vec4::W,
        ];
        Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
    }

    /// Returns the matrix from the world to the clip space of the depth map of a lamp at `place`, aimed at the centre.
    /// The map covers the sphere; if the lamp is inside or close to it, the map covers the directions within 75° of the
    /// centre. `jitter` is as for [`Self::clip_from_world`].
    pub fn clip_from_lamp(&self, place: Vec3, jitter: [f64; 2]) -> Mat4 {
        /// Near plane of a lamp inside the sphere, as a fraction of the radius; nearer surfaces cast no shadow.
        const NEAREST: f32 = 0.01;
        let centre = self.centre;
        let radius = ROOM * self.radius.max(f32::MIN_POSITIVE);
        let distance = place.distance(centre);
        let forward = (centre - place).try_normalize().unwrap_or(Vec3::NEG_Z);
        let (x, y) = forward.any_orthonormal_pair();
        let half = if distance > radius { (radius / distance).asin().min(WIDEST) } else { WIDEST };
        let focal = 1.0 / half.tan();
        let [near, far] = [(distance - radius).max(NEAREST * radius), distance + radius];
        let depth = far / (far - near);
        let row = |axis: Vec3, scale: f32, offset: f32| {
            (axis * scale + forward * offset).extend(-(axis * scale + forward * offset).dot(place))
        };
        let moved = self.offset(jitter);
        let mut third = row(forward, depth, 0.0);
        third.w -= near * depth;
        let rows = [row(x, focal, moved[0]), row(y, focal, moved[1]), third, row(forward, 1.0, 0.0)];
        Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
    }
}

/// Largest half-angle of the depth map of a lamp \[radians\].
const WIDEST: f32 = 75.0 * std::f32::consts::PI / 180.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Light;
    use crate::scene::Room;

    const SPHERE: ShadowSphere =
        ShadowSphere { centre: Vec3::new(3.0, -2.0, 1.0), radius: 2.5, pixel: 0.01, nearest_pixel: 0.01 };

    #[test]
    fn a_map_holds_the_sphere_and_what_is_nearer_to_the_light_has_less_depth() {
        let (direction, ShadowSphere { centre, radius, .. }) = (DVec3::new(0.6, 0.0, 0.8), SPHERE);
        let toward = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::new(-0.6, 0.0, -0.8)];
        let depth = |clip: Mat4, p: Vec3| clip.project_point3(p).z;
        let far = SPHERE.clip_from_world(direction, [0.0; 2]);
        let lamp = centre + direction.as_vec3() * 6.0;
        let near = SPHERE.clip_from_lamp(lamp, [0.0; 2]);
        for clip in [far, near] {
            for toward in toward {
                let place = clip.project_point3(centre + toward * radius);
                let held = place.x.abs() <= 1.0 && place.y.abs() <= 1.0 && (0.0..=1.0).contains(&place.z);
                assert!(held, "{place}");
            }
            assert!(depth(clip, centre + direction.as_vec3()) < depth(clip, centre));
        }
        assert!((depth(far, centre) - 0.5).abs() < 1e-6);
        // B of the depth A + B/distance, as the shader computes it.
        let reach = (near * lamp.extend(1.0)).z;
        let at = |distance: f32| depth(near, lamp - direction.as_vec3() * distance);
        assert!((at(4.0) - at(8.0) - reach * (1.0 / 4.0 - 1.0 / 8.0)).abs() < 1e-5);
        let side = SPHERE.side() as f32;
        let moved = SPHERE.clip_from_lamp(lamp, [1.0, 0.0]).project_point3(centre);
        assert!((moved.x * side / 2.0 - 1.0).abs() < 1e-3);
        let moved = SPHERE.clip_from_world(direction, [1.0, 0.0]).project_point3(centre);
        assert!((moved.x * side / 2.0 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn the_side_follows_from_the_pixel_within_its_limits_and_seldom_changes() {
        let side = |pixel: f32| ShadowSphere { pixel, ..SPHERE }.side();
        assert_eq!((side(1e-9), side(1e3)), (2048, 256));
        for pixel in [0.022f32, 0.03, 0.05, 0.1] {
            let texels = side(pixel) as f32 * pixel / SPHERE.diameter();
            assert!((8.0..8.0 * 1.2).contains(&texels), "{texels} texels across a pixel");
        }
        let mut sides: Vec<u32> = (0..1000).map(|i| side(0.01 * 1.002f32.powi(i))).collect();
        sides.dedup();
        assert!(sides.len() < 15, "{sides:?}");
    }

    #[test]
    fn pixels_hide_points_and_small_lights_but_no_sun_and_no_strip_that_they_resolve() {
        let room = Room { centre: SPHERE.centre.as_dvec3(), unit: 1.0 };
        let hides = |light: &str, pixel: f32| {
            let emitter = Light::parse(light).unwrap().emitter;
            let end = |corner: f64| emitter.incident([corner; 2], u32::MAX, &room);
            ShadowSphere { pixel, nearest_pixel: pixel, ..SPHERE }
                .hides_penumbrae_between(&end(0.0), &end(1.0))
        };
        // The sun's penumbra across the whole sphere is 0.0093 · 5.1 = 0.047 wide, and a texel an eighth of a pixel.
        assert!(hides("30,90", 0.01) && hides("sun:30,90", 0.06));
        assert!(!hides("sun:30,90", 0.05) && !hides("disc:20deg:30,90", 0.1));
        // From a distance of 10 less the radius, a lamp of 0.05 makes a penumbra of 0.034.
        assert!(hides("sphere:0.05:3,-2,11", 0.06) && !hides("sphere:0.05:3,-2,11", 0.03));
        assert!(!hides("rectangle:2x0.001:3,-2,11", 0.06) && !hides("rectangle:0.001x2:3,-2,11", 0.06));
        assert!(!hides("sphere:0.001:3,-2,2", 0.06), "a lamp inside the sphere");
        // A point casts edges as sharp as a texel, which pixels close to the viewer resolve.
        let point = Light::parse("30,90").unwrap().emitter.incident([0.5; 2], u32::MAX, &room);
        let hides_from = |nearest_pixel: f32| {
            ShadowSphere { nearest_pixel, ..SPHERE }.hides_penumbrae_between(&point, &point)
        };
        assert!(hides_from(0.008) && !hides_from(0.001) && !hides_from(0.0));
    }
}
