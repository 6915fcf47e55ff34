//! What a pixel averages over: an ellipse of (u, v), and the taps that stand for it.

use glam::DVec2;

/// What is averaged over the directions of a pixel: the covariance of (u, v), dimensionless.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Covariance {
    /// Of u.
    pub uu: f64,
    /// Of u with v.
    pub uv: f64,
    /// Of v.
    pub vv: f64,
}

impl Covariance {
    /// Of the footprint with the columns `dx`, `dy` of ∂(u, v)/∂(pixel) under a Gaussian pixel filter of standard deviation
    /// `sigma` \[pixels\].
    pub fn of_footprint(dx: DVec2, dy: DVec2, sigma: f64) -> Self {
        let s = sigma * sigma;
        Self {
            uu: s * (dx.x * dx.x + dy.x * dy.x),
            uv: s * (dx.x * dx.y + dy.x * dy.y),
            vv: s * (dx.y * dx.y + dy.y * dy.y),
        }
    }

    /// Variances along the longer and the shorter axis.
    pub fn axes(&self) -> [f64; 2] {
        let (mean, difference) = (0.5 * (self.uu + self.vv), 0.5 * (self.uu - self.vv));
        let spread = difference.hypot(self.uv);
        [mean + spread, (mean - spread).max(0.0)]
    }

    /// Unit vector along the longer axis.
    pub fn longer_axis(&self) -> DVec2 {
        DVec2::from_angle(0.5 * self.uv.atan2(0.5 * (self.uu - self.vv)))
    }
}

/// Which of the samples of a pixel is shaded. The taps of [`MOST_SHARED`] samples together are as close as those of a single one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Number of the sample, from 0.
    pub index: u32,
    /// Samples of the pixel.
    pub count: u32,
}

impl Default for Share {
    fn default() -> Self {
        Self::ALL
    }
}

impl Share {
    /// The only sample.
    pub const ALL: Self = Self { index: 0, count: 1 };

    /// By how many steps the taps of this sample are moved along the longer axis, −½ … ½. The golden ratio spreads them evenly however many samples
    /// there are.
    pub fn offset(self) -> f64 {
        const GOLDEN: f64 = 0.618_033_988_749_894_8;
        if self.count > 1 { (0.5 + f64::from(self.index) * GOLDEN).fract() - 0.5 } else { 0.0 }
    }
}

/// Places in a footprint, whose sum stands for the average over it: a row along the longer axis, or two, where what a tap
/// averages over is narrower than the shorter axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    /// Taps on either side of the middle one.
    pub sides: usize,
    /// From one tap to the next.
    pub step: DVec2,
    /// Steps from the middle of the footprint to the middle tap.
    pub offset: f64,
    /// The weight of a tap n steps from the middle of the footprint is exp(−`fall`·n²).
    pub fall: f64,
    /// From the middle of the footprint to the row; a second one is opposite.
    pub aside: DVec2,
    /// Rows.
    pub rows: usize,
}

/// Taps of the samples that share them are together so many standard deviations of what one of them averages over apart: a row of Gaussians so far apart is
/// even to 3.4 %, and the errors of its crests and troughs cancel over a picture.
pub const SPACING: f64 = 2.2;
/// Taps reach so many standard deviations of the longer axis: 0.3 % of the average lies beyond.
pub const REACH: f64 = 3.0;
/// So many samples of a pixel share the taps of its footprint. With more of them a bright order between two taps is missed too often.
pub const MOST_SHARED: u32 = 4;
/// Most taps on either side of a single sample. A longer footprint is read coarser.
pub const MOST_SIDES: usize = 32;
/// Fewest taps on either side of one of several samples, where the footprint needs as many: 1.5 standard deviations apart their weights add
/// up to the same within 3e-4 wherever they stand.
pub const FEWEST_SIDES: usize = 2;
/// A footprint whose longer axis adds less than this share to the standard deviation of a tap is a tap.
pub const ROUND: f64 = 0.2;

impl Taps {
    /// For the footprint `around`, of which the variance `own` is left to the shorter axis, where a tap averages over the variance `read` ≤ `own`,
    /// and all is blurred by the variance `blur` already.
    pub fn new(around: &Covariance, [own, read]: [f64; 2], blur: f64, share: Share) -> Self {
        let [longer, _] = around.axes();
        let axis = around.longer_axis();
        let left = (longer - read).max(0.0).sqrt();
        let tap = (read + blur).sqrt();
        let mut taps =
            Self { sides: 0, step: DVec2::ZERO, offset: 0.0, fall: 0.0, aside: DVec2::ZERO, rows: 1 };
        if left > ROUND * tap {
            let needed = (REACH * left / (SPACING * tap)).ceil();
            let fewest = needed.min(FEWEST_SIDES as f64);
            let sides =
                (needed / f64::from(share.count.min(MOST_SHARED))).ceil().clamp(fewest, MOST_SIDES as f64);
            let step = REACH / sides;
            taps = Self {
                sides: sides as usize,
                step: axis * (step * left),
                offset: share.offset(),
                fall: 0.5 * step * step,
                ..taps
            };
        }
        let rest = (own - read).max(0.0).sqrt();
        if rest > ROUND * tap {
            taps = Self { aside: axis.perp() * rest, rows: 2, ..taps };
        }
        taps
    }

    /// The least variance that a tap has to average over, so that [`MOST_SIDES`] suffice.
    pub fn least_own(around: &Covariance, blur: f64) -> f64 {
        let [longer, _] = around.axes();
        (longer * (REACH / (SPACING * MOST_SIDES as f64)).powi(2) - blur).max(0.0)
    }

    /// Displacement from the middle of the footprint and weight of each tap; the weights add up to 1.
    pub fn each(&self) -> impl Iterator<Item = (DVec2, f64)> {
        let own = *self;
        let weight = move |n: f64| (-own.fall * n * n).exp();
        let places = move || (-(own.sides as i64)..=own.sides as i64).map(move |k| k as f64 + own.offset);
        let norm: f64 = places().map(weight).sum::<f64>() * own.rows as f64;
        let row = move |aside: DVec2| places().map(move |n| (own.step * n + aside, weight(n) / norm));
        [own.aside, -own.aside].into_iter().take(own.rows).flat_map(row)
    }

    /// Number of taps.
    pub fn count(&self) -> usize {
        (2 * self.sides + 1) * self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Covariance = Covariance { uu: 4e-4, uv: 3e-4, vv: 3e-4 };

    #[test]
    fn axes_are_those_of_the_covariance() {
        let [longer, shorter] = LONG.axes();
        let axis = LONG.longer_axis();
        let along = LONG.uu * axis.x * axis.x + 2.0 * LONG.uv * axis.x * axis.y + LONG.vv * axis.y * axis.y;
        assert!((along - longer).abs() < 1e-15 && (longer + shorter - 7e-4).abs() < 1e-15);
        assert!((longer * shorter - (LONG.uu * LONG.vv - LONG.uv * LONG.uv)).abs() < 1e-18);
    }

    #[test]
    fn taps_and_what_each_averages_over_have_the_covariance_of_the_footprint() {
        let [longer, shorter] = LONG.axes();
        let axis = LONG.longer_axis();
        for (part, count) in [(1.0, 1), (0.3, 1), (1.0, 16), (0.3, 16), (0.5, 64)] {
            let read = part * shorter;
            let (mut mean, mut along, mut across, mut norm) = (DVec2::ZERO, 0.0, 0.0, 0.0);
            for index in 0..count {
                let taps = Taps::new(&LONG, [shorter, read], 0.0, Share { index, count });
                assert!(taps.count() == taps.each().count() && taps.sides <= MOST_SIDES);
                for (place, weight) in taps.each() {
                    let weight = weight / f64::from(count);
                    mean += place * weight;
                    along += weight * place.dot(axis).powi(2);
                    across += weight * place.dot(axis.perp()).powi(2);
                    norm += weight;
                }
            }
            assert!(
                (norm - 1.0).abs() < 1e-12 && mean.length() < 0.03 * longer.sqrt(),
                "{part} {count}: {mean}"
            );
            // What lies beyond the reach is missing.
            let found = [(along + read) / longer, (across + read) / shorter];
            assert!(found.iter().all(|ratio| (ratio - 1.0).abs() < 0.12), "{part} {count}: {found:?}");
        }
    }

    #[test]
    fn a_round_footprint_is_one_tap_and_a_very_long_one_is_read_coarser() {
        let round = Covariance { uu: 1e-4, uv: 0.0, vv: 1e-4 };
        assert_eq!(Taps::new(&round, [1e-4; 2], 0.0, Share::ALL).count(), 1);
        let very_long = Covariance { uu: 1.0, uv: 0.0, vv: 1e-8 };
        let own = Taps::least_own(&very_long, 0.0);
        assert!(own > 1e-8);
        assert!(Taps::new(&very_long, [own; 2], 0.0, Share::ALL).count() <= 2 * MOST_SIDES + 1);
        assert!(Taps::least_own(&round, 0.0) < 1e-6);
    }
}
