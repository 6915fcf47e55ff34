//! Samples of a picture: their positions in the pixel, their weights for the neighbouring pixels, and the
//! low-discrepancy sequence behind all random choices.
//!
//! A pixel shows the mean over a filter of standard deviation ½ pixel; for many samples this filter is the quadratic
//! B-spline. Two steps share it: shading averages over the pixel's footprint (a Gaussian of standard deviation σ_f),
//! and the samples around the pixel's centre have weights of variance σ_r², where σ_f² + σ_r² = ¼ pixel². Variances of
//! successive blurs add.
//!
//! A footprint is exact if (u, v) is linear in the pixel, and ignores edges and curvature; samples are exact but noisy.
//! The share of the footprint therefore decreases with the number of samples, and pictures converge to the result of
//! samples alone. A sample lies anywhere in its pixel and also has weight for the neighbouring pixels, so that each
//! pixel averages more samples than are drawn in it. Of a few samples the footprint has most of the filter, and they lie
//! close to the middle of the pixel.

use super::frame_set::SampleBlock;
use crate::random::Random;

/// Variance of the pixel filter along each axis \[pixel²\], that of the quadratic B-spline.
const FILTER_VARIANCE: f64 = 0.25;
/// Variance of a uniform weight over a pixel \[pixel²\].
const BOX_VARIANCE: f64 = 1.0 / 12.0;
/// K: the footprint of each of N samples, [`MANY_SAMPLES`] or more, has K/(N + K − 1) of the filter's variance.
///
/// A smaller K makes more noise, and a larger one leaves an error of the footprint that no number of samples removes.
/// This value was the best of those measured at 16 and at 64 samples
/// (docs/decisions/0016-samples-count-for-neighbouring-pixels.md).
const SHARED_SAMPLES: f64 = 2.0;
/// Number of samples below which K is larger, [`SHARED_SAMPLES`] ((MANY_SAMPLES − 1)/(N − 1))²: a few samples average their own
/// noise badly, and the footprint of a single one has the whole filter. With the first power the errors of a sphere grow from
/// two to four samples (docs/decisions/0025-pixels-choose-among-directions.md).
const MANY_SAMPLES: f64 = 16.0;
/// Bits of a point of the sequence.
const BITS: u32 = u32::BITS;

/// Number and seed of the samples whose mean is the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Number of samples, at least 1.
    pub count: u32,
    /// Seed of the scrambled sequence.
    pub seed: u64,
}

/// One sample of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Number of the sample, from 0.
    pub index: u32,
    /// Number of samples in the picture.
    pub count: u32,
    /// Seed of the scrambled sequence.
    pub seed: u64,
    /// Position from the pixel's centre: x to the right, y downward, −½ … ½ \[pixels\].
    pub jitter: [f64; 2],
    /// Standard deviation σ_f, as [`Sampling::footprint`].
    pub footprint: f64,
}

impl Sampling {
    /// One sample at the centre of each pixel, whose footprint is the whole filter.
    pub const ONE: Self = Self { count: 1, seed: 0 };

    /// Returns sample number `index` of the picture.
    pub fn sample(&self, index: u32) -> Sample {
        // A single sample does not depend on the seed.
        let seed = if self.count > 1 { self.seed } else { Self::ONE.seed };
        let mut sample =
            Sample { index, count: self.count, seed, jitter: [0.0; 2], footprint: self.footprint() };
        if self.count > 1 {
            let width = (self.rest() / BOX_VARIANCE).sqrt().min(1.0);
            sample.jitter = sample.pair(0).map(|x| width * (x - 0.5));
        }
        sample
    }

    /// Returns the sampling with the largest number of samples, at most [`Self::count`], whose footprints keep at least
    /// half of the filter's variance.
    #[must_use]
    pub fn with_large_footprints(&self) -> Self {
        // Cube of N − 1 where (N − 1)/K is 1.
        const HALF: f64 = SHARED_SAMPLES * (MANY_SAMPLES - 1.0) * (MANY_SAMPLES - 1.0);
        Self { count: self.count.min(HALF.cbrt() as u32 + 1), ..*self }
    }

    /// Returns σ_f: the standard deviation of the part of the pixel filter that shading averages over \[pixels\].
    pub fn footprint(&self) -> f64 {
        (FILTER_VARIANCE - self.rest()).sqrt()
    }

    /// Returns the variance of the filter that the footprint leaves to the positions of the samples \[pixel²\].
    fn rest(&self) -> f64 {
        let others = f64::from(self.count.max(1) - 1);
        let of_k = others / SHARED_SAMPLES * (others / (MANY_SAMPLES - 1.0)).min(1.0).powi(2);
        FILTER_VARIANCE * of_k / (1.0 + of_k)
    }
}

/// Weights of the samples of a pixel and of its eight neighbours for that pixel. A weight is the product of one factor
/// per axis; the three factors of an axis sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelWeights {
    /// Factors of the left neighbour, of the same column, and of the right neighbour.
    pub across: [f64; 3],
    /// Factors of the row above, of the same row, and of the row below.
    pub down: [f64; 3],
}

impl PixelWeights {
    /// Weights of a sample for its pixel alone.
    pub const OWN: Self = Self { across: [0.0, 1.0, 0.0], down: [0.0, 1.0, 0.0] };
}

impl Sample {
    /// Returns coordinate `dimension` of this sample's point, uniform in (0, 1). Dimensions 0 and 1 are the position in
    /// the pixel.
    ///
    /// Dimensions 2d and 2d + 1 together are the first two dimensions of Sobol's sequence, a (0, 2)-sequence in base 2:
    /// each elementary interval of area 2^−k contains one of 2^k consecutive points. The order of the points is
    /// shuffled for each pair of dimensions, and each dimension is scrambled separately (Owen 1995, "Randomly permuted
    /// (t,m,s)-nets"; Burley 2020, "Practical Hash-based Owen Scrambling", for the padding of pairs), so that pairs are
    /// independent of each other.
    pub fn point(&self, dimension: u32) -> f64 {
        let order = hash(&[self.seed, 0, u64::from(dimension / 2)]);
        let index = scrambled(self.index, order); // within aligned blocks of 2^k
        let bits = if dimension.is_multiple_of(2) { index.reverse_bits() } else { second_of_sobol(index) };
        let hashed = hash(&[self.seed, 1, u64::from(dimension)]);
        (f64::from(scrambled(bits, hashed)) + 0.5) / 2f64.powi(BITS as i32)
    }

    /// Returns dimensions 2·`pair` and 2·`pair` + 1 of [`Sample::point`].
    pub fn pair(&self, pair: u32) -> [f64; 2] {
        [self.point(2 * pair), self.point(2 * pair + 1)]
    }

    /// Returns the weights of the sample: a mixture of the quadratic B-spline and of the box over the sample's pixel,
    /// with the variance that the footprint leaves of the filter. Both are partitions of unity, so that all positions
    /// of the picture have equal weight and the weights of a sample sum to 1 (Unser, "Splines: a perfect fit for signal
    /// and image processing", 1999). With a footprint of two thirds of the filter or more, the weights are the box
    /// alone, or a part of it around the middle.
    pub fn weights(&self) -> PixelWeights {
        let left = FILTER_VARIANCE - self.footprint.powi(2);
        let spline = ((left - BOX_VARIANCE) / (FILTER_VARIANCE - BOX_VARIANCE)).max(0.0);
        let along = |jitter: f64| {
            let mut weights = [-1.0, 0.0, 1.0].map(|pixel| spline * quadratic_spline(pixel + jitter));
            weights[1] += 1.0 - spline;
            weights
        };
        PixelWeights { across: along(self.jitter[0]), down: along(self.jitter[1]) }
    }

    /// Returns the sample as shaders read it, with the low bits of the seed.
    pub fn block(&self) -> SampleBlock {
        SampleBlock {
            jitter: self.jitter.map(|x| x as f32),
            footprint: self.footprint as f32,
            index: self.index,
            count: self.count,
            seed: self.seed as u32,
            turn: 0,
            parts: 0,
        }
    }
}

/// Returns the quadratic B-spline at a distance of `x` pixels.
fn quadratic_spline(x: f64) -> f64 {
    let x = x.abs();
    match x {
        _ if x <= 0.5 => 0.75 - x * x,
        _ if x < 1.5 => 0.5 * (1.5 - x).powi(2),
        _ => 0.0,
    }
}

/// Returns the second dimension of Sobol's sequence, as a binary fraction of 32 bits.
fn second_of_sobol(index: u32) -> u32 {
    let mut direction = 1 << (BITS - 1);
    let mut bits = 0;
    for bit in 0..BITS {
        if index >> bit & 1 == 1 {
            bits ^= direction;
        }
        direction ^= direction >> 1;
    }
    bits
}

/// Applies Owen's nested uniform scrambling to a binary fraction of 32 bits: each bit is flipped or not by a random
/// choice that depends on the bits above it.
fn scrambled(bits: u32, seed: u64) -> u32 {
    (0..BITS).fold(0, |result, place| {
        let above = u64::from(bits) >> (BITS - place);
        let flip = hash(&[seed, u64::from(place), above]) as u32 & 1;
        result | ((bits >> (BITS - 1 - place) & 1) ^ flip) << (BITS - 1 - place)
    })
}

/// Hashes a list of numbers to a well-mixed number.
pub(super) fn hash(numbers: &[u64]) -> u64 {
    numbers.iter().fold(0, |state, number| Random::new(state ^ number).bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jitters(sampling: Sampling) -> Vec<[f64; 2]> {
        (0..sampling.count).map(|index| sampling.sample(index).jitter).collect()
    }

    #[test]
    fn of_2_to_the_k_points_each_elementary_interval_holds_one() {
        for (seed, pair, k) in [(0, 0, 4), (1, 0, 6), (7, 3, 5)] {
            let sampling = Sampling { count: 1 << k, seed };
            let points: Vec<_> = (0..1 << k).map(|index| sampling.sample(index).pair(pair)).collect();
            for columns in 0..=k {
                let size = [f64::from(1 << columns), f64::from(1 << (k - columns))];
                let mut cells: Vec<_> =
                    points.iter().map(|p| [(p[0] * size[0]) as u32, (p[1] * size[1]) as u32]).collect();
                cells.sort_unstable();
                cells.dedup();
                assert_eq!(cells.len(), 1 << k, "seed {seed}, pair {pair}, {size:?}");
            }
        }
    }

    #[test]
    fn one_sample_has_the_whole_filter_and_more_have_less_of_it() {
        let shares = [
            (1, 1.0),
            (2, 450.0 / 451.0),
            (8, 450.0 / 793.0),
            (9, 450.0 / 962.0),
            (16, 2.0 / 17.0),
            (4095, 2.0 / 4096.0),
        ];
        for (count, share) in shares {
            let sampling = Sampling { count, seed: 3 };
            let footprint = |sampling: &Sampling| sampling.footprint().powi(2);
            assert!((footprint(&sampling) - 0.25 * share).abs() < 1e-15, "{count}");
            assert_eq!(sampling.sample(count - 1).footprint, sampling.footprint());
            let large = sampling.with_large_footprints();
            assert!((footprint(&large) - 0.25 * share.max(450.0 / 793.0)).abs() < 1e-15, "{count}");
        }
        let only = Sampling::ONE.sample(0);
        assert_eq!((only.jitter, only.weights()), ([0.0; 2], PixelWeights::OWN));
    }

    /// Returns mean and variance along each axis of the sample positions that contribute to a pixel, by weight.
    fn moments(sampling: Sampling) -> [[f64; 2]; 2] {
        let samples: Vec<Sample> = (0..sampling.count).map(|index| sampling.sample(index)).collect();
        [0, 1].map(|axis| {
            let weights = |sample: &Sample| [sample.weights().across, sample.weights().down][axis];
            let places: Vec<(f64, f64)> = samples
                .iter()
                .flat_map(|sample| {
                    [0, 1, 2].map(|k| (f64::from(k) - 1.0 + sample.jitter[axis], weights(sample)[k as usize]))
                })
                .collect();
            let total: f64 = places.iter().map(|(_, weight)| weight).sum();
            assert!((total / f64::from(sampling.count) - 1.0).abs() < 1e-12);
            let mean = places.iter().map(|(place, weight)| place * weight).sum::<f64>() / total;
            [mean, places.iter().map(|(place, weight)| (place - mean).powi(2) * weight).sum::<f64>() / total]
        })
    }

    #[test]
    fn samples_count_by_the_rest_of_the_filter_along_each_axis() {
        for seed in 0..8 {
            // An integral over a scrambled (0, 2)-net converges faster than one over independent points, whose standard
            // deviations are these bounds: √(s²/N) for the mean and s²·√(2/N) for the variance s².
            for count in [4, 16, 64, 256, 4096] {
                let sampling = Sampling { count, seed };
                let rest = 0.25 - sampling.footprint().powi(2);
                let n = f64::from(count);
                for [mean, variance] in moments(sampling) {
                    assert!(mean.abs() < (rest / n).sqrt(), "{seed}, {count}: mean {mean}");
                    let error = (variance - rest).abs();
                    assert!(error < rest * (2.0 / n).sqrt(), "{seed}, {count}: variance {variance}");
                }
            }
        }
    }

    /// Returns the filter of a pixel at the distance `x`: the weights of evenly spread samples as a density over
    /// positions.
    fn filter_at(x: f64, sampling: Sampling) -> f64 {
        // The sample at x lies in the pixel `pixel` away, with this jitter.
        let pixel = x.round();
        let sample = Sample { jitter: [x - pixel, 0.0], ..sampling.sample(0) };
        let place = (pixel + 1.0) as usize;
        let width = (sampling.rest() / BOX_VARIANCE).sqrt().min(1.0);
        let is_there = pixel.abs() <= 1.0 && (x - pixel).abs() <= 0.5 * width;
        if is_there { sample.weights().across[place] / width } else { 0.0 }
    }

    #[test]
    fn the_filters_of_all_pixels_add_up_to_one_everywhere_and_have_the_variance_that_footprints_leave() {
        for count in [2, 4, 8, 12, 16, 64, 1024] {
            let sampling = Sampling { count, seed: 0 };
            const STEPS: usize = 300_000;
            let places = || (0..STEPS).map(|i| 3.0 * (i as f64 + 0.5) / STEPS as f64 - 1.5);
            let is_even = sampling.rest() > BOX_VARIANCE;
            for x in places().filter(|x| is_even && x.abs() < 0.5) {
                let all: f64 = [-1.0, 0.0, 1.0].map(|pixel| filter_at(x - pixel, sampling)).iter().sum();
                assert!((all - 1.0).abs() < 1e-12, "{count} samples at {x}: {all}");
            }
            let variance: f64 =
                places().map(|x| x * x * filter_at(x, sampling)).sum::<f64>() * 3.0 / STEPS as f64;
            let expected = 0.25 - sampling.footprint().powi(2);
            assert!((variance - expected).abs() < 1e-5, "{count}: {variance} instead of {expected}");
        }
        // The Gaussian of the same variance, cut off at the same distance, is no partition of unity.
        let gaussian = |x: f64| (-2.0 * x * x).exp() * (2.0 / std::f64::consts::PI).sqrt();
        let sum = |x: f64| [-1.0, 0.0, 1.0].map(|pixel| gaussian(x - pixel)).iter().sum::<f64>();
        assert!((sum(0.0) - sum(0.5)).abs() > 1e-3);
    }

    #[test]
    fn a_seed_is_one_sequence_and_samples_and_dimensions_differ() {
        let all = |seed| jitters(Sampling { count: 64, seed });
        assert_eq!(all(5), all(5));
        assert_ne!(all(5), all(6));
        let mut points: Vec<_> = (0..8).map(|d| Sampling { count: 4, seed: 1 }.sample(3).point(d)).collect();
        assert!(points.iter().all(|p| (0.0..1.0).contains(p) && *p > 0.0));
        points.sort_by(f64::total_cmp);
        assert!(points.windows(2).all(|p| p[0] < p[1]), "{points:?}");
    }
}
