//! The specular order in colour: the remaining mirror image, a lobe around the specular direction.
//!
//! At one wavelength it is |c_0(z)|² q² γ̂(q(u, v))/w², a Gaussian of (u, v) with the variance λ²/(8π²σ²) and the weight |c_0|²/w². Bands
//! of wavelengths share a variance.

use super::TableSettings;
use crate::optics::quadrature::Wavelengths;
use crate::optics::reflectance::MeanReflectance;
use crate::spectra::power::{Blur, OrderSeries};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Number of bands of wavelengths. Within one, the variance differs by up to 10 % from the band's, which changes the lobe of a mirror by
/// 1.2e-3 of its peak at most once all bands are added (`the_bands_of_the_specular_order_hold_the_lobe_of_a_mirror`). Only pixels beside
/// the specular direction sum them.
pub const BANDS: usize = 16;
/// Number of samples of |w| over 0 … 2: between two, the phase of the farthest heights of 1 µm turns by a quarter of a radian.
pub const SPECULAR_SAMPLES: usize = 128;

/// XYZ weights of the lobe of each band over |w|, and its variance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Specular {
    /// Variance of u and of v in each band without a footprint.
    pub variances: Vec<f64>,
    /// Weights [band][sample of |w| over 0 … 2, ends included]: XYZ of |c_0|² summed over the band's wavelengths.
    pub weights: Vec<Vec<[f32; 3]>>,
}

impl Specular {
    /// Computes the lobes of the surface of `series` in the light of `settings`.
    pub fn new(series: &OrderSeries, settings: &TableSettings) -> Self {
        /// Number of wavelengths: about 1 nm apart, like the tables of the observer. Their weights are integrals, so that no narrow line
        /// falls between two.
        const COUNT: usize = 401;
        let wavelengths = Wavelengths::catmull_rom(&settings.illuminant, COUNT);
        let node = |i: usize| (wavelengths.wavenumbers[i], wavelengths.weights[i]);
        let reflectance = settings.reflectance.as_ref().map(|r| (r, MeanReflectance::new(r)));
        let blur = Blur::of_coherence(series.sigma).variance[0];
        let (mut variances, mut weights) = (Vec::new(), Vec::new());
        for band in 0..BANDS {
            let nodes: Vec<(f64, DVec3)> =
                (band * COUNT / BANDS..(band + 1) * COUNT / BANDS).map(node).collect();
            // Beside a narrow line some weights are negative.
            let total: f64 = nodes.iter().map(|(_, w)| w.element_sum().max(0.0)).sum();
            let mean = |f: &dyn Fn(f64) -> f64| {
                let weighed: f64 = nodes.iter().map(|(q, w)| f(*q) * w.element_sum().max(0.0)).sum();
                if total > 0.0 { weighed / total } else { f(nodes[0].0) }
            };
            variances.push(mean(&|q| blur / (q * q)));
            weights.push(
                (0..SPECULAR_SAMPLES)
                    .map(|i| {
                        let w = 2.0 * i as f64 / (SPECULAR_SAMPLES - 1) as f64;
                        // The lobe is so narrow that (u, v) = 0 throughout, and cos θ_h = |w|/2.
                        let reflected = |q: f64| {
                            reflectance
                                .as_ref()
                                .map_or(1.0, |(r, mean)| mean.ratio(r.at(1.0 / q, 0.5 * w), 0.5 * w))
                        };
                        let power = |q: f64| series.specular_power(2.0 * PI * q * w) * reflected(q);
                        let sum: DVec3 = nodes.iter().map(|(q, xyz)| *xyz * power(*q)).sum();
                        sum.as_vec3().to_array()
                    })
                    .collect(),
            );
        }
        Self { variances, weights }
    }
}
