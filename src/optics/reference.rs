//! The direct sum in f64: no expansion, no transform, no interpolation. Every faster path is tested against it.
//!
//! P = dx·dy Σ_y Σ_x W_u(x) W_v(y) e^{ikwh(x,y)} for each pair of directions and wavelength, with the window and the
//! copies of the patch folded into W (see [`super::coherence`]). Several wavelengths of one pair are summed together:
//! over wavenumbers of equal distance each sample's phase is a geometric sequence, so it costs one complex product.

use super::coherence::{Coherence, WindowedAxis};
use super::energy::EnergyLimit;
use super::geometry::Pair;
use super::quadrature::{SPAN, Wavelengths};
use super::reflectance::Reflectance;
use super::spectrum::Illuminant;
use crate::error::{Error, Result};
use crate::surface::HeightField;
use glam::DVec3;
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;
use std::sync::Arc;

/// Smallest number of nodes of the colour integral: 1 nm apart on average, the resolution of the colour tables.
const COLOUR_NODES: usize = 401;
/// Autocorrelation of the window beyond which the colour integral may alias.
const ALIAS_LEVEL: f64 = 1e-9;
/// Largest number of nodes of the colour integral: beyond it the sum would take minutes a direction.
const MAX_NODES: usize = 200_000;
/// Rows summed by one task: fixed, so that the order of the sum, and with it the last bit, does not depend on the
/// number of cores.
const ROWS_PER_TASK: usize = 16;
/// Wavelengths whose weights are held at once: bounds memory at a few megabytes per thousand samples of a side.
const WAVELENGTHS_PER_BATCH: usize = 512;

/// Surface under a coherence, ready to be summed.
#[derive(Clone, Debug)]
pub struct Reference {
    field: HeightField,
    coherence: Coherence,
    windows: [u32; 2],
    reflectance: Reflectance,
    limit: Option<Arc<dyn EnergyLimit>>,
}

impl Reference {
    /// Returns the direct sum over `field` through `coherence`, averaged over `windows` = \[n, m\] window centres (1 × 1 is the thesis),
    /// for a surface that reflects by `reflectance` (a number is a refractive index).
    pub fn new(
        field: &HeightField,
        coherence: Coherence,
        windows: [u32; 2],
        reflectance: impl Into<Reflectance>,
    ) -> Self {
        Self { field: field.clone(), coherence, windows, reflectance: reflectance.into(), limit: None }
    }

    /// Returns the same sum within a limit of energy.
    pub fn limited(self, limit: Option<Arc<dyn EnergyLimit>>) -> Self {
        Self { limit, ..self }
    }

    /// Returns the BRDF \[sr⁻¹\] at `wavelength` \[µm\] (\[Single 2014\] B.12). 0 below the horizon and beyond the band limit of the
    /// samples (|u|/λ > 1/(2dx)).
    pub fn brdf(&self, pair: &Pair, wavelength: f64) -> f64 {
        if !pair.above_horizon() {
            return 0.0;
        }
        self.cosine_weighted_spectrum(pair, 1.0 / wavelength, 0.0, 1)[0] / pair.light.z
    }

    /// Returns f·cos θ_i \[sr⁻¹\] at the wavenumbers q_j = `first` + j·`step` \[µm⁻¹\].
    pub fn cosine_weighted_spectrum(&self, pair: &Pair, first: f64, step: f64, count: usize) -> Vec<f64> {
        if !pair.above_horizon() {
            return vec![0.0; count];
        }
        let area = self.coherence.area(self.field.patch_size());
        self.power(pair.uvw(), first, step, count)
            .into_iter()
            .enumerate()
            .map(|(j, power)| {
                let wavelength = 1.0 / (first + j as f64 * step);
                let limit = self.limit.as_ref().map_or(1.0, |limit| limit.single(pair, wavelength));
                self.reflectance.cosine_weighted(pair, wavelength, area, power) / limit
            })
            .collect()
    }

    /// Returns XYZ of f·cos θ_i \[sr⁻¹\] under `illuminant`, normalised to 1 for a perfect mirror image of the light.
    ///
    /// # Errors
    /// A window so large that the colour integral would need more than 200 000 wavelengths.
    pub fn cosine_weighted_xyz(&self, pair: &Pair, illuminant: &Illuminant) -> Result<DVec3> {
        if !pair.above_horizon() {
            return Ok(DVec3::ZERO);
        }
        let count = self.colour_nodes(pair, COLOUR_NODES)?;
        let wavelengths = Wavelengths::catmull_rom(illuminant, count);
        let (first, step) = wavelengths.first_and_step();
        let limit = self.limit.as_ref().map_or(1.0, |limit| limit.colour(pair, illuminant));
        Ok(self.colour_of(pair, &wavelengths, &self.power(pair.uvw(), first, step, count)) / limit)
    }

    /// Returns the height field.
    pub(super) fn field(&self) -> &HeightField {
        &self.field
    }

    /// Returns the coherence.
    pub(super) fn coherence(&self) -> &Coherence {
        &self.coherence
    }

    /// Returns the number of window centres along each axis.
    pub(super) fn windows(&self) -> [u32; 2] {
        self.windows
    }

    /// Returns XYZ of f·cos θ_i from |P|² \[µm⁴\] at each of `wavelengths`, without a limit of energy.
    pub(super) fn colour_of(&self, pair: &Pair, wavelengths: &Wavelengths, power: &[f64]) -> DVec3 {
        let area = self.coherence.area(self.field.patch_size());
        let nodes = wavelengths.wavenumbers.iter().zip(&wavelengths.weights);
        let terms = nodes.zip(power).map(|((q, weight), power)| {
            let wavelength = 1.0 / q;
            *weight * self.reflectance.cosine_weighted(pair, wavelength, area, *power)
        });
        terms.sum()
    }

    /// Returns the number of wavelengths that resolve the response along the ray of `pair`, `base` of them for the colour functions alone.
    ///
    /// # Errors
    /// A window so large that there would be more than 200 000.
    pub(super) fn colour_nodes(&self, pair: &Pair, base: usize) -> Result<usize> {
        let uvw = pair.uvw();
        let patch = self.field.patch_size();
        let extent = |axis| self.coherence.correlation_extent(patch, axis, ALIAS_LEVEL);
        let count =
            base as f64 + SPAN * self.coherence.path(uvw.x.abs() * extent(0), uvw.y.abs() * extent(1));
        if count <= MAX_NODES as f64 {
            return Ok(count as usize);
        }
        Err(Error::limit(
            format!("the colour of one direction would take {count:.0} wavelengths at this coherence"),
            "ask for single wavelengths, or for a shorter coherence",
        ))
    }

    /// Returns |P|² \[µm⁴\], averaged over the windows, at the wavenumbers q_j = `first` + j·`step` \[µm⁻¹\] for one (u, v, w). 0 if a
    /// spatial frequency exceeds 1/(2dx) or 1/(2dy).
    pub fn power(&self, uvw: DVec3, first: f64, step: f64, count: usize) -> Vec<f64> {
        let mut power = Vec::with_capacity(count);
        while power.len() < count {
            let begin = power.len();
            let batch = (count - begin).min(WAVELENGTHS_PER_BATCH);
            power.extend(self.power_of_batch(uvw, first + begin as f64 * step, step, batch));
        }
        power
    }

    fn power_of_batch(&self, uvw: DVec3, first: f64, step: f64, count: usize) -> Vec<f64> {
        let [dx, dy] = self.field.pixel_size();
        let in_band = |j: usize| {
            let q = first + j as f64 * step;
            (uvw.x * q).abs() <= 0.5 / dx && (uvw.y * q).abs() <= 0.5 / dy
        };
        // Wavenumbers increase, so those in the band come first.
        let kept = (0..count).take_while(|&j| in_band(j)).count();
        let q = |j: usize| first + j as f64 * step;
        let columns = self.axis_weights(0, (0..kept).map(|j| 2.0 * PI * q(j) * uvw.x));
        let rows = self.axis_weights(1, (0..kept).map(|j| 2.0 * PI * q(j) * uvw.y));
        let sums = self.window_sums(&columns, &rows, 2.0 * PI * uvw.z * first, 2.0 * PI * uvw.z * step, kept);
        let windows = self.windows[0] as usize * self.windows[1] as usize;
        let cell = (dx * dy).powi(2) / windows as f64;
        let mut power: Vec<f64> =
            sums.chunks(windows).map(|p| p.iter().map(Complex64::norm_sqr).sum::<f64>() * cell).collect();
        power.resize(count, 0.0);
        power
    }

    /// Returns W for each wavelength (given by k·u or k·v) and each window along `axis`: `[wavelength][window]`, by samples in the order of
    /// the height field's columns or rows.
    fn axis_weights(&self, axis: usize, kappas: impl Iterator<Item = f64>) -> Vec<Vec<Split>> {
        let samples = [self.field.columns(), self.field.rows()][axis];
        let spacing = self.field.pixel_size()[axis];
        let windows = self.windows[axis];
        let along = |i: u32| -> Box<dyn Fn(f64) -> Vec<Complex64>> {
            let shift = f64::from(i) / f64::from(windows) * samples as f64 * spacing;
            let along = WindowedAxis { samples, spacing, shift };
            match self.coherence {
                Coherence::Gaussian { length } => {
                    let window = along.gaussian(length / 4.0);
                    Box::new(move |kappa| window.weights(kappa))
                }
                Coherence::Repeats(n) => Box::new(move |kappa| along.repeat_weights(n[axis], kappa)),
            }
        };
        let along: Vec<_> = (0..windows).map(along).collect();
        let weights = |along: &dyn Fn(f64) -> Vec<Complex64>, kappa: f64| {
            let mut weights = along(kappa);
            if axis == 1 {
                weights.reverse(); // row 0 has the largest y
            }
            Split::new(&weights)
        };
        kappas.map(|kappa| along.iter().map(|along| weights(along, kappa)).collect()).collect()
    }

    /// Returns Σ_y Σ_x W_u W_v e^{izh} for z = `z` + j·`z_step`: `[wavelength][x window][y window]` in one row.
    fn window_sums(
        &self,
        columns: &[Vec<Split>],
        rows: &[Vec<Split>],
        z: f64,
        z_step: f64,
        count: usize,
    ) -> Vec<Complex64> {
        let [n, m] = self.windows.map(|w| w as usize);
        // A constant height only turns the phase of P; the mid height keeps the phases small.
        let (low, high) = self.field.range();
        let mid = (low + high) / 2.0;
        let task = |first_row: usize| {
            let mut sums = vec![Complex64::ZERO; count * n * m];
            let last_row = (first_row + ROWS_PER_TASK).min(self.field.rows());
            for row in first_row..last_row {
                let heights = self.field.row(row);
                let mut phase = Split::phases(heights, mid, z);
                let turn = (count > 1).then(|| Split::phases(heights, mid, z_step));
                for j in 0..count {
                    for (i, column) in columns[j].iter().enumerate() {
                        let along_x = column.dot(&phase);
                        for (k, weight) in rows[j].iter().enumerate() {
                            sums[(j * n + i) * m + k] += weight.get(row) * along_x;
                        }
                    }
                    if let Some(turn) = turn.as_ref().filter(|_| j + 1 < count) {
                        phase.multiply(turn);
                    }
                }
            }
            sums
        };
        let starts: Vec<usize> = (0..self.field.rows()).step_by(ROWS_PER_TASK).collect();
        let parts: Vec<Vec<Complex64>> = starts.into_par_iter().map(task).collect();
        parts.into_iter().fold(vec![Complex64::ZERO; count * n * m], |mut total, part| {
            total.iter_mut().zip(part).for_each(|(t, p)| *t += p);
            total
        })
    }
}

/// Complex numbers as two arrays, the layout in which the inner loops run on vector registers.
#[derive(Clone, Debug)]
struct Split {
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Split {
    fn new(values: &[Complex64]) -> Self {
        Self { re: values.iter().map(|c| c.re).collect(), im: values.iter().map(|c| c.im).collect() }
    }

    /// Returns e^{iz(h − mid)} of a row of heights.
    fn phases(heights: &[f64], mid: f64, z: f64) -> Self {
        let (im, re) = heights.iter().map(|h| (z * (h - mid)).sin_cos()).unzip();
        Self { re, im }
    }

    fn get(&self, i: usize) -> Complex64 {
        Complex64::new(self.re[i], self.im[i])
    }

    /// Multiplies each element by its counterpart in `other`.
    fn multiply(&mut self, other: &Self) {
        let parts = self.re.iter_mut().zip(&mut self.im);
        for ((re, im), (c, s)) in parts.zip(other.re.iter().zip(&other.im)) {
            (*re, *im) = (*re * c - *im * s, *re * s + *im * c);
        }
    }

    /// Returns Σ self·other without conjugation, in four interleaved partial sums so that additions need not wait.
    fn dot(&self, other: &Self) -> Complex64 {
        const LANES: usize = 4;
        let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
        let whole = self.re.len() / LANES * LANES;
        for base in (0..whole).step_by(LANES) {
            let (a, b) = (&self.re[base..base + LANES], &self.im[base..base + LANES]);
            let (c, d) = (&other.re[base..base + LANES], &other.im[base..base + LANES]);
            for lane in 0..LANES {
                re[lane] += a[lane] * c[lane] - b[lane] * d[lane];
                im[lane] += a[lane] * d[lane] + b[lane] * c[lane];
            }
        }
        let tail: Complex64 = (whole..self.re.len()).map(|i| self.get(i) * other.get(i)).sum();
        Complex64::new(re.iter().sum(), im.iter().sum()) + tail
    }
}
