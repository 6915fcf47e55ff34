//! The options that a scene file holds, as words of a command line.

use crate::error::{Error, Result};
use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

/// The table `options` of a scene file.
pub(super) type FileOptions = BTreeMap<String, OptionValue>;

/// Value of an option.
#[derive(Debug, PartialEq)]
pub(super) enum OptionValue {
    /// A text, which may name a file.
    Text(String),
    /// Number, in its shortest form.
    Number(String),
    /// Value of another kind, with the name of that kind.
    Other(&'static str),
}

/// Returns the `options` as names and words. Names of files in `folder` are joined to it.
///
/// # Errors
/// A value that is neither a text nor a number.
pub(super) fn words(options: FileOptions, folder: &Path) -> Result<Vec<[String; 2]>> {
    let word = |(name, value): (String, OptionValue)| match value {
        OptionValue::Text(text) if folder.join(&text).is_file() => {
            Ok([name, folder.join(&text).to_string_lossy().into_owned()])
        }
        OptionValue::Text(word) | OptionValue::Number(word) => Ok([name, word]),
        OptionValue::Other(kind) => Err(Error::input(
            format!("options: `{name}` is a {kind}"),
            "give a text or a number, as on the command line",
        )),
    };
    options.into_iter().map(word).collect()
}

impl<'de> Deserialize<'de> for OptionValue {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        from.deserialize_any(ValueVisitor)
    }
}

/// Writes numbers as texts, which read as the same words.
impl Serialize for OptionValue {
    fn serialize<S: Serializer>(&self, into: S) -> std::result::Result<S::Ok, S::Error> {
        let (Self::Text(word) | Self::Number(word)) = self else {
            return Err(serde::ser::Error::custom("an option is neither a text nor a number"));
        };
        into.serialize_str(word)
    }
}

struct ValueVisitor;

impl<'de> Visitor<'de> for ValueVisitor {
    type Value = OptionValue;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a text or a number")
    }

    fn visit_str<E>(self, text: &str) -> std::result::Result<OptionValue, E> {
        Ok(OptionValue::Text(text.to_owned()))
    }

    fn visit_i64<E>(self, number: i64) -> std::result::Result<OptionValue, E> {
        Ok(OptionValue::Number(number.to_string()))
    }

    /// Accepts seeds beyond the integers that TOML guarantees.
    fn visit_u64<E>(self, number: u64) -> std::result::Result<OptionValue, E> {
        Ok(OptionValue::Number(number.to_string()))
    }

    /// Accepts an integer beyond all seeds as a word, which its option refuses.
    fn visit_u128<E>(self, number: u128) -> std::result::Result<OptionValue, E> {
        Ok(OptionValue::Number(number.to_string()))
    }

    fn visit_i128<E>(self, number: i128) -> std::result::Result<OptionValue, E> {
        Ok(OptionValue::Number(number.to_string()))
    }

    /// Accepts a number: `{:?}` writes 1e300, while `{}` writes 301 digits.
    fn visit_f64<E>(self, number: f64) -> std::result::Result<OptionValue, E> {
        Ok(OptionValue::Number(format!("{number:?}")))
    }

    fn visit_bool<E>(self, _: bool) -> std::result::Result<OptionValue, E> {
        Ok(OptionValue::Other("boolean"))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> std::result::Result<OptionValue, A::Error> {
        while list.next_element::<IgnoredAny>()?.is_some() {}
        Ok(OptionValue::Other("list"))
    }

    /// Refuses a table; a date is a table to the parser.
    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> std::result::Result<OptionValue, A::Error> {
        while table.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(OptionValue::Other("table or a date"))
    }
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
            [("true", "boolean"), ("[1, [2]]", "list"), ("{ b = 1 }", "table"), ("2026-11-26", "date")]
        {
            let e = read(&format!("a = {value}")).unwrap_err().to_string();
            assert!(
                e.contains("`a` is a") && e.contains(kind) && e.contains("give a text or a number"),
                "{e}"
            );
        }
    }
}
