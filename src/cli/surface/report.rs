//! Report about a file: its channels as text, everything as JSON.

use crate::cli::write;
use crate::error::Result;
use crate::notes::Notes;
use crate::optics::surface_report::SurfaceReport;
use crate::surface::files::plausible::in_words;
use crate::surface::files::{Topography, choose};

/// Returns `report` and its `notes` as indented JSON.
///
/// # Errors
/// Never, for numbers that are finite.
pub fn json(report: &SurfaceReport, notes: &Notes) -> Result<String> {
    write::json_text(&write::with_origin(report, notes))
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
