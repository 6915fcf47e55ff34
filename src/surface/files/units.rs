//! Units in the spellings of instruments.

/// SI prefixes. Nanoscope files write `~` for µ.
const PREFIXES: [(&str, f64); 12] = [
    ("f", 1e-15),
    ("p", 1e-12),
    ("n", 1e-9),
    ("u", 1e-6),
    ("\u{b5}", 1e-6),
    ("\u{3bc}", 1e-6),
    ("~", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("d", 1e-1),
    ("k", 1e3),
    ("M", 1e6),
];

/// Lengths that are not metres with a prefix \[m\].
const OTHER_LENGTHS: [(&str, f64); 12] = [
    ("meter", 1.0),
    ("metre", 1.0),
    ("nanometer", 1e-9),
    ("micron", 1e-6),
    ("micrometer", 1e-6),
    ("micrometre", 1e-6),
    ("millimeter", 1e-3),
    ("\u{c5}", 1e-10),
    ("\u{212b}", 1e-10),
    ("angstrom", 1e-10),
    ("inch", 25.4e-3),
    ("in", 25.4e-3),
];

/// Returns the length of one `unit` \[m\]; `None` if it is no length.
pub fn length(unit: &str) -> Option<f64> {
    let unit = unit.trim();
    let lower = unit.to_lowercase();
    let one = lower.strip_suffix('s').unwrap_or(&lower);
    let other = OTHER_LENGTHS.iter().find(|(name, _)| *name == unit || *name == lower || *name == one);
    other.map(|(_, metres)| *metres).or_else(|| prefixed(unit, "m"))
}

/// Returns true if `unit` is known and of another quantity than length.
pub fn is_of_another_quantity(unit: &str) -> bool {
    const BASES: [&str; 13] = ["V", "A", "N", "Hz", "s", "K", "Pa", "W", "J", "g", "rad", "F", "C"];
    const OTHERS: [&str; 10] =
        ["deg", "degree", "degrees", "\u{b0}", "\u{ba}", "\u{b0}C", "\u{2126}", "Ohm", "%", "radian"];
    /// Letters with other meanings, such as ångström and counts.
    const AMBIGUOUS: [&str; 4] = ["A", "C", "F", "g"];
    let unit = unit.trim();
    let is_known = !AMBIGUOUS.contains(&unit);
    OTHERS.contains(&unit) || is_known && BASES.iter().any(|base| prefixed(unit, base).is_some())
}

/// Returns the factor of `unit`, a multiple of `base` by an SI prefix; `None` if it is another quantity.
pub fn prefixed(unit: &str, base: &str) -> Option<f64> {
    let prefix = unit.strip_suffix(base)?;
    if prefix.is_empty() {
        return Some(1.0);
    }
    PREFIXES.iter().find(|(name, _)| *name == prefix).map(|(_, factor)| *factor)
}

/// Parses a number and the unit behind it, as in `12.34 µm`; a decimal comma counts as a point.
pub fn number_with_unit(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    let number = text[..end].replace(',', ".").parse::<f64>().ok().filter(|x| x.is_finite())?;
    Some((number, text[end..].trim()))
}

/// Parses a length with its unit, as in `12.34 µm` \[m\].
pub fn measured_length(text: &str) -> Option<f64> {
    let (number, unit) = number_with_unit(text)?;
    Some(number * length(unit)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_prefixes_or_names_and_other_quantities_are_none() {
        for (unit, metres) in [
            ("m", 1.0),
            ("nm", 1e-9),
            (" \u{b5}m ", 1e-6),
            ("\u{3bc}m", 1e-6),
            ("~m", 1e-6),
            ("mm", 1e-3),
            ("pm", 1e-12),
            ("\u{c5}", 1e-10),
            ("Micrometer", 1e-6),
        ] {
            assert_eq!(length(unit), Some(metres), "{unit}");
        }
        for unit in ["", "V", "deg", "A", "nm/V", "xm", "Hz", "\u{e9}m"] {
            assert_eq!(length(unit), None, "{unit}");
        }
        for unit in ["V", "mV", "deg", "rad", "nA", "kHz", " N ", "\u{b0}"] {
            assert!(is_of_another_quantity(unit), "{unit}");
        }
        for unit in ["", "nm", "a.u.", "nm/V", "counts", "in", "A"] {
            assert!(!is_of_another_quantity(unit), "{unit}");
        }
        assert_eq!(prefixed("mV", "V"), Some(1e-3));
        assert_eq!(prefixed("Arb", "V"), None);
    }

    #[test]
    fn numbers_keep_their_units() {
        assert_eq!(number_with_unit(" 12.34 \u{b5}m"), Some((12.34, "\u{b5}m")));
        assert_eq!(number_with_unit("12,34 nm"), Some((12.34, "nm")));
        assert_eq!(number_with_unit("7"), Some((7.0, "")));
        assert_eq!(number_with_unit("nan m"), None);
    }
}
