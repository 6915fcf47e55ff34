//! From a height field to its power spectra: how many terms in z, how fine a grid, and the audit of both.

use super::chebyshev::{coefficients_from_values, nodes, polynomials};
use super::orders::{OrderGrid, OrderPowers, Transform};
use super::texture::{self, FrequencyGrid, Levels, PER_TEXEL};
use super::{Beyond, Blur};
use crate::error::{Error, Remedy, Result};
use crate::fft_size::fast_size_with_seven;
use crate::memory;
use crate::optics::spectrum::SHORTEST;
use crate::precompute::kernel::Kernel;
use crate::surface::{HeightField, MAX_SIDE};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// What power spectra are made for. Everything here and the height field is the key of a cache entry.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PowerSettings {
    /// Standard deviation of the coherence window \[µm\], a quarter of the coherence length.
    pub sigma: f64,
    /// How the surface goes on beyond the patch.
    pub beyond: Beyond,
    /// Shortest wavelength that is asked for \[µm\].
    pub shortest: f64,
    /// Relative error of the power between the nodes in z, RMS over the bright orders.
    pub series_error: f64,
    /// Relative error of reading between texels, of a single wavelength.
    pub reading_error: f64,
    /// The least standard deviation of (u, v) that is averaged over, which the finest level need not resolve better.
    pub least_footprint: f64,
    /// Most texels along a side of a texture.
    pub side_limit: usize,
    /// Most bytes of all levels. Not part of the key: it decides whether they are made.
    #[serde(skip)]
    pub memory_limit: usize,
}

impl PowerSettings {
    /// Bytes that spectra may take unless the user says.
    const USUAL_MEMORY: usize = 1 << 31;

    /// Spectra of all visible light for single directions, through a coherence window of standard deviation `sigma` \[µm\], with a relative
    /// error of `tolerance` for a single wavelength.
    pub fn new(sigma: f64, beyond: Beyond, tolerance: f64) -> Self {
        Self {
            sigma,
            beyond,
            shortest: SHORTEST,
            series_error: 0.5 * tolerance,
            reading_error: tolerance,
            least_footprint: 0.0,
            side_limit: MAX_SIDE,
            memory_limit: Self::USUAL_MEMORY,
        }
    }
}

/// The powers of a surface's orders, blurred by the coherence of the light, as Chebyshev series in z over a grid of frequencies.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerSpectra {
    /// Everything but the numbers of the texels.
    pub header: PowerHeader,
    /// Coefficients of Σ|c_m|² γ̂(f − m/T)/z² over `unit`, without the specular order.
    pub levels: Levels,
}

/// What the numbers of [`PowerSpectra`] mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PowerHeader {
    /// Where the texels stand.
    pub grid: FrequencyGrid,
    /// Number of Chebyshev terms in z, a multiple of 4.
    pub terms: usize,
    /// Largest z \[rad/µm\]: the series are over 0 … z_max.
    pub z_max: f64,
    /// What a stored 1 stands for \[µm⁴/rad²\].
    pub unit: f64,
    /// Coefficients of the specular order's power |c_0|² over the same range.
    pub specular: Vec<f64>,
    /// Standard deviation of the coherence window \[µm\].
    pub sigma: f64,
    /// Blur of the orders by the coherence of the light and the lag window.
    pub orders_blur: Blur,
    /// Largest |f_x|, |f_y| that the samples hold \[µm⁻¹\].
    pub band: [f64; 2],
    /// Relative error between the nodes in z, measured on the surface.
    pub series_error: f64,
    /// Relative error of reading between texels, from the kernel's transform.
    pub reading_error: f64,
    /// How many orders share the light: [`texture::effective_orders`].
    pub effective_orders: f64,
}

/// Fewest terms: one texel.
pub(super) const FEWEST_TERMS: usize = PER_TEXEL;
/// Most terms: heights of about 6 µm.
pub(super) const MOST_TERMS: usize = 128;
/// z between the nodes at which the audit compares series with transforms, as shares of the range. Both ends are among them.
const AUDITED: [f64; 4] = [0.03, 0.35, 0.7, 0.997];
/// Orders that the audit judges: this share of the brightest ones.
const JUDGED_SHARE: f64 = 0.1;
/// Levels that a texture has at most, and fewest texels along a side of the coarsest.
pub(super) const MOST_LEVELS: usize = 8;
const FEWEST_TEXELS: usize = 8;

/// Makes the power spectra of `field`.
///
/// # Errors
/// Where memory or the limits of the settings do not suffice, where no number of terms meets the tolerance, what `progress` returns.
pub fn power_spectra(
    field: &HeightField,
    settings: &PowerSettings,
    progress: &dyn Fn(usize, usize) -> Result<()>,
) -> Result<PowerSpectra> {
    let z_max = 4.0 * PI / settings.shortest;
    let SpectraPlan { orders_blur, orders, grid, reading_error } = SpectraPlan::new(field, settings);
    let transform = Transform::new(field, orders, settings.beyond);
    transform.ensure_room()?;
    let [dx, dy] = field.pixel_size();
    let audited: Vec<OrderPowers> = AUDITED.iter().map(|share| transform.at(share * z_max)).collect();
    let mut terms = first_terms(field, z_max);
    loop {
        check_room(&grid, &orders, terms, settings)?;
        let (series, specular) = series(&transform, terms, z_max, progress)?;
        let series_error = audit(&series, &audited, z_max);
        if series_error > settings.series_error && terms < MOST_TERMS {
            terms = (terms + PER_TEXEL).min(MOST_TERMS);
            continue;
        }
        if series_error > settings.series_error {
            return Err(Error::failed(
                format!("{terms} terms in z leave a relative error of {series_error:.1e} on this surface"),
                [Remedy::LargerTolerance, Remedy::ReferenceMethod],
            ));
        }
        let (levels, unit) = texture::levels(&orders, &series, &grid);
        progress(terms, terms)?;
        let effective_orders = texture::effective_orders(&levels[0], &grid, z_max);
        let header = PowerHeader {
            grid,
            terms,
            z_max,
            unit,
            specular,
            sigma: settings.sigma,
            orders_blur,
            band: [0.5 / dx, 0.5 / dy],
            series_error,
            reading_error,
            effective_orders,
        };
        return Ok(PowerSpectra { header, levels });
    }
}

/// Where orders and texels stand.
struct SpectraPlan {
    orders_blur: Blur,
    orders: OrderGrid,
    grid: FrequencyGrid,
    reading_error: f64,
}

impl SpectraPlan {
    fn new(field: &HeightField, settings: &PowerSettings) -> Self {
        let orders_blur = Blur::of_orders(settings.sigma, field.patch_size(), settings.beyond);
        // What the kernel and the finest blur reach beyond the band.
        let guard = 4.0 * orders_blur.variance[0].max(orders_blur.variance[1]).sqrt();
        let orders = OrderGrid::new(field, 2.0 / settings.shortest, guard);
        let (grid, reading_error) = choose_grid(&orders, orders_blur, settings);
        Self { orders_blur, orders, grid, reading_error }
    }
}

/// What power spectra take at least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Estimate {
    /// Terms in z.
    pub terms: usize,
    /// Texels along each side of the finest level.
    pub size: [usize; 2],
    /// Bytes of all levels.
    pub bytes: usize,
}

/// What the power spectra of `field` take, known before they are made: their audit may ask for more terms. `None` where it is too high for any number of
/// them.
pub fn estimate(field: &HeightField, settings: &PowerSettings) -> Option<Estimate> {
    let z_max = 4.0 * PI / settings.shortest;
    if turns(field, z_max) > MOST_TERMS as f64 {
        return None;
    }
    let (grid, terms) = (SpectraPlan::new(field, settings).grid, first_terms(field, z_max));
    Some(Estimate { terms, size: grid.size, bytes: grid.bytes(terms) })
}

/// Terms to begin with: e^{iz(h − h′)} turns by z_max H over the range, half of it to either side. Its coefficients, Bessel functions of the order n at so many
/// turns, are still large at n = turns + 2. The audit asks for more.
fn first_terms(field: &HeightField, z_max: f64) -> usize {
    const STILL_LARGE: f64 = 2.0;
    ((turns(field, z_max) + STILL_LARGE).ceil() as usize)
        .next_multiple_of(PER_TEXEL)
        .clamp(FEWEST_TERMS, MOST_TERMS)
}

fn turns(field: &HeightField, z_max: f64) -> f64 {
    let (low, high) = field.range();
    0.5 * z_max * (high - low)
}

/// The grid on which reading errs by no more than `settings` allow, or the finest that the limits allow, and its error.
fn choose_grid(orders: &OrderGrid, blur: Blur, settings: &PowerSettings) -> (FrequencyGrid, f64) {
    let range = [0, 1].map(|i| orders.size[i] as f64 / orders.patch[i]);
    // A footprint blurs by its width over the wavelength; the longest has the least.
    let footprint = settings.least_footprint / crate::optics::spectrum::LONGEST;
    let finest = Blur { variance: blur.variance.map(|v| v.max(footprint * footprint)) };
    let window = finest.window();
    let kernel = Kernel::Cubic;
    let mut density = 0.8;
    loop {
        let exact = [0, 1].map(|i| (range[i] * window[i] * 2.0 * PI * density).ceil() as usize);
        let levels = levels_for(exact);
        let step = 1 << (levels - 1);
        let size = exact.map(|n| step * fast_size_with_seven(n.max(FEWEST_TEXELS).div_ceil(step)));
        let grid = FrequencyGrid { size, range, levels, blur: finest, kernel };
        let error = grid.interpolation().amplitude_error();
        let at_limit = size.iter().any(|&n| n as f64 * 1.05 > settings.side_limit as f64);
        if error <= settings.reading_error || at_limit {
            return (grid, error);
        }
        density *= 1.05;
    }
}

fn levels_for(size: [usize; 2]) -> usize {
    let least = size[0].min(size[1]);
    let halvings = (least / FEWEST_TEXELS).max(1).ilog2() as usize;
    (halvings + 1).min(MOST_LEVELS)
}

fn check_room(
    grid: &FrequencyGrid,
    orders: &OrderGrid,
    terms: usize,
    settings: &PowerSettings,
) -> Result<()> {
    const MIB: f64 = 1024.0 * 1024.0;
    let bytes = grid.bytes(terms);
    if bytes > settings.memory_limit {
        return Err(Error::failed(
            format!(
                "the power spectra would take {:.0} MiB of {:.0}",
                bytes as f64 / MIB,
                settings.memory_limit as f64 / MIB
            ),
            [Remedy::LargerTolerance, Remedy::ShorterCoherence],
        ));
    }
    let working = orders.count() * terms * size_of::<f64>() + 4 * grid.size[0] * grid.size[1] * 16;
    memory::ensure_room((bytes + working) as u64, "the power spectra")
}

/// The Chebyshev series of every order's power over z², [term][order], and of the specular order's power.
fn series(
    transform: &Transform<'_>,
    terms: usize,
    z_max: f64,
    progress: &dyn Fn(usize, usize) -> Result<()>,
) -> Result<(Vec<Vec<f64>>, Vec<f64>)> {
    let mut values: Vec<Vec<f64>> = Vec::with_capacity(terms);
    let mut specular = Vec::with_capacity(terms);
    for (j, z) in nodes(terms, z_max).into_iter().enumerate() {
        progress(j, terms)?;
        let mut at = transform.at(z);
        at.powers.iter_mut().for_each(|power| *power /= z * z);
        specular.push(at.specular);
        values.push(at.powers);
    }
    let matrix = coefficients_from_values(terms);
    let specular = matrix.iter().map(|row| row.iter().zip(&specular).map(|(m, v)| m * v).sum()).collect();
    // In place, an order at a time.
    const AT_ONCE: usize = 4096;
    let count = transform.grid().count();
    let blocks: Vec<Vec<f64>> = (0..count.div_ceil(AT_ONCE))
        .into_par_iter()
        .map(|block| {
            let range = block * AT_ONCE..((block + 1) * AT_ONCE).min(count);
            let mut out = vec![0.0; range.len() * terms];
            for (k, row) in matrix.iter().enumerate() {
                let own = &mut out[k * range.len()..(k + 1) * range.len()];
                for (value, m) in values.iter().zip(row) {
                    own.iter_mut().zip(&value[range.clone()]).for_each(|(o, v)| *o += m * v);
                }
            }
            out
        })
        .collect();
    for (k, term) in values.iter_mut().enumerate() {
        for (part, block) in term.chunks_mut(AT_ONCE).zip(&blocks) {
            let n = part.len();
            part.copy_from_slice(&block[k * n..(k + 1) * n]);
        }
    }
    Ok((values, specular))
}

/// The largest of the audited z's RMS relative errors over the brightest orders there.
fn audit(series: &[Vec<f64>], audited: &[OrderPowers], z_max: f64) -> f64 {
    let mut worst: f64 = 0.0;
    let mut t = vec![0.0; series.len()];
    for (share, exact) in AUDITED.iter().zip(audited) {
        let z = share * z_max;
        polynomials(2.0 * share - 1.0, &mut t);
        let mut sorted = exact.powers.clone();
        let rank = ((1.0 - JUDGED_SHARE) * sorted.len() as f64) as usize;
        if sorted.is_empty() {
            continue;
        }
        let (_, faintest, _) =
            sorted.select_nth_unstable_by(rank.min(exact.powers.len() - 1), f64::total_cmp);
        // Rounding of the transform: fainter powers are nothing.
        let floor = faintest.max(1e-20);
        let (mut squares, mut count) = (0.0, 0usize);
        for (i, &power) in exact.powers.iter().enumerate().filter(|(_, p)| **p >= floor) {
            let sum: f64 = series.iter().zip(&t).map(|(term, t)| term[i] * t).sum();
            squares += (sum * z * z / power - 1.0).powi(2);
            count += 1;
        }
        if count > 0 {
            worst = worst.max((squares / count as f64).sqrt());
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectra::power::read::{ReadScratch, SpectraReader, Square};
    use glam::DVec2;

    fn settings(tolerance: f64) -> PowerSettings {
        PowerSettings {
            sigma: 2.0,
            beyond: Beyond::Copies,
            shortest: 0.38,
            series_error: tolerance,
            reading_error: tolerance,
            least_footprint: 0.0,
            side_limit: 16384,
            memory_limit: 1 << 30,
        }
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
    fn what_is_made_takes_what_was_estimated_or_more_terms_on_the_same_grid() {
        let heights = (0..40 * 30).map(|i| 0.3 * (f64::from(i) * 0.618_034).fract()).collect();
        let field = HeightField::new(40, 30, [0.1, 0.12], heights).unwrap();
        let made = power_spectra(&field, &settings(1e-2), &|_, _| Ok(())).unwrap().header;
        let expected = estimate(&field, &settings(1e-2)).unwrap();
        assert_eq!(made.grid.size, expected.size);
        assert!(made.terms >= expected.terms && made.grid.bytes(expected.terms) == expected.bytes);
        let high = HeightField::new(2, 1, [0.1; 2], vec![0.0, 20.0]).unwrap();
        assert_eq!(estimate(&high, &settings(1e-2)), None);
    }

    #[test]
    fn the_series_in_z_meet_their_error_at_all_heights_and_at_both_ends_of_z() {
        for height in [0.0, 0.05, 0.4, 1.0, 3.0] {
            let field = rough(height);
            let spectra = power_spectra(&field, &settings(1e-2), &|_, _| Ok(())).unwrap();
            let header = &spectra.header;
            assert!(header.series_error <= 1e-2, "{height} um: {}", header.series_error);
            assert_eq!(header.terms % PER_TEXEL, 0);
            // The specular order's curve against the plain mean of the phases.
            for share in [1e-3, 0.2, 0.55, 0.9999] {
                let z = share * header.z_max;
                let mut t = vec![0.0; header.terms];
                polynomials(2.0 * share - 1.0, &mut t);
                let series: f64 = header.specular.iter().zip(&t).map(|(a, t)| a * t).sum();
                let (re, im) = field
                    .heights()
                    .iter()
                    .fold((0.0, 0.0), |(re, im), h| (re + (z * h).cos(), im + (z * h).sin()));
                let n = field.heights().len() as f64;
                let plain = (re * re + im * im) / (n * n);
                assert!((series - plain).abs() < 2e-3, "{height} um at {share}: {series} {plain}");
            }
        }
    }

    #[test]
    fn what_is_read_between_texels_is_the_blurred_sum_over_the_orders() {
        let tolerance = 1e-2;
        // With the lag window, whose blur follows the sides of the patch, the axes differ.
        for (pixel, beyond) in [([0.1, 0.1], Beyond::Copies), ([0.1, 0.05], Beyond::Alike)] {
            let field = rough(0.3);
            let field = HeightField::new(60, 60, pixel, field.heights().to_vec()).unwrap();
            let settings = PowerSettings { beyond, ..settings(tolerance) };
            let reader = SpectraReader::new(&power_spectra(&field, &settings, &|_, _| Ok(())).unwrap());
            let blur =
                DVec2::from_array(Blur::of_orders(settings.sigma, field.patch_size(), beyond).variance);
            // Every order's power by its transform, without the specular order.
            let orders = OrderGrid::new(&field, 100.0, 0.0);
            let transform = Transform::new(&field, orders, beyond);
            let place = |i: usize| {
                let at = [i % orders.size[0], i / orders.size[0]];
                DVec2::from_array([0, 1].map(|k| (at[k] as f64 - orders.origin[k] as f64) / orders.patch[k]))
            };
            // Nothing else, a little, about as much as the coherence, and several levels.
            let spreads = [0.0, 0.001, 0.05, 0.6, 1.7, 3.01, 3.9, 4.1, 9.0, 40.0];
            let mut sums = [[0.0; 2]; 10];
            for i in 0..200 {
                let f = DVec2::from_angle(2.4 * f64::from(i)) * (0.2 + 0.02 * f64::from(i));
                let z = 4.0 + 0.1 * f64::from(i);
                let powers = transform.at(z).powers;
                let mut t = vec![0.0; reader.header.terms];
                polynomials(2.0 * z / reader.header.z_max - 1.0, &mut t);
                for ([error, energy], spread) in sums.iter_mut().zip(spreads) {
                    let spread = spread * blur.min_element();
                    let variance = blur + spread;
                    // The lobe of every order.
                    let peak = 1.0 / (2.0 * PI * (variance.x * variance.y).sqrt());
                    let lobe = |d: DVec2| peak * (-0.5 * (d * d / variance).element_sum()).exp();
                    let exact: f64 =
                        powers.iter().enumerate().map(|(i, power)| power * lobe(f - place(i))).sum();
                    let mut terms = vec![glam::Vec4::ZERO; reader.header.terms / PER_TEXEL];
                    reader.read(&Square::point(f), spread, &mut ReadScratch::default(), &mut terms);
                    let series = terms.iter().flat_map(|a| a.to_array()).zip(&t);
                    let value: f64 = series.map(|(a, t)| f64::from(a) * t).sum();
                    *error += (value * reader.header.unit * z * z - exact).powi(2);
                    *energy += exact * exact;
                }
            }
            for ([error, energy], spread) in sums.into_iter().zip(spreads) {
                let error = f64::sqrt(error / energy);
                eprintln!("{beyond:?}, averaged over {spread} of the blur's variance: {error:.1e}");
                assert!(error <= tolerance, "{beyond:?}, {spread}: {error}");
            }
        }
    }
}
