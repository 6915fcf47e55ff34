//! Test for periodic height fields: do the edges meet when copies of the field stand side by side?
//!
//! The optics repeats the patch without end. If the left edge does not meet the right one, or the top the bottom, every copy adds a step
//! that the surface does not have, and the step diffracts light along the axes.

use super::HeightField;
use super::si::metres_of_both;
use serde::Serialize;

/// Largest ratio of a seam to the step inside that is nearest to it, for copies that join; the smallest is the inverse. The seam of a
/// periodic field is one of its steps and has a ratio of about 1; the rest is room for noise. The seams of a scan that is not periodic have
/// ratios of 2 and more, unless neighbouring samples are unrelated; then a seam makes no difference.
pub const LARGEST_RATIO: f64 = 1.25;

/// Largest distance of the number of periods over the patch from a whole number, for copies that join: the copies' period errs by this share
/// of a period over the patch.
const WHOLE: f64 = 0.1;

/// A seam below this share of the RMS step inside is too small to be seen beside it.
const NEGLIGIBLE: f64 = 0.05;

/// Steps of the height field across the seams between copies. Index 0 is the seam between the right and the left edge (steps along `x`),
/// index 1 the one between the bottom and the top edge (steps along `y`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tiling {
    /// RMS height difference across the seam over that of the two neighbouring columns (rows) inside whose difference is nearest to it; over
    /// the median difference for a smaller seam. 0 for a seam without a difference.
    pub ratio: [f64; 2],
    /// RMS height difference across the seam \[µm\].
    #[serde(rename = "seam_m", serialize_with = "metres_of_both")]
    pub seam: [f64; 2],
    /// Number of periods over the patch along `x` and `y` of a grating that is in phase all over it: of one that copies break, or else of the
    /// strongest. `None` without such a grating, and where the steps alone were compared.
    pub periods: [Option<f64>; 2],
    /// Seams that are visible in pictures.
    pub verdict: Verdict,
}

/// Axes along which copies of a field do not join.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Copies join without visible steps.
    Tiles,
    /// The left and right edges do not meet.
    SeamAlongX,
    /// The top and bottom edges do not meet.
    SeamAlongY,
    /// Neither pair of edges meets.
    SeamAlongBoth,
}

impl Tiling {
    /// Returns the number of periods along `axis` where copies break a grating, because it is no whole number.
    pub fn broken_periods(&self, axis: usize) -> Option<f64> {
        self.periods[axis].filter(|periods| (periods - periods.round()).abs() > WHOLE)
    }

    /// Returns [`Self::broken_periods`] in words: `12.35 periods along x`, for each axis that has some.
    pub fn broken_in_words(&self) -> Vec<String> {
        let along = |(axis, name): (usize, &str)| {
            self.broken_periods(axis).map(|periods| format!("{periods:.2} periods along {name}"))
        };
        ["x", "y"].into_iter().enumerate().filter_map(along).collect()
    }

    /// Returns true if copies join without visible steps along `axis`, 0 for `x` and 1 for `y`.
    pub fn joins(&self, axis: usize) -> bool {
        match self.verdict {
            Verdict::Tiles => true,
            Verdict::SeamAlongX => axis == 1,
            Verdict::SeamAlongY => axis == 0,
            Verdict::SeamAlongBoth => false,
        }
    }
}

impl Verdict {
    /// Returns the verdict for copies that join along `x` and `y` or not.
    pub(super) fn of(joins: [bool; 2]) -> Self {
        match joins {
            [true, true] => Self::Tiles,
            [false, true] => Self::SeamAlongX,
            [true, false] => Self::SeamAlongY,
            [false, false] => Self::SeamAlongBoth,
        }
    }

    /// Returns the verdict in words, for `surface info`.
    pub fn words(self) -> &'static str {
        match self {
            Self::Tiles => "yes",
            Self::SeamAlongX => "no: the left and right edges do not meet",
            Self::SeamAlongY => "no: the top and bottom edges do not meet",
            Self::SeamAlongBoth => "no: neither pair of edges meets",
        }
    }
}

/// Compares the steps across the seams of `field` with the steps between neighbouring samples inside it, each as RMS over a pair of
/// neighbouring columns or rows.
///
/// A seam no larger than the median step joins, and so does a larger one that is as large as some step inside: a sawtooth has few large
/// steps, all of one size, and one of them may fall on the seam.
pub fn tiles(field: &HeightField) -> Tiling {
    let axes = [steps_along_x(field), steps_along_y(field)];
    let [x, y] = [0, 1].map(|axis| axes[axis].ratio());
    let verdict = Verdict::of([x.1, y.1]);
    Tiling { ratio: [x.0, y.0], seam: [axes[0].seam, axes[1].seam], periods: [None; 2], verdict }
}

/// RMS steps between neighbouring lines along one axis \[µm\].
struct Steps {
    /// Step across the seam.
    seam: f64,
    /// Steps between neighbouring lines inside, smallest first.
    inside: Vec<f64>,
}

impl Steps {
    /// Returns the ratio of the seam to the step that it is compared with, and true if the seam joins.
    fn ratio(&self) -> (f64, bool) {
        if self.seam == 0.0 || self.inside.is_empty() {
            return (0.0, true);
        }
        let median = self.inside[self.inside.len() / 2];
        let squares: f64 = self.inside.iter().map(|step| step * step).sum();
        let small = median.max(NEGLIGIBLE * (squares / self.inside.len() as f64).sqrt());
        if self.seam <= small {
            return (self.seam / small, true);
        }
        // The nearest in proportion: the next larger or the next smaller one.
        let place = self.inside.partition_point(|step| *step < self.seam);
        let larger = self.inside.get(place).map(|step| self.seam / step);
        let smaller = place.checked_sub(1).map(|place| self.seam / self.inside[place]);
        let off = |ratio: f64| ratio.ln().abs();
        let nearest = [larger, smaller].into_iter().flatten().min_by(|a, b| off(*a).total_cmp(&off(*b)));
        nearest.map_or((0.0, true), |ratio| (ratio, off(ratio) <= LARGEST_RATIO.ln()))
    }
}

fn steps_along_x(field: &HeightField) -> Steps {
    let columns = field.columns();
    let mut squares = vec![0.0; columns];
    for row in 0..field.rows() {
        let heights = field.row(row);
        for (square, pair) in squares.iter_mut().zip(heights.windows(2)) {
            *square += (pair[1] - pair[0]).powi(2);
        }
        squares[columns - 1] += (heights[0] - heights[columns - 1]).powi(2);
    }
    root_mean_squares(&squares, field.rows())
}

fn steps_along_y(field: &HeightField) -> Steps {
    let rows = field.rows();
    let square = |row: usize| {
        let pairs = field.row(row).iter().zip(field.row((row + 1) % rows));
        pairs.map(|(a, b)| (b - a).powi(2)).sum::<f64>()
    };
    root_mean_squares(&(0..rows).map(square).collect::<Vec<_>>(), field.columns())
}

/// Returns the RMS steps from `squares`, the sums of squared steps between each line and the next one, the seam's last. Each sum is over
/// `count` samples.
fn root_mean_squares(squares: &[f64], count: usize) -> Steps {
    let mut steps: Vec<f64> = squares.iter().map(|square| (square / count as f64).sqrt()).collect();
    let seam = steps.pop().unwrap_or_default();
    steps.sort_unstable_by(f64::total_cmp);
    Steps { seam, inside: steps }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::surface::synth::{Spec, SurfaceKind, generate};
    use std::f64::consts::TAU;

    fn field(columns: usize, rows: usize, h: impl Fn(f64, f64) -> f64) -> HeightField {
        let at = |i: usize| h((i % columns) as f64, (i / columns) as f64);
        HeightField::new(columns, rows, [0.1; 2], (0..columns * rows).map(at).collect()).unwrap()
    }

    #[test]
    fn every_generated_surface_tiles() {
        for kind in SurfaceKind::ALL {
            let patch = Some([20.0; 2]);
            let tiling = tiles(&generate(&Spec { patch, seed: 3, ..Spec::new(kind) }).unwrap());
            assert_eq!(tiling.verdict, Verdict::Tiles, "{kind:?}: {tiling:?}");
        }
    }

    #[test]
    fn a_ramp_of_n_samples_has_a_seam_of_n_minus_one_steps() {
        let ramp = tiles(&field(33, 20, |x, _| 0.3 * x));
        assert!((ramp.ratio[0] - 32.0).abs() < 1e-9 && ramp.ratio[1] == 0.0, "{ramp:?}");
        assert!((ramp.seam[0] - 9.6).abs() < 1e-12);
        assert_eq!(ramp.verdict, Verdict::SeamAlongX);
        assert!(!ramp.joins(0) && ramp.joins(1));
        let upward = tiles(&field(20, 33, |_, y| 0.3 * y));
        assert_eq!((upward.ratio[0], upward.verdict), (0.0, Verdict::SeamAlongY));
    }

    #[test]
    fn a_sinusoid_tiles_where_the_patch_is_whole_periods_and_only_there() {
        let periods = |n: f64| {
            tiles(&field(100, 100, |x, y| (TAU * n * x / 100.0).sin() + (TAU * n * y / 100.0).cos()))
        };
        assert_eq!(periods(3.0).verdict, Verdict::Tiles);
        assert_eq!(
            periods(3.5).verdict,
            Verdict::SeamAlongY,
            "the sine meets itself at half a period, the cosine does not"
        );
        assert_eq!(periods(3.25).verdict, Verdict::SeamAlongBoth);
    }

    #[test]
    fn a_sawtooth_tiles_after_whole_periods_only_though_no_seam_is_larger_than_its_walls() {
        let teeth = |columns| tiles(&field(columns, 20, |x, _| 0.01 * (x % 25.0))).verdict;
        assert_eq!(
            [teeth(100), teeth(110), teeth(113)],
            [Verdict::Tiles, Verdict::SeamAlongX, Verdict::SeamAlongX]
        );
    }

    #[test]
    fn a_tilt_of_a_few_steps_breaks_the_seams_of_a_random_surface() {
        let mut random = Random::new(5);
        let noise: Vec<f64> = (0..64 * 64).map(|_| random.signed()).collect();
        let with_tilt =
            |tilt: f64| tiles(&field(64, 64, |x, y| noise[(y * 64.0 + x) as usize] + tilt * x)).verdict;
        assert_eq!(with_tilt(0.0), Verdict::Tiles, "neighbours are unrelated: a seam is a step as any other");
        assert_eq!(with_tilt(0.1), Verdict::SeamAlongX);
    }

    #[test]
    fn single_samples_and_lines_and_flat_fields_tile_along_what_they_lack() {
        for (columns, rows) in [(1, 1), (1, 9), (9, 1)] {
            let flat = tiles(&field(columns, rows, |_, _| 0.7));
            assert_eq!((flat.ratio, flat.verdict), ([0.0; 2], Verdict::Tiles));
        }
        assert_eq!(tiles(&field(1, 9, |_, y| y)).verdict, Verdict::SeamAlongY);
        assert!(
            serde_json::to_string(&tiles(&field(2, 2, |x, _| x))).unwrap().contains("\"verdict\":\"tiles\"")
        );
    }
}
