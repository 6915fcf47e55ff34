//! The polynomials in |w|: where their nodes stand, how many a surface needs.
//!
//! At each (u, v) they cover the |w| that unit vectors allow, 0 … √(4 − u² − v²): far from the mirror direction the range is
//! short, and beyond it the layers are not made for what would be asked of them. The range is cut into equal pieces with a
//! cubic each: a reader takes the one piece that its |w| lies in, so more pieces cost room and no time.

use super::aperture::Aperture;
use crate::error::{Error, Result};
use crate::optics::orders::{Colours, Repeats};
use crate::precompute::Layers;
use crate::render::shading::Shading;
use glam::DVec2;
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;

/// Share of the tolerance that goes to interpolating in w.
pub const NODE_SHARE: f64 = 0.4;
/// Nodes of a piece, and coefficients: one texel holds those of a channel.
pub const NODES: usize = 4;
/// Most pieces.
pub const MOST: usize = 8;

/// The largest |w| at |(u, v)| = `uv`; a little beyond the horizon where only texels of the edge stand.
pub fn largest_w(uv: f64) -> f64 {
    /// `LEAST_RANGE` of the shader.
    const LEAST: f64 = 1e-3;
    (4.0 - uv * uv).max(LEAST).sqrt()
}

/// Node `m` of a piece: the Chebyshev points of −1 … 1.
fn node(m: usize) -> f64 {
    -(PI * (m as f64 + 0.5) / NODES as f64).cos()
}

/// Node `number` of `pieces`, piece by piece, as a share of the largest |w|.
pub fn place(number: usize, pieces: usize) -> f64 {
    ((number / NODES) as f64 + 0.5 + 0.5 * node(number % NODES)) / pieces as f64
}

/// T_n(x) of every coefficient.
fn polynomials(x: f64) -> [f64; NODES] {
    [1.0, x, 2.0 * x * x - 1.0, (4.0 * x * x - 3.0) * x]
}

/// The weight of the value at node `m` in coefficient `n`.
pub fn weight(n: usize, m: usize) -> f64 {
    let norm = if n == 0 { 1.0 } else { 2.0 } / NODES as f64;
    norm * polynomials(node(m))[n]
}

/// The first node of the piece that holds `share` of the largest |w|, and the weights of its nodes' values there.
pub fn at(share: f64, pieces: usize) -> (usize, [f64; NODES]) {
    let along = share * pieces as f64;
    let piece = (along as usize).min(pieces - 1);
    let t = polynomials(2.0 * (along - piece as f64) - 1.0);
    (piece * NODES, std::array::from_fn(|m| (0..NODES).map(|n| weight(n, m) * t[n]).sum()))
}

/// The fewest pieces that interpolate colours from `layers`, of [`Basis::Phase`](crate::expansion::Basis::Phase), through `aperture` in w
/// to the share of `shading`'s tolerance, RMS over directions and each relative to its own.
///
/// # Errors
/// Where the most pieces that there are do not suffice: the surface is too high for a table.
pub fn needed(layers: &Layers, aperture: &Aperture, shading: &Shading) -> Result<usize> {
    let tolerance = shading.tolerance;
    let judge = Judge::new(layers, aperture, shading);
    let share = NODE_SHARE * tolerance;
    let mut error = f64::INFINITY;
    for pieces in 1..=MOST {
        error = judge.error(pieces);
        if error <= share {
            return Ok(pieces);
        }
    }
    Err(Error::failed(
        format!(
            "--method table has at most {MOST} pieces in w, which leave a relative error of {error:.1e} on this surface, \
             more than their share {share:.1e} of the tolerance"
        ),
        "ask for a larger --tolerance, or use --method spectral",
    ))
}

/// Power summed over wavelengths as a function of w in some directions, from the layers themselves.
struct Judge<'a> {
    layers: &'a Layers,
    /// The copies, with the colour functions and the tolerance of the sum over wavelengths.
    repeats: Option<(Repeats, Colours, f64)>,
    /// (u, v) of directions everywhere and of those of the mirror's peak.
    directions: [Vec<DVec2>; 2],
}

/// Directions that are looked at, in each of two places.
const DIRECTIONS: usize = 300;
/// Wavenumbers of the sum \[µm⁻¹\]: evenly from 660 to 410 nm, where the colour functions are large.
const WAVENUMBERS: usize = 16;
const ENDS: (f64, f64) = (1.0 / 0.66, 1.0 / 0.41);
/// Places in w where the polynomial is compared.
const STEPS: usize = 17;
/// A direction counts as dark at a w where it has less than this part of its RMS over w.
const DARK: f64 = 0.05;

impl<'a> Judge<'a> {
    fn new(layers: &'a Layers, aperture: &Aperture, shading: &Shading) -> Self {
        // By the golden angle, denser toward the mirror direction; and as many again within the mirror's peak.
        let within = |radius: f64| {
            move |i: usize| {
                DVec2::from_angle(i as f64 * PI * (3.0 - 5f64.sqrt()))
                    * (radius * i as f64 / DIRECTIONS as f64)
            }
        };
        // Twice the standard deviation of its power, λ/(2√2 π σ).
        let peak = 0.12 / aperture.width();
        let directions = [1.95, peak.min(1.95)].map(|radius| (0..DIRECTIONS).map(within(radius)).collect());
        let tolerance = shading.quadrature();
        let repeats =
            aperture.repeats().map(|r| (*r, Colours::new(&shading.illuminant, tolerance), tolerance));
        Self { layers, repeats, directions }
    }

    /// Wavenumbers \[µm⁻¹\] that are summed over along (u, v), and what the power there weighs.
    fn wavenumbers(&self, uv: DVec2) -> Vec<(f64, f64)> {
        let Some((repeats, colours, tolerance)) = &self.repeats else {
            let step = (ENDS.1 - ENDS.0) / (WAVENUMBERS - 1) as f64;
            return (0..WAVENUMBERS).map(|i| ENDS.0 + step * i as f64).map(|q| (q, q * q)).collect();
        };
        // Few orders may be all that there is, so they count as they do in the table.
        let sampling = repeats.sampling(uv, colours.lag, *tolerance);
        let terms = repeats.terms(&sampling, uv, colours);
        terms.into_iter().map(|(q, weight)| (q, q * q * weight.y)).collect()
    }

    /// Index of the texel nearest to a frequency, and whether it holds the conjugate; `None` beyond the band.
    fn texel(&self, f: DVec2) -> Option<(usize, bool)> {
        let layers = self.layers;
        let (f, turned) = if f.x < 0.0 { (-f, true) } else { (f, false) };
        if f.x > layers.band[0] || f.y.abs() > layers.band[1] {
            return None;
        }
        let x = (f.x * layers.length[0]).round() as usize + layers.origin[0];
        let y = (f.y * layers.length[1]).round() as i64 + layers.origin[1] as i64;
        Some((y as usize * layers.size[0] + x, turned))
    }

    /// |P|² at texel `index` and k|w| = `z`.
    fn power(&self, (index, turned): (usize, bool), z: f64) -> f64 {
        let x = 2.0 * z / self.layers.z_max - 1.0;
        let plane = self.layers.size[0] * self.layers.size[1] * 4;
        let sign = if turned { -1.0 } else { 1.0 };
        let (mut before, mut own) = (x, 1.0); // T_{−1} = T_1
        let mut sum = Complex64::ZERO;
        for pair in 0..self.layers.pairs() {
            let [a, b, c, d] =
                std::array::from_fn(|i| f64::from(self.layers.texels.at(pair * plane + index * 4 + i)));
            sum += own * (Complex64::new(a, sign * b) + Complex64::I * Complex64::new(c, sign * d));
            (before, own) = (own, 2.0 * x * own - before);
        }
        sum.norm_sqr()
    }

    /// Relative error of `pieces`, RMS over w and over directions, everywhere or in the mirror's peak: the larger.
    fn error(&self, pieces: usize) -> f64 {
        let rms = |directions: &Vec<DVec2>| {
            let squares: Vec<f64> = directions.par_iter().map(|&uv| self.error_at(uv, pieces)).collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        };
        self.directions.iter().map(rms).fold(0.0, f64::max)
    }

    /// The mean squared error of a direction.
    fn error_at(&self, uv: DVec2, pieces: usize) -> f64 {
        let largest = largest_w(uv.length());
        let seen: Vec<(f64, f64, (usize, bool))> = self
            .wavenumbers(uv)
            .into_iter()
            .filter_map(|(q, weight)| self.texel(uv * q).map(|texel| (q, weight, texel)))
            .collect();
        let colour = |share: f64| -> f64 {
            let power = |q: f64, texel| self.power(texel, 2.0 * PI * q * largest * share);
            seen.iter().map(|&(q, weight, texel)| weight * power(q, texel)).sum()
        };
        let values: Vec<f64> = (0..NODES * pieces).map(|number| colour(place(number, pieces))).collect();
        let compared: Vec<[f64; 2]> = (0..STEPS)
            .map(|step| {
                let share = (step as f64 + 0.5) / STEPS as f64;
                let (first, weights) = at(share, pieces);
                let found: f64 = weights.iter().zip(&values[first..]).map(|(w, v)| w * v).sum();
                [found, colour(share)]
            })
            .collect();
        let size = compared.iter().map(|c| c[1] * c[1]).sum::<f64>() / STEPS as f64;
        let floor = DARK * DARK * size + f64::MIN_POSITIVE;
        let squares = compared.iter().map(|[found, exact]| (found - exact).powi(2) / (exact * exact + floor));
        squares.sum::<f64>() / STEPS as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_met_exactly_by_any_number_of_pieces_and_quartics_better_by_more() {
        let cubic = |w: f64| 0.3 - w + 2.0 * w * w - 0.7 * w.powi(3);
        let error = |f: &dyn Fn(f64) -> f64, pieces: usize| {
            let values: Vec<f64> = (0..NODES * pieces).map(|number| f(place(number, pieces))).collect();
            let off = |share: f64| {
                let (first, weights) = at(share, pieces);
                (weights.iter().zip(&values[first..]).map(|(w, v)| w * v).sum::<f64>() - f(share)).abs()
            };
            (0..=100).map(|i| off(f64::from(i) / 100.0)).fold(0.0, f64::max)
        };
        for pieces in 1..=MOST {
            assert!(error(&cubic, pieces) < 1e-12, "{pieces} pieces");
        }
        // The error of a cubic through Chebyshev's nodes falls with the fourth power of the piece.
        let quartic = |w: f64| w.powi(4);
        let fall = error(&quartic, 2) / error(&quartic, 4);
        assert!((fall / 16.0 - 1.0).abs() < 0.1, "{fall}");
    }
}
