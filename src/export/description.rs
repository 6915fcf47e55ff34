//! `material.json`: the meaning of the numbers of an export, how they were made, and how well they hold.

use super::{ExportSettings, ExportedMaterial};
use crate::error::{Error, Result};
use crate::notes::{self, PreparationRecord};
use crate::optics::validity::{LightColour, ScalarTheory};
use crate::surface::HeightField;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// Word by which an export is known.
const FORMAT: &str = "diffract-material";
/// Version of the format. It changes whenever a reader of the former one would misread an export. Levels of version 2 were an octave apart.
pub(super) const VERSION: u64 = 4;

/// Everything about an exported material but its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaterialDescription {
    /// `diffract-material`.
    pub format: String,
    /// Version of the format.
    pub version: u64,
    /// Name and version of the program.
    pub program: String,
    /// Command that writes the same export; empty if there is none.
    pub command: String,
    /// Meaning of axes, signs and units, in words.
    pub conventions: BTreeMap<String, String>,
    /// Steps that prepared the heights, oldest first.
    #[serde(default)]
    pub prepared_by: PreparationRecord,
    /// The surface.
    pub surface: SurfaceFacts,
    /// Coherence length of the light \[µm\]: four standard deviations of the coherence window.
    pub coherence_length_um: f64,
    /// Continuation of the surface beyond the patch: `copies` or `alike`.
    pub beyond: String,
    /// Spectrum of the light.
    pub illuminant: Value,
    /// Reflectance of the surface, which the table holds.
    pub reflectance: Value,
    /// Theory of the factor: `small-slope` or `stam`.
    pub theory: String,
    /// Errors of scalar theory for this surface and material, in words.
    pub scalar_theory: String,
    /// Relative error that was asked for.
    pub tolerance: f64,
    /// Standard deviation of (u, v) of the smallest footprint that the table serves; 0 for single directions.
    pub smallest_footprint: f64,
    /// Bytes of the texels of all levels.
    pub table_bytes: usize,
    /// Errors of the table against the exact mean in f64.
    pub errors: MeasuredErrors,
    /// Size and check sum of each other file.
    pub files: BTreeMap<String, FileSum>,
    /// BLAKE3 of the text of `material.json` with zeros in place of these 64 hexadecimal digits.
    pub description_blake3: String,
}

/// Height field of an export.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceFacts {
    /// BLAKE3 of columns and rows (u64), the two distances between samples \[µm\] (f64) and the heights \[µm\] (f64) row by row, all little-endian.
    pub blake3: String,
    /// Samples along x and y.
    pub samples: [usize; 2],
    /// Distances between samples along x and y \[µm\].
    pub pixel_size_um: [f64; 2],
    /// Lowest and highest height \[µm\].
    pub heights_um: [f64; 2],
}

/// Errors of a table over the directions of `conformance.csv`, in linear sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredErrors {
    /// Number of directions.
    pub directions: usize,
    /// ‖table − exact‖/‖exact‖ over all directions together.
    pub relative_l2: f64,
    /// RMS over directions of the error relative to the direction's own colour.
    pub own_rms: f64,
    /// 99th percentile of the same.
    pub own_p99: f64,
}

/// Size and check sum of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileSum {
    /// Bytes.
    pub bytes: u64,
    /// BLAKE3, 64 hexadecimal digits.
    pub blake3: String,
}

impl FileSum {
    /// Computes the sum of a file with these `bytes`.
    pub fn new(bytes: &[u8]) -> Self {
        let hash = blake3::Hasher::new().update_rayon(bytes).finalize();
        Self { bytes: bytes.len() as u64, blake3: hash.to_hex().to_string() }
    }
}

impl SurfaceFacts {
    fn new(field: &HeightField) -> Self {
        let mut hasher = blake3::Hasher::new();
        for count in [field.columns(), field.rows()] {
            hasher.update(&(count as u64).to_le_bytes());
        }
        for number in field.pixel_size().iter().chain(field.heights()) {
            hasher.update(&number.to_le_bytes());
        }
        let (low, high) = field.range();
        Self {
            blake3: hasher.finalize().to_hex().to_string(),
            samples: [field.columns(), field.rows()],
            pixel_size_um: field.pixel_size(),
            heights_um: [low, high],
        }
    }
}

/// Digits in place of the check sum of a description while it is computed.
const BLANK_SUM: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// Names and meanings of the conventions.
const CONVENTIONS: [(&str, &str); 7] = [
    (
        "directions",
        "Unit vectors away from the surface, to the light and to the viewer, in its tangent frame: x = T, y = B, z = N (out of the surface).",
    ),
    (
        "heights",
        "x runs along the rows of the height field, y from its last row to its first, heights grow along z. Lengths are micrometres.",
    ),
    (
        "uvw",
        "(u, v, w) = -(light + viewer), dimensionless. Texels stand over -(u, v), from -extent to extent of table.json.",
    ),
    (
        "footprint",
        "Two vectors (dx, dy) of (u, v): the average is over a Gaussian of covariance dx dx^T + dy dy^T. Zero for a point.",
    ),
    (
        "value",
        "Linear sRGB of f cos(theta_light) in 1/sr, signed. A perfect mirror image of the light is white of luminance 1 once integrated.",
    ),
    (
        "texels",
        "Mip level m has the layers of level 2m and then those of level 2m + 1, each of them layer = piece * texels + texel. Rows grow with -v, columns with -u. A number is a coordinate in the cubics of table.json, times its unit.",
    ),
    ("below_horizon", "0 where either direction has z <= 0."),
];

/// Returns `value` as it stands in a description. Nothing is described as `null`, which would equal the `null` of anything else.
fn described(value: &impl Serialize) -> Result<Value> {
    let bug = |what: String| Error::bug(format!("a part of the description cannot be written ({what})"));
    match serde_json::to_value(value) {
        Ok(Value::Null) => Err(bug("it is null".to_owned())),
        Ok(value) => Ok(value),
        Err(e) => Err(bug(e.to_string()).caused_by(e)),
    }
}

impl MaterialDescription {
    /// Describes `material`, the export of `field` under `settings` that `command` makes. The files are yet to be added.
    ///
    /// # Errors
    /// An illuminant or a reflectance that has no description, which is a bug.
    pub fn new(
        field: &HeightField,
        settings: &ExportSettings,
        material: &ExportedMaterial,
        command: String,
    ) -> Result<Self> {
        Ok(Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: notes::software().to_owned(),
            command,
            conventions: CONVENTIONS
                .iter()
                .map(|(name, text)| ((*name).to_owned(), (*text).to_owned()))
                .collect(),
            prepared_by: field.prepared().clone(),
            surface: SurfaceFacts::new(field),
            coherence_length_um: 4.0 * settings.sigma,
            beyond: settings.beyond.name().to_owned(),
            illuminant: described(&settings.illuminant)?,
            reflectance: described(&settings.reflectance)?,
            theory: settings.reflectance.theory().name().to_owned(),
            scalar_theory: ScalarTheory::note(
                field,
                &settings.reflectance,
                LightColour::Spectrum(&settings.illuminant),
            ),
            tolerance: settings.tolerance,
            smallest_footprint: material.table.header.grid.finest,
            table_bytes: material.table.bytes(),
            errors: material.conformance.errors(),
            files: BTreeMap::new(),
            description_blake3: BLANK_SUM.to_owned(),
        })
    }

    /// Returns the text of `material.json`, with its check sum.
    ///
    /// # Errors
    /// Text that cannot be written.
    pub(super) fn to_text(&self) -> serde_json::Result<String> {
        let blank = Self { description_blake3: BLANK_SUM.to_owned(), ..self.clone() };
        let text = serde_json::to_string_pretty(&blank)? + "\n";
        let sum = FileSum::new(text.as_bytes()).blake3;
        Ok(text.replacen(BLANK_SUM, &sum, 1))
    }

    /// Fails unless the check sum is that of `text`, from which the description was read.
    fn check_sum(&self, text: &str) -> Result<()> {
        let is_sum = self.description_blake3.len() == BLANK_SUM.len();
        let blank = text.replacen(&self.description_blake3, BLANK_SUM, 1);
        if is_sum && FileSum::new(blank.as_bytes()).blake3 == self.description_blake3 {
            return Ok(());
        }
        Err(Error::input(
            "its check sum is not that of its text: it was changed or damaged",
            "export the material again",
        ))
    }

    /// Fails unless the export serves `field` under `asked`: the same surface, light and reflectance, at most the tolerance and the smallest footprint.
    ///
    /// # Errors
    /// Names what differs.
    pub fn check(&self, field: &HeightField, asked: &ExportSettings) -> Result<()> {
        let (illuminant, reflectance) = (described(&asked.illuminant)?, described(&asked.reflectance)?);
        let length = 4.0 * asked.sigma;
        let differs = if self.surface != SurfaceFacts::new(field) {
            "it is of another surface, or of the same one prepared otherwise".to_owned()
        } else if (self.coherence_length_um - length).abs() > 1e-9 * length {
            format!(
                "it is of a coherence length of {} µm, and {length} µm are asked for",
                self.coherence_length_um
            )
        } else if self.beyond != asked.beyond.name() {
            format!("beyond the patch it has {}, and {} is asked for", self.beyond, asked.beyond.name())
        } else if self.illuminant != illuminant {
            "it is of another illuminant".to_owned()
        } else if self.theory != asked.reflectance.theory().name() {
            let (has, wants) = (&self.theory, asked.reflectance.theory().name());
            format!("it is by the theory {has}, and {wants} is asked for")
        } else if self.reflectance != reflectance {
            "it is of another material".to_owned()
        } else if self.tolerance > asked.tolerance {
            format!("it has a tolerance of {:e}, and {:e} is asked for", self.tolerance, asked.tolerance)
        } else if self.smallest_footprint > asked.footprint {
            format!(
                "it serves footprints from {:.2e} on, and pixels have {:.2e}",
                self.smallest_footprint, asked.footprint
            )
        } else {
            return Ok(());
        };
        Err(Error::input(
            format!("the export does not fit: {differs}"),
            "export the material for this picture",
        ))
    }

    /// Reads the text of `material.json`.
    ///
    /// # Errors
    /// Text that is no description, and another version.
    pub fn parse(text: &str) -> Result<Self> {
        let broken = |e: serde_json::Error| {
            Error::input(format!("it is no description of a material ({e})"), "export the material again")
                .caused_by(e)
        };
        let value: Value = serde_json::from_str(text).map_err(broken)?;
        if !is_description(&value) {
            return Err(Error::input("it is no description of a material", "give the folder of an export"));
        }
        match value["version"].as_u64() {
            Some(VERSION) => {
                let found: Self = serde_json::from_value(value).map_err(broken)?;
                found.check_sum(text)?;
                Ok(found)
            }
            Some(other) => Err(Error::input(
                format!("it has version {other} of the format, and this program reads version {VERSION}"),
                if other > VERSION {
                    "read it with a newer program, or export the material again"
                } else {
                    "export the material again"
                },
            )),
            _ => Err(Error::input(
                "it names no version of the format that is known",
                "export the material again",
            )),
        }
    }
}

/// True if `value` says that it describes a material, in whichever version.
pub(super) fn is_description(value: &Value) -> bool {
    value["format"] == FORMAT
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorKind;

    #[test]
    fn what_has_no_description_is_an_error() {
        assert_eq!(described(&0.5).unwrap(), 0.5);
        // JSON has no word for it but null.
        assert_eq!(described(&f64::NAN).unwrap_err().kind(), ErrorKind::Bug);
        // A key that is no text.
        let map = BTreeMap::from([((1, 2), 3)]);
        let error = described(&map).unwrap_err();
        assert!(error.kind() == ErrorKind::Bug && std::error::Error::source(&error).is_some(), "{error}");
    }
}
