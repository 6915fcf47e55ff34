//! The BRDF around the power |P|²: everything in it that does not depend on the surface's shape or material.

use super::geometry::Pair;
use std::f64::consts::PI;

/// Refractive index outside the surface.
const IOR_AIR: f64 = 1.0;

/// Returns Schlick's approximation of the intensity reflectance (\[Schlick 1994\]; \[Single 2014\] D.2) of a dielectric of refractive index
/// `ior` in air, at the half vector. It stands for F² of B.12, so it is applied once.
pub fn schlick(ior: f64, cos_half_angle: f64) -> f64 {
    schlick_from(((IOR_AIR - ior) / (IOR_AIR + ior)).powi(2), cos_half_angle)
}

/// Returns Schlick's approximation from the reflectance at normal incidence.
pub fn schlick_from(at_normal: f64, cos_half_angle: f64) -> f64 {
    at_normal + (1.0 - at_normal) * (1.0 - cos_half_angle.min(1.0)).powi(5)
}

/// Returns f·cos θ_i / R for a power `|P|²` \[µm⁴\] seen through a window of effective area `area` = ∬ g² \[µm²\] at `wavelength` \[µm\]
/// (\[Single 2014\] B.12): k² G cos θ_i / (4π² A w²) · |P|². It is 0 below the horizon.
pub fn cosine_weighted(pair: &Pair, wavelength: f64, area: f64, power: f64) -> f64 {
    if !pair.above_horizon() {
        return 0.0;
    }
    let k = 2.0 * PI / wavelength;
    let w = pair.uvw().z;
    k * k * pair.geometric_factor_times_cos_light() / (4.0 * PI * PI * area * w * w) * power
}

/// Returns f·cos θ_i / F for a power `|P|²`, as [`cosine_weighted`] with a factor F in place of R G cos θ_i: k²/(4π² A w²) · |P|².
pub fn per_factor(pair: &Pair, wavelength: f64, area: f64, power: f64) -> f64 {
    let (k, w) = (2.0 * PI / wavelength, pair.uvw().z);
    if w == 0.0 { 0.0 } else { k * k / (4.0 * PI * PI * area * w * w) * power }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schlick_is_the_normal_reflectance_at_normal_incidence_and_one_at_grazing() {
        assert!((schlick(1.5, 1.0) - 0.04).abs() < 1e-15);
        assert!((schlick(1.5, 0.0) - 1.0).abs() < 1e-15);
        // Half way: 0.04 + 0.96/32.
        assert!((schlick(1.5, 0.5) - 0.07).abs() < 1e-15);
    }
}
