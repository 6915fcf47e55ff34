//! The samples of a generated patch: whole periods, whole samples, and room for them.

use super::{Dimensions, Spec};
use crate::error::{Error, Result};
use crate::fft_size::{fast_size, is_fast};
use crate::memory;
use crate::surface::{HeightField, MAX_SIDE};
use rayon::prelude::*;

/// The spacing that carries every frequency that light of 0.38 µm and more can see, λ_min/4 \[µm\].
pub(super) const FINE_ENOUGH: f64 = 0.095;

/// A ratio of two lengths that misses a whole number by less than this is one.
const WHOLE: f64 = 1e-6;

/// A patch of whole periods and its samples.
pub(super) struct SampleGrid {
    samples: [usize; 2],
    patch: [f64; 2],
    /// Periods in the patch; 0 along an axis without.
    pub(super) periods: [usize; 2],
}

impl SampleGrid {
    pub(super) fn new(spec: &Spec, dimensions: &Dimensions) -> Result<Self> {
        let mut grid = Self { samples: [0; 2], patch: [0.0; 2], periods: [0; 2] };
        for axis in 0..2 {
            let wished = spec.patch.map(|patch| patch[axis]);
            let period = dimensions.period[axis];
            let (patch, periods) = whole_periods(wished, dimensions.patch, period)?;
            let pixel = spec.pixel_size.map(|pixel| pixel[axis]);
            let samples = match (pixel, dimensions.of_period) {
                (None, Some(of_period)) if period > 0.0 => periods * of_period.min(MAX_SIDE / periods),
                _ => samples(patch, periods, pixel, dimensions.spacing)?,
            };
            if periods > 0 && samples < 2 * periods {
                return Err(Error::usage(
                    format!("{samples} samples cannot hold {periods} periods of {period} um"),
                    "give a pixel size of less than half the period",
                ));
            }
            grid.samples[axis] = samples;
            grid.patch[axis] = patch;
            grid.periods[axis] = periods;
        }
        let bytes = (grid.samples[0] * grid.samples[1] * size_of::<f64>()) as u64; // at most 2 GiB
        memory::ensure_room(
            bytes,
            &format!("a surface of {} x {} samples", grid.samples[0], grid.samples[1]),
        )?;
        Ok(grid)
    }

    /// Returns the side lengths of the patch \[µm\].
    pub(super) fn patch(&self) -> [f64; 2] {
        self.patch
    }

    /// Returns the field of h(x, y), with `x` and `y` as shares 0 … 1 of the patch from its lower left corner.
    pub(super) fn sample(&self, h: impl Fn(f64, f64) -> f64 + Sync) -> Result<HeightField> {
        let columns = self.samples[0] as f64;
        self.sample_lines(|y, line| {
            for (column, height) in line.iter_mut().enumerate() {
                *height = h((column as f64 + 0.5) / columns, y);
            }
        })
    }

    /// Returns the field that `fill` makes line by line, from `y` as a share of the patch and the samples of the line, all 0. Sample i of n
    /// is at (i + ½)/n of the patch.
    pub(super) fn sample_lines(&self, fill: impl Fn(f64, &mut [f64]) + Sync) -> Result<HeightField> {
        let [columns, rows] = self.samples;
        let mut heights = vec![0.0; columns * rows];
        heights.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
            // Row 0 is the top; samples sit at cell centres.
            fill((rows as f64 - row as f64 - 0.5) / rows as f64, line);
        });
        let pixel_size = [self.patch[0] / columns as f64, self.patch[1] / rows as f64];
        HeightField::new(columns, rows, pixel_size, heights)
    }
}

/// Returns `raw` scaled to the full `height` \[µm\], its lowest point at 0. A constant field becomes 0.
pub(super) fn to_full_height(raw: &HeightField, height: f64) -> Result<HeightField> {
    let (low, high) = raw.range();
    let scale = if high > low { height / (high - low) } else { 0.0 };
    let heights = raw.heights().iter().map(|h| (h - low) * scale).collect();
    HeightField::new(raw.columns(), raw.rows(), raw.pixel_size(), heights)
}

/// Returns the whole number of periods nearest to the wished or usual patch, and their length.
fn whole_periods(wished: Option<f64>, usual: f64, period: f64) -> Result<(f64, usize)> {
    let patch = wished.unwrap_or(usual);
    if period == 0.0 {
        return Ok((patch, 0));
    }
    let periods = (patch / period).round();
    if periods < 1.0 && wished.is_some() {
        return Err(Error::usage(
            format!("a patch of {patch} um does not hold a period of {period} um"),
            "give a patch of at least one period",
        ));
    }
    // Twice as many periods as samples is more than any pixel size can hold.
    if periods.is_nan() || periods > MAX_SIDE as f64 {
        return Err(Error::usage(
            format!("a patch of {patch} um holds too many periods of {period} um"),
            "give a smaller patch or a longer period",
        ));
    }
    let periods = periods.max(1.0);
    Ok((periods * period, periods as usize))
}

/// Returns the number of samples along one axis. Without a wish, the spacing is just below [`FINE_ENOUGH`] and at most `finest`, the number
/// has small prime factors for fast transforms, and every period is sampled alike if that costs few more samples.
fn samples(patch: f64, periods: usize, pixel: Option<f64>, finest: f64) -> Result<usize> {
    let count = (patch / pixel.unwrap_or(FINE_ENOUGH.min(finest)) - WHOLE).ceil().max(1.0);
    if count.is_nan() || count > MAX_SIDE as f64 {
        return Err(Error::usage(
            format!("a patch of {patch} um takes more than {MAX_SIDE} samples on a side"),
            "give a smaller patch or a larger pixel size",
        ));
    }
    let count = count as usize;
    if pixel.is_some() {
        return Ok(count);
    }
    let alike = if periods > 0 { periods * fast_size(count.div_ceil(periods)) } else { usize::MAX };
    let fast = fast_size(count);
    /// Few more: a fifth.
    const FEW_MORE: usize = 5;
    let chosen = if alike <= count + count / FEW_MORE && is_fast(alike) { alike } else { fast };
    Ok(chosen.min(MAX_SIDE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_becomes_whole_periods() {
        assert_eq!(whole_periods(Some(9.0), 20.0, 2.0).unwrap(), (10.0, 5));
        assert_eq!(whole_periods(None, 20.0, 50.0).unwrap(), (50.0, 1));
        assert_eq!(whole_periods(Some(9.0), 20.0, 0.0).unwrap(), (9.0, 0));
        assert!(whole_periods(Some(9.0), 20.0, 20.0).is_err());
        assert!(whole_periods(None, 20.0, 1e-300).is_err());
    }

    #[test]
    fn the_default_spacing_is_fine_enough_and_quick_to_transform() {
        let samples_of = |patch, periods| samples(patch, periods, None, f64::INFINITY).unwrap();
        for (patch, periods) in [(20.0, 0), (20.0, 10), (20.0, 8), (64.98, 57), (65.1, 42), (65.1, 21)] {
            let n = samples_of(patch, periods);
            assert!(patch / n as f64 <= FINE_ENOUGH && is_fast(n), "{patch} um in {n}");
        }
        assert_eq!(samples_of(20.0, 10), 240);
        assert_eq!(samples(20.0, 10, None, 0.05).unwrap(), 400, "fine structure is sampled finely");
        assert_eq!(samples(65.0, 0, Some(0.1), 0.05).unwrap(), 650);
        assert!(samples(1e9, 0, Some(0.1), f64::INFINITY).is_err());
    }
}
