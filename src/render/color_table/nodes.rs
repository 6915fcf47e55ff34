//! Chebyshev nodes in |w|: where they stand, how many a surface needs.
//!
//! At each (u, v) they cover the |w| that unit vectors allow, 0 … √(4 − u² − v²): far from the mirror direction the range is
//! short, and beyond it the layers are not made for what would be asked of them.

use crate::error::{Error, Result};
use crate::precompute::Layers;
use glam::DVec2;
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;

/// Share of the tolerance that goes to interpolating in w.
const NODE_SHARE: f64 = 0.4;
/// Most nodes that the shader takes.
pub const MOST: usize = 8;

/// The largest |w| at |(u, v)| = `uv`; a little beyond the horizon where only texels of the edge stand.
pub fn largest_w(uv: f64) -> f64 {
    /// `LEAST_RANGE` of the shader.
    const LEAST: f64 = 1e-3;
    (4.0 - uv * uv).max(LEAST).sqrt()
}

/// Node `m` of `count` as a share of the largest |w|: the Chebyshev points of 0 … 1.
pub fn place(m: usize, count: usize) -> f64 {
    0.5 - 0.5 * (PI * (m as f64 + 0.5) / count as f64).cos()
}

/// The weight of the value at node `m` in coefficient `n` of Σ a_n T_n(2 x − 1), x the share of the largest |w|.
pub fn weight(n: usize, m: usize, count: usize) -> f64 {
    let norm = if n == 0 { 1.0 } else { 2.0 } / count as f64;
    // 2x − 1 = −cos θ, T_n(−cos θ) = (−1)ⁿ cos nθ.
    let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
    norm * sign * (n as f64 * PI * (m as f64 + 0.5) / count as f64).cos()
}

/// The weight of the value at node `m` of `count` in the polynomial through all of them, at `x` from −1 to 1.
pub fn lagrange(m: usize, count: usize, x: f64) -> f64 {
    let node = |m: usize| 2.0 * place(m, count) - 1.0;
    (0..count).filter(|&other| other != m).map(|other| (x - node(other)) / (node(m) - node(other))).product()
}

/// The fewest nodes that interpolate the power of `layers` in w to the share of `tolerance`, RMS over frequencies that are
/// seen and relative to each one's own.
///
/// # Errors
/// Where the most nodes that there are do not suffice: the surface is too high for a table.
pub fn needed(layers: &Layers, tolerance: f64) -> Result<usize> {
    let judge = Judge::new(layers);
    let share = NODE_SHARE * tolerance;
    let mut error = f64::INFINITY;
    for count in 1..=MOST {
        error = judge.error(count);
        eprintln!("DEBUG nodes {count}: {error:.2e}");
        if error <= share {
            return Ok(count);
        }
    }
    Err(Error::failed(
        format!(
            "--method table has at most {MOST} nodes in w, which leave a relative error of {error:.1e} on this surface, more \
             than its share {share:.1e} of the tolerance"
        ),
        "ask for a larger --tolerance, or use --method spectral",
    ))
}

/// Power summed over wavelengths as a function of w in some directions, from the layers themselves.
struct Judge<'a> {
    layers: &'a Layers,
    /// The directions.
    directions: Vec<DVec2>,
}

/// Directions that are looked at.
const DIRECTIONS: usize = 400;
/// Wavenumbers of the sum \[µm⁻¹\]: evenly from 690 to 420 nm, where the colour functions are large.
const WAVENUMBERS: usize = 16;
const ENDS: (f64, f64) = (1.0 / 0.69, 1.0 / 0.42);
/// Places in w where the polynomial is compared.
const STEPS: usize = 12;

impl<'a> Judge<'a> {
    fn new(layers: &'a Layers) -> Self {
        // Evenly over the disc, by the golden angle; both halves of it, as −f is read where f has no texel.
        let direction = |i: usize| {
            let uv = 1.95 * ((i as f64 + 0.5) / DIRECTIONS as f64).sqrt();
            DVec2::from_angle(i as f64 * PI * (3.0 - 5f64.sqrt())) * uv
        };
        Self { layers, directions: (0..DIRECTIONS).map(direction).collect() }
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
        let table = &self.layers.coefficients;
        let column = (z / table.step).min(table.columns as f64 - 1.001);
        let (left, t) = (column as usize, column.fract());
        let plane = self.layers.size[0] * self.layers.size[1] * 4;
        let sum: Complex64 = (0..self.layers.terms)
            .map(|n| {
                let c = |i: usize| {
                    let [re, im] = table.values[n * table.columns + i];
                    Complex64::new(re.into(), im.into())
                };
                let texel = &self.layers.texels[n / 2 * plane + index * 4 + n % 2 * 2..][..2];
                let sign = if turned { -1.0 } else { 1.0 };
                (c(left) * (1.0 - t) + c(left + 1) * t)
                    * Complex64::new(texel[0].into(), sign * f64::from(texel[1]))
            })
            .sum();
        sum.norm_sqr()
    }

    /// Relative error of `count` nodes, RMS over the directions, each relative to its own RMS over w.
    fn error(&self, count: usize) -> f64 {
        let squares: Vec<f64> = self.directions.par_iter().map(|&uv| self.error_at(uv, count)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    /// The squared error of a direction.
    fn error_at(&self, uv: DVec2, count: usize) -> f64 {
        let largest = largest_w(uv.length());
        let seen: Vec<(f64, (usize, bool))> = (0..WAVENUMBERS)
            .filter_map(|i| {
                let q = ENDS.0 + (ENDS.1 - ENDS.0) * i as f64 / (WAVENUMBERS - 1) as f64;
                self.texel(uv * q).map(|texel| (q, texel))
            })
            .collect();
        let colour = |x: f64| -> f64 {
            seen.iter().map(|&(q, texel)| q * q * self.power(texel, 2.0 * PI * q * largest * x)).sum()
        };
        let values: Vec<f64> = (0..count).map(|m| colour(place(m, count))).collect();
        let (mut error, mut size) = (0.0, 0.0);
        for step in 0..STEPS {
            let x = (step as f64 + 0.5) / STEPS as f64;
            let exact = colour(x);
            let weights = (0..count).map(|m| lagrange(m, count, 2.0 * x - 1.0));
            error += (weights.zip(&values).map(|(w, v)| w * v).sum::<f64>() - exact).powi(2);
            size += exact * exact;
        }
        if size > 0.0 { error / size } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ a_n T_n(x).
    fn chebyshev(coefficients: &[f64], x: f64) -> f64 {
        let (mut next, mut after) = (0.0, 0.0);
        for a in coefficients.iter().skip(1).rev() {
            (next, after) = (a + 2.0 * x * next - after, next);
        }
        coefficients.first().copied().unwrap_or(0.0) + x * next - after
    }

    #[test]
    fn polynomials_below_the_count_are_met_exactly() {
        let f = |w: f64| 0.3 - w + 2.0 * w * w - 0.7 * w.powi(3);
        for count in 4..=MOST {
            let coefficients: Vec<f64> = (0..count)
                .map(|n| (0..count).map(|m| weight(n, m, count) * f(place(m, count))).sum())
                .collect();
            for w in [0.0, 0.1, 0.37, 0.6, 1.0] {
                let x = 2.0 * w - 1.0;
                assert!((chebyshev(&coefficients, x) - f(w)).abs() < 1e-12, "{count} nodes at {w}");
                assert!((through(x) - f(w)).abs() < 1e-12, "{count} nodes at {w}");
            }
        }
        assert!((chebyshev(&[1.0, 1.0, 1.0, 1.0], 0.5) - (1.0 + 0.5 - 0.5 - 1.0)).abs() < 1e-15);
    }
}
