//! How shaders come by c_n(z): from a table, or by computing polynomials.

use crate::expansion::Expansion;
use crate::expansion::anchored::Series;
use rustfft::num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Where a shader has c_n(z) from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// Linear interpolation in the table.
    Interpolated = 0,
    /// The nearest point of the table.
    Nearest = 1,
    /// [`Series::Powers`].
    Powers = 2,
    /// [`Series::Polynomials`].
    Polynomials = 3,
}

impl Source {
    /// Every source, by its number.
    pub const ALL: [Self; 4] = [Self::Interpolated, Self::Nearest, Self::Powers, Self::Polynomials];
}

/// c_n(z) on a uniform grid of z in each band of z.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// Where shaders have them from.
    pub source: Source,
    /// Points over a band, its ends included; the ends alone where shaders compute.
    pub columns: usize,
    /// Pair by pair of terms, band by band, point by point: (Re, Im) of term 2p, (Re, Im) of term 2p + 1.
    pub values: Vec<[f32; 4]>,
}

/// Share of the tolerance that reading between the points may take.
const SHARE: f64 = 0.03;
/// Bounds on the number of intervals: the larger keeps a row within the 4096 texels that every Vulkan device holds.
const INTERVALS: (f64, f64) = (64.0, 4094.0);

impl Coefficients {
    /// The table of `terms` coefficients of `families`, one for each of the equal parts of 0 … `z_max`, for heights of half
    /// range `half_range` \[µm\].
    ///
    /// Taking all coefficients from the nearest point moves z by up to half a step Δz, the heights' phases by half of
    /// Δz·a at most and by Δz·a/√48 in the RMS of heights that fill half of their range; intensities err by twice that.
    /// Interpolating all coefficients alike interpolates e^{izh} itself, with an error of (Δz·a)²/8. Neither cancels.
    pub(super) fn new(
        families: &[Box<dyn Expansion>],
        terms: usize,
        z_max: f64,
        half_range: f64,
        tolerance: f64,
    ) -> Self {
        let width = z_max / families.len() as f64;
        let allowed = SHARE * tolerance;
        let for_nearest = (2.0 * width * half_range / (48f64.sqrt() * allowed)).ceil();
        let for_linear = (width * half_range / (8.0 * allowed).sqrt()).ceil();
        let series = families.first().and_then(|family| family.series());
        let (source, intervals) = match series {
            Some(Series::Powers) => (Source::Powers, 1.0),
            Some(Series::Polynomials) => (Source::Polynomials, 1.0),
            None if for_nearest <= INTERVALS.1 => (Source::Nearest, for_nearest.max(INTERVALS.0)),
            None => (Source::Interpolated, for_linear.clamp(INTERVALS.0, INTERVALS.1)),
        };
        let columns = intervals as usize + 1;
        let bands = families.len();
        let mut values = vec![[0.0f32; 4]; terms.div_ceil(2) * bands * columns];
        let mut c = vec![Complex64::ZERO; terms];
        for (band, family) in families.iter().enumerate() {
            for column in 0..columns {
                family.coefficients(width * (band as f64 + column as f64 / intervals), &mut c);
                for (n, c) in c.iter().enumerate() {
                    let texel = &mut values[(n / 2 * bands + band) * columns + column];
                    texel[n % 2 * 2..][..2].copy_from_slice(&[c.re as f32, c.im as f32]);
                }
            }
        }
        Self { source, columns, values }
    }
}
