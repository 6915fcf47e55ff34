//! The specular order in colour: the remaining mirror image, a lobe around the specular direction.
//!
//! At one wavelength it is |c_0(z)|² q² γ̂(q(u, v))/w², a Gaussian of (u, v) with the variance λ²/(8π²σ²) and the weight |c_0|²/w². Bands
//! of wavelengths share a variance.

use super::TableSettings;
use super::held::HeldFactor;
use crate::optics::quadrature::Wavelengths;
use crate::optics::reflectance::MeanReflectance;
use crate::optics::theory::Theory;
use crate::spectra::power::{Blur, OrderSeries};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Number of bands of wavelengths, a power of 4. Within one, the variance differs by up to 1 % from the band's
/// (`the_bands_of_the_specular_order_hold_the_lobe_of_a_mirror`). Only pixels beside the specular direction sum them, and sums of 4, 16 or all of them where their footprints are wider than the lobe.
pub const BANDS: usize = 64;
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
        let stam = settings.reflectance.as_ref().filter(|r| r.theory() == Theory::Stam);
        let reflectance = stam.map(|r| (r, MeanReflectance::new(r)));
        let held = settings.reflectance.as_ref().and_then(HeldFactor::new);
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
                        let reflected = |q: f64| match (&reflectance, &held) {
                            (Some((r, mean)), _) => mean.ratio(r.at(1.0 / q, 0.5 * w), 0.5 * w),
                            (None, Some(held)) => held.mean(q, 0.0, w),
                            (None, None) => 1.0,
                        };
                        let power = |q: f64| series.specular_power(2.0 * PI * q * w) * reflected(q);
                        let sum: DVec3 = nodes.iter().map(|(q, xyz)| *xyz * power(*q)).sum();
                        let scale = held.as_ref().map_or(DVec3::ONE, |held| held.scales(0.0, w).into());
                        (sum * scale).as_vec3().to_array()
                    })
                    .collect(),
            );
        }
        Self { variances, weights }
    }

    /// Returns the variance and the weights of sums of so many bands `together`; the variance is their mean by luminance.
    pub fn groups(&self, together: usize) -> impl Iterator<Item = (f64, Vec<[f32; 3]>)> {
        self.weights.chunks(together).zip(self.variances.chunks(together)).map(|(weights, variances)| {
            let sum =
                |sample: usize| -> Vec3 { weights.iter().map(|band| Vec3::from_array(band[sample])).sum() };
            let light = |band: &Vec<[f32; 3]>| {
                band.iter().map(|[x, y, z]| f64::from(x + y + z)).sum::<f64>().max(0.0)
            };
            let (mut weighed, mut total) = (0.0, 0.0);
            for (band, variance) in weights.iter().zip(variances) {
                (weighed, total) = (weighed + light(band) * variance, total + light(band));
            }
            let variance = if total > 0.0 { weighed / total } else { variances[0] };
            (variance, (0..SPECULAR_SAMPLES).map(|sample| sum(sample).to_array()).collect())
        })
    }
}
