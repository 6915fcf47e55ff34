//! Notes about the origin of a result: program, command, and preparation of the heights. Every format with room for text carries them.

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};
use std::fmt;
use std::io::Write;

/// Names of the notes about program and command.
const SOFTWARE: &str = "Software";
const COMMAND: &str = "Command";
/// Name of the note about the preparation of the heights.
pub const PREPARED: &str = "Prepared";
/// Name of the note about the validity of scalar theory.
const SCALAR_THEORY: &str = "Scalar theory";

/// Text of a record without steps.
const NO_STEP: &str = "none";
/// Text between two steps of a record; no step contains it.
const BETWEEN_STEPS: &str = ", ";

/// Returns name and version of the program.
pub fn software() -> &'static str {
    concat!("diffract ", env!("CARGO_PKG_VERSION"))
}

/// Steps that prepared a height field, oldest first, in words of the command line: `level plane`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PreparationRecord(Vec<String>);

impl PreparationRecord {
    /// Adds the latest step.
    pub fn push(&mut self, step: impl fmt::Display) {
        self.0.push(step.to_string());
    }

    /// Returns the steps, oldest first.
    pub fn steps(&self) -> &[String] {
        &self.0
    }

    /// Returns true for heights as they were measured or generated.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the record that `text` of a file shows, in the form of `Display`. Steps are taken as they are, because a later version may
    /// know more of them; letters of a damaged file that a terminal would obey are left out.
    pub fn parse(text: &str) -> Self {
        /// Longest text that is taken [letters]: many times any preparation, and little beside the heights.
        const LONGEST: usize = 10_000;
        let text: String = text.chars().filter(|c| !c.is_control()).take(LONGEST).collect();
        let steps = text.split(BETWEEN_STEPS).map(str::trim);
        Self(steps.filter(|step| !step.is_empty() && *step != NO_STEP).map(str::to_owned).collect())
    }
}

impl fmt::Display for PreparationRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() { f.write_str(NO_STEP) } else { f.write_str(&self.0.join(BETWEEN_STEPS)) }
    }
}

/// Notes of a result. As JSON they are an object with the keys `software`, `command` and `prepared`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Notes {
    /// Command that makes the same result; empty if there is none.
    pub command: String,
    /// Preparation of the heights.
    pub prepared: PreparationRecord,
    /// More names (1 to 79 letters of Latin-1) and values, in the order in which they are written.
    pub more: Vec<(String, String)>,
}

impl Notes {
    /// Returns the notes of a result of `command` from heights that were `prepared`.
    pub fn new(command: String, prepared: &PreparationRecord) -> Self {
        Self { command, prepared: prepared.clone(), more: Vec::new() }
    }

    /// Adds the errors of scalar theory for the surface, in words.
    #[must_use]
    pub fn with_scalar_theory(mut self, errors: String) -> Self {
        self.more.push((SCALAR_THEORY.to_owned(), errors));
        self
    }

    /// Returns all names and values, each value in one line. A result without a command has no known surface.
    pub fn entries(&self) -> Vec<(String, String)> {
        let mut entries = vec![(SOFTWARE.to_owned(), software().to_owned())];
        if !self.command.is_empty() {
            entries.push((COMMAND.to_owned(), self.command.clone()));
            entries.push((PREPARED.to_owned(), self.prepared.to_string()));
        }
        entries.extend(self.more.iter().cloned());
        let in_one_line = |value: &str| value.replace(char::is_control, " ");
        entries.into_iter().map(|(name, value)| (name, in_one_line(&value))).collect()
    }

    /// Returns the notes as lines `name: value`, without a line break at the end.
    pub fn text(&self) -> String {
        let line = |(name, value): (String, String)| format!("{name}: {value}");
        self.entries().into_iter().map(line).collect::<Vec<_>>().join("\n")
    }

    /// Adds the notes to a PNG, one chunk of text each.
    ///
    /// # Errors
    /// A name that PNG does not allow.
    pub fn add_to_png<W: Write>(&self, encoder: &mut png::Encoder<'_, W>) -> Result<(), png::EncodingError> {
        self.entries().into_iter().try_for_each(|(name, value)| encoder.add_itxt_chunk(name, value))
    }
}

impl Serialize for Notes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut object = serializer.serialize_struct("Notes", 3)?;
        object.serialize_field("software", software())?;
        object.serialize_field("command", &self.command)?;
        object.serialize_field("prepared", &self.prepared)?;
        object.end()
    }
}

/// Returns the value of the note `name` in `text`, which has the form of [`Notes::text`].
pub fn value<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    text.lines().find_map(|line| line.trim().strip_prefix(name)?.strip_prefix(": "))
}

/// Returns the preparation that `text` of a file notes, in the form of [`Notes::text`]; no step if it notes none.
pub fn preparation(text: &str) -> PreparationRecord {
    value(text, PREPARED).map_or_else(PreparationRecord::default, PreparationRecord::parse)
}

/// Escapes `text` for XML, without the characters that XML does not allow.
pub fn xml(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&apos;"),
            '\n' => escaped.push('\n'),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Converts `text` to ASCII for formats that define no other letters, some readers of which refuse a file that has them: symbols in
/// formulas are written out, other letters as `\u{…}`.
pub fn ascii(text: &str) -> String {
    let letter = |c: char| match c {
        '°' => "deg".to_owned(),
        '²' => "^2".to_owned(),
        'λ' => "lambda".to_owned(),
        'σ' => "sigma ".to_owned(),
        c if c.is_ascii() => c.to_string(),
        c => c.escape_unicode().to_string(),
    };
    text.chars().map(letter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_read_as_it_was_written() {
        let mut record = PreparationRecord::default();
        assert_eq!((record.to_string().as_str(), PreparationRecord::parse("none")), ("none", record.clone()));
        record.push("level plane");
        record.push("crop 40umx20um");
        assert_eq!(record.to_string(), "level plane, crop 40umx20um");
        assert_eq!(PreparationRecord::parse(&record.to_string()), record);
        assert_eq!(PreparationRecord::parse("a\u{1b}[2J, , b").steps(), ["a[2J", "b"]);
        assert!(PreparationRecord::parse(&"x".repeat(1 << 20)).to_string().len() <= 10_000);
    }

    #[test]
    fn notes_are_lines_from_which_the_preparation_is_read() {
        let prepared = PreparationRecord::parse("level plane, despike");
        let notes = Notes::new("diffract orders 'a\nb'".to_owned(), &prepared).with_scalar_theory("λ".into());
        let text = notes.text();
        assert_eq!(
            text,
            format!(
                "Software: {}\nCommand: diffract orders 'a b'\nPrepared: level plane, despike\nScalar theory: λ",
                software()
            )
        );
        assert_eq!((preparation(&text), value(&text, "Prep")), (prepared, None));
        assert_eq!(preparation("no notes"), PreparationRecord::default());
        assert_eq!(Notes::default().text(), format!("Software: {}", software()));
        let json = serde_json::to_value(&notes).unwrap();
        assert_eq!(json["prepared"], serde_json::json!(["level plane", "despike"]));
    }

    #[test]
    fn what_xml_would_read_as_its_own_is_escaped() {
        assert_eq!(xml("a<b> & \"c\"\u{1}"), "a&lt;b&gt; &amp; &quot;c&quot; ");
    }
}
