//! One axis of the transforms: the samples within a window, relative to its centre.

use super::kernel::GriddingKernel;
use crate::fft_size::fast_size;
use crate::optics::coherence::{self, Coherence, GAUSSIAN_CUT, periodic_factor};
use std::f64::consts::PI;

/// Samples and weights of a window along one axis.
#[derive(Debug)]
pub struct TransformAxis {
    /// Length of the transform in samples.
    pub samples: usize,
    /// Length of the transform \[µm\]; bins are 1/length apart.
    pub length: f64,
    /// Weight of each sample, divided by the transform of the kernel (deapodisation).
    pub weights: Vec<f64>,
    /// Column or row of the patch of each sample of the transform.
    pub patch_index: Vec<usize>,
    /// Bins needed on either side of 0.
    pub bins: usize,
    /// Copies of the patch side by side, and its period \[µm\]; `None` for a Gaussian window.
    copies: Option<(u32, f64)>,
}

/// One axis of a height field, with the position of the window and the band.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Samples of the patch.
    pub samples: usize,
    /// Sample spacing \[µm\].
    pub spacing: f64,
    /// Shift of the window from the patch centre \[µm\].
    pub shift: f64,
    /// Largest frequency needed \[µm⁻¹\].
    pub reach: f64,
    /// 0 along columns, 1 along rows, of which the first has the largest coordinate.
    pub number: usize,
}

/// Padded length over σ of a Gaussian window: with [`GAUSSIAN_SHAPE`] the kernel errs by 1e-9 of the local amplitude.
const GAUSSIAN_RATIO: f64 = 14.0;
/// β/w of the kernel for a Gaussian window.
pub const GAUSSIAN_SHAPE: f64 = 2.23;
/// Padded length over the patch's for copies, whose window ends abruptly: 2e-10.
const PATCH_RATIO: f64 = 2.5;
/// β/w of the kernel for copies of a patch.
pub const PATCH_SHAPE: f64 = 2.49;

impl TransformAxis {
    /// Lays out the samples of the axis `look` within the window of `coherence`.
    pub fn new(look: &Look, coherence: &Coherence, kernel: &GriddingKernel) -> Self {
        let patch = look.samples as i64;
        // Sample g of the endless surface stands at (g − (N − 1)/2)·spacing and is sample g mod N of the patch. The
        // first sample, their number, and the window's centre in samples:
        let middle = (look.samples as f64 - 1.0) / 2.0 + look.shift / look.spacing;
        let (first, count, needed) = match coherence {
            Coherence::Gaussian { length } => {
                let reach = GAUSSIAN_CUT * length / 4.0 / look.spacing;
                let first = (middle - reach).ceil() as i64;
                let count = (middle + reach).floor() as i64 - first + 1;
                (first, count, GAUSSIAN_RATIO * length / 4.0 / look.spacing)
            }
            Coherence::Repeats(_) => {
                // Same rule as `coherence::WindowedAxis::repeat_weights`, to the last bit: samples before the window's begin come from the
                // copy after the last.
                let (samples, spacing, shift) = (look.samples, look.spacing, look.shift);
                let along = coherence::WindowedAxis { samples, spacing, shift };
                let begin = along.position(0) - spacing / 2.0 + shift;
                let first = (0..samples).take_while(|&i| along.position(i) < begin).count() as i64;
                (first, patch, PATCH_RATIO * patch as f64)
            }
        };
        let samples =
            fast_size((needed.ceil() as usize).max(count.max(0) as usize).max(2 * super::kernel::TAPS));
        let length = samples as f64 * look.spacing;
        let origin = first + count / 2;
        let mut weights = vec![0.0; samples];
        let mut patch_index = vec![0; samples];
        for g in first..first + count {
            let slot = (g - origin).rem_euclid(samples as i64) as usize;
            let window = match coherence {
                Coherence::Gaussian { length } => {
                    let x = (g as f64 - middle) * look.spacing;
                    (-0.5 * (x / (length / 4.0)).powi(2)).exp()
                }
                Coherence::Repeats(_) => 1.0,
            };
            weights[slot] = window / kernel.transform((g - origin) as f64 / samples as f64);
            let index = g.rem_euclid(patch) as usize;
            patch_index[slot] = if look.number == 1 { look.samples - 1 - index } else { index };
        }
        let copies = match coherence {
            Coherence::Gaussian { .. } => None,
            Coherence::Repeats(n) => Some((n[look.number], patch as f64 * look.spacing)),
        };
        Self { samples, length, weights, patch_index, bins: (look.reach * length).ceil() as usize, copies }
    }

    /// Returns |S|² of the copies at frequency `f` \[µm⁻¹\].
    pub fn copies(&self, f: f64) -> f64 {
        self.copies.map_or(1.0, |(n, period)| periodic_factor(n, 2.0 * PI * f * period).norm_sqr())
    }
}
