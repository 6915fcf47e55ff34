//! PLY files (Stanford polygons), of text and binary: positions, normals, texture coordinates and faces; colours of vertices are left out.

use super::corner::Corner;
use super::mesh::{MAX_TRIANGLES, Mesh};
use super::polygon::PolygonCutter;
use crate::error::{Error, Result};
use crate::memory;
use crate::task::Task;
use glam::Vec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

/// Memory of a triangle while the mesh is built, as of OBJ files.
const BYTES_PER_TRIANGLE: u64 = 700;
/// Memory of a byte of a line while it is split into words, of which the shortest has a byte and a space.
const BYTES_PER_TEXT: u64 = 8;
/// Faces between two reports of progress: some milliseconds.
const REPORT_EVERY: usize = 1 << 16;
/// Names of the coordinates of a texture, in the order of preference.
const TEXTURES: [[&str; 2]; 4] =
    [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];

/// Reads the mesh in the `bytes` of a PLY file, with reports to the task.
///
/// # Errors
/// Fails for bytes that are no PLY or are cut short, for a file without faces, for an index of no vertex, for more than [`MAX_TRIANGLES`], and for a
/// cancelled task.
pub fn load(bytes: &[u8], task: &Task) -> Result<Mesh> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<OtherElement>::new().read_header(&mut reader).map_err(|e| damaged(bytes, e))?;
    let payload = reader.get_ref().len();
    check_elements(&header, payload)?;
    let [vertices, faces] = read_payload(&mut reader, &header).map_err(|e| damaged(bytes, e))?;
    task.check()?;
    let names = header.elements.get("vertex").map(|element| &element.properties);
    let has = |name: &str| names.is_some_and(|names| names.contains_key(name));
    if !["x", "y", "z"].iter().all(|name| has(name)) {
        return Err(Error::input(
            "the vertices of the PLY have no x, y and z",
            "export the mesh as PLY again",
        ));
    }
    let has_normals = ["nx", "ny", "nz"].iter().all(|name| has(name));
    let texture = TEXTURES.iter().position(|names| names.iter().all(|name| has(name)));
    let corner = |vertex: &PlyElement| Corner {
        position: vertex.position,
        normal: has_normals.then_some(vertex.normal),
        uv: texture.map(|which| vertex.textures[which]),
    };
    Mesh::build(cut_faces(&vertices, &faces, corner, task)?, task)
}

/// Returns the error for a file that the parser does not read; its causes quote whole lines.
fn damaged(bytes: &[u8], e: ParseError) -> Error {
    if !bytes.starts_with(b"ply") {
        return Error::input("this is not a PLY", "export the mesh as PLY again").caused_by(e);
    }
    let place = e.line().map_or(String::new(), |line| format!("line {line}: "));
    let what = format!("{place}the PLY is damaged or cut short");
    Error::input(what, "export it again").caused_by(e)
}

/// Fails if the elements of the header need more bytes than the `payload` has, or more memory than there is.
fn check_elements(header: &Header, payload: usize) -> Result<()> {
    let mut least = 0u128;
    for element in header.elements.values() {
        let size = least_size(element, header.encoding);
        if size == 0 && element.count > 0 {
            return Err(Error::input(
                format!(
                    "the {} elements `{}` of the PLY have no properties",
                    element.count,
                    shown(&element.name)
                ),
                "export the mesh as PLY again",
            ));
        }
        least += size as u128 * element.count as u128;
    }
    // The last line may lack its end.
    if least > payload as u128 + 1 {
        return Err(Error::input(
            format!("the PLY has {payload} bytes of data where {least} or more belong"),
            "the file may be cut short; export it again",
        ));
    }
    let count = |name: &str| header.elements.get(name).map_or(0, |element| element.count);
    if count("face") == 0 {
        return Err(Error::input(
            "the PLY has no faces",
            "export it with faces; a point cloud has no surface",
        ));
    }
    if count("face") > MAX_TRIANGLES {
        return Err(Error::input(
            format!("the mesh has {} faces, more than {MAX_TRIANGLES}", count("face")),
            "simplify it first",
        ));
    }
    let elements = (count("vertex") as u64).saturating_add(count("face") as u64);
    let elements = elements.saturating_mul(size_of::<PlyElement>() as u64);
    let triangles = (count("face") as u64).saturating_mul(BYTES_PER_TRIANGLE);
    let text = (payload as u64).saturating_mul(BYTES_PER_TEXT);
    memory::ensure_room(elements.saturating_add(triangles).saturating_add(text), "the triangles of the mesh")
}

/// Returns the beginning of a name in an error.
fn shown(name: &str) -> String {
    /// Most characters of a name.
    const SHOWN: usize = 40;
    name.chars().take(SHOWN).collect()
}

/// Returns the least length of an element \[bytes\]: in text, of one digit and its space or end of line for each number.
fn least_size(element: &ElementDef, encoding: Encoding) -> usize {
    let size = |kind: &ScalarType| match kind {
        _ if encoding == Encoding::Ascii => 2,
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let sizes = element.properties.values().map(|property| match &property.data_type {
        PropertyType::Scalar(kind) | PropertyType::List(kind, _) => size(kind),
    });
    sizes.sum()
}

/// Reads the elements in the order of the file; returns vertices and faces, and passes over the rest.
fn read_payload(
    reader: &mut Reader<&[u8]>,
    header: &Header,
) -> std::result::Result<[Vec<PlyElement>; 2], ParseError> {
    let mut kept = [Vec::new(), Vec::new()];
    for (name, element) in &header.elements {
        let place = match name.as_str() {
            "vertex" => 0,
            "face" => 1,
            _ => {
                Parser::<OtherElement>::new().read_payload_for_element(reader, element, header)?;
                continue;
            }
        };
        kept[place] = Parser::<PlyElement>::new().read_payload_for_element(reader, element, header)?;
    }
    Ok(kept)
}

/// Cuts the faces into triangles.
fn cut_faces(
    vertices: &[PlyElement],
    faces: &[PlyElement],
    corner: impl Fn(&PlyElement) -> Corner,
    task: &Task,
) -> Result<Vec<[Corner; 3]>> {
    let corners = |face: &PlyElement| face.indices.len().saturating_sub(2);
    let count: usize = faces.iter().map(corners).sum();
    if count > MAX_TRIANGLES {
        return Err(Error::input(
            format!("the mesh has {count} triangles, more than {MAX_TRIANGLES}"),
            "simplify it first",
        ));
    }
    memory::ensure_room(count as u64 * BYTES_PER_TRIANGLE, "the triangles of the mesh")?;
    let mut cutter = PolygonCutter::default();
    let mut triangles = Vec::with_capacity(count);
    let mut positions = Vec::new();
    for (number, face) in faces.iter().enumerate() {
        let place = || format!("face {}", number + 1);
        let vertex = |index: &i64| {
            usize::try_from(*index).ok().and_then(|index| vertices.get(index)).ok_or_else(|| {
                let what = format!("it asks for vertex {index} of {}, counted from 0", vertices.len());
                Error::input(what, "the file may be damaged; export it again").at(place())
            })
        };
        let face: Vec<&PlyElement> = face.indices.iter().map(vertex).collect::<Result<_>>()?;
        if face.len() < 3 {
            let what = format!("it has {} corners", face.len());
            return Err(Error::input(what, "give faces 3 corners or more").at(place()));
        }
        positions.clear();
        positions.extend(face.iter().map(|vertex| Vec3::from(vertex.position).as_dvec3()));
        let numbers = cutter.cut(&positions).map_err(|e| e.at(place()))?;
        triangles.extend(numbers.chunks_exact(3).map(|t| [0, 1, 2].map(|k| corner(face[t[k] as usize]))));
        if number.is_multiple_of(REPORT_EVERY) {
            task.report("cutting faces into triangles", number, faces.len())?;
        }
    }
    Ok(triangles)
}

/// Vertex or face.
#[derive(Default)]
struct PlyElement {
    position: [f32; 3],
    normal: [f32; 3],
    /// Texture coordinates by each of [`TEXTURES`].
    textures: [[f32; 2]; TEXTURES.len()],
    indices: Vec<i64>,
}

impl PropertyAccess for PlyElement {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if matches!(name, "vertex_indices" | "vertex_index") {
            return match whole_numbers(property) {
                Some(indices) => {
                    self.indices = indices;
                    PropertyAccessResult::Set
                }
                None => PropertyAccessResult::UnsupportedType,
            };
        }
        let Some(number) = property.to_f32_lossy() else { return PropertyAccessResult::Ignored };
        let texture = || {
            TEXTURES
                .iter()
                .enumerate()
                .find_map(|(i, names)| Some((i, names.iter().position(|known| *known == name)?)))
        };
        match name {
            "x" => self.position[0] = number,
            "y" => self.position[1] = number,
            "z" => self.position[2] = number,
            "nx" => self.normal[0] = number,
            "ny" => self.normal[1] = number,
            "nz" => self.normal[2] = number,
            _ => match texture() {
                Some((which, axis)) => self.textures[which][axis] = number,
                None => return PropertyAccessResult::Ignored,
            },
        }
        PropertyAccessResult::Set
    }
}

/// Returns a list of whole numbers; `None` for other properties.
fn whole_numbers(property: Property) -> Option<Vec<i64>> {
    fn wide<T: Into<i64>>(list: Vec<T>) -> Vec<i64> {
        list.into_iter().map(Into::into).collect()
    }
    Some(match property {
        Property::ListChar(list) => wide(list),
        Property::ListUChar(list) => wide(list),
        Property::ListShort(list) => wide(list),
        Property::ListUShort(list) => wide(list),
        Property::ListInt(list) => wide(list),
        Property::ListUInt(list) => wide(list),
        _ => return None,
    })
}

/// Element of another kind, as an edge or a material, of which nothing is kept.
struct OtherElement;

impl PropertyAccess for OtherElement {
    fn new() -> Self {
        Self
    }
}

#[cfg(test)]
mod tests {
    use super::super::mesh::tests::assert_sound;
    use super::*;

    const HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty double z\nproperty float s\nproperty float t\nproperty uchar red\nelement edge 1\nproperty int a\nelement face 1\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n";

    fn text() -> Vec<u8> {
        let rows = "0 0 0 0 0 255\n1 0 0 1 0 0\n1 1 0 1 1 7\n0 1 0 0 1 8\n5\n1 4 0 1 2 3\n";
        format!("ply\nformat ascii 1.0\ncomment by hand\n{HEADER}{rows}").into_bytes()
    }

    fn binary(is_big: bool) -> Vec<u8> {
        let order = if is_big { "big" } else { "little" };
        let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\n{HEADER}").into_bytes();
        let mut put = |mut number: Vec<u8>| {
            if is_big {
                number.reverse();
            }
            bytes.extend(number);
        };
        for [x, y] in [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            put(x.to_le_bytes().to_vec());
            put(y.to_le_bytes().to_vec());
            put(0f64.to_le_bytes().to_vec());
            put(x.to_le_bytes().to_vec());
            put(y.to_le_bytes().to_vec());
            put(vec![9]);
        }
        put(5i32.to_le_bytes().to_vec());
        put(vec![1]);
        put(vec![4]);
        (0..4i32).for_each(|i| put(i.to_le_bytes().to_vec()));
        bytes
    }

    fn read_mesh(bytes: &[u8]) -> Result<Mesh> {
        load(bytes, &Task::silent())
    }

    #[test]
    fn text_and_both_orders_of_bytes_are_the_same_mesh() {
        let mesh = read_mesh(&text()).unwrap();
        assert_sound(&mesh);
        assert_eq!((mesh.triangle_count(), mesh.vertices().len()), (2, 4));
        for vertex in mesh.vertices() {
            assert_eq!(vertex.uv, [vertex.position[0], vertex.position[1]]);
            assert_eq!((vertex.normal, vertex.tangent), ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]));
        }
        assert_eq!(read_mesh(&binary(false)).unwrap(), mesh);
        assert_eq!(read_mesh(&binary(true)).unwrap(), mesh);
    }

    #[test]
    fn files_cut_anywhere_are_refused() {
        for whole in [text(), binary(false), binary(true)] {
            for length in 0..whole.len() - 1 {
                let e = read_mesh(&whole[..length]).map(|_| ()).unwrap_err().to_string();
                assert!(e.contains("; ") && !e.contains('\n'), "{length}: {e}");
            }
        }
    }

    #[test]
    fn sizes_that_lie_are_refused_before_memory_is_taken() {
        let text = String::from_utf8(text()).unwrap();
        for (old, new, said) in [
            ("vertex 4", "vertex 99999999999999", "bytes of data where"),
            ("vertex 4", "vertex 3", "line "),
            ("edge 1\nproperty int a", "edge 4000000000", "no properties"),
            ("face 1", "face 0", "no faces"),
            ("1 4 0 1 2 3", "1 4 0 1 2 4", "vertex 4 of 4"),
            ("1 4 0 1 2 3", "1 4 0 1 2 -1", "vertex -1 of 4"),
            ("1 4 0 1 2 3", "1 2 0 1", "2 corners"),
            ("1 4 0 1 2 3", "1 4000000000 0 1 2 3", "line "),
            ("property float x", "property float w", "no x, y and z"),
            ("list uchar int", "list uchar float", "damaged"),
            ("0 0 0 0 0 255", "1e39 0 0 0 0 255", "not finite"),
            ("0 0 0 0 0 255", "nan 0 0 0 0 255", "damaged"),
        ] {
            let changed = text.replacen(old, new, 1);
            assert_ne!(changed, text, "{old}");
            let e = read_mesh(changed.as_bytes()).map(|_| ()).unwrap_err().to_string();
            assert!(e.contains(said) && e.contains("; ") && !e.contains('\n'), "{new}: {e}");
        }
    }
}
