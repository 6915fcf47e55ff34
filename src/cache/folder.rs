//! Cache folder: accessible to its owner alone; no link in it is followed.

use crate::error::{Error, Result};
use crate::output;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

/// Permissions to read, write and enter for the owner alone.
#[cfg(unix)]
const OWNER_ONLY: u32 = 0o700;

/// Returns `$XDG_CACHE_HOME/diffract`, else `~/.cache/diffract`; `None` if neither variable is set.
pub(super) fn of_user() -> Option<PathBuf> {
    let absolute = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    absolute("XDG_CACHE_HOME")
        .or_else(|| absolute("HOME").map(|home| home.join(".cache")))
        .map(|base| base.join("diffract"))
}

/// Creates `folder` if it does not exist, and closes it to other users.
///
/// # Errors
/// A folder that cannot be created; those of [`check`].
pub(super) fn prepare(folder: &Path) -> Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, OWNER_ONLY);
    builder.create(folder).map_err(|e| output::write_failed(folder, e))?;
    check(folder)
}

/// Checks that `folder` is a folder of this user, and closes it to everyone else.
///
/// # Errors
/// A folder that does not exist, is a link or another kind of file, belongs to another user, or cannot be closed.
pub(super) fn check(folder: &Path) -> Result<()> {
    let found = fs::symlink_metadata(folder).map_err(|e| output::write_failed(folder, e))?;
    let refuse = |what: &str| {
        Err(Error::files(what, "set XDG_CACHE_HOME to a folder of your own").at(folder.display()))
    };
    if !found.is_dir() {
        return refuse("is not a folder, and links are not followed");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, PermissionsExt};
        if found.uid() != rustix::process::geteuid().as_raw() {
            return refuse("belongs to another user");
        }
        // A closed folder keeps others from putting links or files there.
        if found.mode() & 0o777 != OWNER_ONLY {
            let closed = fs::set_permissions(folder, fs::Permissions::from_mode(OWNER_ONLY));
            closed.map_err(|e| output::write_failed(folder, e))?;
        }
    }
    Ok(())
}

/// Opens the file `path` for reading, if it is a regular file and no link to one.
pub(super) fn open_regular(path: &Path) -> Option<File> {
    let mut options = fs::OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        // Opening a pipe would wait for its other end.
        let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
        std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, flags.bits() as i32);
    }
    if !fs::symlink_metadata(path).ok()?.is_file() {
        return None;
    }
    let file = options.open(path).ok()?;
    file.metadata().ok()?.is_file().then_some(file)
}
