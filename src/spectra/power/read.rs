//! Reads power spectra between their texels, levels and nodes on the CPU, as `shaders/source_mean.glsl` does on the device.

use super::make::{PowerHeader, PowerSpectra};
use super::texture::{PER_TEXEL, interleaved};
use glam::{DVec2, Vec4};

/// Power spectra in the layout that a processor reads fast.
pub struct SpectraReader {
    /// What the numbers mean.
    pub header: PowerHeader,
    // [level][row][column][layer][term of the layer]
    levels: Vec<Vec<Vec4>>,
}

impl SpectraReader {
    /// For `spectra`.
    pub fn new(spectra: &PowerSpectra) -> Self {
        let grid = &spectra.header.grid;
        let level = |(l, values): (usize, &Vec<half::f16>)| {
            let texels = interleaved(values, grid.size_of(l).into_iter().product());
            texels.into_iter().map(Vec4::from).collect()
        };
        Self {
            header: spectra.header.clone(),
            levels: spectra.levels.iter().enumerate().map(level).collect(),
        }
    }

    /// The Chebyshev coefficients at every frequency of `square`, averaged over a normal spread of variance `variance` \[µm⁻²\] around each, in units of the
    /// header's `unit`: `[row][column][layer]`. Frequencies that the samples of the surface do not hold are 0.
    ///
    /// Texels are read from the coarsest level whose blur is well within the one that is asked for. A Gaussian that blurs by the rest is in the weights of the
    /// texels; the wider it is, the more of them are read. Eight reads of two levels, as the shader makes, took 1.8 times as much time for a whole picture of
    /// 64 × 36.
    pub fn read(&self, square: &Square, variance: f64, scratch: &mut ReadScratch, out: &mut [Vec4]) {
        let (level, left) = self.level(variance);
        let ReadScratch { along_x, along_y, row } = scratch;
        self.taps(square, level, 0, left[0], along_x);
        self.taps(square, level, 1, left[1], along_y);
        let [columns, _] = self.header.grid.size_of(level);
        let layers = self.header.terms / PER_TEXEL;
        // Columns that any point reads.
        let begin = along_x.texels[0];
        let end = along_x.texels[along_x.texels.len() - 1] + 1;
        let texels = &self.levels[level];
        row.resize((end - begin) * layers, Vec4::ZERO);
        for (j, out) in out.chunks_exact_mut(square.side * layers).enumerate() {
            row.fill(Vec4::ZERO);
            for ([a, b, c, d], weights) in along_y.fours(j) {
                let held = |row: usize| &texels[(row * columns + begin) * layers..][..(end - begin) * layers];
                let four = held(*a).iter().zip(held(*b)).zip(held(*c)).zip(held(*d));
                for (sum, (((a, b), c), d)) in row.iter_mut().zip(four) {
                    *sum += weighed([*a, *b, *c, *d], weights);
                }
            }
            for (i, out) in out.chunks_exact_mut(layers).enumerate() {
                out.fill(Vec4::ZERO);
                for ([a, b, c, d], weights) in along_x.fours(i) {
                    let held = |column: usize| &row[(column - begin) * layers..][..layers];
                    let four = held(*a).iter().zip(held(*b)).zip(held(*c)).zip(held(*d));
                    for (sum, (((a, b), c), d)) in out.iter_mut().zip(four) {
                        *sum += weighed([*a, *b, *c, *d], weights);
                    }
                }
            }
        }
    }

    /// The coarsest level whose blur is well within that of the orders and of a spread of variance `variance` \[µm⁻²\], and the variance that is left, by axis.
    fn level(&self, variance: f64) -> (usize, [f64; 2]) {
        /// Least ratio of the variance that is asked for to that of the level. The rest blurs the errors of interpolation, too: at ε = 1e-2 a ratio of 1 errs by
        /// 1.1e-2, one of 1.25 by 4e-3 (the test of `make.rs`).
        const WELL_WITHIN: f64 = 1.25;
        let grid = &self.header.grid;
        let asked = self.header.orders_blur.variance.map(|orders| orders + variance);
        let blur = |level: usize, axis: usize| grid.blur.variance[axis] * 4f64.powi(level as i32);
        let is_within = |level: &usize| (0..2).all(|axis| WELL_WITHIN * blur(*level, axis) <= asked[axis]);
        let level = (1..grid.levels).take_while(is_within).last().unwrap_or(0);
        (level, [0, 1].map(|axis| (asked[axis] - blur(level, axis)).max(0.0)))
    }

    /// What every point of `square` reads of `level` along `axis`, where it averages over the variance `left` \[µm⁻²\].
    ///
    /// Texels are made to be read by the grid's kernel, a cubic B-spline of transform sinc⁴ (Unser, "Splines: a perfect fit for signal and image processing",
    /// 1999). A single Gaussian stands for this kernel and the blur together, with the sum of their variances. In its transform, sinc⁴(x) becomes
    /// exp(−2π²x²/3), which is larger by a share of π⁴x⁴/45: 5e-4 at x = 0.12, the standard deviation of the lags that a blur of 1.3 texels leaves.
    fn taps(&self, square: &Square, level: usize, axis: usize, left: f64, taps: &mut AxisTaps) {
        /// Standard deviations within which texels are read: 5e-4 of a Gaussian is beyond.
        const REACH: f64 = 3.5;
        /// Up to this variance of the blur \[texels²\], its Taylor series of two terms holds: w + variance/2 · w″. It errs by (2π²x²·variance)²/2, 4e-4 at x = 0.12.
        const LITTLE: f64 = 0.1;
        let grid = &self.header.grid;
        let held = grid.size_of(level)[axis];
        let spacing = grid.range[axis] / held as f64;
        let left = left / (spacing * spacing);
        let variance = left + grid.kernel.variance();
        let is_blurred = left > LITTLE;
        let sides = if is_blurred { (REACH * variance.sqrt() + 1.0).min(held as f64) as usize } else { 2 };
        taps.count = (2 * sides).next_multiple_of(AT_ONCE);
        taps.texels.clear();
        taps.weights.clear();
        for i in 0..square.side {
            let f = square.first[axis] + square.step * i as f64;
            let place = (f / grid.range[axis] + 0.5) * held as f64 - 0.5;
            let corner = place.floor();
            let first = (corner as i64).saturating_sub(sides as i64 - 1);
            let texel = |i: i64| first.saturating_add(i).clamp(0, held as i64 - 1) as usize;
            taps.texels.extend((0..taps.count as i64).map(texel));
            let begin = taps.weights.len();
            taps.weights.resize(begin + taps.count, 0.0);
            let weights = &mut taps.weights[begin..];
            if f.abs() > self.header.band[axis] {
                continue;
            }
            if is_blurred {
                gaussian(1.0 - sides as f64 - (place - corner), variance, &mut weights[..2 * sides]);
            } else {
                let t = place - corner;
                let four = grid.kernel.weights(t).into_iter().zip(grid.kernel.curvatures(t));
                weights
                    .iter_mut()
                    .zip(four)
                    .for_each(|(weight, (w, curvature))| *weight = (w + 0.5 * left * curvature) as f32);
            }
        }
    }
}

/// Texels that are read at once.
const AT_ONCE: usize = 4;

/// Working arrays of [`SpectraReader::read`].
#[derive(Default)]
pub struct ReadScratch {
    along_x: AxisTaps,
    along_y: AxisTaps,
    // Sums along f_y, of all columns that any point reads: [column][layer].
    row: Vec<Vec4>,
}

/// What each point of a square reads along an axis.
#[derive(Default)]
struct AxisTaps {
    /// Texels of a point, a multiple of [`AT_ONCE`].
    count: usize,
    /// `[point][texel]`: their numbers; beyond an end of the level, that of the last.
    texels: Vec<usize>,
    /// `[point][texel]`.
    weights: Vec<f32>,
}

impl AxisTaps {
    /// What point `i` reads, four at a time: numbers of texels and their weights.
    #[inline]
    fn fours(&self, i: usize) -> impl Iterator<Item = (&[usize; AT_ONCE], &[f32; AT_ONCE])> {
        let own = i * self.count..(i + 1) * self.count;
        let (texels, _) = self.texels[own.clone()].as_chunks();
        let (weights, _) = self.weights[own].as_chunks();
        texels.iter().zip(weights)
    }
}

/// Weights of a Gaussian of variance `variance` at `from`, `from` + 1 and so on, whose sum is 1.
fn gaussian(from: f64, variance: f64, weights: &mut [f32]) {
    // Each is the one before times a factor that itself shrinks by a constant one.
    let mut weight = (-0.5 * from * from / variance).exp();
    let mut factor = (-0.5 * (2.0 * from + 1.0) / variance).exp();
    let growth = (-1.0 / variance).exp();
    let mut sum = 0.0;
    for slot in &mut *weights {
        *slot = weight as f32;
        sum += weight;
        weight *= factor;
        factor *= growth;
    }
    let norm = (1.0 / sum) as f32;
    weights.iter_mut().for_each(|weight| *weight *= norm);
}

/// Σ weight·texel.
#[inline]
fn weighed(texels: [Vec4; AT_ONCE], weights: &[f32; AT_ONCE]) -> Vec4 {
    let [a, b, c, d] = texels;
    a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3]
}

/// A square of frequencies, or of places −(u, v).
#[derive(Clone, Copy, Debug)]
pub struct Square {
    /// The one with the least x and y.
    pub first: DVec2,
    /// From one to the next along either axis.
    pub step: f64,
    /// How many along a side.
    pub side: usize,
}

impl Square {
    /// One point alone.
    pub fn point(at: DVec2) -> Self {
        Self { first: at, step: 0.0, side: 1 }
    }

    /// Every point `factor` times as far from the origin.
    pub fn scaled(self, factor: f64) -> Self {
        Self { first: self.first * factor, step: self.step * factor, ..self }
    }

    /// Largest distance of a point from the origin.
    pub fn farthest(&self) -> f64 {
        self.first.abs().max(self.last().abs()).length()
    }

    /// Smallest distance from the origin of anything between the points.
    pub fn nearest(&self) -> f64 {
        DVec2::ZERO.clamp(self.first, self.last()).length()
    }

    /// Point number `i`, row by row.
    pub fn place(&self, i: usize) -> DVec2 {
        self.first + self.step * DVec2::new((i % self.side) as f64, (i / self.side) as f64)
    }

    fn last(&self) -> DVec2 {
        self.first + self.step * (self.side - 1) as f64
    }
}
