//! Ratio of the albedo of a surface to the reflectance that it may have, for the colours of one light.

use super::color::xyz_to_linear_srgb;
use super::quadrature::Wavelengths;
use super::spectrum::{Illuminant, LONGEST, SHORTEST};
use glam::DVec3;

/// Least component of a colour over its luminance that is compared: smaller ones are outside of the gamut, and their
/// ratios mean nothing.
const COMPARED: f64 = 0.1;

/// Components of colours that are compared.
fn components(xyz: DVec3) -> [f64; 6] {
    let rgb = xyz_to_linear_srgb(xyz);
    [xyz.x, xyz.y, xyz.z, rgb.x, rgb.y, rgb.z]
}

/// Returns the largest ratio of the components of `sent` to those of `allowed` that are compared.
pub fn largest_ratio(sent: DVec3, allowed: DVec3) -> f64 {
    let pairs = components(sent).into_iter().zip(components(allowed));
    pairs.filter(|(_, a)| *a > COMPARED * allowed.y && *a > 0.0).map(|(s, a)| s / a).fold(0.0, f64::max)
}

/// Weights of a few wavenumbers, evenly spread over the visible range, in a colour of one light.
pub struct ColourWeights(Vec<DVec3>);

impl ColourWeights {
    /// Wavenumbers, ends of the visible range included.
    pub const WAVENUMBERS: usize = 12;

    /// Returns the weights under `illuminant`.
    pub fn new(illuminant: &Illuminant) -> Self {
        Self(Wavelengths::catmull_rom(illuminant, Self::WAVENUMBERS).weights)
    }

    /// Returns a wavelength \[µm\] by its number.
    pub fn wavelength(number: usize) -> f64 {
        let (first, last) = (1.0 / LONGEST, 1.0 / SHORTEST);
        1.0 / (first + (last - first) * number as f64 / (Self::WAVENUMBERS - 1) as f64)
    }

    /// Returns XYZ of white.
    pub fn white(&self) -> DVec3 {
        self.0.iter().sum()
    }

    /// Returns XYZ of the albedo and of the allowed reflectance, which `at` returns for the number of a wavenumber.
    pub fn colours(&self, at: impl Fn(usize) -> [f64; 2]) -> [DVec3; 2] {
        let [mut sent, mut allowed] = [DVec3::ZERO; 2];
        for (layer, weight) in self.0.iter().enumerate() {
            let [e, r] = at(layer);
            (sent, allowed) = (sent + *weight * e, allowed + *weight * r);
        }
        [sent, allowed]
    }

    /// Returns E/R of the colour.
    pub fn excess(&self, at: impl Fn(usize) -> [f64; 2]) -> f64 {
        let [sent, allowed] = self.colours(at);
        largest_ratio(sent, allowed)
    }
}
