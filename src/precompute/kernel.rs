//! Reading a spectrum between its samples: which kernel, how many texels, and the error that remains.
//!
//! A kernel that interpolates in frequency multiplies the window's space by the kernel's transform and adds copies of it,
//! displaced by the padded length L and damped by the same transform. Dividing the window by the transform first
//! ("deapodisation", as in gridding and non-uniform FFTs; Jackson et al. 1991) undoes the multiplication; the damped
//! copies remain as the error.

use serde::{Deserialize, Serialize};

/// How the shader reads between texels along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kernel {
    /// The hardware's own linear interpolation; transform sinc².
    Linear,
    /// Cubic B-spline, from two hardware samples (Sigg & Hadwiger 2005); transform sinc⁴.
    Cubic,
}

impl Kernel {
    /// Hardware samples along the axis.
    pub fn samples(self) -> u32 {
        match self {
            Self::Linear => 1,
            Self::Cubic => 2,
        }
    }

    /// Texels along the axis.
    pub fn texels(self) -> usize {
        match self {
            Self::Linear => 2,
            Self::Cubic => 4,
        }
    }

    /// Texels needed beyond the band on each side.
    pub fn guard(self) -> usize {
        match self {
            Self::Linear => 1,
            Self::Cubic => 2,
        }
    }

    /// Weights of the four texels around a place at `t` ∈ \[0, 1\] between the middle two.
    pub fn weights(self, t: f64) -> [f64; 4] {
        match self {
            Self::Linear => [0.0, 1.0 - t, t, 0.0],
            Self::Cubic => {
                let (t2, t3) = (t * t, t * t * t);
                let first = (1.0 - 3.0 * t + 3.0 * t2 - t3) / 6.0;
                let second = (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0;
                [first, second, 1.0 - first - second - t3 / 6.0, t3 / 6.0]
            }
        }
    }

    /// Second derivatives of [`Kernel::weights`] by the place; of the linear kernel the mean of the second differences at both texels.
    pub fn curvatures(self, t: f64) -> [f64; 4] {
        match self {
            Self::Linear => [0.5, -0.5, -0.5, 0.5],
            Self::Cubic => [1.0 - t, 3.0 * t - 2.0, 1.0 - 3.0 * t, t],
        }
    }

    /// Variance of the kernel \[texels²\]: a B-spline is a sum of uniform distributions of width 1, whose variances of 1/12 add.
    pub fn variance(self) -> f64 {
        match self {
            Self::Linear => 1.0 / 6.0,
            Self::Cubic => 1.0 / 3.0,
        }
    }

    /// The word for it in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Cubic => "cubic",
        }
    }

    /// The kernel's transform at `x` = position/L.
    pub fn transform(self, x: f64) -> f64 {
        let sinc = if x == 0.0 { 1.0 } else { (std::f64::consts::PI * x).sin() / (std::f64::consts::PI * x) };
        match self {
            Self::Linear => sinc.powi(2),
            Self::Cubic => sinc.powi(4),
        }
    }

    /// RMS amplitude error along one axis, relative to the local RMS amplitude, for a Gaussian window of standard
    /// deviation σ on a padded length L = `ratio`·σ: the energy of the damped copies, and of what L cuts off.
    pub fn amplitude_error(self, ratio: f64) -> f64 {
        const STEPS: usize = 2000;
        let step = 2.0 * 8.0 / STEPS as f64;
        let (mut error, mut energy) = (0.0, 0.0);
        for i in 0..STEPS {
            let x = (i as f64 + 0.5) * step - 8.0;
            let g2 = (-x * x).exp();
            energy += g2;
            error += if x.abs() > ratio / 2.0 { g2 } else { g2 * self.copies(x / ratio) };
        }
        (error / energy).sqrt()
    }

    /// Energy of the displaced copies at `x` = position/L, |x| ≤ ½, relative to what stands there itself. sin²(π(x + m)) is the same for all m,
    /// so that transform(x + m)/transform(x) is a power of x/(x + m).
    fn copies(self, x: f64) -> f64 {
        const COPIES: i32 = 3; // the transform falls as m⁻² or m⁻⁴
        let ratio = |m: i32| match self {
            Self::Linear => (x / (x + f64::from(m))).powi(4),
            Self::Cubic => (x / (x + f64::from(m))).powi(8),
        };
        (1..=COPIES).map(|m| ratio(m) + ratio(-m)).sum()
    }

    /// The smallest L/σ up to `most` for an amplitude error along one axis of at most `allowed`.
    fn smallest_ratio(self, allowed: f64, most: f64) -> Option<f64> {
        let mut ratio = 6.0;
        while ratio <= most {
            if self.amplitude_error(ratio) <= allowed {
                return Some(ratio);
            }
            ratio *= 1.01;
        }
        None
    }
}

impl Kernel {
    /// As [`Kernel::amplitude_error`], for one period without a window, 1 over T and 0 beyond, on a padded length L = `ratio`·T ≥ T.
    pub fn amplitude_error_of_patch(self, ratio: f64) -> f64 {
        const STEPS: i32 = 1000;
        let error = |i: i32| self.copies(((f64::from(i) + 0.5) / f64::from(STEPS) - 0.5) / ratio);
        ((0..STEPS).map(error).sum::<f64>() / f64::from(STEPS)).sqrt()
    }
}

/// A kernel for each axis, and the padded lengths that they need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolation {
    /// The kernels along f_x and f_y.
    pub kernels: [Kernel; 2],
    /// L/σ along x and y.
    pub ratios: [f64; 2],
}

/// Intensities of speckle are exponentially distributed; the RMS of relative intensity errors over directions is the
/// relative amplitude error times 2·√ln(1/floor), with the floor at a thousandth of the local mean.
pub const SPECKLE: f64 = 2.0 * 2.628;

/// Up to this L/σ one linear sample wins; beyond, textures outgrow every cache.
const MOST_LINEAR: f64 = 13.0;
/// Up to this L/σ along the linear axis two samples win over the four of a cubic kernel along both axes.
const MOST_MIXED: f64 = 26.0;
/// Longer than this, and the rounding of 32-bit layers is the larger error.
const MOST_CUBIC: f64 = 64.0;
/// Part of the error's square that the cubic axis of a mixed kernel may have: its error falls with the fourth power of
/// the length, so a small part costs it little.
const CUBIC_PART: f64 = 0.1;

impl Interpolation {
    /// The cheapest interpolation of the spectrum of one period without a window, with ratios L/T, and its RMS relative
    /// intensity error: at most `tolerance`, or as small as there is.
    pub fn of_patch(tolerance: f64) -> (Self, f64) {
        const MOST: [(Kernel, f64); 2] = [(Kernel::Linear, 6.0), (Kernel::Cubic, 16.0)];
        let mut last = (Self { kernels: [Kernel::Cubic; 2], ratios: [MOST[1].1; 2] }, f64::INFINITY);
        for (kernel, most) in MOST {
            let mut ratio = 1.2;
            while ratio <= most {
                let error = SPECKLE * std::f64::consts::SQRT_2 * kernel.amplitude_error_of_patch(ratio);
                last = (Self { kernels: [kernel; 2], ratios: [ratio; 2] }, error);
                if last.1 <= tolerance {
                    return last;
                }
                ratio *= 1.02;
            }
        }
        last
    }

    /// The cheapest interpolation whose RMS relative intensity error over single directions and wavelengths is at most
    /// `tolerance`, or the finest there is.
    pub fn for_tolerance(tolerance: f64) -> Self {
        use Kernel::{Cubic, Linear};
        let allowed = tolerance / SPECKLE;
        let along = |kernel: Kernel, part: f64, most: f64| kernel.smallest_ratio(allowed * part.sqrt(), most);
        if let Some(ratio) = along(Linear, 0.5, MOST_LINEAR) {
            return Self { kernels: [Linear; 2], ratios: [ratio; 2] };
        }
        if let Some(y) = along(Linear, 1.0 - CUBIC_PART, MOST_MIXED)
            && let Some(x) = along(Cubic, CUBIC_PART, y)
        {
            return Self { kernels: [Cubic, Linear], ratios: [x, y] };
        }
        let ratio = along(Cubic, 0.5, MOST_CUBIC).unwrap_or(MOST_CUBIC);
        Self { kernels: [Cubic; 2], ratios: [ratio; 2] }
    }

    /// Hardware samples per read.
    pub fn samples(&self) -> u32 {
        self.kernels[0].samples() * self.kernels[1].samples()
    }

    /// RMS amplitude error, relative to the local RMS amplitude.
    pub fn amplitude_error(&self) -> f64 {
        let along = |axis: usize| self.kernels[axis].amplitude_error(self.ratios[axis]);
        along(0).hypot(along(1))
    }

    /// RMS relative intensity error over single directions and wavelengths.
    pub fn relative_error(&self) -> f64 {
        SPECKLE * self.amplitude_error()
    }

    /// The words for it in reports: the kernel, or the kernels along f_x and f_y.
    pub fn name(&self) -> String {
        let [x, y] = self.kernels.map(Kernel::name);
        if x == y { x.to_owned() } else { format!("{x} x {y}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_falls_with_the_square_and_the_fourth_power_of_the_length() {
        let fall = |k: Kernel| k.amplitude_error(24.0) / k.amplitude_error(48.0);
        assert!((fall(Kernel::Linear) / 4.0 - 1.0).abs() < 0.15, "{}", fall(Kernel::Linear));
        assert!((fall(Kernel::Cubic) / 16.0 - 1.0).abs() < 0.3, "{}", fall(Kernel::Cubic));
    }

    #[test]
    fn copies_are_damped_by_the_transform() {
        for kernel in [Kernel::Linear, Kernel::Cubic] {
            for x in [-0.5, -0.3, 0.01, 0.2, 0.499] {
                let copy = |m: f64| (kernel.transform(x + m) / kernel.transform(x)).powi(2);
                let sum: f64 = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0].map(copy).iter().sum();
                assert!((kernel.copies(x) / sum - 1.0).abs() < 1e-10, "{kernel:?} {x}");
            }
        }
    }

    #[test]
    fn a_tolerance_gets_the_kernels_and_lengths_it_needs() {
        for (tolerance, samples) in [(1e-1, 1), (3e-2, 2), (1e-3, 4)] {
            let found = Interpolation::for_tolerance(tolerance);
            eprintln!("{tolerance:e}: {found:?}");
            assert_eq!(found.samples(), samples);
            assert!(found.relative_error() <= tolerance && found.ratios[1] <= MOST_MIXED, "{found:?}");
        }
    }
}
