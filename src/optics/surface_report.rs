//! Report about a height field: where it comes from, its statistics, and what its optics is worth.

use super::coherence::Beyond;
use super::validity::ScalarTheory;
use crate::error::{Error, Result};
use crate::surface::files::{FileSummary, ScanOrigin, Topography};
use crate::surface::statistics::notes;
use crate::surface::{HeightField, Statistics};
use serde::Serialize;
use std::ffi::OsStr;

/// Channel of the file.
#[derive(Clone, Debug, Serialize)]
struct ChannelReport {
    name: String,
    unit: String,
    samples: [usize; 2],
    chosen: bool,
}

/// Report of a height field. As JSON it is the output of `surface info`.
#[derive(Clone, Debug, Serialize)]
pub struct SurfaceReport {
    format: Option<&'static str>,
    samples: [usize; 2],
    spacing_m: [f64; 2],
    height_range_m: [f64; 2],
    mean_m: f64,
    rms_m: f64,
    invalid: usize,
    quantisation_m: Option<f64>,
    channels: Vec<ChannelReport>,
    warnings: Vec<String>,
    prepare: Vec<String>,
    beyond: Option<&'static str>,
    notes: Vec<String>,
    statistics: Option<Statistics>,
    scalar_theory: Option<ScalarTheory>,
    /// Name of the file or of the built-in surface.
    surface: String,
}

impl SurfaceReport {
    /// Returns the report of `scan`, of the surface that the user calls `name`; `invalid` samples were not measured in the file.
    pub fn new(name: &OsStr, scan: &Topography, origin: Option<&ScanOrigin>, invalid: usize) -> Self {
        let FileSummary { range, mean, rms } = scan.summary();
        Self {
            format: origin.map(|o| o.format),
            samples: scan.size(),
            spacing_m: scan.spacing(),
            height_range_m: range,
            mean_m: mean,
            rms_m: rms,
            invalid,
            quantisation_m: origin.and_then(|o| o.quantisation),
            channels: origin.map(channels).unwrap_or_default(),
            warnings: origin.map(|o| o.warnings.clone()).unwrap_or_default(),
            prepare: scan.prepared().steps().to_vec(),
            beyond: None,
            notes: Vec::new(),
            statistics: None,
            scalar_theory: None,
            surface: name.to_string_lossy().into_owned(),
        }
    }

    /// Adds the `statistics` of `field`, the errors of scalar theory, and the default continuation beyond the patch.
    ///
    /// # Errors
    /// Heights so large that their sums are not finite numbers.
    pub fn with_statistics(
        self,
        field: &HeightField,
        statistics: Statistics,
        scalar_theory: ScalarTheory,
    ) -> Result<Self> {
        Ok(Self {
            beyond: Some(Beyond::across(&statistics.tiling).name()),
            notes: notes(field, &statistics)?,
            statistics: Some(statistics),
            scalar_theory: Some(scalar_theory),
            ..self
        })
    }

    /// Adds the reason for missing statistics.
    pub fn without_statistics(mut self, reason: &Error) -> Self {
        self.warnings.push(format!("no statistics: {reason}"));
        self
    }
}

fn channels(origin: &ScanOrigin) -> Vec<ChannelReport> {
    let channel = |(i, c): (usize, &crate::surface::files::ChannelInfo)| ChannelReport {
        name: c.name.clone(),
        unit: c.unit.clone(),
        samples: c.size,
        chosen: i == origin.chosen,
    };
    origin.channels.iter().enumerate().map(channel).collect()
}
