//! Parts of a mesh file: the faces that belong to an object, a group or a material of a name.

use crate::error::{Error, Result};
use std::collections::BTreeSet;

/// Parts of a file by name, and the selected one.
#[derive(Default)]
pub(super) struct Parts {
    /// Name of the part whose faces are kept; `None`: all faces.
    wanted: Option<String>,
    /// Names of the current object, groups and material; of a glTF file, of the node, the mesh and the material.
    current: [Vec<String>; 3],
    /// Names of the file, as many as errors list.
    known: BTreeSet<String>,
    /// True if a face belongs to the selected part.
    found: bool,
}

impl Parts {
    /// Largest number of names that an error lists.
    const LISTED: usize = 12;

    /// Returns the parts of a file of which `wanted` is selected; `None`: all faces.
    pub fn new(wanted: Option<&str>) -> Self {
        Self { wanted: wanted.map(str::to_owned), ..Self::default() }
    }

    /// Sets the names of this `kind` for the faces that follow.
    pub fn set(&mut self, kind: usize, names: Vec<String>) {
        self.current[kind] = names;
        for name in &self.current[kind] {
            if self.known.len() < Self::LISTED && !self.known.contains(name) {
                self.known.insert(name.clone());
            }
        }
    }

    /// Returns true if a face at this place belongs to the selected part.
    pub fn keeps(&mut self) -> bool {
        let Some(wanted) = &self.wanted else { return true };
        let keeps = self.current.iter().flatten().any(|name| name == wanted);
        self.found |= keeps;
        keeps
    }

    /// Fails if no face belongs to the selected part.
    pub fn check(&self) -> Result<()> {
        let Some(wanted) = self.wanted.as_ref().filter(|_| !self.found) else { return Ok(()) };
        let known: Vec<&str> = self.known.iter().map(String::as_str).collect();
        let remedy = if known.is_empty() {
            "the file names no object, group or material: leave `part` away".to_owned()
        } else {
            format!("give the name of an object, a group or a material: {}", known.join(", "))
        };
        Err(Error::input(format!("no face belongs to the part `{wanted}`"), remedy))
    }
}
