//! Lines for rays near the mirror direction, which cross too few of the others: octave by octave of max(|u|, |v|), each octave with lines
//! half as far apart as the one above.
//!
//! Each octave reaches half as far as the one above, too, so all have as many lines, and each half as many points. The last serves every ray
//! that is left, as if it were as far from the mirror direction as that octave's nearest: there the spectrum is all but constant.
//!
//! Spectra so near the centre vary slowly; they are read from a transform of the centre alone, as a shader would.

use super::kernel::Kernel;
use super::transform::{PaddedAxis, Pair};
use rayon::prelude::*;
use rustfft::num_complex::Complex64;

/// Octaves. A ray that crosses few lines turns the phase over the window's σ by 40 at the most, whatever the window: 20 of them end where it
/// is below 1e-4, and so is twice as much of the intensity.
pub const OCTAVES: usize = 20;
/// max(|u|, |v|) that all nearer rays are taken for, in units of the last octave's smallest: the far end, where most lines are crossed.
pub const FAR_END: f64 = 1.9;
/// Points of these lines to one of the others: most of the light is here, and they are few.
pub const FINER: usize = 4;

/// Where the octaves stand in a texture, below the other lines.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Near {
    /// Lines on one side of the centre.
    lines: usize,
    /// Points on one side of the centre, octave by octave.
    points: Vec<usize>,
    /// The point and the line of f = 0.
    pub origins: Vec<[usize; 2]>,
    /// Points of a line of the texture, and lines, those above included.
    pub size: [usize; 2],
    kernel: Kernel,
    half_plane: bool,
}

impl Near {
    /// For rays of max(|u|, |v|) < `from` and wavelengths from `shortest` \[µm\], below lines 1/`across` apart with points 1/`along` apart
    /// \[µm, for either set of lines\], which take a texture of `above` points and lines.
    pub fn new(
        (from, shortest): (f64, f64),
        across: [f64; 2],
        along: [f64; 2],
        kernel: Kernel,
        half_plane: bool,
        above: [usize; 2],
    ) -> Self {
        /// A node stands up to one line beyond the visible range, and rounding may count a ray to the next octave.
        const BEYOND: usize = 2;
        let largest = |of: &dyn Fn(usize) -> f64| of(0).max(of(1)).ceil() as usize;
        let lines = largest(&|set| 2.0 * from * across[set] / shortest) + BEYOND;
        let half_width = |octave: usize| {
            let reach = |set: usize| lines as f64 * along[set] / across[set];
            largest(&|set| reach(set) * FINER as f64 / f64::from(finer(octave))) + kernel.guard()
        };
        let points: Vec<usize> = (0..OCTAVES).map(half_width).collect();
        let columns = above[0].max(2 * points[0] + 1);
        let height = if half_plane { lines + 1 } else { 2 * lines + 1 };
        // Side by side, and below each other where a row is full.
        let (mut left, mut top) = (0, above[1]);
        let mut origins = Vec::new();
        for &half in &points {
            if left + 2 * half + 1 > columns {
                (left, top) = (0, top + height);
            }
            origins.push([left + half, if half_plane { top } else { top + lines }]);
            left += 2 * half + 1;
        }
        Self { lines, points, origins, size: [columns, top + height], kernel, half_plane }
    }

    /// Writes a pair of terms of set number `set` into `texels` of this size, less what reading between the points will blur. The lines
    /// above stand 1/`across` apart, their points 1/`along` \[µm\].
    pub fn fill(&self, set: usize, (across, along): (f64, f64), centre: &Centre<'_>, texels: &mut [f32]) {
        let point_length = along * FINER as f64;
        let blur = self.kernel.blur();
        let above = if self.half_plane { 0 } else { self.lines };
        texels.par_chunks_mut(self.size[0] * 4).enumerate().for_each(|(row, texels)| {
            let octaves = self.origins.iter().zip(&self.points).enumerate();
            for (octave, (&[column, origin], &half)) in octaves {
                let line = row as i64 - origin as i64;
                if !(-(above as i64)..=self.lines as i64).contains(&line) {
                    continue;
                }
                let spectra: Vec<[Complex64; 2]> = (-1..=2 * half as i64 + 1)
                    .map(|point| {
                        let along = (point as f64 - half as f64) / point_length;
                        let mut f = [line as f64 / (across * f64::from(finer(octave))), along];
                        if set == 1 {
                            f.swap(0, 1);
                        }
                        centre.at(f)
                    })
                    .collect();
                for (point, near) in spectra.windows(3).enumerate() {
                    let [a, b] = [0, 1].map(|term| {
                        near[1][term] * (1.0 + 2.0 * blur) - (near[0][term] + near[2][term]) * blur
                    });
                    let texel = [a.re as f32, a.im as f32, b.re as f32, b.im as f32];
                    texels[4 * (column - half + point)..][..4].copy_from_slice(&texel);
                }
            }
        });
    }
}

/// By how much closer the lines of an octave stand than the others.
fn finer(octave: usize) -> u32 {
    2 << octave
}

/// A transform of the plane's centre, to be read between its bins.
pub(super) struct Centre<'a> {
    pub pair: &'a Pair,
    pub axes: [&'a PaddedAxis; 2],
    pub kernels: [Kernel; 2],
}

impl Centre<'_> {
    /// The spectra of both terms at the frequency `f` \[µm⁻¹\]; bins that are not kept count as 0.
    fn at(&self, f: [f64; 2]) -> [Complex64; 2] {
        let [x, y] = [0, 1].map(|i| {
            let place = f[i] * self.axes[i].length + self.axes[i].bins as f64;
            (place.floor() as i64 - 1, self.kernels[i].weights(place - place.floor()))
        });
        let mut sum = [Complex64::ZERO; 2];
        for (row, wy) in (y.0..).zip(y.1) {
            for (column, wx) in (x.0..).zip(x.1) {
                let kept = |k: i64, axis: usize| (0..self.axes[axis].kept() as i64).contains(&k);
                if wx * wy != 0.0 && kept(column, 0) && kept(row, 1) {
                    let own = self.pair.at(column as usize, row as usize);
                    sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own * (wx * wy));
                }
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precompute::transform::{Samples, Transformer};
    use crate::surface::HeightField;

    #[test]
    fn octaves_stand_beside_each_other_inside_the_texture() {
        for (half_plane, above) in [(false, [700, 300]), (true, [700, 150]), (false, [40, 9])] {
            let near = Near::new((0.2, 0.38), [30.0, 31.0], [90.0, 88.0], Kernel::Linear, half_plane, above);
            let mut taken = vec![0u8; near.size[0] * near.size[1]];
            taken[..near.size[0] * above[1]].fill(1);
            for (&[column, row], &half) in near.origins.iter().zip(&near.points) {
                let first = if half_plane { row } else { row - near.lines };
                for line in first..=row + near.lines {
                    taken[line * near.size[0]..][column - half..=column + half]
                        .iter_mut()
                        .for_each(|n| *n += 1);
                }
            }
            assert!(near.origins.len() == OCTAVES && taken.iter().all(|n| *n <= 1), "{above:?}");
        }
    }

    #[test]
    fn between_the_bins_of_the_centre_stands_the_spectrum_itself() {
        let heights: Vec<f64> = (0..35).map(|i| (f64::from(i * 37 % 11)).sin() * 0.1).collect();
        let field = HeightField::new(7, 5, [0.2, 0.3], heights).unwrap();
        let own = Samples::of(&field, [0.0; 2]);
        let transformer = |kernels: [Kernel; 2], ratio: f64| {
            let [x, y] = [0, 1].map(|i| PaddedAxis::new(&own[i], 1.0, ratio, Some(kernels[i]), 1.0));
            Transformer::new(&field, x, y)
        };
        let value = |_: usize, i: usize| Complex64::cis(9.0 * field.heights()[i]);
        let ways = [
            ([Kernel::Linear; 2], 8e-3),
            ([Kernel::Cubic, Kernel::Linear], 4e-3),
            ([Kernel::Cubic; 2], 1e-4),
        ];
        for (kernels, allowed) in ways {
            let (coarse, fine) = (transformer(kernels, 30.0), transformer(kernels, 240.0));
            let (pair, truth) = (coarse.pair(false, value), fine.pair(false, value));
            let read = |t: &Transformer<'_>, pair: &Pair, f: [f64; 2]| {
                Centre { pair, axes: [&t.x, &t.y], kernels }.at(f)[0]
            };
            for f in [[0.0, 0.0], [0.013, -0.021], [-0.31, 0.27], [0.5, 0.09]] {
                let (a, b) = (read(&coarse, &pair, f), read(&fine, &truth, f));
                assert!((a - b).norm() < allowed, "{kernels:?} {f:?}: {a} {b}");
            }
            let far = read(&coarse, &pair, [3.0, 0.0]);
            assert_eq!(far, Complex64::ZERO);
        }
    }
}
