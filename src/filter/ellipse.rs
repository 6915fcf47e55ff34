//! The Gaussian ellipse of (u, v) that a pixel averages over.

use glam::DVec2;

/// Covariance of (u, v) over the directions of a pixel, dimensionless.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Covariance {
    /// Variance of u.
    pub uu: f64,
    /// Covariance of u and v.
    pub uv: f64,
    /// Variance of v.
    pub vv: f64,
}

impl Covariance {
    /// Returns the covariance of a round Gaussian of standard deviation `deviation`.
    pub fn round(deviation: f64) -> Self {
        let variance = deviation * deviation;
        Self { uu: variance, uv: 0.0, vv: variance }
    }

    /// Computes the covariance J Jᵀ σ² of a footprint.
    ///
    /// `dx` and `dy` are the columns of J = ∂(u, v)/∂(pixel), σ = `sigma` \[pixels\] is the standard deviation of the Gaussian pixel filter.
    pub fn of_footprint(dx: DVec2, dy: DVec2, sigma: f64) -> Self {
        let s = sigma * sigma;
        Self {
            uu: s * (dx.x * dx.x + dy.x * dy.x),
            uv: s * (dx.x * dx.y + dy.x * dy.y),
            vv: s * (dx.y * dx.y + dy.y * dy.y),
        }
    }

    /// Returns the variances along the longer and the shorter axis.
    pub fn axes(&self) -> [f64; 2] {
        let (mean, difference) = (0.5 * (self.uu + self.vv), 0.5 * (self.uu - self.vv));
        let spread = difference.hypot(self.uv);
        [mean + spread, (mean - spread).max(0.0)]
    }

    /// Returns the unit vector along the longer axis.
    pub fn longer_axis(&self) -> DVec2 {
        DVec2::from_angle(0.5 * self.uv.atan2(0.5 * (self.uu - self.vv)))
    }
}

/// Sizes of the footprints of a picture: the shorter axis sets how fine a source has to be, the longer one how much taps average.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FootprintSizes {
    /// Standard deviation of (u, v) along the shorter axis that 98 % of the pixels exceed; 0 for single directions.
    pub shorter: f64,
    /// Standard deviation along the longer axis that 75 % of the pixels exceed, over all samples of a pixel together.
    pub longer: f64,
}

impl FootprintSizes {
    /// Returns the smaller sizes of two pictures, so that a source resolves both. A picture without footprints does not count.
    #[must_use]
    pub fn finer(self, other: Self) -> Self {
        match (self.longer > 0.0, other.longer > 0.0) {
            (true, false) => self,
            (false, _) => other,
            _ => Self { shorter: self.shorter.min(other.shorter), longer: self.longer.min(other.longer) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_those_of_the_covariance() {
        let c = Covariance { uu: 4e-4, uv: 3e-4, vv: 3e-4 };
        let [longer, shorter] = c.axes();
        let axis = c.longer_axis();
        let along = c.uu * axis.x * axis.x + 2.0 * c.uv * axis.x * axis.y + c.vv * axis.y * axis.y;
        assert!((along - longer).abs() < 1e-15 && (longer + shorter - 7e-4).abs() < 1e-15);
        assert!((longer * shorter - (c.uu * c.vv - c.uv * c.uv)).abs() < 1e-18);
    }

    #[test]
    fn the_finer_of_two_pictures_counts_and_one_without_footprints_does_not() {
        let sizes = |shorter, longer| FootprintSizes { shorter, longer };
        assert_eq!(sizes(1e-3, 5e-2).finer(sizes(2e-3, 3e-2)), sizes(1e-3, 3e-2));
        let none = FootprintSizes::default();
        assert_eq!(sizes(1e-3, 5e-2).finer(none), sizes(1e-3, 5e-2));
        assert_eq!(none.finer(sizes(1e-3, 5e-2)), sizes(1e-3, 5e-2));
        assert_eq!(none.finer(none), none);
    }
}
