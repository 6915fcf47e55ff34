//! Layers for the shader of the thesis, a baseline for comparison: the Fourier series of the powers of the height over one period, which
//! the shader weights by the window's spectrum at the 3 × 3 bins nearest to a frequency (\[Single 2014\], Gaussian window over the DFT).

use super::coefficients::Coefficients;
use super::kernel::{Interpolation, Kernel, Transformed};
use super::layers::{Errors, Layers, largest_z};
use super::pairs::PairRule;
use super::plan::bands_of;
use super::texels::Texels;
use super::transform::{PaddedAxis, Samples, Transformer};
use crate::error::Result;
use crate::memory;
use crate::spectra::amplitude::expansion::taylor::{F32_ROUNDOFF, Taylor};
use crate::spectra::amplitude::expansion::{Basis, Expansion, HeightScale};
use crate::surface::HeightField;
use rustfft::num_complex::Complex64;

/// Number of terms of the Taylor series that the thesis sums on *Elaphe*.
pub const TERMS: usize = 37;
/// Number of wavelengths: 380 to 780 nm in steps of 5 nm.
pub const WAVELENGTHS: usize = 81;
/// Bins of the window's spectrum, 3 along each axis.
pub const TAPS: usize = 9;
/// Bins of the window's spectrum beyond the nearest.
const REACH: usize = 1;

/// Computes the layers of the thesis for `field` seen through a Gaussian of standard deviation `sigma` \[µm\], for wavelengths from
/// `shortest` \[µm\]. The middle height is 0 here too, without which 32-bit floats lose more digits.
///
/// # Errors
/// Too little memory.
pub fn layers(field: &HeightField, sigma: f64, shortest: f64) -> Result<Layers> {
    let scale = HeightScale::of(field);
    let band = bands_of(field, shortest);
    let axes = Samples::of(field, [0.0; 2]);
    let [x, y] = [0, 1].map(|i| PaddedAxis::of_period(&axes[i], band[i], REACH));
    let first_column = x.bins - REACH;
    let size = [x.kept() - first_column, y.kept()];
    let pairs = TERMS.div_ceil(2);
    let texels = size[0] * size[1] * pairs;
    memory::ensure_room(
        texels as u64 * 32 + Transformer::memory(&x, &y, &axes[1], 1),
        "the Fourier series of the thesis",
    )?;
    let heights: Vec<f64> = field.heights().iter().map(|&h| scale.normalise(h)).collect();
    let expansion = Taylor { half_range: scale.half_range };
    let transformer = Transformer::new(field, x, y);
    let mut values = Vec::with_capacity(texels * 4);
    for pair in 0..pairs {
        let value = |n: usize, i: usize| match 2 * pair + n {
            term if term < TERMS => expansion.basis(term, heights[i]),
            _ => Complex64::ZERO,
        };
        let spectra = transformer.pair(true, value);
        for row in 0..size[1] {
            for column in first_column..first_column + size[0] {
                let [a, b] = spectra.at(column, row);
                values.extend([a.re as f32, a.im as f32, b.re as f32, b.im as f32]);
            }
        }
        transformer.take_back(spectra);
    }
    let z_max = largest_z(shortest);
    Ok(Layers {
        size,
        origin: [transformer.x.bins - first_column, transformer.y.bins],
        length: [transformer.x.length, transformer.y.length],
        band,
        sigma,
        half_plane: true,
        terms: TERMS,
        coefficients: Coefficients::new(Basis::Taylor, &expansion, TERMS, z_max, scale.half_range, 1.0),
        z_max,
        pairs_needed: PairRule::constant(pairs),
        interpolation: Interpolation {
            of: Transformed::Window,
            kernels: [Kernel::Linear; 2],
            ratios: [1.0; 2],
        },
        errors: Errors {
            expansion: expansion.truncation_bound(z_max, TERMS),
            interpolation: f64::INFINITY, // the error of 3 x 3 bins has no bound
            truncation_bound: expansion.truncation_bound(z_max, TERMS),
            rounding_bound: expansion.rounding_bound(z_max, F32_ROUNDOFF),
        },
        texels: Texels::of(false, values),
    })
}
