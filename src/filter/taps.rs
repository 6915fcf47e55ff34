//! The rule by which taps stand for the average over a footprint: the twin of `shaders/footprint.glsl`.
//!
//! A level of a table averages over a round Gaussian. Along the longer axis a row of taps supplies the rest of the variance, and across it a mixture of
//! a row of one level and a row of the next coarser one, which has at most twice the variance. Below the coarsest level, two rows stand side by side.

use super::Covariance;
use glam::DVec2;

/// Largest distance between the taps of a row, in standard deviations of what a tap averages over.
pub const SPACING: f64 = 2.2;
/// Standard deviations at which the Gaussian weights of a short row end. The row is stretched to the variance that the cut takes away.
pub const REACH: f64 = 2.8;
/// Standard deviations at which the weights of an infinitely long row end: beside silhouettes, bright orders that far away outshine the middle.
pub const LONG_REACH: f64 = 4.0;
/// Growth of the reach with the length of a row: a row whose standard deviation is L times that of a tap ends at LONG_REACH − OVERHANG/L. The Gaussian of the
/// last tap itself reaches beyond short rows. On the default scene 10 takes 1.08 times the taps that REACH alone would, 2.4
/// takes 1.28 times; one sample of `skin` from afar errs by 0.014 and 0.011, by 0.060 with REACH alone.
const OVERHANG: f64 = 10.0;
/// Standard deviation that a Gaussian cut at REACH keeps, relative to that of the whole.
const KEPT: f64 = 0.9775;
/// Largest number of taps in a row. A longer footprint is read coarser.
pub const MOST_OF_ROW: usize = 201;
/// Largest number of rows.
const MOST_ROWS: usize = 2;
/// Largest number of taps.
pub const MOST_TAPS: usize = MOST_ROWS * MOST_OF_ROW;
/// A row whose standard deviation is below this part of that of a tap is a single tap, and two such rows side by side are one.
pub const ROUND: f64 = 0.2;

/// Largest relative L2 error of a single order along a row, at any length. Errors of N equal orders average to 1/√N of it.
pub const ERROR_ALONG: f64 = 0.027;
/// Largest relative L2 error of a single order across a footprint between two levels that no coherence blurs.
pub const ERROR_ACROSS: f64 = 0.021;
/// Largest relative L2 error of one sample of a picture that the rule leaves, measured on the built-in surfaces and scenes. Samples average it.
pub const ERROR_OF_ONE_SAMPLE: f64 = 5e-2;

/// Variances of the level read and of the next coarser one, without coherence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Variance of the level read.
    pub read: f64,
    /// Variance of the next coarser level; `None` for the coarsest.
    pub next: Option<f64>,
    /// Variance of coherence, which blurs all levels.
    pub blur: f64,
}

/// Tap of a footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// Displacement from the middle of the footprint.
    pub place: DVec2,
    /// Share of the average; those of all taps add up to 1.
    pub weight: f64,
    /// True if the tap reads the next coarser level.
    pub coarser: bool,
}

/// Rows of taps whose weighted sum stands for the average over a footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    axis: DVec2,
    rows: [Row; MOST_ROWS],
    count: usize,
}

/// Row of taps along the longer axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Row {
    line: Line,
    /// Distance of the row from the middle of the footprint.
    aside: f64,
    /// Share of the row in the average.
    weight: f64,
    /// True if the row reads the next coarser level.
    coarser: bool,
}

/// Places on a line with Gaussian weights, symmetric about the middle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Line {
    /// Number of places.
    count: usize,
    /// Distance between places.
    step: f64,
    /// Weight of the place n steps from the middle: exp(−fall n²)/norm.
    fall: f64,
    /// Sum of all exp(−fall n²).
    norm: f64,
}

impl Line {
    /// Spreads places over the standard deviation `deviation`, where each averages over the standard deviation `tap`.
    ///
    /// The variance of the places is exactly that of the line.
    fn new(deviation: f64, tap: f64) -> Self {
        if deviation <= ROUND * tap {
            return Self { count: 1, norm: 1.0, ..Self::default() };
        }
        // One more than the spacing asks for: three taps where it asks for three err by 0.07, four by 0.01.
        let reach = (LONG_REACH - OVERHANG * tap / deviation).clamp(REACH, LONG_REACH);
        let count =
            (2.0 * reach * deviation / (KEPT * SPACING * tap) + 1.0).ceil().clamp(2.0, MOST_OF_ROW as f64);
        let fall = 0.5 * (2.0 * reach / count).powi(2);
        let line = Self { count: count as usize, step: 1.0, fall, norm: 1.0 };
        let norm: f64 = line.each().map(|(_, weight)| weight).sum();
        let moment: f64 = line.each().map(|(n, weight)| weight * n * n).sum();
        Self { step: deviation * (norm / moment).sqrt(), norm, ..line }
    }

    /// Returns places and weights.
    fn each(self) -> impl Iterator<Item = (f64, f64)> {
        let places = (0..self.count).map(move |k| k as f64 - 0.5 * (self.count as f64 - 1.0));
        places.map(move |n| (n * self.step, (-self.fall * n * n).exp() / self.norm))
    }
}

/// Returns the least variance that a tap has to average over along `footprint`, so that [`MOST_OF_ROW`] taps suffice.
pub fn least_own(footprint: &Covariance, blur: f64) -> f64 {
    let [longer, _] = footprint.axes();
    (longer * (2.0 * LONG_REACH / (KEPT * SPACING * MOST_OF_ROW as f64)).powi(2) - blur).max(0.0)
}

impl Taps {
    /// Places the taps of `footprint`, of which the variance `across` ≥ that of the level read is left to the shorter axis.
    pub fn new(footprint: &Covariance, across: f64, levels: Levels) -> Self {
        let [longer, _] = footprint.axes();
        let rest = (across - levels.read).max(0.0);
        let (rows, count) = match levels.next.filter(|next| *next > levels.read) {
            Some(next) => Self::between(longer, rest, next, levels),
            None => Self::beyond(longer, rest, levels),
        };
        Self { axis: footprint.longer_axis(), rows, count }
    }

    /// Makes a row of each of two levels, which together have the variance of the longer axis.
    fn between(longer: f64, rest: f64, next: f64, levels: Levels) -> ([Row; MOST_ROWS], usize) {
        let Levels { read, blur, .. } = levels;
        let share = share_between([read + blur, read + rest + blur, next + blur]);
        let along = (longer - share * longer.max(next)) / (1.0 - share).max(1e-3) - read;
        let finer = Row { line: line(along, read + blur), weight: 1.0 - share, ..Row::default() };
        let coarser =
            Row { line: line(longer - next, next + blur), weight: share, coarser: true, aside: 0.0 };
        ([finer, coarser], if share > 0.0 { 2 } else { 1 })
    }

    /// Makes one row of the coarsest level, or two side by side.
    fn beyond(longer: f64, rest: f64, levels: Levels) -> ([Row; MOST_ROWS], usize) {
        let tap = levels.read + levels.blur;
        let line = line(longer - levels.read, tap);
        if rest <= ROUND * ROUND * tap {
            return ([Row { line, weight: 1.0, ..Row::default() }; MOST_ROWS], 1);
        }
        ([-1.0, 1.0].map(|side| Row { line, aside: side * rest.sqrt(), weight: 0.5, coarser: false }), 2)
    }

    /// Returns the taps.
    pub fn each(&self) -> impl Iterator<Item = Tap> {
        let axis = self.axis;
        self.rows.into_iter().take(self.count).flat_map(move |row| {
            row.line.each().map(move |(along, weight)| Tap {
                place: axis * along + axis.perp() * row.aside,
                weight: row.weight * weight,
                coarser: row.coarser,
            })
        })
    }

    /// Returns the number of taps.
    pub fn count(&self) -> usize {
        self.rows.iter().take(self.count).map(|row| row.line.count).sum()
    }
}

/// Returns the share of the coarser of two levels, of the first and the last of these `variances`, for which both are together as high in the middle as a Gaussian of
/// the variance between. It is within 0.02 of the share of least squares, across long footprints and for round ones, and errs by half as much
/// as the share that keeps the variance, which between levels of twice the variance is up to 8 % smaller.
fn share_between(variances: [f64; 3]) -> f64 {
    let [finer, asked, coarser] = variances.map(|variance| variance.sqrt().recip());
    ((finer - asked) / (finer - coarser)).min(1.0)
}

/// Makes a line of the variance `left` of taps that average over the variance `tap`.
fn line(left: f64, tap: f64) -> Line {
    Line::new(left.max(0.0).sqrt(), tap.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, SQRT_2};

    /// Relative L2 error of weighted Gaussians, each a weight, a variance and a place, against the Gaussian of `variance`.
    fn error(parts: &[(f64, f64, f64)], variance: f64) -> f64 {
        // Integral of the product of two Gaussians whose variances add up to `sum`, `d` apart.
        let product = |sum: f64, d: f64| (-d * d / (2.0 * sum)).exp() / (2.0 * PI * sum).sqrt();
        let pairs = parts.iter().flat_map(|p| parts.iter().map(move |q| (p, q)));
        let square: f64 = pairs.map(|(p, q)| p.0 * q.0 * product(p.1 + q.1, p.2 - q.2)).sum();
        let mixed: f64 = parts.iter().map(|p| p.0 * product(p.1 + variance, p.2)).sum();
        let exact = product(2.0 * variance, 0.0);
        ((square - 2.0 * mixed + exact).max(0.0) / exact).sqrt()
    }

    /// Largest error along rows of all lengths, whose taps are placed for a standard deviation of `placed_for` and average over 1.
    fn worst_along(placed_for: f64) -> f64 {
        let lengths = (0..60).map(|i| 0.25 * 1.08f64.powi(i));
        let of = |length: f64| {
            let line = Line::new(length, placed_for);
            let parts: Vec<_> = line.each().map(|(place, weight)| (weight, 1.0, place)).collect();
            error(&parts, 1.0 + length * length)
        };
        lengths.map(of).fold(0.0, f64::max)
    }

    /// Largest error across a long footprint between two levels, which coherence blurs by `blur` times the finer level's variance.
    fn worst_across(blur: f64) -> f64 {
        let of = |i: i32| {
            let variance = 1.0 + f64::from(i) / 60.0;
            let levels = Levels { read: 1.0, next: Some(2.0), blur };
            let footprint = Covariance { uu: 1e4, uv: 0.0, vv: variance };
            let taps = Taps::new(&footprint, variance, levels);
            let parts: Vec<_> = taps.rows[..taps.count]
                .iter()
                .map(|row| (row.weight, if row.coarser { 2.0 } else { 1.0 } + blur, row.aside))
                .collect();
            error(&parts, variance + blur)
        };
        (1..60).map(of).fold(0.0, f64::max)
    }

    #[test]
    fn a_single_order_errs_by_what_the_constants_say() {
        assert!((worst_along(1.0) / ERROR_ALONG - 1.0).abs() < 0.05, "{}", worst_along(1.0));
        assert!((worst_across(0.0) / ERROR_ACROSS - 1.0).abs() < 0.05, "{}", worst_across(0.0));
        assert!(worst_across(1.0) < 0.5 * ERROR_ACROSS);
        // Taps a fifth farther apart.
        assert!(worst_along(1.2) > 1.3 * ERROR_ALONG, "{}", worst_along(1.2));
    }

    #[test]
    fn an_even_row_ripples_as_the_sum_formula_says() {
        // Poisson's sum formula: 1 + 2 exp(−2π²/spacing²) cos(2πx/spacing) and smaller terms.
        let ripple = |spacing: f64| SQRT_2 * (-2.0 * (PI / spacing).powi(2)).exp();
        for spacing in [SPACING, 2.5, 3.0] {
            let at =
                |x: f64| (-40..=40).map(|k| (-0.5 * (x - spacing * f64::from(k)).powi(2)).exp()).sum::<f64>();
            let mean = (2.0 * PI).sqrt() / spacing;
            let places = (0..64).map(|i| spacing * f64::from(i) / 64.0);
            let square = places.map(|x| (at(x) / mean - 1.0).powi(2)).sum::<f64>() / 64.0;
            assert!((square.sqrt() / ripple(spacing) - 1.0).abs() < 1e-3, "{spacing}");
        }
        assert!(ripple(SPACING) < 0.025 && ripple(1.3 * SPACING) > 0.1);
    }

    #[test]
    fn places_of_a_line_stand_within_the_spacing_and_have_its_variance() {
        for length in [0.21, 0.5, 1.0, 3.0, 10.0, 39.0] {
            let line = Line::new(length, 1.0);
            let moment = |power| line.each().map(|(place, weight)| weight * place.powi(power)).sum::<f64>();
            assert!((moment(0) - 1.0).abs() < 1e-12 && moment(1).abs() < 1e-12 * length);
            assert!((moment(2) / (length * length) - 1.0).abs() < 1e-12, "{length}");
            assert!(line.step < 1.02 * SPACING && line.count < MOST_OF_ROW, "{length}: {line:?}");
        }
        let density = (-0.5 * REACH * REACH).exp() / (2.0 * PI).sqrt();
        let steps = (0..100_000).map(|i| REACH * (f64::from(i) + 0.5) / 1e5);
        let within: f64 = steps.map(|x| 2.0 * (-0.5 * x * x).exp() / (2.0 * PI).sqrt() * REACH / 1e5).sum();
        let kept = 1.0 - 2.0 * REACH * density / within;
        assert!((kept.sqrt() / KEPT - 1.0).abs() < 1e-3, "{}", kept.sqrt());
    }

    #[test]
    fn taps_and_levels_have_the_mean_and_the_covariance_of_the_footprint() {
        let long = Covariance { uu: 4e-4, uv: 3e-4, vv: 3e-4 };
        let round = Covariance { uu: 1e-4, uv: 0.0, vv: 1e-4 };
        for (footprint, part, blur) in
            [(long, 0.6, 0.0), (long, 0.5, 0.0), (long, 0.9, 1e-5), (round, 0.6, 0.0), (round, 0.5, 1e-5)]
        {
            let ([longer, shorter], axis) = (footprint.axes(), footprint.longer_axis());
            let read = part * shorter;
            for next in [None, Some(2.0 * read)] {
                let taps = Taps::new(&footprint, shorter, Levels { read, next, blur });
                assert_eq!(taps.count(), taps.each().count());
                let (mut mean, mut along, mut across, mut norm) = (DVec2::ZERO, 0.0, 0.0, 0.0);
                for Tap { place, weight, coarser } in taps.each() {
                    let tap = if coarser { 2.0 * read } else { read };
                    mean += place * weight;
                    along += weight * (place.dot(axis).powi(2) + tap);
                    across += weight * (place.dot(axis.perp()).powi(2) + tap);
                    norm += weight;
                }
                assert!((norm - 1.0).abs() < 1e-12 && mean.length() < 1e-12);
                // A mixture of two levels has longer tails.
                let tails = if next.is_some() { 0.09 } else { 1e-9 };
                let is_round = longer < shorter * 1.1;
                // A single tap leaves the variance of ROUND out.
                let left_out = ROUND * ROUND * (2.0 * read + blur);
                assert!(
                    along <= longer * (1.0 + if is_round { tails } else { 1e-9 })
                        && along >= longer - left_out,
                    "{footprint:?} {part} {next:?}"
                );
                assert!(
                    across <= shorter * (1.0 + tails) && across >= shorter - left_out,
                    "{footprint:?} {part} {next:?}"
                );
            }
        }
    }

    #[test]
    fn a_round_footprint_is_one_tap_and_a_very_long_one_is_read_coarser() {
        let at = |read| Levels { read, next: None, blur: 0.0 };
        let round = Covariance { uu: 1e-4, uv: 0.0, vv: 1e-4 };
        assert_eq!(Taps::new(&round, 1e-4, at(1e-4)).count(), 1);
        let very_long = Covariance { uu: 1.0, uv: 0.0, vv: 1e-8 };
        let least = least_own(&very_long, 0.0);
        assert!(least > 1e-8 && least_own(&round, 0.0) < 1e-6);
        let taps = Taps::new(&very_long, least, at(least));
        assert!(taps.count() <= MOST_OF_ROW);
        let variance: f64 = taps.each().map(|tap| tap.weight * tap.place.x.powi(2)).sum();
        assert!((variance + least - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_shader_has_the_same_constants() {
        let shader = include_str!("../../shaders/footprint.glsl");
        for (name, value) in [
            ("SPACING", SPACING),
            ("REACH", REACH),
            ("LONG_REACH", LONG_REACH),
            ("OVERHANG", OVERHANG),
            ("KEPT", KEPT),
            ("MOST_OF_ROW", MOST_OF_ROW as f64),
            ("ROUND", ROUND),
        ] {
            let (_, rest) = shader.split_once(&format!("const float {name} = ")).unwrap();
            let found: f64 = rest.split(';').next().unwrap().parse().unwrap();
            assert_eq!(found, value, "{name}");
        }
    }
}
