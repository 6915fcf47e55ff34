//! Makes the default scene's model, a coiled snake with overlapping scales, and prints it as OBJ text:
//! `cargo run --example snake > snake.obj && mv snake.obj assets/meshes/` writes the shipped file anew.
//!
//! y is up, the ground is the plane y = 0, the coil lies around the y axis and everything is within a radius of 1 of
//! the origin. On the skin u runs across the body and v along it toward the tail, so the x axis of a height field
//! lies across the body and its y axis along it, as the ridges of a snake's scales do.

mod body;
mod grid;
mod skin;

use body::Body;
use grid::{ObjText, SkinGrid};
use std::io::{self, Write};

fn main() -> io::Result<()> {
    io::stdout().write_all(obj_text().as_bytes())
}

/// Returns the snake as OBJ text: the same text every time.
fn obj_text() -> String {
    let body = Body::coiled();
    // Parts that cover others come before them.
    let parts: [(&str, Vec<SkinGrid>); 4] = [
        ("head", vec![skin::head(&body)]),
        ("eyes", skin::eyes(&body)),
        ("scales", skin::scales(&body)),
        ("skin", vec![skin::tube(&body)]),
    ];
    let mut text =
        ObjText::new("A coiled snake, made by diffract (examples/snake). y is up, the ground is y = 0.");
    for (name, grids) in &parts {
        text.object(name);
        for grid in grids {
            text.push(grid);
        }
    }
    text.finish()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;
    use diffract::internals::scene::{Scene, Vertex, snake};
    use glam::Vec3;

    #[test]
    fn the_shipped_snake_is_what_the_example_makes() {
        let shipped = std::str::from_utf8(snake::OBJ).unwrap();
        let made = obj_text();
        assert!(
            shipped == made,
            "write assets/meshes/snake.obj anew: see the head of examples/snake/main.rs"
        );
        assert!(made.len() <= 4_500_000, "{} bytes", made.len());
    }

    #[test]
    fn the_snake_of_the_default_scene_is_about_a_metre_long() {
        let length = Body::coiled().length() * Scene::open("snake").unwrap().unit;
        assert!((0.9..1.1).contains(&length), "{length} m");
    }

    #[test]
    fn on_the_scales_the_tangent_lies_across_the_body_and_the_frame_is_not_mirrored() {
        let body = Body::coiled();
        let scales = skin::scales(&body);
        assert!((1500..3500).contains(&scales.len()), "{}", scales.len());
        let mesh = snake::mesh().unwrap();
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
