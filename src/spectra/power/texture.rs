//! The blurred powers on a regular grid of frequencies, in levels of growing blur, as shaders read them.

use super::Blur;
use super::chebyshev::polynomials;
use super::orders::OrderGrid;
use crate::optics::spectrum::MIDDLE;
use crate::precompute::kernel::{Interpolation, Kernel, Transformed};
use crate::surface::transpose::{transpose, transposed};
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;

/// Terms of the series in z that share a texel.
pub const PER_TEXEL: usize = 4;

/// Where the texels of the finest level stand. Level l has 2⁻ˡ of the texels along each axis over the same frequencies, and twice the
/// blur's standard deviation of level l − 1.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FrequencyGrid {
    /// Texels of the finest level along f_x and f_y, a multiple of 2^(levels − 1).
    pub size: [usize; 2],
    /// Range of frequencies along f_x and f_y \[µm⁻¹\], with f = 0 in its middle.
    pub range: [f64; 2],
    /// Number of levels.
    pub levels: usize,
    /// Blur of each order at the finest level.
    pub blur: Blur,
    /// How texels are read.
    pub kernel: Kernel,
}

impl FrequencyGrid {
    /// Texels of level `level`.
    pub fn size_of(&self, level: usize) -> [usize; 2] {
        self.size.map(|n| n >> level)
    }

    /// The kernel along each axis, and the padded lengths.
    pub fn interpolation(&self) -> Interpolation {
        let window = self.blur.window();
        let ratio = |i: usize| self.size[i] as f64 / (self.range[i] * window[i]);
        Interpolation { of: Transformed::Window, kernels: [self.kernel; 2], ratios: [ratio(0), ratio(1)] }
    }

    /// Bytes of all levels of `terms` 16-bit numbers a texel.
    pub fn bytes(&self, terms: usize) -> usize {
        (0..self.levels).map(|l| self.size_of(l).into_iter().product::<usize>()).sum::<usize>() * terms * 2
    }
}

/// The levels: numbers of 16 bits, `[layer][row][column][term of the layer's four]`, rows in growing f_y.
pub type Levels = Vec<Vec<f16>>;

/// Blurs the powers on `orders` and samples them on `grid`. `series` holds one real array over the orders for each term. Beside the levels
/// stands what a stored 1 is worth.
pub fn levels(orders: &OrderGrid, series: &[Vec<f64>], grid: &FrequencyGrid) -> (Levels, f64) {
    let layers = series.len().div_ceil(PER_TEXEL);
    let unit = unit(orders, &series[..1], grid);
    let mut levels: Levels = (0..grid.levels)
        .map(|l| vec![f16::ZERO; grid.size_of(l).into_iter().product::<usize>() * layers * PER_TEXEL])
        .collect();
    // Two real arrays are the parts of one complex one: the blur is real and even, so they stay apart.
    for (pair, terms) in series.chunks(2).enumerate() {
        let lags = autocorrelation(orders, terms);
        for (l, level) in levels.iter_mut().enumerate() {
            let sampled = sample(orders, &lags, grid, l);
            let texels = sampled.len();
            let (layer, slot) = (2 * pair / PER_TEXEL, 2 * pair % PER_TEXEL);
            let begin = layer * texels * PER_TEXEL;
            let own = &mut level[begin..begin + texels * PER_TEXEL];
            own.par_chunks_mut(PER_TEXEL).zip(&sampled).for_each(|(texel, value)| {
                texel[slot] = f16::from_f64(value.re / unit);
                texel[slot + 1] = f16::from_f64(value.im / unit);
            });
        }
    }
    (levels, unit)
}

/// A unit in which the largest constant term of the finest level stands near 3e4: the largest 16-bit float is 65504, and the other terms of a
/// function that is nowhere negative are at most twice the constant.
fn unit(orders: &OrderGrid, constant: &[Vec<f64>], grid: &FrequencyGrid) -> f64 {
    const NEAR: f64 = 3e4;
    let sampled = sample(orders, &autocorrelation(orders, constant), grid, 0);
    let largest = sampled.iter().map(|v| v.re.abs()).fold(0.0, f64::max);
    if largest > 0.0 { largest / NEAR } else { 1.0 }
}

/// The transform of the orders, a function of lag, of one or two arrays: [row][column].
fn autocorrelation(orders: &OrderGrid, terms: &[Vec<f64>]) -> Vec<Complex64> {
    let [columns, rows] = orders.size;
    let second = terms.get(1);
    let mut values: Vec<Complex64> = terms[0]
        .iter()
        .enumerate()
        .map(|(i, &re)| Complex64::new(re, second.map_or(0.0, |values| values[i])))
        .collect();
    transform(&mut values, [columns, rows], false);
    // Order 0 stands at the grid's origin.
    let turn = |k: usize, axis: usize| {
        let (n, origin) = (orders.size[axis], orders.origin[axis]);
        Complex64::cis(2.0 * PI * ((k * origin) % n) as f64 / n as f64)
    };
    let along_x: Vec<Complex64> = (0..columns).map(|k| turn(k, 0)).collect();
    values.par_chunks_mut(columns).enumerate().for_each(|(row, values)| {
        let y = turn(row, 1);
        values.iter_mut().zip(&along_x).for_each(|(value, x)| *value *= x * y);
    });
    values
}

/// The blurred powers at the texels of a level.
fn sample(orders: &OrderGrid, lags: &[Complex64], grid: &FrequencyGrid, level: usize) -> Vec<Complex64> {
    let size = grid.size_of(level);
    let axes = [0, 1].map(|axis| lag_weights(orders, grid, level, axis));
    let [columns, rows] = orders.size;
    let mut values = vec![Complex64::ZERO; size[0] * size[1]];
    values.par_chunks_mut(size[0]).enumerate().for_each(|(row, values)| {
        let (lag_row, weight_y) = (axes[1][row].0, axes[1][row].1);
        if weight_y.norm_sqr() == 0.0 {
            return;
        }
        let source = &lags[(lag_row % rows) * columns..][..columns];
        for (value, (lag, weight)) in values.iter_mut().zip(&axes[0]) {
            *value = source[lag % columns] * weight * weight_y;
        }
    });
    transform(&mut values, size, true);
    values
}

/// For each bin of a level's transform along an axis: the bin of `orders`' transform that it takes, and its weight, the blur over the
/// kernel's transform with the phase of the first texel.
fn lag_weights(
    orders: &OrderGrid,
    grid: &FrequencyGrid,
    level: usize,
    axis: usize,
) -> Vec<(usize, Complex64)> {
    let (texels, count) = (grid.size_of(level)[axis], orders.size[axis]);
    let side = orders.patch[axis];
    // Lags are T/N apart for N orders.
    let step = side / count as f64;
    let variance = grid.blur.variance[axis] * 4f64.powi(level as i32);
    let spacing = grid.range[axis] / texels as f64;
    let first = -0.5 * grid.range[axis] + 0.5 * spacing;
    (0..texels)
        .map(|bin| {
            let signed = if bin < texels.div_ceil(2) { bin as i64 } else { bin as i64 - texels as i64 };
            let lag = signed as f64 * step;
            let gamma = (-2.0 * PI * PI * variance * lag * lag).exp() / grid.kernel.transform(lag * spacing);
            let weight = gamma * step * faded(2.0 * signed.unsigned_abs() as f64 / texels as f64);
            (signed.rem_euclid(count as i64) as usize, Complex64::cis(2.0 * PI * lag * first) * weight)
        })
        .collect()
}

/// What is left of a lag, as a share of the longest that the texels hold. A window that ends at an edge rings over all frequencies, and the rings of
/// bright orders outshine faint directions: a plate lit across its grooves erred by 0.17 at 1e-2, with this by 0.002.
fn faded(share: f64) -> f64 {
    const FIRST: f64 = 0.9;
    match share {
        _ if share <= FIRST => 1.0,
        _ if share >= 1.0 => 0.0,
        _ => (0.5 * PI * (share - FIRST) / (1.0 - FIRST)).cos().powi(2),
    }
}

/// The transform over both axes, in place; `inverse`: e^{+2πi…}. Neither is normalised.
fn transform(values: &mut [Complex64], [columns, rows]: [usize; 2], inverse: bool) {
    let mut planner = FftPlanner::new();
    let mut plan = |n| if inverse { planner.plan_fft_inverse(n) } else { planner.plan_fft_forward(n) };
    let (along_x, along_y) = (plan(columns), plan(rows));
    values.par_chunks_mut(columns).for_each(|row| along_x.process(row));
    let mut turned = transposed(columns, values);
    turned.par_chunks_mut(rows).for_each(|column| along_y.process(column));
    transpose(rows, &turned, values);
}

/// How many orders of equal power would light a picture as evenly: (∫p)²/∫p² of the power p at the finest level, over that of a single order there (the
/// participation ratio). At least about 1, and [`EVEN`] where there is no light. `finest` holds series over 0 … `z_max`; p is that of light of the middle of the
/// spectrum in a usual direction.
pub fn effective_orders(finest: &[f16], grid: &FrequencyGrid, z_max: f64) -> f64 {
    /// |w| where both directions are 30 degrees off the normal.
    const USUAL_W: f64 = 1.7;
    let texels: usize = grid.size_of(0).into_iter().product();
    let area: f64 = (0..2).map(|axis| grid.range[axis] / grid.size_of(0)[axis] as f64).product();
    let one = 4.0 * PI * grid.blur.variance.map(f64::sqrt).into_iter().product::<f64>();
    let layer = texels * PER_TEXEL;
    let mut factors = vec![0.0; finest.len() / texels];
    polynomials((4.0 * PI * USUAL_W / (MIDDLE * z_max) - 1.0).min(1.0), &mut factors);
    let power = |texel: usize| -> f64 {
        let term = |(k, factor): (usize, &f64)| {
            factor * finest[k / PER_TEXEL * layer + texel * PER_TEXEL + k % PER_TEXEL].to_f64()
        };
        factors.iter().enumerate().map(term).sum::<f64>().max(0.0)
    };
    let add = |(sum, squares): (f64, f64), p: f64| (sum + p, squares + p * p);
    let (sum, squares) = (0..texels).map(power).fold((0.0, 0.0), add);
    if squares > 0.0 { (sum * sum / squares * area / one).min(EVEN) } else { EVEN }
}

/// More orders than any picture tells apart.
pub const EVEN: f64 = 1e6;

/// One level as 32-bit floats, [row][column][layer][term of the layer]: the layout that the CPU reads.
pub fn interleaved(level: &[f16], texels: usize) -> Vec<[f32; PER_TEXEL]> {
    let layers = level.len() / (texels * PER_TEXEL);
    let mut floats = vec![0f32; level.len()];
    level.convert_to_f32_slice(&mut floats);
    let mut out = vec![[0f32; PER_TEXEL]; texels * layers];
    out.par_chunks_mut(layers).enumerate().for_each(|(texel, out)| {
        for (layer, four) in out.iter_mut().enumerate() {
            four.copy_from_slice(&floats[(layer * texels + texel) * PER_TEXEL..][..PER_TEXEL]);
        }
    });
    out
}

/// The level of `levels` whose variance is `ratio` times that of the finest, where each has four times the one before.
pub fn level_of_ratio(ratio: f64, levels: usize) -> f64 {
    let last = (levels - 1) as f64;
    let lower = (0.5 * ratio.max(1.0).log2()).floor().min(last);
    let share = (ratio.max(1.0) / 4f64.powf(lower) - 1.0) / 3.0;
    (lower + share.clamp(0.0, 1.0)).min(last)
}
