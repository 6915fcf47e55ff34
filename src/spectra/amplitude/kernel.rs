//! Interpolation of a spectrum between its samples: the kernel, its number of texels, and the remaining error.
//!
//! A kernel that interpolates in frequency multiplies the window's space by the kernel's transform and adds copies of it, displaced by the
//! padded length L and damped by the same transform. Dividing the window by the transform first ("deapodisation", as in gridding and
//! non-uniform FFTs; Jackson et al. 1991) undoes the multiplication; the damped copies remain as the error.

use crate::budget::SPECKLE;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Interpolation of the shader between texels along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kernel {
    /// Linear interpolation by a sampler; transform sinc².
    Linear,
    /// Cubic B-spline, from two linear samples (Sigg & Hadwiger 2005) or four texels; transform sinc⁴.
    Cubic,
}

impl Kernel {
    /// Returns the number of linear samples along the axis.
    pub fn samples(self) -> usize {
        match self {
            Self::Linear => 1,
            Self::Cubic => 2,
        }
    }

    /// Returns the number of texels along the axis.
    pub fn texels(self) -> usize {
        match self {
            Self::Linear => 2,
            Self::Cubic => 4,
        }
    }

    /// Returns the number of texels needed beyond the band on each side.
    pub fn guard(self) -> usize {
        match self {
            Self::Linear => 1,
            Self::Cubic => 2,
        }
    }

    /// Returns the weights of the four texels around a place at `t` ∈ \[0, 1\] between the middle two.
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

    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Cubic => "cubic",
        }
    }

    /// Returns the kernel's transform at `x` = position/L.
    pub fn transform(self, x: f64) -> f64 {
        let sinc = if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
        match self {
            Self::Linear => sinc.powi(2),
            Self::Cubic => sinc.powi(4),
        }
    }

    /// Returns the RMS amplitude error along one axis, relative to the local RMS amplitude, of interpolation on a padded length of `ratio`,
    /// by a sampler or by texels.
    fn amplitude_error(self, ratio: f64, of: Transformed) -> f64 {
        let (kernel_error, rounding) = (self.own_error(ratio, of), self.rounding_error(ratio, of));
        if is_too_coarse(rounding, kernel_error) { kernel_error } else { kernel_error.hypot(rounding) }
    }

    /// Returns true if the shader has to weight texels, because a sampler is too coarse.
    fn weighs_texels(self, ratio: f64, of: Transformed) -> bool {
        is_too_coarse(self.rounding_error(ratio, of), self.own_error(ratio, of))
    }

    /// Returns the error of the kernel alone: the energy of the damped copies, and of the part of the window beyond the padded length.
    fn own_error(self, ratio: f64, of: Transformed) -> f64 {
        const STEPS: usize = 2000;
        let reach = of.reach();
        let (mut error, mut energy) = (0.0, 0.0);
        for i in 0..STEPS {
            let x = ((i as f64 + 0.5) / STEPS as f64 - 0.5) * reach;
            let power = of.power(x);
            energy += power;
            error += if x.abs() > ratio / 2.0 { power } else { power * self.copies(x / ratio) };
        }
        (error / energy).sqrt()
    }

    /// Returns the error of a sampler that rounds the place between two texels. By Parseval, texels differ by 2π/`ratio` times the RMS
    /// distance from the middle of the transformed function.
    fn rounding_error(self, ratio: f64, of: Transformed) -> f64 {
        // RMS of a uniform distribution over a step, in texels.
        let rounded = PLACE_STEP / 12f64.sqrt();
        // Two samples of a B-spline weigh a = (5 − 3t − 3t² + 2t³)/6 and 1 − a at the place t: the root of the mean of a² + (1 − a)².
        const TWO_SAMPLES: f64 = 0.763;
        let share = match self {
            Self::Linear => 1.0,
            Self::Cubic => TWO_SAMPLES,
        };
        rounded * share * 2.0 * PI * of.spread() / ratio
    }

    /// Returns the energy of the displaced copies at `x` = position/L, |x| ≤ ½, relative to the energy of the function there. sin²(π(x +
    /// m)) is the same for all m, so that transform(x + m)/transform(x) is a power of x/(x + m).
    fn copies(self, x: f64) -> f64 {
        const COPIES: i32 = 3; // the transform falls as m⁻² or m⁻⁴
        let ratio = |m: i32| match self {
            Self::Linear => (x / (x + f64::from(m))).powi(4),
            Self::Cubic => (x / (x + f64::from(m))).powi(8),
        };
        (1..=COPIES).map(|m| ratio(m) + ratio(-m)).sum()
    }

    /// Returns the smallest padded length up to `most` for an amplitude error along one axis of at most `allowed`.
    fn smallest_ratio(self, of: Transformed, allowed: f64, most: f64) -> Option<f64> {
        let mut ratio = of.lengths().least;
        while ratio <= most {
            if self.amplitude_error(ratio, of) <= allowed {
                return Some(ratio);
            }
            ratio *= 1.01;
        }
        None
    }
}

/// Samplers round a place between two texels to multiples of this: GPUs of all makers keep 8 bits of it (`subTexelPrecisionBits`; Vulkan promises 4).
const PLACE_STEP: f64 = 1.0 / 256.0;
/// Largest error of a sampler relative to the kernel's error: 0.5 makes both together 12 % larger, because squares add up.
const MOST_ROUNDING: f64 = 0.5;

fn is_too_coarse(rounding: f64, kernel_error: f64) -> bool {
    rounding > MOST_ROUNDING * kernel_error
}

/// Transformed function, and the unit of its padded length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Transformed {
    /// Surface through a Gaussian window, in standard deviations.
    Window,
    /// One period, 1 over its length and 0 beyond, in periods.
    Period,
}

impl Transformed {
    /// Returns the squared amplitude at `x`.
    fn power(self, x: f64) -> f64 {
        match self {
            Self::Window => (-x * x).exp(),
            Self::Period => 1.0,
        }
    }

    /// Returns the length that holds all of the function.
    fn reach(self) -> f64 {
        match self {
            Self::Window => 16.0,
            Self::Period => 1.0,
        }
    }

    /// Returns the RMS distance from the middle.
    fn spread(self) -> f64 {
        match self {
            Self::Window => FRAC_1_SQRT_2,
            Self::Period => 1.0 / 12f64.sqrt(),
        }
    }

    fn lengths(self) -> PaddedLengths {
        match self {
            Self::Window => PaddedLengths { least: 6.0, linear: 13.0, mixed: 26.0, cubic: 64.0 },
            Self::Period => PaddedLengths { least: 1.2, linear: 6.0, mixed: 0.0, cubic: 16.0 },
        }
    }
}

/// Ranges of padded lengths in which the kernels are tried.
struct PaddedLengths {
    /// Shortest sensible length.
    least: f64,
    /// Length up to which one linear sample is fastest; longer textures outgrow every cache.
    linear: f64,
    /// Length along the linear axis up to which two samples are faster than the four of a cubic kernel along both axes.
    mixed: f64,
    /// Length beyond which the rounding of 32-bit layers is the larger error.
    cubic: f64,
}

/// Kernel for each axis, and the padded lengths that they need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolation {
    /// Transformed function.
    pub of: Transformed,
    /// The kernels along f_x and f_y.
    pub kernels: [Kernel; 2],
    /// Padded lengths along x and y, in the unit of the transformed function.
    pub ratios: [f64; 2],
}

/// Part of the squared error for the cubic axis of a mixed kernel: its error falls with the fourth power of the length, so a small part
/// costs it little.
const CUBIC_PART: f64 = 0.1;

impl Interpolation {
    /// Returns the cheapest interpolation whose RMS relative intensity error over single directions and wavelengths is at most `tolerance`,
    /// or the finest available.
    pub fn for_tolerance(tolerance: f64, of: Transformed) -> Self {
        use Kernel::{Cubic, Linear};
        let (allowed, most) = (tolerance / SPECKLE, of.lengths());
        let along =
            |kernel: Kernel, part: f64, most: f64| kernel.smallest_ratio(of, allowed * part.sqrt(), most);
        if let Some(ratio) = along(Linear, 0.5, most.linear) {
            return Self { of, kernels: [Linear; 2], ratios: [ratio; 2] };
        }
        if let Some(y) = along(Linear, 1.0 - CUBIC_PART, most.mixed)
            && let Some(x) = along(Cubic, CUBIC_PART, y)
        {
            return Self { of, kernels: [Cubic, Linear], ratios: [x, y] };
        }
        let ratio = along(Cubic, 0.5, most.cubic).unwrap_or(most.cubic);
        Self { of, kernels: [Cubic; 2], ratios: [ratio; 2] }
    }

    /// Returns true if the shader weights texels itself, because a sampler is too coarse.
    pub fn weighs_texels(&self) -> bool {
        (0..2).any(|axis| self.kernels[axis].weighs_texels(self.ratios[axis], self.of))
    }

    /// Returns the number of reads of a layer: texels if the shader weights them, otherwise linear samples.
    pub fn reads(&self) -> usize {
        let weighs_texels = self.weighs_texels();
        let along = |kernel: Kernel| if weighs_texels { kernel.texels() } else { kernel.samples() };
        self.kernels.map(along).into_iter().product()
    }

    /// Returns the RMS amplitude error, relative to the local RMS amplitude.
    pub fn amplitude_error(&self) -> f64 {
        let along = |axis: usize| self.kernels[axis].amplitude_error(self.ratios[axis], self.of);
        along(0).hypot(along(1))
    }

    /// Returns the RMS relative intensity error over single directions and wavelengths.
    pub fn relative_error(&self) -> f64 {
        SPECKLE * self.amplitude_error()
    }

    /// Returns the name in reports: the kernel, or the kernels along f_x and f_y.
    pub fn name(&self) -> String {
        let [x, y] = self.kernels.map(Kernel::name);
        if x == y { x.to_owned() } else { format!("{x} x {y}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn the_error_falls_with_the_square_and_the_fourth_power_of_the_length() {
        let fall =
            |k: Kernel| k.own_error(24.0, Transformed::Window) / k.own_error(48.0, Transformed::Window);
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
    fn rounded_places_err_as_predicted() {
        // Independent phases make a window's spectrum: the sum over positions of the function there, at one frequency.
        let mut random = Random::new(1);
        for (kernel, ratio) in [(Kernel::Linear, 8.0), (Kernel::Linear, 13.0), (Kernel::Cubic, 16.0)] {
            let (mut error, mut power) = (0.0, 0.0);
            for _ in 0..400 {
                let phases: [f64; 64] = std::array::from_fn(|_| random.share());
                let place = random.share();
                // The divided window's spectrum at a whole number of texels, real part.
                let texel = |n: f64| -> f64 {
                    let of = |(i, phase): (usize, &f64)| {
                        let x = (i as f64 - 31.5) / 8.0;
                        let g = (-0.5 * x * x).exp() / kernel.transform(x / ratio);
                        g * (2.0 * PI * (phase - n * x / ratio)).cos()
                    };
                    phases.iter().enumerate().map(of).sum()
                };
                let texels = [-1.0, 0.0, 1.0, 2.0].map(texel);
                let exact = kernel.weights(place);
                let rounded = |place: f64| (place / PLACE_STEP).round() * PLACE_STEP;
                let by_sampler = match kernel {
                    Kernel::Linear => kernel.weights(rounded(place)),
                    Kernel::Cubic => {
                        let [a, b, c, d] = exact;
                        let (left, right) = (rounded(b / (a + b)), rounded(d / (c + d)));
                        [(a + b) * (1.0 - left), (a + b) * left, (c + d) * (1.0 - right), (c + d) * right]
                    }
                };
                let read = |weights: [f64; 4]| weights.iter().zip(texels).map(|(w, t)| w * t).sum::<f64>();
                error += (read(by_sampler) - read(exact)).powi(2);
                power += read(exact).powi(2);
            }
            let (found, predicted) =
                ((error / power).sqrt(), kernel.rounding_error(ratio, Transformed::Window));
            assert!(
                (found / predicted - 1.0).abs() < 0.2,
                "{kernel:?} {ratio}: {found:e}, predicted {predicted:e}"
            );
        }
    }

    #[test]
    fn a_tolerance_gets_the_kernels_and_lengths_it_needs() {
        for (tolerance, reads) in [(1e-1, 1), (3e-2, 2), (1e-2, 4), (1e-3, 16)] {
            let found = Interpolation::for_tolerance(tolerance, Transformed::Window);
            eprintln!("{tolerance:e}: {found:?}");
            assert_eq!(found.reads(), reads);
            assert!(
                found.relative_error() <= tolerance && found.ratios[1] <= Transformed::Window.lengths().mixed,
                "{found:?}"
            );
        }
    }
}
