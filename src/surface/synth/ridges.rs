//! Skins of snakes: rows of finger-like micro-ridges, overlapping like shingles.
//!
//! Each finger starts with a blunt, narrow tip and widens along −y until it meets its neighbours; there the tip of the
//! next finger of its column lies on it. Between two fingers one sees the row above them going down like a roof, deepest
//! where the fingers meet. Nothing else is drawn: the surface is the highest of all fingers and their roofs. Shape and
//! proportions follow cross-sections of an atomic force microscope scan (*Elaphe*); *Xenopeltis* is the same
//! construction, longer and more regular. Dust, scratches and tilt are left out.

use super::grid::{SampleGrid, to_full_height};
use super::smooth_step;
use super::waves::Waves;
use crate::error::Result;
use crate::random::Random;
use crate::surface::HeightField;

/// Parameters of a skin. Lengths across are in column pitches, along in row pitches, heights relative to the height of a finger's tip above
/// the deepest pit.
pub(super) struct Skin {
    /// Half width of a finger at its tip and where it meets its neighbours.
    half_width: [f64; 2],
    /// Exponent of the widening along a finger: larger values keep the tip's width for longer.
    taper: f64,
    /// Crest at the end of a finger, and the roof where it comes out from under its fingers.
    crest_end: f64,
    roof: f64,
    /// Slow bending of the columns (rms) and of the rows (rms).
    bend: [f64; 2],
    /// Offset of a column of fingers along itself, and of single fingers across and along (largest).
    stagger: f64,
    jitter: [f64; 2],
    /// Variation of a finger's height and width (largest).
    variation: f64,
    /// Slow swelling of the whole skin (rms).
    swell: f64,
}

pub(super) const ELAPHE: Skin = Skin {
    half_width: [0.22, 0.64],
    taper: 1.5,
    crest_end: 0.80,
    roof: 0.55,
    bend: [0.10, 0.20],
    stagger: 0.22,
    jitter: [0.04, 0.12],
    variation: 0.08,
    swell: 0.20,
};

pub(super) const XENOPELTIS: Skin = Skin {
    half_width: [0.32, 0.58],
    taper: 2.5,
    crest_end: 0.92,
    roof: 0.40,
    bend: [0.035, 0.06],
    stagger: 0.05,
    jitter: [0.012, 0.02],
    variation: 0.03,
    swell: 0.06,
};

/// Length of the rounding of a tip, in row pitches.
const TIP: f64 = 0.16;
/// Distance from the tip at which a finger has sunk into its roof, and length over which it sinks, in row pitches.
const SUNK: f64 = 1.80;
const SINKING: f64 = 0.90;
/// Distance from the tip at which the roof appears on the axis of a finger, its increase by the square of the distance from the axis, and
/// length of the rise. The increase makes the round ends of the pits.
const ROOF_START: f64 = 0.90;
const ROOF_LATER: f64 = 0.45;
const ROOF_RISE: f64 = 0.16;
/// Distances from the tip at which the roof reaches height 0 and at which it ends, in row pitches.
const ROOF_DOWN: f64 = 2.15;
const ROOF_END: f64 = 2.6;
/// Sag of the roof between two fingers, by the square of the distance from their axes.
const ROOF_SAG: f64 = 0.35;
/// Sharpness of the crease where two fingers meet; larger is sharper.
const CREASE: f64 = 50.0;

/// Random deviations of one finger.
#[derive(Clone, Copy)]
struct Finger {
    across: f64,
    along: f64,
    height: f64,
    width: f64,
}

/// A whole patch of fingers, columns × rows, periodic.
struct Fingers<'a> {
    skin: &'a Skin,
    columns: usize,
    rows: usize,
    each: Vec<Finger>,
    bend: [Waves; 2],
    swell: Waves,
}

/// Returns the skin on `grid`, scaled to the full height \[µm\], its lowest point at 0.
pub(super) fn make(grid: &SampleGrid, height: f64, seed: u64, skin: &Skin) -> Result<HeightField> {
    let fingers = Fingers::grow(grid, seed, skin);
    to_full_height(&grid.sample(|x, y| fingers.height(x, y))?, height)
}

impl<'a> Fingers<'a> {
    fn grow(grid: &SampleGrid, seed: u64, skin: &'a Skin) -> Self {
        let [columns, rows] = grid.periods;
        let mut random = Random::new(seed);
        /// A wave that bends columns or rows is longer than this \[µm\].
        const BENDING: f64 = 20.0;
        let cycles = grid.patch().map(|side| ((side / BENDING) as i32).clamp(1, 3));
        let bend = [Waves::new(&mut random, cycles), Waves::new(&mut random, cycles)];
        let swell = Waves::new(&mut random, cycles);
        let stagger: Vec<f64> = (0..columns).map(|_| skin.stagger * random.signed()).collect();
        let each = (0..columns * rows)
            .map(|i| Finger {
                across: skin.jitter[0] * random.signed(),
                along: stagger[i % columns] + skin.jitter[1] * random.signed(),
                height: 1.0 + skin.variation * random.signed(),
                width: 1.0 + skin.variation * random.signed(),
            })
            .collect();
        Self { skin, columns, rows, each, bend, swell }
    }

    /// Returns the height at `x`, `y`, shares of the patch.
    fn height(&self, x: f64, y: f64) -> f64 {
        let [bend_x, bend_y] = [0, 1].map(|i| self.skin.bend[i] * self.bend[i].at(x, y));
        // Column and row coordinates after bending; rows count downward.
        let u = x * self.columns as f64 + bend_x;
        let v = (1.0 - y) * self.rows as f64 + bend_y;
        let (column, row) = (u.floor() as i64, v.floor() as i64);
        // A soft maximum, ln Σ e^{s h} / s, rounds the creases a little.
        let mut sum = 0.0;
        for i in column - 1..=column + 1 {
            // The roof of a finger reaches over two rows and a half, less the finger's offset.
            for j in row - 2..=row + 1 {
                let finger = &self.each[self.index(i, j)];
                let across = u - (i as f64 + 0.5 + finger.across);
                let along = v - (j as f64 + finger.along);
                sum += (CREASE * self.skin.finger(across, along, finger)).exp();
            }
        }
        sum.ln() / CREASE + self.skin.swell * self.swell.at(x, y)
    }

    /// Returns the index in `each` of finger `i` of row `j`; both wrap around the patch.
    fn index(&self, i: i64, j: i64) -> usize {
        let around = |k: i64, n: usize| k.rem_euclid(n as i64) as usize;
        around(j, self.rows) * self.columns + around(i, self.columns)
    }
}

impl Skin {
    /// Returns the height of one finger with its roof at `across` its axis and `along` it from the tip; far below 0 outside.
    fn finger(&self, across: f64, along: f64, finger: &Finger) -> f64 {
        /// Deep enough to vanish from every soft maximum.
        const NOWHERE: f64 = -1.0;
        if !(0.0..=ROOF_END).contains(&along) {
            return NOWHERE;
        }
        let way = along.min(1.0);
        let [narrow, wide] = self.half_width;
        let half_width = finger.width * (narrow + (wide - narrow) * way.powf(self.taper));
        let rounding = (1.0 - (1.0 - (along / TIP).min(1.0)).powi(2)).sqrt();
        let crest = finger.height * (1.0 - (1.0 - self.crest_end) * way);
        let aside = across * across;
        // A parabola across.
        let profile = (1.0 - aside / (half_width * half_width)).max(NOWHERE);
        let body = crest * rounding * profile - smooth_step((along - SUNK + SINKING) / SINKING);
        let down = self.roof * (ROOF_DOWN - along) / (ROOF_DOWN - 1.0) - ROOF_SAG * self.roof * aside;
        let out = smooth_step((along - ROOF_START - ROOF_LATER * aside) / ROOF_RISE);
        body.max(NOWHERE + (down - NOWHERE) * out)
    }
}
