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

/// How large the footprints of a picture's pixels are: what a source has to resolve, and how much rows of taps average.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FootprintSizes {
    /// Standard deviation of (u, v) along the shorter axis that all but a fiftieth of the pixels exceed; 0 where single directions are asked for.
    pub shorter: f64,
    /// Standard deviation along the longer axis that three of four pixels exceed.
    pub longer: f64,
}

impl FootprintSizes {
    /// The finer of both along either axis, so that a source resolves both pictures. A picture without footprints asks for nothing.
    #[must_use]
    pub fn finer(self, other: Self) -> Self {
        match (self.longer > 0.0, other.longer > 0.0) {
            (true, false) => self,
            (false, _) => other,
            _ => Self { shorter: self.shorter.min(other.shorter), longer: self.longer.min(other.longer) },
        }
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

/// Places in a footprint, whose weighted sum stands for the average over it: a row along the longer axis, and two beside it where what a tap
/// averages over is narrower than the shorter axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    /// Taps on either side of the middle one, in the row along the longer axis.
    pub sides: usize,
    /// The longer axis, as long as the standard deviation that is left to the row.
    along: DVec2,
    /// The same of the shorter axis; 0 where there is one row.
    across: DVec2,
    /// By how many steps the taps of a row are moved.
    offset: f64,
}

/// Taps in a line.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    /// Taps on either side of the middle one.
    sides: usize,
    /// Steps from the middle of the row to its middle tap.
    offset: f64,
    /// From the middle of the footprint to that of the row.
    aside: DVec2,
    /// Share of the row in the average.
    weight: f64,
}

/// The taps of a sample stand so many standard deviations of what one of them averages over apart, at most. A row of Gaussians h apart is even to
/// 2 exp(−2π²/h²): 1.4 %. With 3.0, 22 %, crests and troughs cancel on a surface of many orders, and a disc of few orders errs by a relative L2 of
/// 0.12.
pub const SPACING: f64 = 2.0;
/// Taps reach so many standard deviations of the longer axis: 0.9 % of the average lies beyond.
pub const REACH: f64 = 2.6;
/// So many samples of a pixel share the taps of its footprint. Four of sixteen samples that share theirs miss bright orders: relative L2 on the
/// snake grows by 0.03.
pub const MOST_SHARED: u32 = 2;
/// Most taps on either side of a single sample. A longer footprint is read coarser.
pub const MOST_SIDES: usize = 36;
/// Fewest taps on either side of one of several samples: 1.3 standard deviations apart their weights add up to the same within 1 % wherever they
/// stand.
pub const FEWEST_SIDES: usize = 2;
/// A footprint whose longer axis adds less than this share to the standard deviation of a tap is a tap.
pub const ROUND: f64 = 0.2;
/// A footprint whose shorter axis adds less than this share to the standard deviation of a tap is one row. With 0.7
/// instead a tenth less is read: relative L2 on the snake is nearly the same, and on a sphere 0.013 instead of 0.006.
pub const NARROW: f64 = 0.3;
/// Rows beside the one along the longer axis stand so many standard deviations of the shorter axis away from it and have this weight each: with them
/// the average has the first five moments of a Gaussian (Gauss and Hermite's rule of three places).
const ASIDE: f64 = 1.732_050_807_568_877_2;
const WEIGHT_ASIDE: f64 = 1.0 / 6.0;
/// The taps of these rows are so much farther apart, and moved by half a step: a seventh less is read for nearly the same error. Twice as far apart, relative L2 on a
/// sphere is three times as large.
const SPARSER_ASIDE: f64 = 1.5;
const OFFSET_ASIDE: f64 = 0.5;

impl Taps {
    /// For the footprint `around`, of which the variance `own` is left to the shorter axis, where a tap averages over the variance `read` ≤ `own`,
    /// and all is blurred by the variance `blur` already.
    pub fn new(around: &Covariance, [own, read]: [f64; 2], blur: f64, share: Share) -> Self {
        let shared = f64::from(share.count.min(MOST_SHARED));
        let mut taps = Self::spaced(around, [own, read], blur, SPACING * shared);
        if taps.sides > 0 && share.count > 1 {
            taps.sides = taps.sides.max(FEWEST_SIDES);
            taps.offset = share.offset();
        }
        taps
    }

    /// The same for a sample that shares its taps with none.
    pub fn unshared(around: &Covariance, [own, read]: [f64; 2], blur: f64) -> Self {
        Self::spaced(around, [own, read], blur, SPACING)
    }

    fn spaced(around: &Covariance, [own, read]: [f64; 2], blur: f64, spacing: f64) -> Self {
        let [longer, _] = around.axes();
        let axis = around.longer_axis();
        let left = (longer - read).max(0.0).sqrt();
        let tap = (read + blur).sqrt();
        let mut taps = Self { sides: 0, along: axis * left, across: DVec2::ZERO, offset: 0.0 };
        if left > ROUND * tap {
            taps.sides = (REACH * left / (spacing * tap)).ceil().min(MOST_SIDES as f64) as usize;
        }
        let rest = (own - read).max(0.0).sqrt();
        if rest > NARROW * tap {
            taps.across = axis.perp() * rest;
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
        let along = self.along;
        self.rows().flat_map(move |row| {
            // Three taps are those of Gauss and Hermite, too.
            let (step, fall) = match row.sides {
                0 => (0.0, 0.0),
                1 => (ASIDE, ((1.0 - 2.0 * WEIGHT_ASIDE) / WEIGHT_ASIDE).ln()),
                sides => (REACH / sides as f64, 0.5 * (REACH / sides as f64).powi(2)),
            };
            let places = move || (-(row.sides as i64)..=row.sides as i64).map(move |k| k as f64 + row.offset);
            let weight = move |n: f64| (-fall * n * n).exp();
            let norm: f64 = places().map(weight).sum();
            places().map(move |n| (along * (step * n) + row.aside, row.weight * weight(n) / norm))
        })
    }

    /// Number of taps.
    pub fn count(&self) -> usize {
        self.rows().map(|row| 2 * row.sides + 1).sum()
    }

    fn rows(&self) -> impl Iterator<Item = Row> {
        let one = self.across == DVec2::ZERO;
        let middle = Row {
            sides: self.sides,
            offset: self.offset,
            aside: DVec2::ZERO,
            weight: if one { 1.0 } else { 1.0 - 2.0 * WEIGHT_ASIDE },
        };
        let moved = (self.offset + OFFSET_ASIDE + 0.5).fract() - 0.5;
        let sides = (self.sides as f64 / SPARSER_ASIDE).ceil() as usize;
        let aside = |side: f64| Row {
            sides,
            offset: if sides > 1 { moved } else { 0.0 },
            aside: self.across * (side * ASIDE),
            weight: WEIGHT_ASIDE,
        };
        let beside = [1.0, -1.0].map(aside);
        std::iter::once(middle).chain(beside.into_iter().take(if one { 0 } else { 2 }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

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
        // Of a Gaussian that ends at 2.6 standard deviations 8 % of the variance are missing.
        let within = 1.0 - 2.0 * REACH * (-0.5 * REACH * REACH).exp() / (2.0 * PI).sqrt() - 0.0093;
        let [longer, shorter] = LONG.axes();
        let axis = LONG.longer_axis();
        for (part, count, blur) in [
            (1.0, 1, 0.0),
            (0.3, 1, 0.0),
            // So wide that a row has three taps, and five.
            (1.0, 1, 1e-3),
            (0.3, 1, 1.5e-4),
            (1.0, 16, 0.0),
            (0.3, 16, 0.0),
            (0.5, 64, 0.0),
        ] {
            let read = part * shorter;
            let (mut mean, mut along, mut across, mut norm) = (DVec2::ZERO, 0.0, 0.0, 0.0);
            for index in 0..count {
                let taps = Taps::new(&LONG, [shorter, read], blur, Share { index, count });
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
            // Steps of 1.3 standard deviations, of which the last ones count or not, leave a few per cent of the variance open.
            let left = along / (longer - read);
            assert!(left > within - 0.03 && left < 1.03, "{part} {count}: {left}");
            // Where there is one row, up to NARROW² of what a tap averages over is left out.
            let found = (across + read) / shorter;
            assert!(if across > 0.0 {
                (found - 1.0).abs() < 1e-9
            } else {
                found >= 1.0 / (1.0 + NARROW * NARROW)
            });
        }
    }

    #[test]
    fn the_finer_of_two_pictures_counts_and_one_without_footprints_does_not() {
        let sizes = |shorter, longer| FootprintSizes { shorter, longer };
        assert_eq!(sizes(1e-3, 5e-2).finer(sizes(2e-3, 3e-2)), sizes(1e-3, 3e-2));
        let none = FootprintSizes::default();
        assert_eq!(sizes(1e-3, 5e-2).finer(none), sizes(1e-3, 5e-2));
        assert_eq!(none.finer(sizes(1e-3, 5e-2)), sizes(1e-3, 5e-2));
        assert_eq!(none.finer(none), none);
    }

    #[test]
    fn three_rows_have_the_fourth_moment_of_a_gaussian() {
        let [_, shorter] = LONG.axes();
        let taps = Taps::new(&LONG, [shorter, 0.25 * shorter], 0.0, Share::ALL);
        let across = LONG.longer_axis().perp();
        let moment = |n| taps.each().map(|(place, weight)| weight * place.dot(across).powi(n)).sum::<f64>();
        let rest = 0.75 * shorter;
        assert!(
            (moment(2) / rest - 1.0).abs() < 1e-9 && (moment(4) / (3.0 * rest * rest) - 1.0).abs() < 1e-9
        );
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
