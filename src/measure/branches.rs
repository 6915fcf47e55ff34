//! Branches of maxima over wavelengths, for responses whose largest maximum switches between periods.

use super::peaks::{Peak, PeriodStatistics, Sought};

/// Responses over wavelengths and view angles.
#[derive(Clone, Copy, Debug)]
pub struct ResponseMap<'a> {
    /// Wavelengths \[µm\].
    pub wavelengths: &'a [f64],
    /// View angles \[degrees\], ascending.
    pub angles: &'a [f64],
    /// BRDF \[sr⁻¹\], wavelength by wavelength.
    pub responses: &'a [f64],
    /// Light, order and expected period of the maxima.
    pub sought: Sought,
}

/// Maximum that is followed over wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Maximum at each wavelength; `None` if there is none nearby.
    pub peaks: Vec<Option<Peak>>,
    /// Number of wavelengths at which it is the largest response.
    pub largest: usize,
    /// Statistics of its period over all wavelengths with this maximum.
    pub statistics: PeriodStatistics,
}

/// Relative difference of periods beyond which two maxima belong to different branches. Speckle moves a maximum by less
/// from one wavelength to the next; branches of a measured skin are 10 % apart.
const APART: f64 = 0.03;
/// Fewest wavelengths at which a branch is the largest response; fewer are outliers.
const FEWEST: usize = 3;
/// Smallest fraction of wavelengths at which a branch is the largest response.
const LEAST_SHARE: f64 = 0.05;

impl Branch {
    fn new(peaks: Vec<Option<Peak>>, largest: usize) -> Self {
        let found: Vec<Peak> = peaks.iter().flatten().copied().collect();
        Self { statistics: PeriodStatistics::of(&found), peaks, largest }
    }
}

impl ResponseMap<'_> {
    fn row(&self, place: usize) -> &[f64] {
        let count = self.angles.len();
        &self.responses[place * count..(place + 1) * count]
    }

    /// Returns the largest response at each wavelength.
    pub fn largest(&self) -> Vec<Peak> {
        let peak = |(place, &wavelength)| self.sought.largest(wavelength, self.angles, self.row(place));
        self.wavelengths.iter().enumerate().map(peak).collect()
    }

    /// Returns the branches that contain the largest response, the one with the most wavelengths first; empty unless
    /// there are at least two.
    pub fn branches(&self) -> Vec<Branch> {
        let clear: Vec<(usize, Peak)> =
            self.largest().into_iter().enumerate().filter(|(_, p)| p.clear && p.period.is_some()).collect();
        let fewest = FEWEST.max((LEAST_SHARE * clear.len() as f64).ceil() as usize);
        let mut groups = self.groups(clear);
        groups.retain(|group| group.len() >= fewest);
        if groups.len() < 2 {
            return Vec::new();
        }
        groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
        groups.iter().map(|group| Branch::new(self.followed(group), group.len())).collect()
    }

    /// Groups peaks whose periods have no gap between them; each group is in the order of wavelengths.
    fn groups(&self, mut peaks: Vec<(usize, Peak)>) -> Vec<Vec<(usize, Peak)>> {
        let period = |peak: &Peak| peak.period.unwrap_or(f64::NAN);
        peaks.sort_by(|(_, a), (_, b)| period(a).total_cmp(&period(b)));
        let mut groups: Vec<Vec<(usize, Peak)>> = Vec::new();
        let mut last: Option<Peak> = None;
        for (place, peak) in peaks {
            let is_near = last.is_some_and(|last| {
                period(&peak) - period(&last) <= self.apart(&last).max(self.apart(&peak))
            });
            match groups.last_mut().filter(|_| is_near) {
                Some(group) => group.push((place, peak)),
                None => groups.push(vec![(place, peak)]),
            }
            last = Some(peak);
        }
        groups.iter_mut().for_each(|group| group.sort_by_key(|(place, _)| *place));
        groups
    }

    /// Returns the difference of periods \[µm\] from `peak` beyond which another peak belongs to another branch: at
    /// least two steps of the angles.
    fn apart(&self, peak: &Peak) -> f64 {
        let Some((angle, period)) = peak.angle.zip(peak.period) else { return 0.0 };
        let place = self.angles.partition_point(|&a| a < angle);
        let at = |place: usize| self.sought.period(peak.wavelength, self.angles[place]);
        let ends = [place.saturating_sub(1), (place + 1).min(self.angles.len() - 1)].map(at);
        let steps = ends[0].zip(ends[1]).map_or(0.0, |(a, b)| (a - b).abs());
        steps.max(APART * period)
    }

    /// Returns at every wavelength the maximum that the `known` peaks (indices and peaks, in order) have at some.
    fn followed(&self, known: &[(usize, Peak)]) -> Vec<Option<Peak>> {
        let mut peaks = vec![None; self.wavelengths.len()];
        known.iter().for_each(|(place, peak)| peaks[*place] = Some(*peak));
        let Some(&(first, start)) = known.first() else { return peaks };
        let mut walk = |places: &mut dyn Iterator<Item = usize>| {
            let mut last = start;
            for place in places {
                peaks[place] = peaks[place].or_else(|| self.nearest(place, &last));
                last = peaks[place].unwrap_or(last);
            }
        };
        walk(&mut (first..self.wavelengths.len()));
        walk(&mut (0..first).rev());
        peaks
    }

    /// Returns the maximum at wavelength number `place` whose period is nearest to that of `peak`; `None` if it belongs
    /// to another branch.
    fn nearest(&self, place: usize, peak: &Peak) -> Option<Peak> {
        let period = peak.period?;
        let away = |p: &Peak| (p.period.unwrap_or(f64::INFINITY) - period).abs();
        let maxima = self.sought.maxima(self.wavelengths[place], self.angles, self.row(place));
        let nearest = maxima.into_iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
        (away(&nearest) <= self.apart(peak).max(self.apart(&nearest))).then_some(nearest)
    }

    /// Returns statistics of the maxima of this map next to those of a `branch` of another map with the same
    /// wavelengths.
    pub fn along(&self, branch: &Branch) -> PeriodStatistics {
        let there = branch.peaks.iter().enumerate();
        let peaks: Vec<Peak> =
            there.filter_map(|(place, peak)| self.nearest(place, peak.as_ref()?)).collect();
        PeriodStatistics::of(&peaks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::grating;

    const THETA_I: f64 = -75.0;

    /// Returns responses of gratings, each given by a period \[µm\] and its strength over wavelengths: Gaussians of 1 %
    /// in the period.
    fn responses(wavelengths: &[f64], angles: &[f64], gratings: &[(f64, &dyn Fn(f64) -> f64)]) -> Vec<f64> {
        let u = |angle: f64| (angle.to_radians().sin() + THETA_I.to_radians().sin()).abs();
        let one = |wavelength: f64, angle: f64, &(period, strength): &(f64, &dyn Fn(f64) -> f64)| {
            let off = (u(angle) * period / wavelength - 1.0) / 0.01;
            strength(wavelength) * (-off * off / 2.0).exp()
        };
        let all = |w: f64, a: f64| 1e-3 + gratings.iter().map(|g| one(w, a, g)).sum::<f64>();
        wavelengths
            .iter()
            .flat_map(|&w| angles.iter().map(move |&a| (w, a)))
            .map(|(w, a)| all(w, a))
            .collect()
    }

    fn axes() -> (Vec<f64>, Vec<f64>) {
        let wavelengths = (0..81).map(|k| 0.380 + 0.005 * f64::from(k)).collect();
        (wavelengths, (0..900).map(|k| 5.0 + 0.05 * f64::from(k)).collect())
    }

    fn sought() -> Sought {
        Sought { theta_i: THETA_I, order: 1, period: None }
    }

    #[test]
    fn two_gratings_that_take_turns_in_being_the_brightest_have_a_branch_each() {
        let (wavelengths, angles) = axes();
        // The second grating is the brighter one above 690 nm.
        let strength = |w: f64| if w < 0.689 { 0.5 } else { 2.0 };
        let responses = responses(&wavelengths, &angles, &[(1.128, &|_| 1.0), (1.016, &strength)]);
        let map = ResponseMap {
            wavelengths: &wavelengths,
            angles: &angles,
            responses: &responses,
            sought: sought(),
        };
        // There is no maximum at the mean over the largest responses.
        let overall = PeriodStatistics::of(&map.largest());
        assert!(
            (1.05..1.12).contains(&overall.mean.unwrap()) && overall.deviation.unwrap() > 0.03,
            "{overall:?}"
        );
        let branches = map.branches();
        assert_eq!(branches.iter().map(|b| b.largest).collect::<Vec<_>>(), [62, 19]);
        for (branch, period) in branches.iter().zip([1.128, 1.016]) {
            let PeriodStatistics { count, mean, deviation, .. } = branch.statistics;
            assert_eq!(count, 81, "followed over all wavelengths");
            assert!((mean.unwrap() / period - 1.0).abs() < 1e-3, "{branch:?}");
            assert!(deviation.unwrap() < 3e-3, "{deviation:?}");
            let again = map.along(branch);
            assert_eq!((again.count, again.mean), (count, mean));
        }
    }

    #[test]
    fn one_grating_and_single_outliers_have_no_branches() {
        let (wavelengths, angles) = axes();
        let of = |gratings: &[(f64, &dyn Fn(f64) -> f64)]| {
            let responses = responses(&wavelengths, &angles, gratings);
            ResponseMap {
                wavelengths: &wavelengths,
                angles: &angles,
                responses: &responses,
                sought: sought(),
            }
            .branches()
        };
        assert_eq!(of(&[(1.128, &|_| 1.0)]), []);
        assert_eq!(of(&[(1.128, &|_| 1.0), (1.016, &|_| 0.5)]), [], "never the brightest");
        let outlier = |w: f64| if (w - 0.5).abs() < 1e-3 { 2.0 } else { 0.5 };
        assert_eq!(of(&[(1.128, &|_| 1.0), (1.016, &outlier)]), []);
        assert_eq!(of(&[]), [], "no maximum at all");
        // Two maxima that are too close to be separate branches.
        let late = |w: f64| if w < 0.6 { 0.5 } else { 2.0 };
        assert_eq!(of(&[(1.128, &|_| 1.0), (1.112, &late)]), []);
    }

    #[test]
    fn a_branch_ends_where_its_maximum_leaves_the_range() {
        let (wavelengths, angles) = axes();
        let angles: Vec<f64> = angles.into_iter().filter(|&a| a < 33.0).collect();
        let strength = |w: f64| if w < 0.6 { 0.1 } else { 4.0 };
        let responses = responses(&wavelengths, &angles, &[(1.016, &|_| 1.0), (1.3, &strength)]);
        let map = ResponseMap {
            wavelengths: &wavelengths,
            angles: &angles,
            responses: &responses,
            sought: sought(),
        };
        let branches = map.branches();
        assert_eq!(branches.len(), 2);
        let inside = |period: f64| {
            let sine = |&w: &f64| grating::sin_view(w, THETA_I.to_radians().sin(), period, 1).unwrap();
            wavelengths.iter().filter(|w| sine(w) < 32.9f64.to_radians().sin()).count()
        };
        let strongest = if branches[0].statistics.mean.unwrap() > 1.2 { [1.3, 1.016] } else { [1.016, 1.3] };
        for (branch, period) in branches.iter().zip(strongest) {
            assert!((branch.statistics.mean.unwrap() / period - 1.0).abs() < 2e-3, "{branch:?}");
            assert!(branch.statistics.count.abs_diff(inside(period)) <= 1 && branch.statistics.count < 81);
        }
    }

    #[test]
    fn steps_between_coarse_angles_are_no_branches() {
        let (wavelengths, angles) = axes();
        let angles: Vec<f64> = angles.into_iter().step_by(40).collect();
        let responses = responses(&wavelengths, &angles, &[(1.128, &|_| 1.0)]);
        let map = ResponseMap {
            wavelengths: &wavelengths,
            angles: &angles,
            responses: &responses,
            sought: sought(),
        };
        assert_eq!(map.branches(), []);
    }
}
