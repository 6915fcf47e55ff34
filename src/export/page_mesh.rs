//! A mesh as pages hold it: 16 bytes for a vertex, usually one for an index.

use crate::error::{Error, Result};
use crate::scene::{Grooves, Mesh, Vertex};
use glam::{Vec2, Vec3};

/// Most bytes of a mesh, of the 6.7 MB that it shares with the texels.
pub const MOST_PAGE_MESH: usize = 5_000_000;

/// Bytes of a vertex: position and handedness as four 16-bit numbers from 0 to 1, normal and tangent as four from −1 to 1, little-endian.
const VERTEX: usize = 16;

/// Mesh of a page, scaled into the unit sphere, with y up.
///
/// The bytes are those of the vertices, then the indices: each as its difference from the one before, 0, −1, 1, −2, 2 … as 0, 1, 2, 3, 4 …,
/// seven bits a byte from the lowest on, with the highest bit set in all but the last byte.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PageMesh {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Vertices and indices.
    pub bytes: Vec<u8>,
}

impl PageMesh {
    /// Packs `mesh`, whose up is +z, with the patch of the height field oriented by `grooves`.
    ///
    /// # Errors
    /// More bytes than [`MOST_PAGE_MESH`]; grooves whose direction is given over (u, v), which pages do not hold.
    pub fn new(mesh: &Mesh, grooves: &Grooves) -> Result<Self> {
        let angle = match grooves {
            Grooves::Along => 0.0,
            Grooves::Turned(degrees) => degrees.to_radians() as f32,
            Grooves::Radial | Grooves::Map(_) => {
                return Err(Error::input(
                    "a page has no texture coordinates, from which this mesh takes the direction of its grooves",
                    "give grooves an angle in the scene file, or name the mesh itself",
                ));
            }
        };
        let bounds = mesh.bounds();
        let mut bytes = Vec::with_capacity(VERTEX * mesh.vertices().len() + 4 * mesh.triangle_count());
        for vertex in mesh.vertices() {
            let place = (Vec3::from(vertex.position) - bounds.centre) / bounds.radius;
            bytes.extend(packed(vertex, place, angle));
        }
        let mut last = 0;
        for &index in mesh.indices() {
            let step = i64::from(index) - last;
            put(((step << 1) ^ (step >> 63)) as u64, &mut bytes);
            last = i64::from(index);
        }
        let packed = Self { vertices: mesh.vertices().len(), triangles: mesh.triangle_count(), bytes };
        packed.check_size()?;
        Ok(packed)
    }

    /// Fails if the mesh takes more than [`MOST_PAGE_MESH`] bytes.
    fn check_size(&self) -> Result<()> {
        let bytes = self.bytes.len();
        if bytes <= MOST_PAGE_MESH {
            return Ok(());
        }
        // Two digits, rounded down.
        let fitting = (self.triangles as u128 * MOST_PAGE_MESH as u128 / bytes as u128) as usize;
        let unit = 10usize.pow(fitting.max(10).ilog10() - 1);
        Err(Error::limit(
            format!(
                "the mesh of {} triangles takes {:.1} MB of the page, and {} MB is the most",
                self.triangles,
                bytes as f64 / 1e6,
                MOST_PAGE_MESH / 1_000_000
            ),
            format!("simplify it to about {} triangles", fitting / unit * unit),
        ))
    }
}

/// Returns the bytes of a vertex at `place` in the unit sphere, whose tangent is turned by `angle` toward the bitangent.
fn packed(vertex: &Vertex, place: Vec3, angle: f32) -> [u8; VERTEX] {
    let [normal, along] = [Vec3::from(vertex.normal), Vec3::from_slice(&vertex.tangent)];
    let hand = vertex.tangent[3];
    let tangent = angle.cos() * along + angle.sin() * hand * normal.cross(along);
    let [x, y, z] = upright(place).to_array();
    let unsigned = [x, y, z, hand].map(|c| ((0.5 * c + 0.5).clamp(0.0, 1.0) * 65535.0).round() as u16);
    let [n, t] = [normal, tangent].map(|axis| folded(upright(axis)));
    let signed = [n.x, n.y, t.x, t.y].map(|c| (c * 32767.0).round() as i16);
    bytemuck::cast([unsigned.map(u16::to_le_bytes), signed.map(i16::to_le_bytes)])
}

/// Returns a vector of a world whose up is +z in that of the page, whose up is +y and whose viewer is in front, at +z.
pub(super) fn upright(v: Vec3) -> Vec3 {
    Vec3::new(v.x, v.z, -v.y)
}

/// Folds a unit vector onto the square from −1 to 1 through an octahedron.
fn folded(unit: Vec3) -> Vec2 {
    let place = unit.truncate() / (unit.x.abs() + unit.y.abs() + unit.z.abs());
    if unit.z < 0.0 { (1.0 - Vec2::new(place.y, place.x).abs()) * Vec2::ONE.copysign(place) } else { place }
}

/// Appends `number`, seven bits a byte.
fn put(mut number: u64, bytes: &mut Vec<u8>) {
    while number > 127 {
        bytes.push(number as u8 | 128);
        number >>= 7;
    }
    bytes.push(number as u8);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::snake;

    /// Unfolds what [`folded`] folds, as the page's shader does.
    fn unfolded([x, y]: [i16; 2]) -> Vec3 {
        let place = Vec2::new(f32::from(x), f32::from(y)) / 32767.0;
        let z = 1.0 - place.x.abs() - place.y.abs();
        let turned = (1.0 - Vec2::new(place.y, place.x).abs()) * Vec2::ONE.copysign(place);
        if z < 0.0 { turned } else { place }.extend(z).normalize()
    }

    fn words<const N: usize>(bytes: &[u8]) -> [[u8; 2]; N] {
        bytes.as_chunks().0.try_into().unwrap()
    }

    #[test]
    fn the_snake_comes_back_within_the_rounding_of_its_numbers() {
        let mesh = snake::mesh().unwrap();
        let page = PageMesh::new(&mesh, &Grooves::Along).unwrap();
        let bounds = mesh.bounds();
        let mut off = [0.0f32; 3];
        let (vertices, indices) = page.bytes.split_at(VERTEX * page.vertices);
        for (bytes, vertex) in vertices.chunks_exact(VERTEX).zip(mesh.vertices()) {
            let [x, y, z, hand] = words(&bytes[..8]).map(|w| f32::from(u16::from_le_bytes(w)) / 65535.0);
            let [a, b, c, d] = words(&bytes[8..]).map(i16::from_le_bytes);
            let place = upright(Vec3::from(vertex.position) - bounds.centre) / bounds.radius;
            let [n, t] = [Vec3::from(vertex.normal), Vec3::from_slice(&vertex.tangent)].map(upright);
            let found = [Vec3::new(x, y, z) * 2.0 - 1.0, unfolded([a, b]), unfolded([c, d])];
            for ((off, found), expected) in off.iter_mut().zip(found).zip([place, n, t]) {
                *off = off.max(found.distance(expected));
            }
            assert_eq!(hand, if vertex.tangent[3] > 0.0 { 1.0 } else { 0.0 });
        }
        eprintln!("{off:?}, {} bytes for {} triangles", page.bytes.len(), page.triangles);
        // Half a step along each axis is 2.6e-5. A step on the octahedron is up to 3 steps on the sphere: 6.5e-5.
        assert!(off[0] < 2.7e-5 && off[1] < 6.6e-5 && off[2] < 6.6e-5, "{off:?}");
        let mut last = 0i64;
        let (mut number, mut shift, mut found) = (0u64, 0, Vec::new());
        for byte in indices {
            number |= u64::from(byte & 127) << shift;
            shift += 7;
            if *byte < 128 {
                last += (number >> 1) as i64 ^ -((number & 1) as i64);
                found.push(last as u32);
                (number, shift) = (0, 0);
            }
        }
        assert_eq!(found, mesh.indices());
        assert!(indices.len() < 5 * page.triangles, "{} bytes of indices", indices.len());
    }

    #[test]
    fn grooves_turn_the_tangent_toward_the_bitangent() {
        let plate = crate::scene::primitives::plate();
        let turned = PageMesh::new(&plate, &Grooves::Turned(90.0)).unwrap();
        let [a, b, c, d] = words(&turned.bytes[8..16]).map(i16::from_le_bytes);
        // N is +z of the world, up in the page; T becomes +y, away from the viewer.
        assert!(unfolded([a, b]).distance(Vec3::Y) < 1e-4 && unfolded([c, d]).distance(Vec3::NEG_Z) < 1e-4);
        let e = PageMesh::new(&plate, &Grooves::Radial).unwrap_err().to_string();
        assert!(e.contains("texture coordinates") && e.contains("an angle"), "{e}");
    }

    #[test]
    fn a_mesh_that_is_too_large_is_refused_with_a_number_of_triangles_that_fits() {
        let mesh = PageMesh { vertices: 1, triangles: 1_000_000, bytes: vec![0; 12_000_000] };
        let e = mesh.check_size().unwrap_err().to_string();
        assert!(e.contains("1000000 triangles takes 12.0 MB") && e.contains("about 410000 triangles"), "{e}");
    }
}
