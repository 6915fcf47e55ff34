//! Part of a footprint in which there are directions: |u| and |v| are at most 2.

use super::spread::{CUT, Spread};
use crate::filter::Covariance;
use glam::DVec2;
use libm::erf;
use std::f64::consts::SQRT_2;

/// Fraction of each order's Gaussian that lies within the directions of a footprint.
///
/// The product of an order at f, blurred by coherence, and a footprint about g is along each axis a Gaussian about the
/// mean of f and g, weighted by their inverse variances. Its part within the limits is a difference of two error
/// functions. Without a footprint the fraction is 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenPart {
    /// Both axes, if the footprint reaches beyond the limits.
    axes: Option<[SeenAxis; 2]>,
}

#[derive(Clone, Copy, Debug)]
struct SeenAxis {
    /// Largest frequency of a direction \[µm⁻¹\].
    limit: f64,
    /// Centre of the footprint \[µm⁻¹\].
    middle: f64,
    /// Weight of an order's frequency in the weighted mean; the rest is the weight of the centre.
    of_order: f64,
    /// Standard deviation about the weighted mean \[µm⁻¹\].
    deviation: f64,
}

impl SeenPart {
    /// The whole of every order.
    #[cfg(test)]
    pub const ALL: Self = Self { axes: None };

    /// Returns the part of `footprint` about the frequency `middle` \[µm⁻¹\] at wavenumber `q` \[µm⁻¹\];
    /// `spread` is the blur by coherence and footprint together.
    pub fn new(middle: DVec2, spread: &Spread, footprint: &Covariance, q: f64) -> Self {
        let limit = 2.0 * q;
        let axis = |middle: f64, both: f64, footprint: f64| {
            let of_order = (footprint / both).clamp(0.0, 1.0);
            SeenAxis { limit, middle, of_order, deviation: (of_order * (both - footprint)).max(0.0).sqrt() }
        };
        let axes = [
            axis(middle.x, spread.xx, q * q * footprint.uu),
            axis(middle.y, spread.yy, q * q * footprint.vv),
        ];
        let ends_within = |axis: &SeenAxis, variance: f64| axis.middle.abs() + CUT * variance.sqrt() < limit;
        let all = ends_within(&axes[0], q * q * footprint.uu) && ends_within(&axes[1], q * q * footprint.vv);
        Self { axes: (!all).then_some(axes) }
    }

    /// Returns the fraction of an order at the frequency `order` \[µm⁻¹\], 0 to 1: the product of those along x and y.
    pub fn share(&self, order: DVec2) -> f64 {
        self.share_along(0, order.x) * self.share_along(1, order.y)
    }

    /// Returns the fraction along x (`axis` 0) or y (1) of an order at the frequency `order` \[µm⁻¹\] on this axis.
    pub fn share_along(&self, axis: usize, order: f64) -> f64 {
        self.axes.as_ref().map_or(1.0, |axes| axes[axis].share(order))
    }
}

impl SeenAxis {
    fn share(&self, order: f64) -> f64 {
        let mean = self.of_order * order + (1.0 - self.of_order) * self.middle;
        if self.deviation == 0.0 {
            return if mean.abs() <= self.limit { 1.0 } else { 0.0 };
        }
        let below = |x: f64| 0.5 * (1.0 + erf((x - mean) / (SQRT_2 * self.deviation)));
        below(self.limit) - below(-self.limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectra::power::Blur;

    #[test]
    fn shares_are_those_of_a_sum_over_the_directions_that_exist() {
        let (q, coherence) = (2.0, 0.03f64);
        let blur = Blur { variance: [coherence.powi(2); 2] };
        for (u, deviation) in [(1.7, 0.3), (1.95, 0.05), (-1.9, 0.5)] {
            let footprint = Covariance { uu: deviation * deviation, uv: 0.0, vv: 1e-6 };
            let middle = DVec2::new(u * q, 0.1);
            let spread = Spread::new(blur, &footprint, q);
            let seen = SeenPart::new(middle, &spread, &footprint, q);
            for order in [1.2, 1.9, 2.0, 2.1, 2.6] {
                let order = DVec2::new(order * q * f64::signum(u), 0.1);
                let density = |x: f64, variance: f64| (-0.5 * x * x / variance).exp();
                let places = (-40_000..=40_000).map(|i| 1e-4 * f64::from(i));
                let product = |f: f64| {
                    density(f - middle.x, q * q * footprint.uu) * density(f - order.x, blur.variance[0])
                };
                let within: f64 = places.map(product).sum();
                let all: f64 = (-200_000..=200_000).map(|i| product(1e-4 * f64::from(i))).sum();
                let found = seen.share(order);
                // The sum ends halfway between points 1e-4 apart, where the density over the narrowest deviation, 0.05,
                // is 8.
                assert!((found - within / all).abs() < 1e-3, "{u} {order}: {found}, {}", within / all);
            }
        }
    }

    #[test]
    fn without_a_footprint_everything_is_seen() {
        let blur = Blur { variance: [1e-3; 2] };
        for u in [0.0, 1.3, 1.999] {
            let footprint = Covariance::default();
            let seen =
                SeenPart::new(DVec2::new(2.0 * u, 0.0), &Spread::new(blur, &footprint, 2.0), &footprint, 2.0);
            assert_eq!(seen.share(DVec2::new(4.2, 0.0)), 1.0, "{u}");
        }
    }
}
