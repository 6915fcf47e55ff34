//! What a pixel averages over: an ellipse of (u, v), and the taps that stand for it.

use glam::DVec2;
use std::f64::consts::{PI, SQRT_2};

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
    /// Standard deviation along the longer axis that three of four pixels exceed, over a pixel's samples together.
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

/// What a tap averages over, beside a blur that all have: the variance of the level that is read, and of the next coarser one, where there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Of the level that is read.
    pub read: f64,
    /// Of the next coarser one.
    pub next: Option<f64>,
    /// What all is blurred by already.
    pub blur: f64,
}

/// Places in a footprint, whose weighted sum stands for the average over it: a row along the longer axis; or, where what a tap averages over is
/// narrower than the shorter axis, a row of the next coarser level, one on either side of it, and perhaps one between these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    rows: [Row; 4],
    count: usize,
}

/// Where one tap stands, and what it counts for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// Displacement from the middle of the footprint.
    pub place: DVec2,
    /// Share of the average; all add up to 1.
    pub weight: f64,
    /// Whether it is of the next coarser level.
    pub coarser: bool,
}

/// Taps in a line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Row {
    /// Steps from the middle of the row to its first tap.
    first: f64,
    /// Number of taps.
    count: usize,
    /// From one tap to the next.
    step: DVec2,
    /// The weight of a tap n steps from the middle is exp(−fall n²).
    fall: f64,
    /// From the middle of the footprint to that of the row.
    aside: DVec2,
    /// Share of the row in the average.
    weight: f64,
    /// Whether it reads the next coarser level.
    coarser: bool,
}

/// How closely the taps of a footprint stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TapRule {
    /// Taps of a row stand so many standard deviations of what one of them averages over apart, at most.
    pub spacing: f64,
    /// Between two levels, share of the finer one that is read in the middle; the rest is read on either side.
    pub middle: f64,
    /// How the weight of the coarser level bends, for least error.
    pub bend: f64,
    /// Whether both levels are read in the middle alone, weighed by `mixed_weight`.
    pub mixed: bool,
}

/// How rows stand for what is between two levels.
struct RowRule {
    rule: TapRule,
    // Relative L2 across the rows, for a single order.
    error: f64,
    // Taps, in those of one row of the finer level; the coarser one has half as many.
    cost: f64,
}

impl TapRule {
    /// Three rows. Taps this far apart are even to 1.0 %.
    pub const COARSE: Self = Self { spacing: 2.0, middle: 0.0, bend: 0.6, mixed: false };
    /// Four rows, and 0.3 %.
    pub const FINE: Self = Self { spacing: 1.8, middle: 0.5, bend: -0.12, mixed: false };

    /// From the most exact rule to the cheapest.
    const ROWS: [RowRule; 3] = [
        RowRule { rule: Self::FINE, error: 0.0093, cost: 3.5 },
        RowRule { rule: Self::COARSE, error: 0.034, cost: 2.5 },
        RowRule { rule: Self { mixed: true, ..Self::COARSE }, error: 0.10, cost: 1.5 },
    ];
    const SPACINGS: [f64; 4] = [Self::FINE.spacing, Self::COARSE.spacing, 2.5, 3.0];

    /// What a relative error of `tolerance` asks for where the light comes from so many orders of equal power: the fewest taps that are within it.
    ///
    /// On the default scene, shading is 1.2 times as fast at 5e-2 as by [`Self::COARSE`], and 1.8 times at 1e-1 (lavapipe, 640 × 480).
    pub fn of(tolerance: f64, orders: f64) -> Self {
        let is_exact = |error: f64, spacing: f64| is_within(error.hypot(ripple(spacing)), tolerance, orders);
        let all = Self::ROWS.iter().flat_map(|rows| Self::SPACINGS.map(|spacing| (rows, spacing)));
        let cost = |&(rows, spacing): &(&RowRule, f64)| rows.cost / spacing;
        let cheapest = all
            .filter(|&(rows, spacing)| is_exact(rows.error, spacing))
            .min_by(|a, b| cost(a).total_cmp(&cost(b)));
        cheapest.map_or(Self::FINE, |(rows, spacing)| Self { spacing, ..rows.rule })
    }

    /// The least variance that a tap has to average over, so that [`MOST_SIDES`] suffice.
    pub fn least_own(&self, around: &Covariance, blur: f64) -> f64 {
        let [longer, _] = around.axes();
        (longer * (REACH / (self.spacing * MOST_SIDES as f64)).powi(2) - blur).max(0.0)
    }
}

/// Taps reach so many standard deviations of the longer axis: 0.9 % of the average lies beyond.
pub const REACH: f64 = 2.6;
/// Most taps on either side of the middle. A longer footprint is read coarser.
pub const MOST_SIDES: usize = 100;
/// Most taps of a footprint: three rows.
pub const MOST_TAPS: usize = 3 * (2 * MOST_SIDES + 1);
/// A footprint whose longer axis adds less than this share to the standard deviation of a tap is a tap.
pub const ROUND: f64 = 0.2;
/// A footprint whose shorter axis adds less than this share to the standard deviation of a tap is one row.
pub const NARROW: f64 = 0.3;
/// Below the coarsest level, rows beside the one along the longer axis stand so many standard deviations of the shorter axis away from it and have this
/// weight each: the rule of Gauss and Hermite of three places. Three taps in a row are those, too.
const ASIDE: f64 = 1.732_050_807_568_877_2;
const WEIGHT_ASIDE: f64 = 1.0 / 6.0;
/// The taps of one of two rows beside each other are moved by half a step.
const OFFSET_ASIDE: f64 = 0.5;

/// Between two levels of variances v and 4 v, a Gaussian whose variance is at the place `s` (0 … 1) between them: the weight of the coarser level in
/// the middle, and the variance that is left to where the finer one is read around it, over 3 v. The weight is a fit to that of least squares.
fn between_levels(s: f64, bend: f64) -> [f64; 2] {
    [s * s * (1.0 + bend - bend * s), s * (1.0 - bend * s) / (1.0 + s - bend * s * s)]
}

/// Relative L2 error of a row of Gaussians `spacing` standard deviations apart that stands for an even line: by Poisson's sum formula it ripples by
/// 2 exp(−2π²/spacing²).
fn ripple(spacing: f64) -> f64 {
    SQRT_2 * (-2.0 * (PI / spacing).powi(2)).exp()
}

/// Bends of `mixed_weight` for rows, and for reads in the plane.
pub const MIXED_ROWS: [f64; 2] = [0.6, 0.4];
/// See [`MIXED_ROWS`].
pub const MIXED_IN_THE_PLANE: [f64; 2] = [0.75, 0.55];

/// At the place `s` (0 … 1) between two levels of variances v and 4 v that are both read in the middle alone: the weight of the coarser one, a fit to that of
/// least squares where a Gaussian of the same variance blurs the average. Relative L2 then: 0.02 across a line, 0.035 in the plane; without that blur, 0.10
/// and 0.19.
fn mixed_weight(s: f64, [bend, turn]: [f64; 2]) -> f64 {
    s * (1.0 + (bend - turn * s) * (1.0 - s))
}

/// Reads of two levels that stand for a round Gaussian between them: the coarser one in the middle, the finer one there and at the corners of a regular polygon.
/// Relative L2 in the plane: a square 0.063, a hexagon 0.024; a mixture of the two levels in the middle errs by 0.14 across any line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polygon {
    /// Number of corners.
    pub corners: usize,
    /// Share of the finer level that is read in the middle.
    pub middle: f64,
    /// How the weight of the coarser level bends.
    pub bend: f64,
    /// Whether both levels are read in the middle alone, weighed by `mixed_weight`.
    pub mixed: bool,
}

/// Whether what errs by `error` for one order takes no more than its share of `tolerance` over so many orders, whose errors are independent.
///
/// A picture may show few of a surface's orders: a plate of *Xenopeltis* shows two. So an error beyond the usual ones counts as averaged by
/// [`MOST_SEEN`] orders at most.
fn is_within(error: f64, tolerance: f64, orders: f64) -> bool {
    const SHARE: f64 = 0.7;
    const MOST_SEEN: f64 = 4.0;
    const USUAL: f64 = 0.065;
    let orders = if error > USUAL { orders.min(MOST_SEEN) } else { orders };
    error / orders.max(1.0).sqrt() <= SHARE * tolerance
}

impl Polygon {
    /// Four corners.
    pub const SQUARE: Self = Self { corners: 4, middle: 0.0, bend: 0.5, mixed: false };
    /// Six corners and the middle.
    pub const HEXAGON: Self = Self { corners: 6, middle: 0.25, bend: 0.0, mixed: false };

    /// What a relative error of `tolerance` asks for where the light comes from so many orders of equal power.
    pub fn of(tolerance: f64, orders: f64) -> Self {
        let polygon = if is_within(0.063, tolerance, orders) { Self::SQUARE } else { Self::HEXAGON };
        Self { mixed: is_within(0.19, tolerance, orders), ..polygon }
    }

    /// Number of reads of both levels.
    pub fn reads(&self) -> usize {
        if self.mixed { 2 } else { self.corners + usize::from(self.middle > 0.0) + 1 }
    }
}

impl Taps {
    /// By `rule` for the footprint `around`, of which the variance `own` ≥ that of the level that is read is left to the shorter axis.
    pub fn new(rule: TapRule, around: &Covariance, own: f64, levels: Levels) -> Self {
        Maker { rule, around, levels }.taps(own)
    }

    /// The taps.
    pub fn each(&self) -> impl Iterator<Item = Tap> {
        self.rows.into_iter().take(self.count).flat_map(|row| {
            let places = move || (0..row.count).map(move |k| k as f64 + row.first);
            let weight = move |n: f64| (-row.fall * n * n).exp();
            let norm: f64 = places().map(weight).sum();
            places().map(move |n| Tap {
                place: row.step * n + row.aside,
                weight: row.weight * weight(n) / norm,
                coarser: row.coarser,
            })
        })
    }

    /// Number of taps.
    pub fn count(&self) -> usize {
        self.rows.iter().take(self.count).map(|row| row.count).sum()
    }
}

/// What all rows of a footprint follow from.
struct Maker<'a> {
    rule: TapRule,
    around: &'a Covariance,
    levels: Levels,
}

impl Maker<'_> {
    fn taps(&self, own: f64) -> Taps {
        let Levels { read, next, blur } = self.levels;
        let [longer, _] = self.around.axes();
        let one = Row { weight: 1.0, ..self.row(longer - read, read, 0.0) };
        let rest = (own - read).max(0.0);
        if rest.sqrt() <= NARROW * (read + blur).sqrt() {
            return Taps { rows: [one, Row::default(), Row::default(), Row::default()], count: 1 };
        }
        match next.filter(|next| *next > read) {
            Some(next) => self.between(rest, next),
            None => self.beyond(rest, one),
        }
    }

    /// Rows of two levels.
    fn between(&self, rest: f64, next: f64) -> Taps {
        let Levels { read, .. } = self.levels;
        let TapRule { middle, bend, mixed, .. } = self.rule;
        let [longer, _] = self.around.axes();
        let place = (rest / (next - read)).min(1.0);
        let [coarser, left] =
            if mixed { [mixed_weight(place, MIXED_ROWS), 0.0] } else { between_levels(place, bend) };
        let aside = self.around.longer_axis().perp() * (left * (next - read) / (1.0 - middle)).sqrt();
        let has_middle = middle > 0.0;
        // All rows together have the variance of the longer axis.
        let along = (longer - coarser * longer.max(next)) / (1.0 - coarser).max(1e-3) - read;
        let finer =
            |share: f64, moved: f64| Row { weight: share * (1.0 - coarser), ..self.row(along, read, moved) };
        let beside =
            |side: f64, moved: f64| Row { aside: aside * side, ..finer(0.5 * (1.0 - middle), moved) };
        let coarse = Row { weight: coarser, coarser: true, ..self.row(longer - next, next, 0.0) };
        if mixed {
            return Taps { rows: [coarse, finer(1.0, 0.0), Row::default(), Row::default()], count: 2 };
        }
        // Rows beside each other stand half a step apart.
        let moved = if has_middle { OFFSET_ASIDE } else { 0.0 };
        let rows = [coarse, beside(1.0, moved), beside(-1.0, OFFSET_ASIDE), finer(middle, 0.0)];
        Taps { rows, count: if has_middle { 4 } else { 3 } }
    }

    /// Rows below the coarsest level, beside the row `one`.
    fn beyond(&self, rest: f64, one: Row) -> Taps {
        let Levels { read, .. } = self.levels;
        let [longer, _] = self.around.axes();
        let aside = self.around.longer_axis().perp() * (ASIDE * rest.sqrt());
        let middle = Row { weight: 1.0 - 2.0 * WEIGHT_ASIDE, ..one };
        let beside = |side: f64| Row {
            aside: aside * side,
            weight: WEIGHT_ASIDE,
            ..self.row(longer - read, read, OFFSET_ASIDE)
        };
        Taps { rows: [middle, beside(1.0), beside(-1.0), Row::default()], count: 3 }
    }

    /// A row to which the variance `left` is left, of taps that average over `read`, moved by `moved` steps.
    fn row(&self, left: f64, read: f64, moved: f64) -> Row {
        let left = left.max(0.0).sqrt();
        let tap = (read + self.levels.blur).sqrt();
        if left <= ROUND * tap {
            return Row { count: 1, ..Row::default() };
        }
        let sides = (REACH * left / (self.rule.spacing * tap)).ceil().min(MOST_SIDES as f64) as usize;
        let along = self.around.longer_axis() * left;
        if sides == 1 {
            let fall = ((1.0 - 2.0 * WEIGHT_ASIDE) / WEIGHT_ASIDE).ln();
            return Row { first: -1.0, count: 3, step: along * ASIDE, fall, ..Row::default() };
        }
        let step = REACH / sides as f64;
        let first = -moved - sides as f64;
        Row { first, count: 2 * sides + 1, step: along * step, fall: 0.5 * step * step, ..Row::default() }
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
        // Of a Gaussian that ends at 2.6 standard deviations 8 % of the variance are missing.
        let within = 1.0 - 2.0 * REACH * (-0.5 * REACH * REACH).exp() / (2.0 * PI).sqrt() - 0.0093;
        let round = Covariance { uu: 1e-4, uv: 0.0, vv: 1e-4 };
        let cases = [
            (LONG, 1.0, 0.0),
            (LONG, 0.3, 0.0),
            (LONG, 0.5, 0.0),
            // So wide that a row has three taps, and five.
            (LONG, 1.0, 1e-3),
            (LONG, 0.3, 1.5e-4),
            (round, 0.3, 0.0),
            (round, 0.7, 1e-5),
        ];
        let both = cases.into_iter().flat_map(|case| [(TapRule::COARSE, case), (TapRule::FINE, case)]);
        for (rule, (around, part, blur)) in both {
            let [longer, shorter] = around.axes();
            let axis = around.longer_axis();
            let read = part * shorter;
            let (mut mean, mut along, mut across, mut norm) = (DVec2::ZERO, 0.0, 0.0, 0.0);
            for next in [None, Some(4.0 * read + 3.0 * blur)] {
                let levels = Levels { read, next, blur };
                let taps = Taps::new(rule, &around, shorter, levels);
                assert!(taps.count() == taps.each().count());
                for Tap { place, weight, coarser } in taps.each() {
                    let weight = weight / 2.0;
                    let own = if coarser { next.unwrap() } else { read };
                    mean += place * weight;
                    along += weight * (place.dot(axis).powi(2) + own);
                    across += weight * (place.dot(axis.perp()).powi(2) + own);
                    norm += weight;
                }
            }
            assert!((norm - 1.0).abs() < 1e-12 && mean.length() < 0.03 * longer.sqrt(), "{part}: {mean}");
            // Steps of 1.3 standard deviations, of which the last ones count or not, leave a few per cent of the variance open.
            let least = read + (within - 0.03) * (longer - read);
            assert!(along > least && along < 1.03 * longer, "{part} {blur}: {along}, {longer}");
            // Where there is one row, up to NARROW² of what a tap averages over is left out.
            let rest = (shorter - read).sqrt() / (read + blur).sqrt();
            if rest > NARROW {
                assert!((across / shorter - 1.0).abs() < 1e-9, "{part} {blur}: {across}");
            } else {
                assert!((across / read - 1.0).abs() < 1e-9);
            }
        }
    }

    /// Relative L2 in the plane of the Gaussians of `parts`, each a weight, a variance and a place, against one of `variance` in the middle.
    fn apart(parts: &[(f64, f64, DVec2)], variance: f64) -> f64 {
        // Two Gaussians of variances that add up to `sum`, `d` apart, multiplied and integrated.
        let product = |sum: f64, d: DVec2| (-d.length_squared() / (2.0 * sum)).exp() / (2.0 * PI * sum);
        let pairs = parts.iter().flat_map(|p| parts.iter().map(move |q| (p, q)));
        let own: f64 = pairs.map(|(p, q)| p.0 * q.0 * product(p.1 + q.1, p.2 - q.2)).sum();
        let mixed: f64 = parts.iter().map(|p| p.0 * product(p.1 + variance, p.2)).sum();
        let exact = product(2.0 * variance, DVec2::ZERO);
        ((own - 2.0 * mixed + exact).max(0.0) / exact).sqrt()
    }

    #[test]
    fn between_two_levels_rows_are_a_gaussian_across_them() {
        for (TapRule { middle, bend, .. }, most) in [(TapRule::COARSE, 0.035), (TapRule::FINE, 0.01)] {
            for i in 1..30 {
                let s = f64::from(i) / 30.0;
                let [coarser, left] = between_levels(s, bend);
                let (variance, d) = (1.0 + 3.0 * s, (3.0 * left / (1.0 - middle)).sqrt());
                let (beside, finer) = (0.5 * (1.0 - middle), 1.0 - coarser);
                let parts = [
                    (finer * beside, 1.0, d),
                    (finer * beside, 1.0, -d),
                    (finer * middle, 1.0, 0.0),
                    (coarser, 4.0, 0.0),
                ];
                let own: f64 = parts.iter().map(|p| p.0 * (p.1 + p.2 * p.2)).sum();
                assert!((own - variance).abs() < 1e-12);
                // A Gaussian in the plane is the product of those of its axes; along the row nothing differs.
                let product = |sum: f64, x: f64| (-x * x / (2.0 * sum)).exp() / (2.0 * PI * sum).sqrt();
                let pairs = parts.iter().flat_map(|p| parts.iter().map(move |q| (p, q)));
                let own: f64 = pairs.map(|(p, q)| p.0 * q.0 * product(p.1 + q.1, p.2 - q.2)).sum();
                let mixed: f64 = parts.iter().map(|p| p.0 * product(p.1 + variance, p.2)).sum();
                let exact = product(2.0 * variance, 0.0);
                let error = ((own - 2.0 * mixed + exact).max(0.0) / exact).sqrt();
                assert!(error < most, "{bend} at {s}: {error}");
            }
        }
    }

    #[test]
    fn between_two_levels_a_polygon_is_a_gaussian_in_the_plane() {
        for (polygon, most) in [(Polygon::SQUARE, 0.064), (Polygon::HEXAGON, 0.025)] {
            for i in 1..30 {
                let s = f64::from(i) / 30.0;
                // As `averaged_power` of `source_mean.glsl`: along each axis, the variance of the corners is half the square of their distance.
                let [coarser, left] = between_levels(s, polygon.bend);
                let distance = (2.0 * left * 3.0 / (1.0 - polygon.middle)).sqrt();
                let finer = 1.0 - coarser;
                let corner = |k: usize| {
                    let place = DVec2::from_angle(2.0 * PI * k as f64 / polygon.corners as f64) * distance;
                    (finer * (1.0 - polygon.middle) / polygon.corners as f64, 1.0, place)
                };
                let mut parts: Vec<_> = (0..polygon.corners).map(corner).collect();
                parts.extend([(coarser, 4.0, DVec2::ZERO), (finer * polygon.middle, 1.0, DVec2::ZERO)]);
                let variance: f64 = parts.iter().map(|p| p.0 * (p.1 + 0.5 * p.2.length_squared())).sum();
                assert!((variance - (1.0 + 3.0 * s)).abs() < 1e-12);
                let error = apart(&parts, variance);
                assert!(error < most, "{polygon:?} at {s}: {error}");
            }
        }
    }

    #[test]
    fn a_mixture_of_two_levels_that_is_blurred_is_a_gaussian() {
        // In one dimension, and in two.
        for (bends, dimensions, most) in [(MIXED_ROWS, 1, 0.021), (MIXED_IN_THE_PLANE, 2, 0.036)] {
            for i in 1..60 {
                let s = f64::from(i) / 60.0;
                let (variance, coarser) = (1.0 + 3.0 * s, mixed_weight(s, bends));
                assert!((0.0..=1.0).contains(&coarser));
                let parts =
                    [(1.0 - coarser, 1.0 + variance), (coarser, 4.0 + variance), (-1.0, 2.0 * variance)];
                let product = |sum: f64| (2.0 * PI * sum).sqrt().powi(-dimensions);
                let pairs = parts.iter().flat_map(|p| parts.iter().map(move |q| (p, q)));
                let square: f64 = pairs.map(|(p, q)| p.0 * q.0 * product(p.1 + q.1)).sum();
                let error = (square.max(0.0) / product(4.0 * variance)).sqrt();
                assert!(error < most, "{dimensions} at {s}: {error}");
            }
        }
    }

    #[test]
    fn a_row_of_gaussians_ripples_as_the_sum_formula_says() {
        for spacing in [1.8, 2.0, 2.5, 3.0] {
            let at =
                |x: f64| (-40..=40).map(|k| (-0.5 * (x - spacing * f64::from(k)).powi(2)).exp()).sum::<f64>();
            let places = (0..64).map(|i| spacing * f64::from(i) / 64.0);
            let mean = (2.0 * PI).sqrt() / spacing;
            let square = places.map(|x| (at(x) / mean - 1.0).powi(2)).sum::<f64>() / 64.0;
            assert!((square.sqrt() / ripple(spacing) - 1.0).abs() < 1e-3, "{spacing}");
        }
    }

    #[test]
    fn a_larger_tolerance_takes_fewer_taps() {
        let [_, shorter] = LONG.axes();
        let levels = Levels { read: 0.5 * shorter, next: Some(2.0 * shorter), blur: 0.0 };
        for orders in [1.0, 5.0, 40.0] {
            let count = |tolerance| Taps::new(TapRule::of(tolerance, orders), &LONG, shorter, levels).count();
            let counts = [1e-3, 1e-2, 3e-2, 1e-1, 3e-1].map(count);
            assert!(counts.is_sorted_by(|finer, coarser| finer >= coarser), "{counts:?}");
            assert!(counts[4] * 2 < counts[0], "{counts:?}");
        }
    }

    #[test]
    fn a_rule_that_mixes_reads_both_levels_in_one_row() {
        let [_, shorter] = LONG.axes();
        let levels = Levels { read: 0.5 * shorter, next: Some(2.0 * shorter), blur: 0.0 };
        let taps = |rule| Taps::new(rule, &LONG, shorter, levels);
        let across = LONG.longer_axis().perp();
        let has_rows_aside =
            |taps: &Taps| taps.each().any(|tap| tap.place.dot(across).abs() > 1e-6 * shorter.sqrt());
        let rows = taps(TapRule::COARSE);
        let mixed = taps(TapRule { mixed: true, ..TapRule::COARSE });
        assert!(has_rows_aside(&rows) && !has_rows_aside(&mixed) && mixed.count() < rows.count());
        let of = |coarser| mixed.each().filter(|t| t.coarser == coarser).map(|t| t.weight).sum::<f64>();
        assert!((of(true) - mixed_weight(1.0 / 3.0, MIXED_ROWS)).abs() < 1e-12);
        assert!((of(true) + of(false) - 1.0).abs() < 1e-12);
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
        let levels = Levels { read: 0.25 * shorter, next: None, blur: 0.0 };
        let taps = Taps::new(TapRule::COARSE, &LONG, shorter, levels);
        let across = LONG.longer_axis().perp();
        let moment = |n| taps.each().map(|tap| tap.weight * tap.place.dot(across).powi(n)).sum::<f64>();
        let rest = 0.75 * shorter;
        assert!(
            (moment(2) / rest - 1.0).abs() < 1e-9 && (moment(4) / (3.0 * rest * rest) - 1.0).abs() < 1e-9
        );
    }

    #[test]
    fn a_round_footprint_is_one_tap_and_a_very_long_one_is_read_coarser() {
        let at = |read| Levels { read, next: None, blur: 0.0 };
        let round = Covariance { uu: 1e-4, uv: 0.0, vv: 1e-4 };
        assert_eq!(Taps::new(TapRule::COARSE, &round, 1e-4, at(1e-4)).count(), 1);
        let very_long = Covariance { uu: 1.0, uv: 0.0, vv: 1e-8 };
        let own = TapRule::COARSE.least_own(&very_long, 0.0);
        assert!(own > 1e-8);
        assert!(Taps::new(TapRule::COARSE, &very_long, own, at(own)).count() <= 2 * MOST_SIDES + 1);
        assert!(TapRule::COARSE.least_own(&round, 0.0) < 1e-6);
    }
}
