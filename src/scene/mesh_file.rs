//! Mesh files of all formats, told apart by their extensions.

use super::mesh::Mesh;
use super::mesh_colors::MeanColor;
use super::object::Up;
use super::{gltf_file, obj, ply_file, stl_file};
use crate::error::{self, Error, Result};
use crate::input;
use crate::memory;
use crate::task::Task;
use glam::Vec3;
use std::io::Read;
use std::path::Path;

/// Extensions of mesh files.
pub const EXTENSIONS: [&str; 5] = ["obj", "gltf", "glb", "ply", "stl"];

/// Largest file \[bytes\].
pub const MAX_BYTES: u64 = 512 << 20;

/// Mesh of a file with what the file says beside it.
#[derive(Debug)]
pub(super) struct LoadedMesh {
    pub mesh: Mesh,
    /// Colour of its materials, linear sRGB; `None` if it names none.
    pub color: Option<Vec3>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl LoadedMesh {
    /// Returns a mesh without a colour.
    pub fn new(mesh: Mesh) -> Self {
        Self { mesh, color: None, notes: Vec::new() }
    }

    /// Sets the colour, and notes if it is the mean of several.
    pub fn color(&mut self, mean: Option<MeanColor>) {
        let Some(MeanColor { color, colors }) = mean else { return };
        self.color = Some(color);
        if colors > 1 {
            self.notes.push(format!(
                "the materials have {colors} colours, and their mean is the pigment; `part` of a scene file selects a material"
            ));
        }
    }
}

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
/// A file that cannot be read, is not a plain file, is larger than [`MAX_BYTES`] or is damaged; a part that it does not have. The error names the file.
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

/// Reads the file, if it is a plain one and not too large.
pub(super) fn read(path: &Path) -> Result<Vec<u8>> {
    let file =
        input::open(path, "a mesh (.obj, .gltf, .glb, .ply, .stl), or the name of a scene", MAX_BYTES)?;
    let length = file.metadata().map_or(0, |about| about.len());
    memory::ensure_room(length, "the file of the mesh").map_err(|e| e.at(path.display()))?;
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    // The file may grow while it is read.
    file.take(MAX_BYTES).read_to_end(&mut bytes).map_err(|e| {
        Error::files(format!("it cannot be read: {}", error::cause(&e)), "check the disk")
            .caused_by(e)
            .at(path.display())
    })?;
    Ok(bytes)
}
