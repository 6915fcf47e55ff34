//! Windowed Fourier transforms of functions of the height, at the frequencies of visible directions.
//!
//! Sign and order: P(f) = Σ p(x) e^{+i2πf·x} dx dy, which is rustfft's inverse direction, unnormalised. Position 0 is the patch centre, so
//! neighbouring bins of a centred window are in phase and can be interpolated between.

use super::kernel::Kernel;
use crate::fft_size::fast_size;
use crate::surface::HeightField;
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner, num_complex::Complex64};
use std::f64::consts::PI;
use std::sync::{Arc, Mutex};

/// Samples of a height field along an axis.
#[derive(Clone, Copy, Debug)]
pub struct Samples {
    /// Number of samples over one period.
    pub count: usize,
    /// Distance of samples \[µm\].
    pub spacing: f64,
    /// True if sample 0 has the largest coordinate, as rows of an image have.
    pub upward: bool,
    /// Position of the window's centre from that of the patch \[µm\].
    pub centre: f64,
}

impl Samples {
    /// Returns the samples along x (0) and y (1) of `field` under a window `shift` \[µm\] from the patch's centre.
    pub fn of(field: &HeightField, shift: [f64; 2]) -> [Self; 2] {
        let counts = [field.columns(), field.rows()];
        [0, 1].map(|i| Self {
            count: counts[i],
            spacing: field.pixel_size()[i],
            upward: i == 1,
            centre: shift[i],
        })
    }

    /// Returns one period T \[µm\].
    pub fn period(&self) -> f64 {
        self.count as f64 * self.spacing
    }
}

/// Sample of the patch under the window.
#[derive(Clone, Copy, Debug)]
struct WindowTap {
    /// Index in the transform.
    slot: usize,
    /// Column or row in the patch.
    patch: usize,
    /// Window over the kernel's transform, normalised to Σ g = 1.
    weight: f64,
}

/// One axis of the transform's grid: the patch repeated over a length L, under the Gaussian window.
#[derive(Clone, Debug)]
pub struct PaddedAxis {
    /// Samples over L.
    pub samples: usize,
    /// L \[µm\]; frequency bins are 1/L apart.
    pub length: f64,
    /// Bins −`bins` … `bins` are kept: the band and the kernel's guard.
    pub bins: usize,
    /// Samples within the window.
    taps: Vec<WindowTap>,
    /// Kept bins, from −`bins` on.
    kept: Vec<KeptBin>,
}

/// Bin of the transform that is kept.
#[derive(Clone, Copy, Debug)]
struct KeptBin {
    /// Index in the transform.
    slot: usize,
    /// Factor that moves the origin to the window's centre.
    origin: Complex64,
}

impl KeptBin {
    /// Returns the bins from −`bins` to `bins` of a transform of `samples`, whose origin lies `shift` samples from the window's centre: that of
    /// an even number of samples, for example, lies between two.
    fn all(bins: usize, samples: usize, shift: f64) -> Vec<Self> {
        let bin = |k: i64| Self {
            slot: k.rem_euclid(samples as i64) as usize,
            origin: Complex64::cis(2.0 * PI * k as f64 * shift / samples as f64),
        };
        (-(bins as i64)..=bins as i64).map(bin).collect()
    }
}

impl PaddedAxis {
    /// Returns the axis of `axis_samples` samples under a Gaussian of standard deviation `sigma` \[µm\] on a length of at least `length` \[µm\],
    /// keeping frequencies up to `band` \[µm⁻¹\]; an infinite σ is one period alone without a window. With `kernel` the spectrum may be
    /// read between its bins, and the window ends at L. Without, it is read at its bins alone, and the part of the window beyond L is
    /// folded back, which does not change the values at the bins.
    pub fn new(axis_samples: &Samples, sigma: f64, length: f64, kernel: Option<Kernel>, band: f64) -> Self {
        /// Smallest size of a transform: it costs nothing and still holds every kernel's guard.
        const FEWEST: usize = 8;
        /// End of a folded window in standard deviations: its amplitude is 3e-6 there.
        const REACH: f64 = 5.0;
        let Samples { count, spacing, upward, centre } = *axis_samples;
        let patch = axis_samples.period();
        let windowed = sigma.is_finite();
        let padded = fast_size(((length / spacing).ceil() as usize).max(FEWEST));
        let length = padded as f64 * spacing;
        // The window's centre in samples of the patch, and the distance to the next sample above it.
        let centre = (count as f64 - 1.0) / 2.0 + centre / spacing;
        let middle = centre.ceil() as i64;
        let shift = centre.ceil() - centre;
        let window = |x: f64| match windowed {
            true => (-0.5 * (x / sigma).powi(2)).exp(),
            false => f64::from(u8::from(x.abs() < patch / 2.0)),
        };
        // The continuous integral of g makes the specular peak of a flat surface 1 by definition.
        let scale = spacing / if windowed { (2.0 * PI).sqrt() * sigma } else { patch };
        let places = match kernel {
            Some(_) => padded.div_ceil(2) as i64 - padded as i64..padded.div_ceil(2) as i64,
            None => {
                let reach = (REACH * sigma.min(patch) / spacing).ceil() as i64;
                -reach..reach + 1
            }
        };
        let taps = places
            .map(|place| {
                let x = (place as f64 + shift) * spacing;
                let weight = window(x) * scale / kernel.map_or(1.0, |kernel| kernel.transform(x / length));
                // Position (j + shift)·spacing is column centre + shift + j = middle + j of the patch.
                let index = (middle + place).rem_euclid(count as i64) as usize;
                WindowTap {
                    slot: place.rem_euclid(padded as i64) as usize,
                    patch: if upward { count - 1 - index } else { index },
                    weight,
                }
            })
            .collect();
        let bins = (band * length).ceil() as usize + kernel.map_or(0, Kernel::guard);
        Self { samples: padded, length, bins, taps, kept: KeptBin::all(bins, padded, shift) }
    }

    /// Returns the axis of one period of `axis_samples` samples alone, at the bins m/T of the periodic surface's Fourier series, those up to `band`
    /// \[µm⁻¹\] and `beyond` more.
    pub fn of_period(axis_samples: &Samples, band: f64, beyond: usize) -> Self {
        let Samples { count, upward, .. } = *axis_samples;
        let centre = (count as f64 - 1.0) / 2.0;
        let middle = centre.ceil() as usize;
        let taps = (0..count)
            .map(|slot| {
                let index = (middle + slot) % count;
                let patch = if upward { count - 1 - index } else { index };
                WindowTap { slot, patch, weight: 1.0 / count as f64 }
            })
            .collect();
        let bins = (band * axis_samples.period()).ceil() as usize + beyond;
        let kept = KeptBin::all(bins, count, centre.ceil() - centre);
        Self { samples: count, length: axis_samples.period(), bins, taps, kept }
    }

    /// Returns the number of bins kept along the whole axis, negative frequencies included.
    pub fn kept(&self) -> usize {
        self.kept.len()
    }
}

/// A spectrum on the kept bins, column by column: `values[column * rows + row]`, frequency (column − bins_x)/L_x,
/// (row − bins_y)/L_y.
#[derive(Debug)]
pub struct TermSpectrum {
    values: Vec<Complex64>,
    columns: usize,
    rows: usize,
}

impl TermSpectrum {
    /// Returns the value at a kept column and row.
    pub fn at(&self, column: usize, row: usize) -> Complex64 {
        self.values[column * self.rows + row]
    }

    /// Returns, at kept (column, row), the spectra A and B of the real and imaginary parts of the transformed function: both are Hermitian,
    /// so A(f) = (Z(f) + Z*(−f))/2 and B(f) = (Z(f) − Z*(−f))/2i.
    fn split(&self, column: usize, row: usize) -> [Complex64; 2] {
        let z = self.at(column, row);
        let mirrored = self.at(self.columns - 1 - column, self.rows - 1 - row).conj();
        let half_difference = (z - mirrored) * 0.5;
        [(z + mirrored) * 0.5, Complex64::new(half_difference.im, -half_difference.re)]
    }
}

/// The spectra of two functions of the height.
#[derive(Debug)]
pub enum TermPair {
    /// Spectrum of a complex function whose real and imaginary parts are two real functions.
    Real(TermSpectrum),
    /// Spectra of two complex functions.
    Complex([TermSpectrum; 2]),
}

impl TermPair {
    /// Returns both values at a kept column and row.
    pub fn at(&self, column: usize, row: usize) -> [Complex64; 2] {
        match self {
            Self::Real(both) => both.split(column, row),
            Self::Complex(each) => each.each_ref().map(|spectrum| spectrum.at(column, row)),
        }
    }
}

impl IntoIterator for TermPair {
    type Item = TermSpectrum;
    type IntoIter = std::vec::IntoIter<TermSpectrum>;

    /// Returns the transformed spectra: one of two real functions, two of complex ones.
    fn into_iter(self) -> Self::IntoIter {
        match self {
            Self::Real(both) => vec![both].into_iter(),
            Self::Complex(each) => Vec::from(each).into_iter(),
        }
    }
}

/// Columns that are transformed together: neighbours share cache lines of the rows.
const TOGETHER: usize = 8;

/// Transforms of one height field under one window.
pub struct Transformer<'a> {
    field: &'a HeightField,
    /// Axis along x.
    pub x: PaddedAxis,
    /// Axis along y.
    pub y: PaddedAxis,
    /// Rows of the patch within the window, and the index of every row of the patch among them.
    rows: Vec<usize>,
    row_place: Vec<usize>,
    along_x: Arc<dyn Fft<f64>>,
    along_y: Arc<dyn Fft<f64>>,
    /// Buffers of former transforms: allocating them anew takes longer than a transform takes to fill them.
    spare: Mutex<Vec<Vec<Complex64>>>,
}

impl<'a> Transformer<'a> {
    /// Plans the transforms over the axes `x` and `y` of `field`.
    pub fn new(field: &'a HeightField, x: PaddedAxis, y: PaddedAxis) -> Self {
        let mut planner = FftPlanner::new();
        let (along_x, along_y) = (planner.plan_fft_inverse(x.samples), planner.plan_fft_inverse(y.samples));
        let mut rows: Vec<usize> = y.taps.iter().map(|tap| tap.patch).collect();
        rows.sort_unstable();
        rows.dedup();
        let mut row_place = vec![0; field.rows()];
        rows.iter().enumerate().for_each(|(place, &row)| row_place[row] = place);
        Self { field, x, y, rows, row_place, along_x, along_y, spare: Mutex::default() }
    }

    /// Returns a buffer of `count` arbitrary numbers, to be overwritten.
    fn room(&self, count: usize) -> Vec<Complex64> {
        let found = self.spare.lock().ok().and_then(|mut spare| {
            let place = spare.iter().position(|room| room.len() == count)?;
            Some(spare.swap_remove(place))
        });
        found.unwrap_or_else(|| vec![Complex64::ZERO; count])
    }

    fn keep(&self, room: Vec<Complex64>) {
        // If a panic poisoned the list, only the buffer is lost.
        if let Ok(mut spare) = self.spare.lock() {
            spare.push(room);
        }
    }

    /// Takes back the buffers of spectra of this transformer for the next ones.
    pub fn take_back(&self, spectra: impl IntoIterator<Item = TermSpectrum>) {
        spectra.into_iter().for_each(|spectrum| self.keep(spectrum.values));
    }

    /// Returns the peak host memory of a transformer of `spectra` spectra at a time \[bytes\]: the rows of the patch within the window, at
    /// the kept columns, the kept spectra, and a few lines for each thread. `axis_samples` is along y.
    pub fn memory(x: &PaddedAxis, y: &PaddedAxis, axis_samples: &Samples, spectra: usize) -> u64 {
        let rows = axis_samples.count.min(y.taps.len());
        let lines = 2 * (x.samples + TOGETHER * y.samples) * rayon::current_num_threads();
        (((rows + spectra * y.kept()) * x.kept() + lines) * size_of::<Complex64>()) as u64
    }

    /// Returns the spectra of window · `value`(0 or 1, sample of the patch); real functions share one transform.
    pub fn pair(&self, real: bool, value: impl Fn(usize, usize) -> Complex64 + Sync) -> TermPair {
        if real {
            TermPair::Real(self.spectrum(|i| Complex64::new(value(0, i).re, value(1, i).re)))
        } else {
            TermPair::Complex([0, 1].map(|n| self.spectrum(|i| value(n, i))))
        }
    }

    /// Returns the spectrum of window · `value`(sample of the patch, by row and column), relative to the window's specular peak.
    pub fn spectrum(&self, value: impl Fn(usize) -> Complex64 + Sync) -> TermSpectrum {
        let (x, y) = (&self.x, &self.y);
        let columns = x.kept();
        // Rows of the patch, transformed once however often they repeat; only the kept columns stay.
        let mut rows_done = self.room(self.rows.len() * columns);
        rows_done.par_chunks_mut(columns).enumerate().for_each_init(
            || {
                (
                    vec![Complex64::ZERO; x.samples],
                    vec![Complex64::ZERO; self.along_x.get_inplace_scratch_len()],
                )
            },
            |(buffer, scratch), (row, kept)| {
                let first = self.rows[row] * self.field.columns();
                buffer.fill(Complex64::ZERO);
                for tap in &x.taps {
                    buffer[tap.slot] += value(first + tap.patch) * tap.weight;
                }
                self.along_x.process_with_scratch(buffer, scratch);
                for (out, bin) in kept.iter_mut().zip(&x.kept) {
                    *out = buffer[bin.slot] * bin.origin;
                }
            },
        );
        let mut values = self.room(columns * y.kept());
        values.par_chunks_mut(TOGETHER * y.kept()).enumerate().for_each_init(
            || {
                (
                    vec![Complex64::ZERO; TOGETHER * y.samples],
                    vec![Complex64::ZERO; self.along_y.get_inplace_scratch_len()],
                )
            },
            |(buffer, scratch), (block, out)| {
                let here = out.len() / y.kept();
                buffer.fill(Complex64::ZERO);
                for tap in &y.taps {
                    let begin = self.row_place[tap.patch] * columns + block * TOGETHER;
                    for (c, v) in rows_done[begin..begin + here].iter().enumerate() {
                        buffer[c * y.samples + tap.slot] += *v * tap.weight;
                    }
                }
                self.along_y.process_with_scratch(&mut buffer[..here * y.samples], scratch);
                for (c, column) in out.chunks_mut(y.kept()).enumerate() {
                    for (out, bin) in column.iter_mut().zip(&y.kept) {
                        *out = buffer[c * y.samples + bin.slot] * bin.origin;
                    }
                }
            },
        );
        self.keep(rows_done);
        TermSpectrum { values, columns, rows: y.kept() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_is_the_plain_sum_with_the_origin_at_the_patch_centre() {
        for (columns, rows, shift) in [(7, 6, [0.0; 2]), (6, 5, [0.0; 2]), (6, 7, [0.33, 1.1])] {
            let heights: Vec<f64> = (0..columns * rows).map(|i| ((i * 37 % 11) as f64).sin() * 0.1).collect();
            let field = HeightField::new(columns, rows, [0.2, 0.3], heights).unwrap();
            // Linear deapodisation is divided out again below: the comparison is with the plain window.
            let (sigma, kernel) = (1.0, Kernel::Linear);
            let [x, y] = Samples::of(&field, shift)
                .map(|axis_samples| PaddedAxis::new(&axis_samples, sigma, 10.0, Some(kernel), 1.5));
            let transformer = Transformer::new(&field, x, y);
            let spectrum = transformer.spectrum(|i| Complex64::cis(9.0 * field.heights()[i]));
            let (x, y) = (&transformer.x, &transformer.y);
            for (column, row) in [(x.bins, y.bins), (x.bins + 3, y.bins + 1), (x.bins - 2, y.bins + 4)] {
                let (fx, fy) =
                    ((column as f64 - x.bins as f64) / x.length, (row as f64 - y.bins as f64) / y.length);
                let mut sum = Complex64::ZERO;
                for j in -100i64..100 {
                    for i in -100i64..100 {
                        // Copies of the patch: column 0 at the patch's left edge, row 0 at its top.
                        let px = field.x(0) + i as f64 * 0.2 - shift[0];
                        let py = field.y(0) - j as f64 * 0.3 - shift[1];
                        if px.abs() > x.length / 2.0 || py.abs() > y.length / 2.0 {
                            continue;
                        }
                        let h = field.row(j.rem_euclid(rows as i64) as usize)
                            [i.rem_euclid(columns as i64) as usize];
                        let g = (-(px * px + py * py) / (2.0 * sigma * sigma)).exp()
                            / (kernel.transform(px / x.length) * kernel.transform(py / y.length));
                        sum += Complex64::from_polar(g, 9.0 * h + 2.0 * PI * (fx * px + fy * py));
                    }
                }
                sum *= 0.2 * 0.3 / (2.0 * PI * sigma * sigma);
                let error = (sum - spectrum.at(column, row)).norm();
                assert!(error < 1e-5, "{columns}x{rows} bin {column},{row}: {error:e}");
            }
        }
    }

    #[test]
    fn a_folded_window_has_the_same_spectrum_at_its_bins() {
        let heights: Vec<f64> = (0..35).map(|i| (f64::from(i * 37 % 11)).sin() * 0.1).collect();
        let field = HeightField::new(7, 5, [0.2, 0.3], heights).unwrap();
        let sigma = 1.0;
        let axis_samples = Samples::of(&field, [0.07, -0.4]);
        let spectrum = |lengths: [f64; 2]| {
            let [x, y] = [0, 1].map(|i| PaddedAxis::new(&axis_samples[i], sigma, lengths[i], None, 1.2));
            let transformer = Transformer::new(&field, x, y);
            let values = transformer.spectrum(|i| Complex64::cis(9.0 * field.heights()[i]));
            (values, transformer)
        };
        // 4.8 is 24 samples along x and 16 along y, 9.6 twice as many: every second bin of these is a bin of those.
        let ((folded, f), (whole, w)) = (spectrum([4.8; 2]), spectrum([9.6; 2]));
        assert!((w.x.length / f.x.length - 2.0).abs() < 1e-9 && (w.y.length / f.y.length - 2.0).abs() < 1e-9);
        for (i, j) in [(0i64, 0i64), (1, 2), (-3, 4), (5, -5)] {
            let at = |bins: usize, k: i64| (bins as i64 + k) as usize;
            let folded = folded.at(at(f.x.bins, i), at(f.y.bins, j));
            let whole = whole.at(at(w.x.bins, 2 * i), at(w.y.bins, 2 * j));
            assert!((folded - whole).norm() < 1e-5, "{i},{j}: {folded} {whole}");
            assert!(folded.norm() > 1e-3, "{i},{j}");
        }
    }
}
