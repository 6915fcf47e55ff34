//! Smooth normals and projected texture coordinates for meshes without them.

use super::corner::{CompleteCorner, Corner};
use glam::{DVec3, Vec2, Vec3};
use std::collections::HashMap;

/// Completes the corners. Every triangle must have an area.
pub(super) fn complete(triangles: &[[Corner; 3]]) -> Vec<[CompleteCorner; 3]> {
    let given = |c: &Corner| c.normal.and_then(|n| Vec3::from(n).as_dvec3().try_normalize());
    let incomplete = triangles.iter().flatten().any(|c| given(c).is_none());
    let smooth = if incomplete { smooth_normals(triangles) } else { HashMap::new() };
    triangles
        .iter()
        .map(|triangle| {
            let face = face_normal(triangle);
            triangle.map(|c| {
                let shared = || smooth.get(&key(c.position)).and_then(|n| n.try_normalize());
                let normal = given(&c).or_else(shared).unwrap_or(face);
                CompleteCorner {
                    position: c.position.into(),
                    normal: normal.as_vec3().normalize(),
                    uv: c.uv.map_or_else(|| project(c.position, face), Vec2::from),
                }
            })
        })
        .collect()
}

/// Sums the face normals at each position, weighted by the angle of the face there. The sum of a sheet with two opposite sides is 0.
fn smooth_normals(triangles: &[[Corner; 3]]) -> HashMap<[u32; 3], DVec3> {
    let mut sums = HashMap::new();
    for triangle in triangles {
        let face = face_normal(triangle);
        for i in 0..3 {
            let [at, next, last] = [i, (i + 1) % 3, (i + 2) % 3].map(|k| place(&triangle[k]));
            let angle = (next - at).angle_between(last - at);
            *sums.entry(key(triangle[i].position)).or_insert(DVec3::ZERO) += face * angle;
        }
    }
    // Sums that cancel leave rounding errors without a direction.
    sums.retain(|_, n| n.length() > 1e-6);
    sums
}

/// Returns the unit normal by the winding.
fn face_normal(triangle: &[Corner; 3]) -> DVec3 {
    let [a, b, c] = [0, 1, 2].map(|k| place(&triangle[k]));
    (b - a).cross(c - a).normalize_or(DVec3::Z)
}

/// Returns texture coordinates on the side of a box that `normal` points to: v goes up the four walls (y), u goes right as seen from
/// outside; on the lid u is x and v is −z, on the floor u is x and v is z.
fn project(position: [f32; 3], normal: DVec3) -> Vec2 {
    let [x, y, z] = position;
    let size = normal.abs();
    let (u, v) = if size.x > size.y && size.x > size.z {
        if normal.x > 0.0 { (-z, y) } else { (z, y) }
    } else if size.y > size.z {
        if normal.y > 0.0 { (x, -z) } else { (x, z) }
    } else if normal.z > 0.0 {
        (x, y)
    } else {
        (-x, y)
    };
    Vec2::new(u, v)
}

fn place(corner: &Corner) -> DVec3 {
    Vec3::from(corner.position).as_dvec3()
}

/// Positions compare by their bits, with one zero.
fn key(position: [f32; 3]) -> [u32; 3] {
    position.map(|v| (v + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(positions: [[f32; 3]; 3]) -> [Corner; 3] {
        positions.map(|position| Corner { position, normal: None, uv: None })
    }

    #[test]
    fn the_normal_of_a_shared_corner_is_weighted_by_angle_and_not_by_the_number_of_triangles() {
        // Three sides of a cube meet at the origin; one of them is cut in two.
        let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mid = [0.5, 0.5, 0.0];
        let sides = [[o, x, mid], [o, mid, y], [o, y, z], [o, z, x]].map(triangle);
        let n = complete(&sides)[0][0].normal;
        assert!(n.distance(Vec3::ONE.normalize()) < 1e-6, "{n}");
    }

    #[test]
    fn a_sheet_with_two_sides_keeps_the_normal_of_each_side() {
        let [a, b, c] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let both = complete(&[triangle([a, b, c]), triangle([a, c, b])]);
        assert_eq!(both[0][0].normal, Vec3::Z);
        assert_eq!(both[1][0].normal, Vec3::NEG_Z);
    }

    #[test]
    fn a_normal_of_no_length_is_replaced() {
        let mut one = triangle([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        one[0].normal = Some([0.0; 3]);
        one[1].normal = Some([0.0, 3.0, 0.0]);
        let done = complete(&[one]);
        assert_eq!(done[0][0].normal, Vec3::Z);
        assert_eq!(done[0][1].normal, Vec3::Y);
    }

    #[test]
    fn projected_texture_coordinates_are_never_mirrored() {
        for n in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            let [t, b] = n.any_orthonormal_pair().into();
            let uv = |d: DVec3| project(d.as_vec3().to_array(), n);
            let turn = n.dot(t.cross(b));
            assert!(uv(t).perp_dot(uv(b)) * turn as f32 > 0.99, "{n}");
        }
    }
}
