//! Report about a file: its channels as text, everything as JSON.

use crate::cli::write;
use crate::error::{Error, Result};
use crate::notes::Notes;
use crate::optics::validity::ScalarTheory;
use crate::setup;
use crate::surface::files::plausible::in_words;
use crate::surface::files::{FileSummary, ScanOrigin, Topography, choose};
use crate::surface::statistics::notes;
use crate::surface::{HeightField, Statistics};
use serde::Serialize;
use std::ffi::OsStr;

/// Channel of the file.
#[derive(Serialize)]
struct ChannelReport {
    name: String,
    unit: String,
    samples: [usize; 2],
    chosen: bool,
}

/// Output of `surface info --json`.
#[derive(Serialize)]
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
    pub fn of(name: &OsStr, scan: &Topography, origin: Option<&ScanOrigin>, invalid: usize) -> Self {
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

    /// Adds the `statistics` of `field`, the errors of scalar theory, and the default of `--beyond`.
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
            beyond: Some(setup::continued(&statistics.tiling).name()),
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

    /// Returns the report and its `notes` as indented JSON.
    ///
    /// # Errors
    /// Never, for numbers that are finite.
    pub fn json(&self, notes: &Notes) -> Result<String> {
        write::json_text(&write::with_origin(self, notes))
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

/// Returns the lines about the format, the channels with a mark at the chosen one, samples that were not measured, and the steps of an
/// 8-bit image.
pub fn lines(scan: &Topography) -> Vec<(&'static str, String)> {
    let Some(origin) = scan.origin() else { return Vec::new() };
    let mut lines = vec![("format", origin.format.to_owned())];
    for (i, c) in origin.channels.iter().enumerate() {
        let mark = if i == origin.chosen { " *" } else { "" };
        let name = if i == 0 { "channels" } else { "" };
        lines.push((name, format!("{} {} ({}){mark}", i + 1, c.name, choose::unit(&c.unit))));
    }
    if scan.missing() > 0 {
        lines.push(("not measured", format!("{} samples", scan.missing())));
    }
    if let Some(step) = origin.quantisation {
        lines.push(("quantisation", format!("8 bits: steps of {:.3} nm", step * 1e9)));
    }
    lines
}

/// Returns the options with the spacing that a file of `scan` cannot carry.
pub fn spacing_option(scan: &Topography) -> String {
    let [dx, dy] = scan.spacing().map(|d| d * 1e9);
    if dx == dy { format!("--pixel-size {dx}nm") } else { format!("--pixel-size {dx}nmx{dy}nm") }
}

/// Returns the size of `scan` as text.
pub fn size(scan: &Topography) -> String {
    let [columns, rows] = scan.size();
    let [dx, dy] = scan.spacing().map(in_words);
    format!("{columns} x {rows} samples, {dx} x {dy} apart")
}
