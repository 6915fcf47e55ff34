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

/// Table of text, built row by row; the first row is the header.
#[derive(Clone, Debug, Default)]
pub struct Csv(Vec<Vec<String>>);

impl Csv {
    /// Returns an empty table.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a row, which has as many cells as the first.
    pub fn row(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        self.0.push(cells.into_iter().map(Into::into).collect());
    }

    /// Returns all rows.
    pub fn rows(&self) -> &[Vec<String>] {
        &self.0
    }

    /// Returns the text, with commas between cells.
    ///
    /// # Errors
    /// A row with more or fewer cells than the first.
    pub fn text(&self) -> Result<String> {
        self.text_between(b',')
    }

    /// Returns the text, with `separator` between cells.
    ///
    /// # Errors
    /// See [`Self::text`].
    pub fn text_between(&self, separator: u8) -> Result<String> {
        let mut writer = csv::WriterBuilder::new().delimiter(separator).from_writer(Vec::new());
        self.0.iter().try_for_each(|row| writer.write_record(row)).map_err(no_csv)?;
        let bytes = writer.into_inner().map_err(no_csv)?;
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
