//! Headers of text: lines of a key and a value, in sections or without.

use super::bytes::damaged;
use crate::error::Result;
use std::collections::HashMap;

/// Values of a header by section and key. Case does not matter, and the first of several values counts.
#[derive(Clone, Debug, Default)]
pub struct TextHeader {
    values: HashMap<String, String>,
}

impl TextHeader {
    /// Reads the lines of `text`: `[Section]`, or a key, `separator` and a value. Lines before the first section have the section ``.
    pub fn parse(text: &str, separator: char) -> Self {
        let mut header = Self::default();
        let mut section = "";
        for line in text.lines().map(str::trim) {
            if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
                section = name;
            } else if let Some((key, value)) = line.split_once(separator) {
                header.insert(section, key, value);
            }
        }
        header
    }

    /// Adds a value, unless there is one of the key in the section.
    pub fn insert(&mut self, section: &str, key: &str, value: &str) {
        self.values.entry(Self::name(section, key)).or_insert_with(|| value.trim().to_owned());
    }

    fn name(section: &str, key: &str) -> String {
        format!("{}\n{}", section.trim(), key.trim()).to_lowercase()
    }

    /// Returns the value of `key` in `section`; `None` if there is none or if it is empty.
    pub fn text(&self, section: &str, key: &str) -> Option<&str> {
        self.values.get(&Self::name(section, key)).map(String::as_str).filter(|value| !value.is_empty())
    }

    /// Returns the number with which a value begins; `None` if there is none.
    pub fn number(&self, section: &str, key: &str) -> Option<f64> {
        self.text(section, key)?.split_whitespace().next()?.parse().ok().filter(|x: &f64| x.is_finite())
    }

    /// Returns a number that has to be there.
    ///
    /// # Errors
    /// No such value, or none that is a number.
    pub fn required(&self, section: &str, key: &str) -> Result<f64> {
        self.number(section, key).ok_or_else(|| damaged(format!("its header has no number `{key}`")))
    }

    /// Returns a count that has to be there.
    ///
    /// # Errors
    /// No such value, or none that is a count.
    pub fn count(&self, section: &str, key: &str) -> Result<u64> {
        let count = self.text(section, key).and_then(|text| text.split_whitespace().next()?.parse().ok());
        count.ok_or_else(|| damaged(format!("its header has no count `{key}`")))
    }
}

/// Returns the place of the first `mark` in `bytes`, and `None` without one.
pub fn find(bytes: &[u8], mark: &[u8]) -> Option<usize> {
    bytes.windows(mark.len()).position(|window| window == mark)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_sections_and_the_first_one_counts() {
        let header = TextHeader::parse("A = 1 \n[One]\nb=2.5 nm\nB=3\n[Two]\nb=\nc=x=y", '=');
        assert_eq!((header.count("", "a").unwrap(), header.number("one", "B")), (1, Some(2.5)));
        assert_eq!((header.text("Two", "b"), header.text("Two", "c")), (None, Some("x=y")));
        assert!(header.count("One", "b").is_err() && header.required("Two", "c").is_err());
        assert_eq!((find(b"abcd", b"cd"), find(b"abc", b"cd")), (Some(2), None));
    }
}
