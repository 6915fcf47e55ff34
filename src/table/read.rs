//! Reads a colour table between its texels and over footprints: the twin of `shaders/source_table.glsl`.

use super::{ColorTable, LARGEST_W, SPECULAR_SAMPLES};
use crate::brdf::mean::Covariance;
use crate::optics::brdf::schlick;
use crate::optics::geometry::Pair;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Reads one table.
pub struct TableReader<'a> {
    table: &'a ColorTable,
}

/// A footprint as the table is read over it: taps along its longer axis, each at a level that stands for the shorter one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    /// Level to read.
    pub level: f64,
    /// Taps on either side of the middle.
    pub sides: usize,
    /// From one tap to the next.
    pub step: DVec2,
    /// The weight of tap k relative to the middle is exp(−`fall`·k²).
    pub fall: f64,
}

/// Taps are at most so many standard deviations of the level's average apart: a row of Gaussians so far apart is even to 3.4 %.
pub const TAP_SPACING: f64 = 2.2;
/// Most taps on either side. A longer footprint is read at a coarser level.
pub const MOST_SIDES: usize = 8;
/// Taps reach so many standard deviations of the longer axis.
pub const TAP_REACH: f64 = 2.5;

impl<'a> TableReader<'a> {
    /// For `table`.
    pub fn new(table: &'a ColorTable) -> Self {
        Self { table }
    }

    /// How to read over `around`.
    pub fn taps(&self, around: &Covariance) -> Taps {
        let grid = &self.table.header.grid;
        let (half_sum, half_difference) = (0.5 * (around.uu + around.vv), 0.5 * (around.uu - around.vv));
        let root = half_difference.hypot(around.uv);
        let (long, short) = (half_sum + root, (half_sum - root).max(0.0));
        // The level's own standard deviation: of the shorter axis, of the finest level, and of what the taps can bridge.
        let bridged = long.sqrt() * TAP_REACH / (TAP_SPACING * MOST_SIDES as f64);
        let own = short.sqrt().max(grid.finest).max(bridged.min(long.sqrt()));
        let left = (long - own * own).max(0.0).sqrt();
        let level = grid.level(own * own);
        // The blur of a tap is at least that of a texel.
        let tap = own.max(0.5 * grid.spacing(0));
        let sides = (TAP_REACH * left / (TAP_SPACING * tap)).ceil().min(MOST_SIDES as f64) as usize;
        if sides == 0 {
            return Taps { level, sides: 0, step: DVec2::ZERO, fall: 0.0 };
        }
        let angle = 0.5 * around.uv.atan2(half_difference);
        let distance = TAP_REACH * left / sides as f64;
        let fall = 0.5 * (distance / left).powi(2);
        Taps { level, sides, step: DVec2::from_angle(angle) * distance, fall }
    }

    /// XYZ of f cos θ_i \[sr⁻¹\] of one pair in a medium of index `ior`, averaged over `around`.
    pub fn xyz(&self, pair: &Pair, ior: f64, around: &Covariance) -> DVec3 {
        if !pair.above_horizon() {
            return DVec3::ZERO;
        }
        let uvw = pair.uvw();
        let (toward, w) = (-uvw.truncate(), uvw.z.abs());
        let taps = self.taps(around);
        let (mut sum, mut norm) = (DVec3::ZERO, 0.0);
        for k in -(taps.sides as i64)..=taps.sides as i64 {
            let weight = (-taps.fall * (k * k) as f64).exp();
            sum += self.at(toward + taps.step * k as f64, w, taps.level) * weight;
            norm += weight;
        }
        let colour = sum / norm + self.specular(toward, w, around);
        colour * (schlick(ior, pair.cos_half_angle()) * pair.geometric_factor_times_cos_light() / (w * w))
    }

    /// The specular order's share.
    fn specular(&self, toward: DVec2, w: f64, around: &Covariance) -> DVec3 {
        let specular = &self.table.header.specular;
        let place = w / LARGEST_W * (SPECULAR_SAMPLES - 1) as f64;
        let sample = (place as usize).min(SPECULAR_SAMPLES - 2);
        let share = (place - sample as f64) as f32;
        let mut sum = DVec3::ZERO;
        for (variance, weights) in specular.variances.iter().zip(&specular.weights) {
            let (xx, yy) = (variance + around.uu, variance + around.vv);
            let det = xx * yy - around.uv * around.uv;
            let r2 = (yy * toward.x * toward.x - 2.0 * around.uv * toward.x * toward.y
                + xx * toward.y * toward.y)
                / det;
            let lobe = (-0.5 * r2).exp() / (2.0 * PI * det.sqrt());
            let (a, b) = (glam::Vec3::from(weights[sample]), glam::Vec3::from(weights[sample + 1]));
            sum += a.lerp(b, share).as_dvec3() * lobe;
        }
        sum
    }

    /// The table's value at a place, |w| and level.
    pub fn at(&self, toward: DVec2, w: f64, level: f64) -> DVec3 {
        let grid = &self.table.header.grid;
        let lower = (level as usize).min(grid.levels - 1);
        let share = level - lower as f64;
        let value = self.at_level(toward, w, lower);
        if share > 0.0 && lower + 1 < grid.levels {
            return value.lerp(self.at_level(toward, w, lower + 1), share);
        }
        value
    }

    fn at_level(&self, toward: DVec2, w: f64, level: usize) -> DVec3 {
        let header = &self.table.header;
        let (side, pieces) = (header.grid.side_of(level), header.pieces);
        let texels = &self.table.levels[level];
        let place = (toward + header.grid.extent) / header.grid.spacing(level) - 0.5;
        let corner = place.floor();
        let t = place - corner;
        let clamp = |i: f64| i.clamp(0.0, side as f64 - 1.0) as usize;
        let in_w = w / LARGEST_W * pieces as f64;
        let piece = (in_w as usize).min(pieces - 1);
        let x = 2.0 * (in_w - piece as f64) - 1.0;
        let channel = |channel: usize| {
            let layer = (piece * 3 + channel) * side * side;
            let at = |i: f64, j: f64| {
                let texel = (layer + clamp(corner.y + j) * side + clamp(corner.x + i)) * 4;
                let c: [f64; 4] = std::array::from_fn(|k| texels[texel + k].to_f64());
                c[0] + x * (c[1] + x * (c[2] + x * c[3]))
            };
            let row = |j: f64| at(0.0, j) * (1.0 - t.x) + at(1.0, j) * t.x;
            (row(0.0) * (1.0 - t.y) + row(1.0) * t.y) * header.unit
        };
        DVec3::new(channel(0), channel(1), channel(2))
    }
}
