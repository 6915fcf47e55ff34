//! Reads power spectra between their texels, levels and nodes: the twin of `shaders/source_mean.glsl`.

use super::make::{Header, PowerSpectra};
use super::texture::{PER_TEXEL, interleaved};
use glam::DVec2;

/// Power spectra in the layout that a processor reads fast.
pub struct Reader {
    /// What the numbers mean.
    pub header: Header,
    // [level][row][column][layer][term of the layer]
    levels: Vec<Vec<[f32; PER_TEXEL]>>,
}

impl Reader {
    /// For `spectra`.
    pub fn new(spectra: &PowerSpectra) -> Self {
        let grid = &spectra.header.grid;
        let level = |(l, values): (usize, &Vec<half::f16>)| {
            interleaved(values, grid.size_of(l).into_iter().product())
        };
        Self {
            header: spectra.header.clone(),
            levels: spectra.levels.iter().enumerate().map(level).collect(),
        }
    }

    /// Whether the samples of the surface hold the frequency `f` \[µm⁻¹\].
    pub fn holds(&self, f: DVec2) -> bool {
        f.x.abs() <= self.header.band[0] && f.y.abs() <= self.header.band[1]
    }

    /// The level, with a fraction, whose blur is that of the orders and of a spread of variance `variance` \[µm⁻²\] around each frequency: a
    /// linear mixture of two blurs has the mean of their variances.
    pub fn level(&self, variance: f64) -> f64 {
        let (finest, orders) = (self.header.grid.blur.variance, self.header.orders_blur.variance);
        let ratio = 0.5 * ((orders[0] + variance) / finest[0] + (orders[1] + variance) / finest[1]);
        level_of_ratio(ratio, self.header.grid.levels)
    }

    /// The Chebyshev coefficients at the frequency `f` \[µm⁻¹\] and `level`, in units of the header's `unit`.
    pub fn read(&self, f: DVec2, level: f64, coefficients: &mut [[f32; PER_TEXEL]]) {
        coefficients.fill([0.0; PER_TEXEL]);
        let lower = (level.floor() as usize).min(self.levels.len() - 1);
        let share = level - lower as f64;
        self.add(f, lower, (1.0 - share) as f32, coefficients);
        if share > 0.0 && lower + 1 < self.levels.len() {
            self.add(f, lower + 1, share as f32, coefficients);
        }
    }

    fn add(&self, f: DVec2, level: usize, share: f32, coefficients: &mut [[f32; PER_TEXEL]]) {
        let grid = &self.header.grid;
        let [columns, rows] = grid.size_of(level);
        let place = (f / DVec2::from_array(grid.range) + 0.5) * DVec2::new(columns as f64, rows as f64) - 0.5;
        let corner = place.floor();
        let (wx, wy) = (grid.kernel.weights(place.x - corner.x), grid.kernel.weights(place.y - corner.y));
        let clamp =
            |i: f64, offset: usize, n: usize| (i as i64 + offset as i64 - 1).clamp(0, n as i64 - 1) as usize;
        let columns_at: [usize; 4] = std::array::from_fn(|i| clamp(corner.x, i, columns));
        let wx = wx.map(|w| w as f32 * share);
        let layers = coefficients.len();
        let values = &self.levels[level];
        for (j, wy) in wy.into_iter().enumerate().filter(|(_, w)| *w != 0.0) {
            let row = clamp(corner.y, j, rows) * columns;
            for (column, wx) in columns_at.iter().zip(wx).filter(|(_, w)| *w != 0.0) {
                let weight = wx * wy as f32;
                let texel = &values[(row + column) * layers..][..layers];
                for (sums, values) in coefficients.iter_mut().zip(texel) {
                    for k in 0..PER_TEXEL {
                        sums[k] += weight * values[k];
                    }
                }
            }
        }
    }
}

/// The level of `levels` whose variance is `ratio` times that of the finest, where each has four times the one before.
pub fn level_of_ratio(ratio: f64, levels: usize) -> f64 {
    let last = (levels - 1) as f64;
    let lower = (0.5 * ratio.max(1.0).log2()).floor().min(last);
    let share = (ratio.max(1.0) / 4f64.powf(lower) - 1.0) / 3.0;
    (lower + share.clamp(0.0, 1.0)).min(last)
}
