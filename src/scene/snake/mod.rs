//! The default scene's model: a coiled snake with overlapping scales, made by code and shipped as
//! `assets/meshes/snake.obj`.
//!
//! y is up, the ground is the plane y = 0, the coil lies around the y axis and everything is within a radius of 1 of
//! the origin. On the skin u runs across the body and v along it toward the tail, so the x axis of a height field
//! lies ACROSS the body and its y axis along it, as the ridges of a snake's scales do.

mod body;
mod grid;
mod skin;

use super::mesh::Mesh;
use super::obj;
use crate::error::Result;
use body::Body;
use grid::{ObjText, SkinGrid};

/// The snake as it ships, as OBJ text.
pub const OBJ: &[u8] = include_bytes!("../../../assets/meshes/snake.obj");

/// The snake as it ships.
///
/// # Errors
/// As [`obj::from_bytes`]; none unless the shipped file is damaged.
pub fn mesh() -> Result<Mesh> {
    obj::from_bytes(OBJ)
}

/// Arc length from the tail's tip to the snout, in units of the model.
pub fn length() -> f64 {
    Body::coiled().length()
}

/// Makes the snake anew, as OBJ text: the same text every time.
pub fn obj_text() -> String {
    let body = Body::coiled();
    // What covers comes before what it covers.
    let parts: [(&str, Vec<SkinGrid>); 4] = [
        ("head", vec![skin::head(&body)]),
        ("eyes", skin::eyes(&body)),
        ("scales", skin::scales(&body)),
        ("skin", vec![skin::tube(&body)]),
    ];
    let mut text =
        ObjText::new("A coiled snake, made by diffract (src/scene/snake). y is up, the ground is y = 0.");
    for (name, grids) in &parts {
        text.object(name);
        for grid in grids {
            text.push(grid);
        }
    }
    text.finish()
}

#[cfg(test)]
mod tests {
    use super::super::mesh::{Vertex, tests::assert_sound};
    use super::*;
    use glam::Vec3;
    use std::path::Path;

    #[test]
    fn the_shipped_snake_is_what_the_code_makes() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/meshes/snake.obj");
        let made = obj_text();
        if std::env::var_os("DIFFRACT_BLESS").is_some_and(|v| v == "1") {
            std::fs::write(&path, &made).unwrap();
        }
        let shipped = std::fs::read_to_string(&path).unwrap();
        assert!(shipped == made, "assets/meshes/snake.obj differs; DIFFRACT_BLESS=1 writes it anew");
        assert!(made.len() <= 3_500_000, "{} bytes", made.len());
    }

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

    #[test]
    fn on_the_scales_the_tangent_lies_across_the_body_and_the_frame_is_not_mirrored() {
        let body = Body::coiled();
        let scales = skin::scales(&body);
        assert!((1500..3500).contains(&scales.len()), "{}", scales.len());
        let mesh = mesh().unwrap();
        assert!(mesh.vertices().iter().all(|v| v.tangent[3] == 1.0));
        // Along the middle of the back the body's own axes are known: T is its left.
        let s = 0.5 * body.length();
        let top = body.skin(s, 0.0, 0.0).as_vec3();
        let [up, left] = [body.frame(s).up, body.frame(s).left].map(|d| d.as_vec3());
        // The flank of another loop may be near; it does not look up.
        let on_back =
            |v: &&Vertex| Vec3::from(v.position).distance(top) < 0.06 && Vec3::from(v.normal).dot(up) > 0.8;
        let near = mesh.vertices().iter().filter(on_back);
        let ways: Vec<f32> = near.map(|v| Vec3::from_slice(&v.tangent).dot(left)).collect();
        assert!(ways.len() > 10 && ways.iter().all(|&w| w > 0.85), "{ways:?}");
    }
}
