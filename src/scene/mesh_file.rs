//! Mesh files of all formats, told apart by their extensions.

use super::loaded_mesh::{LoadedMesh, read};
use super::up::Up;
use super::{gltf_file, obj, ply_file, stl_file};
use crate::error::{Error, Result};
use crate::task::Task;
use std::path::Path;

/// Extensions of mesh files.
pub const EXTENSIONS: [&str; 5] = ["obj", "gltf", "glb", "ply", "stl"];

/// Returns the extension of `path` in lower case, if it is that of a mesh.
pub fn extension(path: &Path) -> Option<&'static str> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    EXTENSIONS.into_iter().find(|known| *known == extension)
}

/// Returns the axis that points up in files of this name unless the user names another: z in those of scanners and of CAD, y in those of modelling programs.
pub fn usual_up(path: &Path) -> Up {
    match extension(path) {
        Some("ply" | "stl") => Up::Z,
        _ => Up::Y,
    }
}

/// Reads the mesh in the file at `path`, or only the `part` of this name, with reports to the task.
///
/// # Errors
/// A file that cannot be read, is not a plain file, is too large or is damaged; a part that it does not have. The error names the file.
/// Also a cancelled task.
pub(super) fn load(path: &Path, part: Option<&str>, task: &Task) -> Result<LoadedMesh> {
    let bytes = read(path)?;
    let loaded = match extension(path) {
        Some("gltf" | "glb") => gltf_file::load(&bytes, path.parent().unwrap_or(Path::new("")), part, task),
        Some("ply") => no_part(part).and_then(|()| ply_file::load(&bytes, task)).map(LoadedMesh::new),
        Some("stl") => no_part(part).and_then(|()| stl_file::load(bytes, task)).map(LoadedMesh::new),
        _ => obj::load(&bytes, path, part, task),
    };
    loaded.map_err(|e| e.at(path.display()))
}

/// Fails if a `part` is named.
fn no_part(part: Option<&str>) -> Result<()> {
    part.map_or(Ok(()), |part| {
        Err(Error::input(
            format!("files of this format name no parts, so that there is no `{part}`"),
            "leave `part` away, or export the mesh as OBJ or glTF",
        ))
    })
}
