//! Scales of height images that the window assumes, because the files carry none, until the user confirms them.

use std::ffi::{OsStr, OsString};

/// Quantity that a height image does not carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Distance of neighbouring samples.
    Spacing,
    /// Height of white.
    Height,
}

/// Scales that are assumed.
#[derive(Default)]
pub struct Guesses {
    // By file.
    assumed: Vec<(OsString, Scale)>,
    /// True if the panel is to scroll to the fields of the scales.
    pub are_sought: bool,
}

impl Guesses {
    /// Adds the `scale` of `file`.
    pub fn assume(&mut self, file: &OsStr, scale: Scale) {
        if !self.has(file, scale) {
            self.assumed.push((file.to_owned(), scale));
        }
        self.are_sought = true;
    }

    /// Returns true if the `scale` of `file` is assumed.
    pub fn has(&self, file: &OsStr, scale: Scale) -> bool {
        self.assumed.iter().any(|(known, of)| known == file && *of == scale)
    }

    /// Takes the `scale` of `file` as known.
    pub fn confirm(&mut self, file: &OsStr, scale: Scale) {
        self.assumed.retain(|(known, of)| known != file || *of != scale);
    }
}
