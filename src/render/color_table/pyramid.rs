//! From values at nodes to the texels of all mip levels.

use super::grid::{Grid, LEVELS};
use super::nodes::{self, NODES};
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};
use rayon::prelude::*;

/// Where the largest number of a table is put in the range of 16-bit floats, which ends at 65504 and loses precision below
/// 6e-5: the faint directions need the room.
const LARGEST: f32 = 3e4;

/// XYZ at every node and place: a plane of `side`² floats for each. A piece has the four nodes of X, then those of Y and Z.
pub type Planes = Vec<Vec<f32>>;

/// The texels of every level, and what a stored 1 stands for. `near` goes into a corner of the finest level.
pub fn texels(grid: &Grid, mut planes: Planes, mut near: Planes) -> (f32, Vec<Vec<u16>>) {
    let mut largest = 0f32;
    for (planes, side) in [(&mut planes, grid.side), (&mut near, grid.near().side)] {
        planes.par_iter_mut().for_each(|plane| prefilter(plane, side));
        planes.par_chunks_mut(NODES).for_each(to_coefficients);
        let of_plane = |p: &Vec<f32>| p.iter().fold(0f32, |m, x| m.max(x.abs()));
        largest = largest.max(planes.par_iter().map(of_plane).reduce(|| 0.0, f32::max));
    }
    let unit = if largest > 0.0 { largest / LARGEST } else { 1.0 };
    let mut side = grid.side;
    into_corner(&mut planes, grid, Some(&near));
    let mut levels = vec![beside(&packed(&planes, side, unit), side)];
    into_corner(&mut planes, grid, None);
    for _ in 1..LEVELS {
        planes.par_iter_mut().for_each(|plane| *plane = halved(plane, side));
        side /= 2;
        levels.push(packed(&planes, side, unit));
    }
    (unit, levels)
}

/// Puts `near` into the corner of `planes` that it has, or nothing.
fn into_corner(planes: &mut Planes, grid: &Grid, near: Option<&Planes>) {
    let side = grid.near().side;
    planes.par_iter_mut().enumerate().for_each(|(number, plane)| {
        for row in 0..side {
            let corner = &mut plane[row * grid.side..][..side];
            match near {
                Some(near) => corner.copy_from_slice(&near[number][row * side..][..side]),
                None => corner.fill(0.0),
            }
        }
    });
}

/// Prepares samples for linear interpolation: (−1, 14, −1)/12 along each axis. Interpolated between, they are then as close
/// to the function that was sampled as linear interpolation can be, 2.4 times closer than through the samples themselves
/// (quasi-interpolation; Condat, Blu and Unser 2005), and their mean stays. Intensities stay positive.
pub fn prefilter(plane: &mut [f32], side: usize) {
    let three = |before: f32, own: f32, after: f32| (14.0 * own - before - after) / 12.0;
    for row in plane.chunks_mut(side) {
        let mut before = row[0];
        for i in 0..side {
            let own = row[i];
            row[i] = three(before, own, row[(i + 1).min(side - 1)]);
            before = own;
        }
    }
    let mut before = plane[..side].to_vec();
    for row in 0..side {
        let (here, rest) = plane[row * side..].split_at_mut(side);
        for (i, own) in here.iter_mut().enumerate() {
            let value = *own;
            let after = rest.get(i).copied().unwrap_or(value);
            *own = three(before[i], value, after).max(0.0);
            before[i] = value;
        }
    }
}

/// The values at the nodes of one channel of a piece to coefficients of Chebyshev polynomials, in place.
fn to_coefficients(planes: &mut [Vec<f32>]) {
    let weights: [[f32; NODES]; NODES] =
        std::array::from_fn(|n| std::array::from_fn(|m| nodes::weight(n, m) as f32));
    let [a, b, c, d] = planes else { return };
    for (((a, b), c), d) in a.iter_mut().zip(b).zip(c).zip(d) {
        let values = [*a, *b, *c, *d];
        let sum = |n: usize| weights[n].iter().zip(values).map(|(w, v)| w * v).sum();
        (*a, *b, *c, *d) = (sum(0), sum(1), sum(2), sum(3));
    }
}

/// The averages of 2 × 2 texels of a plane of `side`.
pub fn halved(plane: &[f32], side: usize) -> Vec<f32> {
    let half = side / 2;
    let mut small = Vec::with_capacity(half * half);
    for rows in plane.chunks(2 * side) {
        let (upper, lower) = rows.split_at(side);
        let pairs = upper.chunks(2).zip(lower.chunks(2));
        small.extend(pairs.map(|(a, b)| 0.25 * ((a[0] + a[1]) + (b[0] + b[1]))));
    }
    small
}

/// The four coefficients of a channel as RGBA of a layer, 16-bit floats in units of `unit`.
fn packed(planes: &Planes, side: usize, unit: f32) -> Vec<u16> {
    let places = side * side;
    let mut texels = vec![0u16; planes.len() * places];
    texels.par_chunks_mut(places * NODES).zip(planes.par_chunks(NODES)).for_each(|(layer, four)| {
        let mut row = vec![0f32; side * NODES];
        for (j, out) in layer.chunks_mut(side * NODES).enumerate() {
            for (c, plane) in four.iter().enumerate() {
                for (i, value) in plane[j * side..][..side].iter().enumerate() {
                    row[i * NODES + c] = value / unit;
                }
            }
            out.reinterpret_cast_mut::<half::f16>().convert_from_f32_slice(&row);
        }
    });
    texels
}

/// Texels of X, Y and Z in layers of their own as texels beside each other.
fn beside(layers: &[u16], side: usize) -> Vec<u16> {
    const TEXEL: usize = 4;
    let layer = side * side * TEXEL;
    let mut texels = vec![0u16; layers.len()];
    texels.par_chunks_mut(3 * side * TEXEL).enumerate().for_each(|(row, out)| {
        let (piece, row) = (row / side, row % side);
        for channel in 0..3 {
            let from = &layers[(3 * piece + channel) * layer + row * side * TEXEL..][..side * TEXEL];
            let to = out[channel * TEXEL..].chunks_mut(3 * TEXEL);
            to.zip(from.chunks(TEXEL)).for_each(|(to, from)| to[..TEXEL].copy_from_slice(from));
        }
    });
    texels
}

/// The finest level of a table, as texels in layers again, as a device filters them.
pub fn in_layers(grid: &Grid, finest: &[u16]) -> Vec<u16> {
    const TEXEL: usize = 4;
    let side = grid.side;
    let mut layers = vec![0u16; finest.len()];
    layers.par_chunks_mut(side * TEXEL).enumerate().for_each(|(row, out)| {
        let (layer, row) = (row / side, row % side);
        let from = &finest[((layer / 3 * side + row) * side * 3 + layer % 3) * TEXEL..];
        out.chunks_mut(TEXEL)
            .zip(from.chunks(3 * TEXEL))
            .for_each(|(to, from)| to.copy_from_slice(&from[..TEXEL]));
    });
    layers
}

#[cfg(test)]
mod tests {
    use super::*;
    use half::f16;

    #[test]
    fn each_level_is_the_average_of_the_one_before_and_keeps_the_mean() {
        let side = 8;
        let plane: Vec<f32> = (0..side * side).map(|i| ((i * 37 % 23) as f32).powi(2)).collect();
        let small = halved(&plane, side);
        assert_eq!(small.len(), 16);
        for (i, value) in small.iter().enumerate() {
            let (x, y) = (i % 4 * 2, i / 4 * 2);
            let four: f32 =
                [(0, 0), (1, 0), (0, 1), (1, 1)].iter().map(|(a, b)| plane[(y + b) * side + x + a]).sum();
            assert_eq!(*value, four / 4.0);
        }
        let mean = |p: &[f32]| p.iter().sum::<f32>() / p.len() as f32;
        assert!((mean(&small) / mean(&plane) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn prefiltered_samples_are_closer_between_than_the_samples_themselves() {
        // A Gaussian of two texels, as the mirror's peak is, off the grid's places.
        let side = 64;
        let f = |x: f64, y: f64| (-((x - 31.3).powi(2) + (y - 30.6).powi(2)) / 8.0).exp();
        let plain: Vec<f32> =
            (0..side * side).map(|i| f((i % side) as f64, (i / side) as f64) as f32).collect();
        let mut filtered = plain.clone();
        prefilter(&mut filtered, side);
        let error = |plane: &[f32]| {
            let (mut wrong, mut size) = (0.0, 0.0);
            for i in 0..500 * 500 {
                let (x, y) = (10.0 + (i % 500) as f64 * 0.08, 10.0 + (i / 500) as f64 * 0.08);
                let (left, top) = (x as usize, y as usize);
                let (s, t) = (x.fract(), y.fract());
                let at = |a: usize, b: usize| f64::from(plane[(top + b) * side + left + a]);
                let read = (at(0, 0) * (1.0 - s) + at(1, 0) * s) * (1.0 - t)
                    + (at(0, 1) * (1.0 - s) + at(1, 1) * s) * t;
                wrong += (read - f(x, y)).powi(2);
                size += f(x, y).powi(2);
            }
            (wrong / size).sqrt()
        };
        let (before, after) = (error(&plain), error(&filtered));
        assert!(after < 0.5 * before && after < 0.02, "{before:.2e} to {after:.2e}");
        let sum = |p: &[f32]| p.iter().map(|x| f64::from(*x)).sum::<f64>();
        assert!((sum(&filtered) / sum(&plain) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn texels_hold_the_polynomials_that_the_shader_evaluates() {
        let grid = Grid { side: 256, spacing: 0.01, pieces: 2 };
        // Constant in (u, v): a cubic in the share of |w|, once, twice and three times for X, Y, Z.
        let f = |x: f64| 1.0 + x + x * x - 0.5 * x.powi(3);
        let planes = |side: usize| -> Planes {
            let plane = |i: usize| {
                let (piece, channel, m) = (i / 12, i / 4 % 3, i % 4);
                vec![(f(nodes::place(4 * piece + m, 2)) * (channel + 1) as f64) as f32; side * side]
            };
            (0..24).map(plane).collect()
        };
        let (unit, levels) = texels(&grid, planes(256), planes(grid.near().side));
        assert_eq!(levels.len(), LEVELS);
        let finest = in_layers(&grid, &levels[0]);
        for (level, texels) in std::iter::once(&finest).chain(&levels[1..]).enumerate() {
            let side = 256 >> level;
            assert_eq!(texels.len(), grid.layers() * side * side * 4);
            for share in [0.0, 0.3, 0.7, 1.0] {
                let piece = usize::from(share >= 0.5);
                let x = 2.0 * (share * 2.0 - piece as f64) - 1.0;
                for channel in 0..3 {
                    let texel = &texels
                        [(3 * piece + channel) * side * side * 4 + (side / 2 * side + side / 2) * 4..][..4];
                    let [a, b, c, d] = std::array::from_fn(|i| f16::from_bits(texel[i]).to_f64());
                    let cubic = a + b * x + c * (2.0 * x * x - 1.0) + d * (4.0 * x * x - 3.0) * x;
                    let expected = f(share) * (channel + 1) as f64;
                    assert!(
                        (cubic * f64::from(unit) / expected - 1.0).abs() < 2e-3,
                        "level {level}, {share}"
                    );
                }
            }
        }
    }
}
