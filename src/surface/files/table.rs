//! Lines of numbers, as written by instruments and spreadsheets.

use super::bytes::{Order, damaged, decode_text, wide_text};
use crate::error::{Error, Result};
use crate::memory;
use std::borrow::Cow;

/// Words for a sample that was not measured, in lower case.
const MISSING: [&str; 6] = ["nan", "bad", "n/a", "null", "---", "--"];

/// Numbers of a table, row by row.
#[derive(Debug, PartialEq)]
pub struct TextTable {
    /// Numbers of a row.
    pub columns: usize,
    /// All numbers; NaN for samples that were not measured.
    pub numbers: Vec<f64>,
    /// Lines before the first row of numbers, without white space around them.
    pub head: Vec<String>,
    /// True if the last of those lines names every column.
    pub titled: bool,
}

/// Separator of the numbers, with or without white space.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Style {
    /// White space.
    Blank,
    /// This character, and perhaps white space around it.
    Separated(char),
}

/// Reads rows of equally many numbers. Empty lines and lines that begin with `#`, `%` or `//` are comments; lines in front of the first
/// number are the head. Numbers are separated by white space, commas, semicolons or tabs. If the separator is not a comma, commas are
/// decimal points.
///
/// # Errors
/// A row of another length, a word that is no number, no row at all; no room.
pub fn parse(text: &str) -> Result<TextTable> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // The lines of old Macintosh programs end in CR alone.
    let ends = if text.contains('\n') { '\n' } else { '\r' };
    let mut table = TextTable { columns: 0, numbers: Vec::new(), head: Vec::new(), titled: false };
    let mut style = None;
    for (i, line) in text.split(ends).enumerate() {
        let unquoted = if line.contains('"') { Cow::Owned(unquoted(line)) } else { Cow::Borrowed(line) };
        let line = unquoted.trim_matches(|c: char| c == ' ' || c == '\r');
        let comment = line.starts_with(['#', '%']) || line.starts_with("//");
        if line.trim().is_empty() || comment {
            if style.is_none() && comment {
                table.head.push(line.to_owned());
            }
            continue;
        }
        let (separation, comma) = *match &mut style {
            Some(style) => style,
            None if !begins_with_a_number(line) => {
                table.head.push(line.to_owned());
                continue;
            }
            none => {
                // A number takes a digit and a separator at least.
                memory::ensure_room(text.len() as u64 / 2 * 8, "the numbers of a text")?;
                none.insert(style_of(line))
            }
        };
        let before = table.numbers.len();
        fields(line, separation, |word| {
            table.numbers.push(number(word, comma).ok_or_else(|| {
                Error::input(
                    format!("line {}: `{}` is no number", i + 1, shortened(word)),
                    "write one height a field",
                )
            })?);
            Ok(())
        })?;
        let found = table.numbers.len() - before;
        if before == 0 {
            table.columns = found;
            table.titled =
                found > 1 && table.head.last().is_some_and(|line| titles(line, separation) == found);
        } else if found != table.columns {
            return Err(Error::input(
                format!("line {} has {found} numbers, lines before it have {}", i + 1, table.columns),
                "write equally many numbers a line",
            ));
        }
    }
    if table.numbers.is_empty() {
        return Err(damaged("it holds no numbers"));
    }
    Ok(table)
}

/// Returns a line without its quotes. What they enclose has a decimal point for a comma, and no other commas.
fn unquoted(line: &str) -> String {
    let mut plain = String::with_capacity(line.len());
    for (i, part) in line.split('"').enumerate() {
        let is_quoted = i % 2 == 1;
        match (is_quoted, part.matches(',').count()) {
            (true, 1) if !part.contains('.') => plain.push_str(&part.replace(',', ".")),
            (true, 1..) => plain.push_str(&part.replace(',', "")),
            _ => plain.push_str(part),
        }
    }
    plain
}

/// Decodes a text: UTF-16 of either byte order, with a byte order mark or of letters with a NUL each; UTF-8; or Latin-1.
pub fn decoded(bytes: &[u8]) -> String {
    match wide_order(bytes) {
        Some(order) => wide_text(bytes, order),
        None => decode_text(bytes),
    }
}

/// Returns the byte order of a text in UTF-16; `None` for other content.
pub fn wide_order(bytes: &[u8]) -> Option<Order> {
    /// Bytes that show the byte order of a text without a mark.
    const SHOWN: usize = 32;
    let is_letter = |b: &u8| b.is_ascii_graphic() || b.is_ascii_whitespace();
    let shown = bytes.get(..bytes.len().min(SHOWN) & !1).filter(|shown| shown.len() >= 8)?;
    let all = |is: &dyn Fn(&u8, &u8) -> bool| shown.chunks_exact(2).all(|pair| is(&pair[0], &pair[1]));
    match bytes {
        [0xff, 0xfe, ..] => Some(Order::Little),
        [0xfe, 0xff, ..] => Some(Order::Big),
        _ if all(&|low, high| is_letter(low) && *high == 0) => Some(Order::Little),
        _ if all(&|high, low| is_letter(low) && *high == 0) => Some(Order::Big),
        _ => None,
    }
}

fn begins_with_a_number(line: &str) -> bool {
    let first = line.trim_start().split([' ', '\t', ',', ';']).next().unwrap_or_default();
    // A comma in the middle may be a decimal point, and then the part before it is a number, too.
    number(first, false).is_some()
}

/// Counts the fields of `line`; 0 for a comment.
fn titles(line: &str, style: Style) -> usize {
    let comment = line.starts_with(['#', '%']) || line.starts_with("//");
    let mut count = 0;
    // The closure never fails.
    let _ = fields(line, style, |_| {
        count += 1;
        Ok(())
    });
    if comment { 0 } else { count }
}

/// Returns the separator of `line`, the first one of numbers, and true if its commas are decimal points.
fn style_of(line: &str) -> (Style, bool) {
    let comma = line.contains(',');
    if line.contains(';') {
        return (Style::Separated(';'), comma);
    }
    if line.trim().contains('\t') {
        // Tabs before or after commas, as in "1,\t2": the commas separate.
        let separates = line.contains(",\t") || line.contains(", ");
        return if comma && separates {
            (Style::Separated(','), false)
        } else {
            (Style::Separated('\t'), comma)
        };
    }
    let blanks = line.trim().contains(' ');
    if comma && (!blanks || line.contains(", ") || line.contains(" ,")) {
        return (Style::Separated(','), false);
    }
    (Style::Blank, comma)
}

/// Calls `each` with the fields of `line`; one separator at its end is no field.
fn fields(line: &str, style: Style, mut each: impl FnMut(&str) -> Result<()>) -> Result<()> {
    match style {
        Style::Blank => line.split_whitespace().try_for_each(each),
        Style::Separated(separator) => {
            let line = line.strip_suffix(separator).unwrap_or(line);
            line.split(separator).try_for_each(|field| each(field.trim()))
        }
    }
}

fn number(word: &str, comma: bool) -> Option<f64> {
    let plain = word.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+' | b'e' | b'E'));
    if plain && !word.is_empty() {
        return word.parse().ok();
    }
    if word.contains(['D', 'd', '\u{2212}']) {
        // Fortran's exponents, and the minus sign of typesetters.
        let usual = word.replace(['D', 'd'], "e").replace('\u{2212}', "-");
        if !usual.is_empty() && usual.starts_with(|c: char| c.is_ascii_digit() || "+-.,".contains(c)) {
            return number(&usual, comma);
        }
    }
    if comma && word.contains(',') {
        return number(&word.replace(',', "."), false);
    }
    let word = word.trim_start_matches(['-', '+']).to_lowercase();
    (word.is_empty() || word.starts_with("inf") || MISSING.contains(&word.as_str())).then_some(f64::NAN)
}

fn shortened(word: &str) -> String {
    word.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> (usize, Vec<f64>) {
        let table = parse(text).unwrap();
        (table.columns, table.numbers)
    }

    #[test]
    fn numbers_stand_apart_by_anything_common() {
        let expected = (3, vec![1.5, -2.0, 3e-9, 4.0, 5.0, 6.0]);
        for text in [
            "1.5 -2 3e-9\n4 5 6\n",
            "1.5\t-2\t3e-9\t\r\n4\t5\t6\t\r\n",
            "1.5,-2,3e-9\n4,5,6",
            "1.5, -2, 3e-9\n4, 5, 6\n",
            "1.5;-2;3e-9;\n4;5;6;\n",
            "1,5;-2,0;3e-9\n4;5;6\n",
            "1,5 -2 3,0e-9\n4 5 6\n",
            "1,5\t-2,0\t3e-9\n4\t5\t6\n",
            "  1.5   -2 3e-9\n\n# half\n4 5 6",
            "\u{feff}x;y;z\n1,5;-2;3E-9\n4;5;6\n",
        ] {
            assert_eq!(rows(text), expected, "{text:?}");
        }
    }

    #[test]
    fn what_was_not_measured_is_nan_and_the_head_is_kept() {
        let table = parse("# Channel: A\nx,y\n1,nan,3\n,BAD,inf\n").unwrap();
        assert_eq!((table.columns, &table.head), (3, &vec!["# Channel: A".to_owned(), "x,y".to_owned()]));
        assert!(!table.titled && parse("a,b\n1,2\n").unwrap().titled);
        assert_eq!(table.numbers.iter().filter(|x| x.is_nan()).count(), 4);
    }

    #[test]
    fn texts_of_other_makers_have_the_same_numbers() {
        let expected = (2, vec![0.5, -2e-3, 3.0, 4.0]);
        for text in [
            "0.5 -2\r3 4\r".replace("-2", "-2D-3"),
            "\"0,5\",\"-0,002\"\n\"3\",\"4\"\n".to_owned(),
            "0,5;\u{2212}2d-3\n3;4\n".to_owned(),
        ] {
            assert_eq!(rows(&text), expected, "{text:?}");
        }
        let wide = |order: &dyn Fn(u16) -> [u8; 2]| {
            "0.5 -2e-3\n3 4\n".encode_utf16().flat_map(order).collect::<Vec<u8>>()
        };
        for bytes in [
            wide(&u16::to_le_bytes),
            wide(&u16::to_be_bytes),
            [&[0xff, 0xfe][..], &wide(&u16::to_le_bytes)].concat(),
        ] {
            assert_eq!(rows(&decoded(&bytes)), expected);
        }
        assert!(parse("1 2\n3 bad1\n").is_err() && wide_order(b"1 2\n3 4\n").is_none());
    }

    #[test]
    fn ragged_rows_and_words_are_refused_by_line() {
        assert!(parse("1 2\n3\n").unwrap_err().to_string().contains("line 2"));
        assert!(parse("1 2\n\n3 x\n").unwrap_err().to_string().contains("line 3: `x`"));
        assert!(parse("").is_err() && parse("# only\nwords\n").is_err());
    }
}
