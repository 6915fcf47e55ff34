//! Normal distributions over frequencies.

use crate::filter::Covariance;
use crate::spectra::power::Blur;
use glam::DVec2;
use std::f64::consts::PI;

/// Standard deviations of the blur beyond which orders are neglected: e^(−r²/2) = 1e-10.
pub(super) const CUT: f64 = 6.8;
/// Distance \[orders\] within which orders are summed even beyond [`CUT`].
pub(super) const NEAREST: f64 = 2.0;

/// Normal distribution over frequencies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    /// Covariance \[µm⁻²\].
    pub xx: f64,
    pub xy: f64,
    pub yy: f64,
    determinant: f64,
    /// Density at 0 \[µm²\].
    peak: f64,
}

impl Spread {
    /// Returns the sum of `blur` and, at wavenumber `q` \[µm⁻¹\], of the covariance of directions.
    pub fn new(blur: Blur, footprint: &Covariance, q: f64) -> Self {
        let [x, y] = blur.variance;
        Self::of(x + q * q * footprint.uu, q * q * footprint.uv, y + q * q * footprint.vv)
    }

    fn of(xx: f64, xy: f64, yy: f64) -> Self {
        let determinant = xx * yy - xy * xy;
        Self { xx, xy, yy, determinant, peak: 1.0 / (2.0 * PI * determinant.sqrt()) }
    }

    /// Returns the distribution whose covariance is smaller by `variance` along x and y \[µm⁻²\]; `None` unless the
    /// result is at least as wide as `variance` in every direction.
    pub fn beyond(&self, variance: [f64; 2]) -> Option<Self> {
        let [x, y] = variance;
        let (left_x, left_y) = (self.xx - 2.0 * x, self.yy - 2.0 * y);
        let wider = left_x > 0.0 && left_y > 0.0 && left_x * left_y > self.xy * self.xy;
        wider.then(|| Self::of(self.xx - x, self.xy, self.yy - y))
    }

    /// Returns the density at `d` \[µm²\].
    pub fn density(&self, d: DVec2) -> f64 {
        let squares = self.yy * d.x * d.x - 2.0 * self.xy * d.x * d.y + self.xx * d.y * d.y;
        self.peak * (-0.5 * squares / self.determinant).exp()
    }

    /// Calls `each` with an index from 0 and the density \[µm²\] for `count` points, from `from` in steps of `step`
    /// along x.
    pub fn densities(&self, from: DVec2, step: f64, count: usize, mut each: impl FnMut(usize, f64)) {
        /// Up to this number densities are computed one by one.
        const FEW: usize = 6;
        if count <= FEW {
            (0..count).for_each(|k| each(k, self.density(from + DVec2::new(k as f64 * step, 0.0))));
            return;
        }
        // Each density is the previous one times a factor, which itself changes by a constant factor.
        let along = (self.yy * (2.0 * from.x + step) - 2.0 * self.xy * from.y) * step;
        let mut factor = (-0.5 * along / self.determinant).exp();
        let growth = (-self.yy * step * step / self.determinant).exp();
        let mut density = self.density(from);
        for k in 0..count {
            each(k, density);
            density *= factor;
            factor *= growth;
        }
    }

    /// Returns the range of x, relative to the centre, in which a row `y` is within [`CUT`] standard deviations, or
    /// within `nearest` of its maximum.
    pub fn row(&self, y: f64, nearest: f64) -> [f64; 2] {
        let left = (CUT * CUT - y * y / self.yy).max(0.0);
        let middle = y * self.xy / self.yy;
        let half = (left * self.determinant / self.yy).sqrt().max(nearest);
        [middle - half, middle + half]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_along_a_row_are_those_of_each_point() {
        let spread = Spread::of(0.3, -0.2, 0.5);
        for (steps, y) in [(3, 0.1), (40, -1.3), (400, 2.9)] {
            let [left, right] = spread.row(y, 0.0);
            let step = (right - left) / f64::from(steps);
            spread.densities(DVec2::new(left, y), step, steps as usize + 1, |i, found| {
                let exact = spread.density(DVec2::new(left + i as f64 * step, y));
                assert!((found / exact - 1.0).abs() < 1e-10, "step {i} of {steps}: {found}, {exact}");
            });
        }
    }
}
