//! Factor F in front of the power |P|²: f cos θ_i = k² F/(4π² A w²) · |P|². It depends on the two directions, the
//! material and the [`Theory`].

use super::brdf::{cosine_weighted, per_factor};
use super::geometry::Pair;
use super::material::LARGEST_INDEX;
use super::polarisation::Polarisation;
use super::reflectance::Reflectance;
use super::small_slope::{Incidence, intensity};
use super::theory::Theory;
use glam::DVec3;
use rustfft::num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Factor F for light from one direction at one wavelength.
pub enum Factor<'a> {
    /// R G cos θ_i (\[Single 2014\] B.12).
    Stam {
        /// Reflectance R.
        reflectance: &'a Reflectance,
        /// Wavelength \[µm\].
        wavelength: f64,
        /// Direction ω_i to the light.
        light: DVec3,
    },
    /// 4 cos² θ_i cos θ_r |B|² ([`super::small_slope`]).
    SmallSlope(Incidence),
}

impl Factor<'_> {
    /// Returns F toward `view`; 0 below the horizon.
    pub fn toward(&self, view: DVec3) -> f64 {
        match self {
            Self::Stam { reflectance, wavelength, light } => {
                let pair = Pair::new(*light, view);
                if !pair.above_horizon() {
                    return 0.0;
                }
                reflectance.at(*wavelength, pair.cos_half_angle()) * pair.geometric_factor_times_cos_light()
            }
            Self::SmallSlope(incidence) => incidence.factor(view),
        }
    }
}

impl Reflectance {
    /// Returns the factor for light from the direction `light` at `wavelength` \[µm\].
    pub fn factor(&self, light: DVec3, wavelength: f64) -> Factor<'_> {
        match self.theory() {
            Theory::Stam => Factor::Stam { reflectance: self, wavelength, light },
            Theory::SmallSlope => {
                Factor::SmallSlope(Incidence::new(self.index_at(wavelength), light, self.polarisation()))
            }
        }
    }

    /// Returns f·cos θ_i for a power `|P|²` \[µm⁴\] seen through a window of effective area `area` = ∬ g² \[µm²\] at
    /// `wavelength` \[µm\], without a limit of energy. It is 0 below the horizon.
    pub fn cosine_weighted(&self, pair: &Pair, wavelength: f64, area: f64, power: f64) -> f64 {
        match self.theory() {
            Theory::Stam => {
                self.at(wavelength, pair.cos_half_angle()) * cosine_weighted(pair, wavelength, area, power)
            }
            Theory::SmallSlope => {
                self.factor(pair.light, wavelength).toward(pair.view)
                    * per_factor(pair, wavelength, area, power)
            }
        }
    }
}

/// Refractive indices n + ik that stand for X, Y and Z in the factor of a colour, whose sums over wavelengths contain
/// the ratio of |B|² to that of the index.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndexTriple {
    /// n for X, Y and Z.
    pub n: [f64; 3],
    /// k for X, Y and Z.
    pub k: [f64; 3],
    /// Polarisation of the light.
    pub polarisation: Polarisation,
}

impl IndexTriple {
    /// Returns the indices of `reflectance` at the wavelengths around which X, Y and Z have most of their light.
    pub fn of(reflectance: &Reflectance) -> Self {
        /// Centroids of the larger lobe of x̄, of ȳ and of z̄ in daylight \[µm\].
        const CENTRES: [f64; 3] = [0.595, 0.557, 0.449];
        let indices = CENTRES.map(|wavelength| reflectance.index_at(wavelength));
        Self { n: indices.map(|n| n.re), k: indices.map(|n| n.im), polarisation: reflectance.polarisation() }
    }

    /// Returns n + ik for X, Y and Z.
    pub fn complex(&self) -> [Complex64; 3] {
        [0, 1, 2].map(|i| Complex64::new(self.n[i], self.k[i]))
    }

    /// Returns |B|² of `pair` for X, Y and Z.
    pub fn intensity(&self, pair: &Pair) -> [f64; 3] {
        self.complex().map(|index| intensity(index, pair, self.polarisation))
    }

    /// Returns true if the numbers can be those of a material.
    pub fn is_sound(&self) -> bool {
        self.n.iter().all(|n| *n > 0.0 && *n <= LARGEST_INDEX)
            && self.k.iter().all(|k| (0.0..=LARGEST_INDEX).contains(k))
    }
}
