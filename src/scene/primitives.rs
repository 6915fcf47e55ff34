//! Shapes with exact frames: a plate, a sphere and a compact disc.

use super::mesh::{Mesh, Vertex};
use std::f32::consts::{PI, TAU};

/// Radius of a compact disc's innermost track, per outer radius.
const DISC_HOLE: f32 = 0.19;

/// Returns a square of side 1 in the xy plane, centred on the origin, facing +z: T = +x, B = +y, uv from (0, 0) to (1, 1).
pub fn plate() -> Mesh {
    lattice(1, 1, |x, y| Vertex {
        position: [x - 0.5, y - 0.5, 0.0],
        normal: [0.0, 0.0, 1.0],
        tangent: [1.0, 0.0, 0.0, 1.0],
        uv: [x, y],
    })
}

/// Returns a sphere of radius 1 around the origin with its poles on the y axis: T points east, B north, uv = (longitude, latitude) in
/// radians. Each triangle at a pole has a separate vertex there, with the frame of the triangle's middle meridian.
pub fn sphere() -> Mesh {
    const SEGMENTS: usize = 128;
    lattice(SEGMENTS, SEGMENTS / 2, |x, y| {
        // The triangle that is kept at a pole has its tip at its western end in the south, at its eastern in the north;
        // half a segment leads to its middle.
        let pole = y == 0.0 || y == 1.0;
        let to_middle = if pole { (0.5 - y) / SEGMENTS as f32 } else { 0.0 };
        let longitude = TAU * (x + to_middle);
        let latitude = PI * (y - 0.5);
        let ((east, front), (up, out)) = (longitude.sin_cos(), latitude.sin_cos());
        let out = if pole { 0.0 } else { out };
        let normal = [out * front, up, -out * east];
        Vertex { position: normal, normal, tangent: [-east, 0.0, -front, 1.0], uv: [longitude, latitude] }
    })
}

/// Returns a compact disc in the xy plane, facing +z: an annulus from radius 0.19 to 1 around the origin. T points outward along the
/// radius, across the tracks, B along the tracks, counter-clockwise; uv = (radius, angle in radians).
pub fn disc() -> Mesh {
    lattice(4, 256, |x, y| {
        let radius = DISC_HOLE + (1.0 - DISC_HOLE) * x;
        let (sin, cos) = (TAU * y).sin_cos();
        Vertex {
            position: [radius * cos, radius * sin, 0.0],
            normal: [0.0, 0.0, 1.0],
            tangent: [cos, sin, 0.0, 1.0],
            uv: [radius, TAU * y],
        }
    })
}

/// Returns a round plate of radius 1 in the xy plane, centred on the origin, facing +z: T = +x, B = +y.
pub fn ground() -> Mesh {
    const SEGMENTS: usize = 96;
    let at = |x: f32, y: f32| Vertex {
        position: [x, y, 0.0],
        normal: [0.0, 0.0, 1.0],
        tangent: [1.0, 0.0, 0.0, 1.0],
        uv: [0.5 + 0.5 * x, 0.5 + 0.5 * y],
    };
    let rim = (0..SEGMENTS).map(|i| {
        let (sin, cos) = (TAU * i as f32 / SEGMENTS as f32).sin_cos();
        at(cos, sin)
    });
    let vertices = std::iter::once(at(0.0, 0.0)).chain(rim).collect();
    let indices = (0..SEGMENTS).flat_map(|i| [0, 1 + i, 1 + (i + 1) % SEGMENTS]).map(|k| k as u32).collect();
    Mesh::from_parts(vertices, indices)
}

/// Returns a mesh of `columns` × `rows` cells of `vertex(x, y)`, both from 0 to 1 with u along x and v along y, outside to the left of u →
/// v. Triangles with two corners in one place are left out.
fn lattice(columns: usize, rows: usize, vertex: impl Fn(f32, f32) -> Vertex) -> Mesh {
    let at = |k: usize, n: usize| k as f32 / n as f32;
    let vertices: Vec<_> = (0..=rows)
        .flat_map(|j| (0..=columns).map(move |i| (i, j)))
        .map(|(i, j)| vertex(at(i, columns), at(j, rows)))
        .collect();
    let mut indices = Vec::with_capacity(6 * columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let a = j * (columns + 1) + i;
            let [b, c, d] = [a + 1, a + columns + 2, a + columns + 1];
            for triangle in [[a, b, c], [a, c, d]] {
                let [p, q, r] = triangle.map(|k| vertices[k].position);
                if p != q && q != r && r != p {
                    indices.extend(triangle.map(|k| k as u32));
                }
            }
        }
    }
    Mesh::from_parts(vertices, indices)
}

#[cfg(test)]
mod tests {
    use super::super::mesh::tests::assert_sound;
    use super::*;
    use glam::{Vec2, Vec3};

    /// Fails unless every triangle faces its normals and its texture coordinates grow along T and B.
    fn assert_framed(mesh: &Mesh) {
        assert_sound(mesh);
        for triangle in mesh.indices().chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.vertices()[triangle[k] as usize]);
            let [p, q, r] = [a, b, c].map(|v| Vec3::from(v.position));
            let [n, t] = [Vec3::from(a.normal), Vec3::from_slice(&a.tangent)];
            let face = (q - p).cross(r - p);
            assert!(face.length() > 0.0 && face.normalize().dot(n) > 0.99);
            // dP/du from the edges of the triangle.
            let [s, e] = [b, c].map(|v| Vec2::from(v.uv) - Vec2::from(a.uv));
            let along_u = ((q - p) * e.y - (r - p) * s.y) / s.perp_dot(e);
            assert!(along_u.normalize().dot(t) > 0.99, "{a:?}");
        }
    }

    #[test]
    fn the_plate_is_the_unit_square_with_the_axes_as_its_frame() {
        let mesh = plate();
        assert_framed(&mesh);
        assert_eq!(mesh.triangle_count(), 2);
        assert!(
            mesh.vertices().iter().all(|v| v.tangent == [1.0, 0.0, 0.0, 1.0] && v.normal == [0.0, 0.0, 1.0])
        );
    }

    #[test]
    fn the_sphere_has_its_frame_right_up_to_the_poles() {
        let mesh = sphere();
        assert_framed(&mesh);
        assert_eq!(mesh.triangle_count(), 2 * 128 * 63);
        assert!((mesh.bounds().radius - 1.0).abs() < 1e-6 && mesh.bounds().centre.length() < 1e-6);
        assert!(mesh.vertices().iter().all(|v| v.position == v.normal && v.tangent[1] == 0.0));
    }

    #[test]
    fn the_tangent_of_the_disc_is_the_radius() {
        let mesh = disc();
        assert_framed(&mesh);
        for v in mesh.vertices() {
            let p = Vec3::from(v.position);
            assert!(p.normalize().distance(Vec3::from_slice(&v.tangent)) < 1e-6);
            assert!((0.189..1.001).contains(&p.length()));
        }
    }
}
