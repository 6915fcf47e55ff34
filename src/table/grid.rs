//! Grid of the texels of a colour table, and the averages of its levels.

use serde::{Deserialize, Serialize};

/// Square of texels over (u, v) with levels half an octave apart: levels 2m and 2m + 1 have the texels of mip level m, of which each has half
/// as many along each axis as the one before.
///
/// Level l averages over a Gaussian of the variance s_0² + c² (2ˡ − 1) in u and in v, with c from [`TableGrid::growth`]. So each level is a
/// blur of the one before by 2^(l−1) c², and a linear mixture of two neighbours has any variance between theirs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableGrid {
    /// Texels along a side of level 0, a multiple of 2^(mip levels − 1).
    pub side: usize,
    /// Number of levels, two for each mip level.
    pub levels: usize,
    /// Half the side of the square: texels cover −extent … extent.
    pub extent: f64,
    /// Standard deviation s_0 of u and of v that level 0 averages over.
    pub finest: f64,
    /// Standard deviation c by which level 1 is wider than level 0.
    pub growth: f64,
}

/// Number of levels with the same texels.
pub const LEVELS_OF_MIP: usize = 2;
/// Fewest texels along a side of the coarsest level, and largest number of mip levels.
const FEWEST: usize = 6;
const MOST_MIPS: usize = 8;
/// |(u, v)| is at most 2.
const REACH: f64 = 2.0;

impl TableGrid {
    /// Returns the grid of texels at most `spacing` apart, for averages over standard deviations of (u, v) from `finest` on. `blur` is the
    /// standard deviation of all averaging in level 0, coherence included.
    pub fn new(spacing: f64, finest: f64, blur: f64) -> Self {
        let exact = (2.0 * REACH / spacing).ceil() as usize;
        let mips = ((exact / FEWEST).max(1).ilog2() as usize + 1).min(MOST_MIPS);
        let side = exact.next_multiple_of(1 << (mips - 1)).max(FEWEST);
        // Blurs to the next mip level, which together have √3 of this many of the finest texels, remove everything that half as many texels cannot hold.
        const LEAST_GROWTH: f64 = 0.75;
        let distance = 2.0 * REACH / side as f64;
        // With a growth of `blur`, level 1 would have twice the variance of level 0 and level 2 the interpolation error of level 0. Most footprints stand
        // between levels 0 and 1, where mixtures err by half as much if these are nearer. Interpolation in level 2 errs by 1.3 times as much.
        const GROWTH: f64 = 0.84;
        let growth = (GROWTH * blur).max(LEAST_GROWTH * distance);
        Self { side, levels: LEVELS_OF_MIP * mips, extent: REACH, finest, growth }
    }

    /// Returns true if each mip level has its levels, and half as many texels along a side as the one before.
    pub fn is_sound(&self) -> bool {
        /// Limit of all sides, larger than any side of a texture.
        const LARGEST_SIDE: usize = 1 << 16;
        (1..=MOST_MIPS).contains(&self.mips())
            && self.levels.is_multiple_of(LEVELS_OF_MIP)
            && (1..=LARGEST_SIDE).contains(&self.side)
            && self.side.is_multiple_of(1 << (self.mips() - 1))
    }

    /// Returns the number of mip levels.
    pub fn mips(&self) -> usize {
        self.levels / LEVELS_OF_MIP
    }

    /// Returns the distance between the texels of `level`.
    pub fn spacing(&self, level: usize) -> f64 {
        2.0 * self.extent / self.side_of(level) as f64
    }

    /// Returns the number of texels along a side of `level`.
    pub fn side_of(&self, level: usize) -> usize {
        self.side >> (level / LEVELS_OF_MIP)
    }

    /// Returns u or v of texel `i` of `level`.
    pub fn at(&self, level: usize, i: usize) -> f64 {
        (i as f64 + 0.5) * self.spacing(level) - self.extent
    }

    /// Returns the coarsest level that averages over at most the variance `variance` of u and of v, or the finest.
    pub fn level(&self, variance: f64) -> usize {
        let ratio = ((variance - self.finest.powi(2)) / self.growth.powi(2) + 1.0).max(1.0);
        (ratio.log2() as usize).min(self.levels - 1)
    }

    /// Returns the variance of u and of v that `level` averages over.
    pub fn variance(&self, level: usize) -> f64 {
        self.finest.powi(2) + self.growth.powi(2) * (2f64.powi(level as i32) - 1.0)
    }

    /// Returns the size of all levels with `layers` of four 16-bit numbers \[bytes\].
    pub fn bytes(&self, layers: usize) -> usize {
        (0..self.levels).map(|l| self.side_of(l).pow(2)).sum::<usize>() * layers * 8
    }
}
