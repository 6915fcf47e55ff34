//! Reads power spectra between their texels, levels and nodes: the twin of `shaders/source_mean.glsl`.

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

    /// The level, with the place by variance to the next as its fraction, whose blur is that of the orders and of a spread of variance `variance`
    /// \[µm⁻²\] around each frequency.
    pub fn level(&self, variance: f64) -> f64 {
        let (finest, orders) = (self.header.grid.blur.variance, self.header.orders_blur.variance);
        let ratio = 0.5 * ((orders[0] + variance) / finest[0] + (orders[1] + variance) / finest[1]);
        level_of_ratio(ratio, self.header.grid.levels)
    }

    /// The Chebyshev coefficients at every frequency of `square` and whole `level`, in units of the header's `unit`: `[row][column][layer]`.
    /// Frequencies that the samples of the surface do not hold are 0. `rows` is working room.
    pub fn read(&self, square: &Square, level: usize, rows: &mut Vec<Vec4>, out: &mut [Vec4]) {
        let level = level.min(self.levels.len() - 1);
        let [columns_held, rows_held] = self.header.grid.size_of(level);
        let clamp = |i: i64, held: usize| i.clamp(0, held as i64 - 1) as usize;
        let layers = self.header.terms / PER_TEXEL;
        let width = square.side * layers;
        // Along f_x first, for all texel rows that any frequency reads.
        let columns: [([usize; 4], [f32; 4]); MOST_SIDE] = std::array::from_fn(|i| {
            let (first, weights) = self.place(square, level, 0, i);
            (std::array::from_fn(|t| clamp(first + t as i64, columns_held) * layers), weights)
        });
        let (first_row, last_row) =
            (self.place(square, level, 1, 0).0, self.place(square, level, 1, square.side - 1).0 + 3);
        rows.clear();
        rows.resize((last_row - first_row + 1) as usize * width, Vec4::ZERO);
        for (row, out) in (first_row..=last_row).zip(rows.chunks_exact_mut(width)) {
            let row =
                &self.levels[level][clamp(row, rows_held) * columns_held * layers..][..columns_held * layers];
            for ((texels, weights), out) in columns.iter().zip(out.chunks_exact_mut(layers)) {
                for (layer, out) in out.iter_mut().enumerate() {
                    let [a, b, c, d] = texels;
                    *out = weighed([row[a + layer], row[b + layer], row[c + layer], row[d + layer]], weights);
                }
            }
        }
        for (j, out) in out.chunks_exact_mut(width).enumerate() {
            let (first, weights) = self.place(square, level, 1, j);
            let four = &rows[(first - first_row) as usize * width..][..4 * width];
            let (a, rest) = four.split_at(width);
            let (b, rest) = rest.split_at(width);
            let (c, d) = rest.split_at(width);
            for ((((out, a), b), c), d) in out.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                *out = weighed([*a, *b, *c, *d], &weights);
            }
        }
    }

    /// The first of the four texels around frequency number `i` of `square` along `axis`, and their weights.
    fn place(&self, square: &Square, level: usize, axis: usize, i: usize) -> (i64, [f32; 4]) {
        let grid = &self.header.grid;
        let f = square.first[axis] + square.step * i as f64;
        let place = (f / grid.range[axis] + 0.5) * grid.size_of(level)[axis] as f64 - 0.5;
        let corner = place.floor();
        let held = f64::from(f.abs() <= self.header.band[axis]);
        (corner as i64 - 1, grid.kernel.weights(place - corner).map(|w| (w * held) as f32))
    }
}

/// Σ weight·texel.
#[inline]
fn weighed(texels: [Vec4; 4], weights: &[f32; 4]) -> Vec4 {
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
    /// How many along a side, at most [`MOST_SIDE`].
    pub side: usize,
}

/// Most points along the side of a [`Square`].
pub const MOST_SIDE: usize = 16;

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

    /// Halfway between the first point and the last.
    pub fn middle(&self) -> DVec2 {
        0.5 * (self.first + self.last())
    }

    fn last(&self) -> DVec2 {
        self.first + self.step * (self.side - 1) as f64
    }
}

/// The level of `levels` whose variance is `ratio` times that of the finest, where each has four times the one before.
pub fn level_of_ratio(ratio: f64, levels: usize) -> f64 {
    let last = (levels - 1) as f64;
    let lower = (0.5 * ratio.max(1.0).log2()).floor().min(last);
    let share = (ratio.max(1.0) / 4f64.powf(lower) - 1.0) / 3.0;
    (lower + share.clamp(0.0, 1.0)).min(last)
}
