//! Optical discs: tracks of pits, as the laser of a player sees them.
//!
//! The track is a spiral, but a patch of some tens of micrometres sees it as straight parallel lines. They run along y,
//! so that the grating vector is along x: on the mesh of a disc x is the radius. Along a track, pits and lands alternate,
//! each a whole number of channel bits T long, from 3T to 11T. The run lengths are random with the probabilities that
//! carry most data (see [`GROWTH`]), and tracks do not know of each other.
//!
//! Published: pitch and channel bit. ECMA-130 (CD): 1.6 µm; T is what passes in one period of 4.3218 MHz at 1.2 m/s, the
//! slower of the permitted speeds, and pits are 3T = 0.833 µm to 11T = 3.054 µm long. ECMA-267 (DVD, single layer):
//! 0.74 µm, T = 133.3 nm, 3T = 0.40 µm to 11T = 1.47 µm. Usual, and not taken from the standards: widths of 0.5 µm and 0.32 µm,
//! and depths near a quarter of the laser's wavelength in polycarbonate (n = 1.55), 126 nm at 780 nm and 105 nm at
//! 650 nm. Chosen: round ends and walls of one width. Sync marks of 14T (DVD) and wobble are left out, and so is what
//! modulation codes do to keep pits and lands balanced over long distances.
//!
//! Heights are those of the metal as it is seen through the polycarbonate. The moulded pits are hollows in the
//! polycarbonate on its far side, so the metal bulges toward the eye: pits are bumps, lands are at 0. The polycarbonate
//! itself is not part of a height field. It leaves the directions of the orders in air as they are, but multiplies the
//! phase by about its index: a height of 0.186 µm has the phase near the normal that 0.12 µm have under polycarbonate.

use super::grid::SampleGrid;
use super::smooth_step;
use crate::error::{Error, Result};
use crate::random::Random;
use crate::surface::HeightField;

/// The dimensions of one format \[µm\].
pub(super) struct DiscFormat {
    /// Distance of neighbouring tracks.
    pitch: f64,
    /// Length of a channel bit, T.
    bit: f64,
    /// Width of a pit at half its height.
    width: f64,
    /// Full height of a pit.
    pub(super) height: f64,
}

pub(super) const CD: DiscFormat = DiscFormat { pitch: 1.6, bit: 1.2 / 4.3218, width: 0.5, height: 0.12 };
pub(super) const DVD: DiscFormat = DiscFormat { pitch: 0.74, bit: 0.1333, width: 0.32, height: 0.105 };

/// Shortest and longest pit or land, in channel bits.
const SHORTEST: usize = 3;
const LONGEST: usize = 11;

/// A run of n bits has the probability GROWTH⁻ⁿ, which makes the sum over all permitted n one: of all sequences with these
/// run lengths the random one of most information [Immink, "Codes for Mass Data Storage Systems", 2004, chapter 4: the
/// capacity is log₂ GROWTH = 0.5418 bit a channel bit]. Modulation codes come close to it.
const GROWTH: f64 = 1.455_784_907_8;

/// Width of a wall, from foot to edge, measured along the plane \[µm\]: the mean slope of a CD's is 50°, as moulded.
const WALL: f64 = 0.1;

/// Sample spacing that puts a sample on the middle of every wall \[µm\].
pub(super) const SPACING: f64 = WALL / 2.0;

impl DiscFormat {
    /// Lengths of which the patch holds a whole number: the track pitch along `x`, the shortest pit along `y`.
    pub(super) fn period(&self) -> [f64; 2] {
        [self.pitch, SHORTEST as f64 * self.bit]
    }
}

/// Returns the tracks of `format` on `grid`, scaled in the plane to its period along `x`, with pits of the height \[µm\].
///
/// # Errors
/// A patch too short for a pit and a land.
pub(super) fn make(grid: &SampleGrid, height: f64, seed: u64, format: &DiscFormat) -> Result<HeightField> {
    let [_, length] = grid.patch();
    let [_, shortest_runs] = grid.periods;
    if shortest_runs < 2 {
        return Err(Error::usage(
            format!("a patch of {length} um along y does not hold a pit and a land"),
            format!("give a patch of at least {} um along y", 2.0 * length),
        ));
    }
    let tracks = Tracks::write(grid, seed, format);
    grid.sample(|x, y| height * tracks.height(x, y))
}

/// All tracks of a patch. Lengths are in µm.
struct Tracks {
    each: Vec<Track>,
    /// Distance of neighbouring tracks, and the length after which each repeats.
    pitch: f64,
    length: f64,
    /// Half the width of a pit, and the width of a wall.
    half_width: f64,
    wall: f64,
}

/// The pits of one track.
struct Track {
    /// Position of the first pit's start on the patch.
    start: f64,
    /// Pits from `start` on, in order.
    pits: Vec<Pit>,
}

struct Pit {
    middle: f64,
    half_length: f64,
}

impl Tracks {
    fn write(grid: &SampleGrid, seed: u64, format: &DiscFormat) -> Self {
        let [width, length] = grid.patch();
        let [tracks, shortest_runs] = grid.periods;
        let pitch = width / tracks as f64;
        let scale = pitch / format.pitch;
        let mut random = Random::new(seed);
        let each = (0..tracks).map(|_| Track::write(&mut random, SHORTEST * shortest_runs, length)).collect();
        Self { each, pitch, length, half_width: 0.5 * format.width * scale, wall: WALL * scale }
    }

    /// Returns the height at `x`, `y`, shares of the patch: 1 on a pit, 0 between pits.
    fn height(&self, x: f64, y: f64) -> f64 {
        let across = x * self.each.len() as f64;
        let track = &self.each[(across as usize).min(self.each.len() - 1)];
        let aside = (across.fract() - 0.5) * self.pitch;
        let along = (y * self.length - track.start).rem_euclid(self.length);
        // The pits before and after the point; the first one is also the one after the last.
        let after = track.pits.partition_point(|pit| pit.middle < along);
        let before = after.checked_sub(1).unwrap_or(track.pits.len() - 1);
        let beside = [before, after % track.pits.len()];
        beside.map(|i| self.pit(&track.pits[i], aside, along)).into_iter().fold(0.0, f64::max)
    }

    /// Returns the height of one pit at `aside` from the middle of its track and `along` it.
    fn pit(&self, pit: &Pit, aside: f64, along: f64) -> f64 {
        let off = (along - pit.middle).abs();
        let off = off.min(self.length - off);
        // The distance from the straight middle of a pit with round ends.
        let past = (off - (pit.half_length - self.half_width)).max(0.0);
        let outside = aside.hypot(past) - self.half_width;
        smooth_step(0.5 - outside / self.wall)
    }
}

impl Track {
    /// Writes a track of `bits` channel bits on `length` µm.
    fn write(random: &mut Random, bits: usize, length: f64) -> Self {
        let start = length * random.share();
        let bit = length / bits as f64;
        let mut from = 0;
        let mut pits = Vec::new();
        for pair in runs(random, bits).chunks_exact(2) {
            let half_length = 0.5 * bit * pair[0] as f64;
            pits.push(Pit { middle: bit * from as f64 + half_length, half_length });
            from += pair[0] + pair[1];
        }
        Self { start, pits }
    }
}

/// Returns the lengths of the pits and lands, in turn, that fill `bits` channel bits, at least twice the shortest run.
fn runs(random: &mut Random, bits: usize) -> Vec<usize> {
    // One in ten is as long as asked, whatever its length, and has as many lands as pits: taking that one keeps the
    // probabilities of runs as they are.
    loop {
        let mut runs = Vec::new();
        let mut sum = 0;
        while sum < bits {
            let run = run(random);
            sum += run;
            runs.push(run);
        }
        if sum == bits && runs.len() % 2 == 0 {
            return runs;
        }
    }
}

/// Returns the length of one run, in channel bits.
fn run(random: &mut Random) -> usize {
    let mut left = random.share();
    for bits in SHORTEST..LONGEST {
        left -= GROWTH.powi(-(bits as i32));
        if left < 0.0 {
            return bits;
        }
    }
    LONGEST
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::synth::{Spec, SurfaceKind, generate};
    use rustfft::num_complex::Complex64;
    use std::f64::consts::TAU;

    /// Lengths of the pits and of the lands on a line along a track \[µm\], between the places at half height.
    fn lengths(line: &[f64], spacing: f64, half: f64) -> [Vec<f64>; 2] {
        let n = line.len();
        let mut edges = Vec::new();
        for i in 0..n {
            let (a, b) = (line[i] - half, line[(i + 1) % n] - half);
            if (a < 0.0) != (b < 0.0) {
                edges.push((i as f64 + a / (a - b), a < 0.0));
            }
        }
        let mut lengths = [Vec::new(), Vec::new()];
        for (i, (from, rising)) in edges.iter().enumerate() {
            let to = edges[(i + 1) % edges.len()].0;
            lengths[usize::from(!rising)].push((to - from).rem_euclid(n as f64) * spacing);
        }
        lengths
    }

    #[test]
    fn pits_and_lands_have_permitted_lengths_and_share_the_track() {
        for (kind, format, width) in [(SurfaceKind::Cd, &CD, 0.5), (SurfaceKind::Dvd, &DVD, 0.32)] {
            let field = generate(&Spec::new(kind)).unwrap();
            let [dx, dy] = field.pixel_size();
            let half = 0.5 * format.height;
            let tracks = (field.patch_size()[0] / format.pitch).round() as usize;
            let mut along = [Vec::new(), Vec::new()];
            for track in 0..tracks {
                let column = ((track as f64 + 0.5) * format.pitch / dx) as usize;
                let line: Vec<f64> = (0..field.rows()).map(|row| field.row(row)[column]).collect();
                let found = lengths(&line, dy, half);
                along.iter_mut().zip(found).for_each(|(all, some)| all.extend(some));
            }
            let permitted = 3.0 * format.bit - dy..=11.0 * format.bit + dy;
            assert!(along.iter().flatten().all(|length| permitted.contains(length)), "{kind:?}: {along:?}");
            let [pits, lands] = along.map(|all| all.iter().sum::<f64>());
            let duty = pits / (pits + lands);
            assert!((duty - 0.5).abs() < 0.02, "{kind:?}: {duty}");
            let widest = (0..field.rows()).flat_map(|row| {
                let [pits, _] = lengths(field.row(row), dx, half);
                pits
            });
            let widest = widest.fold(0.0, f64::max);
            assert!((widest - width).abs() < 0.01, "{kind:?}: {widest}");
        }
    }

    #[test]
    fn runs_fill_the_track_and_are_as_frequent_as_they_should_be() {
        let mut random = Random::new(5);
        for bits in 6..60 {
            let runs = runs(&mut random, bits);
            assert_eq!((runs.iter().sum::<usize>(), runs.len() % 2), (bits, 0));
        }
        let probabilities = (SHORTEST..=LONGEST).map(|n| GROWTH.powi(-(n as i32)));
        assert!((probabilities.clone().sum::<f64>() - 1.0).abs() < 1e-9);
        let runs = runs(&mut random, 100_000);
        for (n, expected) in (SHORTEST..=LONGEST).zip(probabilities) {
            let found = runs.iter().filter(|run| **run == n).count() as f64 / runs.len() as f64;
            assert!((found - expected).abs() < 0.01, "{n}T: {found} and not {expected}");
        }
    }

    #[test]
    fn the_strongest_frequency_across_the_tracks_is_one_cycle_a_track() {
        for (kind, format) in [(SurfaceKind::Cd, &CD), (SurfaceKind::Dvd, &DVD)] {
            let field = generate(&Spec::new(kind)).unwrap();
            let columns = field.columns();
            let means: Vec<f64> = (0..columns)
                .map(|column| (0..field.rows()).map(|row| field.row(row)[column]).sum::<f64>())
                .collect();
            let power = |cycles: &usize| {
                let step = TAU * *cycles as f64 / columns as f64;
                let parts = means.iter().enumerate().map(|(i, h)| Complex64::from_polar(*h, step * i as f64));
                parts.sum::<Complex64>().norm_sqr()
            };
            let strongest = (1..=columns / 2).max_by(|a, b| power(a).total_cmp(&power(b))).unwrap();
            let pitch = field.patch_size()[0] / strongest as f64;
            assert!((pitch / format.pitch - 1.0).abs() < 1e-9, "{kind:?}: {pitch} um");
        }
    }

    #[test]
    fn pits_are_up_and_no_wall_falls_between_two_samples() {
        for (kind, format) in [(SurfaceKind::Cd, &CD), (SurfaceKind::Dvd, &DVD)] {
            let field = generate(&Spec::new(kind)).unwrap();
            assert_eq!(field.range(), (0.0, format.height), "{kind:?}");
            let up = field.heights().iter().filter(|h| **h > 0.5 * format.height).count();
            assert!(3 * up < field.heights().len(), "{kind:?}: more land than pits, {up} samples up");
            let steps = (0..field.rows()).flat_map(|row| field.row(row).windows(2));
            let largest = steps.map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
            // The middle half of a wall rises by 11/16.
            assert!(largest <= 0.69 * format.height, "{kind:?}: {largest}");
        }
    }

    #[test]
    fn a_patch_without_room_for_a_pit_and_a_land_is_refused() {
        let short = Spec { patch: Some([9.0, 0.9]), ..Spec::new(SurfaceKind::Cd) };
        let e = generate(&short).unwrap_err();
        assert!(
            e.kind() == crate::error::ErrorKind::Usage && e.to_string().contains("a pit and a land"),
            "{e}"
        );
        assert!(generate(&Spec { patch: Some([9.0, 1.7]), ..short }).is_ok());
        assert!(generate(&Spec { period: Some(200.0), ..Spec::new(SurfaceKind::Dvd) }).is_err());
    }
}
