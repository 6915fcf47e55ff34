//! Grid of the texels of a colour table, and the averages of its levels.

use serde::{Deserialize, Serialize};

/// Square of texels over (u, v) with mip levels: level l has half of the texels of level l − 1 along each axis.
///
/// Level l averages over a Gaussian of the variance s_0² + c² (4ˡ − 1) in u and in v, with c from [`TableGrid::growth`]. So each level is a
/// blur of the one before by 3·4^(l−1) c², and a linear mixture of two neighbours has any variance between theirs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableGrid {
    /// Texels along a side of level 0, a multiple of 2^(levels − 1).
    pub side: usize,
    /// Number of levels.
    pub levels: usize,
    /// Half the side of the square: texels cover −extent … extent.
    pub extent: f64,
    /// Standard deviation s_0 of u and of v that level 0 averages over.
    pub finest: f64,
    /// Standard deviation c by which levels grow.
    pub growth: f64,
}

/// Fewest texels along a side of the coarsest level, and largest number of levels.
const FEWEST: usize = 6;
pub(super) const MOST_LEVELS: usize = 8;
/// |(u, v)| is at most 2.
const REACH: f64 = 2.0;

impl TableGrid {
    /// Returns the grid of texels at most `spacing` apart, for averages over standard deviations of (u, v) from `finest` on. `blur` is the
    /// standard deviation of all averaging in level 0, coherence included. Levels grow by it, so that the interpolation error of each is
    /// that of level 0.
    pub fn new(spacing: f64, finest: f64, blur: f64) -> Self {
        let exact = (2.0 * REACH / spacing).ceil() as usize;
        let levels = ((exact / FEWEST).max(1).ilog2() as usize + 1).min(MOST_LEVELS);
        let side = exact.next_multiple_of(1 << (levels - 1)).max(FEWEST);
        // A blur to the next level of at least this many of the finest texels removes everything that half as many texels cannot hold.
        const LEAST_GROWTH: f64 = 0.75;
        let distance = 2.0 * REACH / side as f64;
        Self { side, levels, extent: REACH, finest, growth: blur.max(LEAST_GROWTH * distance) }
    }

    /// Returns the distance between the texels of `level`.
    pub fn spacing(&self, level: usize) -> f64 {
        2.0 * self.extent / self.side_of(level) as f64
    }

    /// Returns the number of texels along a side of `level`.
    pub fn side_of(&self, level: usize) -> usize {
        self.side >> level
    }

    /// Returns u or v of texel `i` of `level`.
    pub fn at(&self, level: usize, i: usize) -> f64 {
        (i as f64 + 0.5) * self.spacing(level) - self.extent
    }

    /// Returns the level, with a fraction, that averages over the variance `variance` of u and of v.
    pub fn level(&self, variance: f64) -> f64 {
        let ratio = ((variance - self.finest.powi(2)) / self.growth.powi(2) + 1.0).max(1.0);
        let last = (self.levels - 1) as f64;
        let lower = (0.5 * ratio.log2()).floor().min(last);
        let share = (ratio / 4f64.powf(lower) - 1.0) / 3.0;
        (lower + share.clamp(0.0, 1.0)).min(last)
    }

    /// Returns the variance of u and of v that `level` averages over.
    pub fn variance(&self, level: usize) -> f64 {
        self.finest.powi(2) + self.growth.powi(2) * (4f64.powi(level as i32) - 1.0)
    }

    /// Returns the size of all levels with `layers` of four 16-bit numbers \[bytes\].
    pub fn bytes(&self, layers: usize) -> usize {
        (0..self.levels).map(|l| self.side_of(l).pow(2)).sum::<usize>() * layers * 8
    }
}
