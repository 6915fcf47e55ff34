//! Peaks of an order over wavelengths, its period, and the uncertainty of the period over windows.

use super::branches::Branch;
use super::peaks::{Peak, PeriodStatistics, Sought, WindowSpread};
use super::sweep::AngleSweep;

/// The peaks of one order.
#[derive(Clone, Debug)]
pub struct OrderPeaks {
    /// Light, order and period.
    pub sought: Sought,
    /// Largest response of each wavelength.
    pub peaks: Vec<Peak>,
    /// Period over all of them.
    pub statistics: PeriodStatistics,
    /// Spread of that period over windows, if several are averaged.
    pub spread: Option<WindowSpread>,
    /// Branches between which the largest response changes, the strongest first; empty if it does not change.
    pub branches: Vec<FollowedBranch>,
}

/// A branch of maxima.
#[derive(Clone, Debug)]
pub struct FollowedBranch {
    /// Maxima of the branch and their period.
    pub branch: Branch,
    /// Spread of the period over windows, if several are averaged.
    pub spread: Option<WindowSpread>,
    /// Period of the branch through each window alone.
    pub windows: Vec<PeriodStatistics>,
}

impl OrderPeaks {
    /// Finds the largest responses of `sweep`, without branches.
    pub fn new(sought: Sought, sweep: &AngleSweep) -> Self {
        let peaks = sweep.map(sought).largest();
        let statistics = PeriodStatistics::of(&peaks);
        Self { sought, peaks, statistics, spread: None, branches: Vec::new() }
    }

    /// Finds the branches of `sweep`, and follows them through each of the `windows` alone.
    pub fn find_branches(&mut self, sweep: &AngleSweep, windows: &[AngleSweep]) {
        let follow = |branch: Branch| FollowedBranch {
            windows: windows.iter().map(|one| one.map(self.sought).along(&branch)).collect(),
            branch,
            spread: None,
        };
        self.branches = sweep.map(self.sought).branches().into_iter().map(follow).collect();
    }

    /// Returns the number, from 1, of the branch on which the largest response of wavelength number `place` lies.
    pub fn branch_at(&self, place: usize) -> Option<usize> {
        let largest = self.peaks[place].angle;
        let is_there = |f: &FollowedBranch| f.branch.peaks[place].is_some_and(|peak| peak.angle == largest);
        self.branches.iter().position(is_there).map(|number| number + 1)
    }

    /// Returns the period over all wavelengths and its spread, or those of the strongest branch if there are several.
    pub fn strongest(&self) -> (&PeriodStatistics, Option<&WindowSpread>) {
        match self.branches.first() {
            Some(followed) => (&followed.branch.statistics, followed.spread.as_ref()),
            None => (&self.statistics, self.spread.as_ref()),
        }
    }
}

/// Gives each of the peaks `found` its spread over the windows whose sweeps are `alone`, of which `independent` are independent of each other.
pub fn spread_over_windows(independent: Option<f64>, alone: &[AngleSweep], found: &mut [OrderPeaks]) {
    // A single wavelength or window, or a grating that is the same everywhere, has no spread.
    let Some(independent) = independent.filter(|_| alone.len() > 1) else { return };
    let mean = AngleSweep::mean(alone);
    let rest: Vec<AngleSweep> = alone.iter().map(|one| mean.without(one, alone.len())).collect();
    let spread = |period: &dyn Fn(&AngleSweep) -> Option<f64>| {
        let periods: Option<Vec<f64>> = rest.iter().map(period).collect();
        periods.and_then(|periods| WindowSpread::jackknife(&periods, independent))
    };
    for of in found {
        of.spread = spread(&|rest| PeriodStatistics::of(&rest.map(of.sought).largest()).mean);
        for followed in &mut of.branches {
            followed.spread = spread(&|rest| rest.map(of.sought).along(&followed.branch).mean);
        }
    }
}
