//! Where the texels of a colour table stand: a square grid over (u, v), fine enough for the tolerance.

use super::Filter;
use super::nodes::NODES;
use super::rings::WAVELENGTH;
use crate::error::{Error, Result};
use crate::memory;
use std::f64::consts::PI;

/// Share of the tolerance that goes to reading between the table's texels, which costs the most to lower. The rest: the
/// nodes in w (0.4), the layers (0.44), the wavelengths (0.24), the rings that the grid is interpolated from (0.2, twice); the
/// squares add up to one.
pub const GRID_SHARE: f64 = 0.7;

/// Largest |u| and |v|.
const EXTENT: f64 = 2.0;
/// Each mip level is exactly half the one before, down to a side that is a small number.
pub const LEVELS: usize = 8;
/// Bytes of a texel: four 16-bit floats.
const TEXEL: u64 = 8;

/// The grid of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Texels along a side: an odd or even multiple of 2^(LEVELS − 1).
    pub side: usize,
    /// Distance of texels, in u and v.
    pub spacing: f64,
    /// Pieces of the range of |w|, with a cubic each.
    pub pieces: usize,
}

impl Grid {
    /// The coarsest grid that reads the response of a Gaussian window of standard deviation `sigma` \[µm\], or of what has it as
    /// its [width](super::aperture::Aperture::width), to the relative error `tolerance`, with `pieces` in |w|.
    ///
    /// |P|² is band-limited: as a function of frequency it has the spectrum exp(−x²/(2σ²)) (in power, over displacements
    /// x), the mirror's peak and speckle alike. Linear interpolation of suitably prefiltered samples (see
    /// [`super::pyramid::prefilter`]) leaves a mean square error of (2πΔf)⁴⟨x⁴⟩/720 along each axis, with ⟨x⁴⟩ = 3σ⁴:
    /// relative, (2πσΔf)² √(6/720) over both.
    pub fn new(sigma: f64, tolerance: f64, pieces: usize) -> Self {
        /// Above it the copies that lie behind the first term of the series count, too.
        const LARGEST: f64 = 0.045;
        let error = (GRID_SHARE * tolerance).min(LARGEST);
        let spacing = WAVELENGTH * (error / (6.0f64 / 720.0).sqrt()).sqrt() / (2.0 * PI * sigma);
        let unit = 1 << (LEVELS - 1);
        // A short window's table is small, and finer than it must be.
        let side = ((2.0 * EXTENT / spacing).ceil() as usize + 2).next_multiple_of(unit).max(2 * unit);
        Self { side, spacing: 2.0 * EXTENT / (side - 2) as f64, pieces }
    }

    /// −u of column `i`, −v of row `i`.
    pub fn at(&self, i: usize) -> f64 {
        (i as f64 - self.centre()) * self.spacing
    }

    /// The finer grid around the mirror direction, which a corner of the finest level holds: no direction is in the corners.
    ///
    /// A picture's one bright pixel may stand where interpolation errs most, at the mirror's peak, and decides the L2 error.
    /// There the error is at most (2πσΔf)²/3, 3.6 times the mean of all directions.
    pub fn near(&self) -> Near {
        /// A square of (1 − 1/√2)/2 = 0.146 of the side lies beyond the disc.
        const PART: usize = 14;
        Near { side: self.side * PART / 100 / 2 * 2, spacing: self.spacing / 2.0 }
    }

    /// The places of the finest level, and those of the finer part.
    pub fn squares(&self) -> [Square; 2] {
        let (near, outer) = (self.near(), self.outer());
        [(self.side, self.spacing), (near.side, near.spacing)].map(|(side, spacing)| Square {
            side,
            spacing,
            outer,
        })
    }

    /// The largest |(u, v)| that is read: linear interpolation reads a texel's diagonal beyond 2.
    pub fn outer(&self) -> f64 {
        EXTENT + 1.5 * self.spacing
    }

    /// The texel of u = v = 0, between two.
    pub fn centre(&self) -> f64 {
        (self.side as f64 - 1.0) / 2.0
    }

    /// Layers of a mip level: X, Y and Z of each piece.
    pub fn layers(&self) -> usize {
        3 * self.pieces
    }

    /// Texels along the sides of the texture that `filter` reads, and its layers: X, Y and Z stand beside each other where
    /// points are read, and in layers of their own where a device filters.
    pub fn texture(&self, filter: Filter) -> ([usize; 2], usize) {
        match filter {
            Filter::Point => ([3 * self.side, self.side], self.pieces),
            Filter::Pixel => ([self.side; 2], self.layers()),
        }
    }

    /// Values of a channel that a texel's cubics are made from.
    pub fn values(&self) -> usize {
        NODES * self.pieces
    }

    /// Bytes of the texture, mip levels included.
    pub fn bytes(&self) -> u64 {
        let side = self.side as u64;
        (0..LEVELS).map(|level| (side >> level).pow(2) * self.layers() as u64 * TEXEL).sum()
    }

    /// Bytes that baking takes on the host: a float for each number, a third of that for rings and finer part, one plane twice,
    /// and the texture.
    pub fn baking_bytes(&self) -> u64 {
        let side = self.side as u64;
        side * side * 4 * (4 * self.values() as u64 + 1) + self.bytes()
    }

    /// Fails where a device with images of at most `max_side` texels and room for `memory` bytes, or this machine, cannot
    /// hold the table. `smaller`: the coherence that would make it so.
    ///
    /// # Errors
    /// With the numbers and what to do.
    pub fn check(&self, max_side: u32, memory: u64, smaller: &str) -> Result<()> {
        let remedy = &format!("ask for a larger --tolerance or {smaller}, or use --method spectral");
        let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        let size = format!("{0} x {0} texels in {1} layers", self.side, self.layers());
        if 3 * self.side > max_side as usize {
            return Err(Error::failed(
                format!(
                    "--method table needs a table of {size}, three beside each other, the device holds {max_side} in a row"
                ),
                remedy.as_str(),
            ));
        }
        if self.bytes() > memory {
            let (needed, there) = (gib(self.bytes()), gib(memory));
            return Err(Error::failed(
                format!(
                    "--method table needs {needed:.2} GiB for {size}, the device has {there:.2} GiB for it"
                ),
                remedy.as_str(),
            ));
        }
        memory::ensure_room(self.baking_bytes(), &format!("--method table (a table of {size})"))
            .map_err(|e| e.or(remedy))
    }
}

/// A square grid around the mirror direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Texels along a side.
    pub side: usize,
    /// Distance of texels, in u and v.
    pub spacing: f64,
}

impl Near {
    /// Largest |u| and |v| that are read: a texel before the last.
    pub fn extent(&self) -> f64 {
        (self.side as f64 / 2.0 - 2.0) * self.spacing
    }
}

/// A grid that samples are interpolated to: places (i, j) at ((i − c) d, (j − c) d) with c = (`side` − 1)/2, d = `spacing`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Square {
    /// Places along a side.
    pub side: usize,
    /// Their distance.
    pub spacing: f64,
    /// Beyond this |(u, v)| there is nothing.
    pub outer: f64,
}

impl Square {
    /// −u of column `i`, −v of row `i`.
    pub fn at(&self, i: usize) -> f64 {
        (i as f64 - (self.side as f64 - 1.0) / 2.0) * self.spacing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_covers_every_direction_and_halves_exactly() {
        for (sigma, tolerance) in [(16.25, 2e-2), (2.0, 1e-1), (0.1, 0.5), (30.0, 1e-2)] {
            let grid = Grid::new(sigma, tolerance, 2);
            assert!(grid.at(0) <= -EXTENT && grid.at(grid.side - 1) >= EXTENT, "{grid:?}");
            assert!((grid.at(0) + grid.at(grid.side - 1)).abs() < 1e-12);
            assert_eq!(grid.side % (1 << (LEVELS - 1)), 0);
        }
    }

    #[test]
    fn the_finer_part_is_where_no_direction_reads() {
        for side in [256, 384, 640, 2432, 8192] {
            let grid = Grid { side, spacing: 4.0 / (side - 2) as f64, pieces: 1 };
            let last = grid.at(grid.near().side - 1);
            assert!(last < 0.0 && last.hypot(last) > grid.outer(), "{side}");
            assert!(grid.near().extent() > 0.1);
        }
    }

    #[test]
    fn spacing_follows_the_window_and_the_root_of_the_tolerance() {
        let side = |sigma, tolerance| Grid::new(sigma, tolerance, 2).side as f64;
        assert!((side(16.0, 1e-2) / side(8.0, 1e-2) - 2.0).abs() < 0.1);
        assert!((side(16.0, 1e-3) / side(16.0, 1e-2) - 10f64.sqrt()).abs() < 0.1);
    }

    #[test]
    fn what_does_not_fit_is_refused_with_the_numbers() {
        let grid = Grid::new(16.25, 2e-2, 2);
        assert!(grid.check(16_384, 1 << 32, "less").is_ok());
        let small = grid.check(1024, 1 << 32, "less").unwrap_err().to_string();
        assert!(small.contains(&grid.side.to_string()) && small.contains("1024"), "{small}");
        let little = grid.check(16_384, 1 << 20, "less").unwrap_err().to_string();
        assert!(little.contains("GiB") && little.contains("--tolerance"), "{little}");
        let host = Grid { side: 1 << 24, ..grid }.check(u32::MAX, u64::MAX, "less").unwrap_err().to_string();
        assert!(host.contains("free") && host.contains("--method spectral"), "{host}");
    }
}
