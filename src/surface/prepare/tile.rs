//! Making the edges of a field meet: by mirror images, or by blending one edge into the other.

use super::words::{about, length};
use crate::error::{Error, Remedy, Result};
use crate::surface::{HeightField, MAX_SIDE, statistics};
use crate::units;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::fmt;

/// Method that makes the edges of a field meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tile {
    /// The field, its mirror image beside it, and both upside down below: four times the samples, every height as it is. Grooves that are
    /// not parallel to an axis get a second direction.
    Mirror,
    /// The last part of each row and column fades into the first: fewer samples, one direction. The width \[µm\]; `None`: an
    /// eighth of each side.
    Blend(Option<f64>),
}

impl Tile {
    /// Parses `mirror`, `blend` or `blend:LENGTH`.
    pub(super) fn parse(text: &str) -> Result<Self> {
        match text.split_once(':') {
            None if text == "mirror" => Ok(Self::Mirror),
            None if text == "blend" => Ok(Self::Blend(None)),
            Some(("blend", width)) => units::length(width).map(Some).map(Self::Blend),
            _ => Err(Error::usage(
                format!("there is no way to tile `{text}`"),
                "give mirror, blend, or blend:LENGTH as in blend:5um",
            )),
        }
    }

    /// Returns a field whose edges meet.
    pub(super) fn apply(self, field: &HeightField) -> Result<HeightField> {
        match self {
            Self::Mirror => mirrored(field),
            Self::Blend(width) => blended(field, width),
        }
    }
}

impl fmt::Display for Tile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mirror => f.write_str("mirror"),
            Self::Blend(None) => f.write_str("blend"),
            Self::Blend(Some(width)) => write!(f, "blend:{}", length(*width)),
        }
    }
}

fn mirrored(field: &HeightField) -> Result<HeightField> {
    let (columns, rows) = (field.columns(), field.rows());
    if 2 * columns.max(rows) > MAX_SIDE {
        return Err(Error::limit(
            format!("the mirrored field has more than {MAX_SIDE} samples on a side"),
            [Remedy::BlendTile, Remedy::Words("crop the field before".into())],
        ));
    }
    crate::memory::ensure_room(4 * size_of_val(field.heights()) as u64, "the mirrored field")?;
    let both = |row: usize| field.row(row).iter().chain(field.row(row).iter().rev()).copied();
    let heights = (0..rows).chain((0..rows).rev()).flat_map(both).collect();
    HeightField::new(2 * columns, 2 * rows, field.pixel_size(), heights)
}

fn blended(field: &HeightField, width: Option<f64>) -> Result<HeightField> {
    let [dx, dy] = field.pixel_size();
    let across = overlap(width, field.columns(), dx)?;
    let down = overlap(width, field.rows(), dy)?;
    let mean = statistics::mean(field);
    let columns = field.columns() - across;
    // Along x, each row by itself; all rows share the correlation, or ridges would change their height from row to row.
    let crossfade = Crossfade::new(
        across,
        field.heights().par_chunks(field.columns()).map(|row| moments(&row[..across], &row[columns..], mean)),
    );
    let mut heights = vec![0.0; columns * field.rows()];
    heights.par_chunks_mut(columns).enumerate().for_each(|(row, out)| {
        let row = field.row(row);
        out.copy_from_slice(&row[..columns]);
        for (i, h) in out[..across].iter_mut().enumerate() {
            *h = crossfade.mix(i, row[i], row[columns + i], mean);
        }
    });
    // Along y the same with rows for samples.
    let rows = field.rows() - down;
    let (kept, last) = heights.split_at_mut(rows * columns);
    let line = |i: usize| i * columns..(i + 1) * columns;
    let crossfade = Crossfade::new(
        down,
        (0..down).into_par_iter().map(|i| moments(&kept[line(i)], &last[line(i)], mean)),
    );
    kept.par_chunks_mut(columns).zip(last.par_chunks(columns)).enumerate().for_each(|(i, (first, last))| {
        first.iter_mut().zip(last).for_each(|(a, b)| *a = crossfade.mix(i, *a, *b, mean));
    });
    heights.truncate(rows * columns);
    HeightField::new(columns, rows, field.pixel_size(), heights)
}

/// Returns the number of samples along a side of `n` that fade: over `width` \[µm\], or an eighth of them.
fn overlap(width: Option<f64>, n: usize, spacing: f64) -> Result<usize> {
    let samples = width.map_or(n / 8, |width| (width / spacing).round() as usize);
    if 2 * samples <= n {
        return Ok(samples);
    }
    Err(Error::input(
        format!("the blended part is more than half of {}", about(n as f64 * spacing)),
        "give a shorter one",
    ))
}

/// Returns the sums of the products of the deviations from `mean`: a·a, b·b and a·b.
fn moments(a: &[f64], b: &[f64], mean: f64) -> [f64; 3] {
    let products = a.iter().zip(b).map(|(a, b)| (a - mean, b - mean));
    products.fold([0.0; 3], |s, (a, b)| [s[0] + a * a, s[1] + b * b, s[2] + a * b])
}

/// Weights from one edge's heights to the other's that keep the variance: a plain mean of two parts that have nothing to do with each other
/// would have half of it. For the correlation ρ of the parts the weights w and 1 − w are divided by √(w² + (1 − w)² + 2ρw(1 − w))
/// [Heitz and Neyret 2018, "High-performance by-example noise using a histogram-preserving blending operator", eq. 4, for ρ = 0].
struct Crossfade {
    /// Weights of the first edge's and of the last edge's height.
    weights: Vec<[f64; 2]>,
}

impl Crossfade {
    fn new(samples: usize, moments: impl ParallelIterator<Item = [f64; 3]>) -> Self {
        let [aa, bb, ab] = moments.reduce(|| [0.0; 3], |s, t| [s[0] + t[0], s[1] + t[1], s[2] + t[2]]);
        let norm = (aa * bb).sqrt();
        // Parts that cancel each other cannot be blended well; they are taken as unrelated.
        let correlation = if norm > 0.0 { (ab / norm).clamp(0.0, 1.0) } else { 1.0 };
        let weights = (0..samples).map(|i| {
            let first = (FRAC_PI_2 * (i as f64 + 0.5) / samples as f64).sin().powi(2);
            let last = 1.0 - first;
            let size = (first * first + last * last + 2.0 * correlation * first * last).sqrt();
            [first / size, last / size]
        });
        Self { weights: weights.collect() }
    }

    /// Returns the height `i` samples from the first edge, blended from the height there (`first`) and the one as far behind the cut
    /// (`last`).
    fn mix(&self, i: usize, first: f64, last: f64, mean: f64) -> f64 {
        let [a, b] = self.weights[i];
        mean + a * (first - mean) + b * (last - mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare::tests::field;
    use crate::surface::synth::{Spec, SurfaceKind, generate};
    use crate::surface::tiling::{Verdict, tiles};

    /// Returns a part of a skin whose edges do not meet.
    fn part() -> HeightField {
        let skin =
            generate(&Spec { patch: Some([20.0; 2]), seed: 4, ..Spec::new(SurfaceKind::Elaphe) }).unwrap();
        crate::surface::prepare::PreparationStep::parse("crop 13.3umx12.1um").unwrap().apply(&skin).unwrap()
    }

    #[test]
    fn a_mirrored_field_is_four_images_and_tiles() {
        let quarter = part();
        assert_ne!(tiles(&quarter).verdict, Verdict::Tiles);
        let whole = Tile::Mirror.apply(&quarter).unwrap();
        let (columns, rows) = (quarter.columns(), quarter.rows());
        assert_eq!((whole.columns(), whole.rows()), (2 * columns, 2 * rows));
        for (column, row) in [(0, 0), (5, 7), (columns - 1, rows - 1)] {
            let h = quarter.row(row)[column];
            assert_eq!(whole.row(row)[column], h);
            assert_eq!(whole.row(row)[2 * columns - 1 - column], h);
            assert_eq!(whole.row(2 * rows - 1 - row)[column], h);
        }
        assert_eq!(tiles(&whole).ratio, [0.0; 2], "the edges are the same samples");
    }

    #[test]
    fn a_blended_field_has_no_seam_larger_than_its_own_steps_and_keeps_its_roughness() {
        let part = part();
        let blended = Tile::Blend(None).apply(&part).unwrap();
        assert_eq!(blended.columns(), part.columns() - part.columns() / 8);
        let tiling = tiles(&blended);
        assert_eq!(tiling.verdict, Verdict::Tiles, "{tiling:?}");
        let largest_inside = blended.row(3).windows(2).map(|h| (h[1] - h[0]).abs()).fold(0.0, f64::max);
        assert!(tiling.seam[0] < largest_inside, "{tiling:?}");
        // Outside of the blended part nothing moves.
        let (columns, rows) = (blended.columns(), blended.rows());
        assert_eq!(blended.row(rows - 1)[columns - 1], part.row(rows - 1)[columns - 1]);
        let variance = |f: &HeightField, within: std::ops::Range<usize>| {
            let mean = statistics::mean(&part);
            let part = (0..rows).flat_map(|r| &f.row(r)[within.clone()]).map(|h| (h - mean).powi(2));
            part.sum::<f64>() / (rows * within.len()) as f64
        };
        let strip = 0..part.columns() / 8;
        let ratio = variance(&blended, strip.clone()) / variance(&part, strip);
        assert!((0.75..1.3).contains(&ratio), "a plain mean leaves about a half: {ratio}");
    }

    #[test]
    fn a_field_that_tiles_with_a_period_of_its_overlap_stays_as_it_is() {
        let wave = |x: f64, _: f64| (std::f64::consts::TAU * x).sin();
        let whole = field(80, 80, wave); // 8 periods of 10 samples
        let blended = Tile::Blend(Some(1.0)).apply(&whole).unwrap();
        assert_eq!(blended.columns(), 70);
        for column in 0..70 {
            assert!((blended.row(0)[column] - whole.row(0)[column]).abs() < 1e-12, "{column}");
        }
    }

    #[test]
    fn more_than_half_cannot_be_blended() {
        let e = Tile::Blend(Some(5.0)).apply(&field(80, 80, |x, _| x)).unwrap_err().to_string();
        assert!(e.contains("half of 8um"), "{e}");
    }
}
