//! What the light is coherent over, as a table sees it: how fine |P|² is over (u, v).
//!
//! As a function of frequency |P|² has the displacements between points of the surface that light is coherent over as its
//! spectrum: those of a Gaussian window fall off as exp(−x²/2σ²) in power. Those of n copies of a period T end at a = nT. Speckle
//! has half of its power at none, the mean, and half falling as 1 − x/a; the mirror's peak and orders of many copies have (1 − x/a)².
//! ⟨x⁴⟩ is a⁴/30 of the one and a⁴/35 of the other, so the first stands for all.

use super::rings::WAVELENGTH;
use crate::optics::coherence::Coherence;
use crate::optics::orders::Repeats;
use crate::surface::HeightField;
use std::f64::consts::PI;

/// What is around the patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// A Gaussian window of this standard deviation \[µm\].
    Gaussian(f64),
    /// Copies of the patch and nothing else.
    Repeats(Repeats),
}

impl Aperture {
    /// That of `coherence` over `field`.
    pub fn new(field: &HeightField, coherence: Coherence) -> Self {
        match coherence {
            Coherence::Gaussian { length } => Self::Gaussian(length / 4.0),
            Coherence::Repeats(copies) => Self::Repeats(Repeats { copies, period: field.patch_size() }),
        }
    }

    /// What 4πσ² of the shaders is made of \[µm\].
    pub fn sigma(&self) -> f64 {
        match self {
            Self::Gaussian(sigma) => *sigma,
            Self::Repeats(repeats) => repeats.sigma(),
        }
    }

    /// The copies, where there are any.
    pub fn repeats(&self) -> Option<&Repeats> {
        match self {
            Self::Gaussian(_) => None,
            Self::Repeats(repeats) => Some(repeats),
        }
    }

    /// σ of the Gaussian between whose samples linear interpolation leaves as much \[µm\]: one with the same ⟨x⁴⟩ + ⟨y⁴⟩ = 6σ⁴, and
    /// a fifth more of repeats.
    pub fn width(&self) -> f64 {
        match self {
            Self::Gaussian(sigma) => *sigma,
            Self::Repeats(repeats) => {
                /// Lobes have zeros between them, and light in the plane of a grating may put all of a map on one flank of
                /// them, where the error is 1.6 times as large relative to what is there as over all directions.
                const FLANK: f64 = 1.2;
                let fourth: f64 = sides(repeats).iter().map(|a| a.powi(4) / 30.0).sum();
                FLANK * (fourth / 6.0).powf(0.25)
            }
        }
    }

    /// Angles per unit of |(u, v)| of the displacement that [`Aperture::along`] counts in.
    pub fn band(&self) -> f64 {
        let unit = match self {
            Self::Gaussian(sigma) => *sigma,
            Self::Repeats(repeats) => longer(repeats),
        };
        2.0 * PI * unit / WAVELENGTH
    }

    /// The mean of `error` over the displacements around a ring, in the unit of [`Aperture::band`], where it is largest.
    pub fn mean(&self, error: impl Fn(f64) -> f64) -> f64 {
        match self {
            Self::Gaussian(_) => over_gaussian(error),
            Self::Repeats(repeats) => {
                /// Tangents looked at, over a quarter of a ring.
                const TANGENTS: i32 = 8;
                let shares = sides(repeats).map(|a| a / longer(repeats));
                let tangents =
                    (0..=TANGENTS).map(|i| (0.5 * PI * f64::from(i) / f64::from(TANGENTS)).sin_cos());
                let at = |(sin, cos): (f64, f64)| over_rectangle([shares[0] * sin, shares[1] * cos], &error);
                tangents.map(at).fold(0.0, f64::max)
            }
        }
    }

    /// Power of the displacement `x` along a ray, in the unit of [`Aperture::band`], over that of none.
    pub fn along(&self, x: f64) -> f64 {
        match self {
            Self::Gaussian(_) => (-0.5 * x * x).exp(),
            Self::Repeats(_) => (1.0 - x / self.end()).max(0.0),
        }
    }

    /// Displacement beyond which there is nothing.
    pub fn end(&self) -> f64 {
        match self {
            Self::Gaussian(_) => 5.0,
            // Across the corners.
            Self::Repeats(repeats) => {
                let [a, b] = sides(repeats);
                a.hypot(b) / a.max(b)
            }
        }
    }

    /// What to change where a table is too large for it.
    pub fn smaller(&self) -> &'static str {
        match self {
            Self::Gaussian(_) => "a shorter --coherence",
            Self::Repeats(_) => "fewer --coherence repeats",
        }
    }
}

/// a = nT of both axes \[µm\].
fn sides(repeats: &Repeats) -> [f64; 2] {
    [0, 1].map(|axis| f64::from(repeats.copies[axis]) * repeats.period[axis])
}

fn longer(repeats: &Repeats) -> f64 {
    let [a, b] = sides(repeats);
    a.max(b)
}

/// The mean of `error` under exp(−x²/2).
fn over_gaussian(error: impl Fn(f64) -> f64) -> f64 {
    const STEPS: usize = 200;
    let (mut sum, mut power) = (0.0, 0.0);
    for i in 0..STEPS {
        let x = 6.0 * (i as f64 + 0.5) / STEPS as f64;
        let own = (-0.5 * x * x).exp();
        power += own;
        sum += own * error(x);
    }
    sum / power
}

/// The mean of `error` over the displacements of speckle of a rectangle with the parts `sides` along a line: half of its power has none.
fn over_rectangle(sides: [f64; 2], error: impl Fn(f64) -> f64) -> f64 {
    const STEPS: i32 = 16;
    let places = || {
        (-STEPS..STEPS).map(|i| {
            let x = (f64::from(i) + 0.5) / f64::from(STEPS);
            (x, (1.0 - x.abs()) / f64::from(STEPS))
        })
    };
    let row = |(x, weight): (f64, f64)| -> f64 {
        weight * places().map(|(y, own)| own * error(x * sides[0] + y * sides[1])).sum::<f64>()
    };
    0.5 * places().map(row).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repeats(copies: [u32; 2], period: [f64; 2]) -> Aperture {
        Aperture::Repeats(Repeats { copies, period })
    }

    #[test]
    fn the_width_has_the_fourth_moments_of_the_displacements() {
        // By direct summation over one patch of speckle and over the mirror's peak.
        let a: f64 = 12.0;
        let moment = |power: &dyn Fn(f64) -> f64, at_none: f64| {
            let places = (0..4000).map(|i| a * (f64::from(i) + 0.5) / 4000.0);
            let (sum, whole) = places.fold((0.0, 0.0), |(s, w), x| (s + power(x) * x.powi(4), w + power(x)));
            sum / whole * (1.0 - at_none)
        };
        let speckle = moment(&|x| 1.0 - x / a, 0.5);
        let mirror = moment(&|x| (1.0 - x / a).powi(2), 0.0);
        assert!((speckle / (a.powi(4) / 30.0) - 1.0).abs() < 1e-4);
        assert!((mirror / (a.powi(4) / 35.0) - 1.0).abs() < 1e-4);
        let width = repeats([3, 3], [4.0, 4.0]).width();
        assert!((6.0 * (width / 1.2).powi(4) / (2.0 * speckle) - 1.0).abs() < 1e-4);
        assert_eq!(Aperture::Gaussian(2.5).width(), 2.5);
    }

    #[test]
    fn means_around_a_ring_are_those_of_the_displacements() {
        let square = |x: f64| x * x;
        assert!((Aperture::Gaussian(3.0).mean(square) - 1.0).abs() < 1e-3);
        // ⟨x²⟩ of 1 − |x| is 1/6, half of it is the mean's; along a diagonal both axes count by their halves.
        for (aperture, expected) in [
            (repeats([2, 2], [5.0, 5.0]), 1.0 / 12.0),
            (repeats([5, 1], [5.0, 5.0]), 1.0 / 12.0),
            (repeats([1, 5], [5.0, 5.0]), 1.0 / 12.0),
        ] {
            let found = aperture.mean(square);
            assert!((found / expected - 1.0).abs() < 0.02, "{aperture:?}: {found}");
        }
        assert!(
            repeats([2, 2], [5.0, 5.0]).along(1.5) == 0.0 && repeats([1, 9], [5.0, 5.0]).along(1.2) == 0.0
        );
    }
}
