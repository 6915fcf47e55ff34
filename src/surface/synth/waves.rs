//! Smooth random functions of a patch.

use crate::random::Random;
use rustfft::num_complex::Complex64;
use std::f64::consts::TAU;

/// A smooth, random, periodic function of the patch: a sum of the waves with few cycles along its sides.
pub(super) struct Waves {
    /// Largest number of cycles along x and y.
    cycles: [usize; 2],
    /// Amplitude and phase of each wave: `[n][m + most]` for n cycles along x and m along y.
    waves: Vec<Vec<Complex64>>,
}

impl Waves {
    /// Returns waves of up to `cycles` along x and y whose sum has a root mean square of 1.
    pub(super) fn new(random: &mut Random, cycles: [i32; 2]) -> Self {
        let mut wave = |n: i32, m: i32| {
            // One of each pair of opposite waves, and no constant.
            if n == 0 && m <= 0 {
                return Complex64::ZERO;
            }
            // Longer waves are higher, as in scans of skins.
            let amplitude = (0.5 + random.share()) / f64::from(n * n + m * m).sqrt();
            Complex64::from_polar(amplitude, TAU * random.share())
        };
        let mut waves: Vec<Vec<Complex64>> =
            (0..=cycles[0]).map(|n| (-cycles[1]..=cycles[1]).map(|m| wave(n, m)).collect()).collect();
        let mean_square: f64 = waves.iter().flatten().map(|wave| 0.5 * wave.norm_sqr()).sum();
        let scale = if mean_square > 0.0 { 1.0 / mean_square.sqrt() } else { 0.0 };
        waves.iter_mut().flatten().for_each(|wave| *wave *= scale);
        Self { cycles: cycles.map(|most| most as usize), waves }
    }

    /// Returns the value at `x`, `y`, shares of the patch: the real part of Σ c e^{2πi(nx + my)}, from powers of two numbers on the circle.
    pub(super) fn at(&self, x: f64, y: f64) -> f64 {
        let (along_x, along_y) = (Complex64::cis(TAU * x), Complex64::cis(TAU * y));
        let lowest = along_y.conj().powu(self.cycles[1] as u32);
        // Horner, from the largest n down.
        let row = |waves: &Vec<Complex64>| {
            waves.iter().rev().fold(Complex64::ZERO, |sum, wave| sum * along_y + wave) * lowest
        };
        self.waves.iter().rev().fold(Complex64::ZERO, |sum, waves| sum * along_x + row(waves)).re
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_are_the_sum_of_their_cosines() {
        let waves = Waves::new(&mut Random::new(3), [3, 2]);
        let (x, y) = (0.37, 0.81);
        let cosine = |n: usize, m: usize, wave: &Complex64| {
            wave.norm() * (TAU * (n as f64 * x + (m as f64 - 2.0) * y) + wave.arg()).cos()
        };
        let each = waves.waves.iter().enumerate();
        let sum: f64 =
            each.flat_map(|(n, row)| row.iter().enumerate().map(move |(m, wave)| cosine(n, m, wave))).sum();
        assert!((waves.at(x, y) - sum).abs() < 1e-13 && sum.abs() > 1e-3, "{sum}");
    }

    #[test]
    fn waves_are_periodic_with_unit_power() {
        let waves = Waves::new(&mut Random::new(7), [3, 2]);
        assert!((waves.at(0.3, 0.1) - waves.at(1.3, -0.9)).abs() < 1e-12);
        let n = 32;
        let points = (0..n * n).map(|i| waves.at((i % n) as f64 / n as f64, (i / n) as f64 / n as f64));
        let mean_square = points.map(|v| v * v).sum::<f64>() / (n * n) as f64;
        assert!((mean_square - 1.0).abs() < 1e-9, "{mean_square}");
    }
}
