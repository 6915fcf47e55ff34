//! Maxima of the response over view angles at each wavelength, and their periods by the grating equation.

use crate::optics::geometry::sin_cos_degrees;
use crate::optics::grating;

/// Largest response of one wavelength over a sweep of view angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Wavelength \[µm\].
    pub wavelength: f64,
    /// Angle with the largest response \[degrees\]; `None` if nothing is reflected.
    pub angle: Option<f64>,
    /// Period m λ/|sin α + sin θ_i| \[µm\] at this angle; `None` also in the specular direction, which fits every
    /// period.
    pub period: Option<f64>,
    /// Largest response \[sr⁻¹\].
    pub response: f64,
    /// True if the maximum lies inside the sweep. At an end, the true maximum may lie beyond.
    pub clear: bool,
}

/// Light, order and expected period of the maxima to find.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sought {
    /// Angle of the light \[degrees\].
    pub theta_i: f64,
    /// Order of diffraction assigned to the maxima.
    pub order: u32,
    /// Approximate period of the grating \[µm\]. If given, only angles within half an order are considered: sin α + sin
    /// θ_i lies between (m − ½) λ/d and (m + ½) λ/d on either side.
    pub period: Option<f64>,
}

impl Sought {
    /// Returns the peak among `responses` \[sr⁻¹\] at `angles` \[degrees\], for light of `wavelength` \[µm\]. The first
    /// of equal responses is taken. The angle is one of the sweep's, not interpolated.
    pub fn largest(&self, wavelength: f64, angles: &[f64], responses: &[f64]) -> Peak {
        let kept = (0..responses.len()).filter(|&i| self.keeps(wavelength, angles[i]));
        let best = kept.fold(None, |best: Option<usize>, i| match best {
            Some(largest) if responses[i] <= responses[largest] => best,
            _ => (responses[i] > 0.0).then_some(i).or(best),
        });
        best.map_or(Peak { wavelength, angle: None, period: None, response: 0.0, clear: false }, |place| {
            self.peak(wavelength, angles, responses, place)
        })
    }

    /// Returns all maxima inside the sweep, in the order of angles.
    pub fn maxima(&self, wavelength: f64, angles: &[f64], responses: &[f64]) -> Vec<Peak> {
        let places = 1..responses.len().saturating_sub(1);
        let is_maximum = |&i: &usize| responses[i - 1] < responses[i] && responses[i] >= responses[i + 1];
        let kept = places.filter(is_maximum).filter(|&i| self.keeps(wavelength, angles[i]));
        kept.map(|i| self.peak(wavelength, angles, responses, i)).filter(|peak| peak.clear).collect()
    }

    /// Returns the period \[µm\] whose order lies at `angle` \[degrees\]; `None` in the specular direction.
    pub fn period(&self, wavelength: f64, angle: f64) -> Option<f64> {
        grating::period(wavelength, sine(self.theta_i), sine(angle), self.order)
    }

    fn peak(&self, wavelength: f64, angles: &[f64], responses: &[f64], place: usize) -> Peak {
        let keep = |place: usize| self.keeps(wavelength, angles[place]);
        Peak {
            wavelength,
            angle: Some(angles[place]),
            period: self.period(wavelength, angles[place]),
            response: responses[place],
            clear: place > 0 && place + 1 < angles.len() && keep(place - 1) && keep(place + 1),
        }
    }

    /// Returns true if `angle` \[degrees\] can belong to the order.
    fn keeps(&self, wavelength: f64, angle: f64) -> bool {
        self.period.is_none_or(|period| {
            let u = (sine(angle) + sine(self.theta_i)).abs();
            (u * period / wavelength - f64::from(self.order)).abs() < 0.5
        })
    }
}

/// Returns the sine, exactly odd, so that the sum in the specular direction is exactly 0.
fn sine(angle: f64) -> f64 {
    sin_cos_degrees(angle.abs()).0 * angle.signum()
}

/// Statistics of the periods of many wavelengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodStatistics {
    /// Number of wavelengths with a period.
    pub count: usize,
    /// Number of wavelengths whose maximum lies inside the sweep.
    pub clear: usize,
    /// Mean period \[µm\]; `None` if no wavelength has one.
    pub mean: Option<f64>,
    /// Standard deviation of the sample, with n − 1 \[µm\]; `None` below two wavelengths.
    pub deviation: Option<f64>,
}

impl PeriodStatistics {
    /// Returns the statistics of all peaks that have a period, clear or not.
    pub fn of(peaks: &[Peak]) -> Self {
        let periods: Vec<f64> = peaks.iter().filter_map(|p| p.period).collect();
        let count = periods.len();
        let mean = periods.iter().sum::<f64>() / count as f64;
        let squares = periods.iter().map(|d| (d - mean).powi(2)).sum::<f64>();
        Self {
            count,
            clear: peaks.iter().filter(|p| p.clear).count(),
            mean: (count > 0).then_some(mean),
            deviation: (count > 1).then(|| (squares / (count as f64 - 1.0)).sqrt()),
        }
    }
}

/// Uncertainty of a mean over windows as an estimate for an infinite surface of the same kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowSpread {
    /// Number of averaged windows.
    pub windows: usize,
    /// Effective number of independent windows.
    pub independent: f64,
    /// Standard error of the mean period \[µm\]; 0 if the windows differ by less than a step of the sweep's angles.
    pub error: f64,
    /// Half the width of its 95 % confidence interval \[µm\]; `None` if the error is 0, or if fewer than
    /// [`WindowSpread::FEWEST`] windows are independent.
    pub half_interval: Option<f64>,
}

impl WindowSpread {
    /// Fewest independent windows for a confidence interval.
    pub const FEWEST: f64 = 4.0;

    /// Estimates the uncertainty by the jackknife. `without` holds the mean period \[µm\] of all windows but one, for
    /// each of them. If windows overlap, only `independent` of them are independent, and the error is larger by the
    /// root of the ratio. `None` for fewer than two windows, or two independent ones.
    ///
    /// Efron and Stein 1981, "The jackknife estimate of variance": the variance is (n − 1)/n times the sum of squared
    /// deviations.
    pub fn jackknife(without: &[f64], independent: f64) -> Option<Self> {
        let count = without.len() as f64;
        let independent = independent.min(count);
        if without.len() < 2 || independent < 2.0 {
            return None;
        }
        // From the first, so that equal ones have an error of exactly 0.
        let from_first = || without.iter().map(|d| d - without[0]);
        let mean = from_first().sum::<f64>() / count;
        let squares: f64 = from_first().map(|d| (d - mean).powi(2)).sum();
        let error = ((count - 1.0) / count * squares * count / independent).sqrt();
        let has_interval = independent >= Self::FEWEST && error > 0.0;
        let half_interval = has_interval.then(|| student_95(independent - 1.0) * error);
        Some(Self { windows: without.len(), independent, error, half_interval })
    }
}

/// Returns the 97.5 % quantile of Student's t with `freedom` ≥ 3 degrees of freedom, within 1 %: the Cornish–Fisher
/// expansion (Abramowitz and Stegun 26.7.5).
fn student_95(freedom: f64) -> f64 {
    const NORMAL: f64 = 1.959_963_984_540_054;
    let power = |n| NORMAL.powi(n);
    NORMAL
        + (power(3) + NORMAL) / (4.0 * freedom)
        + (5.0 * power(5) + 16.0 * power(3) + 3.0 * NORMAL) / (96.0 * freedom.powi(2))
        + (3.0 * power(7) + 19.0 * power(5) + 17.0 * power(3) - 15.0 * NORMAL) / (384.0 * freedom.powi(3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jackknife_of_a_mean_is_its_standard_error() {
        // For means of all but one of n numbers the jackknife gives s/√n exactly.
        let numbers = [1.0, 2.0, 4.0, 7.0, 11.0];
        let sum: f64 = numbers.iter().sum();
        let without: Vec<f64> = numbers.iter().map(|x| (sum - x) / 4.0).collect();
        let variance = numbers.iter().map(|x| (x - sum / 5.0).powi(2)).sum::<f64>() / 4.0;
        let spread = WindowSpread::jackknife(&without, 5.0).unwrap();
        assert!((spread.error - (variance / 5.0).sqrt()).abs() < 1e-12);
        // Tables of Student's t for 4 degrees of freedom: 2.776.
        assert!((spread.half_interval.unwrap() / spread.error - 2.776).abs() < 0.01);
        // Half as many independent windows, twice the variance.
        let overlapping = WindowSpread::jackknife(&without, 2.5).unwrap();
        assert!((overlapping.error / spread.error - 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(overlapping.half_interval, None);
        let equal = WindowSpread::jackknife(&[1.1; 5], 5.0).unwrap();
        assert_eq!(
            (equal.error, equal.half_interval),
            (0.0, None),
            "nothing tells how far they are from the truth"
        );
        assert_eq!(WindowSpread::jackknife(&without, 1.5), None);
        assert_eq!(WindowSpread::jackknife(&without[..1], 5.0), None);
    }

    #[test]
    fn student_s_t_is_that_of_tables() {
        for (freedom, expected) in [(3.0, 3.182), (5.0, 2.571), (15.0, 2.131), (100.0, 1.984)] {
            assert!((student_95(freedom) / expected - 1.0).abs() < 0.01, "{freedom}");
        }
    }

    #[test]
    fn the_largest_response_gives_the_angle_and_the_period() {
        let angles = [-10.0, 0.0, 30.0, 40.0];
        let find = |order, responses: &[f64]| {
            Sought { theta_i: 0.0, order, period: None }.largest(0.5, &angles, responses)
        };
        let peak = find(2, &[1.0, 2.0, 5.0, 3.0]);
        assert_eq!((peak.angle, peak.response, peak.clear), (Some(30.0), 5.0, true));
        assert!((peak.period.unwrap() - 2.0).abs() < 1e-12);
        assert!(!find(1, &[6.0, 2.0, 5.0, 3.0]).clear, "at the start");
        assert!(!find(1, &[1.0, 2.0, 5.0, 7.0]).clear, "at the end");
        assert_eq!(find(1, &[1.0, 5.0, 5.0, 3.0]).angle, Some(0.0), "the first");
    }

    #[test]
    fn an_order_s_peak_is_sought_within_half_an_order() {
        // λ/d = 0.25 at normal incidence: orders at 14.48°, 30° and 48.59°.
        let angles = [10.0, 14.5, 19.0, 25.0, 30.0, 35.0, 42.0, 48.6, 55.0];
        let responses = [0.1, 1.0, 0.2, 0.3, 9.0, 0.4, 0.1, 2.0, 0.1];
        let sought = |order| Sought { theta_i: 0.0, order, period: Some(2.0) };
        let of = |order| sought(order).largest(0.5, &angles, &responses);
        assert_eq!([1, 2, 3].map(|m| of(m).angle), [Some(14.5), Some(30.0), Some(48.6)]);
        assert!([1, 2, 3].into_iter().all(|m| of(m).clear));
        assert!(!sought(1).largest(0.5, &angles[2..5], &responses[2..5]).clear, "its side is the end");
        assert_eq!(of(4).angle, None, "no angle that far");
        // Without a period, all three are maxima.
        assert_eq!(sought(2).maxima(0.5, &angles, &responses).len(), 1);
        let all = Sought { period: None, ..sought(1) }.maxima(0.5, &angles, &responses);
        assert_eq!(all.iter().map(|p| p.angle).collect::<Vec<_>>(), [Some(14.5), Some(30.0), Some(48.6)]);
    }

    #[test]
    fn the_specular_direction_has_no_period_and_darkness_no_angle() {
        let angles = [-31.0, -30.0, -29.0];
        let sought = Sought { theta_i: 30.0, order: 1, period: None };
        let specular = sought.largest(0.5, &angles, &[1.0, 2.0, 1.0]);
        assert_eq!((specular.angle, specular.period), (Some(-30.0), None));
        let dark = sought.largest(0.5, &angles, &[0.0; 3]);
        assert_eq!((dark.angle, dark.period, dark.response, dark.clear), (None, None, 0.0, false));
        assert_eq!(PeriodStatistics::of(&[specular, dark]).mean, None);
    }

    #[test]
    fn statistics_are_those_of_the_periods() {
        let peak = |period, clear| Peak { wavelength: 0.5, angle: Some(1.0), period, response: 1.0, clear };
        let all = [peak(Some(1.0), true), peak(Some(2.0), false), peak(Some(3.0), true), peak(None, true)];
        let s = PeriodStatistics::of(&all);
        assert_eq!((s.count, s.clear, s.mean, s.deviation), (3, 3, Some(2.0), Some(1.0)));
        assert_eq!(PeriodStatistics::of(&all[..1]).deviation, None);
    }
}
