//! The power of every order over z², as a Chebyshev series in z.

use super::chebyshev::{ChebyshevTransform, nodes, polynomials};
use super::orders::{OrderGrid, OrderPowers, Transform};
use super::{Beyond, Blur};
use crate::budget::ErrorBudget;
use crate::error::{Error, Remedy, Result};
use crate::memory;
use crate::optics::spectrum::SHORTEST;
use crate::sums;
use crate::surface::HeightField;
use crate::task::{ORDERS, Progress, Task};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::{PI, SQRT_2};

/// Light and accuracy that series are made for. These and the height field are part of the key of a colour table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PowerSettings {
    /// Standard deviation of the coherence window \[µm\], a quarter of the coherence length.
    pub sigma: f64,
    /// Continuation of the surface beyond the patch.
    pub beyond: Beyond,
    /// Shortest wavelength \[µm\].
    pub shortest: f64,
    /// Allowed relative error of the power between the nodes in z, RMS over the brightest orders.
    pub error: f64,
}

impl PowerSettings {
    /// Returns settings for all visible light through a coherence window of standard deviation `sigma` \[µm\], with a relative
    /// error of `tolerance` of single directions.
    pub fn new(sigma: f64, beyond: Beyond, tolerance: f64) -> Self {
        Self { sigma, beyond, shortest: SHORTEST, error: ErrorBudget::of_directions(tolerance).mean.series }
    }

    fn z_max(&self) -> f64 {
        4.0 * PI / self.shortest
    }
}

/// Powers |c_m(z)|²/z² \[µm²/rad²\] of a surface's orders, as series Σ a_k T_k(2z/z_max − 1). 32-bit floats leave 6e-8 of each.
pub struct OrderSeries {
    /// Orders that are held.
    pub grid: OrderGrid,
    /// Number of terms in z, a multiple of [`TERMS_AT_ONCE`].
    pub terms: usize,
    /// Largest z \[rad/µm\].
    pub z_max: f64,
    /// Coefficients of the specular order's power |c_0|² over the same range.
    pub specular: Vec<f64>,
    /// Standard deviation of the coherence window \[µm\].
    pub sigma: f64,
    /// Blur of the orders by the coherence of the light and the lag window.
    pub blur: Blur,
    /// Largest |f_x|, |f_y| that the samples hold \[µm⁻¹\].
    pub band: [f64; 2],
    /// Relative error between the nodes in z, measured on the surface; 0 without an audit.
    pub error: f64,
    // [row][column][term], without the specular order.
    coefficients: Vec<f32>,
}

/// Terms that vector registers take together.
pub const TERMS_AT_ONCE: usize = 4;
/// Largest number of terms, sufficient for heights of about 6 µm.
const MOST_TERMS: usize = 128;
/// z between the nodes at which the audit compares series with transforms, as shares of the range. Both ends are among them.
const AUDITED: [f64; 4] = [0.03, 0.35, 0.7, 0.997];
/// Share of the orders, the brightest ones, that the audit judges.
const JUDGED_SHARE: f64 = 0.1;
/// Power of an order over that of the brightest scattered one below which the audit does not judge it: 32-bit floats hold an order relative to its largest power
/// over z, and faint orders of small z are far below that.
const JUDGED_POWER: f64 = 1e-5;
/// Standard deviations of the blur that are held beyond the visible frequencies: e^(−8) of an order reaches farther.
const GUARD: f64 = 4.0;

/// Lower bound of the size of a surface's series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Estimate {
    /// Terms in z.
    pub terms: usize,
    /// Orders along x and y.
    pub orders: [usize; 2],
    /// Bytes.
    pub bytes: usize,
}

impl OrderSeries {
    /// Computes the series of `field` with as many terms as the error of `settings` asks for.
    ///
    /// # Errors
    /// Too little memory; a surface too high for any number of terms; a cancelled task.
    pub fn new(field: &HeightField, settings: &PowerSettings, task: &Task) -> Result<Self> {
        Self::check_heights(field, settings)?;
        let z_max = settings.z_max();
        let transform = Transform::new(field, order_grid(field, settings), settings.beyond);
        transform.ensure_room()?;
        let mut terms = first_terms(field, z_max);
        let audited = AUDITED.map(|share| share * z_max);
        let mut exact: Vec<OrderPowers> = Vec::with_capacity(AUDITED.len());
        loop {
            let series_alone = task.part(|progress| Progress { of: progress.of + AUDITED.len(), ..progress });
            let mut series = Self::with_terms(&transform, settings, terms, &series_alone)?;
            for z in audited.iter().skip(exact.len()) {
                task.report(ORDERS, terms + exact.len(), terms + AUDITED.len())?;
                exact.push(transform.at(*z));
            }
            let errors = audited.iter().zip(&exact).map(|(z, exact)| series.error_at(*z, exact));
            series.error = errors.fold(0.0, f64::max);
            if series.error <= settings.error {
                task.report(ORDERS, 1, 1)?;
                return Ok(series);
            }
            if terms == MOST_TERMS {
                return Err(Error::limit(
                    format!(
                        "{terms} terms in z leave a relative error of {:.1e} on this surface",
                        series.error
                    ),
                    [Remedy::TimesTolerance(series.error / settings.error), Remedy::ReferenceMethod],
                ));
            }
            terms = (terms + TERMS_AT_ONCE).min(MOST_TERMS);
        }
    }

    /// Computes series of `terms` terms, without an audit.
    ///
    /// # Errors
    /// Too little memory; a cancelled task.
    pub fn with_terms(
        transform: &Transform<'_>,
        settings: &PowerSettings,
        terms: usize,
        task: &Task,
    ) -> Result<Self> {
        let (grid, z_max, field) = (*transform.grid(), settings.z_max(), transform.field());
        memory::ensure_room((grid.count() * terms * size_of::<f32>()) as u64, "the powers of all orders")?;
        let mut coefficients = vec![0f32; grid.count() * terms];
        let mut specular = vec![0.0; terms];
        for (j, z) in nodes(terms, z_max).into_iter().enumerate() {
            task.report(ORDERS, j, terms)?;
            let at = transform.at(z);
            specular[j] = at.specular;
            let scale = 1.0 / (z * z);
            let orders = coefficients.par_chunks_exact_mut(terms).zip(&at.powers);
            orders.for_each(|(order, power)| order[j] = (power * scale) as f32);
        }
        let transform = ChebyshevTransform::new(terms);
        let values = specular.clone();
        transform.apply(values.into_iter(), &mut transform.scratch(), |k, a| specular[k] = a);
        coefficients.par_chunks_exact_mut(terms).try_for_each_init(
            || (transform.scratch(), vec![0f32; terms]),
            |(scratch, values), order| {
                task.check()?;
                values.copy_from_slice(order);
                transform.apply(values.iter().map(|v| f64::from(*v)), scratch, |k, a| order[k] = a as f32);
                Ok(())
            },
        )?;
        let [dx, dy] = field.pixel_size();
        Ok(Self {
            grid,
            terms,
            z_max,
            specular,
            sigma: settings.sigma,
            blur: Blur::of_orders(settings.sigma, field.patch_size(), settings.beyond),
            band: [0.5 / dx, 0.5 / dy],
            error: 0.0,
            coefficients,
        })
    }

    /// Fails at once for heights that no number of terms can follow; [`Self::new`] finds lesser ones by its audit. A sinusoid turns the phase by √2 times its
    /// standard deviation times z. Single spikes count for little.
    ///
    /// # Errors
    /// With the heights and the most that are possible.
    pub fn check_heights(field: &HeightField, settings: &PowerSettings) -> Result<()> {
        /// Times as many turns as terms, of which the audit leaves none.
        const HOPELESS: f64 = 2.0;
        let heights = field.heights();
        let mean = heights.iter().sum::<f64>() / heights.len() as f64;
        let deviation =
            (heights.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / heights.len() as f64).sqrt();
        let most = HOPELESS * MOST_TERMS as f64 / (SQRT_2 * settings.z_max());
        if deviation <= most {
            return Ok(());
        }
        Err(Error::limit(
            format!(
                "the heights vary by {deviation:.3e} um RMS, and beyond {most:.1} um {MOST_TERMS} terms in z cannot follow them"
            ),
            [Remedy::Words("check the height and its unit".into()), Remedy::ReferenceMethod],
        ))
    }

    /// Returns the least that the series of `field` take; `None` for a surface too high for any number of terms.
    pub fn estimate(field: &HeightField, settings: &PowerSettings) -> Option<Estimate> {
        let z_max = settings.z_max();
        if turns(field, z_max) > MOST_TERMS as f64 {
            return None;
        }
        let (grid, terms) = (order_grid(field, settings), first_terms(field, z_max));
        Some(Estimate { terms, orders: grid.size, bytes: grid.count() * terms * size_of::<f32>() })
    }

    /// Coefficients of all orders, row by row in growing m_y, an order's terms together.
    pub fn coefficients(&self) -> &[f32] {
        &self.coefficients
    }

    /// Fills `values` with the polynomials T_0 … T_{n−1} at `z` \[rad/µm\].
    pub fn polynomials_at(&self, z: f64, values: &mut [f64]) {
        polynomials((2.0 * z / self.z_max - 1.0).min(1.0), values);
    }

    /// Returns |c_0|² at `z` \[rad/µm\].
    pub fn specular_power(&self, z: f64) -> f64 {
        let mut t = vec![0.0; self.specular.len()];
        self.polynomials_at(z, &mut t);
        self.specular.iter().zip(&t).map(|(a, t)| a * t).sum::<f64>().max(0.0)
    }

    /// Returns the number of orders of equal power that would light a picture as evenly, (Σp)²/Σp² of the orders' powers p at
    /// `z` \[rad/µm\] (the participation ratio); [`EVEN`] for a surface that scatters nothing.
    pub fn effective_orders(&self, z: f64) -> f64 {
        let mut t = vec![0.0; self.terms];
        self.polynomials_at(z, &mut t);
        let power =
            |order: &[f32]| order.iter().zip(&t).map(|(a, t)| f64::from(*a) * t).sum::<f64>().max(0.0);
        let add = |(sum, squares): (f64, f64), p: f64| (sum + p, squares + p * p);
        let (sum, squares) = self.coefficients.chunks_exact(self.terms).map(power).fold((0.0, 0.0), add);
        if squares > 0.0 { (sum * sum / squares).min(EVEN) } else { EVEN }
    }

    /// Returns the RMS relative error over the brightest orders at `z` \[rad/µm\], whose powers are `exact`.
    fn error_at(&self, z: f64, exact: &OrderPowers) -> f64 {
        /// Rounding of the transform: fainter powers are nothing.
        const LEAST: f64 = 1e-20;
        let mut t = vec![0.0; self.terms];
        self.polynomials_at(z, &mut t);
        let mut sorted = exact.powers.clone();
        let rank = ((1.0 - JUDGED_SHARE) * sorted.len() as f64) as usize;
        let rank = rank.min(sorted.len().saturating_sub(1));
        let (_, faintest, _) = sorted.select_nth_unstable_by(rank, f64::total_cmp);
        let brightest = exact.powers.iter().copied().fold(0.0, f64::max);
        let floor = faintest.max(LEAST).max(JUDGED_POWER * brightest);
        let judged = self.coefficients.par_chunks_exact(self.terms).zip(&exact.powers);
        let square = |(order, power): (&[f32], &f64)| {
            let sum: f64 = order.iter().zip(&t).map(|(a, t)| f64::from(*a) * t).sum();
            (sum * z * z / power - 1.0).powi(2)
        };
        let one = |both: (&[f32], &f64)| if *both.1 >= floor { (square(both), 1usize) } else { (0.0, 0) };
        let (squares, count) = sums::in_order(judged.map(one), (0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        if count > 0 { (squares / count as f64).sqrt() } else { 0.0 }
    }
}

/// Number of orders above those that any picture resolves.
pub const EVEN: f64 = 1e6;

/// Returns the orders that light of `settings` sends into visible directions.
pub(crate) fn order_grid(field: &HeightField, settings: &PowerSettings) -> OrderGrid {
    let [x, y] = Blur::of_orders(settings.sigma, field.patch_size(), settings.beyond).variance;
    OrderGrid::new(field, 2.0 / settings.shortest, GUARD * x.max(y).sqrt())
}

/// Returns the number of terms to begin with: the phase of e^{iz(h − h′)} covers z_max H, half of it to either side. Its
/// coefficients, Bessel functions of order n of this half, are still large at n = half + 2. The audit adds more terms.
fn first_terms(field: &HeightField, z_max: f64) -> usize {
    const STILL_LARGE: f64 = 2.0;
    let terms = (turns(field, z_max) + STILL_LARGE).ceil() as usize;
    terms.next_multiple_of(TERMS_AT_ONCE).clamp(TERMS_AT_ONCE, MOST_TERMS)
}

fn turns(field: &HeightField, z_max: f64) -> f64 {
    let (low, high) = field.range();
    0.5 * z_max * (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(tolerance: f64) -> PowerSettings {
        PowerSettings { error: tolerance, ..PowerSettings::new(2.0, Beyond::Copies, tolerance) }
    }

    #[test]
    fn heights_that_no_terms_follow_are_refused_at_once_and_lower_ones_are_not() {
        let settings = settings(1e-2);
        let e = OrderSeries::check_heights(&rough(1e6), &settings).unwrap_err().to_string();
        assert!(e.contains("um RMS") && e.contains("check the height and its unit"), "{e}");
        assert!(OrderSeries::new(&rough(1e6), &settings, &Task::reporting(|_| panic!("it began"))).is_err());
        // Half as much is for the audit to judge.
        assert!(OrderSeries::check_heights(&rough(5.0), &settings).is_ok());
    }

    fn rough(height: f64) -> HeightField {
        let wave = |x: f64, y: f64| {
            (6.3 * x).sin() + 0.6 * (5.1 * x + 7.7 * y).cos() + 0.4 * (11.0 * y - 3.0 * x).sin()
        };
        let n = 60;
        let at = |i: usize| wave(0.1 * (i % n) as f64, 0.1 * (i / n) as f64) / 4.0;
        HeightField::new(n, n, [0.1; 2], (0..n * n).map(|i| height * at(i)).collect()).unwrap()
    }

    #[test]
    fn series_take_their_estimate_or_more_terms_for_the_same_orders() {
        let heights = (0..40 * 30).map(|i| 0.3 * (f64::from(i) * 0.618_034).fract()).collect();
        let field = HeightField::new(40, 30, [0.1, 0.12], heights).unwrap();
        let made = OrderSeries::new(&field, &settings(1e-2), &Task::silent()).unwrap();
        let expected = OrderSeries::estimate(&field, &settings(1e-2)).unwrap();
        assert_eq!(made.grid.size, expected.orders);
        assert!(made.terms >= expected.terms && made.coefficients().len() * 4 >= expected.bytes);
        let high = HeightField::new(2, 1, [0.1; 2], vec![0.0, 20.0]).unwrap();
        assert_eq!(OrderSeries::estimate(&high, &settings(1e-2)), None);
        let refused = OrderSeries::new(&high, &settings(1e-2), &Task::silent());
        assert!(refused.is_err(), "heights beyond any number of terms");
    }

    #[test]
    fn the_series_in_z_meet_their_error_at_all_heights_and_at_both_ends_of_z() {
        for height in [0.0, 0.05, 0.4, 1.0, 3.0] {
            let field = rough(height);
            let series = OrderSeries::new(&field, &settings(1e-2), &Task::silent()).unwrap();
            assert!(series.error <= 1e-2, "{height} um: {}", series.error);
            assert_eq!(series.terms % TERMS_AT_ONCE, 0);
            // The specular order's curve against the plain mean of the phases.
            for share in [1e-3, 0.2, 0.55, 0.9999] {
                let z = share * series.z_max;
                let (re, im) = field
                    .heights()
                    .iter()
                    .fold((0.0, 0.0), |(re, im), h| (re + (z * h).cos(), im + (z * h).sin()));
                let n = field.heights().len() as f64;
                let plain = (re * re + im * im) / (n * n);
                let found = series.specular_power(z);
                assert!((found - plain).abs() < 2e-3, "{height} um at {share}: {found} {plain}");
            }
        }
    }

    #[test]
    fn too_few_terms_are_found_out() {
        let field = rough(1.0);
        let settings = settings(1e-2);
        let transform = Transform::new(&field, order_grid(&field, &settings), settings.beyond);
        let z = 0.7 * settings.z_max();
        let error = |terms| {
            let series = OrderSeries::with_terms(&transform, &settings, terms, &Task::silent()).unwrap();
            series.error_at(z, &transform.at(z))
        };
        assert!(error(8) > 0.1 && error(32) < 1e-3, "{} {}", error(8), error(32));
    }
}
