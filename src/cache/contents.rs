//! Contents of the cache folder, and its limit.

use super::folder;
use crate::error::Result;
use crate::output;
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Contents of the cache folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Contents {
    /// Number and bytes of the results of each kind, by the kind's name.
    pub kinds: BTreeMap<String, Usage>,
}

impl Contents {
    /// Returns number and bytes of all kinds.
    pub fn total(&self) -> Usage {
        self.kinds.values().fold(Usage::default(), |all, kind| Usage {
            files: all.files + kind.files,
            bytes: all.bytes + kind.bytes,
        })
    }
}

/// Disk usage of the results of a kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// Number of files.
    pub files: u64,
    /// Total size \[bytes\].
    pub bytes: u64,
}

/// Cached result.
struct CacheEntry {
    path: PathBuf,
    kind: String,
    bytes: u64,
    used: SystemTime,
}

/// Returns the kind of a result whose file is called `name`: 64 hexadecimal digits, a dot, lower-case letters. Results of former versions
/// have such names, too. Other files in the folder are not ours.
fn kind_of(name: &str) -> Option<&str> {
    const DIGITS: usize = 2 * blake3::OUT_LEN;
    let (digits, kind) = name.split_once('.')?;
    let is_key =
        digits.len() == DIGITS && digits.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b));
    let is_kind = !kind.is_empty() && kind.bytes().all(|b| b.is_ascii_lowercase() || b == b'-');
    (is_key && is_kind).then_some(kind)
}

/// Returns all results in `folder`. Links and everything else that is no regular file are left alone.
fn entries(folder: &Path) -> std::io::Result<Vec<CacheEntry>> {
    let now = SystemTime::now();
    let entry = |file: fs::DirEntry| -> Option<CacheEntry> {
        let name = file.file_name();
        let kind = kind_of(name.to_str()?)?.to_owned();
        // Metadata of the entry itself: a link is not followed.
        let metadata = file.metadata().ok().filter(Metadata::is_file)?;
        let used = metadata.accessed().unwrap_or(SystemTime::UNIX_EPOCH);
        // A time in the future means a wrong clock, not that the file was used last.
        let used = if used > now { SystemTime::UNIX_EPOCH } else { used };
        Some(CacheEntry { path: file.path(), kind, bytes: metadata.len(), used })
    };
    fs::read_dir(folder)?.filter_map(|file| file.map(entry).transpose()).collect()
}

fn summary(entries: &[CacheEntry]) -> Contents {
    let mut kinds = BTreeMap::<String, Usage>::new();
    for entry in entries {
        let usage = kinds.entry(entry.kind.clone()).or_default();
        usage.files += 1;
        usage.bytes = usage.bytes.saturating_add(entry.bytes);
    }
    Contents { kinds }
}

/// Returns the contents of `folder`; nothing if it does not exist.
pub(super) fn read(folder: &Path) -> Result<Contents> {
    Ok(summary(&listed(folder)?))
}

/// Removes all results and stale temporary files, and returns the former contents.
pub(super) fn clear(folder: &Path) -> Result<Contents> {
    let entries = listed(folder)?;
    for entry in &entries {
        match fs::remove_file(&entry.path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(output::write_failed(&entry.path, e));
            }
            _ => {}
        }
    }
    sweep(folder);
    Ok(summary(&entries))
}

fn listed(folder: &Path) -> Result<Vec<CacheEntry>> {
    if matches!(fs::symlink_metadata(folder), Err(e) if e.kind() == std::io::ErrorKind::NotFound) {
        return Ok(vec![]);
    }
    folder::check(folder)?;
    entries(folder).map_err(|e| output::write_failed(folder, e))
}

/// Removes the least recently used results of `folder` until the remaining ones take at most `most` bytes; `replaced` does not count,
/// because it is about to be replaced.
pub(super) fn make_room(folder: &Path, most: u64, replaced: &Path) {
    let mut entries = entries(folder).unwrap_or_default(); // what cannot be listed cannot be removed; writing will fail
    entries.retain(|entry| entry.path != replaced);
    // Last used first; names break ties, so that the order is the same everywhere.
    entries.sort_by(|a, b| Reverse(a.used).cmp(&Reverse(b.used)).then_with(|| a.path.cmp(&b.path)));
    let mut kept = 0u64;
    for entry in entries {
        kept = kept.saturating_add(entry.bytes);
        if kept > most {
            // Another process may have removed the file already.
            let _ = fs::remove_file(&entry.path);
        }
    }
}

/// Removes temporary files of programs that were killed while they wrote. A file that is being written is locked; a new one may not be
/// locked yet.
pub(super) fn sweep(folder: &Path) {
    const JUST_NOW: Duration = Duration::from_secs(60);
    for file in fs::read_dir(folder).into_iter().flatten().flatten() {
        if !file.file_name().as_encoded_bytes().starts_with(output::TEMPORARY.as_bytes()) {
            continue;
        }
        let Some(open) = folder::open_regular(&file.path()) else { continue };
        let modified = open.metadata().and_then(|metadata| metadata.modified());
        // A time in the future says nothing about the age.
        let is_new = modified.is_ok_and(|time| time.elapsed().is_ok_and(|age| age < JUST_NOW));
        if !is_new && open.try_lock().is_ok() {
            let _ = fs::remove_file(file.path()); // the next sweep tries again
        }
    }
}
