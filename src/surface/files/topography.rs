//! One channel of a file as heights, with its origin.

use super::super::HeightField;
use super::invalid;
use super::plausible::{self, HeightSource};
use crate::error::{Error, Result};
use crate::memory;
use crate::notes::PreparationRecord;

/// Micrometres of a metre.
const UM: f64 = 1e6;

/// A channel, for lists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelInfo {
    /// Name as in the file.
    pub name: String,
    /// Unit as in the file; empty for none.
    pub unit: String,
    /// Samples along `x` and `y`.
    pub size: [usize; 2],
}

/// Origin of heights that were read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanOrigin {
    /// The format, for people.
    pub format: &'static str,
    /// All channels of the file.
    pub channels: Vec<ChannelInfo>,
    /// Index of the channel of the heights.
    pub chosen: usize,
    /// Step of an 8-bit image \[m\]; `None` for finer samples.
    pub quantisation: Option<f64>,
    /// Facts that a user should know before trusting the heights, one line each.
    pub warnings: Vec<String>,
}

/// Exact heights of a file, including NaN for samples that were not measured.
#[derive(Clone, Debug)]
pub struct Topography {
    size: [usize; 2],
    /// \[m\]
    spacing: [f64; 2],
    /// \[µm\]
    pixel_size: [f64; 2],
    /// Heights row by row from the top, in units of `unit`; NaN for samples that were not measured.
    samples: Vec<f64>,
    /// Unit of `samples` \[µm\].
    unit: f64,
    missing: usize,
    origin: Option<ScanOrigin>,
    prepared: PreparationRecord,
}

/// Sample spacing in its original unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spacing {
    /// Along `x` and `y` \[m\].
    Metres([f64; 2]),
    /// Along `x` and `y` \[µm\].
    Micrometres([f64; 2]),
}

/// Statistics of the measured heights of a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileSummary {
    /// Lowest and highest height \[m\].
    pub range: [f64; 2],
    /// Mean height \[m\].
    pub mean: f64,
    /// Root mean square deviation from the mean \[m\].
    pub rms: f64,
}

impl Topography {
    /// Returns heights of `size` samples, each `unit` \[µm\] times its number in `samples`; NaN for samples that were not measured.
    ///
    /// # Errors
    /// A height or a spacing that is no number; no measured sample at all.
    pub fn new(
        size: [usize; 2],
        spacing: Spacing,
        samples: Vec<f64>,
        unit: f64,
        origin: Option<ScanOrigin>,
    ) -> Result<Self> {
        let (spacing, pixel_size) = match spacing {
            Spacing::Metres(m) => (m, m.map(|m| m * UM)),
            Spacing::Micrometres(um) => (um.map(|um| um / UM), um),
        };
        let missing = samples.iter().filter(|x| x.is_nan()).count();
        if missing == samples.len() {
            return Err(Error::input("no sample of it was measured", "choose another channel or file"));
        }
        if samples.iter().any(|x| !x.is_nan() && !(x * unit).is_finite()) {
            return Err(Error::input(
                "its heights are too large for numbers",
                "check the scale of the heights",
            ));
        }
        let prepared = PreparationRecord::default();
        Ok(Self { size, spacing, pixel_size, samples, unit, missing, origin, prepared })
    }

    /// Returns the heights of a height field, all of them measured.
    pub fn of(field: HeightField) -> Self {
        let pixel_size = field.pixel_size();
        Self {
            size: [field.columns(), field.rows()],
            spacing: pixel_size.map(|d| d / UM),
            pixel_size,
            prepared: field.prepared().clone(),
            samples: field.into_heights(),
            unit: 1.0,
            missing: 0,
            origin: None,
        }
    }

    /// Returns the number of samples along `x` and `y`.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Returns the distance of neighbouring samples along `x` and `y` \[m\].
    pub fn spacing(&self) -> [f64; 2] {
        self.spacing
    }

    /// Returns the number of samples that were not measured.
    pub fn missing(&self) -> usize {
        self.missing
    }

    /// Returns the origin of the heights; `None` for computed ones.
    pub fn origin(&self) -> Option<&ScanOrigin> {
        self.origin.as_ref()
    }

    /// Returns the steps that made these heights of the measured ones, as the file notes them.
    pub fn prepared(&self) -> &PreparationRecord {
        &self.prepared
    }

    /// Returns the same heights with the record of their preparation.
    #[must_use]
    pub fn with_record(self, prepared: PreparationRecord) -> Self {
        Self { prepared, ..self }
    }

    /// Returns questions about implausible scales, with the heights by `scale`.
    pub fn questions(&self, scale: HeightSource) -> Vec<String> {
        let [low, high] = self.summary().range;
        plausible::questions(self.size, self.spacing, high - low, scale)
    }

    /// Adds warnings to the origin: the `notes` of the reader, and questions about implausible scales, with the heights by `scale`.
    pub(super) fn warn(&mut self, notes: Vec<String>, scale: HeightSource) {
        let mut warnings = notes;
        warnings.extend(self.questions(scale));
        if self.missing > 0 {
            let (missing, count) = (self.missing, self.samples.len());
            warnings.push(format!(
                "{missing} of {count} samples were not measured; where all are needed, {}",
                invalid::METHOD
            ));
        }
        if let Some(origin) = &mut self.origin {
            origin.warnings = warnings;
        }
    }

    /// Returns the heights \[m\], row by row from the top; NaN for samples that were not measured.
    pub fn metres(&self) -> impl Iterator<Item = f64> + '_ {
        let factor = self.unit / UM;
        self.samples.iter().map(move |x| x * factor)
    }

    /// Returns range, mean and deviation of the measured samples.
    pub fn summary(&self) -> FileSummary {
        let measured = || self.metres().filter(|h| !h.is_nan());
        let count = (self.samples.len() - self.missing) as f64;
        let low = measured().fold(f64::INFINITY, f64::min);
        let high = measured().fold(f64::NEG_INFINITY, f64::max);
        // From the lowest height: a small relief may stand on a large offset.
        let mean = low + measured().map(|h| h - low).sum::<f64>() / count;
        let rms = (measured().map(|h| (h - mean).powi(2)).sum::<f64>() / count).sqrt();
        FileSummary { range: [low, high], mean, rms }
    }

    /// Converts to a height field; [`invalid::fill`] fills the samples that were not measured.
    ///
    /// # Errors
    /// Too many samples that were not measured; no room.
    pub fn into_field(mut self) -> Result<HeightField> {
        let [columns, rows] = self.size;
        if self.missing > 0 {
            memory::ensure_room(
                self.missing as u64 * 2 * size_of::<usize>() as u64,
                "filling the gaps of a scan",
            )?;
            invalid::fill(&mut self.samples, columns, self.missing)?;
        }
        for sample in &mut self.samples {
            *sample *= self.unit;
        }
        Ok(HeightField::new(columns, rows, self.pixel_size, self.samples)?.with_record(self.prepared))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metres_are_exact_and_micrometres_are_what_options_say() {
        let heights = vec![1.0 / 3.0 * 1e-7, f64::NAN, -7.7e-9];
        let metres =
            Topography::new([3, 1], Spacing::Metres([1e-8 / 3.0; 2]), heights.clone(), UM, None).unwrap();
        assert_eq!(metres.metres().next(), Some(heights[0]));
        assert_eq!((metres.missing(), metres.spacing()[0]), (1, 1e-8 / 3.0));
        let coded =
            Topography::new([2, 1], Spacing::Micrometres([0.097_66; 2]), vec![0.0, 1.0], 0.4347, None)
                .unwrap();
        let field = coded.into_field().unwrap();
        assert_eq!((field.heights(), field.pixel_size()), (&[0.0, 0.4347][..], [0.097_66; 2]));
    }

    #[test]
    fn what_was_not_measured_counts_in_no_statistic() {
        let t = Topography::new([2, 2], Spacing::Metres([1e-8; 2]), vec![1.0, f64::NAN, 3.0, 2.0], UM, None)
            .unwrap();
        let FileSummary { range, mean, rms } = t.summary();
        assert_eq!((range, mean), ([1.0, 3.0], 2.0));
        assert!((rms - (2.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert!(Topography::new([1, 1], Spacing::Metres([1.0; 2]), vec![f64::NAN], 1.0, None).is_err());
        assert!(Topography::new([1, 1], Spacing::Metres([1.0; 2]), vec![1e300], 1e300, None).is_err());
    }
}
