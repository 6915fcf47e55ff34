//! Relation of heights at a distance: autocorrelation length and texture direction.

use super::height_spectrum::{SurfaceSpectrum, half_transform};
use crate::error::Result;
use crate::surface::si::metres_of_option;
use crate::surface::{HeightField, Levelling};
use rayon::prelude::*;
use rustfft::{FftPlanner, num_complex::Complex};
use serde::Serialize;
use std::f64::consts::PI;

/// Spatial parameters of ISO 25178-2:2021.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Texture {
    /// Autocorrelation length Sal (4.3.2): the shortest distance, over all directions, at which the autocorrelation has fallen to
    /// `THRESHOLD` \[µm\]; `None` if it does not within a quarter of the field.
    #[serde(rename = "sal_m", serialize_with = "metres_of_option")]
    pub sal: Option<f64>,
    /// Texture direction Std (4.3.4): where the angular amplitude density of the spectrum is largest, from +x toward +y, 0 … 180
    /// \[degrees\]. It is the direction across the grooves; `None` for a flat field.
    #[serde(rename = "std_deg")]
    pub std: Option<f64>,
}

/// The share of the variance that the standard takes for uncorrelated.
pub const THRESHOLD: f64 = 0.2;
/// Bins of the angular spectrum, half a degree each.
const ANGLES: usize = 360;

impl Texture {
    /// Measures `field`, whose windowed spectrum is `spectrum`.
    ///
    /// # Errors
    /// Too little memory for the autocorrelation.
    pub fn of(field: &HeightField, spectrum: &SurfaceSpectrum) -> Result<Self> {
        let (low, high) = field.range();
        if low == high {
            return Ok(Self { sal: None, std: None }); // rounding errors would have a direction, too
        }
        Ok(Self { sal: Autocorrelation::of(field)?.shortest_decay(), std: direction(spectrum) })
    }
}

/// Returns the centre of the strongest bin of the angular amplitude density \[degrees\].
fn direction(spectrum: &SurfaceSpectrum) -> Option<f64> {
    /// Below this many cycles over the field an angle is not resolved and the window's main lobe is in the way.
    const FEWEST_CYCLES: f64 = 3.0;
    let [columns, rows] = spectrum.samples;
    let largest = (columns as f64 / spectrum.patch[0]).min(rows as f64 / spectrum.patch[1]) / 2.0;
    let of_column = |mut bins: Vec<f64>, i: usize| {
        for j in 0..rows {
            let [x, y] = spectrum.frequency(i, j);
            let cycles = (x * spectrum.patch[0]).hypot(y * spectrum.patch[1]);
            // A full disc: corners of the square have more frequencies at some angles than at others.
            if cycles >= FEWEST_CYCLES && x.hypot(y) <= largest {
                let angle = y.atan2(x).rem_euclid(PI);
                bins[((angle / PI * ANGLES as f64) as usize).min(ANGLES - 1)] += spectrum.power(i, j).sqrt();
            }
        }
        bins
    };
    let bins = (0..spectrum.half())
        .into_par_iter()
        .fold(|| vec![0.0; ANGLES], of_column)
        .reduce(|| vec![0.0; ANGLES], |a, b| a.iter().zip(&b).map(|(a, b)| a + b).collect());
    let strongest = (0..ANGLES).max_by(|a, b| bins[*a].total_cmp(&bins[*b]))?;
    (bins[strongest] > 0.0).then(|| (strongest as f64 + 0.5) * 180.0 / ANGLES as f64)
}

/// The mean product of heights (about their mean) a distance apart, over all pairs of samples that are so far apart.
struct Autocorrelation {
    /// The largest distance in samples along `x` and `y`.
    reach: [usize; 2],
    pixel_size: [f64; 2],
    /// For distances −reach … reach along `x` and 0 … reach down the rows, over the variance.
    values: Vec<f64>,
}

impl Autocorrelation {
    /// Computes the autocorrelation by the transform of the field padded with zeros up to the largest distance, so that nothing is taken as
    /// periodic.
    fn of(field: &HeightField) -> Result<Self> {
        let level = field.levelled(Levelling::Mean)?;
        let (columns, rows) = (field.columns(), field.rows());
        let reach = [columns / 4, rows / 4];
        let padded = [fast_length(columns + reach[0]), fast_length(rows + reach[1])];
        let row = |r: usize, out: &mut [f64]| {
            if r < rows {
                out[..columns].copy_from_slice(level.row(r));
            }
        };
        let mut transform = half_transform(padded, row)?;
        // Back along y, then along x for the rows that are wanted. The autocorrelation is real.
        let mut planner = FftPlanner::new();
        let (down, across) = (planner.plan_fft_inverse(padded[1]), planner.plan_fft_inverse(padded[0]));
        transform.par_chunks_mut(padded[1]).for_each(|column| {
            column.iter_mut().for_each(|value| *value = Complex::new(value.norm_sqr(), 0.0));
            down.process(column);
        });
        let width = 2 * reach[0] + 1;
        let half = padded[0] / 2 + 1;
        let mut values = vec![0.0; width * (reach[1] + 1)];
        values.par_chunks_mut(width).enumerate().for_each(|(lag_y, out)| {
            // The opposite frequency has the same power, so that its column is read upside down.
            let at = |i: usize| match i < half {
                true => transform[i * padded[1] + lag_y],
                false => transform[(padded[0] - i) * padded[1] + (padded[1] - lag_y) % padded[1]],
            };
            let mut line: Vec<Complex<f64>> = (0..padded[0]).map(at).collect();
            across.process(&mut line);
            for (k, value) in out.iter_mut().enumerate() {
                let lag_x = k as isize - reach[0] as isize;
                let pairs = (columns - lag_x.unsigned_abs()) * (rows - lag_y);
                *value = line[lag_x.rem_euclid(padded[0] as isize) as usize].re / pairs as f64;
            }
        });
        let variance = values[reach[0]];
        if variance > 0.0 {
            values.iter_mut().for_each(|value| *value /= variance);
        }
        Ok(Self { reach, pixel_size: field.pixel_size(), values })
    }

    /// Returns the value at `x` in −reach … reach and `y` in −1 … reach, in samples, clamped to the array.
    fn sample(&self, x: i64, y: i64) -> f64 {
        let [across, down] = self.reach.map(|reach| reach as i64);
        // Opposite distances have the same autocorrelation.
        let (x, y) = if y < 0 { (-x, -y) } else { (x, y) };
        let width = 2 * self.reach[0] + 1;
        self.values[y.min(down) as usize * width + (x.clamp(-across, across) + across) as usize]
    }

    /// Interpolates between the samples, by the cubics through four of them along each axis; `y` is at least 0. A straight line between
    /// samples errs by 3 % of a sinusoid of 12 samples a period, a cubic by 0.1 %.
    fn at(&self, x: f64, y: f64) -> f64 {
        let (i, j) = (x.floor(), y.floor());
        let (across, down) = (cubic(x - i), cubic(y - j));
        let place = |first: f64, tap: usize| first as i64 + tap as i64 - 1;
        let along = |row: usize| -> f64 {
            (0..4).map(|tap| across[tap] * self.sample(place(i, tap), place(j, row))).sum()
        };
        (0..4).map(|row| down[row] * along(row)).sum()
    }

    /// Returns the shortest distance at which the autocorrelation falls to [`THRESHOLD`] \[µm\].
    fn shortest_decay(&self) -> Option<f64> {
        if self.values[self.reach[0]] != 1.0 {
            return None; // a flat field
        }
        // On the way to a sample below it falls to the threshold, and perhaps sooner in another direction.
        let bound = self.nearest_below()?;
        /// Directions in the arc of a sample: ripples on a slow decline touch the threshold in few directions.
        const PER_SAMPLE: f64 = 8.0;
        let [dx, dy] = self.pixel_size;
        let directions = (PI * bound / dx.min(dy) * PER_SAMPLE).ceil() as usize;
        let decays = (0..directions)
            .into_par_iter()
            .filter_map(|n| self.decay(PI * n as f64 / directions as f64, bound));
        Some(decays.reduce(|| bound, f64::min))
    }

    /// Returns the distance of the nearest sample at or below [`THRESHOLD`] \[µm\].
    fn nearest_below(&self) -> Option<f64> {
        let [dx, dy] = self.pixel_size;
        let width = 2 * self.reach[0] + 1;
        let distance = |i: usize| {
            let x = (i % width) as f64 - self.reach[0] as f64;
            (x * dx).hypot((i / width) as f64 * dy)
        };
        let below = (0..self.values.len()).filter(|&i| self.values[i] <= THRESHOLD).map(distance);
        below.min_by(f64::total_cmp)
    }

    /// Returns the first distance in a direction at which the autocorrelation falls to [`THRESHOLD`], if that is within `bound` \[µm\].
    fn decay(&self, angle: f64, bound: f64) -> Option<f64> {
        let [dx, dy] = self.pixel_size;
        let (sin, cos) = angle.sin_cos();
        /// Steps in a sample: fine enough that the straight line between two is the surface between.
        const PER_SAMPLE: f64 = 4.0;
        let step = dx.min(dy) / PER_SAMPLE;
        let mut before = 1.0;
        for n in 1.. {
            let distance = n as f64 * step;
            let (x, y) = (distance * cos / dx, distance * sin / dy);
            if distance - step > bound || x.abs() > self.reach[0] as f64 || y > self.reach[1] as f64 {
                return None;
            }
            let here = self.at(x, y);
            if here <= THRESHOLD {
                return Some(distance - step * (THRESHOLD - here) / (before - here));
            }
            before = here;
        }
        None
    }
}

/// Returns the weights of the samples at −1, 0, 1 and 2 of the cubic through them, at `t` in 0 … 1 (Lagrange).
fn cubic(t: f64) -> [f64; 4] {
    [
        t * (t - 1.0) * (2.0 - t) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        (t + 1.0) * t * (2.0 - t) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ]
}

/// Returns the next length of at least `n` with no prime factor above 5: such transforms are fast.
fn fast_length(n: usize) -> usize {
    let smooth = |n: &usize| {
        let mut rest = *n;
        for factor in [2, 3, 5] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    (n.max(1)..).find(smooth).unwrap_or(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::surface::statistics::tests::field;
    use std::f64::consts::TAU;

    #[test]
    fn the_autocorrelation_is_the_plain_mean_of_products() {
        let mut random = Random::new(12);
        let heights: Vec<f64> = (0..20 * 15).map(|_| random.signed()).collect();
        let f = HeightField::new(20, 15, [0.1, 0.2], heights).unwrap();
        let level = f.levelled(Levelling::Mean).unwrap();
        let found = Autocorrelation::of(&f).unwrap();
        let plain = |lag_x: isize, lag_y: usize| {
            let mut products = Vec::new();
            for r in 0..15 - lag_y {
                for c in 0..20_isize {
                    if let Some(other) = usize::try_from(c + lag_x).ok().filter(|c| *c < 20) {
                        products.push(level.row(r)[c as usize] * level.row(r + lag_y)[other]);
                    }
                }
            }
            products.iter().sum::<f64>() / products.len() as f64
        };
        for (x, y) in [(0, 0), (5, 0), (-5, 3), (2, 3), (-1, 1)] {
            let expected = plain(x, y) / plain(0, 0);
            assert!((found.at(x as f64, y as f64) - expected).abs() < 1e-12, "{x}, {y}");
        }
    }

    #[test]
    fn a_sinusoid_falls_to_a_fifth_across_its_grooves() {
        // The autocorrelation is cos(2π t/d): 0.2 at d·acos(0.2)/2π. The field has 200 periods, so that a partial period at the end hardly
        // counts.
        let wave = field(4000, 8, |x, _| (TAU * x / 2.0).sin());
        let texture = Texture::of(&wave, &SurfaceSpectrum::windowed(&wave).unwrap()).unwrap();
        let expected = 2.0 * 0.2_f64.acos() / TAU;
        assert!((texture.sal.unwrap() / expected - 1.0).abs() < 3e-3, "{texture:?} and not {expected}");
    }

    #[test]
    fn few_samples_a_period_do_as_well() {
        // 12.5 samples a period: straight lines between the samples would be off by more than a percent.
        let wave = field(4000, 8, |x, _| (TAU * x / 1.25).sin());
        let found = Autocorrelation::of(&wave).unwrap().shortest_decay().unwrap();
        let expected = 1.25 * 0.2_f64.acos() / TAU;
        assert!((found / expected - 1.0).abs() < 3e-3, "{found} and not {expected}");
    }

    #[test]
    fn ripples_that_touch_the_threshold_in_few_directions_are_found() {
        // Waviness falls to a fifth far out; ripples of a second direction dip below it sooner, each time in a narrow place.
        let mut random = Random::new(4);
        let phases: Vec<f64> = (0..6).map(|_| PI * random.signed()).collect();
        let rough = field(300, 600, |x, y| {
            let slow = (0..6).map(|i| (0.11 * (i + 1) as f64 * x + 0.07 * i as f64 * y + phases[i]).sin());
            slow.sum::<f64>() + 0.9 * (TAU * (x + 0.03 * y) / 1.1).sin() * (TAU * y / 9.0).cos()
        });
        let found = Autocorrelation::of(&rough).unwrap();
        let (sal, nearest) = (found.shortest_decay().unwrap(), found.nearest_below().unwrap());
        assert!(sal <= nearest, "{sal} of {nearest}");
        // Every crossing along rays ten times as close is at least as far.
        let finer = (0..20_000).filter_map(|n| found.decay(PI * f64::from(n) / 2e4, nearest));
        let least = finer.min_by(f64::total_cmp).unwrap();
        assert!((sal / least - 1.0).abs() < 1e-3, "{sal} and not {least}");
    }

    #[test]
    fn the_direction_is_across_the_grooves() {
        for degrees in [0.0, 30.0, 77.0, 90.0, 135.0] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let wave = field(200, 400, |x, y| (TAU * (x * cos - y * sin) / 0.9).sin());
            let std = direction(&SurfaceSpectrum::windowed(&wave).unwrap()).unwrap();
            let off = (std - degrees + 90.0).rem_euclid(180.0) - 90.0;
            assert!(off.abs() < 1.1, "{std} and not {degrees}");
        }
    }

    #[test]
    fn flat_fields_have_neither_and_a_slope_does_not_decay() {
        let flat = field(40, 40, |_, _| 0.3);
        let texture = Texture::of(&flat, &SurfaceSpectrum::windowed(&flat).unwrap()).unwrap();
        assert_eq!(texture, Texture { sal: None, std: None });
        assert_eq!(Autocorrelation::of(&field(40, 40, |x, _| x)).unwrap().shortest_decay(), None);
    }
}
