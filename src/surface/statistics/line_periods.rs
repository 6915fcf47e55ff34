//! Periods along the axes: the length after which the rows, or the columns, repeat.

use super::mean;
use crate::surface::HeightField;
use rustfft::{FftPlanner, num_complex::Complex};
use std::f64::consts::TAU;

/// Returns the length after which the heights repeat along `x` and `y` \[µm\]; `None` if nothing clearly repeats.
pub fn line_periods(field: &HeightField) -> [Option<f64>; 2] {
    let mean = mean(field);
    let (columns, rows) = (field.columns(), field.rows());
    let [width, height] = field.patch_size();
    let along_x = line_spectrum(columns, rows, |line, i| field.row(line)[i] - mean);
    let along_y = line_spectrum(rows, columns, |line, i| field.row(i)[line] - mean);
    // Upper bound of the power that rounding leaves of a constant line.
    let (low, high) = field.range();
    let noise = (1e-12 * low.abs().max(high.abs())).powi(2);
    [(along_x, width), (along_y, height)]
        .map(|(spectrum, length)| dominant_cycles(&spectrum, noise).map(|cycles| length / cycles))
}

/// Returns the power at 0, 1, … n/2 cycles a line, averaged over the `lines`. The mean of each line is subtracted, and a Hann window keeps
/// a scan's tilt from leaking into all frequencies. The powers sum to the mean square of the remaining heights.
///
/// Long fields are subsampled to `MOST_LINES` lines, evenly spread: a walk down every column of a field of gigabytes takes minutes.
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

/// Smallest number of repeats in a patch for a period.
const FEWEST_CYCLES: usize = 3;
/// Half the width of the band of one period, relative to its centre: about the variation of natural ridges.
const BAND: f64 = 0.1;
/// Ratio of frequencies to a period's within which the period has to dominate.
const SURROUNDINGS: f64 = 1.5;
/// Least ratio of the power density in the band to that outside it. White noise has 1.
const CLEAR: f64 = 5.0;

/// Returns the number of cycles a line (not whole, in general) with the most power within [`BAND`]; `None` unless that band stands out of
/// its surroundings and of the whole spectrum.
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
    use crate::surface::statistics::tests::field;

    #[test]
    fn a_period_is_found_under_tilt_and_large_waves() {
        let ridges =
            |x: f64, y: f64| 0.1 * (TAU * y / 0.7).sin() + 0.5 * x + 0.4 * y + (x * 0.3 + y * 0.2).sin();
        let period = line_periods(&field(150, 400, ridges));
        assert!((period[1].unwrap() - 0.7).abs() < 0.01, "{period:?}");
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
        assert_eq!(line_periods(&field(256, 128, noise)), [None, None]);
        assert_eq!(line_periods(&field(64, 64, |_, _| 0.3)), [None, None]);
        assert_eq!(line_periods(&field(1, 1, |_, _| 1.0)), [None, None]);
    }
}
