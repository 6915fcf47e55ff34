//! The triangle mesh with a tangent frame at every vertex.

use super::corner::Corner;
use super::{normals, tangents};
use crate::error::{Error, Result};
use crate::task::Task;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec3};
use std::collections::HashMap;

/// Largest number of triangles of a mesh: 5 GB while it is built, if no vertex is shared.
pub const MAX_TRIANGLES: usize = 8_000_000;

/// The largest absolute coordinate: squares of products of coordinates still fit an `f32`.
const MAX_COORDINATE: f32 = 1e9;

/// Sine of the smallest angle of a triangle that is kept; a thinner one has no direction that an `f32` can hold.
const THINNEST: f64 = 1e-6;

/// One vertex, laid out as the vertex buffer holds it: 48 bytes, no padding.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// Position in model space; any axis may be up.
    pub position: [f32; 3],
    /// Unit normal N.
    pub normal: [f32; 3],
    /// Unit tangent T (xyz), orthogonal to N, and the handedness w = ±1: B = w · (N × T).
    pub tangent: [f32; 4],
    /// Texture coordinates; T points along growing u, B along growing v.
    pub uv: [f32; 2],
}

/// A sphere around a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Centre of the mesh's axis-aligned box.
    pub centre: Vec3,
    /// Distance from `centre` to the farthest vertex; positive.
    pub radius: f32,
}

/// Triangles with unit normals and tangents orthogonal to them, everything finite and every index in range.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
    bounds: Bounds,
    origin: TangentOrigin,
}

/// Origin of the directions in which texture coordinates grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TangentOrigin {
    /// The texture coordinates of the mesh.
    Given,
    /// The sides of a box: a corner of the mesh has no texture coordinates.
    Projected,
    /// None: those of every triangle are equal or lie on a line.
    Arbitrary,
}

#[doc(hidden)]
impl Mesh {
    /// Builds a mesh from loose triangles, counter-clockwise as seen from outside.
    ///
    /// Triangles without area are dropped. Missing normals are averages over the triangles that share a position,
    /// weighted by their angle there, so edges come out smooth. Tangents follow MikkTSpace; where the texture
    /// coordinates give no direction, T is any unit vector orthogonal to N. Equal vertices are shared.
    ///
    /// # Errors
    /// More than [`MAX_TRIANGLES`], a coordinate that is not finite or beyond ±10⁹, no triangle with an area.
    pub fn from_triangles(triangles: Vec<[Corner; 3]>) -> Result<Self> {
        Self::build(triangles, &Task::silent())
    }

    /// Builds a mesh like [`Mesh::from_triangles`], with reports to `task`.
    ///
    /// # Errors
    /// Those of [`Mesh::from_triangles`], and a cancelled task.
    pub(super) fn build(mut triangles: Vec<[Corner; 3]>, task: &Task) -> Result<Self> {
        let step = |done| task.report("building the mesh", done, 4);
        step(0)?;
        if triangles.len() > MAX_TRIANGLES {
            return Err(Error::input(
                format!("the mesh has {} triangles, more than {MAX_TRIANGLES}", triangles.len()),
                "simplify it first",
            ));
        }
        for (i, triangle) in triangles.iter().enumerate() {
            triangle.iter().try_for_each(check).map_err(|e| e.at(format!("triangle {}", i + 1)))?;
        }
        triangles.retain(has_area);
        if triangles.is_empty() {
            return Err(Error::input(
                "the mesh has no triangle with an area",
                "give it at least one real face",
            ));
        }
        step(1)?;
        let origin = TangentOrigin::of(&triangles);
        let corners = normals::complete(&triangles);
        drop(triangles);
        step(2)?;
        let tangents = tangents::generate(&corners);
        step(3)?;
        let vertices = corners.iter().flatten().zip(tangents.iter().flatten());
        let mesh = weld(vertices.map(|(corner, &tangent)| Vertex {
            position: corner.position.to_array(),
            normal: corner.normal.to_array(),
            tangent,
            uv: corner.uv.to_array(),
        }));
        Ok(Self { origin, ..mesh })
    }

    /// Returns a mesh with known frames. The caller guarantees the invariants of [`Mesh`].
    pub(super) fn from_parts(vertices: Vec<Vertex>, indices: Vec<u32>) -> Self {
        Self { bounds: Bounds::of(vertices.iter()), vertices, indices, origin: TangentOrigin::Given }
    }

    /// Returns a note on the direction of grooves if the mesh does not give it; `None` if it does.
    pub fn note(&self) -> Option<&'static str> {
        match self.origin {
            TangentOrigin::Given => None,
            TangentOrigin::Projected => Some(
                "without texture coordinates the direction of the grooves is that of the sides of a box; unwrap the mesh to give it one",
            ),
            TangentOrigin::Arbitrary => Some(
                "the texture coordinates of each triangle are equal or on a line, so that the direction of the grooves is arbitrary; unwrap the mesh",
            ),
        }
    }

    /// Rotates positions, normals and tangents of the mesh by `turn`.
    #[must_use]
    pub fn turned(mut self, turn: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        for v in &mut self.vertices {
            let [x, y, z, w] = v.tangent;
            let [tx, ty, tz] = turn([x, y, z]);
            (v.position, v.normal, v.tangent) = (turn(v.position), turn(v.normal), [tx, ty, tz, w]);
        }
        self.bounds = Bounds::of(self.vertices.iter());
        self
    }

    /// Scales the mesh by `size`, then moves it by `offset`.
    ///
    /// # Errors
    /// A coordinate beyond ±10⁹ after that, or all of the mesh in one point.
    pub fn moved(mut self, size: f32, offset: Vec3) -> Result<Self> {
        for v in &mut self.vertices {
            v.position = (size * Vec3::from(v.position) + offset).to_array();
        }
        self.bounds = Bounds::of(self.vertices.iter());
        let inside = |v: &Vertex| v.position.iter().all(|x| x.abs() <= MAX_COORDINATE);
        if self.vertices.iter().all(inside) && self.bounds.radius > 0.0 {
            return Ok(self);
        }
        Err(Error::input(
            format!("the mesh stands beyond {MAX_COORDINATE:e}, or all of it in one place"),
            "give another place or size",
        ))
    }

    /// Returns all vertices, ready for a vertex buffer.
    pub fn vertices(&self) -> &[Vertex] {
        &self.vertices
    }

    /// Returns three vertex indices per triangle, ready for an index buffer.
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// Returns the number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// Returns the bounding sphere.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }
}

impl Bounds {
    /// Returns a sphere around all of `meshes`.
    pub fn enclosing(meshes: &[&Mesh]) -> Self {
        match meshes {
            [one] => one.bounds,
            several => Self::of(several.iter().flat_map(|mesh| mesh.vertices())),
        }
    }

    fn of<'a>(vertices: impl Iterator<Item = &'a Vertex> + Clone) -> Self {
        let points = || vertices.clone().map(|v| Vec3::from(v.position));
        let low = points().fold(Vec3::INFINITY, Vec3::min);
        let high = points().fold(Vec3::NEG_INFINITY, Vec3::max);
        let centre = (low + high) * 0.5;
        Self { centre, radius: points().map(|p| p.distance(centre)).fold(0.0, f32::max) }
    }
}

/// Rejects coordinates that are not finite or too large.
fn check(corner: &Corner) -> Result<()> {
    let sane = |values: &[f32]| values.iter().all(|v| v.abs() <= MAX_COORDINATE);
    let wrong = |what: &str, values: &[f32]| {
        Error::input(
            format!("the {what} {values:?} is not finite or beyond {MAX_COORDINATE:e}"),
            "repair or rescale the mesh",
        )
    };
    if !sane(&corner.position) {
        return Err(wrong("position", &corner.position));
    }
    if let Some(normal) = corner.normal.filter(|n| !n.iter().all(|v| v.is_finite())) {
        return Err(wrong("normal", &normal));
    }
    match corner.uv {
        Some(uv) if !sane(&uv) => Err(wrong("texture coordinate", &uv)),
        _ => Ok(()),
    }
}

/// Returns true if a triangle spans an area, relative to its size.
fn has_area(triangle: &[Corner; 3]) -> bool {
    let [a, b, c] = triangle.map(|corner| Vec3::from(corner.position).as_dvec3());
    let longest = [b - a, c - b, a - c].map(DVec3::length_squared).into_iter().fold(0.0, f64::max);
    (b - a).cross(c - a).length() > THINNEST * longest
}

impl TangentOrigin {
    fn of(triangles: &[[Corner; 3]]) -> Self {
        if triangles.iter().flatten().any(|corner| corner.uv.is_none()) {
            return Self::Projected;
        }
        let spans = |triangle: &[Corner; 3]| {
            let [a, b, c] = triangle.map(|corner| DVec2::from(corner.uv.unwrap_or_default().map(f64::from))); // some, see above
            let longest = [b - a, c - b, a - c].map(DVec2::length_squared).into_iter().fold(0.0, f64::max);
            (b - a).perp_dot(c - a).abs() > THINNEST * longest
        };
        if triangles.iter().any(spans) { Self::Given } else { Self::Arbitrary }
    }
}

/// Merges equal vertices.
fn weld(corners: impl Iterator<Item = Vertex>) -> Mesh {
    let mut known: HashMap<[u32; 12], u32> = HashMap::new();
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for mut vertex in corners {
        // −0 and 0 are the same place.
        let floats: &mut [f32; 12] = bytemuck::cast_mut(&mut vertex);
        floats.iter_mut().for_each(|v| *v += 0.0);
        let index = *known.entry(floats.map(f32::to_bits)).or_insert_with(|| {
            vertices.push(vertex);
            (vertices.len() - 1) as u32
        });
        indices.push(index);
    }
    Mesh::from_parts(vertices, indices)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Fails unless `mesh` keeps the invariants of [`Mesh`].
    pub fn assert_sound(mesh: &Mesh) {
        assert!(!mesh.indices.is_empty() && mesh.indices.len().is_multiple_of(3));
        assert!(mesh.indices.iter().all(|&i| (i as usize) < mesh.vertices.len()));
        for v in &mesh.vertices {
            assert!(bytemuck::cast::<Vertex, [f32; 12]>(*v).iter().all(|x| x.is_finite()), "{v:?}");
            let [n, t] = [Vec3::from(v.normal), Vec3::from_slice(&v.tangent)];
            assert!((n.length() - 1.0).abs() < 1e-5 && (t.length() - 1.0).abs() < 1e-5, "{v:?}");
            assert!(n.dot(t).abs() < 1e-5, "{v:?}");
            assert!(v.tangent[3].abs() == 1.0, "{v:?}");
        }
    }

    fn corner(position: [f32; 3]) -> Corner {
        Corner { position, normal: None, uv: None }
    }

    #[test]
    fn a_lone_triangle_gets_its_face_normal_and_a_frame() {
        let triangle = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]].map(corner);
        let mesh = Mesh::from_triangles(vec![triangle]).unwrap();
        assert_sound(&mesh);
        assert_eq!((mesh.vertices.len(), mesh.triangle_count()), (3, 1));
        assert_eq!(mesh.vertices[0].normal, [0.0, 0.0, 1.0]);
        assert_eq!(mesh.vertices[0].tangent, [1.0, 0.0, 0.0, 1.0]);
        let bounds = mesh.bounds();
        assert_eq!(bounds.centre, Vec3::new(1.0, 1.0, 0.0));
        assert!((bounds.radius - 2f32.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn triangles_without_area_are_dropped_and_a_mesh_of_them_is_refused() {
        let good = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(corner);
        let line = [[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]].map(corner);
        let point = [corner([5.0; 3]); 3];
        assert_eq!(Mesh::from_triangles(vec![line, good, point]).unwrap().triangle_count(), 1);
        assert!(
            Mesh::from_triangles(vec![line, point])
                .unwrap_err()
                .to_string()
                .contains("no triangle with an area")
        );
        assert!(Mesh::from_triangles(vec![]).is_err());
    }

    #[test]
    fn meshes_tell_where_the_direction_of_grooves_is_from() {
        let with = |uvs: [Option<[f32; 2]>; 3]| {
            let mut triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(corner);
            triangle.iter_mut().zip(uvs).for_each(|(corner, uv)| corner.uv = uv);
            Mesh::from_triangles(vec![triangle]).unwrap().note()
        };
        assert_eq!(with([Some([0.0, 0.0]), Some([1.0, 0.0]), Some([0.0, 1.0])]), None);
        assert!(with([Some([0.0, 0.0]), Some([1.0, 0.0]), None]).unwrap().contains("without texture"));
        for line in [[[0.5, 0.5]; 3], [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]] {
            assert!(with(line.map(Some)).unwrap().contains("on a line"), "{line:?}");
        }
    }

    #[test]
    fn coordinates_that_are_not_finite_are_named() {
        for bad in [f32::NAN, f32::INFINITY, 1e30] {
            let mut triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(corner);
            triangle[1].position[2] = bad;
            let e = Mesh::from_triangles(vec![triangle]).unwrap_err().to_string();
            assert!(e.contains("triangle 1") && e.contains("position"), "{e}");
        }
        let mut triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(corner);
        triangle[2].normal = Some([f32::NAN, 0.0, 0.0]);
        assert!(Mesh::from_triangles(vec![triangle]).is_err());
        triangle[2].normal = None;
        triangle[0].uv = Some([f32::NAN, 0.0]);
        assert!(Mesh::from_triangles(vec![triangle]).is_err());
    }

    proptest! {
        #[test]
        fn any_triangles_with_any_attributes_come_out_sound(
            raw in prop::collection::vec((prop::array::uniform3(0usize..12), any::<[bool; 2]>(), 0usize..12), 1..40),
            pool in prop::collection::vec(prop::array::uniform8(-2i8..=2), 12),
            exponent in -20i32..8,
        ) {
            let scale = 10f32.powi(exponent);
            let triangles: Vec<_> = raw.iter().map(|(at, has, other)| at.map(|i| {
                let p = pool[i].map(f32::from);
                let q = pool[*other].map(f32::from);
                Corner {
                    position: [p[0] * scale, p[1] * scale, p[2] * scale],
                    normal: has[0].then_some([q[3], p[4], p[5]]),
                    uv: has[1].then_some([p[6], p[7]]),
                }
            })).collect();
            if let Ok(mesh) = Mesh::from_triangles(triangles) {
                assert_sound(&mesh);
            }
        }
    }
}
