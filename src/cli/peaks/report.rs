//! What the peaks say, as CSV, as a line and as JSON.

use super::TangentAxis;
use crate::cli::write::Csv;
use crate::error::Result;
use crate::measure::peaks::{Peak, PeriodStatistics, WindowSpread};
use serde::Serialize;

/// The peaks of one order.
#[derive(Clone, Debug)]
pub struct Found {
    /// m.
    pub order: u32,
    /// One for each wavelength.
    pub peaks: Vec<Peak>,
    /// Over all of them.
    pub statistics: PeriodStatistics,
    /// Over windows, where several are averaged.
    pub spread: Option<WindowSpread>,
}

impl Found {
    /// `peaks` of `order`.
    pub fn new(order: u32, peaks: Vec<Peak>) -> Self {
        let statistics = PeriodStatistics::of(&peaks);
        Self { order, peaks, statistics, spread: None }
    }

    /// The period in a line.
    pub fn line(&self) -> String {
        let nm = |d: Option<f64>| d.map(nanometres);
        let period = match (nm(self.statistics.mean), nm(self.statistics.deviation)) {
            (Some(mean), Some(deviation)) => {
                format!("period {mean:.3} nm, standard deviation {deviation:.3} nm")
            }
            (Some(mean), None) => format!("period {mean:.3} nm"),
            (None, _) => "no period".to_owned(),
        };
        let period = match &self.spread {
            None => period,
            Some(spread) => format!("{period}; {}", over_windows(spread)),
        };
        let (clear, all) = (self.statistics.clear, self.peaks.len());
        format!("{period}; {clear} of {all} wavelengths have a clear peak in the range")
    }
}

/// What windows say of the uncertainty.
fn over_windows(spread: &WindowSpread) -> String {
    let WindowSpread { windows, independent, .. } = spread;
    let whose = if *independent < *windows as f64 {
        format!("{windows} windows, of which {independent:.1} are independent")
    } else {
        format!("{windows} windows")
    };
    let error = format!("standard error {:.3} nm over {whose}", nanometres(spread.error));
    match spread.half_interval {
        Some(half) => format!("95 % within {:.3} nm, {error}", nanometres(half)),
        None => error,
    }
}

/// The CSV; with several orders, another column says which.
pub fn table(found: &[Found]) -> Result<String> {
    let cell = |value: Option<f64>| value.map(|x| x.to_string()).unwrap_or_default();
    let columns = if found.len() > 1 { 5 } else { 4 };
    let mut table = Csv::new();
    table.row(&["wavelength", "angle", "period", "response", "order"][..columns])?;
    for of in found {
        for peak in &of.peaks {
            let cells = [
                nanometres(peak.wavelength).to_string(),
                cell(peak.angle),
                cell(peak.period.map(nanometres)),
                format!("{:e}", peak.response),
                of.order.to_string(),
            ];
            table.row(&cells[..columns])?;
        }
    }
    table.text()
}

/// nm from µm, without the last bits that the change of units adds.
fn nanometres(micrometres: f64) -> f64 {
    (micrometres * 1e12).round() / 1e9
}

/// What is said about all wavelengths, as JSON has it.
#[derive(Serialize)]
pub struct PeaksReport {
    theta_i: f64,
    axis: TangentAxis,
    order: u32,
    /// Wavelengths that were asked for.
    wavelengths: usize,
    /// Those that have a period.
    with_period: usize,
    /// Those whose maximum lies inside the range of angles.
    clear: usize,
    /// Over those that have a period.
    period_nm: PeriodSummary,
    /// Over windows, where several are averaged.
    #[serde(skip_serializing_if = "Option::is_none")]
    over_windows: Option<PeriodSpread>,
    /// The same through each window alone, where several are averaged.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    windows: Vec<WindowReport>,
}

/// `None` where there are too few wavelengths \[nm\].
#[derive(Serialize)]
struct PeriodSummary {
    mean: Option<f64>,
    standard_deviation: Option<f64>,
}

/// The jackknife over windows \[nm\].
#[derive(Serialize)]
struct PeriodSpread {
    windows: usize,
    independent_windows: f64,
    standard_error_nm: f64,
    /// `None` where there are too few windows.
    interval_95_nm: Option<[f64; 2]>,
}

impl PeriodSpread {
    fn of(spread: &WindowSpread, mean: f64) -> Self {
        let nm = |micrometres: f64| micrometres * 1e3;
        Self {
            windows: spread.windows,
            independent_windows: spread.independent,
            standard_error_nm: nm(spread.error),
            interval_95_nm: spread.half_interval.map(|half| [nm(mean - half), nm(mean + half)]),
        }
    }
}

/// What one window says.
#[derive(Serialize)]
struct WindowReport {
    clear: usize,
    period_nm: PeriodSummary,
}

impl PeriodSummary {
    fn of(statistics: &PeriodStatistics) -> Self {
        Self {
            mean: statistics.mean.map(|d| d * 1e3),
            standard_deviation: statistics.deviation.map(|d| d * 1e3),
        }
    }
}

impl PeaksReport {
    /// Of one order, and of the same order through each window alone.
    pub fn new(theta_i: f64, axis: TangentAxis, found: &Found, windows: &[&Found]) -> Self {
        let statistics = &found.statistics;
        let window = |of: &&Found| WindowReport {
            clear: of.statistics.clear,
            period_nm: PeriodSummary::of(&of.statistics),
        };
        Self {
            theta_i,
            axis,
            order: found.order,
            wavelengths: found.peaks.len(),
            with_period: statistics.count,
            clear: statistics.clear,
            period_nm: PeriodSummary::of(statistics),
            over_windows: found
                .spread
                .as_ref()
                .zip(statistics.mean)
                .map(|(spread, mean)| PeriodSpread::of(spread, mean)),
            windows: windows.iter().map(window).collect(),
        }
    }
}
