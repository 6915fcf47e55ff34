//! Lines in front of a matrix of heights, in which programs write its scales.
//!
//! Gwyddion's export, SPIP's ASCII, Nova's ASCII, Keyence's CSV and ESRI's ASCII grid. Facts after those programs' files and Gwyddion's
//! readers. A `Scale X` of Nova with a unit of its own is the width of the image, one without the distance of samples.

use super::header::TextHeader;
use super::scan::spacing;
use super::units;

/// Metres of a nanometre.
const NANOMETRE: f64 = 1e-9;

/// Number of a sample without data in ESRI's grids that do not name another.
const NO_DATA: f64 = -9999.0;

/// Names of the unit of heights.
const UNITS: [&str; 5] = ["Unit of Z", "Unit Data", "z-unit", "Z unit", "Unit"];

/// Scales and sizes that the lines in front of a matrix give.
#[derive(Clone, Debug)]
pub struct TextHead {
    /// The format, for people.
    pub format: &'static str,
    /// Name of the channel.
    pub name: String,
    /// Unit of the numbers.
    pub unit: String,
    /// Size of one unit of the numbers, in `unit`.
    pub factor: f64,
    /// Columns and rows, if the lines count them.
    pub counts: Option<[u64; 2]>,
    /// Width and height of the image \[m\].
    pub sides: [Option<f64>; 2],
    /// Distance of samples \[m\], if the lines give it instead.
    pub spacing: [Option<f64>; 2],
    /// Number of a sample that was not measured.
    pub missing: Option<f64>,
    /// True if a matrix of the same size follows, in which samples that were not measured are 1.
    pub has_mask: bool,
}

impl Default for TextHead {
    fn default() -> Self {
        Self {
            format: "text",
            name: "matrix".to_owned(),
            unit: "m".to_owned(),
            factor: 1.0,
            counts: None,
            sides: [None; 2],
            spacing: [None; 2],
            missing: None,
            has_mask: false,
        }
    }
}

impl TextHead {
    /// Reads the lines `head`; those of no known program say nothing but the unit of heights.
    pub fn read(head: &[String]) -> Self {
        if let Some(found) = gwyddion(head) {
            return found;
        }
        let header = entries(head);
        let has = |key: &str| header.text("", key).is_some();
        let unit = UNITS.iter().find_map(|key| header.text("", key)).map(str::to_owned);
        let plain = Self { unit: unit.clone().unwrap_or_else(|| "m".to_owned()), ..Self::default() };
        let counts =
            |keys: [&str; 2]| Some([header.count("", keys[0]).ok()?, header.count("", keys[1]).ok()?]);
        let number = |key: &str| header.number("", key);
        if has("x-pixels") && has("x-length") {
            let bit = number("Bit2nm").filter(|_| unit.is_none());
            return Self {
                format: "SPIP ASCII",
                unit: if bit.is_some() { "nm".to_owned() } else { plain.unit },
                factor: bit.unwrap_or(1.0),
                counts: counts(["x-pixels", "y-pixels"]),
                sides: ["x-length", "y-length"].map(|key| Some(number(key)? * NANOMETRE)),
                has_mask: number("voidpixels").is_some_and(|count| count > 0.0),
                ..Self::default()
            };
        }
        if has("NX") && has("Scale X") {
            let side =
                |axis: &str| header.text("", &format!("Scale {axis}")).and_then(units::measured_length);
            let step = |axis: &str| {
                let unit = units::length(header.text("", &format!("Unit {axis}"))?)?;
                spacing(number(&format!("Scale {axis}"))? * unit, 1)
            };
            let counts = counts(["NX", "NY"]);
            return Self {
                format: "Nova ASCII",
                counts,
                sides: ["X", "Y"].map(side),
                spacing: ["X", "Y"].map(step),
                ..plain
            };
        }
        if has("XY calibration") {
            let pixel = header.text("", "XY calibration").map(|text| text.replace(',', " "));
            let pixel = pixel.as_deref().and_then(units::measured_length).and_then(|d| spacing(d, 1));
            return Self { format: "Keyence CSV", spacing: [pixel; 2], ..plain };
        }
        if has("ncols") {
            let cell = number("cellsize");
            return Self {
                format: "ESRI ASCII grid",
                spacing: ["dx", "dy"].map(|key| spacing(cell.or(number(key))?, 1)),
                counts: counts(["ncols", "nrows"]),
                missing: Some(number("NODATA_value").unwrap_or(NO_DATA)),
                ..plain
            };
        }
        plain
    }
}

/// Returns keys and values of the lines, which stand before and behind the first equals sign, colon, comma, tab or blank.
fn entries(head: &[String]) -> TextHeader {
    let mut header = TextHeader::default();
    for line in head {
        let line = line.trim_start_matches(['#', '%', '/', ' ']);
        if let Some((key, value)) = ['=', ':', ',', '\t', ' '].iter().find_map(|c| line.split_once(*c)) {
            // Micro in Shift-JIS, which Keyence's program writes.
            header.insert("", key, &value.replace("\u{83}\u{ca}", "\u{b5}"));
        }
    }
    header
}

/// Parses the four lines of Gwyddion's export, which are recognised by the two lengths.
fn gwyddion(head: &[String]) -> Option<TextHead> {
    let entries: Vec<&str> =
        head.iter().filter_map(|line| Some(line.strip_prefix('#')?.split_once(':')?.1.trim())).collect();
    entries.windows(4).find_map(|lines| {
        let [name, width, height, unit] = lines else { return None };
        let sides = [units::measured_length(width)?, units::measured_length(height)?].map(Some);
        let (name, unit) = ((*name).to_owned(), (*unit).to_owned());
        Some(TextHead { format: "Gwyddion text", name, unit, sides, ..TextHead::default() })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> TextHead {
        TextHead::read(&text.lines().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn spip_has_nanometres_and_nova_either_widths_or_steps() {
        let spip = read(
            "# File Format = ASCII\n# x-pixels = 4\n# y-pixels = 3\n# x-length = 400\n# y-length = 600\n# Bit2nm = 2",
        );
        assert_eq!((spip.unit.as_str(), spip.factor, spip.counts), ("nm", 2.0, Some([4, 3])));
        assert!((spip.sides[1].unwrap() - 6e-7).abs() < 1e-18 && !spip.has_mask);
        let nova = read("NX = 64\nNY = 48\nScale X = 6.4 um\nScale Y = 4.8 um\nUnit of Z = nm");
        assert!(
            (nova.sides[0].unwrap() - 6.4e-6).abs() < 1e-15 && nova.spacing[0].is_none() && nova.unit == "nm"
        );
        let nova =
            read("NX = 64\nNY = 48\nScale X = 0.5\nScale Y = 0.5\nUnit X = um\nUnit Y = um\nUnit Data = A");
        assert_eq!((nova.sides[0], nova.spacing[0], nova.unit.as_str()), (None, Some(5e-7), "A"));
    }

    #[test]
    fn keyence_and_esri_have_distances_of_samples() {
        let keyence = read("XY calibration,100.000,nm\nUnit,\u{83}\u{ca}m\nHeight");
        assert!((keyence.spacing[1].unwrap() - 1e-7).abs() < 1e-18 && keyence.unit == "\u{b5}m");
        let esri = read("ncols        4\nnrows        3\nxllcorner 0.0\ncellsize     2.5\nNODATA_value -1");
        assert_eq!((esri.spacing, esri.missing, esri.counts), ([Some(2.5); 2], Some(-1.0), Some([4, 3])));
    }
}
