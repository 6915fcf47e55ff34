//! Spectra of the basis functions under one window, in f64, and |P|² read between their bins.

use super::axis::{GAUSSIAN_SHAPE, Look, PATCH_SHAPE, TransformAxis};
use super::basis::HeightBasis;
use super::kernel::{GriddingKernel, TAPS};
use crate::error::Result;
use crate::memory;
use crate::optics::coherence::Coherence;
use crate::surface::HeightField;
use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::PI;
use std::sync::Arc;

/// Bins of the kernel beyond a frequency.
const GUARD: usize = TAPS / 2;

/// Spectra of one surface under one window.
#[derive(Debug)]
pub struct Spectra<'a> {
    basis: &'a HeightBasis,
    kernel: GriddingKernel,
    x: TransformAxis,
    y: TransformAxis,
    /// `[f_x][f_y][term]`, f_x from −`GUARD` bins, f_y from −(bins + `GUARD`): Re, Im in µm².
    texels: Vec<f64>,
    /// Numbers in a texel: two for each term; the number of terms is even, so that four fill whole registers.
    stride: usize,
    /// Registers of this machine.
    arch: Arch,
    /// Band limit of the samples along x and y \[µm⁻¹\].
    band: [f64; 2],
}

impl<'a> Spectra<'a> {
    /// Transforms `field` seen through `coherence` around a centre that is `shift` \[µm\] from the patch's, for frequencies
    /// up to `reach` \[µm⁻¹\].
    ///
    /// # Errors
    /// Too little memory.
    pub fn new(
        field: &HeightField,
        coherence: &Coherence,
        shift: [f64; 2],
        reach: [f64; 2],
        basis: &'a HeightBasis,
    ) -> Result<Self> {
        let spacing = field.pixel_size();
        let band = spacing.map(|d| 0.5 / d);
        let kernel = GriddingKernel::new(match coherence {
            Coherence::Gaussian { .. } => GAUSSIAN_SHAPE,
            Coherence::Repeats(_) => PATCH_SHAPE,
        });
        let axis = |number: usize| {
            let look = Look {
                samples: [field.columns(), field.rows()][number],
                spacing: spacing[number],
                shift: shift[number],
                reach: reach[number].min(band[number]),
                number,
            };
            TransformAxis::new(&look, coherence, &kernel)
        };
        let (x, y) = (axis(0), axis(1));
        let stride = 2 * basis.terms().next_multiple_of(2);
        let (columns, rows) = (x.bins + 2 * GUARD + 1, 2 * (y.bins + GUARD) + 1);
        let samples = field.heights().len() * basis.terms();
        let numbers = columns * rows * stride + y.samples * columns * 4 + samples;
        memory::ensure_room(numbers as u64 * 8, "the spectra of the reference")?;
        let mut spectra = Self {
            basis,
            kernel,
            x,
            y,
            texels: vec![0.0; columns * rows * stride],
            stride,
            arch: Arch::new(),
            band,
        };
        spectra.fill(field);
        Ok(spectra)
    }

    fn fill(&mut self, field: &HeightField) {
        let terms = self.basis.terms();
        let mut functions = vec![0.0; field.heights().len() * terms];
        functions
            .par_chunks_mut(terms)
            .zip(field.heights())
            .for_each(|(out, &height)| self.basis.values(height, out));
        let mut planner = FftPlanner::new();
        // The inverse direction has the sign of P: e^{+2πi f·x}.
        let along_x = planner.plan_fft_inverse(self.x.samples);
        let along_y = planner.plan_fft_inverse(self.y.samples);
        let [dx, dy] = field.pixel_size();
        for pair in 0..terms.div_ceil(2) {
            let value = |sample: usize| {
                let at = |term: usize| if term < terms { functions[sample * terms + term] } else { 0.0 };
                Complex64::new(at(2 * pair), at(2 * pair + 1)) * (dx * dy)
            };
            let rows = self.transform_rows(field.columns(), &value, along_x.as_ref());
            self.transform_columns(&rows, pair, &along_y);
        }
    }

    /// Transforms every row of the window, at the kept bins of f_x. One transform gives the spectra of two real functions, A(f) = (Z(f) +
    /// Z*(−f))/2 and B(f) = (Z(f) − Z*(−f))/2i.
    fn transform_rows(
        &self,
        patch_columns: usize,
        value: &(dyn Fn(usize) -> Complex64 + Sync),
        plan: &dyn Fft<f64>,
    ) -> Vec<[Complex64; 2]> {
        let (x, y) = (&self.x, &self.y);
        let columns = x.bins + 2 * GUARD + 1;
        let mut rows = vec![[Complex64::ZERO; 2]; y.samples * columns];
        rows.par_chunks_mut(columns).enumerate().for_each_init(
            || (vec![Complex64::ZERO; x.samples], vec![Complex64::ZERO; plan.get_inplace_scratch_len()]),
            |(buffer, scratch), (row, kept)| {
                if y.weights[row] == 0.0 {
                    return;
                }
                let first = y.patch_index[row] * patch_columns;
                for (slot, (index, weight)) in buffer.iter_mut().zip(x.patch_index.iter().zip(&x.weights)) {
                    *slot = value(first + index) * (weight * y.weights[row]);
                }
                plan.process_with_scratch(buffer, scratch);
                let at = |k: i64| buffer[k.rem_euclid(x.samples as i64) as usize];
                for (column, slot) in kept.iter_mut().enumerate() {
                    let k = column as i64 - GUARD as i64;
                    let (z, mirrored) = (at(k), at(-k).conj());
                    let difference = (z - mirrored) * 0.5;
                    *slot = [(z + mirrored) * 0.5, Complex64::new(difference.im, -difference.re)];
                }
            },
        );
        rows
    }

    fn transform_columns(&mut self, rows: &[[Complex64; 2]], pair: usize, plan: &Arc<dyn Fft<f64>>) {
        /// Neighbouring columns share cache lines of `rows`.
        const TOGETHER: usize = 8;
        let (x, y, stride) = (&self.x, &self.y, self.stride);
        let columns = x.bins + 2 * GUARD + 1;
        let kept = 2 * (y.bins + GUARD) + 1;
        let lowest = -((y.bins + GUARD) as i64);
        self.texels.par_chunks_mut(TOGETHER * kept * stride).enumerate().for_each_init(
            || {
                (
                    vec![Complex64::ZERO; 2 * TOGETHER * y.samples],
                    vec![Complex64::ZERO; plan.get_inplace_scratch_len()],
                )
            },
            |(buffer, scratch), (block, out)| {
                let here = out.len() / (kept * stride);
                for row in 0..y.samples {
                    let begin = row * columns + block * TOGETHER;
                    for (c, both) in rows[begin..begin + here].iter().enumerate() {
                        for (half, value) in both.iter().enumerate() {
                            buffer[(2 * c + half) * y.samples + row] = *value;
                        }
                    }
                }
                plan.process_with_scratch(&mut buffer[..2 * here * y.samples], scratch);
                for (c, column) in out.chunks_mut(kept * stride).enumerate() {
                    for (k, texel) in column.chunks_mut(stride).enumerate() {
                        let bin = (lowest + k as i64).rem_euclid(y.samples as i64) as usize;
                        for half in 0..2 {
                            let value = buffer[(2 * c + half) * y.samples + bin];
                            let slot = 4 * pair + 2 * half;
                            texel[slot] = value.re;
                            texel[slot + 1] = value.im;
                        }
                    }
                }
            },
        );
    }

    /// Returns |P|² \[µm⁴\] at the wavenumbers q_j = `first` + j·`step` \[µm⁻¹\], like [`crate::optics::reference::Reference::power`] of
    /// one window.
    pub fn power(&self, uvw: DVec3, first: f64, step: f64, count: usize) -> Vec<f64> {
        let mut power = vec![0.0; count];
        let mut coefficients = vec![Complex64::ZERO; self.basis.terms()];
        let mut sums = vec![0.0; self.stride];
        // |P(f, −z)| = |Σ c_n(z)* P_n(f)|, and P_n(−f) = P_n(f)*: for −f the stored values are conjugated instead.
        let conjugate = if uvw.x < 0.0 { 1.0 } else { -1.0 };
        let (u, v) = if uvw.x < 0.0 { (-uvw.x, -uvw.y) } else { (uvw.x, uvw.y) };
        for (j, power) in power.iter_mut().enumerate() {
            let q = first + j as f64 * step;
            let (fx, fy) = (u * q, v * q);
            if fx > self.band[0] || fy.abs() > self.band[1] {
                break; // wavenumbers grow
            }
            self.basis.coefficients(2.0 * PI * q * uvw.z.abs(), &mut coefficients);
            self.read(fx, fy, &mut sums);
            let amplitude: Complex64 = coefficients
                .iter()
                .zip(sums.chunks(2))
                .map(|(c, s)| Complex64::new(c.re, conjugate * c.im) * Complex64::new(s[0], s[1]))
                .sum();
            *power = amplitude.norm_sqr() * self.x.copies(fx) * self.y.copies(fy);
        }
        power
    }

    /// Interpolates the terms at a frequency \[µm⁻¹\], f_x ≥ 0.
    fn read(&self, fx: f64, fy: f64, sums: &mut [f64]) {
        let (px, py) = (fx * self.x.length, fy * self.y.length);
        let (left, below) = (px.floor(), py.floor());
        let (wx, wy) = (self.kernel.weights(px - left), self.kernel.weights(py - below));
        let rows = 2 * (self.y.bins + GUARD) + 1;
        // Tap 0 stands GUARD − 1 bins below the place.
        let column = left as usize + 1;
        let row = (below as i64 + self.y.bins as i64 + 1) as usize;
        let begin = |tap: usize| ((column + tap) * rows + row) * self.stride;
        let lines = std::array::from_fn(|tap| &self.texels[begin(tap)..][..TAPS * self.stride]);
        self.arch.dispatch(TapSums { lines, weights: [wx, wy], stride: self.stride, sums });
    }
}

/// Sums of the texels about a place, with the weights of their columns and rows.
struct TapSums<'a> {
    /// Texels of each column.
    lines: [&'a [f64]; TAPS],
    weights: [[f64; TAPS]; 2],
    stride: usize,
    sums: &'a mut [f64],
}

impl WithSimd for TapSums<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut first = 0;
        for width in [8, 4, 2, 1] {
            while self.stride - first >= width * S::F64_LANES {
                match width {
                    8 => self.sum::<S, 8>(simd, first),
                    4 => self.sum::<S, 4>(simd, first),
                    2 => self.sum::<S, 2>(simd, first),
                    _ => self.sum::<S, 1>(simd, first),
                }
                first += width * S::F64_LANES;
            }
        }
    }
}

impl TapSums<'_> {
    /// Sums N registers of every texel, from its number `first` on.
    #[inline(always)]
    fn sum<S: Simd, const N: usize>(&mut self, simd: S, first: usize) {
        let [wx, wy] = &self.weights;
        let mut totals = [simd.splat_f64s(0.0); N];
        for (column, line) in self.lines.iter().enumerate() {
            for (row, wy) in wy.iter().enumerate() {
                let weight = simd.splat_f64s(wx[column] * wy);
                let (texel, _) = S::as_simd_f64s(&line[row * self.stride + first..][..N * S::F64_LANES]);
                for lane in 0..N {
                    totals[lane] = simd.mul_add_e_f64s(texel[lane], weight, totals[lane]);
                }
            }
        }
        let (sums, _) = S::as_mut_simd_f64s(&mut self.sums[first..][..N * S::F64_LANES]);
        sums.copy_from_slice(&totals);
    }
}
