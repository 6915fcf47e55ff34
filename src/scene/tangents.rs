//! Tangents after MikkTSpace, the convention that normal maps are baked with.

use super::corner::CompleteCorner;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::Vec3;
use std::collections::HashMap;

/// Largest number of triangles around one point that are handed over together.
const MOST_AROUND: usize = 1000;

/// Returns tangent and handedness of every corner: unit, orthogonal to the corner's normal, w = ±1 with B = w · (N × T). If the texture
/// coordinates give no direction, T is any unit vector orthogonal to N, and w = 1.
pub(super) fn generate(triangles: &[[CompleteCorner; 3]]) -> Vec<[[f32; 4]; 3]> {
    let place = Normalization::of(triangles);
    let batches = batches(triangles, &place);
    let mut mikk =
        Mikk { triangles, place: &place, batch: &[], tangents: vec![[[0.0; 4]; 3]; triangles.len()] };
    for batch in &batches {
        mikk.batch = batch;
        // The error type has no values: generation cannot fail, at worst it leaves corners without a tangent.
        let _ = generate_tangents(&mut mikk);
    }
    for (corners, tangents) in triangles.iter().zip(&mut mikk.tangents) {
        for (corner, tangent) in corners.iter().zip(tangents) {
            *tangent = orthonormal(corner.normal, *tangent);
        }
    }
    mikk.tangents
}

/// Returns `tangent` made orthogonal to `normal`, or a substitute if it has no direction.
fn orthonormal(normal: Vec3, tangent: [f32; 4]) -> [f32; 4] {
    let t = Vec3::from_slice(&tangent);
    let flat = t - normal * normal.dot(t);
    // A shorter difference is rounding.
    if !(flat.is_finite() && flat.length() > 1e-4) {
        return normal.any_orthonormal_vector().extend(1.0).to_array();
    }
    // Once more, because the first difference may have lost digits.
    let unit = flat.normalize();
    let t = (unit - normal * normal.dot(unit)).normalize();
    t.extend(if tangent[3] < 0.0 { -1.0 } else { 1.0 }).to_array()
}

/// Returns the batches of triangles to hand over together: usually all of the mesh. bevy_mikktspace recurses from triangle to triangle
/// around a point, so a fan of a hundred thousand would overflow the stack. If more than [`MOST_AROUND`] meet at a point, the rest go into
/// further batches.
fn batches(triangles: &[[CompleteCorner; 3]], place: &Normalization) -> Vec<Vec<usize>> {
    // Latest batch of each point, and number of its triangles in that batch.
    let mut met: HashMap<[u32; 3], (usize, usize)> = HashMap::new();
    let mut batches = vec![Vec::new()];
    for (i, triangle) in triangles.iter().enumerate() {
        let points = triangle.map(|corner| place.map(corner.position).map(|v| (v + 0.0).to_bits()));
        let free = points.map(|p| match met.get(&p) {
            Some(&(batch, count)) => batch + usize::from(count >= MOST_AROUND),
            None => 0,
        });
        let batch = free.into_iter().fold(0, usize::max);
        for p in points {
            let place = met.entry(p).or_insert((batch, 0));
            *place = if place.0 == batch { (batch, place.1 + 1) } else { (batch, 1) };
        }
        if batch == batches.len() {
            batches.push(Vec::new());
        }
        batches[batch].push(i);
    }
    batches
}

/// Translation to the origin and scaling to unit size, so that products of lengths neither overflow nor vanish.
struct Normalization {
    centre: Vec3,
    scale: f32,
}

impl Normalization {
    fn of(triangles: &[[CompleteCorner; 3]]) -> Self {
        let points = || triangles.iter().flatten().map(|c| c.position);
        let low = points().fold(Vec3::INFINITY, Vec3::min);
        let high = points().fold(Vec3::NEG_INFINITY, Vec3::max);
        Self { centre: (low + high) * 0.5, scale: 2.0 / (high - low).max_element() }
    }

    fn map(&self, position: Vec3) -> [f32; 3] {
        ((position - self.centre) * self.scale).to_array()
    }
}

struct Mikk<'a> {
    triangles: &'a [[CompleteCorner; 3]],
    place: &'a Normalization,
    batch: &'a [usize],
    tangents: Vec<[[f32; 4]; 3]>,
}

impl Geometry for Mikk<'_> {
    fn num_faces(&self) -> usize {
        self.batch.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.place.map(self.triangles[self.batch[face]][vert].position)
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.triangles[self.batch[face]][vert].normal.to_array()
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.triangles[self.batch[face]][vert].uv.to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, vert: usize) {
        self.tangents[self.batch[face]][vert] = space.map_or([0.0; 4], |s| s.tangent_encoded());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    /// Returns a square in the xy plane facing +z, texture coordinates by `uv`.
    fn square(uv: impl Fn(f32, f32) -> Vec2) -> Vec<[CompleteCorner; 3]> {
        let corner = |[x, y]: [f32; 2]| CompleteCorner {
            position: Vec3::new(x, y, 0.0),
            normal: Vec3::Z,
            uv: uv(x, y),
        };
        let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        vec![[a, b, c].map(corner), [a, c, d].map(corner)]
    }

    fn only_tangent(triangles: &[[CompleteCorner; 3]]) -> [f32; 4] {
        let all = generate(triangles);
        assert!(all.iter().flatten().all(|t| *t == all[0][0]), "{all:?}");
        all[0][0]
    }

    #[test]
    fn on_a_plane_with_uv_xy_the_tangent_is_x_and_the_bitangent_y() {
        let [x, y, z, w] = only_tangent(&square(Vec2::new));
        assert_eq!([x, y, z, w], [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(w * Vec3::Z.cross(Vec3::new(x, y, z)), Vec3::Y);
    }

    #[test]
    fn mirrored_texture_coordinates_turn_the_handedness_and_keep_b_along_v() {
        let [x, y, z, w] = only_tangent(&square(|x, y| Vec2::new(-x, y)));
        assert_eq!([x, y, z, w], [-1.0, 0.0, 0.0, -1.0]);
        assert_eq!(w * Vec3::Z.cross(Vec3::new(x, y, z)), Vec3::Y);
    }

    #[test]
    fn turned_texture_coordinates_turn_the_tangent() {
        assert_eq!(only_tangent(&square(|x, y| Vec2::new(y, -x))), [0.0, 1.0, 0.0, 1.0]);
    }

    #[test]
    fn without_a_direction_in_the_texture_coordinates_the_tangent_is_any_orthogonal_unit_vector() {
        for t in generate(&square(|_, _| Vec2::ZERO)).iter().flatten() {
            assert!(t[2] == 0.0 && (t[0].hypot(t[1]) - 1.0).abs() < 1e-6 && t[3] == 1.0, "{t:?}");
        }
    }
    #[test]
    fn around_a_crowded_point_the_tangents_of_all_batches_agree() {
        let rim = |k: usize| {
            let (y, x) = (0.001 * k as f32).sin_cos();
            Vec3::new(x, y, 0.0)
        };
        let corner = |p: Vec3| CompleteCorner { position: p, normal: Vec3::Z, uv: p.truncate() };
        let fan: Vec<_> =
            (0..3 * MOST_AROUND).map(|k| [Vec3::ZERO, rim(k), rim(k + 1)].map(corner)).collect();
        assert_eq!(
            batches(&fan, &Normalization::of(&fan)).iter().map(Vec::len).collect::<Vec<_>>(),
            [MOST_AROUND; 3]
        );
        for t in generate(&fan).iter().flatten() {
            assert!(Vec3::from_slice(t).distance(Vec3::X) < 1e-3 && t[3] == 1.0, "{t:?}");
        }
    }
}
