//! The folder of an export: written whole or not at all, and read with every check sum.

use super::conformance::Conformance;
use super::description::{FileSum, MaterialDescription, is_description};
use super::shader::{self, ShaderLanguage, TextureLayout};
use super::{ExportedMaterial, engines, flat, ktx2, translation};
use crate::error::{self, Error, Result};
use crate::input;
use crate::output::{TEMPORARY, write_failed};
use crate::table::{ColorTable, TableHeader};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The file that makes a folder an export.
const MATERIAL: &str = "material.json";
const TABLE: &str = "table.json";
const TEXELS: &str = "table.ktx2";
const FLAT_TEXELS: &str = "table2d.exr";
const FLAT_FUNCTIONS: &str = "functions.exr";
const DIRECTIONS: &str = "conformance.csv";
const FUNCTIONS: &str = "functions.ktx2";
/// Names of the reading function in GLSL, GLSL ES, WGSL and HLSL.
const SHADERS: [&str; 4] = ["material.glsl", "material.es.glsl", "material.wgsl", "material.hlsl"];
/// Names of the function that reads plain images.
const FLAT_SHADERS: [&str; 4] =
    ["material2d.glsl", "material2d.es.glsl", "material2d.wgsl", "material2d.hlsl"];
/// Names of the function for Godot, Unity and Unreal.
const ENGINE_SHADERS: [&str; 3] = ["material.gdshader", "material.unity.hlsl", "material.ush"];
/// The files that the description has sums of, but for the shaders.
const DESCRIBED: [&str; 6] = [TABLE, TEXELS, FLAT_TEXELS, DIRECTIONS, FUNCTIONS, FLAT_FUNCTIONS];
/// Files of exports of former versions.
const FORMER: [&str; 1] = ["table.exr"];

/// Returns the names of the files that the description has sums of.
fn described() -> impl Iterator<Item = &'static str> {
    DESCRIBED.into_iter().chain(SHADERS).chain(FLAT_SHADERS).chain(ENGINE_SHADERS)
}

/// Fails if an export must not stand at `folder`: asked before long work whose result would be lost.
///
/// # Errors
/// A file, a folder with content that is no export, a folder above that does not exist or is not writable.
pub fn check_target(folder: &Path) -> Result<()> {
    match fs::symlink_metadata(folder) {
        Ok(there) if !there.is_dir() => {
            return Err(Error::usage("is not a folder", "give the export the name of a new folder")
                .at(folder.display()));
        }
        Ok(_) if !may_be_replaced(folder) => {
            return Err(Error::usage(
                "is a folder with other content, which stays",
                "give the export the name of a new folder",
            )
            .at(folder.display()));
        }
        _ => {}
    }
    draft_beside(folder).map(drop)
}

/// True if the folder is empty or an export, in whichever version, with nothing beside its files.
fn may_be_replaced(folder: &Path) -> bool {
    let Ok(entries) = fs::read_dir(folder) else { return false };
    let names: Vec<_> = entries.map(|entry| entry.map(|entry| entry.file_name())).collect();
    let is_ours =
        |name: &std::ffi::OsString| described().chain(FORMER).chain([MATERIAL]).any(|entry| name == entry);
    let describes = |text: String| serde_json::from_str(&text).is_ok_and(|value| is_description(&value));
    names.is_empty()
        || names.iter().all(|name| name.as_ref().is_ok_and(is_ours))
            && input::read_text(&folder.join(MATERIAL), "an export").is_ok_and(describes)
}

/// Makes a folder for the files beside `folder`; it goes with its value.
fn draft_beside(folder: &Path) -> Result<tempfile::TempDir> {
    if folder.file_name().is_none() {
        return Err(Error::usage(
            format!("'{}' names no folder", folder.display()),
            "give the export a name",
        ));
    }
    let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY);
    // The umask clears bits of this mode.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
    builder.tempdir_in(parent).map_err(|e| {
        Error::files(
            format!("cannot create a folder in {}: {}", parent.display(), error::cause(&e)),
            "create that folder, make it writable, or choose another one",
        )
        .caused_by(e)
        .at(folder.display())
    })
}

/// Writes `material` as the folder `folder`, described by `description`, to which the files are added. A former export there is replaced.
///
/// # Errors
/// Same as [`check_target`]; fails on a full disk too.
pub fn write(
    folder: &Path,
    material: &ExportedMaterial,
    description: &mut MaterialDescription,
) -> Result<()> {
    check_target(folder)?;
    let draft = draft_beside(folder)?;
    let mut add = |name: &str, bytes: Vec<u8>| {
        description.files.insert(name.to_owned(), FileSum::new(&bytes));
        put(&draft.path().join(name), &bytes, folder)
    };
    add(TABLE, json(&material.table.header)?)?;
    add(TEXELS, ktx2::write(&material.table))?;
    add(FLAT_TEXELS, flat::write(&material.table)?)?;
    add(DIRECTIONS, material.conformance.to_csv()?.into_bytes())?;
    let header = &material.table.header;
    add(FUNCTIONS, ktx2::write_functions(header))?;
    add(FLAT_FUNCTIONS, flat::write_functions(header)?)?;
    for (names, layout) in [(SHADERS, TextureLayout::Array), (FLAT_SHADERS, TextureLayout::Flat)] {
        let texts = [
            shader::write(header, ShaderLanguage::Glsl, layout),
            shader::write(header, ShaderLanguage::GlslEs, layout),
            translation::write_wgsl(header, layout)?,
            translation::write_hlsl(header, layout)?,
        ];
        names.into_iter().zip(texts).try_for_each(|(name, text)| add(name, text.into_bytes()))?;
    }
    let texts = [engines::write_godot(header), engines::UNITY.to_owned(), engines::write_unreal(header)?];
    ENGINE_SHADERS.into_iter().zip(texts).try_for_each(|(name, text)| add(name, text.into_bytes()))?;
    let text = description.to_text().map_err(not_written)?;
    put(&draft.path().join(MATERIAL), text.as_bytes(), folder)?;
    give_name(draft, folder)
}

fn put(path: &Path, bytes: &[u8], folder: &Path) -> Result<()> {
    let written = fs::File::create(path).and_then(|mut file| {
        std::io::Write::write_all(&mut file, bytes)?;
        file.sync_all()
    });
    written.map_err(|e| write_failed(folder, e))
}

/// Moves the finished `draft` to `folder`. A former export is moved away first, and back if the new one cannot take its place.
fn give_name(draft: tempfile::TempDir, folder: &Path) -> Result<()> {
    let failed = |e: std::io::Error| write_failed(folder, e);
    if folder.exists() {
        let former = draft_beside(folder)?;
        let away = former.path().join("former");
        fs::rename(folder, &away).map_err(failed)?;
        if let Err(e) = fs::rename(draft.path(), folder) {
            fs::rename(&away, folder).map_err(failed)?;
            return Err(failed(e));
        }
    } else {
        fs::rename(draft.path(), folder).map_err(failed)?;
    }
    // The folder has another name now, which is not to be removed; its former path is of no use.
    let _ = draft.keep();
    Ok(())
}

fn json(value: &impl serde::Serialize) -> Result<Vec<u8>> {
    let text = serde_json::to_vec_pretty(value);
    let mut text = text.map_err(not_written)?;
    text.push(b'\n');
    Ok(text)
}

fn not_written(e: serde_json::Error) -> Error {
    Error::bug(format!("the description cannot be written ({e})")).caused_by(e)
}

/// Reads an export.
pub struct ExportReader {
    folder: PathBuf,
    /// Its description.
    pub description: MaterialDescription,
}

impl ExportReader {
    /// Reads the description in `folder`.
    ///
    /// # Errors
    /// A folder that is no export, a damaged description, or one of a newer version.
    pub fn open(folder: &Path) -> Result<Self> {
        let path = folder.join(MATERIAL);
        let text = input::read_text(&path, "the folder of an export")?;
        let description = MaterialDescription::parse(&text).map_err(|e| e.at(path.display()))?;
        Ok(Self { folder: folder.to_owned(), description })
    }

    /// Returns the bytes of a file of the export.
    ///
    /// # Errors
    /// A file that is missing, truncated or damaged.
    pub fn file(&self, name: &str) -> Result<Vec<u8>> {
        let path = self.folder.join(name);
        let refused = |what: String| Error::input(what, "export the material again").at(path.display());
        let expected = self.description.files.get(name);
        let expected = expected.ok_or_else(|| refused("the description does not name it".to_owned()))?;
        let file = input::open(&path, "all files of an export", u64::MAX)?;
        let mut bytes = Vec::new();
        // One byte more than expected tells a longer file without reading it.
        file.take(expected.bytes.saturating_add(1))
            .read_to_end(&mut bytes)
            .map_err(|e| refused(format!("it cannot be read: {}", error::cause(&e))))?;
        let found = FileSum::new(&bytes);
        if found.bytes < expected.bytes {
            return Err(refused(format!("it is truncated: {} of {} bytes", found.bytes, expected.bytes)));
        }
        if found != *expected {
            return Err(refused("its check sum is not that of the description: it is damaged".to_owned()));
        }
        Ok(bytes)
    }

    /// Returns the colour table.
    ///
    /// # Errors
    /// Same as [`ExportReader::file`]; fails for numbers that no table has.
    pub fn table(&self) -> Result<ColorTable> {
        let path = self.folder.join(TABLE);
        let refused = |what: String| Error::input(what, "export the material again").at(path.display());
        let header: TableHeader = serde_json::from_slice(&self.file(TABLE)?)
            .map_err(|e| refused(format!("it is no description of a table ({e})")).caused_by(e))?;
        let texels = self.file(TEXELS)?;
        let levels = ktx2::read(&texels, &header).map_err(|e| e.at(self.folder.join(TEXELS).display()))?;
        ColorTable::from_parts(header, levels)
            .ok_or_else(|| refused("it describes no table that can be".to_owned()))
    }

    /// Returns the directions with their colours.
    ///
    /// # Errors
    /// Same as [`ExportReader::file`]; fails for text that is no such table.
    pub fn conformance(&self) -> Result<Conformance> {
        let path = self.folder.join(DIRECTIONS);
        let text = String::from_utf8(self.file(DIRECTIONS)?).map_err(|e| {
            Error::input(format!("it is not text ({e})"), "export the material again")
                .caused_by(e)
                .at(path.display())
        })?;
        Conformance::from_csv(&text).map_err(|e| e.at(path.display()))
    }

    /// Reads every file, and returns the directions with their colours.
    ///
    /// # Errors
    /// Same as the other functions.
    pub fn check(&self) -> Result<Conformance> {
        self.table()?;
        for name in described().filter(|name| ![TABLE, TEXELS, DIRECTIONS].contains(name)) {
            self.file(name)?;
        }
        self.conformance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::conformance::tests::{small_field, small_settings, small_table};
    use crate::export::description::VERSION;
    use std::sync::Arc;

    fn export(folder: &Path) -> Result<()> {
        let (conformance, table) = small_table();
        let material = ExportedMaterial { table, conformance };
        let mut description =
            MaterialDescription::new(&small_field(), &small_settings(), &material, String::new()).unwrap();
        write(folder, &material, &mut description)
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn an_export_comes_back_as_it_went_and_replaces_a_former_one() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("material");
        for _ in 0..2 {
            export(&folder).unwrap();
            let mut expected: Vec<&str> = described().chain([MATERIAL]).collect();
            expected.sort_unstable();
            assert_eq!(names(&folder), expected);
            assert_eq!(names(place.path()), ["material"]);
            let reader = ExportReader::open(&folder).unwrap();
            reader.check().unwrap();
            assert_eq!((reader.conformance().unwrap(), Arc::new(reader.table().unwrap())), small_table());
        }
    }

    #[test]
    fn folders_with_other_content_and_files_stay() {
        let place = tempfile::tempdir().unwrap();
        let (other, file, empty) =
            (place.path().join("other"), place.path().join("file"), place.path().join("empty"));
        fs::create_dir(&other).unwrap();
        fs::write(other.join("thesis.txt"), "x").unwrap();
        fs::write(&file, "x").unwrap();
        fs::create_dir(&empty).unwrap();
        assert!(export(&other).unwrap_err().to_string().contains("other content"));
        assert!(export(&file).unwrap_err().to_string().contains("not a folder"));
        assert!(export(&place.path().join("no/folder")).is_err());
        assert_eq!(
            (names(&other), names(place.path())),
            (vec!["thesis.txt".to_owned()], ["empty", "file", "other"].map(str::to_owned).to_vec())
        );
        export(&empty).unwrap();
        // Notes beside an export are no part of it.
        fs::write(empty.join("notes.txt"), "x").unwrap();
        assert!(export(&empty).unwrap_err().to_string().contains("other content"));
        assert!(empty.join("notes.txt").is_file());
    }

    #[test]
    fn a_truncated_damaged_or_newer_export_is_refused_with_the_reason() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("material");
        export(&folder).unwrap();
        let reason = |name: &str, change: &dyn Fn(&mut Vec<u8>)| {
            let sound = fs::read(folder.join(name)).unwrap();
            let mut bytes = sound.clone();
            change(&mut bytes);
            fs::write(folder.join(name), bytes).unwrap();
            let checked = ExportReader::open(&folder).and_then(|reader| reader.check());
            fs::write(folder.join(name), sound).unwrap();
            checked.unwrap_err().to_string()
        };
        for name in described() {
            let e = reason(name, &|bytes| bytes.truncate(bytes.len() / 2));
            assert!(e.contains("truncated") && e.contains(name), "{e}");
            let e = reason(name, &|bytes| {
                let middle = bytes.len() / 2;
                bytes[middle] ^= 1;
            });
            assert!(e.contains("damaged") && e.contains(name), "{e}");
            let e = reason(name, &|bytes| bytes.push(0));
            assert!(e.contains("damaged"), "{e}");
        }
        let e = reason(MATERIAL, &|bytes| bytes.truncate(100));
        assert!(e.contains("no description"), "{e}");
        let e = reason(MATERIAL, &|bytes| {
            let text = String::from_utf8(bytes.clone()).unwrap();
            *bytes = text
                .replace(&format!("\"version\": {VERSION}"), &format!("\"version\": {}", VERSION + 1))
                .into_bytes();
        });
        assert!(e.contains(&format!("version {}", VERSION + 1)) && e.contains("newer program"), "{e}");
        // Each byte of the description counts.
        let sound = fs::read(folder.join(MATERIAL)).unwrap();
        for place in 0..sound.len() {
            let mut changed = sound.clone();
            changed[place] ^= 1;
            fs::write(folder.join(MATERIAL), changed).unwrap();
            let e = ExportReader::open(&folder).err().unwrap_or_else(|| panic!("byte {place}")).to_string();
            assert!(e.contains(MATERIAL) || e.contains("it is no description"), "byte {place}: {e}");
        }
        fs::write(folder.join(MATERIAL), &sound).unwrap();
        fs::remove_file(folder.join(TEXELS)).unwrap();
        let e = ExportReader::open(&folder).unwrap().check().unwrap_err().to_string();
        assert!(e.contains("no such file"), "{e}");
    }
}
