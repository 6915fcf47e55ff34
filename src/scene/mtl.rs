//! Material files of Wavefront OBJ (`.mtl`): the diffuse colour `Kd` of each material. Textures and all else are left out.

use crate::error::{Error, Result};
use crate::input;
use glam::Vec3;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Component, Path};

/// Largest file \[bytes\]: that of ten thousand materials has a tenth of it.
const MAX_BYTES: u64 = 16 << 20;

/// Returns the colours of the materials in the files `names`, which lie in `folder` or below it, and notes on files that were not read.
pub(super) fn read(names: &[String], folder: &Path) -> (BTreeMap<String, Vec3>, Vec<String>) {
    let mut colors = BTreeMap::new();
    let mut notes = Vec::new();
    for name in names {
        match text_of(name, folder) {
            Ok(text) => colors.extend(parse(&text)),
            Err(e) => notes.push(format!("the colours of the file of materials are left out: {e}")),
        }
    }
    (colors, notes)
}

/// Reads the text of the file `name` in `folder`. A file elsewhere is not opened: nobody has named it but the mesh.
fn text_of(name: &str, folder: &Path) -> Result<String> {
    const EXPECTED: &str = "the .mtl file that the mesh names, beside the mesh";
    let path = Path::new(name);
    let is_below = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if !is_below {
        let what = "it lies in another folder than the mesh";
        return Err(Error::input(what, format!("give {EXPECTED}")).at(name));
    }
    let mut bytes = Vec::new();
    let file = input::open(&folder.join(path), EXPECTED, MAX_BYTES)?;
    file.take(MAX_BYTES)
        .read_to_end(&mut bytes)
        .map_err(|e| Error::files("it cannot be read", format!("give {EXPECTED}")).caused_by(e).at(name))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Returns the colours of the materials in the `text` of a file.
fn parse(text: &str) -> BTreeMap<String, Vec3> {
    let mut colors = BTreeMap::new();
    let mut name = None;
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("newmtl") => name = Some(words.collect::<Vec<_>>().join(" ")),
            Some("Kd") => {
                let color = color(&words.collect::<Vec<_>>());
                if let (Some(name), Some(color)) = (&name, color) {
                    colors.insert(name.clone(), color);
                }
            }
            _ => {}
        }
    }
    colors
}

/// Returns the colour `r g b`, or `r` for a grey one, within 0 to 1; `None` for other forms, as `spectral` and `xyz`.
fn color(words: &[&str]) -> Option<Vec3> {
    let numbers: Option<Vec<f32>> =
        words.iter().take(3).map(|word| word.parse().ok().filter(|x: &f32| x.is_finite())).collect();
    let color = match numbers?.as_slice() {
        [grey] => Vec3::splat(*grey),
        [r, g, b] => Vec3::new(*r, *g, *b),
        _ => return None,
    };
    Some(color.clamp(Vec3::ZERO, Vec3::ONE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_those_of_their_materials() {
        let text = "# by hand\r\nKd 1 1 1\nnewmtl dark red\nNs 10\nKd 0.5 0.1 0.02\nmap_Kd a.png\nnewmtl grey\n Kd 0.25\nnewmtl odd\nKd spectral a.rfl\nnewmtl bright\nKd 2 -1 0.5 # much\nnewmtl nan\nKd nan 0 0\nnewmtl\n";
        let colors = parse(text);
        assert_eq!(colors.len(), 3, "{colors:?}");
        assert_eq!(colors["dark red"], Vec3::new(0.5, 0.1, 0.02));
        assert_eq!(colors["grey"], Vec3::splat(0.25));
        assert_eq!(colors["bright"], Vec3::new(1.0, 0.0, 0.5));
    }

    #[test]
    fn files_elsewhere_and_missing_ones_are_told() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.mtl"), "newmtl a\nKd 0.1 0.2 0.3\n").unwrap();
        let names = ["./a.mtl", "../a.mtl", "/etc/passwd", "b.mtl"].map(str::to_owned);
        let (colors, notes) = read(&names, folder.path());
        assert_eq!(colors.len(), 1);
        assert_eq!(notes.len(), 3, "{notes:?}");
        assert!(notes[1].contains("another folder") && notes[2].contains("no such file"), "{notes:?}");
    }
}
