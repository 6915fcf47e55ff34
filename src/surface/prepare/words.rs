//! Steps in words: `level plane`, `crop 40umx20um`, `invert`.

use super::{Crop, Levelling, PreparationStep, Rotation, Tile};
use crate::error::{Error, Result};
use crate::units;
use std::fmt;

/// Every step's word, which is the name of its option, and the form of its value; empty for a step without a value.
pub const WORDS: [(&str, &str); 10] = [
    ("level", "none|mean|plane|polynomial:N|rows|rows-median|facet"),
    ("despike", ""),
    ("destripe", ""),
    ("deconvolve-tip", "RADIUS"),
    ("crop", "LENGTH[xLENGTH][+X+Y]"),
    ("resample", "LENGTH"),
    ("rotate", "ANGLE|auto"),
    ("taper", "LENGTH"),
    ("tile", "mirror|blend[:LENGTH]"),
    ("invert", ""),
];

/// One of each kind of step, for tests.
#[cfg(test)]
pub(super) const EXAMPLES: [&str; 21] = [
    "level none",
    "level mean",
    "level plane",
    "level polynomial:3",
    "level rows",
    "level rows-median",
    "level facet",
    "despike",
    "destripe",
    "deconvolve-tip 10nm",
    "crop 0.2um",
    "crop 40umx20.5um+5um+0um",
    "resample 97.66nm",
    "resample 80nmx90nm",
    "rotate 30deg",
    "rotate 90deg",
    "rotate auto",
    "taper 0.1um",
    "tile mirror",
    "tile blend:50nm",
    "invert",
];

impl PreparationStep {
    /// Parses a step, its word first: `level plane`.
    ///
    /// # Errors
    /// An unknown word; a value that is missing, superfluous or cannot be meant.
    pub fn parse(text: &str) -> Result<Self> {
        let text = text.trim();
        let (word, value) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        Self::from_option(word, value.trim())
    }

    /// Parses the step of `word` with `value`; `value` is empty for a step that takes none.
    ///
    /// # Errors
    /// See [`PreparationStep::parse`].
    pub fn from_option(word: &str, value: &str) -> Result<Self> {
        let without = |step| {
            let refuse = || Error::usage(format!("`{word}` takes no value"), format!("write `{word}` alone"));
            value.is_empty().then_some(step).ok_or_else(refuse)
        };
        match word {
            "level" => Levelling::parse(value).map(Self::Level),
            "despike" => without(Self::Despike),
            "destripe" => without(Self::Destripe),
            "deconvolve-tip" => units::length(value).map(Self::DeconvolveTip),
            "crop" => Crop::parse(value).map(Self::Crop),
            "resample" => units::length_pair(value).map(Self::Resample),
            "rotate" => Rotation::parse(value).map(Self::Rotate),
            "taper" => units::length(value).map(Self::Taper),
            "tile" => Tile::parse(value).map(Self::Tile),
            "invert" => without(Self::Invert),
            _ => {
                let known = WORDS.map(|(word, _)| word).join(", ");
                Err(Error::usage(format!("there is no step `{word}`"), format!("give one of {known}")))
            }
        }
    }
}

impl fmt::Display for PreparationStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Level(level) => write!(f, "level {level}"),
            Self::Despike => f.write_str("despike"),
            Self::Destripe => f.write_str("destripe"),
            Self::DeconvolveTip(radius) => write!(f, "deconvolve-tip {}", length(*radius)),
            Self::Crop(crop) => write!(f, "crop {crop}"),
            Self::Resample(spacing) => write!(f, "resample {}", lengths(*spacing)),
            Self::Rotate(rotation) => write!(f, "rotate {rotation}"),
            Self::Taper(taper) => write!(f, "taper {}", length(*taper)),
            Self::Tile(tile) => write!(f, "tile {tile}"),
            Self::Invert => f.write_str("invert"),
        }
    }
}

/// Writes a length \[µm\] in the unit with the shortest text, so that [`units::length`] reads the same number.
pub(super) fn length(um: f64) -> String {
    /// Decimal digits that a rounded number keeps; more than any instrument has.
    const DIGITS: f64 = 1e12;
    let rounded = |x: f64| {
        let power = 10f64.powf(x.abs().log10().floor());
        (x / power * DIGITS).round() / DIGITS * power
    };
    let candidates = [("um", 1.0), ("nm", 1e3), ("mm", 1e-3)].into_iter().flat_map(|(unit, per_um)| {
        let value = um * per_um;
        [value, rounded(value)].map(|value| format!("{value}{unit}"))
    });
    let exact = candidates.filter(|text| units::length(text).is_ok_and(|read| read == um));
    exact.min_by_key(String::len).unwrap_or_else(|| format!("{um}um"))
}

/// Writes a length \[µm\] to four digits, for messages.
pub(super) fn about(um: f64) -> String {
    let decimals = (3.0 - um.abs().max(1e-6).log10().floor()).max(0.0) as usize;
    let text = format!("{um:.decimals$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{short}um")
}

/// Writes two lengths \[µm\], or one if both are equal.
pub(super) fn lengths([x, y]: [f64; 2]) -> String {
    if x == y { length(x) } else { format!("{}x{}", length(x), length(y)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn what_is_written_is_read_again() {
        for text in EXAMPLES {
            let step = PreparationStep::parse(text).unwrap();
            assert_eq!(step.to_string(), text);
            assert_eq!(PreparationStep::parse(&step.to_string()).unwrap(), step);
        }
        assert_eq!(PreparationStep::parse("  crop   40um ").unwrap().to_string(), "crop 40um");
        assert_eq!(PreparationStep::parse("taper 0.5mm").unwrap().to_string(), "taper 500um");
    }

    #[test]
    fn every_length_is_read_as_the_same_number() {
        let mut random = Random::new(2);
        for _ in 0..1000 {
            let length = 10f64.powf(4.0 * random.signed());
            let step = PreparationStep::Resample([length, 1.0]);
            assert_eq!(PreparationStep::parse(&step.to_string()).unwrap(), step, "{step}");
        }
    }

    #[test]
    fn messages_have_four_digits() {
        for (um, expected) in
            [(1.4000000000000001, "1.4um"), (65.0, "65um"), (0.012_345_6, "0.01235um"), (12_345.0, "12345um")]
        {
            assert_eq!(about(um), expected);
        }
    }

    #[test]
    fn every_word_has_an_example_and_a_step() {
        for (word, _) in WORDS {
            assert!(EXAMPLES.iter().any(|text| text.split(' ').next() == Some(word)), "{word}");
        }
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_exit_code_2() {
        for text in [
            "",
            "levels plane",
            "level",
            "level top",
            "level Mean",
            "level polynomial",
            "level polynomial:0",
            "level polynomial:13",
            "level polynomial:-1",
            "level polynomial:2.5",
            "despike 3",
            "destripe x",
            "invert yes",
            "deconvolve-tip",
            "deconvolve-tip 10",
            "deconvolve-tip 0nm",
            "deconvolve-tip -10nm",
            "crop",
            "crop 40",
            "crop 0um",
            "crop 40umx",
            "crop 40um+5um",
            "crop 40um+-5um+0um",
            "crop 40um+5um+5",
            "crop 1umx1umx1um",
            "resample",
            "resample 0nm",
            "resample 50",
            "rotate",
            "rotate 30",
            "rotate nandeg",
            "rotate autos",
            "rotate 361deg",
            "taper",
            "taper -1um",
            "tile",
            "tile blends",
            "tile blend:",
            "tile blend:0um",
            "tile mirror:5um",
        ] {
            let e = PreparationStep::parse(text).unwrap_err();
            assert_eq!(e.kind(), crate::error::ErrorKind::Usage, "{text}");
            assert!(e.to_string().contains("; "), "{text}: {e}");
        }
    }
}
