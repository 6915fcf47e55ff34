//! Mean over coherence areas in f64 for many directions: Fourier transforms at Chebyshev nodes in z give the power of
//! every order, and a direction sums the few orders around it.

use super::albedo::{Decimation, DirectionalAlbedo};
use super::energy_map::EnergyMap;
use super::mean::MeanBrdf;
use super::seen_part::SeenPart;
use super::spread::{CUT, NEAREST, Spread};
use crate::budget::ErrorBudget;
use crate::error::{Error, Remedy, Result};
use crate::filter::Covariance;
use crate::optics::energy::EnergyLimit;
use crate::optics::geometry::Pair;
use crate::optics::polarisation::Polarisation;
use crate::optics::quadrature::{SPAN, Wavelengths};
use crate::optics::spectrum::{Illuminant, LONGEST};
use crate::spectra::power::{
    Blur, Downsampling, OrderGrid, OrderSeries, PowerSettings, Pyramid, PyramidLevel, TERMS_AT_ONCE,
    Transform,
};
use crate::surface::HeightField;
use crate::task::{DIRECTIONS, ORDERS, Task};
use glam::{DVec2, DVec3, Vec4};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

/// Nodes in z in addition to those required by the height range: the interpolation error falls below 1e-8 on every
/// surface of the tests.
const MORE_NODES: usize = 16;

/// Orders to sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SummedOrders {
    /// All orders.
    All,
    /// All but the specular order.
    Scattered,
}

/// Sampling of wavelengths for colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourSampling {
    /// Level of the coherence function beyond which the colour integral may alias.
    pub alias_level: f64,
    /// Wavelengths required by the colour functions alone.
    pub nodes: usize,
}

impl ColourSampling {
    /// Sampling of the reference: with 101 wavelengths, colours of *Elaphe* in the specular direction differ from 401
    /// by 1.6e-6.
    pub const EXACT: Self = Self { alias_level: 1e-9, nodes: 128 };

    /// Returns the sampling that keeps the relative error of each colour well below `tolerance`, including dark ones.
    pub fn within(tolerance: f64) -> Self {
        /// Wavelengths of the colour functions alone for a relative error of 1e-3.
        const NODES: usize = 64;
        /// Tolerance at or below which the sampling of the reference is used.
        const SMALL: f64 = 1e-3;
        if tolerance <= SMALL {
            Self::EXACT
        } else {
            Self { alias_level: ErrorBudget::of_directions(tolerance).mean.aliases, nodes: NODES }
        }
    }
}

/// Largest number of terms in z, each of which takes a transform of the field: heights that span 250 µm in visible light.
const MOST_TERMS: usize = 4096;

/// Mean with the power of every order as a Chebyshev series in z. Its power differs from the direct sum by less than
/// 1e-5.
pub struct TabulatedMean {
    mean: MeanBrdf,
    sampling: ColourSampling,
    series: OrderSeries,
    // Made for the first average over many orders.
    pyramid: OnceLock<Pyramid>,
    limit: Option<Arc<DirectionalAlbedo>>,
}

impl TabulatedMean {
    /// Tabulates the powers of all orders of `mean` for wavelengths from `shortest` \[µm\].
    ///
    /// # Errors
    /// Heights that need more than 4096 terms, too little memory, or a cancelled task.
    pub fn new(mean: MeanBrdf, shortest: f64, task: &Task) -> Result<Self> {
        Self::with_sampling(mean, shortest, ColourSampling::EXACT, task)
    }

    /// Tabulates the powers of all orders, for colours by `sampling`.
    ///
    /// # Errors
    /// Same as [`TabulatedMean::new`].
    pub fn with_sampling(
        mean: MeanBrdf,
        shortest: f64,
        sampling: ColourSampling,
        task: &Task,
    ) -> Result<Self> {
        let MeanBrdf { ref field, sigma, beyond, .. } = mean;
        let settings = PowerSettings { shortest, ..PowerSettings::new(sigma, beyond, 0.0) };
        let terms = Self::terms(field, shortest);
        if terms > MOST_TERMS {
            let (low, high) = field.range();
            return Err(Error::limit(
                format!(
                    "heights that span {:.1} um need {terms} terms in z, more than {MOST_TERMS}",
                    high - low
                ),
                [Remedy::Words("check the height and its unit".into()), Remedy::ReferenceMethod],
            ));
        }
        let [x, y] = mean.blur().variance;
        let grid = OrderGrid::new(field, 2.0 / shortest, CUT * x.max(y).sqrt());
        let transform = Transform::new(field, grid, beyond);
        transform.ensure_room()?;
        let series = OrderSeries::with_terms(&transform, &settings, terms, task)?;
        task.report(ORDERS, terms, terms)?;
        Ok(Self { mean, sampling, series, pyramid: OnceLock::new(), limit: None })
    }

    /// Returns the same mean within the limit of energy that its theory has.
    pub fn limited(self, decimation: Decimation) -> Self {
        let limit = self.mean.reflectance.is_limited().then(|| Arc::new(self.albedo(decimation)));
        Self { limit, ..self }
    }

    /// Returns the limit of energy of a surface whose sums are not of its orders, for wavelengths from `shortest` \[µm\]; `None` where the theory has none, and for heights that are
    /// too large for the sum over all orders.
    ///
    /// # Errors
    /// Fails if there is not enough memory, or if the task is cancelled.
    pub fn limit_of(mean: MeanBrdf, shortest: f64, task: &Task) -> Result<Option<Arc<DirectionalAlbedo>>> {
        /// Most terms of the series in z: heights of 60 µm in visible light.
        const MOST_OF_LIMIT: usize = 1024;
        if !mean.reflectance.is_limited() || Self::terms(&mean.field, shortest) > MOST_OF_LIMIT {
            return Ok(None);
        }
        Ok(Some(Arc::new(Self::new(mean, shortest, task)?.albedo(Decimation::Fine))))
    }

    /// Makes the limit of energy of colours, if there is one: [`Self::xyz`] would make it without progress.
    ///
    /// # Errors
    /// Fails if the task is cancelled.
    pub fn prepare_colours(&self, task: &Task) -> Result<()> {
        self.limit.as_ref().map_or(Ok(()), |limit| limit.make_table(task))
    }

    /// Returns the directional albedo of the orders.
    pub fn albedo(&self, decimation: Decimation) -> DirectionalAlbedo {
        DirectionalAlbedo::new(&self.series, &self.mean.reflectance, decimation)
    }

    /// Returns the share of the light from `light` that the orders send into all directions, within the limit of energy: at `wavelength` \[µm\], or
    /// the luminance of the colour under `illuminant`. `None` for polarised light.
    pub fn sent(&self, light: DVec3, wavelength: Option<f64>, illuminant: &Illuminant) -> Option<f64> {
        if self.mean.reflectance.polarisation() != Polarisation::None {
            return None;
        }
        let orders = self.albedo(Decimation::Coarse);
        let is_limited = self.limit.is_some();
        let Some(wavelength) = wavelength else {
            let energy = self.limit.as_ref().map(|limit| EnergyMap::new(limit, illuminant));
            let share =
                |view| energy.as_ref().map_or(1.0, |energy| 1.0 / energy.limit(&Pair::new(light, view)));
            let wavelengths = Wavelengths::catmull_rom(illuminant, self.sampling.nodes);
            return Some(wavelengths.integral(|wavelength| orders.sent(light, wavelength, share)).y);
        };
        let of_light = orders.excess(light, wavelength).max(1.0);
        let share = |view| if is_limited { 1.0 / of_light.max(orders.excess(view, wavelength)) } else { 1.0 };
        Some(orders.sent(light, wavelength, share))
    }

    /// Returns the limit of energy, if there is one.
    pub fn limit(&self) -> Option<&Arc<DirectionalAlbedo>> {
        self.limit.as_ref()
    }

    /// Returns the number of terms in z, each of which takes a transform of `field`, for wavelengths from `shortest` \[µm\].
    pub(super) fn terms(field: &HeightField, shortest: f64) -> usize {
        let (low, high) = field.range();
        let turns = 2.0 * PI / shortest * (high - low);
        (turns.ceil() as usize + MORE_NODES).next_multiple_of(TERMS_AT_ONCE)
    }

    /// Returns ⟨|P|²⟩/A \[µm²\] as [`MeanBrdf::power`].
    pub fn power(&self, uvw: DVec3, q: f64, footprint: &Covariance) -> f64 {
        let f = -uvw.truncate() * q;
        let lobe = Spread::new(Blur::of_coherence(self.mean.sigma), footprint, q);
        let specular = if self.mean.holds(f) { self.specular_order(uvw, q) * lobe.density(f) } else { 0.0 };
        specular + self.scattered_power(uvw, q, footprint)
    }

    /// Returns the power without the specular order.
    pub fn scattered_power(&self, uvw: DVec3, q: f64, footprint: &Covariance) -> f64 {
        let f = -uvw.truncate() * q;
        let z = 2.0 * PI * q * uvw.z.abs();
        if !self.mean.holds(f) || z > self.series.z_max * (1.0 + 1e-9) {
            return 0.0;
        }
        let spread = Spread::new(self.mean.blur(), footprint, q);
        let seen = SeenPart::new(f, &spread, footprint, q);
        z * z * self.blurred(f, &spread, &seen, &self.polynomials_at(z))
    }

    /// Returns |c_0|² at wavenumber `q` \[µm⁻¹\], the power of the specular order.
    pub fn specular_order(&self, uvw: DVec3, q: f64) -> f64 {
        let z = 2.0 * PI * q * uvw.z.abs();
        if z > self.series.z_max * (1.0 + 1e-9) {
            return 0.0;
        }
        self.series.specular_power(z)
    }

    fn polynomials_at(&self, z: f64) -> Vec<f32> {
        let mut t = vec![0.0; self.series.terms];
        self.series.polynomials_at(z, &mut t);
        t.into_iter().map(|t| t as f32).collect()
    }

    /// Returns Σ_m |c_m|²/z² γ̂(f − m/T) for the polynomials `t` of z. γ̂ is `spread`, weighted by the part `seen`.
    fn blurred(&self, f: DVec2, spread: &Spread, seen: &SeenPart, t: &[f32]) -> f64 {
        let [width, height] = self.series.grid.patch;
        let beyond = |[x, y]: [f64; 2]| spread.beyond([x / (width * width), y / (height * height)]);
        // Blur of the first level: its points are two orders apart.
        let narrowest = (2.0 * Downsampling::EXACT.blur).powi(2);
        let orders = Pyramid::orders(&self.series);
        if beyond([narrowest; 2]).is_none() {
            return self.sum(f, spread, seen, t, &orders);
        }
        let pyramid = self.pyramid.get_or_init(|| Pyramid::new(&self.series, Downsampling::EXACT));
        let levels = (1..pyramid.count()).rev().map(|number| pyramid.level(number, &self.series));
        let coarser = levels.filter_map(|level| Some((beyond(level.grid.variance)?, level))).next();
        match coarser {
            Some((left, level)) => self.sum(f, &left, seen, t, &level),
            None => self.sum(f, spread, seen, t, &orders),
        }
    }

    /// Sums the points of `level` under `spread` about `f`, for the polynomials `t` of z. The orders nearest to `f` are
    /// always included: between the orders of a short patch the tails of these are all there is.
    fn sum(&self, f: DVec2, spread: &Spread, seen: &SeenPart, t: &[f32], level: &PyramidLevel<'_>) -> f64 {
        let step = level.grid.step;
        let points = DVec2::from_array(self.series.grid.patch) / DVec2::from_array(step);
        let reach = (spread.yy.sqrt() * CUT).max(NEAREST / points.y);
        let [first, last] = [((f.y - reach) * points.y).ceil(), ((f.y + reach) * points.y).floor()];
        let columns_of = |y: f64| {
            let [left, right] = spread.row(y, NEAREST / points.x);
            ((f.x + left) * points.x).ceil() as i64..((f.x + right) * points.x).floor() as i64 + 1
        };
        let rows: Vec<_> = (first as i64..=last as i64)
            .map(|row| (row, row as f64 / points.y - f.y))
            .map(|(row, y)| (row, y, columns_of(y)))
            .filter(|(.., columns)| !columns.is_empty())
            .collect();
        let leftmost = rows.iter().map(|(.., columns)| columns.start).min().unwrap_or_default();
        let rightmost = rows.iter().map(|(.., columns)| columns.end).max().unwrap_or_default();
        let shares: Vec<f64> =
            (leftmost..rightmost).map(|column| seen.share_along(0, column as f64 / points.x)).collect();
        let mut sum = 0.0;
        for (row, y, columns) in rows {
            let Some(line) = level.row(row) else { continue };
            let (mut of_row, mut line) = (0.0, line.points_from(columns.start));
            let from = DVec2::new(columns.start as f64 / points.x - f.x, y);
            let shares = &shares[(columns.start - leftmost) as usize..];
            spread.densities(from, 1.0 / points.x, (columns.end - columns.start) as usize, |k, weight| {
                if let Some(series) = line.next_point() {
                    of_row += weight * shares[k] * f64::from(dot(series, t));
                }
            });
            sum += of_row * seen.share_along(1, f.y + y);
        }
        (sum * step[0] * step[1]).max(0.0)
    }

    /// Returns f cos θ_i \[sr⁻¹\] of one pair at `wavelength` \[µm\], averaged over `footprint`.
    pub fn cosine_weighted(&self, pair: &Pair, wavelength: f64, footprint: &Covariance) -> f64 {
        let limit = self.limit.as_ref().map_or(1.0, |limit| limit.single(pair, wavelength));
        self.unlimited(pair, wavelength, footprint) / limit
    }

    /// Returns [`Self::cosine_weighted`] without the limit of energy.
    pub fn unlimited(&self, pair: &Pair, wavelength: f64, footprint: &Covariance) -> f64 {
        self.weighted(pair, wavelength, |uvw, q| self.power(uvw, q, footprint))
    }

    /// Returns f cos θ_i \[sr⁻¹\] for the `power` at (u, v, w) and a wavenumber, without a limit.
    fn weighted(&self, pair: &Pair, wavelength: f64, power: impl Fn(DVec3, f64) -> f64) -> f64 {
        if !pair.above_horizon() {
            return 0.0;
        }
        let power = power(pair.uvw(), 1.0 / wavelength);
        self.mean.reflectance.cosine_weighted(pair, wavelength, 1.0, power)
    }

    /// Returns XYZ of f cos θ_i \[sr⁻¹\] of each pair under `illuminant`, averaged over its covariance, by these
    /// `orders`.
    ///
    /// # Errors
    /// Fails if the task is cancelled.
    pub fn xyz(
        &self,
        illuminant: &Illuminant,
        pairs: &[(Pair, Covariance)],
        orders: SummedOrders,
        task: &Task,
    ) -> Result<Vec<DVec3>> {
        const AT_ONCE: usize = 1024;
        let counts: Vec<usize> =
            pairs.iter().map(|(pair, footprint)| self.colour_nodes(pair, footprint)).collect();
        let distinct: std::collections::BTreeSet<usize> = counts.iter().copied().collect();
        let sets: BTreeMap<usize, Wavelengths> =
            distinct.into_par_iter().map(|n| (n, Wavelengths::catmull_rom(illuminant, n))).collect();
        let energy = self.limit.as_ref().map(|limit| EnergyMap::new(limit, illuminant));
        let mut colours = Vec::with_capacity(pairs.len());
        for (pairs_now, counts_now) in pairs.chunks(AT_ONCE).zip(counts.chunks(AT_ONCE)) {
            task.report(DIRECTIONS, colours.len(), pairs.len())?;
            colours.par_extend(pairs_now.par_iter().zip(counts_now).map(|((pair, footprint), count)| {
                sets.get(count).map_or(DVec3::ZERO, |wavelengths| {
                    wavelengths.integral(|wavelength| {
                        let power = |uvw, q| match orders {
                            SummedOrders::All => self.power(uvw, q, footprint),
                            SummedOrders::Scattered => self.scattered_power(uvw, q, footprint),
                        };
                        self.weighted(pair, wavelength, power)
                    }) / energy.as_ref().map_or(1.0, |energy| energy.limit(pair))
                })
            }));
        }
        task.report(DIRECTIONS, pairs.len(), pairs.len())?;
        Ok(colours)
    }

    /// Returns XYZ of the light reflected toward `view` by the specular order from surroundings of radiance 1.
    pub fn mirrored(&self, illuminant: &Illuminant, views: &[DVec3]) -> Vec<DVec3> {
        let wavelengths = Wavelengths::catmull_rom(illuminant, self.sampling.nodes);
        let energy = self.limit.as_ref().map(|limit| EnergyMap::new(limit, illuminant));
        let of = |view: &DVec3| {
            let pair = Pair::new(DVec3::new(-view.x, -view.y, view.z), *view);
            // The integral of the lobe's density over (u, v) is 1/q², and du dv = cos θ_i dω_i.
            let power = |uvw: DVec3, q: f64| self.specular_order(uvw, q) / (q * q);
            let limit = energy.as_ref().map_or(1.0, |energy| energy.limit(&pair));
            wavelengths.integral(|wavelength| self.weighted(&pair, wavelength, power))
                / (limit * view.z.max(f64::MIN_POSITIVE))
        };
        views.par_iter().map(of).collect()
    }

    /// Returns the number of wavelengths that resolve the response along the ray of `pair`, rounded up to one of few
    /// counts.
    fn colour_nodes(&self, pair: &Pair, footprint: &Covariance) -> usize {
        /// Ratio between counts, so that few sets of weights serve all directions.
        const STEP: f64 = 1.1;
        let uv = pair.uvw().truncate();
        // In the specular direction every wavelength reads the same point.
        let along = uv.try_normalize().unwrap_or(DVec2::X);
        let q = 1.0 / LONGEST;
        let spread = Spread::new(Blur::of_coherence(self.mean.sigma), footprint, q);
        let variance = spread.xx * along.x * along.x
            + 2.0 * spread.xy * along.x * along.y
            + spread.yy * along.y * along.y;
        // The correlation function of a blur of standard deviation b is exp(−2π²b²Δ²).
        let extent = (1.0 / self.sampling.alias_level).ln().sqrt() / (PI * (2.0 * variance).sqrt());
        let count = self.sampling.nodes as f64 + SPAN * uv.length() * extent;
        STEP.powf((count.ln() / STEP.ln()).ceil()) as usize
    }

    /// Returns |c_m|² at z = k|w| \[rad/µm\]; 0 for an order that is not held.
    pub(super) fn order_power(&self, order: [i64; 2], z: f64) -> f64 {
        if order == [0, 0] {
            return self.series.specular_power(z);
        }
        let series = Pyramid::orders(&self.series).at(order[0], order[1]).unwrap_or_default();
        let mut t = vec![0.0; self.series.terms];
        self.series.polynomials_at(z, &mut t);
        let sum: f64 = series.iter().zip(&t).map(|(a, t)| f64::from(*a) * t).sum();
        (z * z * sum).max(0.0)
    }

    /// Returns the shortest tabulated wavelength \[µm\].
    pub fn shortest(&self) -> f64 {
        4.0 * PI / self.series.z_max
    }
}

/// Returns Σ a b by eight partial sums, so that the loop uses vector registers. It is written as loops because a
/// development build does not inline sums of iterators.
fn dot(mut a: &[f32], mut b: &[f32]) -> f32 {
    let mut sums = [Vec4::ZERO; 2];
    while let (
        &[a0, a1, a2, a3, a4, a5, a6, a7, ref a_left @ ..],
        &[b0, b1, b2, b3, b4, b5, b6, b7, ref b_left @ ..],
    ) = (a, b)
    {
        sums[0] += Vec4::new(a0, a1, a2, a3) * Vec4::new(b0, b1, b2, b3);
        sums[1] += Vec4::new(a4, a5, a6, a7) * Vec4::new(b4, b5, b6, b7);
        (a, b) = (a_left, b_left);
    }
    let mut sum = (sums[0] + sums[1]).element_sum();
    while let (&[first_a, ref a_left @ ..], &[first_b, ref b_left @ ..]) = (a, b) {
        sum += first_a * first_b;
        (a, b) = (a_left, b_left);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::mean::tests::{DIRECTIONS, pair, rough};
    use crate::spectra::power::Beyond;
    use crate::surface::synth::{self, Spec, SurfaceKind};

    #[test]
    fn averages_over_many_orders_are_the_sum_over_all_of_them() {
        let elaphe = |spacing: f64| {
            let spec = Spec {
                patch: Some([12.0, 8.0]),
                pixel_size: Some([spacing; 2]),
                ..Spec::new(SurfaceKind::Elaphe)
            };
            synth::generate(&spec).unwrap()
        };
        let rough = |width: usize, height: usize| {
            let heights = (0..width * height).map(|i| 0.15 * ((i * 37 % 101) as f64 * 0.7).sin()).collect();
            HeightField::new(width, height, [0.25; 2], heights).unwrap()
        };
        // With samples 0.25 µm apart the orders wrap around, and their number may be odd.
        for field in [elaphe(0.1), elaphe(0.25), rough(48, 34), rough(49, 33)] {
            let name = (field.columns(), field.rows());
            let mean = MeanBrdf::in_sunlight(&field, 1.5);
            let table = TabulatedMean::new(mean, 0.38, &Task::silent()).unwrap();
            for (uu, uv, vv) in [(0.02, 0.0, 0.02), (0.2, 0.05, 0.03), (0.3, -0.1, 0.3), (1e-3, 0.0, 0.2)] {
                let footprint = Covariance { uu, uv, vv };
                for (uvw, q) in [(DVec3::new(0.1, -0.2, -1.8), 2.2), (DVec3::new(-0.9, 0.6, -1.0), 1.5)] {
                    let spread = Spread::new(table.mean.blur(), &footprint, q);
                    let z = 2.0 * PI * q * uvw.z.abs();
                    let t = table.polynomials_at(z);
                    let f = -uvw.truncate() * q;
                    let all = table.sum(f, &spread, &SeenPart::ALL, &t, &Pyramid::orders(&table.series));
                    let some = table.blurred(f, &spread, &SeenPart::ALL, &t);
                    assert!((some / all - 1.0).abs() < 1e-5, "{name:?}, {footprint:?}: {some} of {all}");
                }
            }
            let coarser = table.pyramid.get().map_or(0, |pyramid| pyramid.count() - 1);
            assert!(coarser > 0, "{name:?} samples have no levels");
        }
    }

    #[test]
    fn the_transforms_give_the_direct_sum() {
        for field in [
            rough(),
            synth::generate(&Spec { patch: Some([12.0; 2]), ..Spec::new(SurfaceKind::Blaze) }).unwrap(),
        ] {
            for beyond in [Beyond::Copies, Beyond::Alike] {
                let mean = MeanBrdf { field: field.clone(), sigma: 2.0, beyond, reflectance: 1.5.into() };
                let table = TabulatedMean::new(mean.clone(), 0.38, &Task::silent()).unwrap();
                for footprint in [Covariance::default(), Covariance { uu: 4e-4, uv: 1e-4, vv: 1e-3 }] {
                    for directions in DIRECTIONS {
                        for wavelength in [0.4, 0.55, 0.7] {
                            let uvw = pair(directions).uvw();
                            let direct = mean.power(uvw, 1.0 / wavelength, &footprint);
                            let fast = table.power(uvw, 1.0 / wavelength, &footprint);
                            // Relative to the mean density of power, 1 over the band, where the value itself is
                            // smaller.
                            assert!(
                                (fast - direct).abs() <= 1e-5 * direct + 1e-9,
                                "{beyond:?} {directions:?} {wavelength}: {fast} {direct}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn averages_that_reach_beyond_the_horizon_along_x_or_y_are_the_direct_sum() {
        let field = rough();
        let mean =
            MeanBrdf { field: field.clone(), sigma: 2.0, beyond: Beyond::Copies, reflectance: 1.5.into() };
        let table = TabulatedMean::new(mean.clone(), 0.38, &Task::silent()).unwrap();
        let (footprint, q) = (Covariance { uu: 0.02, uv: 0.005, vv: 0.03 }, 1.0 / 0.55);
        for uvw in [DVec3::new(1.75, 0.3, -0.8), DVec3::new(0.2, -1.8, -0.7), DVec3::new(1.4, 1.3, -0.5)] {
            let f = -uvw.truncate() * q;
            let seen = SeenPart::new(f, &Spread::new(mean.blur(), &footprint, q), &footprint, q);
            let beyond = seen.share(1.6 * f);
            assert!(beyond < 0.5, "the horizon leaves {beyond} of an order beyond it");
            let (direct, fast) = (mean.power(uvw, q, &footprint), table.power(uvw, q, &footprint));
            // Relative to the mean density of power, 1 over the band, where the value itself is smaller.
            assert!((fast - direct).abs() <= 1e-5 * direct + 1e-9, "{uvw}: {fast} {direct}");
        }
    }
}
