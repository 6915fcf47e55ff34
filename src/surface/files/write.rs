//! Writes heights to a file in the format of its extension.

use super::{Topography, gsf, gwy, npy, text, tiff, x3p};
use crate::error::{Error, Result};
use crate::notes::Notes;
use crate::output;
use std::path::Path;

/// A format that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScanFormat {
    /// Gwyddion simple field: 32-bit floats with units.
    Gsf,
    /// Gwyddion's native format: float64 in metres. It cannot mark samples that were not measured.
    Gwyddion,
    /// NumPy array of float64 in metres, without a lateral scale and without notes.
    Npy,
    /// TIFF of 32-bit floats in metres, with resolution tags.
    Tiff,
    /// Text as Gwyddion exports it, with every digit.
    Text,
    /// X3P with float64 in metres.
    X3p,
}

impl ScanFormat {
    /// Returns the format of a file name's extension.
    ///
    /// # Errors
    /// An extension of no such format.
    pub fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("gsf") => Ok(Self::Gsf),
            Some("gwy") => Ok(Self::Gwyddion),
            Some("npy") => Ok(Self::Npy),
            Some("tif" | "tiff") => Ok(Self::Tiff),
            Some("txt") => Ok(Self::Text),
            Some("x3p") => Ok(Self::X3p),
            _ => Err(Error::usage(
                format!("{}: the format of the surface is not clear", path.display()),
                "name it .gsf, .gwy, .npy, .tif, .txt or .x3p",
            )),
        }
    }

    /// Returns true if heights are rounded to single precision, 24 of 53 bits.
    pub fn is_single(self) -> bool {
        matches!(self, Self::Gsf | Self::Tiff)
    }

    /// Returns true if files carry the distance of samples.
    pub fn has_scale(self) -> bool {
        self != Self::Npy
    }
}

/// Returns the largest error by which `format` rounds the heights of `scan`, relative to their range: small heights on a large offset lose digits. It is 0 for
/// formats that hold every digit, and for equal heights.
pub fn rounding(format: ScanFormat, scan: &Topography) -> f64 {
    let [low, high] = scan.summary().range;
    if !format.is_single() || high <= low {
        return 0.0;
    }
    let errors = scan.metres().filter(|h| !h.is_nan()).map(|h| (h - f64::from(h as f32)).abs());
    errors.fold(0.0, f64::max) / (high - low)
}

/// Writes `scan` to `path`, whole or not at all, with notes of its preparation and of the `command` that writes it. A NumPy array has no
/// room for notes.
///
/// # Errors
/// Heights that the format cannot hold; a place that cannot be written to.
pub fn write(path: &Path, format: ScanFormat, scan: &Topography, command: String) -> Result<()> {
    if format.is_single() && scan.metres().any(|h| h.abs() > f64::from(f32::MAX)) {
        return Err(Error::limit(
            "a height is too large for 32-bit floats",
            "write .gwy, .npy, .txt or .x3p",
        ));
    }
    let (missing, [columns, rows]) = (scan.missing(), scan.size());
    if format == ScanFormat::Gwyddion && missing > 0 {
        return Err(Error::limit(
            format!("{missing} of {} samples were not measured, for which .gwy has no mark", columns * rows),
            "write .gsf, .npy, .tif, .txt or .x3p",
        ));
    }
    let notes = Notes::new(command, scan.prepared());
    output::write_atomically(path, |file| {
        let failed = |e: std::io::Error| output::write_failed(path, e);
        match format {
            ScanFormat::Gsf => gsf::write(scan, &notes, file).map_err(failed),
            ScanFormat::Gwyddion => gwy::write(scan, &notes, file).map_err(failed),
            ScanFormat::Npy => npy::write(scan, file).map_err(failed),
            ScanFormat::Tiff => tiff::write(scan, &notes, file).map_err(|e| e.at(path.display())),
            ScanFormat::Text => text::write(scan, &notes, file).map_err(failed),
            ScanFormat::X3p => x3p::write(scan, &notes, file).map_err(failed),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::HeightField;

    #[test]
    fn heights_on_a_large_offset_lose_digits_in_single_precision_alone() {
        let scan = |offset: f64| {
            let heights = (0..64).map(|i| offset + 0.1 * (f64::from(i) * 0.618_034).fract()).collect();
            Topography::of(HeightField::new(8, 8, [0.1; 2], heights).unwrap())
        };
        for format in [ScanFormat::Gsf, ScanFormat::Tiff] {
            assert!(rounding(format, &scan(0.0)) < 1e-7);
            // A metre in units of 2⁻²⁴ m, over 0.1 µm.
            let lost = rounding(format, &scan(0.9e6));
            assert!((0.1..0.6).contains(&lost), "{lost}");
        }
        assert_eq!(rounding(ScanFormat::Npy, &scan(0.9e6)), 0.0);
        let flat = HeightField::new(2, 2, [0.1; 2], vec![1e6; 4]).unwrap();
        assert_eq!(rounding(ScanFormat::Gsf, &Topography::of(flat)), 0.0);
    }
}
