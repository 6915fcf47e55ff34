//! The text header of a Nanoscope file.

use super::super::bytes::{cut_short, damaged, decode_text};
use crate::error::Result;

/// Longest header \[bytes\]; real ones are 8 to 100 kB.
const LONGEST: usize = 4 << 20;

/// Names of sections that describe an image, in lower case.
const IMAGES: [&str; 4] = ["ciao image list", "afm image list", "stm image list", "ncafm image list"];

/// Section of the header: its lines by their keys, in lower case.
pub struct Section {
    name: String,
    lines: Vec<(String, String)>,
}

/// All sections, in the order of the file.
pub struct NanoscopeHeader {
    /// The file's version, as in 0x09300000; `None` for the oldest files.
    pub version: Option<u32>,
    /// The sections.
    pub sections: Vec<Section>,
}

impl NanoscopeHeader {
    /// Parses the header at the start of `bytes`.
    ///
    /// # Errors
    /// The header does not end.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let bytes = &bytes[..bytes.len().min(LONGEST)];
        let mut sections: Vec<Section> = Vec::new();
        let mut ended = false;
        for line in bytes.split(|b| *b == b'\n') {
            let line = decode_text(line);
            let line = line.trim_end_matches(['\r', '\0', ' ']);
            let line = if sections.is_empty() { line.replacen('?', "\\", 1) } else { line.to_owned() };
            if let Some(name) = line.strip_prefix("\\*") {
                if name.eq_ignore_ascii_case("file list end") {
                    ended = true;
                    break;
                }
                sections.push(Section { name: name.trim().to_lowercase(), lines: Vec::new() });
            } else if let (Some(text), Some(section)) = (line.strip_prefix('\\'), sections.last_mut()) {
                let (key, value) = split(text);
                section.lines.push((key.trim().to_lowercase(), value.trim().to_owned()));
            }
        }
        if !ended {
            return Err(cut_short());
        }
        let version = sections.first().and_then(|s| s.text("version")).and_then(|text| {
            let digits = text.trim_start_matches("0x").trim_start_matches("0X");
            u32::from_str_radix(digits.split_whitespace().next()?, 16).ok()
        });
        Ok(Self { version, sections })
    }

    /// Returns the value of `key` (in any case) in the first section that has it and is no image.
    pub fn lookup(&self, key: &str) -> Option<&str> {
        let key = key.to_lowercase();
        self.sections.iter().filter(|s| !s.is_image()).find_map(|s| s.text(&key))
    }
}

/// Splits a line into key and value. Keys of parameters may begin with `@2:`, whose colon ends no key.
fn split(line: &str) -> (&str, &str) {
    let parameter = line.strip_prefix('@').is_some_and(|rest| {
        let mut start = rest.chars();
        start.next().is_some_and(|c| c.is_ascii_digit()) && start.next() == Some(':')
    });
    let from = if parameter { 3 } else { 0 };
    match line[from..].find(':') {
        Some(colon) => (&line[..from + colon], &line[from + colon + 1..]),
        None => (line, ""),
    }
}

impl Section {
    /// Returns true if the section describes an image.
    pub fn is_image(&self) -> bool {
        IMAGES.contains(&self.name.as_str())
    }

    /// Returns the value of `key`, in lower case; the last value of a key that stands twice.
    pub fn text(&self, key: &str) -> Option<&str> {
        self.lines.iter().rev().find(|(k, _)| k == key).map(|(_, value)| value.as_str())
    }

    /// Returns the value of `@2:key`, or of the lowest other number that there is.
    pub fn numbered(&self, key: &str) -> Option<&str> {
        let number = |k: &str| {
            let (number, name) = k.strip_prefix('@')?.split_once(':')?;
            (name == key).then(|| number.parse::<u32>().ok()).flatten()
        };
        // Group 2 is the newest description of images; 3 and more are those of other modes.
        let order = |n: u32| (n != 2, n);
        let found = self.lines.iter().filter_map(|(k, value)| Some((number(k)?, value)));
        found.min_by_key(|(n, _)| order(*n)).map(|(_, value)| value.as_str())
    }

    /// Returns the whole number of `key`.
    ///
    /// # Errors
    /// It is missing or none.
    pub fn count(&self, key: &str) -> Result<u64> {
        let text = self.text(key).ok_or_else(|| damaged(format!("`{key}` is missing")))?;
        let word = text.split_whitespace().next().unwrap_or_default();
        word.parse().map_err(|_| damaged(format!("`{key}: {text}` is no count")))
    }

    /// Returns the whole number of `key`; `None` if it is missing.
    ///
    /// # Errors
    /// It is none.
    pub fn optional_count(&self, key: &str) -> Result<Option<u64>> {
        self.text(key).map(|_| self.count(key)).transpose()
    }

    /// Returns the image's name, as in the instrument's software.
    pub fn name(&self) -> String {
        let text = self.numbered("image data").or_else(|| self.text("image data")).unwrap_or("image");
        let quoted = text.split('"').nth(1);
        let internal = text.split_once('[').and_then(|(_, rest)| rest.split_once(']')).map(|(name, _)| name);
        quoted.filter(|name| !name.is_empty()).or(internal).unwrap_or(text).to_owned()
    }
}

/// A value of a parameter: `V [Sens. Zsens] (0.0067 V/LSB) 440.0 V`.
pub struct ParameterValue {
    /// The number behind the parentheses.
    pub number: f64,
    /// Unit; empty for none.
    pub unit: String,
    /// Name of another parameter, in brackets.
    pub soft_scale: Option<String>,
}

impl ParameterValue {
    /// Reads a value or scale (`V` or `C`).
    pub fn parse(text: &str) -> Option<Self> {
        let mut rest = text.strip_prefix(['V', 'C']).unwrap_or(text).trim_start();
        let mut soft_scale = None;
        if let Some(inner) = rest.strip_prefix('[') {
            let (name, behind) = inner.split_once(']')?;
            soft_scale = Some(name.trim().to_owned()).filter(|name| !name.is_empty());
            rest = behind.trim_start();
        }
        if rest.starts_with('(') {
            rest = rest[closing(rest)? + 1..].trim_start();
        }
        let (number, unit) = number_and_unit(rest)?;
        Some(Self { number, unit, soft_scale })
    }

    /// Reads the form of old files, `1500 nm (16384)`.
    pub fn parse_plain(text: &str) -> Option<Self> {
        let text = text.split('(').next().unwrap_or(text);
        let (number, unit) = number_and_unit(text.trim())?;
        Some(Self { number, unit, soft_scale: None })
    }
}

/// Returns the position of the closing parenthesis of the one that `text` begins with.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0;
    text.char_indices().find_map(|(i, c)| {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        (depth == 0).then_some(i)
    })
}

fn number_and_unit(text: &str) -> Option<(f64, String)> {
    let mut words = text.split_whitespace();
    let number = words.next()?.parse::<f64>().ok().filter(|x| x.is_finite())?;
    Some((number, words.next().unwrap_or_default().to_owned()))
}
