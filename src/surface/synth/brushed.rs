//! Brushed metal: long scratches, nearly parallel.
//!
//! Each scratch is the cut of one grain of an abrasive: the grain sinks in, cuts, and comes out again. The cross-section of a scratch is a
//! parabola, and wider grains cut deeper in proportion. Scratches are placed at random, run along y but for a few degrees, are about as
//! long as the patch, and wrap around it. At crossings the deepest cut remains, so that sharp ridges stand between neighbours; between
//! scratches the metal stays plane. The scratches run along y, so light spreads along x: a highlight becomes a streak across the scratches.
//!
//! Nothing here is a measurement. The finish is a fine one: its arithmetic mean deviation Sa is about 0.1 µm, while hairline typically has
//! 0.2 µm to 0.4 µm and No. 4 has 0.4 µm to 0.6 µm. A patch of 65 µm is too small for enough of their scratches. Pits, and the metal that a
//! grain throws up beside its scratch, are left out.

use super::grid::{SampleGrid, to_full_height};
use crate::error::Result;
use crate::random::Random;
use crate::surface::HeightField;

/// Mean distance of neighbouring scratches on a line along `x` \[µm\].
pub(super) const DISTANCE: f64 = 0.4;
/// The deepest cut below the highest metal \[µm\].
pub(super) const HEIGHT: f64 = 0.5;

/// Lengths of scratches and half their widths where they are deepest, least and most, in mean distances. The
/// logarithms are spread evenly.
const LENGTH: [f64; 2] = [100.0, 300.0];
const HALF_WIDTH: [f64; 2] = [0.75, 3.0];
/// The depth of the shallowest scratch, where the deepest of the same width is 1.
const SHALLOWEST: f64 = 0.4;
/// The largest slope of a scratch to the y axis: 3°. Small slopes are the more frequent ones.
const LEAN: f64 = 0.052;

/// One scratch. Lengths are in µm, the depth is a share.
struct ScratchMark {
    middle: [f64; 2],
    half_length: f64,
    half_width: f64,
    depth: f64,
    /// Displacement along `x` over the length of the scratch along `y`.
    lean: f64,
}

/// Returns scratches on `grid`, scaled in the plane to its mean distance along `x`, and to the full height \[µm\].
pub(super) fn make(grid: &SampleGrid, height: f64, seed: u64) -> Result<HeightField> {
    let patch = grid.patch();
    let scratches = scratch(patch, patch[0] / grid.periods[0] as f64, seed);
    let raw = grid.sample_lines(|y, line| {
        for scratch in &scratches {
            scratch.cut(patch, y * patch[1], line);
        }
    })?;
    to_full_height(&raw, height)
}

/// Returns scratches that a line along `x` meets every `distance`, on average.
fn scratch(patch: [f64; 2], distance: f64, seed: u64) -> Vec<ScratchMark> {
    let mut random = Random::new(seed);
    let mut scratches = Vec::new();
    let mut left = patch[0] * patch[1] / distance;
    while left > 0.0 {
        let length = between(&mut random, LENGTH.map(|l| l * distance)).min(left);
        left -= length;
        let half_width = between(&mut random, HALF_WIDTH);
        let depth = SHALLOWEST + (1.0 - SHALLOWEST) * random.share();
        scratches.push(ScratchMark {
            middle: patch.map(|side| side * random.share()),
            half_length: 0.5 * length,
            half_width: half_width * distance,
            depth: depth * half_width / HALF_WIDTH[1],
            lean: LEAN * (random.share() - random.share()),
        });
    }
    scratches
}

/// Returns a random number from `least` to `most` whose logarithm is spread evenly.
fn between(random: &mut Random, [least, most]: [f64; 2]) -> f64 {
    least * (most / least).powf(random.share())
}

impl ScratchMark {
    /// Cuts the scratch, as often as it goes around the patch, into the `line` of samples at `y` \[µm\].
    fn cut(&self, patch: [f64; 2], y: f64, line: &mut [f64]) {
        let off = y - self.middle[1];
        let first = ((-self.half_length - off) / patch[1]).ceil() as i64;
        let last = ((self.half_length - off) / patch[1]).floor() as i64;
        for around in first..=last {
            let along = off + around as f64 * patch[1];
            // Even over most of the length.
            let sunk = 1.0 - (along / self.half_length).powi(4);
            self.groove(self.middle[0] + self.lean * along, sunk, patch[0], line);
        }
    }

    /// Cuts the cross-section around `x` \[µm\], of the share `sunk` of the full depth, into a line of the `width` \[µm\].
    fn groove(&self, x: f64, sunk: f64, width: f64, line: &mut [f64]) {
        let spacing = width / line.len() as f64;
        // The width of a parabola at the surface.
        let half_width = self.half_width * sunk.max(0.0).sqrt();
        let depth = self.depth * sunk;
        // Sample i is at (i + ½) spacings.
        let first = ((x - half_width) / spacing - 0.5).ceil() as i64;
        let last = ((x + half_width) / spacing - 0.5).floor() as i64;
        for i in first..=last {
            let aside = ((i as f64 + 0.5) * spacing - x) / half_width;
            let sample = &mut line[i.rem_euclid(line.len() as i64) as usize];
            *sample = sample.min(-depth * (1.0 - aside * aside));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::surface::statistics::{HeightParameters, Slopes};
    use crate::surface::synth::{Spec, SurfaceKind, generate};

    #[test]
    fn scratches_run_along_y() {
        let field = generate(&Spec::new(SurfaceKind::Brushed)).unwrap();
        let Slopes { rms, .. } = Slopes::of(&field);
        assert!(rms[0] > 20.0 * rms[1] && rms[1] > 0.0, "{rms:?}");
        assert!(
            (0.08..0.12).contains(&HeightParameters::of(&field).sa),
            "{}",
            HeightParameters::of(&field).sa
        );
    }
}
