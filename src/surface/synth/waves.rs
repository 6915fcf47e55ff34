//! Smooth random functions of a patch.

use crate::random::Random;
use std::f64::consts::TAU;

/// A smooth, random, periodic function of the patch: a sum of the waves with few cycles along its sides.
pub(super) struct Waves {
    /// Cycles along x and y, amplitude, phase.
    waves: Vec<([f64; 2], f64, f64)>,
}

impl Waves {
    /// Waves of up to `cycles` along x and y whose sum has a root mean square of 1.
    pub(super) fn new(random: &mut Random, cycles: [i32; 2]) -> Self {
        let mut waves = Vec::new();
        for n in 0..=cycles[0] {
            for m in -cycles[1]..=cycles[1] {
                // One of each pair of opposite waves, and no constant.
                if n > 0 || m > 0 {
                    // Longer waves are higher, as in scans of skins.
                    let amplitude = (0.5 + random.share()) / f64::from(n * n + m * m).sqrt();
                    waves.push(([f64::from(n), f64::from(m)], amplitude, TAU * random.share()));
                }
            }
        }
        let mean_square: f64 = waves.iter().map(|(_, amplitude, _)| 0.5 * amplitude * amplitude).sum();
        let scale = if mean_square > 0.0 { 1.0 / mean_square.sqrt() } else { 0.0 };
        waves.iter_mut().for_each(|(_, amplitude, _)| *amplitude *= scale);
        Self { waves }
    }

    /// The value at `x`, `y`, shares of the patch.
    pub(super) fn at(&self, x: f64, y: f64) -> f64 {
        self.waves
            .iter()
            .map(|([n, m], amplitude, phase)| amplitude * (TAU * (n * x + m * y) + phase).cos())
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
