//! Result files that appear whole or not at all: written beside their target, then renamed.

use crate::error::{Error, Result};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// How the names of files begin that are still being written.
pub const TEMPORARY: &str = ".diffract-";

/// Writes the file `path` through `write`, which gets a buffered, seekable writer.
///
/// The bytes go to a temporary file in the same folder, which is renamed to `path` when all of them are on disk. A
/// failure leaves a former file as it was and nothing new behind. A link is followed; the new file has the permissions
/// that the umask gives to any new file.
///
/// # Errors
/// Whatever `write` returns; a folder that is missing or not writable; a target that is a folder or a device.
pub fn write_atomically<T>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<T>,
) -> Result<T> {
    let target = resolve(path)?;
    let mut temporary = temporary_beside(&target).map_err(|e| e.at(path.display()))?;
    let mut writer = BufWriter::new(temporary.as_file_mut());
    let value = write(&mut writer)?;
    writer.flush().map_err(|e| write_failed(path, &e))?;
    drop(writer);
    temporary.as_file().sync_all().map_err(|e| write_failed(path, &e))?;
    temporary.persist(&target).map_err(|e| write_failed(path, &e.error))?;
    Ok(value)
}

/// Fails where [`write_atomically`] would: asked before long work whose result would be lost.
///
/// # Errors
/// As [`write_atomically`]. A disk that fills up in between is not foreseen.
pub fn check(path: &Path) -> Result<()> {
    temporary_beside(&resolve(path)?).map(drop).map_err(|e| e.at(path.display()))
}

/// A temporary file in the folder of `target`, gone with its value.
fn temporary_beside(target: &Path) -> Result<tempfile::NamedTempFile> {
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    new_file().tempfile_in(folder).map_err(|e| cannot_create(&e, folder))
}

/// The error for a write to `path` that the system refused.
pub fn write_failed(path: &Path, cause: &io::Error) -> Error {
    Error::failed(format!("cannot write: {cause}"), "check the free space and the permissions")
        .at(path.display())
}

/// The file that `path` means, links followed, unless it is something that must not be replaced.
fn resolve(path: &Path) -> Result<PathBuf> {
    let ends_as_a_folder = path.to_string_lossy().ends_with(std::path::is_separator);
    if path.file_name().is_none() || ends_as_a_folder {
        return Err(Error::usage(
            format!("'{}' names no file", path.display()),
            "give the output a file name",
        ));
    }
    match fs::metadata(path) {
        Ok(there) if there.is_dir() => {
            Err(Error::usage(format!("{}: is a folder", path.display()), "give the output a file name in it"))
        }
        Ok(there) if !there.is_file() => Err(Error::usage(
            format!("{}: is not a regular file and would be replaced", path.display()),
            "give the output another name",
        )),
        Ok(_) => path.canonicalize().map_err(|e| write_failed(path, &e)),
        Err(_) => Ok(path.to_path_buf()),
    }
}

fn cannot_create(cause: &io::Error, folder: &Path) -> Error {
    let folder = folder.display();
    match cause.kind() {
        io::ErrorKind::NotFound => {
            Error::failed(format!("the folder {folder} does not exist"), "create it or choose another one")
        }
        io::ErrorKind::NotADirectory => {
            Error::failed(format!("{folder} is not a folder"), "choose another place for the output")
        }
        _ => Error::failed(
            format!("cannot create a file in the folder {folder}: {cause}"),
            "make it writable or choose another one",
        ),
    }
}

/// A temporary file whose permissions are those of any new file; the default of `tempfile` is the owner only.
fn new_file() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        /// Read and write for everyone, from which the system takes away what the umask says.
        const BEFORE_UMASK: u32 = 0o666;
        builder.permissions(fs::Permissions::from_mode(BEFORE_UMASK));
    }
    builder
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    fn put(path: &Path, text: &str) -> Result<()> {
        write_atomically(path, |file| file.write_all(text.as_bytes()).map_err(|e| write_failed(path, &e)))
    }

    #[test]
    fn a_written_file_holds_the_bytes_and_has_ordinary_permissions() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        put(&path, "one").unwrap();
        put(&path, "two").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(entries(folder.path()), 1);
        let ordinary = folder.path().join("b.txt");
        fs::write(&ordinary, "x").unwrap();
        let mode = |p: &Path| fs::metadata(p).unwrap().permissions();
        assert_eq!(mode(&path), mode(&ordinary));
    }

    #[test]
    fn a_failure_leaves_the_former_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        put(&path, "one").unwrap();
        let failed: Result<()> = write_atomically(&path, |file| {
            file.write_all(b"half").unwrap();
            Err(Error::failed("no", "stop"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "one");
        assert_eq!(entries(folder.path()), 1);
    }

    #[test]
    fn a_missing_folder_a_folder_and_a_device_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let e = put(&folder.path().join("no/a.txt"), "x").unwrap_err().to_string();
        assert!(e.contains("does not exist"), "{e}");
        let e = put(folder.path(), "x").unwrap_err();
        assert!(e.to_string().contains("is a folder") && e.exit_code() == 2, "{e}");
        assert!(put(Path::new(""), "x").is_err());
        assert!(put(&folder.path().join("a.txt/"), "x").unwrap_err().to_string().contains("names no file"));
        fs::write(folder.path().join("file"), "x").unwrap();
        assert!(check(&folder.path().join("b.txt")).is_ok() && check(folder.path()).is_err());
        assert!(check(&folder.path().join("no/a.txt")).is_err() && entries(folder.path()) == 1);
        assert!(put(&folder.path().join("file/a.txt"), "x").is_err());
        #[cfg(unix)]
        assert!(put(Path::new("/dev/null"), "x").unwrap_err().to_string().contains("not a regular file"));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_to_the_new_content() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, "one").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        put(&link, "two").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&real).unwrap(), "two");
    }
}
