//! Whether a height field tiles: whether its edges meet when copies of it stand side by side.
//!
//! The optics repeats the patch without end. Where the left edge does not meet the right one, or the top the bottom, every copy adds
//! a step that the surface does not have, and the step diffracts light along the axes.

use super::HeightField;
use serde::Serialize;

/// The largest ratio of a seam to the steps inside at which the field still tiles. The seam of a periodic field is one of its own
/// steps, so its ratio is at most about 1; the rest is room for noise. The seams of a scan that does not tile have ratios of 2 and more
/// unless neighbouring samples are unrelated, where a seam makes no difference.
pub const LARGEST_RATIO: f64 = 1.25;

/// How the edges of a height field meet. Index 0 is the seam between the right and the left edge (steps along `x`), index 1 the one
/// between the bottom and the top edge (steps along `y`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tiling {
    /// RMS height difference across the seam over the largest RMS difference of two neighbouring columns (rows) inside the
    /// field; 0 where there is no difference across the seam.
    pub ratio: [f64; 2],
    /// RMS height difference across the seam \[µm\].
    #[serde(rename = "seam_um")]
    pub seam: [f64; 2],
    /// Whether the field can stand for an endless surface as it is.
    pub verdict: Verdict,
}

/// What [`Tiling::ratio`] means for pictures.
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
    /// Whether copies join without visible steps along `axis`, 0 for `x` and 1 for `y`.
    pub fn joins(&self, axis: usize) -> bool {
        self.ratio[axis] <= LARGEST_RATIO
    }
}

impl Verdict {
    /// The verdict in words, for `surface info`.
    pub fn words(self) -> &'static str {
        match self {
            Self::Tiles => "yes",
            Self::SeamAlongX => "no: the left and right edges do not meet",
            Self::SeamAlongY => "no: the top and bottom edges do not meet",
            Self::SeamAlongBoth => "no: neither pair of edges meets",
        }
    }
}

/// Compares the steps across the seams of `field` with the steps between neighbouring samples inside it.
///
/// The yardstick is the largest step inside, as RMS over a pair of neighbouring columns or rows, and not the typical one: a sawtooth or a
/// binary grating has rare large steps, and one of them may fall on the seam.
pub fn tiles(field: &HeightField) -> Tiling {
    let along_x = steps_along_x(field);
    let along_y = steps_along_y(field);
    let axes = [along_x, along_y];
    let ratio = axes.map(|steps| steps.ratio());
    let verdict = match ratio.map(|r| r <= LARGEST_RATIO) {
        [true, true] => Verdict::Tiles,
        [false, true] => Verdict::SeamAlongX,
        [true, false] => Verdict::SeamAlongY,
        [false, false] => Verdict::SeamAlongBoth,
    };
    Tiling { ratio, seam: axes.map(|steps| steps.seam), verdict }
}

/// RMS steps along one axis \[µm\].
#[derive(Clone, Copy)]
struct Steps {
    /// Across the seam.
    seam: f64,
    /// The largest between two neighbouring lines inside.
    inside: f64,
}

impl Steps {
    /// Where there is a step across the seam there is one inside, too: lines that all equal their neighbours equal each other.
    fn ratio(&self) -> f64 {
        if self.seam == 0.0 { 0.0 } else { self.seam / self.inside }
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

/// From the sums of squared steps between each line and the next one, the seam's last, each over `count` samples.
fn root_mean_squares(squares: &[f64], count: usize) -> Steps {
    let rms = |square: f64| (square / count as f64).sqrt();
    let (seam, inside) = squares.split_last().map_or((0.0, &[][..]), |(seam, inside)| (*seam, inside));
    Steps { seam: rms(seam), inside: rms(inside.iter().copied().fold(0.0, f64::max)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::surface::synth::{Kind, Spec, generate};
    use std::f64::consts::TAU;

    fn field(columns: usize, rows: usize, h: impl Fn(f64, f64) -> f64) -> HeightField {
        let at = |i: usize| h((i % columns) as f64, (i / columns) as f64);
        HeightField::new(columns, rows, [0.1; 2], (0..columns * rows).map(at).collect()).unwrap()
    }

    #[test]
    fn every_generated_surface_tiles() {
        for kind in Kind::ALL {
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
