//! Report of the peaks, as CSV, as a line and as JSON.

use super::TangentAxis;
use crate::cli::write::Csv;
use crate::measure::branches::Branch;
use crate::measure::order_peaks::{FollowedBranch, OrderPeaks};
use crate::measure::peaks::{PeriodStatistics, WindowSpread};
use serde::Serialize;

impl OrderPeaks {
    /// Returns the period in a line, as for a single branch.
    pub fn line(&self) -> String {
        let period = in_words(&self.statistics, self.spread.as_ref());
        let (clear, all) = (self.statistics.clear, self.peaks.len());
        let mirror = match self.at_mirror() {
            0 => String::new(),
            count => format!(
                "; at {count} of them it is the mirror's, at {}°, which fits every period: leave this angle out of --angles",
                -self.sought.theta_i
            ),
        };
        format!("{period}; {clear} of {all} wavelengths have a clear peak in the range{mirror}")
    }

    /// Returns the number of wavelengths whose largest response is in the mirror direction.
    fn at_mirror(&self) -> usize {
        self.peaks.iter().filter(|peak| peak.angle.is_some() && peak.period.is_none()).count()
    }

    /// Returns the order of which a branch is one of the longest period among the branches, for `mean` \[µm\] at this order; `None` if it is none of 2 to 9.
    fn order_of_longest(&self, mean: f64) -> Option<u32> {
        /// Relative distance of periods that count as the same.
        const SAME: f64 = 0.01;
        let means = self.branches.iter().filter_map(|followed| followed.branch.statistics.mean);
        let longest = means.fold(0.0, f64::max);
        (2..=9).find(|order| (f64::from(*order) * mean / longest - 1.0).abs() < SAME)
    }

    /// Returns the period in a line, or a line for each branch and an explanation.
    pub fn lines(&self) -> Vec<String> {
        if self.branches.is_empty() {
            return vec![self.line()];
        }
        let count = self.branches.len();
        let mut lines = vec![format!(
            "the largest response changes between {count} branches, each with a period of its own"
        )];
        for (number, followed) in self.branches.iter().enumerate() {
            let which = format!("branch {} of {count}: ", number + 1);
            for (window, alone) in followed.windows.iter().enumerate() {
                let windows = followed.windows.len();
                lines.push(format!("{which}window {} of {windows}: {}", window + 1, in_words(alone, None)));
            }
            let Branch { statistics, largest, .. } = &followed.branch;
            let times = statistics.mean.and_then(|mean| Some((mean, self.order_of_longest(mean)?)));
            let higher = times.map_or(String::new(), |(mean, times)| {
                format!(
                    "; as order {} it has the longest period of the branches, {:.3} nm",
                    times * self.sought.order,
                    nanometres(f64::from(times) * mean)
                )
            });
            lines.push(format!(
                "{which}{}{higher}; a maximum at {} of {} wavelengths, the largest response at {largest}",
                in_words(statistics, followed.spread.as_ref()),
                statistics.count,
                self.peaks.len(),
            ));
        }
        lines
    }
}

/// Describes a period with its uncertainty.
fn in_words(statistics: &PeriodStatistics, spread: Option<&WindowSpread>) -> String {
    let nm = |d: Option<f64>| d.map(nanometres);
    let period = match (nm(statistics.mean), nm(statistics.deviation)) {
        (Some(mean), Some(deviation)) => {
            format!("period {mean:.3} nm, standard deviation {deviation:.3} nm")
        }
        (Some(mean), None) => format!("period {mean:.3} nm"),
        (None, _) => "no period".to_owned(),
    };
    match spread {
        None => period,
        Some(spread) => format!("{period}; {}", over_windows(spread)),
    }
}

/// Describes the uncertainty over windows.
fn over_windows(spread: &WindowSpread) -> String {
    let WindowSpread { windows, independent, .. } = spread;
    if spread.error == 0.0 {
        return format!(
            "the peaks of all {windows} windows lie at the same angles: a smaller step of --angles gives a standard error"
        );
    }
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

/// Returns the CSV; with several orders or branches, another column numbers them.
pub fn table(found: &[OrderPeaks]) -> Csv {
    let cell = |value: Option<f64>| value.map(|x| x.to_string()).unwrap_or_default();
    let columns = [true, true, true, true, found.len() > 1, found.iter().any(|of| !of.branches.is_empty())];
    let mut table = Csv::new();
    let mut row = |cells: [String; 6]| {
        let shown = cells.into_iter().zip(columns).filter(|(_, shown)| *shown);
        table.row(shown.map(|(cell, _)| cell));
    };
    row(["wavelength", "angle", "period", "response", "order", "branch"].map(str::to_owned));
    for of in found {
        for (place, peak) in of.peaks.iter().enumerate() {
            row([
                nanometres(peak.wavelength).to_string(),
                cell(peak.angle),
                cell(peak.period.map(nanometres)),
                format!("{:e}", peak.response),
                of.sought.order.to_string(),
                of.branch_at(place).map(|number| number.to_string()).unwrap_or_default(),
            ]);
        }
    }
    table
}

/// Converts µm to nm, without the last bits that the change of units adds.
fn nanometres(micrometres: f64) -> f64 {
    (micrometres * 1e12).round() / 1e9
}

/// Summary over all wavelengths, for JSON.
#[derive(Serialize)]
pub struct PeaksReport {
    theta_i: f64,
    axis: TangentAxis,
    order: u32,
    /// Number of wavelengths.
    wavelengths: usize,
    /// Number of wavelengths that have a period.
    with_period: usize,
    /// Number of wavelengths whose maximum lies inside the range of angles.
    clear: usize,
    /// Period over the wavelengths that have one; of the strongest branch if there are several.
    period_nm: PeriodSummary,
    /// Largest shift of the period by copies of the patch that break a grating \[nm\]; absent if they do not.
    #[serde(skip_serializing_if = "Option::is_none")]
    shift_of_copies_nm: Option<f64>,
    /// Spread over windows, if several are averaged.
    #[serde(skip_serializing_if = "Option::is_none")]
    over_windows: Option<PeriodSpread>,
    /// Reports of each window alone, if several are averaged.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    windows: Vec<WindowReport>,
    /// Branches between which the largest response changes, the strongest first; absent if it does not change.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    branches: Vec<BranchReport>,
}

/// Mean and spread of a period \[nm\]; `None` for too few wavelengths.
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
    /// Confidence interval; `None` for too few windows, or if their peaks lie at the same angles.
    interval_95_nm: Option<[f64; 2]>,
}

impl PeriodSpread {
    fn of_some(spread: Option<&WindowSpread>, statistics: &PeriodStatistics) -> Option<Self> {
        spread.zip(statistics.mean).map(|(spread, mean)| Self::of(spread, mean))
    }

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

/// One of several branches.
#[derive(Serialize)]
struct BranchReport {
    /// Wavelengths at which it is a maximum.
    wavelengths: usize,
    /// Wavelengths at which it is the largest response.
    largest: usize,
    period_nm: PeriodSummary,
    #[serde(skip_serializing_if = "Option::is_none")]
    over_windows: Option<PeriodSpread>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    windows: Vec<WindowReport>,
}

impl BranchReport {
    fn of(followed: &FollowedBranch) -> Self {
        let Branch { statistics, largest, .. } = &followed.branch;
        Self {
            wavelengths: statistics.count,
            largest: *largest,
            period_nm: PeriodSummary::of(statistics),
            over_windows: PeriodSpread::of_some(followed.spread.as_ref(), statistics),
            windows: followed.windows.iter().map(WindowReport::of).collect(),
        }
    }
}

/// Summary of a single window.
#[derive(Serialize)]
struct WindowReport {
    clear: usize,
    period_nm: PeriodSummary,
}

impl WindowReport {
    fn of(statistics: &PeriodStatistics) -> Self {
        Self { clear: statistics.clear, period_nm: PeriodSummary::of(statistics) }
    }
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
    /// Returns the report of one order, and of the same order through each window alone.
    pub fn new(theta_i: f64, axis: TangentAxis, found: &OrderPeaks, windows: &[&OrderPeaks]) -> Self {
        let (period, spread) = found.strongest();
        let alone: Vec<&PeriodStatistics> = match found.branches.first() {
            Some(strongest) => strongest.windows.iter().collect(),
            None => windows.iter().map(|of| &of.statistics).collect(),
        };
        Self {
            theta_i,
            axis,
            order: found.sought.order,
            wavelengths: found.peaks.len(),
            with_period: found.statistics.count,
            clear: found.statistics.clear,
            period_nm: PeriodSummary::of(period),
            shift_of_copies_nm: None,
            over_windows: PeriodSpread::of_some(spread, period),
            windows: alone.into_iter().map(WindowReport::of).collect(),
            branches: found.branches.iter().map(BranchReport::of).collect(),
        }
    }

    /// Adds the shift of the period by copies, relative to the period.
    pub fn with_shift(mut self, relative: Option<f64>) -> Self {
        self.shift_of_copies_nm = relative.zip(self.period_nm.mean).map(|(shift, mean)| shift * mean);
        self
    }
}
