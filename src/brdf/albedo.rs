//! Directional albedo of a surface from its orders, and the limit of energy that follows from it ([`crate::optics::energy`]).

use crate::error::Result;
use crate::optics::colour_excess::ColourWeights;
use crate::optics::energy::{DirectionGrid, EnergyLimit};
use crate::optics::geometry::Pair;
use crate::optics::polarisation::Polarisation;
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::Illuminant;
use crate::spectra::power::OrderSeries;
use crate::task::Task;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Name of the work in reports of progress.
const ENERGY: &str = "energy";

/// Number of orders whose series are summed together: a recurrence waits for its last step, and those of other orders fill the wait.
/// An export of *Elaphe* in gold takes 0.67 of the processor time that it takes with one order at once and roots by polar coordinates.
const BLOCK: usize = 8;

/// Largest number of directions that are kept, in some 20 MB. A sweep of *Elaphe* through 16 windows, over 31 wavelengths and 301 angles, takes a
/// quarter of the processor time that it takes without (45 s instead of about 185, from the time of one window).
const MOST_KEPT: usize = 1 << 18;

/// Orders of a surface, or groups of neighbouring ones, with their powers as series in z, and the reflectance of the surface.
pub struct DirectionalAlbedo {
    reflectance: Reflectance,
    z_max: f64,
    specular: Vec<f64>,
    terms: usize,
    // (m/T_x, n/T_y) of ω_i + ω_r over the wavelength [µm⁻¹].
    frequencies: Vec<DVec2>,
    // [block of orders][term][order of the block], powers |c_m|²/z²; 0 behind the last order.
    coefficients: Vec<[f32; BLOCK]>,
    // Larger groups of the same orders, from which the table is made.
    coarse: Option<Box<Self>>,
    table: OnceLock<ExcessTable>,
    // E/R by the bits of direction and wavelength, up to MOST_KEPT.
    kept: Mutex<HashMap<[u64; 4], f64>>,
}

impl std::fmt::Debug for DirectionalAlbedo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "DirectionalAlbedo of {} orders", self.frequencies.len())
    }
}

/// Groups of neighbouring orders that are summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimation {
    /// Groups 0.06 wide in u for the shortest wavelength: some thousand in all, for maps over directions. Surfaces of
    /// few orders keep each.
    Coarse,
    /// Groups 0.015 wide, for single directions. Patches of up to 25 µm keep each order.
    Fine,
}

impl Decimation {
    /// Returns the number of groups along each axis of the square of all visible frequencies, −2/λ to 2/λ of the
    /// shortest wavelength λ.
    fn groups(self) -> f64 {
        match self {
            Self::Coarse => 64.0,
            Self::Fine => 256.0,
        }
    }
}

impl DirectionalAlbedo {
    /// Sums neighbouring orders of `series` into groups, each at the mean frequency of its power.
    pub fn new(series: &OrderSeries, reflectance: &Reflectance, decimation: Decimation) -> Self {
        // λ = 4π/z_max.
        let sizes = |decimation: Decimation| {
            let width = series.z_max / PI / decimation.groups();
            series.grid.patch.map(|side| ((width * side) as i64).max(1))
        };
        let [fine, coarse] = [decimation, Decimation::Coarse].map(sizes);
        let coarse = (coarse != fine).then(|| Box::new(Self::grouped(series, reflectance, coarse)));
        Self { coarse, ..Self::grouped(series, reflectance, fine) }
    }

    /// Returns the divisor of the BRDF for each of `pairs` at `wavelength` \[µm\]. Each direction is summed once, in parallel, and kept
    /// for further windows of the surface, which are asked for the same directions.
    pub fn limits(&self, pairs: &[Pair], wavelength: f64) -> Vec<f64> {
        let key = |DVec3 { x, y, z }| [x, y, z, wavelength].map(f64::to_bits);
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let mut excess: HashMap<_, _> = {
            let kept = kept();
            let directions = pairs.iter().flat_map(|pair| [pair.light, pair.view]);
            directions.map(|d| (key(d), (d, kept.get(&key(d)).copied()))).collect()
        };
        excess.par_iter_mut().for_each(|(_, (direction, excess))| {
            excess.get_or_insert_with(|| self.excess(*direction, wavelength));
        });
        // Each direction is in the map.
        let of = |direction| excess.get(&key(direction)).and_then(|(_, excess)| *excess).unwrap_or(0.0);
        let limits = pairs.iter().map(|pair| of(pair.light).max(of(pair.view)).max(1.0)).collect();
        let mut kept = kept();
        let room = MOST_KEPT.saturating_sub(kept.len());
        kept.extend(excess.iter().filter_map(|(key, (_, excess))| Some((*key, (*excess)?))).take(room));
        limits
    }

    /// Sums orders into groups of `sizes` along each axis.
    fn grouped(series: &OrderSeries, reflectance: &Reflectance, sizes: [i64; 2]) -> Self {
        let terms = series.terms;
        let [columns, rows] = series.grid.size;
        let patch = DVec2::from_array(series.grid.patch);
        let group = |place: usize, axis: usize| {
            (place as i64 - series.grid.origin[axis] as i64).div_euclid(sizes[axis])
        };
        let first = [0, 1].map(|axis| group(0, axis));
        let counts = [group(columns - 1, 0) - first[0] + 1, group(rows - 1, 1) - first[1] + 1];
        let count = (counts[0] * counts[1]) as usize;
        let (mut sums, mut centres, mut weights) =
            (vec![0f32; count * terms], vec![DVec2::ZERO; count], vec![0.0; count]);
        for (number, order) in series.coefficients().chunks_exact(terms).enumerate() {
            let place = [number % columns, number / columns];
            let at = ((group(place[1], 1) - first[1]) * counts[0] + group(place[0], 0) - first[0]) as usize;
            // The first term is the mean over z.
            let weight = f64::from(order[0].max(0.0));
            let numbers = [0, 1].map(|axis| place[axis] as f64 - series.grid.origin[axis] as f64);
            centres[at] += weight * DVec2::from_array(numbers) / patch;
            weights[at] += weight;
            sums[at * terms..][..terms].iter_mut().zip(order).for_each(|(sum, a)| *sum += a);
        }
        let lit: Vec<usize> = (0..count).filter(|at| weights[*at] > 0.0).collect();
        let block_of = |orders: &[usize], term: usize| {
            std::array::from_fn(|lane| orders.get(lane).map_or(0.0, |at| sums[at * terms + term]))
        };
        let blocks = lit.chunks(BLOCK).flat_map(|orders| (0..terms).map(move |term| (orders, term)));
        Self {
            reflectance: reflectance.clone().polarised(Polarisation::None),
            z_max: series.z_max,
            specular: series.specular.clone(),
            terms,
            frequencies: lit.iter().map(|at| centres[*at] / weights[*at]).collect(),
            coefficients: blocks.map(|(orders, term)| block_of(orders, term)).collect(),
            coarse: None,
            table: OnceLock::new(),
            kept: Mutex::default(),
        }
    }

    /// Returns the largest reflectance that a surface may have for light from `direction` at `wavelength` \[µm\]: that
    /// of a flat one, or 1 below a film, whose own reflectance may vanish.
    pub fn allowed(&self, direction: DVec3, wavelength: f64) -> f64 {
        match &self.reflectance {
            Reflectance::Fresnel { film: Some(_), .. } => 1.0,
            _ => self.reflectance.at(wavelength, direction.z),
        }
    }

    /// Returns E, the share of the light from `light` at `wavelength` \[µm\] that is sent into all directions,
    /// unpolarised and without a limit.
    pub fn at(&self, light: DVec3, wavelength: f64) -> f64 {
        self.sent(light, wavelength, |_| 1.0)
    }

    /// Returns the share of the light from `light` at `wavelength` \[µm\] that is sent into all directions, each of
    /// which counts by `weight`.
    pub fn sent(&self, light: DVec3, wavelength: f64, weight: impl Fn(DVec3) -> f64) -> f64 {
        if light.z <= 0.0 {
            return 0.0;
        }
        let k = TAU / wavelength;
        let factor = self.reflectance.factor(light, wavelength);
        let (w, mirror) = (2.0 * light.z, DVec3::new(-light.x, -light.y, light.z));
        let specular =
            weight(mirror) * factor.toward(mirror) / (light.z * w * w) * self.specular_series(k * w).max(0.0);
        let mut scattered = 0.0;
        for (frequencies, coefficients) in
            self.frequencies.chunks(BLOCK).zip(self.coefficients.chunks_exact(self.terms))
        {
            // At the horizon, 0, where there is no order.
            let (mut views, mut z) = ([DVec3::ZERO; BLOCK], [0.0; BLOCK]);
            let mut is_seen = false;
            for (lane, frequency) in frequencies.iter().enumerate() {
                let across = wavelength * *frequency - light.truncate();
                let squared = across.length_squared();
                if squared < 1.0 {
                    views[lane] = across.extend((1.0 - squared).sqrt());
                    is_seen = true;
                }
                z[lane] = k * (light.z + views[lane].z);
            }
            if !is_seen {
                continue;
            }
            let powers = self.series(coefficients, z);
            for lane in (0..BLOCK).filter(|lane| views[*lane].z > 0.0) {
                scattered += weight(views[lane]) * factor.toward(views[lane]) * powers[lane].max(0.0);
            }
        }
        specular + scattered * k * k / light.z
    }

    /// Returns the argument of the Chebyshev polynomials for `z`.
    fn argument(&self, z: f64) -> f64 {
        (2.0 * z / self.z_max - 1.0).min(1.0)
    }

    /// Returns the sum of Chebyshev polynomials with the coefficients of the specular order at `z`, by Clenshaw's recurrence.
    fn specular_series(&self, z: f64) -> f64 {
        let x = self.argument(z);
        let Some((first, rest)) = self.specular.split_first() else { return 0.0 };
        let (mut b1, mut b2) = (0.0, 0.0);
        for a in rest.iter().rev() {
            (b1, b2) = (a + 2.0 * x * b1 - b2, b1);
        }
        first + x * b1 - b2
    }

    /// Returns the sums of Chebyshev polynomials with the coefficients of a block of orders at `z`, as [`Self::specular_series`].
    fn series(&self, coefficients: &[[f32; BLOCK]], z: [f64; BLOCK]) -> [f64; BLOCK] {
        let Some((first, rest)) = coefficients.split_first() else { return [0.0; BLOCK] };
        let mut x = [0.0; BLOCK];
        for lane in 0..BLOCK {
            x[lane] = self.argument(z[lane]);
        }
        let (mut b1, mut b2) = ([0.0; BLOCK], [0.0; BLOCK]);
        for a in rest.iter().rev() {
            for lane in 0..BLOCK {
                let sum = f64::from(a[lane]) + 2.0 * x[lane] * b1[lane] - b2[lane];
                (b2[lane], b1[lane]) = (b1[lane], sum);
            }
        }
        let mut sums = [0.0; BLOCK];
        for lane in 0..BLOCK {
            sums[lane] = f64::from(first[lane]) + x[lane] * b1[lane] - b2[lane];
        }
        sums
    }

    /// Returns the table of E and R over directions and visible wavelengths, made on first use.
    pub fn table(&self) -> &ExcessTable {
        let coarse = self.coarse.as_deref().unwrap_or(self);
        self.table.get_or_init(|| {
            let layers = (0..ColourWeights::WAVENUMBERS).map(|number| ExcessTable::layer(coarse, number));
            ExcessTable { layers: layers.collect() }
        })
    }

    /// Makes the [`Self::table`] if there is none yet; `task` is told of each layer.
    ///
    /// # Errors
    /// Fails if the task is cancelled.
    pub fn make_table(&self, task: &Task) -> Result<()> {
        if self.table.get().is_some() {
            return Ok(());
        }
        let coarse = self.coarse.as_deref().unwrap_or(self);
        let mut layers = Vec::with_capacity(ColourWeights::WAVENUMBERS);
        for layer in 0..ColourWeights::WAVENUMBERS {
            task.report(ENERGY, layer, ColourWeights::WAVENUMBERS)?;
            layers.push(ExcessTable::layer(coarse, layer));
        }
        task.report(ENERGY, layers.len(), layers.len())?;
        // Another thread may have made the same table in the meantime.
        self.table.get_or_init(|| ExcessTable { layers });
        Ok(())
    }

    /// Returns E/R for light from `direction` at `wavelength` \[µm\].
    pub fn excess(&self, direction: DVec3, wavelength: f64) -> f64 {
        if direction.z <= 0.0 {
            return 0.0;
        }
        /// Reflectances below this one count as this one: a surface of the index of air has none, and no light to limit.
        const LEAST: f64 = 1e-12;
        self.at(direction, wavelength) / self.allowed(direction, wavelength).max(LEAST)
    }
}

impl EnergyLimit for DirectionalAlbedo {
    fn single(&self, pair: &Pair, wavelength: f64) -> f64 {
        self.excess(pair.light, wavelength).max(self.excess(pair.view, wavelength)).max(1.0)
    }

    fn colour(&self, pair: &Pair, illuminant: &Illuminant) -> f64 {
        let weights = ColourWeights::new(illuminant);
        let excess = |direction: DVec3| {
            weights.excess(|layer| {
                let wavelength = ColourWeights::wavelength(layer);
                [self.at(direction, wavelength), self.allowed(direction, wavelength)]
            })
        };
        excess(pair.light).max(excess(pair.view)).max(1.0)
    }
}

/// E and the largest allowed reflectance at the points of a [`DirectionGrid`], for the wavelengths of [`ColourWeights`].
#[derive(Clone, Debug, PartialEq)]
pub struct ExcessTable {
    /// `[wavenumber][point]`: E and the allowed reflectance.
    layers: Vec<Vec<[f64; 2]>>,
}

impl ExcessTable {
    /// Returns E and the allowed reflectance of `albedo` at every point for wavenumber `number`.
    fn layer(albedo: &DirectionalAlbedo, number: usize) -> Vec<[f64; 2]> {
        let wavelength = ColourWeights::wavelength(number);
        let point = |point: usize| {
            if !DirectionGrid::is_read(point) {
                return [0.0, 1.0];
            }
            let direction = DirectionGrid::direction(point);
            [albedo.at(direction, wavelength), albedo.allowed(direction, wavelength)]
        };
        (0..DirectionGrid::COUNT).into_par_iter().map(point).collect()
    }

    /// Returns E and the allowed reflectance of a layer at a point.
    pub fn of_layer(&self, layer: usize, point: usize) -> [f64; 2] {
        self.layers[layer][point]
    }
}
