//! Result files that appear whole or not at all: written without a name or beside their target, then renamed.

use crate::error::{self, Error, Result};
use std::fs::{self, File, Metadata};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Prefix of the names of files that are still being written.
pub const TEMPORARY: &str = ".diffract-";

/// Permissions of a new result before the umask: read and write for everyone.
const BEFORE_UMASK: u32 = 0o666;

/// Writes the file `path` through `write`, which gets a buffered, seekable writer.
///
/// The bytes go to a temporary file in the same folder, which becomes `path` when all of them are on disk. A failure
/// leaves a former file as it was and nothing new behind; so does a signal that ends the program, where the file system
/// has files without a name (Linux, most local file systems). A link is followed. A file that is replaced passes on its
/// permissions, and its owner and group if the system allows that; hard links to it keep the former content. What goes to
/// `/dev/null` is written and forgotten.
///
/// # Errors
/// Whatever `write` returns; a folder that is missing or not writable; a target that is a folder or a device, or that
/// may not be written.
pub fn write_atomically<T>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<T>,
) -> Result<T> {
    if is_nowhere(path) {
        let folder = std::env::temp_dir();
        let mut draft = Draft::new(&folder, BEFORE_UMASK).map_err(|e| cannot_create(e, &folder))?;
        return write(&mut BufWriter::new(draft.file()));
    }
    let target = resolve(path)?;
    let mut draft = Draft::beside(&target).map_err(|e| e.at(path.display()))?;
    let mut writer = BufWriter::new(draft.file());
    let value = write(&mut writer)?;
    writer.flush().map_err(|e| write_failed(path, e))?;
    drop(writer);
    draft.file().sync_all().map_err(|e| write_failed(path, e))?;
    if let Ok(former) = fs::metadata(&target) {
        // otherwise there is no former file
        pass_on(&former, draft.file()).map_err(|e| write_failed(path, e))?;
    }
    draft.persist(&target).map_err(|e| write_failed(path, e))?;
    Ok(value)
}

/// Fails if [`write_atomically`] would: a check before long work whose result would be lost.
///
/// # Errors
/// Those of [`write_atomically`]. A disk that fills up in between is not foreseen.
pub fn check(path: &Path) -> Result<()> {
    if is_nowhere(path) {
        return Ok(());
    }
    Draft::beside(&resolve(path)?).map(drop).map_err(|e| e.at(path.display()))
}

/// Returns true for the file that keeps nothing, to which a user sends a result that is not wanted.
pub fn is_nowhere(path: &Path) -> bool {
    cfg!(unix) && path == Path::new("/dev/null")
}

/// File that is being written; removed on drop unless it gets a name.
pub(crate) struct Draft {
    folder: PathBuf,
    file: Unfinished,
}

enum Unfinished {
    /// File without a name: the system removes it when the program ends in any way.
    #[cfg(target_os = "linux")]
    Unnamed(File),
    /// Named file, for file systems without unnamed ones.
    Named(NamedTempFile),
}

impl Draft {
    /// Creates a file in `folder` with the permissions `mode`, less the umask.
    pub(crate) fn new(folder: &Path, mode: u32) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        if let Ok(file) = unnamed(folder, mode) {
            return Ok(Self { folder: folder.to_owned(), file: Unfinished::Unnamed(file) });
        }
        let file = builder(mode).tempfile_in(folder)?;
        Ok(Self { folder: folder.to_owned(), file: Unfinished::Named(file) })
    }

    /// Creates a file in the folder of `target`.
    fn beside(target: &Path) -> Result<Self> {
        let folder = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        Self::new(folder, BEFORE_UMASK).map_err(|e| cannot_create(e, folder))
    }

    /// Returns the file for writing.
    pub(crate) fn file(&mut self) -> &mut File {
        match &mut self.file {
            #[cfg(target_os = "linux")]
            Unfinished::Unnamed(file) => file,
            Unfinished::Named(file) => file.as_file_mut(),
        }
    }

    /// Moves the file to `target`, which must be in its folder, and replaces a former file.
    pub(crate) fn persist(self, target: &Path) -> io::Result<()> {
        match self.file {
            #[cfg(target_os = "linux")]
            Unfinished::Unnamed(file) => {
                match link(&file, target) {
                    // Only a rename replaces a file, and only a file with a name can be renamed.
                    Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                    other => return other,
                }
                let named = builder(BEFORE_UMASK).make_in(&self.folder, |path| link(&file, path))?;
                named.persist(target).map(drop).map_err(|e| e.error)
            }
            Unfinished::Named(file) => file.persist(target).map(drop).map_err(|e| e.error),
        }
    }
}

/// Creates a file in `folder` without a name.
#[cfg(target_os = "linux")]
fn unnamed(folder: &Path, mode: u32) -> io::Result<File> {
    use rustix::fs::{Mode, OFlags};
    // Path through which the file gets its name later.
    fs::metadata("/proc/self/fd")?;
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    Ok(rustix::fs::open(folder, flags, Mode::from_raw_mode(mode))?.into())
}

/// Gives a file without a name the name `path`.
#[cfg(target_os = "linux")]
fn link(file: &File, path: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let descriptor = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(linkat(CWD, descriptor, CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

/// Gives `file` the permissions of `former`, and its owner and group if the system allows it.
fn pass_on(former: &Metadata, file: &File) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        let written = file.metadata()?;
        // Each separately: the group may be allowed if the owner is not.
        if written.gid() != former.gid() {
            let _ = fchown(file, None, Some(former.gid())); // refused: the group of this process stays
        }
        if written.uid() != former.uid() {
            let _ = fchown(file, Some(former.uid()), None); // refused: this user stays the owner
        }
    }
    file.set_permissions(former.permissions())
}

/// Returns the error for a write to `path` that the system refused.
pub fn write_failed(path: &Path, cause: io::Error) -> Error {
    Error::files(
        format!("cannot write: {}", error::cause(&cause)),
        "check the free space and the permissions",
    )
    .caused_by(cause)
    .at(path.display())
}

/// Returns the target of `path`, with links followed, unless it must not be replaced.
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
        Ok(there) if !may_be_written(path, &there) => Err(Error::usage(
            format!("{}: is write-protected and would be replaced", path.display()),
            "give the output another name, or allow writing to the file",
        )),
        Ok(_) => path.canonicalize().map_err(|e| write_failed(path, e)),
        Err(_) => Ok(path.to_path_buf()), // there is nothing to replace; creating the file tells what else is wrong
    }
}

/// Returns true if the file `path` has a write permission, which binds root here as well, and this user may write it.
fn may_be_written(path: &Path, there: &Metadata) -> bool {
    #[cfg(unix)]
    if rustix::fs::access(path, rustix::fs::Access::WRITE_OK).is_err() {
        return false;
    }
    #[cfg(not(unix))]
    let _ = path;
    !there.permissions().readonly()
}

fn cannot_create(cause: io::Error, folder: &Path) -> Error {
    let folder = folder.display();
    let error = match cause.kind() {
        io::ErrorKind::NotFound => {
            Error::files(format!("the folder {folder} does not exist"), "create it or choose another one")
        }
        io::ErrorKind::NotADirectory => {
            Error::files(format!("{folder} is not a folder"), "choose another place for the output")
        }
        _ => Error::files(
            format!("cannot create a file in the folder {folder}: {}", error::cause(&cause)),
            "make it writable or choose another one",
        ),
    };
    error.caused_by(cause)
}

/// Returns a builder of temporary files with the permissions `mode`, less the umask; the default of `tempfile` is the owner only.
fn builder(mode: u32) -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(mode));
    #[cfg(not(unix))]
    let _ = mode;
    builder
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    fn put(path: &Path, text: &str) -> Result<()> {
        write_atomically(path, |file| file.write_all(text.as_bytes()).map_err(|e| write_failed(path, e)))
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
            Err(Error::input("no", "stop"))
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
        assert!(e.to_string().contains("is a folder") && e.kind() == error::ErrorKind::Usage, "{e}");
        assert!(put(Path::new(""), "x").is_err());
        assert!(put(&folder.path().join("a.txt/"), "x").unwrap_err().to_string().contains("names no file"));
        fs::write(folder.path().join("file"), "x").unwrap();
        assert!(check(&folder.path().join("b.txt")).is_ok() && check(folder.path()).is_err());
        assert!(check(&folder.path().join("no/a.txt")).is_err() && entries(folder.path()) == 1);
        assert!(put(&folder.path().join("file/a.txt"), "x").is_err());
        #[cfg(unix)]
        assert!(put(Path::new("/dev/zero"), "x").unwrap_err().to_string().contains("not a regular file"));
        put(Path::new("/dev/null"), "x").unwrap();
        check(Path::new("/dev/null")).unwrap();
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

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_replaced_passes_its_permissions_and_owner_on() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        put(&path, "one").unwrap();
        for mode in [0o600, 0o640, 0o666, 0o755] {
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            put(&path, "two").unwrap();
            assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o7777, mode, "{mode:o}");
        }
        // Only root can give files away.
        if chown(&path, Some(12_345), Some(54_321)).is_ok() {
            put(&path, "three").unwrap();
            let there = fs::metadata(&path).unwrap();
            assert_eq!((there.uid(), there.gid()), (12_345, 54_321));
        }
        assert_eq!(entries(folder.path()), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_write_protected_file_is_refused_also_to_root_and_before_any_work() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        put(&path, "one").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
        for refused in [check(&path), put(&path, "two")] {
            let e = refused.unwrap_err();
            assert!(e.kind() == error::ErrorKind::Usage && e.to_string().contains("write-protected"), "{e}");
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), "one");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_that_is_being_written_has_no_name() {
        let folder = tempfile::tempdir().unwrap();
        if unnamed(folder.path(), BEFORE_UMASK).is_err() {
            return; // this file system has no files without names
        }
        let path = folder.path().join("a.txt");
        put(&path, "one").unwrap();
        write_atomically(&path, |file| {
            file.write_all(b"two").map_err(|e| write_failed(&path, e))?;
            assert_eq!(entries(folder.path()), 1, "the former file alone");
            Ok(())
        })
        .unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(entries(folder.path()), 1);
    }

    #[test]
    fn a_file_system_without_nameless_files_gets_named_ones() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for text in ["one", "two"] {
            let named = builder(BEFORE_UMASK).tempfile_in(folder.path()).unwrap();
            let mut draft = Draft { folder: folder.path().to_owned(), file: Unfinished::Named(named) };
            draft.file().write_all(text.as_bytes()).unwrap();
            draft.persist(&path).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(entries(folder.path()), 1);
    }
}
