//! Triangles of all objects, and which of them a ray meets.

use crate::scene::Mesh;
use bvh::aabb::{Aabb, Bounded, IntersectsAabb};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use glam::{DVec3, Vec3};
use nalgebra::Point3;
use std::cell::Cell;

/// Relative error of places that are computed in f64, with room to spare. Boxes are wider by it, and a shadow ray meets nothing nearer.
const ROUNDING: f64 = 1e-9;

/// Half line. Distances along it are in lengths of `direction`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where to it leads, of any length.
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
    /// Whether it blocks light.
    blocks_light: bool,
    /// Number of its leaf in the hierarchy.
    node: usize,
}

/// Crossing of a ray and the plane of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// Distance along the ray; negative behind its origin.
    pub distance: f64,
    /// Barycentric coordinates, all positive within the triangle. Their sum is 1.
    pub weights: [f64; 3],
}

impl Crossing {
    /// Tells a crossing on the triangle from one beside it. A ray along the edge of two triangles meets at least one.
    fn is_inside(&self) -> bool {
        self.weights.iter().all(|weight| *weight >= -ROUNDING)
    }
}

impl Triangle {
    fn corners(&self) -> [DVec3; 3] {
        self.corners.map(|corner| corner.as_dvec3())
    }

    /// Returns the normal of the plane, of no particular length.
    pub fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners();
        (b - a).cross(c - a)
    }

    /// Crosses the plane of the triangle (Möller and Trumbore 1997); `None` where the ray runs along it.
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

/// Part of a ray up to `end`, which comes nearer as triangles are met.
struct Reach {
    origin: DVec3,
    inverse: DVec3,
    end: Cell<f64>,
}

impl IntersectsAabb<f64, 3> for Reach {
    /// The slab test of Kay and Kajiya (1986).
    fn intersects_aabb(&self, aabb: &Aabb<f64, 3>) -> bool {
        let [low, high] = [aabb.min, aabb.max]
            .map(|corner| (DVec3::new(corner.x, corner.y, corner.z) - self.origin) * self.inverse);
        let first = low.min(high).max_element().max(0.0);
        let last = low.max(high).min_element().min(self.end.get());
        first <= last
    }
}

/// Triangles in a hierarchy of boxes.
pub(super) struct Triangles {
    all: Vec<Triangle>,
    tree: Bvh<f64, 3>,
    /// Largest coordinate of any.
    extent: f64,
}

impl Triangles {
    /// Those of `objects`, meshes and whether they block light.
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

    /// Finds the triangle that `ray` meets first.
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

    /// Tells whether anything but the triangle `from`, on which `ray` starts, blocks light between its origin and the distance `end`.
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
