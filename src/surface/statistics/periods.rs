//! The periods that stand out of the power spectrum of a field, with their directions and their uncertainty.

use super::height_spectrum::SurfaceSpectrum;
use crate::error::Result;
use crate::surface::HeightField;
use crate::surface::si::{metres, metres_of_option};
use serde::Serialize;
use std::f64::consts::PI;

/// A period of the heights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Period {
    /// Its length \[µm\].
    #[serde(rename = "length_m", serialize_with = "metres")]
    pub length: f64,
    /// Uncertainty of the length \[µm\]: its standard deviation over the left, right, upper and lower half of the field, and what other
    /// components of the spectrum may shift the peak by. `None` if halves are too small for the period.
    #[serde(rename = "length_spread_m", serialize_with = "metres_of_option")]
    pub length_spread: Option<f64>,
    /// Direction of its wave vector from +x toward +y, across the grooves, −90 … 90 \[degrees\].
    #[serde(rename = "direction_deg")]
    pub direction: f64,
    /// Standard deviation of the direction over the same halves \[degrees\].
    #[serde(rename = "direction_spread_deg")]
    pub direction_spread: Option<f64>,
    /// Amplitude of the sinusoid that has the power of the peak \[µm\].
    #[serde(rename = "amplitude_m", serialize_with = "metres")]
    pub amplitude: f64,
}

/// Smallest number of repeats over the field for a period.
const FEWEST_CYCLES: f64 = 3.0;
/// A peak's power over the mean power of noise at its |f|: white noise alone reaches 20 once in 5·10⁸ frequencies.
const CLEAR: f64 = 30.0;
/// A peak's power over that of the strongest.
const STRONG: f64 = 0.02;
/// Peaks nearer to a stronger one than this share of its frequency belong to that peak.
const OWN: f64 = 0.2;
/// Bins that the main lobe of a Hann window reaches to each side.
const LOBE: f64 = 2.0;
/// Largest number of periods that are reported.
const MOST: usize = 4;
/// Search range of the period in a half field, relative to its frequency.
const NEAR: f64 = 0.25;

/// Returns the strongest periods of `field`, whose windowed spectrum is `spectrum`.
///
/// # Errors
/// Too little memory for the spectra of half fields.
pub fn dominant_periods(field: &HeightField, spectrum: &SurfaceSpectrum) -> Result<Vec<Period>> {
    let peaks = peaks(field, spectrum);
    if peaks.is_empty() {
        return Ok(Vec::new());
    }
    let mut in_halves: Vec<Vec<[f64; 2]>> = vec![Vec::new(); peaks.len()];
    let mut asked = 0;
    for half in halves(field) {
        asked += 1;
        let spectrum = SurfaceSpectrum::windowed(&half?)?;
        for (peak, found) in peaks.iter().zip(&mut in_halves) {
            let near = |f: [f64; 2]| distance(f, peak.frequency) < NEAR * length(peak.frequency);
            if let Some((place, _)) = strongest(&spectrum, near) {
                let f = refined(&spectrum, place);
                // The opposite frequency has the same power.
                let same_side = f[0] * peak.frequency[0] + f[1] * peak.frequency[1] >= 0.0;
                found.push(if same_side { f } else { f.map(|x| -x) });
            }
        }
    }
    // A peak that most halves lack is a coincidence of the whole field.
    let shown = |in_halves: &[[f64; 2]]| 2 * in_halves.len() >= asked;
    let found = peaks.iter().zip(&in_halves).filter(|(_, in_halves)| shown(in_halves));
    let periods = found.map(|(peak, in_halves)| period(peak, in_halves, leaked(spectrum, peak, &peaks)));
    Ok(periods.collect())
}

/// Returns the wave vector of the strongest period \[1/µm\], by which a rotation aligns grooves; `None` if no period stands out.
///
/// # Errors
/// Too little memory for the spectrum.
pub(in crate::surface) fn wave_vector(field: &HeightField) -> Result<Option<[f64; 2]>> {
    let part = super::height_spectrum::analysed_part(field);
    let spectrum = SurfaceSpectrum::windowed(&part)?;
    Ok(peaks(&part, &spectrum).first().map(|peak| peak.frequency))
}

/// A peak of the spectrum.
struct SpectralPeak {
    /// Refined between the bins \[1/µm\]; `f_x ≥ 0`, apart from the refinement.
    frequency: [f64; 2],
    /// Amplitude of the sinusoid \[µm\].
    amplitude: f64,
}

fn length(f: [f64; 2]) -> f64 {
    f[0].hypot(f[1])
}

/// Returns the distance of `a` from `b` or its opposite, whichever is nearer.
fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1]).min((a[0] + b[0]).hypot(a[1] + b[1]))
}

fn peaks(field: &HeightField, spectrum: &SurfaceSpectrum) -> Vec<SpectralPeak> {
    // Rounding leaves this much of the heights behind.
    let (low, high) = field.range();
    let rounding = (1e-12 * low.abs().max(high.abs())).powi(2);
    let bin = (1.0 / spectrum.patch[0]).max(1.0 / spectrum.patch[1]);
    let mut found: Vec<SpectralPeak> = Vec::new();
    let mut first_power = 0.0;
    while found.len() < MOST {
        let free = |f: [f64; 2]| {
            found.iter().all(|peak| distance(f, peak.frequency) > OWN * length(peak.frequency) + LOBE * bin)
        };
        let Some((place, power)) = strongest(spectrum, free) else { break };
        first_power = f64::max(first_power, power);
        let f = length(spectrum.frequency(place[0], place[1]));
        if power <= rounding || power < STRONG * first_power || power < CLEAR * spectrum.background(f) {
            break;
        }
        found.push(SpectralPeak {
            frequency: refined(spectrum, place),
            amplitude: amplitude(spectrum, place),
        });
    }
    found
}

/// Returns the indices and the power of the strongest peak that is `allowed` and has at least [`FEWEST_CYCLES`] over the field. A frequency
/// on the flank of a stronger, lower one is no peak.
fn strongest(
    spectrum: &SurfaceSpectrum,
    allowed: impl Fn([f64; 2]) -> bool + Sync,
) -> Option<([usize; 2], f64)> {
    use rayon::prelude::*;
    let of_column = |i: usize| {
        let candidates = (0..spectrum.samples[1]).filter_map(|j| {
            let f = spectrum.frequency(i, j);
            let cycles = (f[0] * spectrum.patch[0]).hypot(f[1] * spectrum.patch[1]);
            (cycles >= FEWEST_CYCLES).then(|| (spectrum.power(i, j), j, f))
        });
        // The calls come last because they cost more than the comparison.
        let mut best: Option<(usize, f64)> = None;
        for (power, j, f) in candidates {
            if best.is_none_or(|(_, most)| power > most) && allowed(f) && is_summit(spectrum, [i, j]) {
                best = Some((j, power));
            }
        }
        best.map(|(j, power)| ([i, j], power))
    };
    (0..spectrum.half()).into_par_iter().filter_map(of_column).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns true if no neighbouring frequency is stronger.
fn is_summit(spectrum: &SurfaceSpectrum, place: [usize; 2]) -> bool {
    let [i, j] = place.map(|n| n as isize);
    let here = spectrum.power(place[0], place[1]);
    let around = (-1..=1).flat_map(|di| (-1..=1).map(move |dj| (di, dj)));
    around.into_iter().all(|(di, dj)| spectrum.value(i + di, j + dj).norm_sqr() <= here * (1.0 + 1e-9))
}

/// Returns the frequency of the peak at `place`, interpolated between the bins \[1/µm\].
///
/// For one sinusoid under a Hann window the ratio α of the amplitudes at the larger neighbour and at the peak gives the distance exactly, δ
/// = (2α − 1)/(α + 1) [Grandke 1983, "Interpolation algorithms for discrete Fourier transforms of weighted signals"]. The window is a
/// product, so that each axis is interpolated separately.
pub(super) fn refined(spectrum: &SurfaceSpectrum, place: [usize; 2]) -> [f64; 2] {
    let [i, j] = place.map(|n| n as isize);
    let at = |di: isize, dj: isize| spectrum.value(i + di, j + dj).norm();
    let offset = |below: f64, above: f64, peak: f64| {
        let (next, sign) = if above >= below { (above, 1.0) } else { (below, -1.0) };
        let ratio = next / peak;
        let delta = (2.0 * ratio - 1.0) / (ratio + 1.0);
        sign * if delta.is_finite() { delta.clamp(-0.5, 0.5) } else { 0.0 }
    };
    let peak = at(0, 0);
    let [x, y] = spectrum.frequency(place[0], place[1]);
    let along = |samples: usize, delta: f64| if samples > 1 { delta } else { 0.0 };
    let dx = along(spectrum.samples[0], offset(at(-1, 0), at(1, 0), peak));
    let dy = along(spectrum.samples[1], offset(at(0, -1), at(0, 1), peak));
    [x + dx / spectrum.patch[0], y - dy / spectrum.patch[1]] // places grow down, y grows up
}

/// Returns the amplitude of the sinusoid whose power is that of the main lobe around `place`: A²/2 is twice the power of one sign's lobe.
pub(super) fn amplitude(spectrum: &SurfaceSpectrum, place: [usize; 2]) -> f64 {
    let [i, j] = place.map(|n| n as isize);
    let reach = |samples: usize| {
        let reach = (LOBE as isize).min((samples as isize - 1) / 2);
        -reach..=reach
    };
    let lobe = reach(spectrum.samples[0])
        .flat_map(|di| reach(spectrum.samples[1]).map(move |dj| (di, dj)))
        .map(|(di, dj)| spectrum.value(i + di, j + dj).norm_sqr());
    2.0 * lobe.sum::<f64>().sqrt()
}

/// Returns the left, right, upper and lower half of `field`, if they have enough samples for [`FEWEST_CYCLES`] of two samples.
fn halves(field: &HeightField) -> impl Iterator<Item = Result<HeightField>> + '_ {
    const FEWEST_SAMPLES: usize = 6;
    let (columns, rows) = (field.columns(), field.rows());
    let (c, r) = (columns / 2, rows / 2);
    [(0, 0, c, rows), (columns - c, 0, c, rows), (0, 0, columns, r), (0, rows - r, columns, r)]
        .into_iter()
        .filter(|(.., c, r)| *c > 0 && *r > 0 && (*c).max(*r) >= FEWEST_SAMPLES)
        .map(move |(left, top, c, r)| {
            let part = (top..top + r).flat_map(|row| &field.row(row)[left..left + c]).copied().collect();
            HeightField::new(c, r, field.pixel_size(), part)
        })
}

/// Returns the relative error of the length of `peak` by the side lobes of its negative frequency and of the other `peaks`.
///
/// A Hann window's transform at d bins is at most 1/(πd(d² − 1)) of its peak. A share ε of the amplitude in each of the two bins that
/// [`refined`] takes the ratio of moves the ratio by up to 2ε, and the peak by up to 1.5 times as many bins.
fn leaked(spectrum: &SurfaceSpectrum, peak: &SpectralPeak, peaks: &[SpectralPeak]) -> f64 {
    const BINS_PER_SHARE: f64 = 3.0;
    let bins = |f: [f64; 2]| (f[0] * spectrum.patch[0]).hypot(f[1] * spectrum.patch[1]);
    let [x, y] = peak.frequency;
    let side_lobe = |other: &SpectralPeak, sign: f64| {
        // Nearer than the main lobe nothing is resolved; the nearest bin of the peak is one nearer.
        let d = (bins([x - sign * other.frequency[0], y - sign * other.frequency[1]]) - 1.0).max(LOBE);
        other.amplitude / peak.amplitude / (PI * d * (d * d - 1.0))
    };
    let others =
        peaks.iter().filter(|other| other.frequency != peak.frequency).map(|other| side_lobe(other, 1.0));
    let sum = others.sum::<f64>() + peaks.iter().map(|other| side_lobe(other, -1.0)).sum::<f64>();
    BINS_PER_SHARE * sum / bins(peak.frequency)
}

/// Returns the period of a peak with its spread in `in_halves`, the frequencies of the peak in half fields, and the relative error `leaked`
/// of its length.
fn period(peak: &SpectralPeak, in_halves: &[[f64; 2]], leaked: f64) -> Period {
    let [x, y] = peak.frequency;
    let direction = (y / x).atan().to_degrees(); // ±90 where x is 0
    let lengths: Vec<f64> = in_halves.iter().map(|f| 1.0 / length(*f)).collect();
    // The angle to the whole field's wave vector, so that no turn of 180° comes between.
    let angles: Vec<f64> =
        in_halves.iter().map(|[u, v]| (x * v - y * u).atan2(x * u + y * v).to_degrees()).collect();
    Period {
        length: 1.0 / length(peak.frequency),
        length_spread: deviation(&lengths).map(|spread| spread.hypot(leaked / length(peak.frequency))),
        direction,
        direction_spread: deviation(&angles),
        amplitude: peak.amplitude,
    }
}

/// Returns the standard deviation of two numbers or more.
fn deviation(numbers: &[f64]) -> Option<f64> {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    (numbers.len() > 1).then(|| (numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::surface::statistics::tests::field;
    use std::f64::consts::TAU;

    fn periods(field: &HeightField) -> Vec<Period> {
        dominant_periods(field, &SurfaceSpectrum::windowed(field).unwrap()).unwrap()
    }

    #[test]
    fn a_sinusoid_has_its_period_direction_and_amplitude() {
        for (length, degrees) in [(0.83, 0.0), (0.61, 30.0), (1.37, -52.5), (0.9, 89.0), (0.77, -71.0)] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            // `field` has y from the top: upward it falls.
            let wave =
                field(220, 400, |x, y| 0.2 * (TAU * (x * cos - y * sin) / length + 0.4).sin() + 0.1 * x);
            let found = &periods(&wave)[0];
            assert!((found.length / length - 1.0).abs() < 2e-4, "{length} um, {degrees}: {found:?}");
            assert!((found.direction - degrees).abs() < 0.02, "{length} um, {degrees}: {found:?}");
            assert!((found.amplitude / 0.2 - 1.0).abs() < 0.02, "{length} um, {degrees}: {found:?}");
            assert!(found.length_spread.unwrap() < 1e-2 * length, "{found:?}");
        }
    }

    #[test]
    fn the_uncertainty_of_a_few_cycles_of_a_blaze_holds_its_period() {
        for columns in [110, 119, 131, 160, 200] {
            // Unlike a sinusoid a sawtooth has harmonics whose side lobes shift the peak.
            let blaze = field(columns, 40, |x, _| 0.24 * (x / 2.5).fract());
            let found = periods(&blaze);
            let [first, ..] = &found[..] else { panic!("no period of {columns} columns") };
            let spread = first.length_spread.unwrap();
            // Three standard deviations.
            assert!((first.length - 2.5).abs() <= 3.0 * spread, "{columns} columns: {first:?}");
            assert!(spread < 0.02 * 2.5, "{columns} columns: {first:?}");
        }
    }

    #[test]
    fn two_gratings_are_two_periods_and_the_stronger_is_first() {
        let crossed = field(200, 400, |x, y| 0.1 * (TAU * x / 0.7).sin() + 0.05 * (TAU * y / 1.1).cos());
        let found = periods(&crossed);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!((found[0].length - 0.7).abs() < 1e-3 && (found[1].length - 1.1).abs() < 1e-3);
        assert!(found[0].direction.abs() < 0.1 && (found[1].direction.abs() - 90.0).abs() < 0.1);
    }

    #[test]
    fn the_spread_is_that_of_the_halves() {
        // 0.6 µm on the left, 0.66 µm on the right.
        let two = field(400, 200, |x, _| 0.1 * (TAU * if x < 20.0 { x / 0.6 } else { x / 0.66 }).sin());
        let found = &periods(&two)[0];
        assert!((0.02..0.05).contains(&found.length_spread.unwrap()), "{found:?}");
        assert!(found.direction_spread.unwrap() < 0.2, "{found:?}");
    }

    #[test]
    fn noise_and_flat_fields_and_single_waves_have_no_period() {
        let mut random = Random::new(8);
        let noise = (0..300 * 200).map(|_| random.signed()).collect();
        assert_eq!(periods(&HeightField::new(300, 200, [0.1; 2], noise).unwrap()), []);
        assert_eq!(periods(&field(100, 100, |_, _| 0.3)), []);
        assert_eq!(periods(&field(100, 100, |x, _| (TAU * x / 5.0).sin())), [], "two cycles are no period");
    }
}
