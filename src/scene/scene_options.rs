//! The options that a scene file holds, as words of a command line.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The table `options` of a scene file.
pub(super) type FileOptions = BTreeMap<String, OptionValue>;

/// Value of an option. Seeds may lie beyond the integers that TOML guarantees.
#[derive(Debug, Deserialize, Serialize)]
#[serde(untagged)]
pub(super) enum OptionValue {
    /// A text, which may name a file.
    Text(String),
    Integer(i64),
    LargeInteger(u64),
    Real(f64),
    Other(toml::Value),
}

/// Returns the `options` as names and words. Names of files in `folder` are joined to it.
///
/// # Errors
/// A value that is neither a text nor a number.
pub(super) fn words(options: FileOptions, folder: &Path) -> Result<Vec<[String; 2]>> {
    let word = |(name, value): (String, OptionValue)| {
        let word = match value {
            OptionValue::Text(text) if folder.join(&text).is_file() => {
                folder.join(&text).to_string_lossy().into_owned()
            }
            OptionValue::Text(word) => word,
            OptionValue::Integer(number) => number.to_string(),
            OptionValue::LargeInteger(number) => number.to_string(),
            // `{}` would write 301 digits of 1e300.
            OptionValue::Real(number) => format!("{number:?}"),
            OptionValue::Other(value) => {
                let what = format!("options: `{name}` is of the type {}", value.type_str());
                return Err(Error::input(what, "give a text or a number, as on the command line"));
            }
        };
        Ok([name, word])
    };
    options.into_iter().map(word).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<[String; 2]>> {
        words(toml::from_str(text).unwrap(), Path::new(""))
    }

    #[test]
    fn texts_and_numbers_are_words_and_no_number_is_longer_than_need_be() {
        for (value, word) in [
            ("\"gaussian:40um\"", "gaussian:40um"),
            ("4", "4"),
            ("-3", "-3"),
            ("0.05", "0.05"),
            ("18446744073709551615", "18446744073709551615"),
            ("1e300", "1e300"),
            ("1e-300", "1e-300"),
        ] {
            assert_eq!(
                read(&format!("a = {value}")).unwrap(),
                [["a".to_owned(), word.to_owned()]],
                "{value}"
            );
        }
    }

    #[test]
    fn other_values_are_refused_by_name() {
        for (value, kind) in
            [("true", "boolean"), ("[1, [2]]", "array"), ("{ b = 1 }", "table"), ("2026-11-26", "datetime")]
        {
            let e = read(&format!("a = {value}")).unwrap_err().to_string();
            assert!(
                e.contains("`a` is of the type") && e.contains(kind) && e.contains("give a text or a number"),
                "{e}"
            );
        }
    }
}
