//! Power spectra of height fields.

use crate::error::Result;
use crate::memory;
use crate::surface::{HeightField, Levelling};
use rayon::prelude::*;
use rustfft::{FftPlanner, num_complex::Complex};
use std::f64::consts::{LN_2, TAU};

/// The longest side that is transformed; of larger fields the middle is taken, which holds the same frequencies.
const LONGEST_SIDE: usize = 4096;
/// Frequencies above this share of the largest one are taken for noise.
const NOISE_BAND: f64 = 0.8;
/// Frequencies above this share of the largest one belong to structure that is hardly sampled.
const FINE_BAND: f64 = 0.5;

/// The power of heights over spatial frequency. Heights are real, so that the half with f_x ≥ 0 is kept.
pub struct SurfaceSpectrum {
    /// Columns and rows of the field.
    pub samples: [usize; 2],
    /// Side lengths of the field \[µm\].
    pub patch: [f64; 2],
    /// The transform divided so that the squares of all frequencies, both halves, sum to the mean square height \[µm\]; for each f_x
    /// all f_y, as [`SurfaceSpectrum::frequency`] has them.
    transform: Vec<Complex<f64>>,
}

/// Returns the part of `field` that is analysed: all, or the middle of a large field.
pub fn analysed_part(field: &HeightField) -> std::borrow::Cow<'_, HeightField> {
    use std::borrow::Cow;
    let (columns, rows) = (field.columns().min(LONGEST_SIDE), field.rows().min(LONGEST_SIDE));
    if (columns, rows) == (field.columns(), field.rows()) {
        return Cow::Borrowed(field);
    }
    let [left, top] = [(field.columns() - columns) / 2, (field.rows() - rows) / 2];
    let heights = (top..top + rows).flat_map(|row| &field.row(row)[left..left + columns]).copied().collect();
    HeightField::new(columns, rows, field.pixel_size(), heights).map_or(Cow::Borrowed(field), Cow::Owned)
}

impl SurfaceSpectrum {
    /// Returns the spectrum of `field` less its plane under a Hann window along each axis, in units of the mean square height.
    ///
    /// # Errors
    /// Too little memory, heights whose sums are not finite numbers.
    pub fn windowed(field: &HeightField) -> Result<Self> {
        let level = field.levelled(Levelling::Plane)?;
        let [across, down] = [level.columns(), level.rows()].map(hann);
        Self::of(&level, |row, column| down[row] * across[column])
    }

    /// Returns the spectrum of `field` less its mean, taken as one period.
    ///
    /// # Errors
    /// See [`SurfaceSpectrum::windowed`].
    pub fn of_one_period(field: &HeightField) -> Result<Self> {
        let level = field.levelled(Levelling::Mean)?;
        Self::of(&level, |_, _| 1.0)
    }

    fn of(field: &HeightField, weight: impl Fn(usize, usize) -> f64 + Sync) -> Result<Self> {
        let samples = [field.columns(), field.rows()];
        let energy: f64 = (0..samples[1])
            .into_par_iter()
            .map(|row| (0..samples[0]).map(|column| weight(row, column).powi(2)).sum::<f64>())
            .sum();
        let scale = 1.0 / (energy * (samples[0] * samples[1]) as f64).sqrt();
        let row = |row: usize, values: &mut [f64]| {
            for (column, (value, h)) in values.iter_mut().zip(field.row(row)).enumerate() {
                *value = scale * weight(row, column) * h;
            }
        };
        Ok(Self { samples, patch: field.patch_size(), transform: half_transform(samples, row)? })
    }

    /// Returns the number of frequencies along `x` that are kept.
    pub fn half(&self) -> usize {
        self.samples[0] / 2 + 1
    }

    /// Returns the frequency of index `j` along `y` in periods over the patch; y grows up.
    fn cycles_up(&self, j: usize) -> f64 {
        let rows = self.samples[1];
        let signed = if 2 * j > rows { j as f64 - rows as f64 } else { j as f64 };
        -signed
    }

    /// Returns the frequency at `i` along `x` and `j` along `y` \[1/µm\].
    pub fn frequency(&self, i: usize, j: usize) -> [f64; 2] {
        [i as f64 / self.patch[0], self.cycles_up(j) / self.patch[1]]
    }

    /// Returns the complex value at `i`, `j`; `i` beyond the half is read at the opposite frequency.
    pub fn value(&self, i: isize, j: isize) -> Complex<f64> {
        let [columns, rows] = self.samples.map(|n| n as isize);
        let (i, j) = (i.rem_euclid(columns), j.rem_euclid(rows));
        let at = |i: isize, j: isize| self.transform[(i * rows + j) as usize];
        if i < self.half() as isize { at(i, j) } else { at(columns - i, (rows - j) % rows).conj() }
    }

    /// Returns the power at `i`, `j`, equal to that at the opposite frequency \[µm²\].
    pub fn power(&self, i: usize, j: usize) -> f64 {
        self.transform[i * self.samples[1] + j].norm_sqr()
    }

    /// Returns the multiplicity of the frequencies with index `i` along x: 2 if they also stand for their opposite frequencies, otherwise
    /// 1.
    fn weight(&self, i: usize) -> f64 {
        let own_opposite = i == 0 || 2 * i == self.samples[0];
        if own_opposite { 1.0 } else { 2.0 }
    }

    /// Folds `part` of (f_x number, f_y number, weight) over all frequencies but 0.
    pub(super) fn sum<T: Send>(
        &self,
        zero: impl Fn() -> T + Sync + Send,
        part: impl Fn(&mut T, usize, usize, f64) + Sync,
        add: impl Fn(T, T) -> T + Sync + Send,
    ) -> T {
        (0..self.half())
            .into_par_iter()
            .fold(&zero, |mut total, i| {
                let weight = self.weight(i);
                for j in usize::from(i == 0)..self.samples[1] {
                    part(&mut total, i, j, weight);
                }
                total
            })
            .reduce(&zero, add)
    }

    /// Returns the larger of |f_x| and |f_y|, each relative to its Nyquist frequency.
    fn share_of_band(&self, i: usize, j: usize) -> f64 {
        let [columns, rows] = self.samples;
        (2.0 * i as f64 / columns as f64).max(2.0 * self.cycles_up(j).abs() / rows as f64)
    }

    /// Returns the RMS height of white noise as strong as the spectrum in the outer band of the frequencies \[µm\].
    ///
    /// From the median there, which single lines of a grating's spectrum do not move.
    pub fn noise(&self) -> f64 {
        let outer = |found: &mut Vec<f64>, i: usize, j: usize, _: f64| {
            if self.share_of_band(i, j) >= NOISE_BAND {
                found.push(self.power(i, j));
            }
        };
        let mean = mean_of_noise(self.sum(Vec::new, outer, joined));
        (mean * (self.samples[0] * self.samples[1]) as f64).sqrt()
    }

    /// Returns the share of the power at undersampled frequencies; 0 if there is no power.
    pub fn undersampled_share(&self) -> f64 {
        let part = |sums: &mut [f64; 2], i: usize, j: usize, weight: f64| {
            let power = weight * self.power(i, j);
            sums[0] += power;
            sums[1] += if self.share_of_band(i, j) > FINE_BAND { power } else { 0.0 };
        };
        let [all, fine] = self.sum(|| [0.0; 2], part, |a, b| [a[0] + b[0], a[1] + b[1]]);
        if all > 0.0 { fine / all } else { 0.0 }
    }

    /// Returns the mean power of noise at frequencies whose |f| is about `frequency` \[1/µm\], in µm²: from the median, which peaks do not
    /// move.
    pub fn background(&self, frequency: f64) -> f64 {
        /// Half the width of the ring of frequencies, as a share of |f|.
        const WIDTH: f64 = 0.1;
        let half_width = (WIDTH * frequency).max(1.0 / self.patch[0]).max(1.0 / self.patch[1]);
        let near = |found: &mut Vec<f64>, i: usize, j: usize, _: f64| {
            let [x, y] = self.frequency(i, j);
            if (x.hypot(y) - frequency).abs() <= half_width {
                found.push(self.power(i, j));
            }
        };
        mean_of_noise(self.sum(Vec::new, near, joined))
    }

    /// Returns the power spectral density \[µm⁴\] averaged over rings of |f|: (frequency \[1/µm\], density). The rings are as wide as the
    /// coarser spacing of the frequencies and end at the smaller Nyquist frequency.
    pub fn radial(&self) -> Vec<[f64; 2]> {
        let [width, height] = self.patch;
        let ring = (1.0 / width).max(1.0 / height);
        let largest = [0, 1].map(|axis| self.samples[axis] as f64 / 2.0 / self.patch[axis]);
        let count = (largest[0].min(largest[1]) / ring) as usize;
        let part = |rings: &mut Vec<[f64; 2]>, i: usize, j: usize, weight: f64| {
            let [x, y] = self.frequency(i, j);
            if let Some(ring) = rings.get_mut((x.hypot(y) / ring).round() as usize) {
                ring[0] += weight * self.power(i, j);
                ring[1] += weight;
            }
        };
        let add = |a: Vec<[f64; 2]>, b: Vec<[f64; 2]>| {
            a.iter().zip(&b).map(|(a, b)| [a[0] + b[0], a[1] + b[1]]).collect()
        };
        let rings = self.sum(|| vec![[0.0; 2]; count + 1], part, add);
        let density = |(n, [power, count]): (usize, &[f64; 2])| {
            (*count > 0.0).then(|| [n as f64 * ring, power / count * width * height])
        };
        rings.iter().enumerate().skip(1).filter_map(density).collect()
    }
}

fn joined(mut a: Vec<f64>, mut b: Vec<f64>) -> Vec<f64> {
    a.append(&mut b);
    a
}

/// Returns the mean of exponentially distributed powers from their median, which is ln 2 of the mean; 0 for none.
fn mean_of_noise(mut powers: Vec<f64>) -> f64 {
    if powers.is_empty() {
        return 0.0;
    }
    let middle = powers.len() / 2;
    *powers.select_nth_unstable_by(middle, f64::total_cmp).1 / LN_2
}

/// Returns half a period of a raised cosine over `n` samples, 0 at the outer edges of the first and the last.
pub(super) fn hann(n: usize) -> Vec<f64> {
    (0..n).map(|i| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / n as f64).cos()).collect()
}

/// Returns the discrete Fourier transform Σ h e^{−2πi(column·i/columns + row·j/rows)} of real heights for i ≤ columns/2; index j varies
/// fastest. `row` writes the heights of a row.
///
/// # Errors
/// Too little memory.
pub(super) fn half_transform(
    [columns, rows]: [usize; 2],
    row: impl Fn(usize, &mut [f64]) + Sync,
) -> Result<Vec<Complex<f64>>> {
    let half = columns / 2 + 1;
    let bytes = 2 * (half * rows * size_of::<Complex<f64>>()) as u64;
    memory::ensure_room(bytes, "the spectrum of the height field")?;
    let mut planner = FftPlanner::new();
    let (along_rows, along_columns) = (planner.plan_fft_forward(columns), planner.plan_fft_forward(rows));
    // Two real rows are transformed as one complex row: the even part of the result is the first, the odd part the second.
    let mut by_rows = vec![Complex::default(); half * rows];
    by_rows.par_chunks_mut(2 * half).enumerate().for_each(|(pair, out)| {
        let (mut first, mut second) = (vec![0.0; columns], vec![0.0; columns]);
        row(2 * pair, &mut first);
        if 2 * pair + 1 < rows {
            row(2 * pair + 1, &mut second);
        }
        let mut both: Vec<Complex<f64>> =
            first.iter().zip(&second).map(|(a, b)| Complex::new(*a, *b)).collect();
        along_rows.process(&mut both);
        for i in 0..half {
            let (here, opposite) = (both[i], both[(columns - i) % columns].conj());
            out[i] = (here + opposite) * 0.5;
            if let Some(second) = out.get_mut(half + i) {
                *second = (here - opposite) * Complex::new(0.0, -0.5);
            }
        }
    });
    let mut by_columns = vec![Complex::default(); half * rows];
    by_columns.par_chunks_mut(rows).enumerate().for_each(|(i, column)| {
        column.iter_mut().enumerate().for_each(|(row, value)| *value = by_rows[row * half + i]);
        along_columns.process(column);
    });
    Ok(by_columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::surface::statistics::tests::field;

    fn noise(columns: usize, rows: usize, sigma: f64) -> HeightField {
        let mut random = Random::new(3);
        // Uniform in ±1 has the variance 1/3.
        let heights = (0..columns * rows).map(|_| sigma * 3f64.sqrt() * random.signed()).collect();
        HeightField::new(columns, rows, [0.1; 2], heights).unwrap()
    }

    #[test]
    fn the_half_is_that_of_the_plain_sum() {
        for (columns, rows) in [(6, 5), (7, 4), (1, 3), (4, 1)] {
            let f = noise(columns, rows, 1.0);
            let half = half_transform([columns, rows], |r, out| out.copy_from_slice(f.row(r))).unwrap();
            for i in 0..columns / 2 + 1 {
                for j in 0..rows {
                    let plain: Complex<f64> = (0..columns * rows)
                        .map(|n| {
                            let (c, r) = (n % columns, n / columns);
                            let turns = (c * i) as f64 / columns as f64 + (r * j) as f64 / rows as f64;
                            Complex::cis(-TAU * turns) * f.row(r)[c]
                        })
                        .sum();
                    assert!((half[i * rows + j] - plain).norm() < 1e-12, "{columns} x {rows}: {i}, {j}");
                }
            }
        }
    }

    #[test]
    fn all_power_together_is_the_mean_square_height() {
        for (columns, rows) in [(32, 20), (33, 21)] {
            let f = noise(columns, rows, 0.5);
            let spectrum = SurfaceSpectrum::of_one_period(&f).unwrap();
            let all = spectrum.sum(|| 0.0, |sum, i, j, w| *sum += w * spectrum.power(i, j), |a, b| a + b);
            let sq = super::super::HeightParameters::of(&f).sq;
            assert!((all / (sq * sq) - 1.0).abs() < 1e-12, "{columns} x {rows}");
            assert_eq!(spectrum.value(-3, 2), spectrum.value(3, -2).conj());
        }
    }

    #[test]
    fn white_noise_is_found_beside_a_grating_and_not_without_it() {
        let clean = field(256, 256, |x, _| 0.3 * (TAU * x / 0.8).sin());
        assert!(SurfaceSpectrum::windowed(&clean).unwrap().noise() < 1e-6);
        let rough = noise(256, 256, 2e-3);
        let both = clean.heights().iter().zip(rough.heights()).map(|(a, b)| a + b).collect();
        let both = HeightField::new(256, 256, clean.pixel_size(), both).unwrap();
        let found = SurfaceSpectrum::windowed(&both).unwrap().noise();
        assert!((found / 2e-3 - 1.0).abs() < 0.03, "{found}");
    }

    #[test]
    fn structure_of_three_samples_a_period_is_undersampled_and_of_eight_is_not() {
        let share = |period: f64| {
            let wave = field(240, 60, |x, _| (TAU * x / 0.1 / period).sin());
            SurfaceSpectrum::windowed(&wave).unwrap().undersampled_share()
        };
        assert!(share(3.0) > 0.99 && share(8.0) < 1e-3, "{} {}", share(3.0), share(8.0));
    }

    #[test]
    fn the_radial_density_of_white_noise_is_flat_and_integrates_to_its_variance() {
        let rings = SurfaceSpectrum::windowed(&noise(200, 200, 0.1)).unwrap().radial();
        // σ² over the area of the band, (1/0.1 µm)².
        let expected = 0.01 * 0.01;
        let outer = &rings[rings.len() / 2..];
        let mean = outer.iter().map(|r| r[1]).sum::<f64>() / outer.len() as f64;
        assert!((mean / expected - 1.0).abs() < 0.03, "{mean} and not {expected}");
        assert!((rings[rings.len() - 1][0] - 5.0).abs() < 0.1, "the last ring is the largest frequency");
    }
}
