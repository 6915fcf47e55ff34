//! Interpolation of a colour table between its texels and over footprints: the twin of `shaders/source_table.glsl`.

use super::basis::PER_TEXEL;
use super::{ColorBasis, ColorTable, LARGEST_W, SPECULAR_SAMPLES};
use crate::brdf::energy_map::EnergyMap;
use crate::filter::{self, Covariance, Levels, Tap, Taps};
use crate::optics::geometry::Pair;
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::MIDDLE;
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Reader of one table.
#[derive(Clone, Debug)]
pub struct TableReader {
    table: Arc<ColorTable>,
    // Limits of energy, as in an energy map.
    energy: Option<Vec<[f32; 2]>>,
}

impl TableReader {
    /// Returns a reader of `table`, within the limit of energy that an export contains.
    pub fn new(table: Arc<ColorTable>) -> Self {
        let energy = table.header.energy.clone();
        Self { table, energy }
    }

    /// Returns the same reader within a limit of energy.
    pub fn limited(self, energy: Option<&EnergyMap>) -> Self {
        Self { energy: energy.map(|map| map.points().to_vec()), ..self }
    }

    /// Returns the level to read over `footprint`, and the taps. The level is the coarsest one that averages over no more than the shorter
    /// axis, and taps average over the rest.
    pub fn taps(&self, footprint: &Covariance) -> (usize, Taps) {
        let header = &self.table.header;
        let [_, shorter] = footprint.axes();
        let grid = &header.grid;
        let across =
            shorter.max(grid.finest.powi(2)).max(filter::least_own(footprint, header.coherence_blur));
        let level = grid.level(across);
        let next = (level + 1 < grid.levels).then(|| grid.variance(level + 1));
        let levels = Levels { read: grid.variance(level), next, blur: header.coherence_blur };
        (level, Taps::new(footprint, across, levels))
    }

    /// Returns XYZ of f cos θ_i \[sr⁻¹\] of one pair, averaged over `footprint`, on a surface that reflects by `reflectance`. A table that was
    /// baked for a spectral reflectance contains it, except for the mean in its header.
    pub fn xyz(&self, pair: &Pair, reflectance: &Reflectance, footprint: &Covariance) -> DVec3 {
        if !pair.above_horizon() {
            return DVec3::ZERO;
        }
        let specular = self.specular(-pair.uvw().truncate(), pair.uvw().z.abs(), footprint);
        self.scattered(pair, reflectance, footprint) + specular * self.share(pair, reflectance)
    }

    /// Returns the same without the specular order.
    pub fn scattered(&self, pair: &Pair, reflectance: &Reflectance, footprint: &Covariance) -> DVec3 {
        if !pair.above_horizon() {
            return DVec3::ZERO;
        }
        let uvw = pair.uvw();
        let (toward, w) = (-uvw.truncate(), uvw.z.abs());
        let (level, taps) = self.taps(footprint);
        let read = |tap: Tap| self.at(toward + tap.place, w, level + usize::from(tap.coarser)) * tap.weight;
        let sum: DVec3 = taps.each().map(read).sum();
        sum * (w * w) * self.share(pair, reflectance)
    }

    /// Returns XYZ of the specular order toward `view` from the mirrored direction, integrated over (u, v). Twin of `source_mirrored` in
    /// `source_table.glsl`.
    pub fn mirrored(&self, view: DVec3, reflectance: &Reflectance) -> DVec3 {
        let pair = Pair::new(DVec3::new(-view.x, -view.y, view.z), view);
        if !pair.above_horizon() {
            return DVec3::ZERO;
        }
        let weights = self.table.header.specular.weights.iter();
        let sum: DVec3 = weights.map(|weights| Self::weight(weights, pair.uvw().z.abs())).sum();
        sum * self.share(&pair, reflectance)
    }

    /// Returns the factor of X, Y and Z over |w|², within the limit of energy.
    fn share(&self, pair: &Pair, reflectance: &Reflectance) -> DVec3 {
        let limit = self.energy.as_ref().map_or(1.0, |points| EnergyMap::limit_of(points, pair));
        self.factor(pair, reflectance) / (pair.uvw().z.powi(2) * limit)
    }

    /// Returns the factor in front of X, Y and Z.
    fn factor(&self, pair: &Pair, reflectance: &Reflectance) -> DVec3 {
        let header = &self.table.header;
        if let Some(indices) = &header.indices {
            let cosines = 4.0 * pair.light.z * pair.light.z * pair.view.z;
            return DVec3::from_array(indices.intensity(pair)) * cosines;
        }
        let factor = match &header.mean_reflectance {
            Some(mean) => mean.at(pair.cos_half_angle()) * pair.geometric_factor_times_cos_light(),
            None => reflectance.factor(pair.light, MIDDLE).toward(pair.view),
        };
        DVec3::splat(factor)
    }

    /// Returns the share of the specular order.
    fn specular(&self, toward: DVec2, w: f64, footprint: &Covariance) -> DVec3 {
        let specular = &self.table.header.specular;
        let mut sum = DVec3::ZERO;
        for (variance, weights) in specular.variances.iter().zip(&specular.weights) {
            let (xx, yy) = (variance + footprint.uu, variance + footprint.vv);
            let det = xx * yy - footprint.uv * footprint.uv;
            let r2 = (yy * toward.x * toward.x - 2.0 * footprint.uv * toward.x * toward.y
                + xx * toward.y * toward.y)
                / det;
            let lobe = (-0.5 * r2).exp() / (2.0 * PI * det.sqrt());
            sum += Self::weight(weights, w) * lobe;
        }
        sum
    }

    /// Returns the weight of a band of the specular order at |w|.
    fn weight(weights: &[[f32; 3]], w: f64) -> DVec3 {
        let place = w / LARGEST_W * (SPECULAR_SAMPLES - 1) as f64;
        let sample = (place as usize).min(SPECULAR_SAMPLES - 2);
        let (a, b) = (Vec3::from(weights[sample]), Vec3::from(weights[sample + 1]));
        a.lerp(b, (place - sample as f64) as f32).as_dvec3()
    }

    /// Returns the table's value at a place, |w| and level.
    pub fn at(&self, toward: DVec2, w: f64, level: usize) -> DVec3 {
        let header = &self.table.header;
        let side = header.grid.side_of(level);
        let texels = self.table.level(level);
        let place = (toward + header.grid.extent) / header.grid.spacing(level) - 0.5;
        let corner = place.floor();
        let t = place - corner;
        let within = |i: f64| (0.0..side as f64).contains(&i);
        let (piece, x) = header.basis.piece(w);
        let number = |component: usize| {
            let layer = (piece * header.basis.texels() + component / PER_TEXEL) * side * side;
            let at = |i: f64, j: f64| {
                let (row, column) = (corner.y + j, corner.x + i);
                if !(within(row) && within(column)) {
                    return 0.0;
                }
                let texel = (layer + row as usize * side + column as usize) * PER_TEXEL;
                texels[texel + component % PER_TEXEL].to_f64()
            };
            let row = |j: f64| at(0.0, j) * (1.0 - t.x) + at(1.0, j) * t.x;
            (row(0.0) * (1.0 - t.y) + row(1.0) * t.y) as f32
        };
        let numbers: Vec<f32> = (0..header.basis.components).map(number).collect();
        ColorBasis::colour(header.basis.of_piece(piece), &numbers, x).as_dvec3() * header.unit
    }
}
