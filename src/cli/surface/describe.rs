//! Description of a height field in numbers, for reading by eye.

use crate::error::Result;
use crate::optics::coherence::{Beyond, SUNLIGHT_LENGTH};
use crate::optics::sampling;
use crate::optics::spectrum::SHORTEST;
use crate::optics::validity::ScalarTheory;
use crate::spectra::amplitude::expansion::HeightScale;
use crate::spectra::amplitude::expansion::taylor::{F32_ROUNDOFF, terms_for, thesis_bound};
use crate::spectra::amplitude::layers::largest_z;
use crate::spectra::power::{Estimate, OrderSeries, PowerSettings};
use crate::surface::statistics::{Period, notes};
use crate::surface::tiling::Tiling;
use crate::surface::{HeightField, Statistics};

/// Name and text of a line.
type Line = (&'static str, String);

/// Describes `field` line by line, with the errors of scalar theory in `theory`.
pub fn text(field: &HeightField, statistics: &Statistics, theory: &ScalarTheory) -> Result<String> {
    let lines = lines(field, statistics, theory)?;
    Ok(lines.iter().map(|(name, value)| format!("{name:<26}{value}\n")).collect())
}

/// Returns the same as names and values.
pub fn lines(field: &HeightField, statistics: &Statistics, theory: &ScalarTheory) -> Result<Vec<Line>> {
    let mut lines = grid(field, statistics);
    lines.extend(distributions(statistics));
    lines.extend(spectrum(statistics));
    lines.push(("scalar theory", theory.line().to_owned()));
    lines.extend(optics(field));
    lines.extend(notes(field, statistics)?.into_iter().map(|note| ("note", note)));
    Ok(lines)
}

fn nm(um: f64) -> String {
    format!("{:.1} nm", um * 1e3)
}

fn pair([x, y]: [f64; 2], unit: &str, factor: f64) -> String {
    format!("{:.4} x {:.4} {unit}", x * factor, y * factor)
}

fn grid(field: &HeightField, statistics: &Statistics) -> Vec<Line> {
    let tiling = &statistics.tiling;
    let [x, y] = tiling.ratio;
    let broken = tiling.broken_in_words().into_iter().map(|periods| periods + ", ");
    let seams = format!(
        "{} ({}steps across the seams {x:.2}, {y:.2} of the nearest inside)",
        tiling.verdict.words(),
        broken.collect::<String>()
    );
    vec![
        ("samples", format!("{} x {}", field.columns(), field.rows())),
        ("spacing", pair(field.pixel_size(), "nm", 1e3)),
        ("patch", pair(field.patch_size(), "um", 1.0)),
        ("prepared by", field.prepared().to_string()),
        ("tiles", seams),
        ("beyond the patch", beyond(tiling).to_owned()),
    ]
}

/// Returns the default of `--beyond` for a surface with these seams, with the reason.
fn beyond(tiling: &Tiling) -> &'static str {
    match Beyond::across(tiling) {
        Beyond::Copies => "copies by default, because copies join",
        Beyond::Alike => "alike by default, because copies do not join",
    }
}

fn distributions(statistics: &Statistics) -> Vec<Line> {
    let (h, s) = (&statistics.heights, &statistics.slopes);
    let [low, high] = h.range;
    let step = h.quantisation.map_or(String::new(), |step| format!(", multiples of {:.3} nm", step * 1e3));
    vec![
        ("height range", format!("{} ({} to {})", nm(high - low), nm(low), nm(high))),
        ("mean, RMS roughness", format!("{}, {}", nm(h.mean), nm(h.sq))),
        ("Sa, Sq", format!("{:.2} nm, {:.2} nm", h.sa * 1e3, h.sq * 1e3)),
        ("Ssk, Sku", format!("{:.3}, {:.3}", h.ssk, h.sku)),
        ("distinct heights", format!("{}{step}", h.levels)),
        ("beyond 3 sigma", format!("{:.2} %", h.outliers * 100.0)),
        ("Sdq", format!("{:.4} ({:.2} deg)", s.sdq, s.sdq.atan().to_degrees())),
        ("RMS slope along x, y", slopes_along_axes(s.rms)),
        ("slope angles", format!("95 % below {:.1} deg, steepest {:.1} deg", s.angle_95, s.angle_max)),
    ]
}

/// Returns the two parts of Sdq.
fn slopes_along_axes(rms: [f64; 2]) -> String {
    let [x, y] = rms.map(|slope| format!("{slope:.4} ({:.2} deg)", slope.atan().to_degrees()));
    format!("{x}, {y}")
}

fn spectrum(statistics: &Statistics) -> Vec<Line> {
    let period = |p: Option<f64>| p.map_or("none found".to_owned(), |p| format!("{p:.3} um"));
    let texture = &statistics.texture;
    let sal = texture.sal.map_or("beyond a quarter of the patch".to_owned(), |sal| format!("{sal:.4} um"));
    let std =
        texture.std.map_or("none".to_owned(), |std| format!("{std:.2} deg from +x, across the grooves"));
    let mut lines = vec![("Sal", sal), ("Std", std)];
    if statistics.periods.is_empty() {
        lines.push(("dominant period", "none stands out".to_owned()));
        let [along_x, along_y] = statistics.line_periods;
        lines.push(("period along x, y", format!("{}, {}", period(along_x), period(along_y))));
    }
    lines.extend(statistics.periods.iter().map(|p| ("dominant period", dominant(p))));
    let fine = format!(
        "{:.2} % of the variance in structure finer than 4 samples",
        100.0 * statistics.undersampled_share
    );
    lines.extend([
        ("holds frequencies to", pair(statistics.largest_frequency, "1/um", 1.0)),
        ("finest structure", fine),
        ("noise floor", format!("{:.2} nm RMS at most", statistics.noise * 1e3)),
    ]);
    lines
}

fn dominant(period: &Period) -> String {
    let spread = |spread: Option<f64>, unit: &str, factor: f64, digits: usize| {
        spread.map_or(String::new(), |s| format!(" ± {:.digits$} {unit}", s * factor))
    };
    format!(
        "{:.4} um{} at {:.2} deg{} from +x, amplitude {}, {}",
        period.length,
        spread(period.length_spread, "um", 1.0, 4),
        period.direction,
        spread(period.direction_spread, "deg", 1.0, 2),
        nm(period.amplitude),
        period.method.words()
    )
}

fn optics(field: &HeightField) -> Vec<Line> {
    let held = sampling::limit(field.pixel_size(), SHORTEST).map_or("all".to_owned(), |limit| {
        format!("|{}| up to {:.2}; all need {} between samples", limit.axis, limit.largest, nm(limit.needed))
    });
    let half_range = HeightScale::of(field).half_range;
    let x = largest_z(SHORTEST) * half_range;
    let mut lines = vec![("directions held at 380 nm", held), ("largest phase k|w|a", format!("{x:.2}"))];
    lines.extend([1e-1, 1e-2, 1e-3].map(|tolerance| ("orders of the mean", power_cost(field, tolerance))));
    for tolerance in [1e-1, 1e-2, 1e-3, 1e-4] {
        let bound = match terms_for(x, tolerance, F32_ROUNDOFF) {
            Ok(terms) => {
                let thesis = (1..=4096).find(|&n| thesis_bound(2.0 * x, n - 1) <= tolerance);
                let thesis = thesis.map_or("more than 4096".to_owned(), |n| n.to_string());
                format!("{terms} terms (tight bound, centred; the thesis' bound asks for {thesis})")
            }
            Err(_) => "not in 32-bit floats".to_owned(), // the only error of `terms_for`
        };
        lines.push(("taylor", format!("sup error {tolerance:.0e}: {bound}")));
    }
    lines
}

/// Returns the size of the orders' series in sunlight for a `tolerance`.
fn power_cost(field: &HeightField, tolerance: f64) -> String {
    const MIB: f64 = 1024.0 * 1024.0;
    let settings = PowerSettings::new(SUNLIGHT_LENGTH / 4.0, Beyond::suited_to(field), tolerance);
    let Some(Estimate { terms, orders: [x, y], bytes }) = OrderSeries::estimate(field, &settings) else {
        return format!("error {tolerance:.0e}: not for so high a surface");
    };
    let mib = bytes as f64 / MIB;
    format!(
        "error {tolerance:.0e}: from {terms} terms on for {x} x {y} orders, {mib:.1} MiB (coherence of 65 um)"
    )
}
