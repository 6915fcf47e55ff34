//! Deconvolution of the probe's tip: an upper bound of the surface from the recorded heights.
//!
//! A scan is the surface dilated by the reflected tip: hills look wider, pits narrower. Eroding the scan by the same tip gives the least upper
//! bound of all surfaces that the scan allows, and the surface itself wherever the tip touched it [Villarrubia 1997, "Algorithms for scanned
//! probe microscope image simulation, surface reconstruction, and tip estimation", J. Res. Natl. Inst. Stand. Technol. 102, 425]. The tip is a
//! paraboloid of revolution u²/(2R), which a sphere of radius R osculates at the apex. Its erosion separates into rows and columns, and that of
//! a line is the lower envelope of parabolas, exact and in linear time [Felzenszwalb, Huttenlocher 2012, "Distance transforms of sampled
//! functions", Theory of Computing 8, 415].

use crate::error::Result;
use crate::surface::HeightField;
use crate::surface::transpose::transposed;
use rayon::prelude::*;

/// Returns `field` eroded by a tip whose apex has the radius of curvature `radius` \[µm\].
///
/// Samples beyond the edges are unknown and bound nothing.
///
/// # Errors
/// Heights that are not finite numbers.
pub(super) fn apply(field: &HeightField, radius: f64) -> Result<HeightField> {
    let (columns, rows) = (field.columns(), field.rows());
    let [dx, dy] = field.pixel_size();
    let along = |lines: &mut [f64], length: usize, spacing: f64| {
        let bend = spacing * spacing / (2.0 * radius);
        lines
            .par_chunks_mut(length)
            .for_each_init(ParabolaEnvelope::default, |envelope, line| envelope.erode(line, bend));
    };
    let mut heights = field.heights().to_vec();
    along(&mut heights, columns, dx);
    let mut turned = transposed(columns, &heights);
    along(&mut turned, rows, dy);
    HeightField::new(columns, rows, [dx, dy], transposed(rows, &turned))
}

/// The lower envelope of parabolas that stand at the samples of a line.
#[derive(Default)]
struct ParabolaEnvelope {
    line: Vec<f64>,
    /// Samples whose parabolas are part of the envelope, and the column at which each begins.
    seen: Vec<(usize, f64)>,
}

impl ParabolaEnvelope {
    /// Replaces each height `h_i` of `line` by min_j h_j + `bend` (i − j)².
    fn erode(&mut self, line: &mut [f64], bend: f64) {
        self.line.clear();
        self.line.extend_from_slice(line);
        self.seen.clear();
        for (i, &h) in self.line.iter().enumerate() {
            let mut begins = f64::NEG_INFINITY;
            while let Some(&(j, from)) = self.seen.last() {
                // Column at which the parabolas at i and j cross.
                let rise = (h - self.line[j]) / (bend * (i - j) as f64);
                begins = 0.5 * ((i + j) as f64 + rise);
                if begins > from {
                    break;
                }
                self.seen.pop();
                begins = f64::NEG_INFINITY;
            }
            self.seen.push((i, begins));
        }
        let mut lowest = 0;
        for (i, h) in line.iter_mut().enumerate() {
            while self.seen.get(lowest + 1).is_some_and(|(_, begins)| *begins < i as f64) {
                lowest += 1;
            }
            let j = self.seen[lowest].0;
            // A sample bounds itself, even if rounding puts a crossing on the wrong side of it.
            *h = h.min(self.line[j] + bend * (i as f64 - j as f64).powi(2));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::surface::prepare::tests::{difference, field};

    /// Returns the scan of `surface` by a tip: the dilation, which is the erosion of the mould.
    fn scanned(surface: &HeightField, radius: f64) -> HeightField {
        let mould = |f: &HeightField| super::super::invert::apply(f).unwrap();
        mould(&apply(&mould(surface), radius).unwrap())
    }

    fn rough(seed: u64) -> HeightField {
        let mut random = Random::new(seed);
        let heights = (0..37 * 23).map(|_| 0.3 * random.signed()).collect();
        HeightField::new(37, 23, [0.1, 0.07], heights).unwrap()
    }

    #[test]
    fn the_erosion_is_the_plain_minimum_over_all_samples() {
        for (seed, radius) in [(1, 0.002), (2, 0.02), (3, 0.5), (4, 30.0)] {
            let scan = rough(seed);
            let found = apply(&scan, radius).unwrap();
            let [dx, dy] = scan.pixel_size();
            for (r, c) in (0..23).flat_map(|r| (0..37).map(move |c| (r, c))) {
                let tip = |i: usize| {
                    let (x, y) = ((i % 37) as f64 - c as f64, (i / 37) as f64 - r as f64);
                    scan.heights()[i] + ((x * dx).powi(2) + (y * dy).powi(2)) / (2.0 * radius)
                };
                let expected = (0..37 * 23).map(tip).fold(f64::INFINITY, f64::min);
                assert!((found.row(r)[c] - expected).abs() < 1e-12, "radius {radius}, sample {c}, {r}");
            }
        }
    }

    #[test]
    fn level_ground_and_a_surface_flatter_than_the_tip_stay_as_they_are() {
        let flat = field(20, 30, |_, _| 0.4);
        assert_eq!(apply(&flat, 0.05).unwrap(), flat);
        // A dome of radius 2 µm under a tip of 1 µm: the tip that stands at 1.5 x touches the dome at x. Within half of the field all of these places
        // are in the scan, and its erosion is the surface.
        let dome = field(60, 60, |x, y| -0.25 * (x * x + y * y));
        let found = apply(&scanned(&dome, 1.0), 1.0).unwrap();
        for row in 15..45 {
            for (found, height) in found.row(row)[15..45].iter().zip(&dome.row(row)[15..45]) {
                assert!((found - height).abs() < 1e-12, "{found} instead of {height}");
            }
        }
    }

    #[test]
    fn a_step_is_given_back_but_in_the_shadow_of_its_wall() {
        // A step 200 nm high under a tip of 50 nm casts a shadow of √(2·0.05·0.2) = 141 nm on the low side.
        let (height, radius) = (0.2, 0.05);
        let reach = f64::sqrt(2.0 * radius * height);
        let step = field(61, 5, |x, _| if x < 0.0 { 0.0 } else { height });
        let scan = scanned(&step, radius);
        let found = apply(&scan, radius).unwrap();
        let first = step.row(2).iter().position(|h| *h > 0.0).unwrap();
        for (c, (h, found)) in step.row(2).iter().zip(found.row(2)).enumerate() {
            let from_wall = step.x(first) - step.x(c);
            let expected = if c >= first {
                height
            } else if from_wall > reach {
                0.0
            } else {
                // The tip's flank leans on the edge: the sample there is at the same height in the scan and after it.
                height - from_wall.powi(2) / (2.0 * radius)
            };
            let scanned = scan.row(2)[c];
            assert!((scanned - expected).abs() < 1e-12, "{c}: scanned {scanned} and not {expected}");
            assert!(*found >= h - 1e-12 && *found <= scanned + 1e-12, "{c}: {found}");
            if c >= first || from_wall > 2.0 * reach {
                assert!((found - h).abs() < 1e-12, "{c}: {found} and not {h}");
            }
        }
    }

    #[test]
    fn a_scan_of_what_is_found_is_the_scan_and_gives_the_same_again() {
        for seed in 5..9 {
            let surface = rough(seed);
            let scan = scanned(&surface, 0.04);
            let found = apply(&scan, 0.04).unwrap();
            assert!(difference(&scanned(&found, 0.04), &scan) < 1e-12, "the closing explains the scan");
            let again = apply(&scanned(&found, 0.04), 0.04).unwrap();
            assert!(difference(&again, &found) < 1e-12, "the closing is idempotent");
            assert!(found.heights().iter().zip(surface.heights()).all(|(f, s)| *f >= s - 1e-12));
            assert!(difference(&found, &surface) > 1e-3, "what no tip reached stays unknown");
        }
    }
}
