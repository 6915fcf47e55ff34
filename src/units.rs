//! Parsers of numbers with units, on the command line and in scene files.
//!
//! Lengths become micrometres and angles degrees. A length without a unit is an error. Every function is a plain `&str -> Result`, so that
//! it can be an argument's value parser.

use crate::error::{Error, Result};

/// Units of length as powers of ten of a micrometre. Both micro signs, U+00B5 and the Greek letter U+03BC, are common.
const LENGTHS: [(&str, i32); 6] =
    [("nm", -3), ("um", 0), ("\u{b5}m", 0), ("\u{3bc}m", 0), ("mm", 3), ("m", 6)];

/// Units of angle in degrees.
const ANGLES: [(&str, f64); 3] = [("deg", 1.0), ("\u{b0}", 1.0), ("rad", 180.0 / std::f64::consts::PI)];

/// Units of length on paper and screens \[mm\]; a pixel is that of SVG, 1/96 inch.
const PAGE_LENGTHS: [(&str, f64); 4] = [("mm", 1.0), ("cm", 10.0), ("in", 25.4), ("px", 25.4 / 96.0)];

/// Units of size on disk, decimal and binary, with their size \[bytes\].
const SIZES: [(&str, f64); 10] = [
    ("kB", 1e3),
    ("KB", 1e3),
    ("MB", 1e6),
    ("GB", 1e9),
    ("TB", 1e12),
    ("KiB", 1024.0),
    ("MiB", 1_048_576.0),
    ("GiB", 1_073_741_824.0),
    ("TiB", 1_099_511_627_776.0),
    ("B", 1.0),
];

/// Range of plausible lengths, 1 pm to 1 m \[µm\]; sums of their powers do not overflow.
const MEANT: (f64, f64) = (1e-6, 1e6);

/// Largest side of a picture in pixels: the common limit of Vulkan devices.
pub const MAX_PIXELS: u32 = 16_384;

/// Largest number of copies or windows along one axis.
pub const MAX_COUNT: u32 = 10_000;

/// Parses a positive length such as `65um`, `434.7nm`, `0.5mm` or `1µm` \[µm\].
///
/// # Errors
/// No number, a missing or unknown unit, a number that is not finite and positive, a length outside 1 pm … 1 m.
pub fn length(text: &str) -> Result<f64> {
    let value = length_or_zero(text)?;
    if value == 0.0 {
        return Err(not_positive(text));
    }
    Ok(value)
}

/// Parses a length like [`length`] that may also be 0, in any form: `0um`, `0.0nm` \[µm\].
///
/// # Errors
/// Those of [`length`], but for 0.
pub fn length_or_zero(text: &str) -> Result<f64> {
    let value = with_unit(text, &LENGTHS, "12nm, 12um or 12mm", shifted)?;
    if value == 0.0 {
        return Ok(0.0);
    }
    if value < 0.0 {
        return Err(not_positive(text));
    }
    if !(MEANT.0..=MEANT.1).contains(&value) {
        return Err(Error::usage(format!("'{}' is out of range", text.trim()), "write 0.001nm to 1m"));
    }
    Ok(value)
}

/// Parses a positive length on paper or on a screen such as `85mm`, `18cm`, `7in` or `800px` \[mm\].
///
/// # Errors
/// No number, a missing or unknown unit, a number that is not finite and positive.
pub fn page_length(text: &str) -> Result<f64> {
    let value = with_unit(text, &PAGE_LENGTHS, "85mm, 18cm, 7in or 800px", product)?;
    if value > 0.0 { Ok(value) } else { Err(not_positive(text)) }
}

/// Parses one length for both axes, or two as in `80nmx90nm` (`x` or `×`) \[µm\].
///
/// # Errors
/// Those of [`length`], for either.
pub fn length_pair(text: &str) -> Result<[f64; 2]> {
    match split_pair(text) {
        Some((x, y)) => Ok([length(x)?, length(y)?]),
        None => length(text).map(|both| [both; 2]),
    }
}

/// Parses a finite angle such as `30deg`, `-12.5°` or `0.5rad` \[degrees\].
///
/// # Errors
/// No number, a missing or unknown unit, a number that is not finite.
pub fn angle(text: &str) -> Result<f64> {
    with_unit(text, &ANGLES, "30deg", product)
}

/// Parses three finite numbers such as `0.3,1.7,-2`.
///
/// # Errors
/// Another number of fields, or one that is no number or beyond ±10⁹.
pub fn triple(text: &str) -> Result<[f64; 3]> {
    /// Largest absolute value, the same as for coordinates of meshes: squares still fit an `f32`.
    const LARGEST: f64 = 1e9;
    numbers(text)
        .filter(|numbers: &[f64; 3]| numbers.iter().all(|x| x.abs() <= LARGEST))
        .ok_or_else(|| Error::usage(format!("'{text}' is not three numbers"), "write X,Y,Z as in 0.3,1.7,-2"))
}

/// Parses two finite numbers such as `0.3,-0.2`.
///
/// # Errors
/// Another number of fields, or one that is no number.
pub fn pair(text: &str) -> Result<[f64; 2]> {
    numbers(text)
        .ok_or_else(|| Error::usage(format!("'{text}' is not two numbers"), "write X,Y as in 0.3,-0.2"))
}

/// Parses a positive number such as `2.5`.
///
/// # Errors
/// Text that is no number, and numbers that are not positive.
pub fn positive(text: &str) -> Result<f64> {
    number(text.trim())
        .filter(|&x| x > 0.0)
        .ok_or_else(|| Error::usage(format!("'{text}' is not a positive number"), "write it as in 2.5"))
}

/// Returns exactly `N` numbers that commas separate.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|field| number(field.trim())).collect();
    numbers?.try_into().ok()
}

/// Parses a colour as three numbers from 0 to 1, linear sRGB.
///
/// # Errors
/// Those of [`triple`], and numbers outside 0 … 1.
pub fn color(text: &str) -> Result<[f64; 3]> {
    let color = triple(text).ok().filter(|color| color.iter().all(|c| (0.0..=1.0).contains(c)));
    color.ok_or_else(|| {
        let remedy = "give R,G,B from 0 to 1 each, linear sRGB, as in 0.8,0.2,0.1";
        Error::usage(format!("'{text}' is no colour"), remedy)
    })
}

/// Parses a size in memory or on disk such as `2GiB`, `500MB` or `0` \[bytes\].
///
/// # Errors
/// No number, no unit or an unknown one, a negative number, more than 2⁶³ bytes.
pub fn bytes(text: &str) -> Result<u64> {
    const EXAMPLES: &str = "500MiB, 2GiB or 0";
    /// Largest size \[bytes\], exactly an `f64`.
    const LARGEST: f64 = (1u64 << 63) as f64;
    if number(text.trim()) == Some(0.0) {
        return Ok(0);
    }
    let value = with_unit(text, &SIZES, EXAMPLES, product)?;
    if !(0.0..=LARGEST).contains(&value) {
        return Err(Error::usage(format!("'{}' is out of range", text.trim()), format!("write {EXAMPLES}")));
    }
    Ok(value as u64)
}

/// Parses two counts such as `3x3`, each 1 … [`MAX_COUNT`].
///
/// # Errors
/// Another form or a count outside.
pub fn counts(text: &str) -> Result<[u32; 2]> {
    whole_pair(text, "3x3", MAX_COUNT)
}

/// Parses a picture size in pixels such as `1280x720`, each side 1 … [`MAX_PIXELS`].
///
/// # Errors
/// Another form or a side outside.
pub fn size(text: &str) -> Result<[u32; 2]> {
    whole_pair(text, "1280x720", MAX_PIXELS)
}

fn whole_pair(text: &str, example: &str, largest: u32) -> Result<[u32; 2]> {
    let remedy = format!("write two whole numbers from 1 to {largest}, as in {example}");
    let refuse = || Error::usage(format!("'{text}' is not a pair of whole numbers in range"), remedy.clone());
    let (x, y) = split_pair(text).ok_or_else(refuse)?;
    let whole = |part: &str| {
        let digits = part.bytes().all(|b| b.is_ascii_digit()); // "+3" is none
        let value = part.parse::<u32>().ok().filter(|n| digits && (1..=largest).contains(n));
        value.ok_or_else(refuse)
    };
    Ok([whole(x)?, whole(y)?])
}

/// Splits `text` at its only `x` or `×`.
fn split_pair(text: &str) -> Option<(&str, &str)> {
    let (first, second) = text.split_once(['x', '\u{d7}'])?;
    Some((first.trim(), second.trim()))
}

/// Parses a number followed by one of `units`; `scaled` returns the number that a text writes in its unit.
fn with_unit<S: Copy>(
    text: &str,
    units: &[(&str, S)],
    examples: &str,
    scaled: impl Fn(&str, S) -> Option<f64>,
) -> Result<f64> {
    let trimmed = text.trim();
    if trimmed.is_empty() {
        return Err(Error::usage("the value is empty", format!("write {examples}")));
    }
    // The longest unit that fits: "5nm" ends in "m" too, but its "5n" is no number.
    let fitting = units.iter().filter_map(|(unit, scale)| {
        let value = trimmed.strip_suffix(unit)?.trim_end();
        Some((number(value)?, scaled(value, *scale)?))
    });
    if let Some((number, value)) = fitting.into_iter().next() {
        // Reject products that overflow or underflow.
        let kept = value.is_finite() && (number == 0.0 || value != 0.0);
        let out_of_range =
            || Error::usage(format!("'{trimmed}' is out of range"), format!("write {examples}"));
        return kept.then_some(value).ok_or_else(out_of_range);
    }
    if number(trimmed).is_some() {
        return Err(Error::usage(format!("{trimmed} has no unit"), with_own_number(trimmed, examples)));
    }
    let known: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
    Err(Error::usage(
        format!("'{trimmed}' is not a number with a unit"),
        format!("write {examples} (units: {})", known.join(", ")),
    ))
}

/// Returns the number that `text` writes, times `scale`.
fn product(text: &str, scale: f64) -> Option<f64> {
    number(text).map(|number| number * scale)
}

/// Returns the decimal number that `text` writes with its point moved by `power` places, rounded once: 700 moved by −3 is 0.7, and 700 × 10⁻³ is not.
pub fn shifted(text: &str, power: i32) -> Option<f64> {
    number(text)?;
    let (digits, exponent) = match text.split_once(['e', 'E']) {
        Some((digits, exponent)) => (digits, exponent.parse::<i32>().ok()?),
        None => (text, 0),
    };
    format!("{digits}e{}", exponent.checked_add(power)?).parse().ok()
}

/// Returns `nanometres` in micrometres: the float that is nearest to the decimal number that prints as `nanometres`, moved by three places.
pub fn micrometres(nanometres: f64) -> f64 {
    shifted(&nanometres.to_string(), -3).unwrap_or(nanometres / 1e3)
}

/// Returns `write 12nm, 12um or 12mm`, with the number that the user wrote.
fn with_own_number(number: &str, examples: &str) -> String {
    let example = examples.trim_start_matches(|c: char| c.is_ascii_digit());
    let placeholder = &examples[..examples.len() - example.len()];
    format!("write {}", examples.replace(placeholder, number))
}

/// Parses a finite decimal number. The parser of Rust's standard library accepts `inf` and `NaN` as well.
pub fn number(text: &str) -> Option<f64> {
    let decimal = text.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+' | b'e' | b'E'));
    text.parse::<f64>().ok().filter(|value| decimal && value.is_finite())
}

fn not_positive(text: &str) -> Error {
    Error::usage(
        format!("the length {} is not positive", text.trim()),
        "give a length above zero, as in 12um",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * b.abs()
    }

    #[test]
    fn lengths_become_micrometres() {
        for (text, expected) in [
            ("65um", 65.0),
            ("434.7nm", 0.4347),
            ("0.5mm", 500.0),
            ("1\u{b5}m", 1.0),
            ("1\u{3bc}m", 1.0),
            (" 2e-3 mm ", 2.0),
            ("0.001m", 1000.0),
            (".5um", 0.5),
        ] {
            assert!(close(length(text).unwrap(), expected), "{text}");
        }
    }

    #[test]
    fn a_length_is_the_float_that_is_nearest_to_its_decimal_number() {
        for (text, expected) in [
            ("700nm", 0.7),
            ("550nm", 0.55),
            ("48.83nm", 0.048_83),
            ("1.14um", 1.14),
            ("4e2nm", 0.4),
            ("+4E+2nm", 0.4),
            ("0.001m", 1000.0),
            ("434.7nm", 0.4347),
        ] {
            assert_eq!(length(text).unwrap().to_bits(), f64::to_bits(expected), "{text}");
        }
        assert_eq!([380.1, 550.0, 1e-7].map(micrometres), [0.3801, 0.55, 1e-10]);
        assert_eq!((shifted("5e2147483647", 1), shifted("x", 1), shifted("", 1)), (None, None, None));
    }

    #[test]
    fn a_length_that_may_be_zero_is_so_in_any_form() {
        for text in ["0um", "0.0um", "+0 nm", "-0mm", "0e3m", ".0um"] {
            assert_eq!(length_or_zero(text).unwrap(), 0.0, "{text}");
            assert!(length(text).is_err(), "{text}");
        }
        assert_eq!(length_or_zero("5um").unwrap(), 5.0);
        for text in ["-1um", "0", "1e-9nm", "zero"] {
            assert!(length_or_zero(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_bare_number_is_told_its_units() {
        assert_eq!(length("12").unwrap_err().to_string(), "12 has no unit; write 12nm, 12um or 12mm");
        assert_eq!(angle("-7.5").unwrap_err().to_string(), "-7.5 has no unit; write -7.5deg");
    }

    #[test]
    fn what_is_no_positive_length_is_refused_with_exit_code_2() {
        for text in [
            "",
            " ",
            "um",
            "NaN",
            "NaNum",
            "inf",
            "infnm",
            "-infum",
            "0um",
            "-0nm",
            "-3um",
            "1e999um",
            "1e308m",
            "1e-323nm",
            "1e-4nm",
            "1.1m",
            "12km",
            "12 parsec",
            "1,5um",
            "0x10um",
            "5umum",
            "5u m",
            "--5um",
            "1_000nm",
            "\u{b5}m",
            "5\0um",
            "12deg",
        ] {
            let e = length(text).unwrap_err();
            assert_eq!(e.kind(), crate::error::ErrorKind::Usage, "{text}");
            assert!(e.to_string().contains("; "), "{text}");
        }
    }

    #[test]
    fn a_pair_is_two_lengths_and_one_length_is_both() {
        let pair = length_pair("80nmx90nm").unwrap();
        assert!(close(pair[0], 0.08) && close(pair[1], 0.09));
        let pair = length_pair("1um \u{d7} 0.5mm").unwrap();
        assert!(close(pair[0], 1.0) && close(pair[1], 500.0));
        assert_eq!(length_pair("2um").unwrap(), [2.0, 2.0]);
        for text in ["80nmx", "x90nm", "80x90nm", "1umx2umx3um", "x", "0nmx1nm"] {
            assert!(length_pair(text).is_err(), "{text}");
        }
    }

    #[test]
    fn angles_become_degrees_and_may_be_negative() {
        assert!(close(angle("30deg").unwrap(), 30.0));
        assert!(close(angle("-12.5\u{b0}").unwrap(), -12.5));
        assert!(close(angle("3.141592653589793rad").unwrap(), 180.0));
        assert_eq!(angle("0deg").unwrap(), 0.0);
        for text in ["", "deg", "30um", "infdeg", "1e400deg"] {
            assert!(angle(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_triple_has_three_numbers_and_a_colour_stays_within_one() {
        assert_eq!(triple("0.3, 1.7,-2e1").unwrap(), [0.3, 1.7, -20.0]);
        for text in ["", "1,2", "1,2,3,4", "1,,3", "1,2,x", "nan,0,0", "inf,0,0", "1e10,0,0", "1 2 3"] {
            assert!(triple(text).is_err() && color(text).is_err(), "{text}");
        }
        assert_eq!(color("0,0.5,1").unwrap(), [0.0, 0.5, 1.0]);
        let said = color("ff0000").unwrap_err().to_string();
        let advised = said.rsplit(' ').next().unwrap();
        assert!(color(advised).is_ok(), "what is advised is taken: {said}");
        assert!(color("0,0,1.1").is_err() && color("-0.1,0,0").is_err());
    }

    #[test]
    fn sizes_on_disk_have_decimal_or_binary_units_and_zero_needs_none() {
        for (text, expected) in [
            ("2GiB", 2 << 30),
            ("500MB", 500_000_000),
            ("1.5 KiB", 1536),
            ("7B", 7),
            ("0", 0),
            ("0MiB", 0),
            ("8388608TiB", 1 << 63),
        ] {
            assert_eq!(bytes(text).unwrap(), expected, "{text}");
        }
        assert_eq!(bytes("500").unwrap_err().to_string(), "500 has no unit; write 500MiB, 2GiB or 0");
        for text in ["", "GiB", "-1MiB", "8388609TiB", "1e400GB", "infMiB", "NaNB", "2 gigabytes", "0x10MB"] {
            assert_eq!(bytes(text).unwrap_err().kind(), crate::error::ErrorKind::Usage, "{text}");
        }
    }

    #[test]
    fn counts_and_sizes_are_whole_and_bounded() {
        assert_eq!(counts("3x4").unwrap(), [3, 4]);
        assert_eq!(size("1280x720").unwrap(), [1280, 720]);
        assert_eq!(size("16384x1").unwrap(), [16384, 1]);
        for text in ["", "x", "3", "0x3", "3x-3", "3.0x3", "+3x3", "3x3x3", "99999999999x1", "axb"] {
            assert!(counts(text).is_err(), "{text}");
            assert!(size(text).is_err(), "{text}");
        }
        assert!(size("16385x1").is_err());
    }
}
