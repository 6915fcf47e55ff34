//! Spectra on the lines of a grid, for colours alone.
//!
//! A direction (u, v) and all wavelengths make a ray through the plane of frequencies, f = −(u, v)/λ. A colour is an integral along
//! it, and where its nodes stand is free: they are put where the ray crosses the lines f_x = m/L_x of a grid (lines f_y = m/L_y
//! where |v| > |u|). Across the lines nothing is interpolated then, so that they may stand as far apart as the nodes do, and what is
//! read of a node are neighbours along one line.
//!
//! Rays of small |u| and |v| cross few lines; finer ones are there for them (`near.rs`).

use super::kernel::{self, Kernel, SPECKLE};
use super::near::{Centre, FAR_END, Near, OCTAVES};
use super::texels::Texels;
use super::transform::{PaddedAxis, Pair, Samples};
use rayon::prelude::*;
use serde::Serialize;

/// How lines are spaced, and which rays they serve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spacing {
    /// Level of the aliases that nodes may leave (see [`crate::optics::quadrature::Rule`]).
    pub level: f64,
    /// max(|u|, |v|) from which on a ray crosses enough lines.
    pub from: f64,
    /// L/σ across the lines.
    across: f64,
    kernel: Kernel,
    /// L/σ along them.
    along: f64,
}

impl Spacing {
    /// Lines for a Gaussian of standard deviation `sigma` \[µm\], L = `across`·σ, whose nodes leave aliases of `level` and are at least
    /// `fewest` over `span` \[µm⁻¹\], and which are read along themselves with a relative intensity error of `interpolation`. `None`
    /// where hardly a ray would cross enough.
    pub fn new(
        sigma: f64,
        (level, across): (f64, f64),
        fewest: f64,
        span: f64,
        interpolation: f64,
    ) -> Option<Self> {
        /// Beyond, the centre is most of the plane.
        const MOST: f64 = 0.5;
        let from = fewest / (span * across * sigma);
        let (kernel, along) = kernel::along_lines(interpolation);
        (across > 0.0 && from <= MOST).then_some(Self { level, from, across, kernel, along })
    }

    /// Texels that are read of a node for `pairs` pairs of terms, where 16 bits hold them.
    pub(super) fn texels_of_a_node(&self, pairs: usize) -> usize {
        let beside = grouped(pairs, true, pairs);
        self.kernel.texels() * if beside.is_multiple_of(2) { pairs.div_ceil(2) } else { pairs }
    }

    /// RMS relative intensity error of reading along the lines.
    pub fn interpolation_error(&self) -> f64 {
        SPECKLE * self.kernel.amplitude_error(self.along)
    }

    /// The largest frequency of either axis that rays near the mirror direction are read at \[µm⁻¹\], for wavelengths from `shortest` \[µm\].
    pub(super) fn centre(&self, sigma: f64, shortest: f64) -> f64 {
        /// Lines of the finest octave beyond the visible range, and points beside them.
        const BEYOND: f64 = 4.0;
        self.from / shortest + BEYOND / (self.across.min(self.along) * sigma)
    }

    /// The transforms' axes: for lines of constant f_x, and of constant f_y.
    pub(super) fn axes(&self, own: &[Samples; 2], sigma: f64, band: [f64; 2]) -> [[PaddedAxis; 2]; 2] {
        [0, 1].map(|set| {
            [0, 1].map(|axis| {
                let (ratio, kernel) =
                    if axis == set { (self.across, None) } else { (self.along, Some(self.kernel)) };
                PaddedAxis::new(&own[axis], sigma, ratio * sigma, kernel, band[axis])
            })
        })
    }
}

/// Spectra of the basis functions on lines of constant f_x and on lines of constant f_y.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines {
    /// max(|u|, |v|) from which on they are read.
    pub from: f64,
    /// Level of the nodes' aliases.
    pub level: f64,
    /// L of both sets across the lines \[µm\]: lines stand at m/L.
    pub across: [f64; 2],
    /// L of both sets along the lines \[µm\].
    pub along: [f64; 2],
    /// How to read between texels of a line.
    pub kernel: Kernel,
    /// Points of a line, and lines, of either set: as many as the larger takes.
    pub size: [usize; 2],
    /// The point and the line of f = 0.
    pub origin: [usize; 2],
    /// The same of the finer lines of each octave of rays below `from`.
    pub near: Vec<[usize; 2]>,
    /// Pairs of terms that stand beside each other at a point, so that they come from one place of the memory; one behind the last
    /// is 0.
    pub grouped: usize,
    /// RGBA texels: set by set, group by group of pairs, band by band of z, line by line, point by point, pair by pair.
    pub texels: Texels,
}

/// How many of `pairs` pairs of terms stand beside each other where `most` texels can.
fn grouped(pairs: usize, half: bool, most: usize) -> usize {
    let even = pairs.next_multiple_of(2);
    // Two of them to a texel, which is worth up to a fifth of the memory.
    if half && 5 * even <= 6 * pairs { even.min(2 * most) } else { pairs.min(most) }
}

/// What lines take of a texture.
#[derive(Clone, Debug)]
pub(super) struct Extent {
    /// Bins of each set's axes: [set][across, along].
    bins: [[usize; 2]; 2],
    /// L of both sets across the lines, and along them \[µm\].
    across: [f64; 2],
    along: [f64; 2],
    /// The point and the line of f = 0.
    origin: [usize; 2],
    near: Near,
    half_plane: bool,
}

impl Extent {
    /// For `axes` of `spacing` and wavelengths from `shortest` \[µm\]; of real functions on the half plane where `half_plane`.
    pub(super) fn new(
        spacing: &Spacing,
        axes: &[[PaddedAxis; 2]; 2],
        shortest: f64,
        half_plane: bool,
    ) -> Self {
        let [x_lines, y_lines] = axes;
        let (across, along) = ([&x_lines[0], &y_lines[1]], [&x_lines[1], &y_lines[0]]);
        let bins = [0, 1].map(|set| [across[set].bins, along[set].bins]);
        let largest = |which: usize| bins[0][which].max(bins[1][which]);
        let lines = if half_plane { largest(0) + 1 } else { 2 * largest(0) + 1 };
        let [across, along] = [across, along].map(|axes| axes.map(|axis| axis.length));
        let above = [2 * largest(1) + 1, lines];
        let near = Near::new((spacing.from, shortest), across, along, spacing.kernel, half_plane, above);
        let origin = [largest(1), if half_plane { 0 } else { largest(0) }];
        Self { bins, across, along, origin, near, half_plane }
    }

    /// Points of a line, and lines.
    pub(super) fn size(&self) -> [usize; 2] {
        self.near.size
    }
}

/// Lines that are being made.
pub(super) struct Maker {
    lines: Lines,
    extent: Extent,
    bands: usize,
    /// Layers of both sets, `[set][pair × bands + band]`.
    made: [Vec<Vec<f32>>; 2],
}

impl Maker {
    /// Of `extent` by `spacing`, in so many `bands`.
    pub(super) fn new(spacing: &Spacing, extent: Extent, bands: usize) -> Self {
        Self {
            lines: Lines {
                from: spacing.from,
                level: spacing.level,
                across: extent.across,
                along: extent.along,
                kernel: spacing.kernel,
                size: extent.size(),
                origin: extent.origin,
                near: extent.near.origins.clone(),
                grouped: 1,
                texels: Texels::zeroed(false, 0),
            },
            extent,
            bands,
            made: [Vec::new(), Vec::new()],
        }
    }

    /// Takes the next pair of terms in, as transformed for set number `set` and for the plane's `centre`.
    pub(super) fn add(&mut self, set: usize, pair: &Pair, centre: &Centre<'_>) {
        let [points, rows] = self.lines.size;
        let Extent { bins, across: lengths, along: point_lengths, origin, near, half_plane } = &self.extent;
        let [across, along] = bins[set];
        let first_line = if *half_plane { 0 } else { -(across as i64) };
        let mut texels = vec![0f32; points * rows * 4];
        texels.par_chunks_mut(points * 4).enumerate().for_each(|(row, out)| {
            let line = row as i64 - origin[1] as i64;
            if line < first_line || line > across as i64 {
                return;
            }
            let line = (line + across as i64) as usize;
            for point in 0..=2 * along {
                let [a, b] = if set == 0 { pair.at(line, point) } else { pair.at(point, line) };
                let texel = [a.re as f32, a.im as f32, b.re as f32, b.im as f32];
                out[(origin[0] - along + point) * 4..][..4].copy_from_slice(&texel);
            }
        });
        near.fill(set, (lengths[set], point_lengths[set]), centre, &mut texels);
        self.made[set].push(texels);
    }

    /// Whether 16 bits hold all of them.
    pub(super) fn fit_halves(&self) -> bool {
        self.made.par_iter().flatten().all(|layer| Texels::fit_halves(layer))
    }

    /// The lines of `pairs` pairs of terms in each band, in 16 bits where `half`, no row longer than `side_limit` texels.
    pub(super) fn finish(self, pairs: usize, half: bool, side_limit: usize) -> Lines {
        let Self { mut lines, bands, made, .. } = self;
        let [points, rows] = lines.size;
        lines.grouped = grouped(pairs, half, (side_limit / points).max(1));
        lines.texels = Texels::zeroed(half, lines.layers(pairs, bands) * points * rows * lines.grouped * 4);
        let texel = if half { 8 } else { 16 };
        let mut room = lines.texels.bytes_mut().chunks_mut(points * rows * lines.grouped * texel);
        for mut set in made {
            for first in (0..pairs).step_by(lines.grouped) {
                for band in 0..bands {
                    // Taken one after the other, so that no more than one group exists twice.
                    let own: Vec<Texels> = (first..pairs.min(first + lines.grouped))
                        .map(|pair| Texels::of(half, std::mem::take(&mut set[pair * bands + band])))
                        .collect();
                    let Some(layer) = room.next() else { continue };
                    layer.par_chunks_mut(lines.grouped * texel).enumerate().for_each(|(place, out)| {
                        for (out, own) in out.chunks_mut(texel).zip(&own) {
                            out.copy_from_slice(&own.bytes()[place * texel..][..texel]);
                        }
                    });
                }
            }
        }
        lines
    }
}

impl Lines {
    /// Whether shaders read two pairs at once: numbers of 16 bits, in texels of 16 bytes.
    pub fn are_packed(&self) -> bool {
        self.texels.is_half() && self.grouped.is_multiple_of(2)
    }

    /// max(|u|, |v|) that rays nearer to the mirror direction are taken for.
    pub fn nearest(&self) -> f64 {
        self.from * FAR_END * f64::from(-(OCTAVES as i32)).exp2()
    }

    /// Where the ray along |(u, v)| = `uv` crosses lines: the set, and lines per unit of wavenumber \[µm\].
    pub fn crossed(&self, uv: [f64; 2]) -> (usize, f64) {
        let set = usize::from(uv[1] > uv[0]);
        let reach = uv[set];
        if reach >= self.from {
            return (set, reach * self.across[set]);
        }
        let reach = reach.max(self.nearest());
        let octave = ((self.from / reach).log2() as i32).clamp(0, OCTAVES as i32 - 1);
        (set, reach * self.across[set] * f64::from(octave + 1).exp2())
    }

    /// Layers of the texture, of `pairs` pairs of terms in each of `bands` bands.
    pub fn layers(&self, pairs: usize, bands: usize) -> usize {
        2 * bands * pairs.div_ceil(self.grouped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pairs_share_a_texel_where_that_takes_little_room() {
        // Pairs, 16 bits, texels of a row for each point; pairs side by side.
        for (pairs, half, most, together) in [
            (2, true, 4, 2),
            (5, true, 4, 6),
            (5, true, 2, 4),
            (5, true, 1, 2),
            (3, true, 4, 3),
            (1, true, 4, 1),
            (5, false, 4, 4),
            (2, false, 1, 1),
        ] {
            assert_eq!(grouped(pairs, half, most), together, "{pairs} pairs, {most} texels");
        }
    }
}
