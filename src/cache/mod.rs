//! Cache on disk for the results of long computations.
//!
//! One folder, `$XDG_CACHE_HOME/diffract` or `~/.cache/diffract`, holds all of them. A [`EntryFormat`] names a kind of result
//! and its version, a [`Key`] is a hash of everything that a result depends on, and a [`Store`] loads and saves.
//!
//! - A file appears whole or not at all: it is written beside its place and renamed. A file that is damaged, foreign or
//!   of another version counts as absent.
//! - The folder is its owner's alone, and no link in it is followed.
//! - The folder is bounded: before a file is added, the least recently used files go.

mod contents;
mod file;
mod folder;
mod kept;
mod key;

pub use contents::{Contents, Usage};
pub use file::{Payload, read, seal};
pub use kept::{Kept, count, positive};
pub use key::{EntryFormat, Key};

use crate::error::{Error, Remedy, Result};
use crate::memory;
use crate::output;
use serde::{Serialize, de::DeserializeOwned};
use std::fs::FileTimes;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Default limit of the folder's size \[bytes\], 2 GiB.
pub const DEFAULT_LIMIT: u64 = 2 << 30;

/// Permissions of cached files.
const OWNER_ONLY: u32 = 0o600;

/// Cache folder and its limit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Store {
    folder: PathBuf,
    limit: u64,
}

impl Store {
    /// Returns the store of the user, which holds at most `limit` bytes; `None` if that is 0 or the user has no home.
    pub fn of_user(limit: u64) -> Option<Self> {
        if limit == 0 {
            return None;
        }
        folder::of_user().map(|folder| Self::at(folder, limit))
    }

    /// Returns a store in `folder` that holds at most `limit` bytes.
    pub fn at(folder: impl Into<PathBuf>, limit: u64) -> Self {
        Self { folder: folder.into(), limit }
    }

    /// Returns the most bytes that the store holds.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// Returns the folder, which need not exist yet.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the path of the result of `key`.
    pub fn path(&self, format: &EntryFormat, key: &Key) -> PathBuf {
        self.folder.join(format!("{}.{}", key.to_hex(), format.name))
    }

    /// Loads the result of `key`, made by `build` from the header and the payload of its file.
    ///
    /// `build` runs before the check sum is compared, and a forged file may have a correct one: it must check every number that it uses,
    /// and take memory through [`Payload`] only. It has to read the payload to its end. Loading marks the file as used.
    ///
    /// `None` if there is no such file, or one that is damaged, that `build` refuses, whose payload is larger than `memory_limit` bytes or
    /// than the memory that is free.
    pub fn load<H: DeserializeOwned, T>(
        &self,
        format: &EntryFormat,
        key: &Key,
        memory_limit: u64,
        build: impl FnOnce(H, &mut Payload<'_>) -> Option<T>,
    ) -> Option<T> {
        folder::check(&self.folder).ok()?;
        let mut file = folder::open_regular(&self.path(format, key))?;
        let size = file.metadata().ok()?.len();
        if size.saturating_sub(file::LARGEST_OVERHEAD) > memory_limit {
            return None;
        }
        memory::ensure_room(size, "what is kept").ok()?;
        let built = read(&mut file, size, format, key, memory_limit, build)?;
        // A file that cannot be marked is only removed earlier. The time of writing stays.
        let _ = file.set_times(FileTimes::new().set_accessed(SystemTime::now()));
        Some(built)
    }

    /// Stores `header` and the concatenation of `payload` as the result of `key`. Makes room first, at the expense of the least recently
    /// used files.
    ///
    /// # Errors
    /// A file larger than the limit, a folder that is open to others, a file that cannot be written. The result itself is still good.
    pub fn save(
        &self,
        format: &EntryFormat,
        key: &Key,
        header: &impl Serialize,
        payload: &[&[u8]],
    ) -> Result<()> {
        let place = self.path(format, key);
        let head = file::Head::new(format, key, header, payload)?;
        let size = head.file_bytes();
        if size > self.limit {
            return Err(Error::limit(
                format!(
                    "{} are more than the cache may hold, {}",
                    memory::in_words(size),
                    memory::in_words(self.limit)
                ),
                Remedy::LargerCache,
            ));
        }
        folder::prepare(&self.folder)?;
        contents::sweep(&self.folder);
        contents::make_room(&self.folder, self.limit - size, &place);
        let failed = |e: std::io::Error| output::write_failed(&self.folder, e);
        let mut draft = output::Draft::new(&self.folder, OWNER_ONLY).map_err(failed)?;
        // Lock held while the file is written: a sweep removes only temporary files without a lock.
        let _ = draft.file().try_lock(); // a file system without locks: the age alone protects the file
        let mut writer = BufWriter::new(draft.file());
        file::write(&mut writer, &head, payload).map_err(failed)?;
        drop(writer);
        draft.persist(&place).map_err(failed)?;
        Ok(())
    }

    /// Returns the contents of the folder.
    ///
    /// # Errors
    /// A folder that cannot be read, or is open to others.
    pub fn contents(&self) -> Result<Contents> {
        contents::read(&self.folder)
    }

    /// Removes every cached result, and returns the former contents.
    ///
    /// # Errors
    /// Those of [`Store::contents`]; a file that cannot be removed.
    pub fn clear(&self) -> Result<Contents> {
        contents::clear(&self.folder)
    }
}

#[cfg(test)]
mod tests;
