//! The mean over coherence areas in f64: a direct sum over the samples for a few directions, and Fourier transforms at
//! Chebyshev nodes in z for many. See [`crate::spectra::power`] for the formula.

use super::pyramid::{self, GridLine, PyramidLevel};
use super::spread::{CUT, Spread};
use super::{Brdf, without_cosine};
use crate::error::Result;
use crate::filter::Covariance;
use crate::memory;
use crate::optics::brdf::cosine_weighted;
use crate::optics::coherence::SUNLIGHT_LENGTH;
use crate::optics::geometry::Pair;
use crate::optics::nufft::Progress;
use crate::optics::quadrature::{Nodes, SPAN};
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::{Illuminant, LONGEST};
use crate::spectra::power::chebyshev::{coefficients_from_values, nodes, polynomials};
use crate::spectra::power::{Beyond, Blur, OrderGrid, Transform};
use crate::surface::HeightField;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rustfft::num_complex::Complex64;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Nodes in z beyond those that the height range asks for: the interpolation error falls below 1e-8 on every surface of the tests.
const MORE_NODES: usize = 16;
/// Wavelengths of the colour functions alone; with 101 of them colours of *Elaphe* differ from 401 by 1.6e-6.
const COLOUR_NODES: usize = 128;
/// Level of the coherence function beyond which the colour integral may alias.
const ALIAS_LEVEL: f64 = 1e-9;

/// A surface whose mean response is asked for.
#[derive(Clone, Debug)]
pub struct MeanBrdf<'a> {
    /// The height field.
    pub field: &'a HeightField,
    /// Standard deviation of the coherence window \[µm\], a quarter of the coherence length.
    pub sigma: f64,
    /// How the surface goes on beyond the patch.
    pub beyond: Beyond,
    /// What the surface reflects.
    pub reflectance: Reflectance,
}

impl<'a> MeanBrdf<'a> {
    /// What a pixel sees of copies of `field`, which reflects by `reflectance` (a number is a refractive index), in sunlight.
    pub fn in_sunlight(field: &'a HeightField, reflectance: impl Into<Reflectance>) -> Self {
        Self { field, sigma: SUNLIGHT_LENGTH / 4.0, beyond: Beyond::Copies, reflectance: reflectance.into() }
    }
}

impl MeanBrdf<'_> {
    /// Whether the samples hold the frequency `f` \[µm⁻¹\]: beyond 1/(2dx) the response is 0.
    fn holds(&self, f: DVec2) -> bool {
        let [dx, dy] = self.field.pixel_size();
        f.x.abs() <= 0.5 / dx && f.y.abs() <= 0.5 / dy
    }

    fn blur(&self) -> Blur {
        Blur::of_orders(self.sigma, self.field.patch_size(), self.beyond)
    }

    /// ⟨|P|²⟩/A \[µm²\] at wavenumber `q` \[µm⁻¹\] for one (u, v, w), by a direct sum over all samples for each order near the frequency.
    pub fn power(&self, uvw: DVec3, q: f64, around: &Covariance) -> f64 {
        let f = -uvw.truncate() * q;
        if !self.holds(f) {
            return 0.0;
        }
        let z = 2.0 * PI * q * uvw.z.abs();
        let spread = Spread::new(self.blur(), around, q);
        let patch = DVec2::from_array(self.field.patch_size());
        let first = |centre: f64, width: f64, side: f64| ((centre - CUT * width) * side).ceil() as i64;
        let last = |centre: f64, width: f64, side: f64| ((centre + CUT * width) * side).floor() as i64;
        let (sx, sy) = (spread.xx.sqrt(), spread.yy.sqrt());
        let columns: Vec<i64> = (first(f.x, sx, patch.x)..=last(f.x, sx, patch.x)).collect();
        let rows: Vec<i64> = (first(f.y, sy, patch.y)..=last(f.y, sy, patch.y)).collect();
        let (specular, powers) = self.order_powers(z, &columns, &rows);
        let blurred: f64 = powers
            .iter()
            .enumerate()
            .map(|(i, power)| {
                let m = DVec2::new(columns[i % columns.len()] as f64, rows[i / columns.len()] as f64);
                power * spread.density(f - m / patch)
            })
            .sum();
        blurred + specular * Spread::new(Blur::of_coherence(self.sigma), around, q).density(f)
    }

    /// |c_0|², and |c_m|² for m in `columns` × `rows`, row by row, each a plain sum over the samples.
    fn order_powers(&self, z: f64, columns: &[i64], rows: &[i64]) -> (f64, Vec<f64>) {
        let field = self.field;
        let (low, high) = field.range();
        let middle = 0.5 * (low + high);
        let samples = [field.columns(), field.rows()];
        let taper = samples.map(|n| self.taper(n));
        let phases: Vec<Vec<Complex64>> = (0..samples[1])
            .into_par_iter()
            .map(|row| field.row(row).iter().map(|h| Complex64::cis(z * (h - middle))).collect())
            .collect();
        let count = (samples[0] * samples[1]) as f64;
        let weighed = |row: usize| -> Complex64 {
            let along = phases[row].iter().zip(&taper[0]).map(|(p, t)| p * (t * t)).sum::<Complex64>();
            along * taper[1][row].powi(2)
        };
        let mean = (0..samples[1]).map(weighed).sum::<Complex64>() / count;
        let offset = if self.beyond == Beyond::Alike { mean } else { Complex64::ZERO };
        let turns = |m: i64, place: f64, side: f64| Complex64::cis(2.0 * PI * m as f64 * place / side);
        let [tx, ty] = field.patch_size();
        let along_x: Vec<Vec<Complex64>> = columns
            .par_iter()
            .map(|&m| (0..samples[0]).map(|c| turns(m, field.x(c), tx) * taper[0][c]).collect())
            .collect();
        // [column order][row] sums along x.
        let sums: Vec<Vec<Complex64>> = along_x
            .par_iter()
            .map(|twiddles| {
                let dot = |row: usize| -> Complex64 {
                    phases[row].iter().zip(twiddles).map(|(p, t)| (p - offset) * t).sum::<Complex64>()
                        * taper[1][row]
                };
                (0..samples[1]).map(dot).collect()
            })
            .collect();
        let mut powers = Vec::with_capacity(columns.len() * rows.len());
        for &my in rows {
            let along_y: Vec<Complex64> = (0..samples[1]).map(|r| turns(my, field.y(r), ty)).collect();
            for (&mx, sums) in columns.iter().zip(&sums) {
                let sum: Complex64 = sums.iter().zip(&along_y).map(|(s, t)| s * t).sum();
                let is_specular = mx == 0 && my == 0 && self.beyond == Beyond::Copies;
                powers.push(if is_specular { 0.0 } else { (sum / count).norm_sqr() });
            }
        }
        (mean.norm_sqr(), powers)
    }

    fn taper(&self, count: usize) -> Vec<f64> {
        match self.beyond {
            Beyond::Copies => vec![1.0; count],
            Beyond::Alike => {
                let window = |i: usize| 0.5 - 0.5 * (2.0 * PI * (i as f64 + 0.5) / count as f64).cos();
                let power = (0..count).map(|i| window(i).powi(2)).sum::<f64>() / count as f64;
                (0..count).map(|i| window(i) / power.sqrt()).collect()
            }
        }
    }

    /// The BRDF \[sr⁻¹\] at `wavelength` \[µm\] by the direct sum; 0 below the horizon.
    pub fn brdf(&self, pair: &Pair, wavelength: f64) -> f64 {
        if !pair.above_horizon() {
            return 0.0;
        }
        let power = self.power(pair.uvw(), 1.0 / wavelength, &Covariance::default());
        let reflectance = self.reflectance.at(wavelength, pair.cos_half_angle());
        reflectance * cosine_weighted(pair, wavelength, 1.0, power) / pair.light.z
    }
}

/// Which orders are summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SummedOrders {
    /// All of them.
    All,
    /// All but the specular one.
    Scattered,
}

/// The mean with every order's power as a Chebyshev series in z.
pub struct TabulatedMean<'a> {
    mean: MeanBrdf<'a>,
    grid: OrderGrid,
    z_max: f64,
    terms: usize,
    // Coefficients of |c_m|²/z², order by order. 32-bit floats leave 6e-8 of each.
    orders: Vec<f32>,
    // Coefficients of |c_0|².
    specular: Vec<f64>,
    // Made when an average over many orders is first asked for.
    levels: OnceLock<Vec<PyramidLevel>>,
}

impl<'a> TabulatedMean<'a> {
    /// Tabulates the powers of all orders of `mean` for wavelengths from `shortest` \[µm\].
    ///
    /// # Errors
    /// Where memory does not suffice; what `progress` returns.
    pub fn new(mean: MeanBrdf<'a>, shortest: f64, progress: Progress<'_>) -> Result<Self> {
        let z_max = 4.0 * PI / shortest;
        let (low, high) = mean.field.range();
        let terms = (0.5 * z_max * (high - low)).ceil() as usize + MORE_NODES;
        let blur = mean.blur();
        let guard = CUT * blur.variance[0].max(blur.variance[1]).sqrt();
        let grid = OrderGrid::new(mean.field, 2.0 / shortest, guard);
        let transform = Transform::new(mean.field, grid, mean.beyond);
        let bytes = (grid.count() * terms * size_of::<f32>()) as u64;
        memory::ensure_room(bytes, "the powers of all orders")?;
        transform.ensure_room()?;
        let mut orders = vec![0f32; grid.count() * terms];
        let mut specular = vec![0.0; terms];
        let nodes = nodes(terms, z_max);
        for (j, &z) in nodes.iter().enumerate() {
            progress(j, terms)?;
            let powers = transform.at(z);
            specular[j] = powers.specular;
            let scale = 1.0 / (z * z);
            orders
                .par_chunks_mut(terms)
                .zip(&powers.powers)
                .for_each(|(order, power)| order[j] = (power * scale) as f32);
        }
        let matrix = coefficients_from_values(terms);
        let apply = |values: &[f64]| -> Vec<f64> {
            matrix.iter().map(|row| row.iter().zip(values).map(|(m, v)| m * v).sum()).collect()
        };
        specular = apply(&specular);
        orders.par_chunks_mut(terms).for_each(|order| {
            let values: Vec<f64> = order.iter().map(|&v| f64::from(v)).collect();
            order.iter_mut().zip(apply(&values)).for_each(|(slot, a)| *slot = a as f32);
        });
        progress(terms, terms)?;
        Ok(Self { mean, grid, z_max, terms, orders, specular, levels: OnceLock::new() })
    }

    /// ⟨|P|²⟩/A \[µm²\] as [`MeanBrdf::power`].
    pub fn power(&self, uvw: DVec3, q: f64, around: &Covariance) -> f64 {
        let f = -uvw.truncate() * q;
        let lobe = Spread::new(Blur::of_coherence(self.mean.sigma), around, q);
        let specular = if self.mean.holds(f) { self.specular_order(uvw, q) * lobe.density(f) } else { 0.0 };
        specular + self.scattered_power(uvw, q, around)
    }

    /// The same without the specular order.
    pub fn scattered_power(&self, uvw: DVec3, q: f64, around: &Covariance) -> f64 {
        let f = -uvw.truncate() * q;
        let z = 2.0 * PI * q * uvw.z.abs();
        if !self.mean.holds(f) || z > self.z_max * (1.0 + 1e-9) {
            return 0.0;
        }
        let t: Vec<f32> = self.polynomials_at(z).into_iter().map(|t| t as f32).collect();
        z * z * self.blurred(f, &Spread::new(self.mean.blur(), around, q), &t)
    }

    /// |c_0|² at wavenumber `q` \[µm⁻¹\], the specular order's share of the power.
    pub fn specular_order(&self, uvw: DVec3, q: f64) -> f64 {
        let z = 2.0 * PI * q * uvw.z.abs();
        if z > self.z_max * (1.0 + 1e-9) {
            return 0.0;
        }
        self.specular.iter().zip(self.polynomials_at(z)).map(|(a, t)| a * t).sum::<f64>().max(0.0)
    }

    fn polynomials_at(&self, z: f64) -> Vec<f64> {
        let mut t = vec![0.0; self.terms];
        polynomials(2.0 * z / self.z_max - 1.0, &mut t);
        t
    }

    /// Σ_m |c_m|²/z² γ̂(f − m/T) for the polynomials `t` of z.
    fn blurred(&self, f: DVec2, spread: &Spread, t: &[f32]) -> f64 {
        let [width, height] = self.grid.patch;
        let beyond = |[x, y]: [f64; 2]| spread.beyond([x / (width * width), y / (height * height)]);
        let all = || self.sum(f, spread, t, [1.0; 2], |x, y| self.order(x, y));
        if beyond(pyramid::NARROWEST).is_none() {
            return all();
        }
        let levels = self.levels.get_or_init(|| self.make_levels());
        let coarser = levels.iter().rev().find_map(|level| beyond(level.variance).map(|left| (level, left)));
        match coarser {
            Some((level, left)) => self.sum(f, &left, t, level.step, |x, y| level.at(x, y)),
            None => all(),
        }
    }

    /// Sum of the points `step` orders apart along x and y under `spread` about `f`, for the polynomials `t` of z.
    fn sum<'b>(
        &self,
        f: DVec2,
        spread: &Spread,
        t: &[f32],
        step: [f64; 2],
        at: impl Fn(i64, i64) -> Option<&'b [f32]>,
    ) -> f64 {
        let points = DVec2::from_array(self.grid.patch) / DVec2::from_array(step);
        let reach = spread.yy.sqrt() * CUT;
        let [first, last] = [((f.y - reach) * points.y).ceil(), ((f.y + reach) * points.y).floor()];
        let mut sum = 0.0;
        for row in first as i64..=last as i64 {
            let y = row as f64 / points.y - f.y;
            let Some([left, right]) = spread.row(y) else { continue };
            let columns = ((f.x + left) * points.x).ceil() as i64..=((f.x + right) * points.x).floor() as i64;
            let from = DVec2::new(*columns.start() as f64 / points.x - f.x, y);
            for (column, weight) in columns.zip(spread.densities(from, 1.0 / points.x)) {
                if let Some(series) = at(column, row) {
                    sum += weight * f64::from(dot(series, t));
                }
            }
        }
        (sum * step[0] * step[1]).max(0.0)
    }

    /// The series of an order.
    fn order(&self, x: i64, y: i64) -> Option<&[f32]> {
        let (row, column) = (self.place(y, 1)?, self.place(x, 0)?);
        let begin = (row * self.grid.size[0] + column) * self.terms;
        Some(&self.orders[begin..begin + self.terms])
    }

    fn make_levels(&self) -> Vec<PyramidLevel> {
        let line = |axis: usize| {
            let (size, origin) = (self.grid.size[axis], self.grid.origin[axis] as i64);
            let wraps = self.grid.periodic[axis];
            GridLine { first: if wraps { 0 } else { -origin }, size, wraps }
        };
        let grid = [line(0), line(1)];
        pyramid::levels(grid, self.terms, |x, y| self.order(x, y))
    }

    fn place(&self, m: i64, axis: usize) -> Option<usize> {
        let (size, origin) = (self.grid.size[axis] as i64, self.grid.origin[axis] as i64);
        let place = m + origin;
        if self.grid.periodic[axis] {
            return Some(place.rem_euclid(size) as usize);
        }
        (0..size).contains(&place).then_some(place as usize)
    }

    /// f cos θ_i \[sr⁻¹\] of one pair at `wavelength` \[µm\], averaged over `around`.
    pub fn cosine_weighted(&self, pair: &Pair, wavelength: f64, around: &Covariance) -> f64 {
        self.weighted(pair, wavelength, |uvw, q| self.power(uvw, q, around))
    }

    /// f cos θ_i \[sr⁻¹\] for the `power` at (u, v, w) and a wavenumber.
    fn weighted(&self, pair: &Pair, wavelength: f64, power: impl Fn(DVec3, f64) -> f64) -> f64 {
        if !pair.above_horizon() {
            return 0.0;
        }
        let reflectance = self.mean.reflectance.at(wavelength, pair.cos_half_angle());
        reflectance * cosine_weighted(pair, wavelength, 1.0, power(pair.uvw(), 1.0 / wavelength))
    }

    /// XYZ of f cos θ_i \[sr⁻¹\] of each pair under `illuminant`, averaged over the covariance beside it, by these `orders`.
    ///
    /// # Errors
    /// What `progress` returns.
    pub fn xyz(
        &self,
        illuminant: &Illuminant,
        pairs: &[(Pair, Covariance)],
        orders: SummedOrders,
        progress: Progress<'_>,
    ) -> Result<Vec<DVec3>> {
        const AT_ONCE: usize = 1024;
        let counts: Vec<usize> = pairs.iter().map(|(pair, around)| self.colour_nodes(pair, around)).collect();
        let distinct: std::collections::BTreeSet<usize> = counts.iter().copied().collect();
        let combs: BTreeMap<usize, Nodes> =
            distinct.into_par_iter().map(|n| (n, Nodes::catmull_rom(illuminant, n))).collect();
        let mut colours = Vec::with_capacity(pairs.len());
        for (pairs_now, counts_now) in pairs.chunks(AT_ONCE).zip(counts.chunks(AT_ONCE)) {
            progress(colours.len(), pairs.len())?;
            colours.par_extend(pairs_now.par_iter().zip(counts_now).map(|((pair, around), count)| {
                combs.get(count).map_or(DVec3::ZERO, |nodes| {
                    integral(nodes, |wavelength| match orders {
                        SummedOrders::All => self.cosine_weighted(pair, wavelength, around),
                        SummedOrders::Scattered => {
                            self.weighted(pair, wavelength, |uvw, q| self.scattered_power(uvw, q, around))
                        }
                    })
                })
            }));
        }
        progress(pairs.len(), pairs.len())?;
        Ok(colours)
    }

    /// XYZ of what the surface sends toward `view` of surroundings of radiance 1, by the specular order alone.
    pub fn mirrored(&self, illuminant: &Illuminant, views: &[DVec3]) -> Vec<DVec3> {
        let nodes = Nodes::catmull_rom(illuminant, COLOUR_NODES);
        let of = |view: &DVec3| {
            let pair = Pair::new(DVec3::new(-view.x, -view.y, view.z), *view);
            // The density of the lobe over (u, v) has the integral 1/q², and du dv = cos θ_i dω_i.
            let power = |uvw: DVec3, q: f64| self.specular_order(uvw, q) / (q * q);
            integral(&nodes, |wavelength| self.weighted(&pair, wavelength, power))
                / view.z.max(f64::MIN_POSITIVE)
        };
        views.par_iter().map(of).collect()
    }

    /// Wavelengths that resolve the response along the ray of `pair`, rounded up to a ladder of few counts.
    fn colour_nodes(&self, pair: &Pair, around: &Covariance) -> usize {
        /// Counts grow by this factor, so that few sets of weights serve all directions.
        const STEP: f64 = 1.1;
        let uv = pair.uvw().truncate();
        // Straight at the specular direction every wavelength reads the same place.
        let along = uv.try_normalize().unwrap_or(DVec2::X);
        let q = 1.0 / LONGEST;
        let spread = Spread::new(Blur::of_coherence(self.mean.sigma), around, q);
        let variance = spread.xx * along.x * along.x
            + 2.0 * spread.xy * along.x * along.y
            + spread.yy * along.y * along.y;
        // The correlation function of a blur of standard deviation b is exp(−2π²b²Δ²).
        let extent = (1.0 / ALIAS_LEVEL).ln().sqrt() / (PI * (2.0 * variance).sqrt());
        let count = COLOUR_NODES as f64 + SPAN * uv.length() * extent;
        STEP.powf((count.ln() / STEP.ln()).ceil()) as usize
    }

    /// The shortest wavelength that is held \[µm\].
    pub fn shortest(&self) -> f64 {
        4.0 * PI / self.z_max
    }
}

/// The mean as a [`Brdf`]: a direct sum for the first few single wavelengths, and the table of all orders once there are many, or for colours.
pub struct MeanReference<'a> {
    mean: MeanBrdf<'a>,
    illuminant: &'a Illuminant,
    shortest: f64,
    answered: usize,
    table: Option<TabulatedMean<'a>>,
    too_large: bool,
}

/// Direct sums that take as long as the table of all orders.
const WORTH_A_TABLE: usize = 24;

impl<'a> MeanReference<'a> {
    /// For wavelengths from `shortest` \[µm\], and colours under `illuminant`.
    pub fn new(mean: MeanBrdf<'a>, illuminant: &'a Illuminant, shortest: f64) -> Self {
        Self { mean, illuminant, shortest, answered: 0, table: None, too_large: false }
    }

    /// The table of all orders, made when it is first asked for.
    fn table(&mut self) -> Result<&TabulatedMean<'a>> {
        let table = match self.table.take() {
            Some(table) => table,
            None => TabulatedMean::new(self.mean.clone(), self.shortest, &|_, _| Ok(()))?,
        };
        Ok(self.table.insert(table))
    }
}

impl Brdf for MeanReference<'_> {
    fn spectral(&mut self, pairs: &[Pair], wavelength: f64) -> Result<Vec<f64>> {
        self.answered += pairs.len();
        if self.answered > WORTH_A_TABLE && !self.too_large {
            match self.table() {
                Ok(table) => {
                    let none = Covariance::default();
                    let one = |pair: &Pair| {
                        let weighted = table.cosine_weighted(pair, wavelength, &none);
                        without_cosine(pair, DVec3::splat(weighted)).x
                    };
                    return Ok(pairs.par_iter().map(one).collect());
                }
                // The direct sum needs no room.
                Err(_) => self.too_large = true,
            }
        }
        Ok(pairs.iter().map(|pair| self.mean.brdf(pair, wavelength)).collect())
    }

    fn xyz(&mut self, pairs: &[Pair]) -> Result<Vec<DVec3>> {
        let illuminant = self.illuminant;
        let asked: Vec<_> = pairs.iter().map(|pair| (*pair, Covariance::default())).collect();
        let weighted = self.table()?.xyz(illuminant, &asked, SummedOrders::All, &|_, _| Ok(()))?;
        Ok(pairs.iter().zip(weighted).map(|(pair, f)| without_cosine(pair, f)).collect())
    }

    fn batch(&self) -> usize {
        if self.table.is_some() { 4096 } else { WORTH_A_TABLE }
    }
}

/// Σ of `of` over the wavelengths of `nodes`.
fn integral(nodes: &Nodes, of: impl Fn(f64) -> f64) -> DVec3 {
    let wavelength = |j: usize| 1.0 / (nodes.first + j as f64 * nodes.step);
    nodes.weights.iter().enumerate().map(|(j, weight)| *weight * of(wavelength(j))).sum()
}

/// Σ a b in eight partial sums, so that the loop runs on vector registers.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0f32; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f32 = a8.remainder().iter().zip(b8.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a8.zip(b8) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f32>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::coherence::Coherence;
    use crate::optics::geometry::direction;
    use crate::optics::reference::Reference;
    use crate::surface::synth::{self, Spec, SurfaceKind};

    fn rough() -> HeightField {
        let heights = (0..24 * 20).map(|i| 0.15 * ((i * 37 % 101) as f64 * 0.7).sin()).collect();
        HeightField::new(24, 20, [0.1, 0.11], heights).unwrap()
    }

    const DIRECTIONS: [((f64, f64), (f64, f64)); 4] = [
        ((30.0, 20.0), (40.0, 170.0)),
        ((10.0, 0.0), (70.0, 80.0)),
        ((60.0, 5.0), (60.0, 185.0)),
        ((30.0, 0.0), (31.0, 179.0)),
    ];

    fn pair((light, view): ((f64, f64), (f64, f64))) -> Pair {
        Pair::new(direction(light.0, light.1), direction(view.0, view.1))
    }

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
        // Of samples 0.25 µm apart the orders wrap around, and may be odd in number.
        for field in [elaphe(0.1), elaphe(0.25), rough(48, 34), rough(49, 33)] {
            let name = (field.columns(), field.rows());
            let mean = MeanBrdf::in_sunlight(&field, 1.5);
            let table = TabulatedMean::new(mean, 0.38, &|_, _| Ok(())).unwrap();
            for (uu, uv, vv) in [(0.02, 0.0, 0.02), (0.2, 0.05, 0.03), (0.3, -0.1, 0.3), (1e-3, 0.0, 0.2)] {
                let around = Covariance { uu, uv, vv };
                for (uvw, q) in [(DVec3::new(0.1, -0.2, -1.8), 2.2), (DVec3::new(-0.9, 0.6, -1.0), 1.5)] {
                    let spread = Spread::new(table.mean.blur(), &around, q);
                    let z = 2.0 * PI * q * uvw.z.abs();
                    let t: Vec<f32> = table.polynomials_at(z).into_iter().map(|t| t as f32).collect();
                    let f = -uvw.truncate() * q;
                    let all = table.sum(f, &spread, &t, [1.0; 2], |x, y| table.order(x, y));
                    let some = table.blurred(f, &spread, &t);
                    assert!((some / all - 1.0).abs() < 1e-5, "{name:?}, {around:?}: {some} of {all}");
                }
            }
            let coarser = table.levels.get().map_or(0, Vec::len);
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
                let mean = MeanBrdf { field: &field, sigma: 2.0, beyond, reflectance: 1.5.into() };
                let table = TabulatedMean::new(mean.clone(), 0.38, &|_, _| Ok(())).unwrap();
                for around in [Covariance::default(), Covariance { uu: 4e-4, uv: 1e-4, vv: 1e-3 }] {
                    for directions in DIRECTIONS {
                        for wavelength in [0.4, 0.55, 0.7] {
                            let uvw = pair(directions).uvw();
                            let direct = mean.power(uvw, 1.0 / wavelength, &around);
                            let fast = table.power(uvw, 1.0 / wavelength, &around);
                            // Relative to the mean density of power, 1 over the band, where the value itself is fainter.
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
    fn the_mean_does_not_depend_on_where_the_patch_begins() {
        let field = rough();
        let moved = field.moved(7, 3);
        let of = |field| {
            let mean = MeanBrdf { field, sigma: 0.75, beyond: Beyond::Copies, reflectance: 1.5.into() };
            DIRECTIONS.map(|d| mean.brdf(&pair(d), 0.5))
        };
        for (a, b) in of(&field).into_iter().zip(of(&moved)) {
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn a_footprint_is_the_average_over_its_directions() {
        let field = rough();
        let mean = MeanBrdf { field: &field, sigma: 1.0, beyond: Beyond::Copies, reflectance: 1.5.into() };
        let around = Covariance { uu: 9e-4, uv: 2e-4, vv: 4e-4 };
        let uvw = DVec3::new(0.3, -0.2, -1.6);
        // A grid of directions with the weights of the normal distribution.
        let (det, mut sum, mut norm) = (around.uu * around.vv - around.uv * around.uv, 0.0, 0.0);
        for i in -40..=40 {
            for j in -40..=40 {
                let d = DVec2::new(f64::from(i) * 0.004, f64::from(j) * 0.003);
                let r2 = (around.vv * d.x * d.x - 2.0 * around.uv * d.x * d.y + around.uu * d.y * d.y) / det;
                let weight = (-0.5 * r2).exp();
                norm += weight;
                sum += weight * mean.power(uvw + d.extend(0.0), 2.0, &Covariance::default());
            }
        }
        let blurred = mean.power(uvw, 2.0, &around);
        assert!((sum / norm / blurred - 1.0).abs() < 1e-4, "{} {blurred}", sum / norm);
    }

    #[test]
    fn the_mean_over_all_windows_is_what_many_windows_tend_to() {
        let field = rough();
        let coherence = Coherence::Gaussian { length: 3.0 };
        let mean = MeanBrdf { field: &field, sigma: 0.75, beyond: Beyond::Copies, reflectance: 1.5.into() };
        for directions in DIRECTIONS {
            let pair = pair(directions);
            let exact = mean.brdf(&pair, 0.55);
            let error = |n: u32| {
                let windows = Reference::new(&field, coherence, [n, n], 1.5).brdf(&pair, 0.55);
                (windows / exact - 1.0).abs()
            };
            let errors = [1, 2, 4, 8].map(error);
            // The windows are cut at 7σ, 2e-11 of their peak, and orders at 1e-10 of theirs.
            assert!(errors[3] < 1e-8, "{directions:?}: {errors:?}");
            assert!(errors[0] > 1e-3, "one window already gives the mean: {errors:?}");
        }
    }
}
