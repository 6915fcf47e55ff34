//! What is in a height field, as numbers.

use super::{HeightField, level};
use rayon::prelude::*;
use rustfft::{FftPlanner, num_complex::Complex};
use std::f64::consts::TAU;

/// The numbers of `surface info`.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// Samples along `x` and `y`.
    pub samples: [usize; 2],
    /// Sample spacing along `x` and `y` \[µm\].
    pub pixel_size: [f64; 2],
    /// Side lengths of the patch \[µm\].
    pub patch_size: [f64; 2],
    /// Lowest and highest height \[µm\].
    pub range: (f64, f64),
    /// Mean height \[µm\].
    pub mean: f64,
    /// Root mean square deviation from the mean \[µm\].
    pub roughness: f64,
    /// How many different heights occur.
    pub levels: usize,
    /// The largest spatial frequency along `x` and `y` that the sampling carries, 1/(2 dx) \[1/µm\].
    pub largest_frequency: [f64; 2],
    /// The length after which the heights repeat along `x` and `y` \[µm\]; `None` where nothing clearly repeats.
    pub period: [Option<f64>; 2],
    /// Share of the samples that lie beyond three standard deviations: 0.0027 for normally distributed heights, far
    /// more where there is dust.
    pub outliers: f64,
}

/// Standard deviations from the mean beyond which a sample counts as an outlier.
const OUTLIER: f64 = 3.0;

impl Statistics {
    /// Measures `field`.
    pub fn of(field: &HeightField) -> Self {
        let count = field.heights().len() as f64;
        let mean = level::mean(field);
        let variance = field.heights().iter().map(|h| (h - mean).powi(2)).sum::<f64>() / count;
        let roughness = variance.sqrt();
        let beyond = field.heights().iter().filter(|h| (*h - mean).abs() > OUTLIER * roughness).count();
        let [dx, dy] = field.pixel_size();
        Self {
            samples: [field.columns(), field.rows()],
            pixel_size: [dx, dy],
            patch_size: field.patch_size(),
            range: field.range(),
            mean,
            roughness,
            levels: distinct(field.heights()),
            largest_frequency: [0.5 / dx, 0.5 / dy],
            period: periods(field, mean),
            outliers: beyond as f64 / count,
        }
    }
}

fn distinct(heights: &[f64]) -> usize {
    /// Heights that are copied at once: those of an image are few different ones, a copy of all of them may be gigabytes.
    const AT_ONCE: usize = 1 << 20;
    let sorted = |mut some: Vec<f64>| {
        some.par_sort_unstable_by(f64::total_cmp);
        some.dedup_by(|a, b| *a == *b); // 0 and −0 are one height
        some.shrink_to_fit(); // or each keeps the room of what it was
        some
    };
    let parts: Vec<Vec<f64>> = heights.par_chunks(AT_ONCE).map(|part| sorted(part.to_vec())).collect();
    sorted(parts.concat()).len()
}

fn periods(field: &HeightField, mean: f64) -> [Option<f64>; 2] {
    let (columns, rows) = (field.columns(), field.rows());
    let [width, height] = field.patch_size();
    let along_x = line_spectrum(columns, rows, |line, i| field.row(line)[i] - mean);
    let along_y = line_spectrum(rows, columns, |line, i| field.row(i)[line] - mean);
    // Rounding leaves this much of the heights behind where a line is constant.
    let (low, high) = field.range();
    let noise = (1e-12 * low.abs().max(high.abs())).powi(2);
    [(along_x, width), (along_y, height)]
        .map(|(spectrum, length)| dominant_cycles(&spectrum, noise).map(|cycles| length / cycles))
}

/// Power at 0, 1, … n/2 cycles a line, averaged over the `lines`, each less its own mean and under a Hann window, which
/// keeps a scan's tilt from leaking into all frequencies. Scaled so that the sum is the mean square of what is left.
///
/// Of many lines some are enough, evenly spread: a walk down every column of a field of gigabytes takes minutes.
fn line_spectrum(n: usize, lines: usize, sample: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    const MOST_LINES: usize = 2048;
    let step = lines.div_ceil(MOST_LINES);
    let transform = FftPlanner::new().plan_fft_forward(n);
    let window: Vec<f64> = (0..n).map(|i| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / n as f64).cos()).collect();
    let energy: f64 = window.iter().map(|w| w * w).sum();
    let mut power = vec![0.0; n / 2 + 1];
    let mut line_values = vec![Complex::default(); n];
    for line in (0..lines).step_by(step) {
        let mean = (0..n).map(|i| sample(line, i)).sum::<f64>() / n as f64;
        for (i, value) in line_values.iter_mut().enumerate() {
            *value = Complex::new(window[i] * (sample(line, i) - mean), 0.0);
        }
        transform.process(&mut line_values);
        for (cycles, p) in power.iter_mut().enumerate() {
            *p += line_values[cycles].norm_sqr();
        }
    }
    // Both signs of the frequency, and Parseval's n.
    let scale = 2.0 / (n as f64 * energy * lines.div_ceil(step) as f64);
    power.iter().map(|p| p * scale).collect()
}

/// Fewer repeats than this in a patch are no period.
const FEWEST_CYCLES: usize = 3;
/// Half the width of the band that counts as one period, relative to its centre: natural ridges vary by about so much.
const BAND: f64 = 0.1;
/// A period rules its surroundings from 1/OCTAVES to OCTAVES times its frequency.
const SURROUNDINGS: f64 = 1.5;
/// How many times denser the power in the band must be than outside it. White noise has 1.
const CLEAR: f64 = 5.0;

/// The number of cycles a line (not whole, in general) that hold the most power within [`BAND`], if that band stands
/// out of its surroundings and of the whole spectrum.
fn dominant_cycles(spectrum: &[f64], noise: f64) -> Option<f64> {
    let last = spectrum.len() - 1;
    if last < FEWEST_CYCLES {
        return None;
    }
    let band = |cycles: usize| {
        let half = ((BAND * cycles as f64) as usize).max(1);
        cycles.saturating_sub(half).max(1)..=(cycles + half).min(last)
    };
    let sums: Vec<f64> = (0..=last).map(|cycles| spectrum[band(cycles)].iter().sum()).collect();
    let rules = |cycles: &usize| {
        let from = (*cycles as f64 / SURROUNDINGS) as usize;
        let to = ((*cycles as f64 * SURROUNDINGS) as usize).min(last);
        (from.max(1)..=to).all(|other| sums[other] <= sums[*cycles])
    };
    let best = (FEWEST_CYCLES..=last).filter(rules).max_by(|a, b| sums[*a].total_cmp(&sums[*b]))?;
    let inside = band(best).count() as f64;
    let others: f64 = spectrum[FEWEST_CYCLES..].iter().sum::<f64>() - sums[best];
    let outside = (last as f64 - inside).max(1.0);
    let clear = sums[best] > noise && sums[best] / inside > CLEAR * others.max(0.0) / outside;
    let moment: f64 = band(best).map(|cycles| cycles as f64 * spectrum[cycles]).sum();
    clear.then(|| moment / sums[best])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(columns: usize, rows: usize, h: impl Fn(f64, f64) -> f64) -> HeightField {
        let pixel = [0.1, 0.05];
        let at = |i: usize| h((i % columns) as f64 * pixel[0], (i / columns) as f64 * pixel[1]);
        HeightField::new(columns, rows, pixel, (0..columns * rows).map(at).collect()).unwrap()
    }

    #[test]
    fn a_sinusoid_has_its_closed_form_numbers() {
        let s = Statistics::of(&field(200, 40, |x, _| 3.0 + 0.2 * (TAU * x / 2.0).sin()));
        assert!((s.mean - 3.0).abs() < 1e-12);
        assert!((s.roughness - 0.2 / 2_f64.sqrt()).abs() < 1e-12);
        assert!((s.range.1 - 3.2).abs() < 1e-12 && (s.range.0 - 2.8).abs() < 1e-12);
        assert_eq!(s.samples, [200, 40]);
        assert!((s.patch_size[0] - 20.0).abs() < 1e-12 && (s.patch_size[1] - 2.0).abs() < 1e-12);
        assert!(
            (s.largest_frequency[0] - 5.0).abs() < 1e-12 && (s.largest_frequency[1] - 10.0).abs() < 1e-12
        );
        assert!((s.period[0].unwrap() - 2.0).abs() < 1e-9, "{:?}", s.period);
        assert_eq!(s.period[1], None);
        assert_eq!(s.outliers, 0.0);
    }

    #[test]
    fn a_period_is_found_under_tilt_and_large_waves() {
        let ridges =
            |x: f64, y: f64| 0.1 * (TAU * y / 0.7).sin() + 0.5 * x + 0.4 * y + (x * 0.3 + y * 0.2).sin();
        let s = Statistics::of(&field(150, 400, ridges));
        assert!((s.period[1].unwrap() - 0.7).abs() < 0.01, "{:?}", s.period);
    }

    #[test]
    fn noise_a_flat_field_and_a_single_sample_have_no_period() {
        // Bits of a sample's number, well mixed (the last steps of SplitMix64).
        let noise = |x: f64, y: f64| {
            let mut z = ((x * 10.0).round() + (y * 20.0).round() * 256.0) as u64;
            for factor in [0xBF58_476D_1CE4_E5B9, 0x94D0_49BB_1331_11EB_u64] {
                z = (z ^ (z >> 30)).wrapping_mul(factor).wrapping_add(0x9E37_79B9_7F4A_7C15);
            }
            (z >> 40) as f64
        };
        assert_eq!(Statistics::of(&field(256, 128, noise)).period, [None, None]);
        let flat = Statistics::of(&field(64, 64, |_, _| 0.3));
        assert_eq!((flat.period, flat.levels, flat.outliers), ([None, None], 1, 0.0));
        assert_eq!(Statistics::of(&field(1, 1, |_, _| 1.0)).period, [None, None]);
    }

    #[test]
    fn levels_and_outliers_are_counted() {
        let steps = Statistics::of(&field(100, 10, |x, _| (x / 2.5).floor()));
        assert_eq!(steps.levels, 4);
        let dusty = Statistics::of(&field(100, 10, |x, y| if x == 0.0 && y == 0.0 { 9.0 } else { 0.0 }));
        assert_eq!(dusty.outliers, 1e-3);
    }
}
