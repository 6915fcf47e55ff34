//! Results in files and on stdout, as text, CSV and JSON.

use super::console::Console;
use crate::error::{Error, Result};
use crate::notes::Notes;
use crate::output;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// Writes a text result to the file `path`, whole or not at all, or to stdout.
pub fn result(path: Option<&Path>, text: &str, console: &Console) -> Result<()> {
    match path {
        None => console.write(text),
        Some(path) => file(path, text),
    }
}

/// Writes `text` to the file `path`, whole or not at all.
pub fn file(path: &Path, text: &str) -> Result<()> {
    output::write_atomically(path, |file| {
        file.write_all(text.as_bytes()).map_err(|e| output::write_failed(path, e))
    })
}

/// Table as CSV, built row by row.
pub struct Csv(csv::Writer<Vec<u8>>);

impl Csv {
    /// Returns an empty table.
    pub fn new() -> Self {
        Self(csv::Writer::from_writer(Vec::new()))
    }

    /// Adds a row.
    ///
    /// # Errors
    /// A row with more or fewer cells than the first.
    pub fn row(&mut self, cells: impl IntoIterator<Item = impl AsRef<[u8]>>) -> Result<()> {
        self.0.write_record(cells).map_err(no_csv)
    }

    /// Returns the text.
    ///
    /// # Errors
    /// Never, if the cells are text.
    pub fn text(self) -> Result<String> {
        let bytes = self.0.into_inner().map_err(no_csv)?;
        String::from_utf8(bytes).map_err(no_csv)
    }
}

/// Returns the error for a table that is no CSV.
fn no_csv(cause: impl std::error::Error + Send + Sync + 'static) -> Error {
    Error::bug(format!("the table is no CSV ({cause})")).caused_by(cause)
}

/// Report with its origin, for JSON.
#[derive(Serialize)]
struct ReportWithOrigin<'a, R> {
    #[serde(flatten)]
    report: &'a R,
    origin: &'a Notes,
}

/// Returns `report`, which is an object in JSON, with its `notes` as the last key, `origin`.
pub fn with_origin<'a>(report: &'a impl Serialize, notes: &'a Notes) -> impl Serialize + 'a {
    ReportWithOrigin { report, origin: notes }
}

/// Returns `report` as indented JSON.
///
/// # Errors
/// Never, if its numbers are finite.
pub fn json_text(report: &impl Serialize) -> Result<String> {
    let json = serde_json::to_string_pretty(report)
        .map_err(|e| Error::bug(format!("the report is no JSON ({e})")).caused_by(e))?;
    Ok(json + "\n")
}

/// Writes `report` as JSON to the file `path`.
pub fn json(path: &Path, report: &impl Serialize) -> Result<()> {
    file(path, &json_text(report)?)
}
