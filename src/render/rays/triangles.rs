//! Triangles of all objects, and the intersection of rays with them.

use crate::scene::Mesh;
use bvh::aabb::{Aabb, Bounded, IntersectsAabb};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use glam::{DVec3, Vec3};
use nalgebra::Point3;
use std::cell::Cell;

/// Relative error of positions computed in f64, with a margin. Boxes are enlarged by it, and shadow rays ignore hits
/// nearer than it.
const ROUNDING: f64 = 1e-9;

/// Half line. Distances along it are in units of the length of `direction`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// Start.
    pub origin: DVec3,
    /// Direction, of any length.
    pub direction: DVec3,
}

/// Triangle of an object.
#[derive(Clone, Debug)]
pub(super) struct Triangle {
    /// Number of the object.
    pub object: usize,
    /// Number of the triangle in its mesh.
    pub number: usize,
    /// Positions of its corners.
    corners: [Vec3; 3],
    /// True if it casts shadows.
    blocks_light: bool,
    /// Number of its leaf in the hierarchy.
    node: usize,
}

/// Intersection of a ray with the plane of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// Distance along the ray; negative behind its origin.
    pub distance: f64,
    /// Barycentric coordinates, all positive inside the triangle. Their sum is 1.
    pub weights: [f64; 3],
}

impl Crossing {
    /// Returns true if the intersection lies on the triangle. A ray through the shared edge of two triangles hits at
    /// least one.
    fn is_inside(&self) -> bool {
        self.weights.iter().all(|weight| *weight >= -ROUNDING)
    }
}

impl Triangle {
    fn corners(&self) -> [DVec3; 3] {
        self.corners.map(|corner| corner.as_dvec3())
    }

    /// Returns the normal of the plane, not normalised.
    pub fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners();
        (b - a).cross(c - a)
    }

    /// Intersects the plane of the triangle (Möller and Trumbore 1997); `None` if the ray is parallel to it.
    pub fn crossing(&self, ray: &Ray) -> Option<Crossing> {
        let [a, b, c] = self.corners();
        let (first, second, from) = (b - a, c - a, ray.origin - a);
        let across = ray.direction.cross(second);
        let determinant = first.dot(across);
        let up = from.cross(first);
        let (u, v) = (from.dot(across) / determinant, ray.direction.dot(up) / determinant);
        let crossing = Crossing { distance: second.dot(up) / determinant, weights: [1.0 - u - v, u, v] };
        (crossing.distance.is_finite() && u.is_finite() && v.is_finite()).then_some(crossing)
    }
}

impl Bounded<f64, 3> for Triangle {
    fn aabb(&self) -> Aabb<f64, 3> {
        let [a, b, c] = self.corners();
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let room = ROUNDING * low.abs().max(high.abs()).max_element().max(f64::MIN_POSITIVE);
        let point = |p: DVec3| Point3::new(p.x, p.y, p.z);
        Aabb::with_bounds(point(low - room), point(high + room))
    }
}

impl BHShape<f64, 3> for Triangle {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

/// Part of a ray up to `end`, which is reduced as triangles are hit.
struct Reach {
    origin: DVec3,
    inverse: DVec3,
    end: Cell<f64>,
}

impl IntersectsAabb<f64, 3> for Reach {
    /// Applies the slab test of Kay and Kajiya (1986).
    fn intersects_aabb(&self, aabb: &Aabb<f64, 3>) -> bool {
        let [low, high] = [aabb.min, aabb.max]
            .map(|corner| (DVec3::new(corner.x, corner.y, corner.z) - self.origin) * self.inverse);
        let first = low.min(high).max_element().max(0.0);
        let last = low.max(high).min_element().min(self.end.get());
        first <= last
    }
}

/// Triangles in a bounding volume hierarchy.
pub(super) struct Triangles {
    all: Vec<Triangle>,
    tree: Bvh<f64, 3>,
    /// Largest absolute coordinate of a corner.
    extent: f64,
}

impl Triangles {
    /// Builds the hierarchy of `objects`, each a mesh and true if it casts shadows.
    pub fn new<'a>(objects: impl Iterator<Item = (&'a Mesh, bool)>) -> Self {
        let mut all = Vec::new();
        for (object, (mesh, blocks_light)) in objects.enumerate() {
            for (number, indices) in mesh.indices().chunks_exact(3).enumerate() {
                let corner = |i: usize| Vec3::from(mesh.vertices()[indices[i] as usize].position);
                let corners = [corner(0), corner(1), corner(2)];
                all.push(Triangle { object, number, corners, blocks_light, node: 0 });
            }
        }
        let corners = all.iter().flat_map(|triangle| triangle.corners);
        let extent = corners.map(|corner| corner.abs().max_element()).fold(0.0, f32::max);
        let tree = Bvh::build(&mut all);
        Self { all, tree, extent: extent.into() }
    }

    /// Finds the first triangle that `ray` hits.
    pub fn nearest(&self, ray: &Ray) -> Option<(&Triangle, Crossing)> {
        let reach = Reach { origin: ray.origin, inverse: ray.direction.recip(), end: Cell::new(f64::MAX) };
        let mut nearest = None;
        for triangle in self.tree.traverse_iterator(&reach, &self.all) {
            let Some(crossing) = triangle.crossing(ray).filter(Crossing::is_inside) else { continue };
            if (0.0..reach.end.get()).contains(&crossing.distance) {
                reach.end.set(crossing.distance);
                nearest = Some((triangle, crossing));
            }
        }
        nearest
    }

    /// Returns true if a triangle other than `from`, on which `ray` starts, blocks light between the origin and the
    /// distance `end`.
    pub fn blocked(&self, ray: &Ray, end: f64, from: &Triangle) -> bool {
        let least = ROUNDING * self.extent / ray.direction.length();
        let reach = Reach { origin: ray.origin, inverse: ray.direction.recip(), end: Cell::new(end) };
        self.tree.traverse_iterator(&reach, &self.all).any(|triangle| {
            let is_other = (triangle.object, triangle.number) != (from.object, from.number);
            let crossing = || triangle.crossing(ray).filter(Crossing::is_inside);
            triangle.blocks_light
                && is_other
                && crossing().is_some_and(|crossing| (least..end).contains(&crossing.distance))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::scene::primitives;

    #[test]
    fn the_nearest_triangle_is_the_one_that_a_search_through_all_finds() {
        let meshes = [primitives::sphere(), primitives::disc(), primitives::plate()];
        let triangles = Triangles::new(meshes.iter().map(|mesh| (mesh, true)));
        let mut random = Random::new(7);
        let mut point = |size: f64| DVec3::from([(); 3].map(|()| size * (2.0 * random.share() - 1.0)));
        let mut met = 0;
        for _ in 0..300 {
            let origin = point(3.0);
            let ray = Ray { origin, direction: point(1.0) - origin };
            let crossings = triangles.all.iter().filter_map(|triangle| triangle.crossing(&ray));
            let distances = crossings.filter(|c| c.is_inside() && c.distance >= 0.0).map(|c| c.distance);
            let exact = distances.fold(f64::INFINITY, f64::min);
            let found = triangles.nearest(&ray).map_or(f64::INFINITY, |(_, crossing)| crossing.distance);
            assert_eq!(found, exact);
            met += usize::from(exact.is_finite());
        }
        assert!(met > 100, "{met}");
    }

    #[test]
    fn a_ray_through_an_edge_or_a_corner_meets_the_mesh() {
        let plate = primitives::plate();
        let triangles = Triangles::new(std::iter::once((&plate, true)));
        for place in [DVec3::ZERO, DVec3::new(0.1, 0.1, 0.0), DVec3::new(-0.25, -0.25, 0.0)] {
            let origin = DVec3::new(0.3, -0.7, 1.9);
            let (_, crossing) = triangles.nearest(&Ray { origin, direction: place - origin }).unwrap();
            assert!((crossing.distance - 1.0).abs() < 1e-12, "{place}");
        }
        let beside = Ray { origin: DVec3::Z, direction: DVec3::new(0.51, 0.0, -1.0) };
        assert!(triangles.nearest(&beside).is_none());
    }

    #[test]
    fn light_is_blocked_between_a_place_and_the_lamp_alone_and_by_what_casts_shadows() {
        let plate = primitives::plate();
        let above = plate.clone().moved(1.0, Vec3::Z).unwrap();
        let blocked = |blocks: bool, end: f64| {
            let triangles = Triangles::new([(&plate, true), (&above, blocks)].into_iter());
            let down = Ray { origin: DVec3::new(0.2, 0.1, 0.5), direction: DVec3::NEG_Z };
            let (from, _) = triangles.nearest(&down).unwrap();
            let up = Ray { origin: DVec3::new(0.2, 0.1, 0.0), direction: DVec3::Z };
            triangles.blocked(&up, end, from)
        };
        assert!(blocked(true, f64::MAX) && blocked(true, 1.5));
        assert!(!blocked(true, 0.9) && !blocked(false, f64::MAX));
    }
}
