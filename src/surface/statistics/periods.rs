//! The periods that stand out of the power spectrum of a field, with their directions and their uncertainty.

use super::bands::{SpectralBand, bands};
use super::height_spectrum::SurfaceSpectrum;
use crate::error::Result;
use crate::surface::si::{metres, metres_of_option};
use crate::surface::{HeightField, Levelling};
use rustfft::num_complex::Complex;
use serde::Serialize;
use std::f64::consts::PI;

/// A period of the heights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Period {
    /// Its length \[µm\].
    #[serde(rename = "length_m", serialize_with = "metres")]
    pub length: f64,
    /// Method by which the length was found.
    pub method: PeriodMethod,
    /// Uncertainty of the length \[µm\]: its standard deviation over the left, right, upper and lower half of the field, and what other
    /// components of the spectrum may shift a line by, or what the window shifts the middle of a band by. `None` if halves are too small
    /// for the period.
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

/// Method by which the length of a period was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PeriodMethod {
    /// The frequency of a line of the spectrum: the heights repeat exactly.
    Line,
    /// The middle of a band of frequencies: the period varies over the field.
    Band,
}

impl PeriodMethod {
    /// Returns the name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Band => "band",
        }
    }

    /// Returns the method in words, for `surface info`.
    pub fn words(self) -> &'static str {
        match self {
            Self::Line => "a line of the spectrum",
            Self::Band => "the middle of a band of the spectrum",
        }
    }
}

/// Smallest number of repeats over the field for a period.
const FEWEST_CYCLES: f64 = 3.0;
/// A peak's power over the mean power of noise at its |f|: white noise alone reaches 20 once in 5·10⁸ frequencies.
const CLEAR: f64 = 30.0;
/// A peak's power over that of the strongest.
const STRONG: f64 = 0.02;
/// Least share of the power of the band around it, less noise, that a line has.
const LINE_SHARE: f64 = 0.8;
/// Largest share of the power of the bins at and beside a line that its shape, that of the window's transform, leaves.
const MISFIT: f64 = 0.1;
/// Largest difference in the number of periods over the field, between the field and its halves, of an exact line.
const EXACT: f64 = 0.05;
/// Standard deviation of the length over half fields from which on a peak is no period, relative to the length: noise has such peaks, too.
const UNSTEADY: f64 = 0.08;
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
            found.extend(peak.found_in(&spectrum));
        }
    }
    let unwindowed = if peaks.iter().any(|peak| peak.method == PeriodMethod::Band) {
        Some(SurfaceSpectrum::of_one_period(&field.levelled(Levelling::Plane)?)?)
    } else {
        None
    };
    let shifted = |peak: &SpectralPeak| match (peak.method, &unwindowed) {
        (PeriodMethod::Band, Some(unwindowed)) => SpectralBand::around(unwindowed, peak.frequency)
            .map_or(0.0, |band| length(peak.frequency) / band.length() - 1.0),
        _ => leaked(spectrum, peak, &peaks),
    };
    // A peak that most halves lack is a coincidence of the whole field.
    let shown = |in_halves: &[[f64; 2]]| 2 * in_halves.len() >= asked;
    let found = peaks.iter().zip(&in_halves).filter(|(_, in_halves)| shown(in_halves));
    let periods = found.map(|(peak, in_halves)| period(peak, in_halves, shifted(peak)));
    let steady =
        |period: &Period| period.length_spread.is_none_or(|spread| spread < UNSTEADY * period.length);
    Ok(periods.filter(steady).collect())
}

/// Returns the wave vector of the strongest period \[1/µm\], by which a rotation aligns grooves; `None` if no period stands out.
///
/// # Errors
/// Too little memory for the spectrum.
pub(in crate::internals::surface) fn wave_vector(field: &HeightField) -> Result<Option<[f64; 2]>> {
    let part = super::height_spectrum::analysed_part(field);
    let spectrum = SurfaceSpectrum::windowed(&part)?;
    Ok(peaks(&part, &spectrum).first().map(|peak| peak.frequency))
}

/// A peak of the spectrum.
struct SpectralPeak {
    /// A line or the middle of a band.
    method: PeriodMethod,
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

impl SpectralPeak {
    /// Returns the power of one sign of the frequency \[µm²\].
    fn power(&self) -> f64 {
        (self.amplitude / 2.0).powi(2)
    }

    fn of_band(band: &SpectralBand) -> Self {
        Self { method: PeriodMethod::Band, frequency: band.frequency, amplitude: 2.0 * band.power.sqrt() }
    }

    /// Returns true if the frequency, or for a line a multiple of it, is within `reach` of `other`. Harmonics belong to the line.
    fn has_multiple_within(&self, other: [f64; 2], reach: f64) -> bool {
        let harmonics = if self.method == PeriodMethod::Line {
            (length(other) / length(self.frequency)).round().max(1.0)
        } else {
            1.0
        };
        distance(self.frequency.map(|f| harmonics * f), other) <= reach
    }

    /// Returns the frequency of this peak in the `spectrum` of a part of the field; `None` if it is not there.
    fn found_in(&self, spectrum: &SurfaceSpectrum) -> Option<[f64; 2]> {
        if self.method == PeriodMethod::Band {
            return SpectralBand::around(spectrum, self.frequency).map(|band| band.frequency);
        }
        let near = |f: [f64; 2]| distance(f, self.frequency) < NEAR * length(self.frequency);
        let (place, _) = strongest(spectrum, near)?;
        let f = refined(spectrum, place);
        // The opposite frequency has the same power.
        let same_side = f[0] * self.frequency[0] + f[1] * self.frequency[1] >= 0.0;
        Some(if same_side { f } else { f.map(|x| -x) })
    }
}

/// Returns the lines and the bands that stand out, the strongest first. What looks like a line and has another shape, or little of the
/// power around it, is the highest of many frequencies in a band.
fn peaks(field: &HeightField, spectrum: &SurfaceSpectrum) -> Vec<SpectralPeak> {
    let mut found: Vec<SpectralPeak> = Vec::new();
    let mut wide = Vec::new();
    for line in lines(field, spectrum) {
        match SpectralBand::around(spectrum, line.frequency) {
            Some(band) if !is_line(spectrum, &line, &band) => wide.push(band),
            _ => found.push(line),
        }
    }
    wide.extend(bands(spectrum, FEWEST_CYCLES).into_iter().filter(|band| band.power > rounding(field)));
    for band in wide {
        let own = |peak: &SpectralPeak| peak.has_multiple_within(band.frequency, band.reach());
        if !found.iter().any(own) {
            found.push(SpectralPeak::of_band(&band));
        }
    }
    found.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    let strongest = found.first().map_or(0.0, SpectralPeak::power);
    found.retain(|peak| peak.power() >= STRONG * strongest);
    found.truncate(MOST);
    found
}

/// Returns the frequencies of the exact lines \[1/µm\], the strongest first: those of gratings that are in phase over the whole field, so that
/// each half of it has the same frequency.
///
/// # Errors
/// Too little memory for the spectra of half fields.
pub(super) fn exact_lines(field: &HeightField, spectrum: &SurfaceSpectrum) -> Result<Vec<[f64; 2]>> {
    let is_line = |line: &SpectralPeak| {
        SpectralBand::around(spectrum, line.frequency).is_none_or(|band| is_line(spectrum, line, &band))
    };
    let mut exact: Vec<SpectralPeak> = lines(field, spectrum).into_iter().filter(is_line).collect();
    if exact.is_empty() {
        return Ok(Vec::new());
    }
    for half in halves(field) {
        let half = SurfaceSpectrum::windowed(&half?)?;
        exact.retain(|line| {
            line.found_in(&half).is_none_or(|f| {
                let periods = |axis: usize| (f[axis] - line.frequency[axis]).abs() * spectrum.patch[axis];
                periods(0).max(periods(1)) < EXACT
            })
        });
    }
    Ok(exact.iter().map(|line| line.frequency).collect())
}

/// Returns true if `line` has the shape of a single frequency and most of the power of the band around it.
fn is_line(spectrum: &SurfaceSpectrum, line: &SpectralPeak, band: &SpectralBand) -> bool {
    let noise = spectrum.background(length(line.frequency)) * band.bins(spectrum);
    line.power() >= LINE_SHARE * (band.power - noise) && misfit(spectrum, line.frequency) <= MISFIT
}

/// Returns the share of the power in the bins at and beside `frequency` that the transform of a Hann window there leaves.
fn misfit(spectrum: &SurfaceSpectrum, frequency: [f64; 2]) -> f64 {
    let at = [0, 1].map(|axis| frequency[axis] * spectrum.patch[axis]);
    let middle = at.map(|bins| bins.round() as isize);
    // Single lines have one bin along that axis.
    let reach = spectrum.samples.map(|samples| isize::from(samples > 1));
    let shape = |axis: usize, bin: isize| {
        if reach[axis] == 0 { Complex::ONE } else { hann_transform(bin as f64 - at[axis]) }
    };
    let (mut all, mut product, mut shapes) = (0.0, Complex::<f64>::default(), 0.0);
    for i in -reach[0]..=reach[0] {
        for up in -reach[1]..=reach[1] {
            let place = [middle[0] + i, middle[1] + up];
            let measured = spectrum.value(place[0], -place[1]);
            // Rows are counted downward, against y.
            let model = shape(0, place[0]) * shape(1, place[1]).conj();
            all += measured.norm_sqr();
            product += measured * model.conj();
            shapes += model.norm_sqr();
        }
    }
    if all > 0.0 { 1.0 - product.norm_sqr() / (all * shapes) } else { 1.0 }
}

/// Returns the transform of a Hann window over many samples at `d` bins, relative to that at 0, with the phase of samples that are counted
/// from the edge.
fn hann_transform(d: f64) -> Complex<f64> {
    // At 0 and 1 the quotient is 0/0.
    let value = if d.abs() < 1e-6 {
        1.0
    } else if (d.abs() - 1.0).abs() < 1e-6 {
        0.5
    } else {
        (PI * d).sin() / (PI * d) / (1.0 - d * d)
    };
    Complex::cis(-PI * d) * value
}

/// Returns the power that rounding leaves of the heights \[µm²\].
fn rounding(field: &HeightField) -> f64 {
    let (low, high) = field.range();
    (1e-12 * low.abs().max(high.abs())).powi(2)
}

/// Returns the lines of the spectrum, the strongest first.
fn lines(field: &HeightField, spectrum: &SurfaceSpectrum) -> Vec<SpectralPeak> {
    let rounding = rounding(field);
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
            method: PeriodMethod::Line,
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
    let lines = peaks.iter().filter(|other| other.method == PeriodMethod::Line);
    let others = lines.clone().filter(|other| other.frequency != peak.frequency);
    let sum = others.map(|other| side_lobe(other, 1.0)).sum::<f64>()
        + lines.map(|other| side_lobe(other, -1.0)).sum::<f64>();
    BINS_PER_SHARE * sum / bins(peak.frequency)
}

/// Returns the period of a peak with its spread in `in_halves`, the frequencies of the peak in half fields, and the relative error
/// `shifted` of its length by the window or by other peaks.
fn period(peak: &SpectralPeak, in_halves: &[[f64; 2]], shifted: f64) -> Period {
    let [x, y] = peak.frequency;
    let direction = (y / x).atan().to_degrees(); // ±90 where x is 0
    let lengths: Vec<f64> = in_halves.iter().map(|f| 1.0 / length(*f)).collect();
    // The angle to the whole field's wave vector, so that no turn of 180° comes between.
    let angles: Vec<f64> =
        in_halves.iter().map(|[u, v]| (x * v - y * u).atan2(x * u + y * v).to_degrees()).collect();
    Period {
        length: 1.0 / length(peak.frequency),
        method: peak.method,
        length_spread: deviation(&lengths).map(|spread| spread.hypot(shifted / length(peak.frequency))),
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

    /// Returns grooves along y whose period wanders by a tenth around 1 µm, 50 µm across, tilted and bowed.
    fn wandering(seed: u64, bow: f64) -> HeightField {
        let mut random = Random::new(seed);
        let mut phase = vec![0.0_f64];
        let mut rate = 0.0;
        for _ in 0..500 {
            // An autoregressive rate, correlated over 1 µm.
            rate = 0.9 * rate + 0.08 * random.signed();
            phase.push(phase[phase.len() - 1] + TAU * 0.1 * (1.0 + rate));
        }
        field(500, 100, move |x, y| {
            0.1 * phase[(x / 0.1).round() as usize].sin()
                + 0.01 * x
                + bow * ((x - 25.0) / 25.0).powi(2) * (1.0 + 0.1 * y)
        })
    }

    #[test]
    fn a_period_that_wanders_is_the_middle_of_a_band_whatever_is_subtracted() {
        let mut bands = 0;
        for seed in 1..6 {
            let found: Vec<Period> =
                [0.0, 0.3, 1.0].map(|bow| periods(&wandering(seed, bow))[0].clone()).into();
            let [first, ..] = &found[..] else { unreachable!() };
            bands += usize::from(first.method == PeriodMethod::Band);
            let spread = first.length_spread.unwrap();
            assert!((first.length - 1.0).abs() < 0.1 && spread < 0.08, "{found:?}");
            for other in &found {
                assert!((other.length - first.length).abs() < 0.1 * spread.max(0.01), "{found:?}");
            }
        }
        // One in a few wanders by so little that most of its power is in a line.
        assert!(bands >= 3, "{bands} of 5");
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
