//! Bands of the power spectrum: periods that vary over a field, as those of natural ridges do, and spread over many frequencies.
//!
//! A single frequency of such a spectrum is as strong as it is by chance. The middle of the band is not: it hardly changes with levelling,
//! cropping or the window.

use super::height_spectrum::SurfaceSpectrum;
use std::f64::consts::PI;

/// Standard deviation of the Gaussian whose weighted mean is the middle of a band, relative to |f|: about the variation of natural ridges.
const WIDTH: f64 = 0.15;
/// Standard deviations beyond which that Gaussian is 0.
const REACH: f64 = 3.0;
/// Change of the middle, relative to |f|, below which it is found.
const SETTLED: f64 = 1e-6;
/// Largest number of steps to the middle.
const MOST_STEPS: usize = 300;

/// A band of the spectrum.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpectralBand {
    /// Its middle \[1/µm\].
    pub frequency: [f64; 2],
    /// Power under the Gaussian around the middle, of one sign of the frequency \[µm²\].
    pub power: f64,
}

impl SpectralBand {
    /// Returns the band whose middle is next to `start`: the fixed point of the mean frequency under a Gaussian weight (mean shift;
    /// Fukunaga and Hostetler 1975). `None` without power there.
    pub fn around(spectrum: &SurfaceSpectrum, start: [f64; 2]) -> Option<Self> {
        let mut band = Self { frequency: start, power: 0.0 };
        for _ in 0..MOST_STEPS {
            let next = band.stepped(spectrum)?;
            let [x, y] = [0, 1].map(|axis| next.frequency[axis] - band.frequency[axis]);
            band = next;
            if x.hypot(y) < SETTLED * band.length() {
                break;
            }
        }
        Some(band)
    }

    /// Returns |f| \[1/µm\].
    pub fn length(&self) -> f64 {
        self.frequency[0].hypot(self.frequency[1])
    }

    /// Returns the largest distance of frequencies that belong to the band from its middle \[1/µm\].
    pub fn reach(&self) -> f64 {
        REACH * WIDTH * self.length()
    }

    /// Returns the number of frequencies under the Gaussian: the sum of its weights.
    pub fn bins(&self, spectrum: &SurfaceSpectrum) -> f64 {
        2.0 * PI * (WIDTH * self.length()).powi(2) * spectrum.patch[0] * spectrum.patch[1]
    }

    /// Returns the band with the mean frequency around this one's.
    fn stepped(&self, spectrum: &SurfaceSpectrum) -> Option<Self> {
        let [x, y] = self.frequency;
        let deviation = WIDTH * self.length();
        let range = |middle: f64, length: f64, samples: usize| {
            let most = (samples / 2) as f64;
            let bin = |f: f64| (f * length).round().clamp(-most, most) as isize;
            bin(middle - REACH * deviation)..=bin(middle + REACH * deviation)
        };
        let [width, height] = spectrum.patch;
        let (mut power, mut sums) = (0.0, [0.0; 2]);
        for i in range(x, width, spectrum.samples[0]) {
            for up in range(y, height, spectrum.samples[1]) {
                let f = [i as f64 / width, up as f64 / height];
                let distance = ((f[0] - x).powi(2) + (f[1] - y).powi(2)) / (deviation * deviation);
                let weight = (-0.5 * distance).exp() * spectrum.value(i, -up).norm_sqr();
                power += weight;
                sums = [sums[0] + weight * f[0], sums[1] + weight * f[1]];
            }
        }
        (power > 0.0).then(|| Self { frequency: sums.map(|sum| sum / power), power })
    }
}

/// Number of directions, over half a turn, of the smoothed spectrum.
const DIRECTIONS: usize = 60;
/// Width of a ring of the smoothed spectrum, in ln |f|.
const RING: f64 = 0.03;
/// Standard deviation of the smoothing, in rings and in directions.
const SMOOTH: f64 = 3.0;
/// Ratio of frequencies within which the power has to fall to both sides of a band.
const SURROUNDINGS: f64 = 1.5;
/// Least ratio of a band's power to the least one within its surroundings, on the side where that is larger.
const PROMINENT: f64 = 3.0;
/// Least excess of that ratio over 1, in standard deviations of the smoothed power of noise.
const CLEAR: f64 = 8.0;
/// Share of the largest frequency above which nothing is taken for a band.
const HIGHEST: f64 = 0.8;

/// Returns the middles of the bands that stand out of the smoothed spectrum among frequencies of at least `fewest_cycles` over the field.
pub(super) fn bands(spectrum: &SurfaceSpectrum, fewest_cycles: f64) -> Vec<SpectralBand> {
    let lowest = fewest_cycles / spectrum.patch[0].max(spectrum.patch[1]);
    let axes = [0, 1].into_iter().filter(|&axis| spectrum.samples[axis] > 1);
    let highest = axes
        .map(|axis| HIGHEST * 0.5 * spectrum.samples[axis] as f64 / spectrum.patch[axis])
        .fold(f64::INFINITY, f64::min);
    if !highest.is_finite() || highest <= lowest {
        return Vec::new();
    }
    // Along the shorter side, the lowest frequency has fewer periods.
    let is_enough = |[x, y]: [f64; 2]| (x * spectrum.patch[0]).hypot(y * spectrum.patch[1]) >= fewest_cycles;
    let smooth = Rings::of(spectrum, [lowest, highest], is_enough).smoothed();
    let starts = smooth.summits().map(|[ring, direction]| smooth.frequency(ring, direction));
    let mut found: Vec<SpectralBand> = Vec::new();
    for band in starts.filter_map(|start| SpectralBand::around(spectrum, start)) {
        let same = |other: &SpectralBand| {
            let [x, y] = [0, 1].map(|axis| other.frequency[axis] - band.frequency[axis]);
            x.hypot(y) < other.reach()
        };
        if is_enough(band.frequency) && !found.iter().any(same) {
            found.push(band);
        }
    }
    found
}

/// Power over |f| and the direction, in cells of equal width in ln |f| and angle.
struct Rings {
    /// Lowest frequency \[1/µm\].
    lowest: f64,
    /// For each ring all directions: the sum of the powers \[µm²\], that of weights, and that of squared weights.
    cells: Vec<[[f64; 3]; DIRECTIONS]>,
}

impl Rings {
    /// Returns the power of the frequencies that `is_enough` allows.
    fn of(
        spectrum: &SurfaceSpectrum,
        [lowest, highest]: [f64; 2],
        is_enough: impl Fn([f64; 2]) -> bool + Sync,
    ) -> Self {
        let count = ((highest / lowest).ln() / RING) as usize + 1;
        let empty = || vec![[[0.0; 3]; DIRECTIONS]; count];
        let part = |cells: &mut Vec<[[f64; 3]; DIRECTIONS]>, i: usize, j: usize, _: f64| {
            let [x, y] = spectrum.frequency(i, j);
            let ring = (x.hypot(y) / lowest).ln() / RING;
            if (0.0..count as f64).contains(&ring) && is_enough([x, y]) {
                let turns = (y.atan2(x) / PI + 0.5).rem_euclid(1.0);
                let direction = (turns * DIRECTIONS as f64) as usize % DIRECTIONS;
                let cell = &mut cells[ring as usize][direction];
                *cell = [cell[0] + spectrum.power(i, j), cell[1] + 1.0, cell[2] + 1.0];
            }
        };
        let add = |mut a: Vec<[[f64; 3]; DIRECTIONS]>, b: Vec<[[f64; 3]; DIRECTIONS]>| {
            for (cell, other) in a.iter_mut().flatten().zip(b.iter().flatten()) {
                *cell = [cell[0] + other[0], cell[1] + other[1], cell[2] + other[2]];
            }
            a
        };
        Self { lowest, cells: spectrum.sum(empty, part, add) }
    }

    /// Returns this smoothed by a Gaussian along both axes.
    fn smoothed(&self) -> Self {
        const HALF: isize = (3.0 * SMOOTH) as isize;
        let weight = |d: isize| (-0.5 * (d as f64 / SMOOTH).powi(2)).exp();
        let count = self.cells.len() as isize;
        let around = |ring: isize, direction: isize| {
            let mut sum = [0.0; 3];
            for (r, d) in (-HALF..=HALF).flat_map(|r| (-HALF..=HALF).map(move |d| (r, d))) {
                if (0..count).contains(&(ring + r)) {
                    let place = (direction + d).rem_euclid(DIRECTIONS as isize) as usize;
                    let cell = self.cells[(ring + r) as usize][place];
                    let w = weight(r) * weight(d);
                    sum = [sum[0] + w * cell[0], sum[1] + w * cell[1], sum[2] + w * w * cell[2]];
                }
            }
            sum
        };
        let ring = |ring: isize| std::array::from_fn(|direction| around(ring, direction as isize));
        Self { lowest: self.lowest, cells: (0..count).map(ring).collect() }
    }

    /// Returns the mean power in a cell \[µm²\]; 0 for one without frequencies.
    fn mean(&self, ring: usize, direction: usize) -> f64 {
        let [power, weight, _] = self.cells[ring][direction];
        if weight > 0.0 { power / weight } else { 0.0 }
    }

    /// Returns the middle of a cell \[1/µm\].
    fn frequency(&self, ring: usize, direction: usize) -> [f64; 2] {
        let f = self.lowest * (RING * (ring as f64 + 0.5)).exp();
        let angle = PI * ((direction as f64 + 0.5) / DIRECTIONS as f64 - 0.5);
        [f * angle.cos(), f * angle.sin()]
    }

    /// Returns the ring and direction of each clear summit, the strongest first.
    fn summits(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let places = (0..self.cells.len()).flat_map(|ring| (0..DIRECTIONS).map(move |d| [ring, d]));
        let mut summits: Vec<[usize; 2]> =
            places.filter(|place| self.is_summit(*place) && self.is_prominent(*place)).collect();
        summits.sort_by(|a, b| self.mean(b[0], b[1]).total_cmp(&self.mean(a[0], a[1])));
        summits.into_iter()
    }

    fn is_summit(&self, [ring, direction]: [usize; 2]) -> bool {
        let here = self.mean(ring, direction);
        let rings = ring.saturating_sub(1)..=(ring + 1).min(self.cells.len() - 1);
        let beside = [DIRECTIONS - 1, 0, 1].map(|d| (direction + d) % DIRECTIONS);
        rings.into_iter().all(|ring| beside.iter().all(|&d| self.mean(ring, d) <= here))
    }

    /// Returns true if the power falls clearly toward lower and higher frequencies.
    fn is_prominent(&self, [ring, direction]: [usize; 2]) -> bool {
        let reach = (SURROUNDINGS.ln() / RING).round() as usize;
        let (below, above) =
            (ring.saturating_sub(reach)..=ring, ring..=(ring + reach).min(self.cells.len() - 1));
        let least = |rings: std::ops::RangeInclusive<usize>| {
            rings.map(|ring| self.mean(ring, direction)).fold(f64::INFINITY, f64::min)
        };
        let [_, weight, squares] = self.cells[ring][direction];
        // Powers of noise are exponentially distributed: the deviation of one is its mean.
        let deviation = squares.sqrt() / weight;
        let ratio = self.mean(ring, direction) / least(below).max(least(above));
        ratio > PROMINENT.max(1.0 + CLEAR * deviation)
    }
}
