//! State that a window leaves for the next, as JSON in `$XDG_STATE_HOME/diffract`, else in `~/.local/state/diffract`: the arguments of the
//! `diffract view` that begins with the settings of the last closed window (`last-view.json`), and the recently opened files
//! (`recent.json`).

use super::view_command;
use crate::error::{Error, Result};
use crate::input;
use crate::output;
use crate::scene::Scene;
use crate::viewer::ViewSettings;
use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;

/// File with the settings of the last closed window.
const LAST: &str = "last-view.json";
/// File with the names of recently opened files.
const RECENT: &str = "recent.json";

fn path(name: &str) -> Option<PathBuf> {
    let absolute = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    absolute("XDG_STATE_HOME")
        .or_else(|| absolute("HOME").map(|home| home.join(".local/state")))
        .map(|base| base.join("diffract").join(name))
}

/// Returns true if settings of a window are stored.
pub fn is_kept() -> bool {
    path(LAST).is_some_and(|path| path.is_file())
}

/// Stores `settings` of `scene` instead of the former ones.
///
/// # Errors
/// A file that cannot be written.
pub fn keep(settings: &ViewSettings, scene: &Scene) -> Result<()> {
    write(LAST, &view_command::view(settings, scene))
}

/// Writes `words` into the file `name`. Without a folder for state files nothing is written.
fn write(name: &str, words: &[String]) -> Result<()> {
    let Some(path) = path(name) else { return Ok(()) };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| output::write_failed(folder, e))?;
    }
    output::write_atomically(&path, |file| {
        let no_json = |e| Error::bug(format!("words are no JSON ({e})")).caused_by(e);
        let text = serde_json::to_string(words).map_err(no_json)?;
        file.write_all(text.as_bytes()).map_err(|e| output::write_failed(&path, e))
    })
}

/// Returns the recently opened files, the newest first. A damaged list counts as empty and is replaced at the next change.
pub fn recent() -> Vec<String> {
    let text = path(RECENT).and_then(|path| input::read_text(&path, "a list of files").ok());
    // No list, or a damaged one.
    text.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
}

/// Stores the list of recently opened files.
///
/// # Errors
/// A file that cannot be written.
pub fn keep_recent(names: &[String]) -> Result<()> {
    write(RECENT, names)
}

/// Reads the stored arguments.
///
/// # Errors
/// No stored settings, or damaged ones.
pub fn words() -> Result<Vec<OsString>> {
    let nothing = || Error::input("there is no window to go on with", "begin with `diffract view`");
    let path = path(LAST).ok_or_else(nothing)?;
    let text = input::read_text(&path, "the settings of a window")?;
    let words: Vec<String> =
        serde_json::from_str(&text).map_err(|e| damaged(&e).caused_by(e).at(path.display()))?;
    Ok(words.into_iter().map(OsString::from).collect())
}

/// Returns the error for stored settings that cannot be read.
pub fn damaged(cause: &dyn std::fmt::Display) -> Error {
    let what = format!("the settings of the last window cannot be read ({cause})");
    Error::input(what, "begin with `diffract view`; the next window that is closed takes their place")
}
