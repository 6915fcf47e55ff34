//! The mesh of the default scene: a coiled snake with overlapping scales, made by `examples/snake`.
//!
//! y is up, the ground is the plane y = 0, the coil lies around the y axis and everything is within a radius of 1 of the origin. On the
//! skin u runs across the body and v along it toward the tail, so the x axis of a height field lies across the body and its y axis along
//! it, like the ridges of a snake's scales.

use super::mesh::Mesh;
use super::obj;
use crate::error::Result;

/// OBJ text of the shipped snake.
pub const OBJ: &[u8] = include_bytes!("../../assets/meshes/snake.obj");

/// Returns the mesh of the shipped snake.
///
/// # Errors
/// Those of [`obj::from_bytes`]; none unless the shipped file is damaged.
pub fn mesh() -> Result<Mesh> {
    obj::from_bytes(OBJ)
}

#[cfg(test)]
mod tests {
    use super::super::mesh::tests::assert_sound;
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_snake_is_a_sound_mesh_on_the_ground_within_its_radius() {
        let mesh = mesh().unwrap();
        assert_sound(&mesh);
        assert!((20_000..150_000).contains(&mesh.triangle_count()), "{}", mesh.triangle_count());
        for v in mesh.vertices() {
            let p = Vec3::from(v.position);
            assert!(p.length() < 1.0 && p.y > -0.005, "{p}");
        }
    }

    #[test]
    fn faces_look_the_way_of_their_normals() {
        let mesh = mesh().unwrap();
        let facing = mesh.indices().chunks(3).filter(|t| {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.vertices()[t[k] as usize]);
            let [p, q, r] = [a, b, c].map(|v| Vec3::from(v.position));
            let shading: Vec3 = [a, b, c].map(|v| Vec3::from(v.normal)).into_iter().sum();
            (q - p).cross(r - p).dot(shading) > 0.0
        });
        let share = facing.count() as f64 / mesh.triangle_count() as f64;
        assert!(share > 0.995, "{share}");
    }
}
