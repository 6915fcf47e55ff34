//! Files that a command reads and writes, checked against each other before any work.

use crate::error::{Error, Result};
use crate::output;
use std::path::{Path, PathBuf};

/// Inputs and outputs of one command.
#[derive(Clone, Debug, Default)]
pub struct Files {
    inputs: Vec<PathBuf>,
    outputs: Vec<PathBuf>,
}

impl Files {
    /// Returns an empty list.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds inputs; a name that is no file, such as that of a built-in surface, does no harm.
    #[must_use]
    pub fn reads<P: AsRef<Path>>(mut self, paths: impl IntoIterator<Item = P>) -> Self {
        self.inputs.extend(paths.into_iter().map(|path| path.as_ref().to_owned()));
        self
    }

    /// Adds outputs.
    #[must_use]
    pub fn writes<P: AsRef<Path>>(mut self, paths: impl IntoIterator<Item = P>) -> Self {
        self.outputs.extend(paths.into_iter().map(|path| path.as_ref().to_owned()));
        self
    }

    /// Checks that every output can be written, that none is an input, and that no two are the same file.
    ///
    /// # Errors
    /// Outputs that coincide with another file, which are named; otherwise those of [`output::check`].
    pub fn check(&self) -> Result<()> {
        let known = |path: &PathBuf| (Identity::of(path), path.clone());
        let inputs: Vec<_> = self.inputs.iter().map(known).collect();
        let mut outputs: Vec<(Identity, PathBuf)> = Vec::new();
        for path in &self.outputs {
            output::check(path)?;
            if output::is_nowhere(path) {
                continue;
            }
            let identity = Identity::of(path);
            if let Some((_, input)) = inputs.iter().find(|(input, _)| identity.meets(input)) {
                return Err(refused(path, "is the input", input));
            }
            if let Some((_, other)) = outputs.iter().find(|(other, _)| identity.meets(other)) {
                return Err(refused(path, "is the same file as the output", other));
            }
            outputs.push((identity, path.clone()));
        }
        Ok(())
    }
}

fn refused(path: &Path, what: &str, other: &Path) -> Error {
    let what = if path == other { what.to_owned() } else { format!("{what} {}", other.display()) };
    Error::usage(what, "give the output another name").at(path.display())
}

/// Identity of the file that a path leads to.
struct Identity {
    /// Path without links; for a file that does not exist, that of the folder and the name.
    path: Option<PathBuf>,
    /// Device and inode of an existing file.
    #[cfg(unix)]
    node: Option<(u64, u64)>,
}

impl Identity {
    fn of(path: &Path) -> Self {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let new = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
        Self {
            path: path.canonicalize().ok().or_else(new),
            #[cfg(unix)]
            node: std::fs::metadata(path).ok().map(|there| {
                use std::os::unix::fs::MetadataExt;
                (there.dev(), there.ino())
            }),
        }
    }

    fn meets(&self, other: &Self) -> bool {
        #[cfg(unix)]
        if self.node.is_some() && self.node == other.node {
            return true;
        }
        self.path.is_some() && self.path == other.path
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn an_output_that_is_an_input_is_refused_by_whatever_path_it_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("in.png"), "x").unwrap();
        fs::create_dir(at("sub")).unwrap();
        let mut ways = vec![at("in.png"), at("sub/../in.png"), at("./in.png")];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("in.png"), at("link.png")).unwrap();
            ways.push(at("link.png"));
        }
        fs::hard_link(at("in.png"), at("hard.png")).unwrap();
        ways.push(at("hard.png"));
        for way in ways {
            let e = Files::new().reads([at("in.png")]).writes([&way]).check().unwrap_err();
            assert!(
                e.kind() == crate::error::ErrorKind::Usage && e.to_string().contains("is the input"),
                "{}: {e}",
                way.display()
            );
        }
        assert!(Files::new().reads(["elaphe", "d65"]).writes([at("out.png")]).check().is_ok());
        assert!(Files::new().reads([at("in.png"), at("none.png")]).writes([at("new.png")]).check().is_ok());
    }

    #[test]
    fn two_outputs_of_one_name_are_refused_also_where_there_is_no_file_yet() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        for (a, b) in [("new.csv", "new.csv"), ("new.csv", "sub/../new.csv"), ("./new.csv", "new.csv")] {
            let e = Files::new().writes([at(a), at(b)]).check().unwrap_err().to_string();
            assert!(e.contains("is the same file"), "{a} {b}: {e}");
        }
        assert!(Files::new().writes([at("a.csv"), at("b.csv"), at("sub/a.csv")]).check().is_ok());
        assert!(Files::new().writes([at("none/a.csv")]).check().is_err(), "no folder");
    }
}
