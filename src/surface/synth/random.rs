//! A small seeded generator, so that a seed means one surface for ever.

use std::f64::consts::TAU;

/// SplitMix64 [Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators"].
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in 0 … 1, 1 excluded: the 53 bits that a double holds.
    pub(super) fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in −1 … 1.
    pub(super) fn signed(&mut self) -> f64 {
        2.0 * self.share() - 1.0
    }
}

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
    fn the_generator_gives_the_published_numbers() {
        // The first outputs for the seed 1234567 of the reference implementation.
        let mut random = Random::new(1_234_567);
        assert_eq!([random.next(), random.next()], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
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
