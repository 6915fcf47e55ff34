//! Orders of a periodic surface: their directions, and the shares of the light that they take.

use super::albedo::{Decimation, DirectionalAlbedo};
use super::mean::MeanBrdf;
use super::tabulated::TabulatedMean;
use crate::error::Result;
use crate::optics::geometry::Pair;
use crate::optics::theory::Theory;
use crate::spectra::power::Beyond;
use crate::surface::HeightField;
use crate::task::{ORDERS, Task};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Order of a periodic surface that propagates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffractionOrder {
    /// m and n: (u, v) = (m λ/T_x, n λ/T_y).
    pub numbers: [i64; 2],
    /// ω_r, away from the surface.
    pub view: DVec3,
    /// Share of the incident light, ∫ f cos θ_r dω_r over the order, 0 to about 1.
    pub efficiency: f64,
    /// Reflectance with which Kirchhoff's factor has this efficiency: R at the half vector by Stam's theory.
    pub reflectance: f64,
    /// Divisor by which the limit of energy made the order fainter; 1 where there is none.
    pub limit: f64,
    /// Period of the grating whose first order this is \[µm\]; `None` for the specular order.
    pub period: Option<f64>,
}

impl MeanBrdf {
    /// Returns the orders of copies of the patch that light from `light` = ω_i at `wavelength` \[µm\] sends above the horizon, by n and then by
    /// m. Those that the samples do not resolve are left out; there are none for light below the horizon.
    ///
    /// Each takes F/(w² cos θ_i) · |c_m(k|w|)|² of the light, with the [`Factor`](crate::optics::factor::Factor) F, which is R G cos θ_i by B.13 \[Single 2014\]: ⟨|P|²⟩/A of
    /// [`crate::spectra::power`] holds the power |c_m|² around the order, and du dv = cos θ_r dω_r. Few orders are summed directly, many are read from their series in z. The limit of
    /// energy of the theory, if it has one, is applied to each.
    ///
    /// # Errors
    /// Too little memory for the series; a cancelled task.
    pub fn orders(&self, light: DVec3, wavelength: f64, task: &Task) -> Result<Vec<DiffractionOrder>> {
        let of_copies = Self { beyond: Beyond::Copies, ..self.clone() };
        let asked = propagating(&self.field, light, wavelength);
        // A sum takes about as long as a term of the series.
        let is_many = asked.len() > TabulatedMean::terms(&self.field, wavelength);
        let series = (is_many || self.reflectance.is_limited())
            .then(|| TabulatedMean::new(of_copies.clone(), wavelength, task))
            .transpose()?;
        let limits = self.limits(&asked, series.as_ref(), wavelength);
        let order = |(i, &(numbers, pair)): (usize, &([i64; 2], Pair))| {
            // Powers stand at the frequencies of ω_i + ω_r = −(u, v).
            let (opposite, z) = (numbers.map(|m| -m), TAU / wavelength * pair.uvw().z.abs());
            let power = match &series {
                Some(series) if is_many => series.order_power(opposite, z),
                _ => {
                    task.report(ORDERS, i, asked.len())?;
                    of_copies.order_power(opposite, z)
                }
            };
            Ok(self.order(numbers, &pair, wavelength, power, limits.get(i).copied().unwrap_or(1.0)))
        };
        asked.iter().enumerate().map(order).collect()
    }

    /// Returns the divisors of the orders in the directions `asked`; none without a limit.
    fn limits(
        &self,
        asked: &[([i64; 2], Pair)],
        series: Option<&TabulatedMean>,
        wavelength: f64,
    ) -> Vec<f64> {
        let pairs: Vec<Pair> = asked.iter().map(|(_, pair)| *pair).collect();
        let albedo = |series: &TabulatedMean| -> DirectionalAlbedo {
            // Each order is a direction: of many, the sum is over groups.
            series.albedo(if pairs.len() > MANY { Decimation::Coarse } else { Decimation::Fine })
        };
        let limited = series.filter(|_| self.reflectance.is_limited());
        limited.map_or_else(Vec::new, |series| albedo(series).limits(&pairs, wavelength))
    }

    /// Returns the order `numbers` in the directions `pair`, of power |c_m|² = `power`, divided by `limit`.
    fn order(
        &self,
        numbers: [i64; 2],
        pair: &Pair,
        wavelength: f64,
        power: f64,
        limit: f64,
    ) -> DiffractionOrder {
        // ∫ du dv over the density of an order in f = (u, v)/λ is λ².
        let in_order = power * wavelength.powi(2);
        let weighted = self.reflectance.cosine_weighted(pair, wavelength, 1.0, in_order);
        let factor = self.reflectance.factor(pair.light, wavelength).toward(pair.view);
        let frequency = frequency(&self.field, numbers).length();
        DiffractionOrder {
            numbers,
            view: pair.view,
            efficiency: weighted / pair.light.z / limit,
            reflectance: match self.reflectance.theory() {
                Theory::Stam => self.reflectance.at(wavelength, pair.cos_half_angle()),
                Theory::SmallSlope => factor / pair.geometric_factor_times_cos_light(),
            },
            limit,
            period: (frequency > 0.0).then(|| 1.0 / frequency),
        }
    }
}

/// Number of orders above which the limit of each is summed over groups of orders.
const MANY: usize = 2000;

/// Returns (m/T_x, n/T_y) \[µm⁻¹\].
fn frequency(field: &HeightField, numbers: [i64; 2]) -> DVec2 {
    let [m, n] = numbers.map(|m| m as f64);
    DVec2::new(m, n) / DVec2::from_array(field.patch_size())
}

/// Returns numbers and directions of the orders above the horizon that the samples resolve, and not only their alias.
fn propagating(field: &HeightField, light: DVec3, wavelength: f64) -> Vec<([i64; 2], Pair)> {
    let patch = field.patch_size();
    let band = field.pixel_size().map(|spacing| 0.5 / spacing);
    let range = |axis: usize| {
        let end = |of: f64| (of - light[axis]) * patch[axis] / wavelength;
        end(-1.0).ceil() as i64..=end(1.0).floor() as i64
    };
    let order = |numbers: [i64; 2]| {
        let f = frequency(field, numbers);
        let tangential = -light.truncate() - wavelength * f;
        let normal = (1.0 - tangential.length_squared()).max(0.0).sqrt();
        let pair = Pair::new(light, tangential.extend(normal));
        let is_resolved = f.x.abs() < band[0] && f.y.abs() < band[1];
        (is_resolved && pair.above_horizon()).then_some((numbers, pair))
    };
    range(1).flat_map(|n| range(0).map(move |m| [m, n])).filter_map(order).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::Covariance;
    use crate::optics::geometry::direction;

    const GREEN: f64 = 0.55;

    fn orders(field: &HeightField, light: DVec3) -> Vec<DiffractionOrder> {
        mean(field).orders(light, GREEN, &Task::silent()).unwrap()
    }

    fn mean(field: &HeightField) -> MeanBrdf {
        MeanBrdf { field: field.clone(), sigma: 40.0, beyond: Beyond::Copies, reflectance: 1.5.into() }
    }

    #[test]
    fn efficiencies_are_integrals_of_the_direct_sum_over_the_orders() {
        let heights = (0..24 * 20).map(|i| 0.15 * ((i * 37 % 101) as f64 * 0.7).sin()).collect();
        let field = HeightField::new(24, 20, [0.11, 0.12], heights).unwrap();
        let light = direction(25.0, 70.0);
        let brdf = mean(&field);
        // Orders are Gaussians e^(−(kσ)²(u² + v²)), which steps of 0.8/(kσ) sum to 2e-7.
        let step = 0.8 * GREEN / (2.0 * std::f64::consts::PI * brdf.sigma);
        let found = orders(&field, light);
        assert!(found.len() > 60, "{}", found.len());
        let mut tested = Vec::new();
        for order in found.iter().filter(|order| order.view.z > 0.5).step_by(7) {
            let at = |i: i32, j: i32| {
                let xy = order.view.truncate() + DVec2::new(f64::from(i), f64::from(j)) * step;
                let view = xy.extend((1.0 - xy.length_squared()).sqrt());
                brdf.brdf(&Pair::new(light, view), GREEN, &Covariance::default())
            };
            let sum: f64 = (-6..=6).flat_map(|j| (-6..=6).map(move |i| (i, j))).map(|(i, j)| at(i, j)).sum();
            let share = sum * step * step;
            // G/w² and R bend over the order by less than (width/cos θ_r)².
            let off = (order.efficiency / share - 1.0).abs();
            assert!(off < 1e-4, "{:?}: {} {share}", order.numbers, order.efficiency);
            tested.push(order.efficiency);
        }
        assert!(tested.len() > 5 && tested.iter().any(|share| *share > 1e-4), "{tested:?}");
    }

    #[test]
    fn many_orders_are_read_from_series_and_few_are_summed() {
        let heights = |n: usize| (0..n * n).map(|i| 0.15 * ((i * 37 % 101) as f64 * 0.7).sin()).collect();
        let [few, many] = [6, 30].map(|n| HeightField::new(n, n, [0.12; 2], heights(n)).unwrap());
        let light = direction(25.0, 70.0);
        assert!(orders(&few, light).len() < TabulatedMean::terms(&few, GREEN));
        let read = orders(&many, light);
        assert!(read.len() > TabulatedMean::terms(&many, GREEN));
        let brightest = read.iter().map(|order| order.efficiency).fold(0.0, f64::max);
        for order in read.iter().step_by(10) {
            let pair = Pair::new(light, order.view);
            let z = TAU / GREEN * pair.uvw().z.abs();
            let power = mean(&many).order_power(order.numbers.map(|m| -m), z);
            let summed = mean(&many).order(order.numbers, &pair, GREEN, power, order.limit).efficiency;
            let off = (order.efficiency - summed).abs();
            assert!(off < 1e-6 * summed + 1e-9 * brightest, "{:?}: {off:e} of {summed:e}", order.numbers);
        }
    }

    #[test]
    fn a_mirror_has_one_order_with_all_that_it_reflects_and_light_from_below_none() {
        let field = HeightField::new(40, 40, [0.1; 2], vec![0.0; 1600]).unwrap();
        let light = direction(60.0, 200.0);
        let found = orders(&field, light);
        let lit: Vec<_> = found.iter().filter(|order| order.efficiency > 0.0).collect();
        assert_eq!(lit.len(), 1);
        assert_eq!((lit[0].numbers, lit[0].period), ([0, 0], None));
        assert!((lit[0].efficiency / lit[0].reflectance - 1.0).abs() < 1e-12);
        assert!((lit[0].view - direction(60.0, 20.0)).length() < 1e-12);
        assert!(orders(&field, direction(90.0, 0.0)).is_empty());
        assert!(orders(&field, direction(120.0, 0.0)).is_empty());
    }

    #[test]
    fn orders_beyond_the_frequencies_of_the_samples_are_left_out() {
        let field = HeightField::new(8, 1, [0.5, 0.5], vec![0.0; 8]).unwrap();
        let found = orders(&field, DVec3::Z);
        // Samples 0.5 µm apart hold |f| below 1/µm: |m| < 4 of a patch of 4 µm, of the seven on each side that propagate.
        let numbers: Vec<_> = found.iter().map(|order| order.numbers).collect();
        assert_eq!(numbers, (-3..=3).map(|m| [m, 0]).collect::<Vec<_>>());
        assert!((found[0].period.unwrap() - 4.0 / 3.0).abs() < 1e-12);
    }
}
