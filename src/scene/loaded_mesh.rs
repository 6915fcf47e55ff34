//! A mesh as it comes from a file, and the bytes of mesh files.

use super::mesh::Mesh;
use super::mesh_colors::MeanColor;
use crate::error::{self, Error, Result};
use crate::input;
use crate::memory;
use glam::Vec3;
use std::io::Read;
use std::path::Path;

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

/// Reads the file, if it is a plain one and not too large.
///
/// # Errors
/// Fails for a file that cannot be read, is not a plain file, or is larger than [`MAX_BYTES`].
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
