//! Names for saved pictures and recordings.

use std::path::{Path, PathBuf};

/// Returns the first path of `diffract-001`, `diffract-002` … in `folder` that exists neither as PNG nor as EXR,
/// without extension.
pub fn free_name(folder: &Path) -> PathBuf {
    let name = |number: u32| folder.join(format!("diffract-{number:03}"));
    let free = |path: &PathBuf| ["png", "exr"].iter().all(|e| !path.with_extension(e).exists());
    (1..).map(name).find(free).unwrap_or_else(|| name(0))
}

/// Returns the first path of `diffract-turn-001`, `diffract-turn-002` … in `folder` that does not exist.
pub fn free_folder(folder: &Path) -> PathBuf {
    let name = |number: u32| folder.join(format!("diffract-turn-{number:03}"));
    (1..).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_free_where_neither_a_png_nor_an_exr_has_it() {
        let folder = tempfile::tempdir().unwrap();
        assert!(free_name(folder.path()).ends_with("diffract-001"));
        std::fs::write(folder.path().join("diffract-001.exr"), "x").unwrap();
        assert!(free_name(folder.path()).ends_with("diffract-002"));
        std::fs::write(folder.path().join("diffract-002.png"), "x").unwrap();
        assert!(free_name(folder.path()).ends_with("diffract-003"));
    }
}
