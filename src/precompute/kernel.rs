//! Reading a spectrum between its samples: which kernel, how many texels, and the error that remains.
//!
//! A kernel that interpolates in frequency multiplies the window's space by the kernel's transform and adds copies of it,
//! displaced by the padded length L and damped by the same transform. Dividing the window by the transform first
//! ("deapodisation", as in gridding and non-uniform FFTs; Jackson et al. 1991) undoes the multiplication; the damped
//! copies remain as the error.

/// How the shader reads between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// One hardware bilinear sample; transform sinc².
    Bilinear,
    /// Cubic B-spline from four hardware bilinear samples (Sigg & Hadwiger 2005); transform sinc⁴.
    Bspline,
}

impl Kernel {
    /// Hardware samples per read.
    pub fn samples(self) -> u32 {
        match self {
            Self::Bilinear => 1,
            Self::Bspline => 4,
        }
    }

    /// Texels needed beyond the band on each side.
    pub fn guard(self) -> usize {
        match self {
            Self::Bilinear => 1,
            Self::Bspline => 2,
        }
    }

    /// The kernel's transform at `x` = position/L.
    pub fn transform(self, x: f64) -> f64 {
        let sinc = if x == 0.0 { 1.0 } else { (std::f64::consts::PI * x).sin() / (std::f64::consts::PI * x) };
        match self {
            Self::Bilinear => sinc.powi(2),
            Self::Bspline => sinc.powi(4),
        }
    }

    /// RMS amplitude error along both axes, relative to the local RMS amplitude, for a Gaussian window of standard
    /// deviation σ on a padded length L = `ratio`·σ: the energy of the damped copies, and of what L cuts off.
    pub fn amplitude_error(self, ratio: f64) -> f64 {
        const STEPS: usize = 2000;
        const COPIES: i32 = 3; // the transform falls as m⁻² or m⁻⁴
        let step = 2.0 * 8.0 / STEPS as f64;
        let (mut error, mut energy) = (0.0, 0.0);
        for i in 0..STEPS {
            let x = (i as f64 + 0.5) * step - 8.0;
            let g2 = (-x * x).exp();
            energy += g2;
            error += if x.abs() > ratio / 2.0 {
                g2
            } else {
                let own = self.transform(x / ratio);
                let copies = (1..=COPIES).flat_map(|m| [f64::from(m), f64::from(-m)]);
                g2 * copies.map(|m| (self.transform(x / ratio + m) / own).powi(2)).sum::<f64>()
            };
        }
        (2.0 * error / energy).sqrt()
    }
}

impl Kernel {
    /// The same for one period without a window, 1 over T and 0 beyond, on a padded length L = `ratio`·T ≥ T.
    pub fn amplitude_error_of_patch(self, ratio: f64) -> f64 {
        const STEPS: i32 = 1000;
        const COPIES: i32 = 3;
        let error = |i: i32| {
            let x = ((f64::from(i) + 0.5) / f64::from(STEPS) - 0.5) / ratio;
            let copies = (1..=COPIES).flat_map(|m| [f64::from(m), f64::from(-m)]);
            copies.map(|m| (self.transform(x + m) / self.transform(x)).powi(2)).sum::<f64>()
        };
        (2.0 * (0..STEPS).map(error).sum::<f64>() / f64::from(STEPS)).sqrt()
    }
}

/// A kernel and the padded length it needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolation {
    /// The kernel.
    pub kernel: Kernel,
    /// L/σ.
    pub ratio: f64,
}

/// Intensities of speckle are exponentially distributed; the RMS of relative intensity errors over directions is the
/// relative amplitude error times 2·√ln(1/floor), with the floor at a thousandth of the local mean.
const SPECKLE: f64 = 2.0 * 2.628;

/// Above this L/σ one bilinear sample in a large texture costs more than four in a small one.
const MAX_BILINEAR_RATIO: f64 = 16.0;

impl Interpolation {
    /// The cheapest interpolation of the spectrum of one period without a window, with `ratio` = L/T, and its RMS relative
    /// intensity error: at most `tolerance`, or as small as there is.
    pub fn of_patch(tolerance: f64) -> (Self, f64) {
        const MOST: [(Kernel, f64); 2] = [(Kernel::Bilinear, 6.0), (Kernel::Bspline, 16.0)];
        let mut last = (Self { kernel: Kernel::Bspline, ratio: MOST[1].1 }, f64::INFINITY);
        for (kernel, most) in MOST {
            let mut ratio = 1.2;
            while ratio <= most {
                last = (Self { kernel, ratio }, SPECKLE * kernel.amplitude_error_of_patch(ratio));
                if last.1 <= tolerance {
                    return last;
                }
                ratio *= 1.02;
            }
        }
        last
    }

    /// The cheapest interpolation whose RMS relative intensity error over single directions and wavelengths is at most
    /// `tolerance`, or the finest there is, with 1.6e-6.
    pub fn for_tolerance(tolerance: f64) -> Self {
        let smallest = |kernel: Kernel, most: f64| {
            let mut ratio = 6.0;
            while ratio <= most {
                let candidate = Self { kernel, ratio };
                if candidate.relative_error() <= tolerance {
                    return Some(candidate);
                }
                ratio *= 1.02;
            }
            None
        };
        // Longer than 64σ, and the rounding of 32-bit layers is the larger error.
        smallest(Kernel::Bilinear, MAX_BILINEAR_RATIO)
            .or_else(|| smallest(Kernel::Bspline, 64.0))
            .unwrap_or(Self { kernel: Kernel::Bspline, ratio: 64.0 })
    }

    /// RMS relative intensity error over single directions and wavelengths.
    pub fn relative_error(&self) -> f64 {
        SPECKLE * self.kernel.amplitude_error(self.ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_falls_with_the_square_and_the_fourth_power_of_the_length() {
        let fall = |k: Kernel| k.amplitude_error(24.0) / k.amplitude_error(48.0);
        assert!((fall(Kernel::Bilinear) / 4.0 - 1.0).abs() < 0.15, "{}", fall(Kernel::Bilinear));
        assert!((fall(Kernel::Bspline) / 16.0 - 1.0).abs() < 0.3, "{}", fall(Kernel::Bspline));
    }

    #[test]
    fn a_tolerance_gets_the_kernel_and_length_it_needs() {
        let coarse = Interpolation::for_tolerance(0.1);
        assert_eq!(coarse.kernel, Kernel::Bilinear);
        let fine = Interpolation::for_tolerance(1e-3);
        assert_eq!(fine.kernel, Kernel::Bspline);
        assert!(fine.relative_error() <= 1e-3 && fine.ratio < 20.0, "{fine:?}");
    }
}
