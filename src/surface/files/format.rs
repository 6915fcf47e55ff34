//! Description of one format of files.

use super::scan::Scan;
use crate::error::Result;

/// A format of files: its names, how it is recognised, and its reader. Each reader's module has one, and [`FORMATS`](super::FORMATS)
/// lists them.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Name of the format's folders of seeds and findings of the fuzzer.
    pub name: &'static str,
    /// Name for people: the program or the makers.
    pub title: &'static str,
    /// Extensions of the names of files, without the dot, in lower case.
    pub extensions: &'static [&'static str],
    /// Function that returns true if a file with this content is of the format.
    pub signature: fn(&[u8]) -> bool,
    /// True if a file of no known signature is of the format if its name has one of the extensions.
    pub is_by_name: bool,
    /// Function that reads a whole file.
    pub read: for<'a> fn(&'a [u8]) -> Result<Scan<'a>>,
    /// Facts for the table in `docs/SCANS.md`: lateral scale, height scale, samples that were not measured, notes.
    pub facts: [&'static str; 4],
}

impl Format {
    /// Returns true if `extension`, in lower case, is one of the format's.
    pub fn has_extension(&self, extension: &str) -> bool {
        self.extensions.contains(&extension)
    }

    /// Returns the format's row of the table in `docs/SCANS.md`.
    pub fn row(&self) -> String {
        let names: Vec<String> = self.extensions.iter().map(|extension| format!("`.{extension}`")).collect();
        format!("| {} {} | {} |", names.join(", "), self.title, self.facts.join(" | ")).replace("|  |", "| |")
    }
}

/// Says that no file is recognised by its content.
pub fn no_signature(_: &[u8]) -> bool {
    false
}
