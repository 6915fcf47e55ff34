//! glTF 2.0 files (`.gltf`, `.glb`): the triangles of the first scene, with their normals, their first texture coordinates and the base colours of
//! their materials. Skins, morph targets, textures, cameras and lights are left out.

use super::corner::Corner;
use super::gltf_buffers::GltfBuffers;
use super::loaded_mesh::LoadedMesh;
use super::mesh::{MAX_TRIANGLES, Mesh};
use super::mesh_colors::MeshColors;
use super::parts::Parts;
use crate::error::{Error, Result};
use crate::memory;
use crate::task::Task;
use glam::{DMat3, DMat4, DVec3, Vec3};
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Node, Primitive, Semantic};
use std::collections::BTreeMap;
use std::path::Path;

/// Beginning of a binary file.
const SIGNATURE: &[u8] = b"glTF";
/// Length of the header of a binary file, and of it with that of its first chunk \[bytes\].
const HEADER: usize = 12;
const FIRST_CHUNK: usize = HEADER + 8;
/// Memory of an object, of a value and of a byte of the description \[bytes\]: the largest object, a node, takes 400.
const BYTES_PER_OBJECT: u64 = 512;
const BYTES_PER_VALUE: u64 = 128;
const BYTES_PER_BYTE: u64 = 4;
/// Memory of a triangle while the mesh is built, as of OBJ files.
const BYTES_PER_TRIANGLE: u64 = 700;
/// Most vertices and indices that are read, in all places of all meshes: those of the largest mesh whose triangles share no vertex, twice.
const MOST_READ: usize = 12 * MAX_TRIANGLES;
/// Most pieces of meshes in all places.
const MOST_PIECES: usize = 1 << 20;

/// Reads the mesh in the `bytes` of a glTF file in `folder`, or only the `part` that is a node, a mesh or a material of this name; reports to the task.
///
/// # Errors
/// Fails for bytes that are no glTF or are cut short, an extension without which the file has no mesh, a buffer that is missing or short, an index of
/// no vertex, no triangles, more than [`MAX_TRIANGLES`], a part that the file does not have, and a cancelled task.
pub(super) fn load(bytes: &[u8], folder: &Path, part: Option<&str>, task: &Task) -> Result<LoadedMesh> {
    let (document, blob) = parse(bytes)?;
    let buffers = GltfBuffers::read(&document, blob, folder)?;
    let mut gathered = GltfTriangles {
        buffers: &buffers,
        parts: Parts::new(part),
        colors: MeshColors::default(),
        triangles: Vec::new(),
        read: 0,
        pieces: 0,
        task,
    };
    gathered.scene(&document)?;
    gathered.parts.check()?;
    if gathered.triangles.is_empty() {
        return Err(Error::input("the glTF has no triangles", "export it with the faces of a mesh"));
    }
    let (colors, triangles) = (gathered.colors, gathered.triangles);
    let mut loaded = LoadedMesh::new(Mesh::build(triangles, task)?);
    let by_key: BTreeMap<String, Vec3> =
        document.materials().map(|m| (key(m.index()), color_of(&m))).collect();
    loaded.color(colors.mean(|name| by_key.get(name).copied()));
    Ok(loaded)
}

/// Reads the mesh in the bytes of a glTF file that holds all its data.
///
/// # Errors
/// Those of a file, whose buffers beside it are missing.
pub fn from_bytes(bytes: &[u8]) -> Result<Mesh> {
    load(bytes, Path::new("no folder"), None, &Task::silent()).map(|loaded| loaded.mesh)
}

/// Returns the key of a material, whose names need not differ.
fn key(index: Option<usize>) -> String {
    index.map_or(String::new(), |index| index.to_string())
}

/// Returns the base colour of a material, linear sRGB within 0 to 1.
fn color_of(material: &gltf::Material<'_>) -> Vec3 {
    let [r, g, b, _] = material.pbr_metallic_roughness().base_color_factor();
    Vec3::new(r, g, b).map(|x| if x.is_nan() { 0.0 } else { x }).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Parses and checks the description, and returns it with the data that a binary file holds.
fn parse(bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>)> {
    let damaged =
        |e: gltf::Error| Error::input("the glTF is damaged or cut short", "export it again").caused_by(e);
    check_room(bytes)?;
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(damaged)?;
    // None is supported, compression least of all.
    if let Some(extension) = document.extensions_required().next() {
        return Err(Error::input(
            format!("the glTF needs the extension {extension:?}, which is not read"),
            "export it again without compression and extensions",
        ));
    }
    // The check of the rest indexes with these.
    let root = document.as_json();
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    if primitives.flat_map(|p| p.attributes.values()).any(|index| index.value() >= root.accessors.len()) {
        return Err(Error::input(
            "a mesh of the glTF asks for data that it does not have",
            "export it again",
        ));
    }
    let document = Document::from_json(document.into_json()).map_err(damaged)?;
    Ok((document, blob))
}

/// Fails for a file that is no glTF, and for a description that would take more memory than there is.
fn check_room(bytes: &[u8]) -> Result<()> {
    let is_binary = bytes.starts_with(SIGNATURE);
    let word =
        |place: usize| bytes.get(place..place + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    // The parser trusts the length in the header to be no less than that of the header.
    let is_short = is_binary && word(8).is_none_or(|length| (length as usize) < FIRST_CHUNK);
    if is_short || !(is_binary || bytes.trim_ascii_start().starts_with(b"{")) {
        return Err(Error::input("this is not a glTF, or it is cut short", "export the mesh as .glb again"));
    }
    let description = match word(HEADER).filter(|_| is_binary) {
        Some(length) => {
            &bytes[FIRST_CHUNK.min(bytes.len())..]
                [..(length as usize).min(bytes.len() - FIRST_CHUNK.min(bytes.len()))]
        }
        None => bytes,
    };
    let (mut objects, mut values) = (0u64, 0u64);
    for byte in description {
        objects += u64::from(*byte == b'{');
        values += u64::from(*byte == b':');
    }
    let room =
        BYTES_PER_OBJECT * objects + BYTES_PER_VALUE * values + BYTES_PER_BYTE * description.len() as u64;
    memory::ensure_room(room.saturating_add(bytes.len() as u64), "the description of the mesh")
}

/// Triangles of the nodes so far.
struct GltfTriangles<'a> {
    buffers: &'a GltfBuffers,
    parts: Parts,
    colors: MeshColors,
    triangles: Vec<[Corner; 3]>,
    /// Number of vertices and indices that were read.
    read: usize,
    /// Number of pieces of meshes.
    pieces: usize,
    task: &'a Task,
}

impl GltfTriangles<'_> {
    /// Adds the nodes of the default scene, or the first; all meshes where they are if there is none.
    fn scene(&mut self, document: &Document) -> Result<()> {
        let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
            for mesh in document.meshes() {
                self.mesh(&mesh, None, DMat4::IDENTITY)?;
            }
            return Ok(());
        };
        let mut visited = vec![false; document.nodes().len()];
        let mut waiting: Vec<(Node<'_>, DMat4)> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
        while let Some((node, parent)) = waiting.pop() {
            // Nodes form trees; others would not end.
            if std::mem::replace(&mut visited[node.index()], true) {
                return Err(Error::input(
                    format!("node {} of the glTF is a child twice", node.index()),
                    "the file may be damaged; export it again",
                ));
            }
            let columns = node.transform().matrix().map(|column| column.map(f64::from));
            let place = parent * DMat4::from_cols_array_2d(&columns);
            if let Some(mesh) = node.mesh() {
                self.mesh(&mesh, node.name(), place)?;
            }
            waiting.extend(node.children().map(|child| (child, place)));
        }
        Ok(())
    }

    /// Adds the pieces of `mesh` at `place` in the scene that belong to the selected part.
    fn mesh(&mut self, mesh: &gltf::Mesh<'_>, node: Option<&str>, place: DMat4) -> Result<()> {
        let named = |name: Option<&str>| name.map(str::to_owned).into_iter().collect();
        self.parts.set(0, named(node));
        self.parts.set(1, named(mesh.name()));
        for primitive in mesh.primitives() {
            self.pieces += 1;
            if self.pieces > MOST_PIECES {
                return Err(too_much(self.pieces, MOST_PIECES, "pieces of meshes"));
            }
            self.parts.set(2, named(primitive.material().name()));
            if self.parts.keeps() {
                let at = |e: Error| e.at(format!("mesh {}", mesh.index()));
                self.primitive(&primitive, place).map_err(at)?;
            }
        }
        self.task.report("reading meshes", self.triangles.len(), self.triangles.len().max(1))
    }

    /// Adds the triangles of `primitive`; points and lines have none.
    fn primitive(&mut self, primitive: &Primitive<'_>, place: DMat4) -> Result<()> {
        let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(()) };
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let indices = primitive.indices();
        let count = indices.as_ref().map_or(positions.count(), gltf::Accessor::count);
        self.read = self.read.saturating_add(positions.count()).saturating_add(count);
        if self.read > MOST_READ {
            return Err(too_much(self.read, MOST_READ, "vertices and indices"));
        }
        let corners = corners(primitive, self.buffers, place)?;
        let numbers = match indices {
            Some(indices) => self.buffers.indices(&indices)?,
            None => (0..corners.len() as u32).collect(),
        };
        let triangles = triangles(&numbers, primitive.mode());
        let total = self.triangles.len() + triangles.len();
        if total > MAX_TRIANGLES {
            return Err(too_much(total, MAX_TRIANGLES, "triangles"));
        }
        memory::ensure_room(total as u64 * BYTES_PER_TRIANGLE, "the triangles of the mesh")?;
        let key = key(primitive.material().index());
        self.colors.add(Some(&key).filter(|key| !key.is_empty()).map(String::as_str), triangles.len());
        let is_mirrored = place.determinant() < 0.0;
        for [a, b, c] in triangles {
            let [a, b, c] = if is_mirrored { [a, c, b] } else { [a, b, c] };
            let corner = |number: u32| {
                corners.get(number as usize).copied().ok_or_else(|| {
                    let what = format!("it asks for vertex {number} of {}, counted from 0", corners.len());
                    Error::input(what, "the file may be damaged; export it again")
                })
            };
            self.triangles.push([corner(a)?, corner(b)?, corner(c)?]);
        }
        Ok(())
    }
}

fn too_much(count: usize, most: usize, what: &str) -> Error {
    Error::input(format!("the glTF has {count} or more {what}, more than {most}"), "simplify it first")
}

/// Returns the vertices of `primitive` at `place` in the scene.
fn corners(primitive: &Primitive<'_>, buffers: &GltfBuffers, place: DMat4) -> Result<Vec<Corner>> {
    let attribute = |semantic: Semantic| primitive.get(&semantic);
    let positions = attribute(Semantic::Positions).map_or(Ok(Vec::new()), |a| buffers.floats::<3>(&a))?;
    let normals = attribute(Semantic::Normals).map(|a| buffers.floats::<3>(&a)).transpose()?;
    let uvs = attribute(Semantic::TexCoords(0)).map(|a| buffers.floats::<2>(&a)).transpose()?;
    // Normals turn by the inverse transpose.
    let turn = DMat3::from_mat4(place).inverse().transpose();
    let turned = |normal: [f32; 3]| {
        let normal = (turn * Vec3::from(normal).as_dvec3()).normalize_or_zero();
        normal.as_vec3().to_array()
    };
    let moved = |position: [f32; 3]| {
        let moved: DVec3 = place.transform_point3(Vec3::from(position).as_dvec3());
        moved.as_vec3().to_array()
    };
    let corner = |(i, position): (usize, &[f32; 3])| Corner {
        position: moved(*position),
        normal: normals.as_ref().and_then(|normals| normals.get(i)).map(|normal| turned(*normal)),
        // v grows downward in glTF, from the top of the picture.
        uv: uvs.as_ref().and_then(|uvs| uvs.get(i)).map(|[u, v]| [*u, 1.0 - v]),
    };
    Ok(positions.iter().enumerate().map(corner).collect())
}

/// Returns the corners of each triangle; every second of a strip is turned over.
fn triangles(numbers: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let strip = numbers.windows(3).enumerate();
            strip.map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] }).collect()
        }
        Mode::TriangleFan => {
            numbers.get(1..).unwrap_or(&[]).windows(2).map(|t| [numbers[0], t[0], t[1]]).collect()
        }
        _ => numbers.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

#[cfg(test)]
#[path = "gltf_tests.rs"]
mod tests;
