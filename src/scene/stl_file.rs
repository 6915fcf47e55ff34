//! STL files, of text and binary. Normals of their facets are left out: those of the mesh are smooth, as of all meshes without normals of corners.

use super::corner::Corner;
use super::mesh::{MAX_TRIANGLES, Mesh};
use crate::error::{Error, Result};
use crate::memory;
use crate::task::Task;
use std::io::Cursor;

/// Length of the comment, and of it with the number of triangles, at the beginning of a binary file \[bytes\].
const COMMENT: usize = 80;
const HEADER: usize = COMMENT + 4;
/// Length of a triangle in a binary file \[bytes\].
const TRIANGLE: usize = 50;
/// Least length of a triangle in a file of text \[bytes\]: seven lines of their shortest words.
const SHORTEST_TEXT: usize = 90;
/// First word of a file of text, and of each solid in it.
const SOLID: &[u8] = b"solid";
/// Triangles between two reports of progress: some milliseconds.
const REPORT_EVERY: usize = 1 << 16;
/// Memory of a triangle while the mesh is built, as of OBJ files.
const BYTES_PER_TRIANGLE: u64 = 700;

/// Reads the mesh in the `bytes` of an STL file, with reports to the task.
///
/// # Errors
/// Fails for bytes that are no STL or are cut short, for more than [`MAX_TRIANGLES`], and for a cancelled task.
pub fn load(bytes: Vec<u8>, task: &Task) -> Result<Mesh> {
    let mut triangles = Vec::new();
    match binary_count(&bytes) {
        Some(count) => {
            check_count(count)?;
            memory::ensure_room(count as u64 * BYTES_PER_TRIANGLE, "the triangles of the mesh")?;
            read_binary(bytes, count, task, &mut triangles)?;
        }
        None if is_text(&bytes) => {
            let most = (bytes.len() / SHORTEST_TEXT).min(MAX_TRIANGLES) as u64;
            memory::ensure_room(bytes.len() as u64 + most * BYTES_PER_TRIANGLE, "the triangles of the mesh")?;
            for solid in solids(&bytes) {
                read_text(solid, task, &mut triangles)?;
            }
        }
        None => return Err(no_stl(&bytes)),
    }
    Mesh::build(triangles, task)
}

/// Returns the number of triangles if `bytes` are as long as the binary file that they would be. Some binary files begin with `solid`, too.
fn binary_count(bytes: &[u8]) -> Option<usize> {
    let count = u32::from_le_bytes(bytes.get(COMMENT..HEADER)?.try_into().ok()?);
    let length = u64::from(count) * TRIANGLE as u64 + HEADER as u64;
    (length == bytes.len() as u64).then_some(count as usize)
}

fn is_text(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().get(..SOLID.len()).is_some_and(|word| word.eq_ignore_ascii_case(SOLID))
}

fn no_stl(bytes: &[u8]) -> Error {
    match bytes.get(COMMENT..HEADER).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes) {
        Some(count) => Error::input(
            format!("as an STL it would have {count} triangles, and its length is another"),
            "the file may be cut short; export it again",
        ),
        None => Error::input("this is not an STL", "export the mesh as STL again"),
    }
}

fn check_count(count: usize) -> Result<()> {
    if count <= MAX_TRIANGLES {
        return Ok(());
    }
    Err(Error::input(
        format!("the mesh has {count} triangles, more than {MAX_TRIANGLES}"),
        "simplify it first",
    ))
}

/// Reads the `count` triangles of a binary file.
fn read_binary(
    mut bytes: Vec<u8>,
    count: usize,
    task: &Task,
    triangles: &mut Vec<[Corner; 3]>,
) -> Result<()> {
    // A comment that begins with `solid` would pass for text.
    bytes[..COMMENT].fill(0);
    triangles.reserve_exact(count);
    read(Cursor::new(&bytes[..]), (count, task), triangles)
}

/// Reads a solid of text, from its first line on.
fn read_text(solid: &[u8], task: &Task, triangles: &mut Vec<[Corner; 3]>) -> Result<()> {
    // The reader knows lower case and a first line with a name alone.
    let start = solid.iter().position(|b| *b == b'\n').map_or(solid.len(), |end| end + 1);
    let mut text = b"solid mesh\n".to_vec();
    text.extend(solid[start..].iter().map(u8::to_ascii_lowercase));
    read(Cursor::new(&text[..]), (solid.len() / SHORTEST_TEXT, task), triangles)
}

/// Adds the triangles of `stl`, about `expected` of them, with reports to the task.
fn read(
    mut stl: Cursor<&[u8]>,
    (expected, task): (usize, &Task),
    triangles: &mut Vec<[Corner; 3]>,
) -> Result<()> {
    let damaged = |number: usize, e: std::io::Error| {
        // Causes of several lines quote the file.
        let what = format!("triangle {} cannot be read", number + 1);
        Error::input(what, "the file may be cut short; export it again").caused_by(e)
    };
    let reader = stl_io::create_stl_reader(&mut stl).map_err(|e| damaged(triangles.len(), e))?;
    for triangle in reader {
        let triangle = triangle.map_err(|e| damaged(triangles.len(), e))?;
        let corner = |k: usize| Corner { position: triangle.vertices[k].0, normal: None, uv: None };
        triangles.push([0, 1, 2].map(corner));
        check_count(triangles.len())?;
        if triangles.len().is_multiple_of(REPORT_EVERY) {
            task.report("reading triangles", triangles.len(), expected.max(triangles.len()))?;
        }
    }
    Ok(())
}

/// Returns the solids of a file of text, each from its line `solid` on.
fn solids(text: &[u8]) -> Vec<&[u8]> {
    let mut starts = Vec::new();
    let mut place = 0;
    for line in text.split_inclusive(|b| *b == b'\n') {
        if is_text(line) {
            starts.push(place);
        }
        place += line.len();
    }
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    starts.iter().zip(ends).map(|(start, end)| &text[*start..end]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::mesh::tests::assert_sound;
    use super::*;

    /// Corners of two triangles of a square.
    const SQUARE: [[[f32; 3]; 3]; 2] = [
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
        [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
    ];

    fn binary(comment: &[u8]) -> Vec<u8> {
        let mut bytes = comment.to_vec();
        bytes.resize(COMMENT, b' ');
        bytes.extend((SQUARE.len() as u32).to_le_bytes());
        for triangle in SQUARE {
            bytes.extend([0; 12]);
            bytes.extend(triangle.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    fn text() -> String {
        let solid = |[a, b, c]: [[f32; 3]; 3]| {
            let vertex = |[x, y, z]: [f32; 3]| format!("      vertex {x} {y:e} {z}\r\n");
            let vertices = [a, b, c].map(vertex).concat();
            format!(
                "solid\r\n  facet normal 0 0 1\r\n    outer loop\r\n{vertices}    endloop\r\n  endfacet\r\nendsolid\r\n"
            )
        };
        SQUARE.map(solid).concat()
    }

    fn read_mesh(bytes: &[u8]) -> Result<Mesh> {
        load(bytes.to_vec(), &Task::silent())
    }

    #[test]
    fn text_and_binary_are_the_same_mesh() {
        let mesh = read_mesh(&binary(b"solid in spite of its name")).unwrap();
        assert_sound(&mesh);
        assert_eq!((mesh.triangle_count(), mesh.vertices().len()), (2, 4));
        assert!(mesh.vertices().iter().all(|v| v.normal == [0.0, 0.0, 1.0]));
        for same in [binary(b"made by hand"), text().into_bytes(), text().to_uppercase().into_bytes()] {
            assert_eq!(read_mesh(&same).unwrap(), mesh);
        }
    }

    #[test]
    fn files_cut_anywhere_are_refused_or_have_less() {
        for whole in [binary(b""), text().into_bytes()] {
            for length in 0..whole.len() {
                match read_mesh(&whole[..length]) {
                    Ok(mesh) => assert!(mesh.triangle_count() <= 2),
                    Err(e) => {
                        let e = e.to_string();
                        assert!(e.contains("; ") && !e.contains('\n'), "{length}: {e}");
                    }
                }
            }
        }
    }

    #[test]
    fn damage_and_sizes_that_lie_are_refused() {
        let mut huge = binary(b"");
        huge[COMMENT..HEADER].fill(0xff);
        assert!(read_mesh(&huge).unwrap_err().to_string().contains("4294967295 triangles"));
        let mut not_finite = binary(b"");
        not_finite[HEADER + 12..HEADER + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(read_mesh(&not_finite).unwrap_err().to_string().contains("triangle 1"));
        let damaged = text().replacen("vertex", "vortex", 1);
        assert!(read_mesh(damaged.as_bytes()).unwrap_err().to_string().contains("triangle 1 cannot be read"));
    }
}
