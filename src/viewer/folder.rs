//! Height files of a folder in their order.

use super::changes::StepDirection;
use crate::error::{self, Error, Result};
use crate::surface::files;
use std::cmp::Ordering;
use std::path::{Path, PathBuf};

/// Height file in a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Neighbour {
    /// Path of the file.
    pub path: PathBuf,
    /// Number among the height files of the folder, from 1.
    pub number: usize,
    /// Number of height files in the folder.
    pub of: usize,
}

/// Returns the height file after or before `file` in its folder, ordered by name. The first file follows the last.
///
/// # Errors
/// Fails if the folder cannot be read, or if it has no other height file.
pub fn neighbour(file: &Path, step: StepDirection) -> Result<Neighbour> {
    let folder = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let unreadable = |e: std::io::Error| {
        Error::files(
            format!("the folder {} cannot be read: {}", folder.display(), error::cause(&e)),
            "open another file",
        )
        .caused_by(e)
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = folder.join(entry.map_err(unreadable)?.file_name());
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        if files::is_extension(extension) && path.is_file() {
            files.push(path);
        }
    }
    files.sort_by(|a, b| by_name(&name(a), &name(b)));
    let of = files.len();
    let shown_name = name(file);
    // If `file` itself is gone, its position is the one it would have.
    let before = files.iter().take_while(|other| by_name(&name(other), &shown_name).is_lt()).count();
    let is_there = files.get(before).is_some_and(|other| name(other) == shown_name);
    let place = match step {
        StepDirection::Forward => before + usize::from(is_there),
        StepDirection::Back => before + of.max(1) - 1,
    };
    match files.into_iter().nth(place % of.max(1)) {
        Some(path) if name(&path) != shown_name => Ok(Neighbour { path, number: place % of + 1, of }),
        _ => Err(Error::input("the folder has no other height field", "open another file")),
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Compares names, with numbers in them compared by value: scan2 comes before scan10.
fn by_name(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a, b);
    loop {
        let digits = |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (of_a, of_b) = (digits(a), digits(b));
        if of_a > 0 && of_b > 0 {
            let number = |text: &'_ str, n: usize| text[..n].trim_start_matches('0').to_owned();
            let (x, y) = (number(a, of_a), number(b, of_b));
            let order = x.len().cmp(&y.len()).then(x.cmp(&y)).then(of_a.cmp(&of_b));
            if order.is_ne() {
                return order;
            }
            (a, b) = (&a[of_a..], &b[of_b..]);
            continue;
        }
        let (mut rest_a, mut rest_b) = (a.chars(), b.chars());
        match (rest_a.next(), rest_b.next()) {
            (None, None) => return Ordering::Equal,
            (None, _) => return Ordering::Less,
            (_, None) => return Ordering::Greater,
            (Some(x), Some(y)) => {
                let order = x.to_lowercase().cmp(y.to_lowercase()).then(x.cmp(&y));
                if order.is_ne() {
                    return order;
                }
            }
        }
        (a, b) = (rest_a.as_str(), rest_b.as_str());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_follow_each_other_in_the_order_of_their_numbers_and_around() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["scan10.png", "scan2.png", "Scan1.gwy", "notes.md", "b.obj", "a7.TIF"] {
            std::fs::write(folder.path().join(name), "x").unwrap();
        }
        let step = |from: &str, step| neighbour(&folder.path().join(from), step).unwrap();
        let mut at = "a7.TIF".to_owned();
        for (number, expected) in [(2, "Scan1.gwy"), (3, "scan2.png"), (4, "scan10.png"), (1, "a7.TIF")] {
            let next = step(&at, StepDirection::Forward);
            assert_eq!((name(&next.path).as_str(), next.number, next.of), (expected, number, 4));
            assert_eq!(name(&step(expected, StepDirection::Back).path), at);
            at = expected.to_owned();
        }
        // A file that is gone keeps its position.
        assert_eq!(name(&step("scan5.png", StepDirection::Forward).path), "scan10.png");
        assert_eq!(name(&step("scan5.png", StepDirection::Back).path), "scan2.png");
    }

    #[test]
    fn a_folder_without_another_height_field_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let only = folder.path().join("a.png");
        std::fs::write(&only, "x").unwrap();
        for step in [StepDirection::Forward, StepDirection::Back] {
            assert!(neighbour(&only, step).unwrap_err().to_string().contains("no other height field"));
        }
        assert!(neighbour(Path::new("/no/such/folder/a.png"), StepDirection::Back).is_err());
    }
}
