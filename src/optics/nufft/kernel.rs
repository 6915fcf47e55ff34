//! The kernel between the bins of a transform, the exponential of a semicircle (Barnett, Magland and af Klinteberg 2019):
//! φ(t) = exp(β(√(1 − (2t/w)²) − 1)) over w = 10 bins.

use std::f64::consts::PI;

/// Width of the kernel in bins.
pub const TAPS: usize = 10;

/// φ for one shape parameter.
#[derive(Clone, Copy, Debug)]
pub struct GriddingKernel {
    beta: f64,
}

impl GriddingKernel {
    /// Returns the kernel with β = `shape`·w.
    pub fn new(shape: f64) -> Self {
        Self { beta: shape * TAPS as f64 }
    }

    /// Returns the offset of a tap from the bin at or below: −4 … 5.
    fn offset(tap: usize) -> f64 {
        tap as f64 - (TAPS as f64 / 2.0 - 1.0)
    }

    /// Returns φ at every tap for a place `fraction` ∈ \[0, 1) above a bin.
    pub fn weights(&self, fraction: f64) -> [f64; TAPS] {
        std::array::from_fn(|tap| self.at(fraction - Self::offset(tap)))
    }

    fn at(&self, t: f64) -> f64 {
        let inside = 1.0 - (2.0 * t / TAPS as f64).powi(2);
        (self.beta * (inside.max(0.0).sqrt() - 1.0)).exp()
    }

    /// Returns ∫ φ(t) e^{2πixt} dt, in the same units, at `x` = position/length within ±1/2: by the trapezoid rule over θ with
    /// 2t/w = sin θ, which errs by as much as φ has at its ends.
    pub fn transform(&self, x: f64) -> f64 {
        const STEPS: usize = 96;
        let half = TAPS as f64 / 2.0;
        let value = |i: usize| {
            let (sin, cos) = ((i as f64 / STEPS as f64 - 0.5) * PI).sin_cos();
            (self.beta * (cos - 1.0)).exp() * cos * (2.0 * PI * x * half * sin).cos()
        };
        (1..STEPS).map(value).sum::<f64>() * half * PI / STEPS as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_is_that_of_the_kernel() {
        let kernel = GriddingKernel::new(2.3);
        let half = TAPS as f64 / 2.0;
        for x in [0.0, 0.1, 0.3, 0.5] {
            let sum: f64 = (0..1000 * TAPS)
                .map(|i| {
                    let t = (i as f64 + 0.5) / 1000.0 - half;
                    kernel.at(t) * (2.0 * PI * x * t).cos() / 1000.0
                })
                .sum();
            assert!((kernel.transform(x) - sum).abs() < 1e-8, "{x}: {} {sum}", kernel.transform(x));
        }
    }
}
