//! The one error type: what went wrong, where, and what to do about it, in a line.

use std::fmt;

/// Whose turn it is to act; decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The request itself cannot be meant (exit code 2).
    Usage,
    /// The request was sound, the work failed (exit code 1).
    Failed,
}

/// An error with a remedy. Displays as one line: `what; remedy`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    kind: Kind,
    what: String,
    remedy: String,
}

/// The result of everything in this crate that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Wrong use: an option, a value or a combination that cannot be meant.
    pub fn usage(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind: Kind::Usage, what: what.into(), remedy: remedy.into() }
    }

    /// Failed work: a file, a device or a computation that did not do what was asked.
    pub fn failed(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind: Kind::Failed, what: what.into(), remedy: remedy.into() }
    }

    /// The same error with `place` (a file, a line, an option) named in front.
    #[must_use]
    pub fn at(mut self, place: impl fmt::Display) -> Self {
        self.what = format!("{place}: {}", self.what);
        self
    }

    /// The same error with a second remedy behind the first.
    #[must_use]
    pub fn or(mut self, remedy: impl fmt::Display) -> Self {
        self.remedy = format!("{}, or {remedy}", self.remedy);
        self
    }

    /// Whose turn it is to act.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The process exit code that belongs to this error.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            Kind::Failed => 1,
            Kind::Usage => 2,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", line(&self.what), line(&self.remedy))
    }
}

/// `text` on one plain line of readable length: file names and library messages may hold line breaks, what a terminal
/// obeys, or a megabyte of nines.
fn line(text: &str) -> String {
    /// Longer than the words of any language and almost all paths.
    const LONGEST: usize = 400;
    let words = text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|word| !word.is_empty());
    let shown = words.map(|word| match word.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &word[..end]),
        None => word.to_owned(),
    });
    shown.collect::<Vec<_>>().join(" ")
}

impl std::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_one_line_that_names_place_and_remedy() {
        let e = Error::failed("cannot read\nit", "check the path").at("a\nb.png");
        assert_eq!(e.to_string(), "a b.png: cannot read it; check the path");
        assert_eq!(Error::usage("red\u{1b}[31m", "b").to_string(), "red [31m; b");
        assert!(Error::usage("9".repeat(1 << 20), "b").to_string().len() < 500);
        assert_eq!(e.exit_code(), 1);
        assert_eq!(Error::usage("a", "b").exit_code(), 2);
    }
}
