//! Depth maps of lights: their side, and the matrices from the world to their clip space.

use glam::{DVec3, Mat4, Vec3, Vec4};

/// Returns the side of the depth maps for a picture of `size` pixels \[texels\]: about four texels per pixel if the
/// mesh fills the picture. With half the side, twice as many pixels at a shadow's edge are on the wrong side of it.
pub fn side(size: [u32; 2]) -> u32 {
    (4 * size[0].max(size[1])).clamp(256, 2048)
}

/// Returns the matrix from the world to the clip space of the depth map of a light in this `direction`, for a picture
/// of `size` pixels. The map covers a sphere of `radius` around `centre`. `jitter` \[texels\] shifts the map against
/// the mesh, so that its texels blur over many samples.
pub fn clip_from_world(
    direction: DVec3,
    centre: Vec3,
    radius: f32,
    size: [u32; 2],
    jitter: [f64; 2],
) -> Mat4 {
    /// Margin around the sphere, so that nothing is cut off at the edge of the map.
    const ROOM: f32 = 1.02;
    let toward = direction.as_vec3();
    let (x, y) = toward.any_orthonormal_pair();
    let scale = 1.0 / (ROOM * radius.max(f32::MIN_POSITIVE));
    let moved = |axis: usize| (2.0 * jitter[axis] / f64::from(side(size))) as f32;
    // Depth grows from 0, nearest to the light, to 1.
    let rows = [
        (x * scale).extend(moved(0) - scale * x.dot(centre)),
        (y * scale).extend(moved(1) - scale * y.dot(centre)),
        (toward * (-0.5 * scale)).extend(0.5 + 0.5 * scale * toward.dot(centre)),
        Vec4::W,
    ];
    Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
}

/// Returns the matrix from the world to the clip space of the depth map of a lamp at `place`, aimed at the centre of a
/// sphere of `radius` around `centre`. The map covers the sphere; if the lamp is inside or close to it, the map covers
/// the directions within 75° of the centre. `size` and `jitter` are as for [`clip_from_world`].
pub fn clip_from_lamp(place: Vec3, centre: Vec3, radius: f32, size: [u32; 2], jitter: [f64; 2]) -> Mat4 {
    /// Margin around the sphere, so that nothing is cut off at the edge of the map.
    const ROOM: f32 = 1.02;
    /// Near plane of a lamp inside the sphere, as a fraction of the radius; nearer surfaces cast no shadow.
    const NEAREST: f32 = 0.01;
    let radius = ROOM * radius.max(f32::MIN_POSITIVE);
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
    let moved = |axis: usize| (2.0 * jitter[axis] / f64::from(side(size))) as f32;
    let mut third = row(forward, depth, 0.0);
    third.w -= near * depth;
    let rows = [row(x, focal, moved(0)), row(y, focal, moved(1)), third, row(forward, 1.0, 0.0)];
    Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
}

/// Largest half-angle of the depth map of a lamp \[radians\].
const WIDEST: f32 = 75.0 * std::f32::consts::PI / 180.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_holds_the_sphere_and_what_is_nearer_to_the_light_has_less_depth() {
        let (direction, centre, radius) = (DVec3::new(0.6, 0.0, 0.8), Vec3::new(3.0, -2.0, 1.0), 2.5);
        let size = [640, 480];
        let toward = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::new(-0.6, 0.0, -0.8)];
        let depth = |clip: Mat4, p: Vec3| clip.project_point3(p).z;
        let far = clip_from_world(direction, centre, radius, size, [0.0; 2]);
        let lamp = centre + direction.as_vec3() * 6.0;
        let near = clip_from_lamp(lamp, centre, radius, size, [0.0; 2]);
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
        let moved = clip_from_lamp(lamp, centre, radius, size, [1.0, 0.0]).project_point3(centre);
        assert!((moved.x * side(size) as f32 / 2.0 - 1.0).abs() < 1e-3);
        let moved = clip_from_world(direction, centre, radius, size, [1.0, 0.0]).project_point3(centre);
        assert!((moved.x * side(size) as f32 / 2.0 - 1.0).abs() < 1e-3);
    }
}
