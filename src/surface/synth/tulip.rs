//! Petals of the tulip 'Queen of the Night': long, irregular striations of the cuticle.
//!
//! The striations are a random wave: a sum of plane waves whose frequencies lie on a piece of a ring around the mean frequency, near the x
//! axis, so that the striations run along y, bend, fork and end as folds of a cuticle do. The sum alone would vanish in places and tower in
//! others; division by a part of its envelope leaves folds of more equal height.
//!
//! Published: the spacing of 1.2 µm ± 0.3 µm [Whitney et al. 2009, "Floral iridescence, produced by diffractive optics, acts as a cue for
//! animal pollinators", Science 323, 130–133]. Chosen: the height, the straightness of the striations, and their round profile. The arched
//! cells below the cuticle are left out.

use super::grid::{SampleGrid, to_full_height};
use crate::error::Result;
use crate::random::Random;
use crate::surface::HeightField;
use rustfft::num_complex::Complex64;
use std::f64::consts::TAU;

/// Mean distance of neighbouring striations \[µm\].
pub(super) const DISTANCE: f64 = 1.2;
/// From the deepest groove to the highest fold \[µm\].
pub(super) const HEIGHT: f64 = 0.5;

/// Standard deviations of the power over the ring: of the frequency, as a share of the mean one, and of the direction
/// \[rad\], 4°. The first makes neighbouring striations differ in distance by about as much as on petals.
const SPREAD: f64 = 0.2;
const FANNING: f64 = 0.07;
/// Standard deviations beyond which the ring is cut off.
const REACH: f64 = 3.0;
/// The mean square of the envelope that counts as full: the larger it is, the more the heights of folds differ.
const FULL: f64 = 1.0;

/// Returns striations on `grid`, at its mean distance along `x`, scaled to the full height \[µm\].
pub(super) fn make(grid: &SampleGrid, height: f64, seed: u64) -> Result<HeightField> {
    let wave = RandomWave::new(grid, seed);
    let raw = grid.sample_lines(|y, line| {
        let amplitudes = wave.amplitudes(y);
        let n = line.len() as f64;
        for (column, height) in line.iter_mut().enumerate() {
            let value = wave.value(&amplitudes, (column as f64 + 0.5) / n);
            *height = value.re / (FULL + value.norm_sqr()).sqrt();
        }
    })?;
    to_full_height(&raw, height)
}

/// A complex random wave of the patch, Σ c e^{2πi(nx + my)} with n > 0: its real part is the sum of plane waves, its
/// magnitude their envelope. The mean square of the magnitude is 1.
struct RandomWave {
    /// The least n and the most m.
    first: i64,
    most: i64,
    /// `[n − first][m + most]`.
    coefficients: Vec<Vec<Complex64>>,
}

impl RandomWave {
    fn new(grid: &SampleGrid, seed: u64) -> Self {
        let patch = grid.patch();
        let mean = grid.periods[0] as f64 / patch[0];
        let first = ((mean * (1.0 - REACH * SPREAD) * patch[0]).ceil() as i64).max(1);
        let last = (mean * (1.0 + REACH * SPREAD) * patch[0]) as i64;
        let most = (mean * REACH * FANNING * patch[1]) as i64;
        let mut random = Random::new(seed);
        let mut coefficient = |n: i64, m: i64| {
            let frequency = [n as f64 / patch[0], m as f64 / patch[1]];
            let ratio = frequency[0].hypot(frequency[1]) / mean;
            let off = (ratio - 1.0) / SPREAD;
            let turn = frequency[1].atan2(frequency[0]) / FANNING;
            // The square root of a power that is normally distributed over frequencies and directions; of the waves of a
            // patch, more have a high frequency than a low one, in proportion.
            let amplitude = (-0.25 * (off * off + turn * turn)).exp() / ratio.sqrt();
            Complex64::from_polar(amplitude, TAU * random.share())
        };
        let mut coefficients: Vec<Vec<Complex64>> =
            (first..=last.max(first)).map(|n| (-most..=most).map(|m| coefficient(n, m)).collect()).collect();
        let power: f64 = coefficients.iter().flatten().map(Complex64::norm_sqr).sum();
        coefficients.iter_mut().flatten().for_each(|c| *c /= power.sqrt());
        Self { first, most, coefficients }
    }

    /// Returns the amplitudes of e^{2πinx} on the line at `y`, a share of the patch.
    fn amplitudes(&self, y: f64) -> Vec<Complex64> {
        let step = Complex64::cis(TAU * y);
        let lowest = Complex64::cis(-TAU * self.most as f64 * y);
        self.coefficients.iter().map(|row| horner(row, step) * lowest).collect()
    }

    /// Returns the wave at `x`, a share of the patch, on the line with the `amplitudes`.
    fn value(&self, amplitudes: &[Complex64], x: f64) -> Complex64 {
        horner(amplitudes, Complex64::cis(TAU * x)) * Complex64::cis(TAU * self.first as f64 * x)
    }
}

/// Returns Σ c_j z^j.
fn horner(coefficients: &[Complex64], z: Complex64) -> Complex64 {
    coefficients.iter().rev().fold(Complex64::ZERO, |sum, c| sum * z + c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::synth::{Spec, SurfaceKind, generate};

    /// Returns the distances of neighbouring crests on the lines along `x` \[µm\].
    fn distances(field: &HeightField) -> Vec<f64> {
        let middle = crate::surface::statistics::mean(field);
        let mut distances = Vec::new();
        for row in 0..field.rows() {
            let line = field.row(row);
            let rises = |pair: &[f64]| pair[0] < middle && pair[1] >= middle;
            let places = line.windows(2).enumerate().filter(|(_, pair)| rises(pair));
            let places: Vec<f64> =
                places.map(|(i, pair)| i as f64 + (middle - pair[0]) / (pair[1] - pair[0])).collect();
            distances.extend(places.windows(2).map(|pair| (pair[1] - pair[0]) * field.pixel_size()[0]));
        }
        distances
    }

    #[test]
    fn striations_are_as_far_apart_as_on_the_petal() {
        for seed in [0, 7] {
            let distances = distances(&generate(&Spec { seed, ..Spec::new(SurfaceKind::Tulip) }).unwrap());
            let count = distances.len() as f64;
            let mean = distances.iter().sum::<f64>() / count;
            let deviation = (distances.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / count).sqrt();
            assert!((mean - 1.2).abs() < 0.1, "{mean} um");
            assert!((deviation - 0.3).abs() < 0.1, "{deviation} um");
        }
    }

    #[test]
    fn a_wave_is_the_sum_of_its_parts() {
        let spec = Spec { patch: Some([10.0, 30.0]), ..Spec::new(SurfaceKind::Tulip) };
        let grid = SampleGrid::new(&spec, &SurfaceKind::Tulip.dimensions()).unwrap();
        let wave = RandomWave::new(&grid, 3);
        let (x, y) = (0.37, 0.81);
        let mut sum = Complex64::ZERO;
        for (n, row) in (wave.first..).zip(&wave.coefficients) {
            for (m, c) in (-wave.most..).zip(row) {
                sum += c * Complex64::cis(TAU * (n as f64 * x + m as f64 * y));
            }
        }
        let value = wave.value(&wave.amplitudes(y), x);
        assert!((value - sum).norm() < 1e-12 && sum.norm() > 1e-3, "{value} and not {sum}");
    }
}
