//! Quadrature over wavelengths, with weights that contain the colour functions.
//!
//! Along a ray from the specular direction the response varies with the wavenumber q = 1/λ at a rate that the window fixes: in q the
//! response |P(q·(u,v))|² has the spectrum of the window's autocorrelation. So the number of wavelengths follows from a formula: the number
//! of correlation lengths along the ray, plus the number for the colour functions. Wavelengths to which the eye is less sensitive need
//! fewer nodes; see [`WavelengthSets`].

use super::spectrum::{Illuminant, LONGEST, SHORTEST};
use glam::DVec3;
use std::f64::consts::PI;

/// Span of wavenumbers of the colour integral, 1/λ_min − 1/λ_max \[µm⁻¹\].
pub const SPAN: f64 = 1.0 / SHORTEST - 1.0 / LONGEST;

const NM_PER_UM: f64 = 1000.0;

/// Wavenumbers q_j with the XYZ weight of each: Σ f(q_j) weight_j ≈ ∫ f S (x̄,ȳ,z̄) dλ / ∫ S ȳ dλ.
#[derive(Clone, Debug, PartialEq)]
pub struct Wavelengths {
    /// Wavenumbers, growing \[µm⁻¹\].
    pub wavenumbers: Vec<f64>,
    /// XYZ weights.
    pub weights: Vec<DVec3>,
}

impl Wavelengths {
    /// Returns the trapezoid rule with `count` ≥ 2 equal steps of the wavenumber over 380–780 nm, ends included.
    #[cfg(test)]
    pub(crate) fn trapezoid(illuminant: &Illuminant, count: usize) -> Self {
        let colour = ColourDensity::new(illuminant);
        let wavenumbers = even_wavenumbers(count);
        let step = SPAN / (count as f64 - 1.0);
        let weights = wavenumbers
            .iter()
            .enumerate()
            .map(|(j, q)| {
                let end = if j == 0 || j == count - 1 { 0.5 } else { 1.0 };
                colour.at(*q) * (step * end)
            })
            .collect();
        Self { wavenumbers, weights }
    }

    /// Returns product integration with `count` ≥ 4 equal steps: each weight is the colour function's integral against a Catmull–Rom
    /// kernel, so the jagged daylight spectrum costs no wavelengths and only the response has to be resolved.
    pub fn catmull_rom(illuminant: &Illuminant, count: usize) -> Self {
        /// Steps per wavelength, so that each sees its whole kernel.
        const PER_NODE: usize = 16;
        let fine = FINE.max(PER_NODE * count);
        let colours = fine_colours(illuminant, fine);
        let last = (count - 1) as f64;
        let places = (0..fine).map(|i| (i as f64 + 0.5) / fine as f64 * last);
        Self { wavenumbers: even_wavenumbers(count), weights: kernel_weights(places.zip(colours), count) }
    }

    /// Returns the trapezoid rule with `count` ≥ 2 equal steps of the wavelength over 380–780 nm, as renderers usually sum.
    pub fn even(illuminant: &Illuminant, count: usize) -> Self {
        let (luminance, last) = (illuminant.luminance(), count - 1);
        let step = (LONGEST - SHORTEST) / last as f64;
        let node = |j: usize| {
            let wavelength = LONGEST - j as f64 * step;
            let end = if j == 0 || j == last { 0.5 } else { 1.0 };
            let weight = illuminant.weight(wavelength * NM_PER_UM, luminance) * (step * NM_PER_UM * end);
            (1.0 / wavelength, weight)
        };
        let (wavenumbers, weights) = (0..count).map(node).unzip();
        Self { wavenumbers, weights }
    }

    /// Returns the number of wavelengths.
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// Returns the first wavenumber and the distance of the next \[µm⁻¹\]; all are as far apart for equal steps of the wavenumber.
    pub fn first_and_step(&self) -> (f64, f64) {
        match self.wavenumbers.as_slice() {
            [] => (0.0, 0.0),
            [only] => (*only, 0.0),
            [first, .., last] => (*first, (last - first) / (self.len() - 1) as f64),
        }
    }

    /// Returns Σ `of`(1/q) weight \[µm\].
    pub fn integral(&self, of: impl Fn(f64) -> f64) -> DVec3 {
        self.weights.iter().zip(&self.wavenumbers).map(|(weight, q)| *weight * of(1.0 / q)).sum()
    }
}

/// Returns `count` wavenumbers over the whole span, ends included \[µm⁻¹\].
fn even_wavenumbers(count: usize) -> Vec<f64> {
    (0..count).map(|j| 1.0 / LONGEST + j as f64 * (SPAN / (count as f64 - 1.0))).collect()
}

/// Steps of the colour functions: 0.02 nm at the short end, 0.1 nm at the long one. The tables are linear over 1 nm.
const FINE: usize = 8192;

/// Returns the colour functions times the step, in the middle of each of `count` steps of the wavenumber.
fn fine_colours(illuminant: &Illuminant, count: usize) -> Vec<DVec3> {
    let colour = ColourDensity::new(illuminant);
    let step = SPAN / count as f64;
    (0..count).map(|i| colour.at(1.0 / LONGEST + (i as f64 + 0.5) * step) * step).collect()
}

/// Returns the weights of `count` wavelengths at 0, 1, …: the integral of `colours`, each with its place, against Catmull–Rom kernels.
/// Beyond the ends a response is extended by its end value.
fn kernel_weights(colours: impl Iterator<Item = (f64, DVec3)>, count: usize) -> Vec<DVec3> {
    let mut weights = vec![DVec3::ZERO; count];
    for (place, colour) in colours {
        let left = place.floor().min(count as f64 - 2.0);
        for (offset, share) in (-1..=2).zip(catmull_rom(place - left)) {
            let j = (left as i64 + offset).clamp(0, count as i64 - 1) as usize;
            weights[j] += colour * share;
        }
    }
    weights
}

/// Returns the weights of the four neighbours at −1, 0, 1, 2 of a point at `t` ∈ \[0, 1\] (Catmull & Rom 1974).
fn catmull_rom(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        0.5 * (-t3 + 2.0 * t2 - t),
        0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
        0.5 * (-3.0 * t3 + 4.0 * t2 + t),
        0.5 * (t3 - t2),
    ]
}

/// The colour functions as a density over wavenumber.
struct ColourDensity<'a> {
    illuminant: &'a Illuminant,
    luminance: f64,
}

impl<'a> ColourDensity<'a> {
    fn new(illuminant: &'a Illuminant) -> Self {
        Self { illuminant, luminance: illuminant.luminance() }
    }

    /// Returns S (x̄,ȳ,z̄)/∫Sȳdλ · |dλ/dq| at `q` \[µm⁻¹\].
    fn at(&self, q: f64) -> DVec3 {
        // Held inside the tables against the rounding of the last wavenumber.
        let wavelength = (1.0 / q).clamp(SHORTEST, LONGEST) * NM_PER_UM;
        self.illuminant.weight(wavelength, self.luminance) * (NM_PER_UM / (q * q))
    }
}

/// Returns S (x̄,ȳ,z̄)/∫Sȳdλ · |dλ/dq| \[µm\] at `count` ≥ 2 equal steps of wavenumber over 380–780 nm, ends included: the XYZ per unit
/// of wavenumber of a response of 1.
pub fn density_table(illuminant: &Illuminant, count: usize) -> Vec<DVec3> {
    let colour = ColourDensity::new(illuminant);
    even_wavenumbers(count).into_iter().map(|q| colour.at(q)).collect()
}

/// Sets of wavelengths of increasing size; each direction takes the smallest sufficient set. Nodes are denser at wavelengths to which the
/// eye is more sensitive.
///
/// Wavelengths of local step δq along a ray at |(u,v)| alias the part of the window's autocorrelation exp(−x²/4σ²) beyond x = 1/(|(u,v)|
/// δq). At a wavelength with colour functions s times their peak, an alias of level ε/√s is allowed. The density of wavelengths is
/// therefore √ln(√s/ε)·2σ|(u,v)|, and 0 for √s < ε: the ends of the visible range. The square root keeps the error of directions small
/// whose light lies at one end.
#[derive(Clone, Debug, PartialEq)]
pub struct WavelengthSets {
    /// Wavelengths, in order of their count.
    pub sets: Vec<Wavelengths>,
    // Wavelengths that a direction needs for the colour functions alone, and per unit of |(u, v)|.
    base: f64,
    per_uv: f64,
}

impl WavelengthSets {
    /// Ratio of neighbouring counts: a direction takes 2 % more wavelengths than it needs on average.
    pub const RATIO: f64 = 1.04;

    /// Returns sets for a relative colour error of `tolerance` under `illuminant` through a Gaussian window of standard deviation `sigma`
    /// \[µm\].
    ///
    /// The many correlation lengths of a direction average an alias down by a factor of two, measured on speckle, including directions that
    /// speckle makes darker than their surroundings. The number of nodes for the colour functions alone is the one at which Catmull–Rom
    /// weights reach the tolerance on a smooth response.
    pub fn gaussian(illuminant: &Illuminant, sigma: f64, tolerance: f64) -> Self {
        /// Ratio of the level of aliases to the error of the colour.
        const AVERAGED: f64 = 2.0;
        // Above one half the logarithm would give no wavelengths at all.
        let level = (AVERAGED * tolerance).clamp(1e-8, 0.5);
        let density = WavelengthDensity::new(illuminant, level);
        let base = 5.0 + 4.0 * (1.0 / level).log10();
        let mut all = Self { sets: Vec::new(), base, per_uv: 2.0 * sigma * density.integral };
        let most = all.needed(2.0);
        let mut count = all.needed(0.0).max(4);
        loop {
            all.sets.push(density.wavelengths(count));
            if count >= most {
                return all;
            }
            count = ((count as f64 * Self::RATIO).ceil() as usize).min(most);
        }
    }

    /// Returns the same `wavelengths` for all directions.
    pub fn only(wavelengths: Wavelengths) -> Self {
        Self { sets: vec![wavelengths], base: 0.0, per_uv: 0.0 }
    }

    /// Returns the number of wavelengths that a direction at |(u, v)| = `uv` needs.
    fn needed(&self, uv: f64) -> usize {
        (self.base + self.per_uv * uv).ceil() as usize
    }

    /// Returns the number of the set for a direction at |(u, v)| = `uv`.
    pub fn number(&self, uv: f64) -> usize {
        let needed = self.needed(uv.min(2.0));
        self.sets.partition_point(|set| set.len() < needed).min(self.sets.len() - 1)
    }
}

/// The density of wavelengths over the visible range, on fine steps.
struct WavelengthDensity {
    /// Colour functions times the step, at each step's middle.
    colour: Vec<DVec3>,
    /// Part of the wavelengths before the end of each step, growing from 0 to 1; one entry more than steps.
    part: Vec<f64>,
    /// ∫ √ln(√s/ε) dq \[µm⁻¹\].
    integral: f64,
}

impl WavelengthDensity {
    /// Returns the density for aliases of level `level` at the peak of the colour functions.
    fn new(illuminant: &Illuminant, level: f64) -> Self {
        let colour = fine_colours(illuminant, FINE);
        let step = SPAN / FINE as f64;
        let peak = colour.iter().map(|c| c.length()).fold(f64::MIN_POSITIVE, f64::max);
        let mut integral = 0.0;
        let sums = colour.iter().map(|c| {
            integral += ((c.length() / peak).sqrt() / level).ln().max(0.0).sqrt() * step;
            integral
        });
        let mut part: Vec<f64> = std::iter::once(0.0).chain(sums).collect();
        part.iter_mut().for_each(|p| *p /= integral);
        Self { colour, part, integral }
    }

    /// Returns `count` ≥ 4 wavelengths: each weight is the integral of the colour functions against a Catmull–Rom kernel in the coordinate
    /// of this density.
    fn wavelengths(&self, count: usize) -> Wavelengths {
        let step = SPAN / self.colour.len() as f64;
        let last = (count - 1) as f64;
        let wavenumber = |j: usize| {
            let target = j as f64 / last;
            let right = self.part.partition_point(|p| *p < target).clamp(1, self.part.len() - 1);
            let (before, after) = (self.part[right - 1], self.part[right]);
            let share = if after > before { (target - before) / (after - before) } else { 0.0 };
            1.0 / LONGEST + (right as f64 - 1.0 + share) * step
        };
        let places = self.part.windows(2).map(|ends| (ends[0] + ends[1]) / 2.0 * last);
        let weights = kernel_weights(places.zip(self.colour.iter().copied()), count);
        Wavelengths { wavenumbers: (0..count).map(wavenumber).collect(), weights }
    }
}

/// Returns places from 0 to 1 and weights, which add up to 1, of the `count`-point Gauss–Legendre rule: exact for polynomials of degree 2 `count` − 1. The places
/// are roots of Legendre's polynomial, by Newton's method (Press et al., *Numerical Recipes*, 4.6).
pub fn gauss_legendre(count: u32) -> Vec<(f64, f64)> {
    /// Steps from Tricomi's start after which roots are exact to rounding.
    const STEPS: usize = 6;
    let n = f64::from(count);
    // P_n(x) and its derivative.
    let polynomial = |x: f64| {
        let (mut before, mut now) = (1.0, x);
        for k in 2..=count {
            let k = f64::from(k);
            (before, now) = (now, ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k);
        }
        (now, n * (x * now - before) / (x * x - 1.0))
    };
    let point = |i: u32| {
        let mut x = (PI * (f64::from(i) + 0.75) / (n + 0.5)).cos();
        for _ in 0..STEPS {
            let (value, slope) = polynomial(x);
            x -= value / slope;
        }
        let (_, slope) = polynomial(x);
        (0.5 - 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(point).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::random::Random;

    /// Returns a speckled response along a ray: |Σ a_m e^{i2πq·uv·x_m}|², random phases, with the x_m spread as the energy g² of the
    /// Gaussian window, a normal distribution of standard deviation σ/√2.
    pub fn speckle(seed: u64, sigma: f64, uv: f64) -> impl Fn(f64) -> f64 {
        let mut random = Random::new(seed);
        let mut uniform = || random.share();
        let spots: Vec<(f64, f64)> = (0..200)
            .map(|_| {
                let r = (-2.0 * (1.0 - uniform()).ln()).sqrt();
                (sigma / 2f64.sqrt() * r * (2.0 * PI * uniform()).cos(), uniform() * std::f64::consts::TAU)
            })
            .collect();
        move |q| {
            let (re, im) = spots.iter().fold((0.0, 0.0), |(re, im), (x, a)| {
                let (s, c) = (2.0 * PI * q * uv * x + a).sin_cos();
                (re + c, im + s)
            });
            (re * re + im * im) / 200.0
        }
    }

    pub fn colour(wavelengths: &Wavelengths, f: &dyn Fn(f64) -> f64) -> DVec3 {
        wavelengths.integral(|wavelength| f(1.0 / wavelength))
    }

    #[test]
    fn gauss_and_legendre_s_rule_is_exact_for_polynomials_and_good_for_waves() {
        for count in 1..=12 {
            let rule = gauss_legendre(count);
            for power in 0..2 * count as i32 {
                let sum: f64 = rule.iter().map(|(x, weight)| weight * x.powi(power)).sum();
                assert!((sum * f64::from(power + 1) - 1.0).abs() < 1e-12, "{count}, {power}: {sum}");
            }
            let wave: f64 = rule.iter().map(|(x, weight)| weight * (2.0 * x).cos()).sum();
            assert!(count < 4 || (wave / (0.5 * 2f64.sin()) - 1.0).abs() < 1e-6, "{count}: {wave}");
        }
    }

    #[test]
    fn both_rules_give_a_flat_response_the_white_of_the_light() {
        let illuminant = Illuminant::D65;
        for nodes in [Wavelengths::trapezoid(&illuminant, 801), Wavelengths::catmull_rom(&illuminant, 12)] {
            let white: DVec3 = nodes.weights.iter().sum();
            assert!((white - DVec3::new(0.9504, 1.0, 1.0889)).length() < 4e-4, "{white}");
        }
    }

    #[test]
    fn near_the_mirror_the_weights_stand_in_for_nodes() {
        // A response that varies with the wavelength as slowly as a mirror's: only the jagged daylight remains.
        let smooth = |q: f64| (q / 2.0).powi(2) * (1.0 + 0.5 * (3.0 * q).sin());
        let truth = colour(&Wavelengths::trapezoid(&Illuminant::D65, 8001), &smooth);
        let error = |nodes: Wavelengths| (colour(&nodes, &smooth) - truth).length() / truth.length();
        let weighted = error(Wavelengths::catmull_rom(&Illuminant::D65, 12));
        let plain = error(Wavelengths::trapezoid(&Illuminant::D65, 12));
        eprintln!("12 nodes: Catmull-Rom {weighted:.1e}, trapezoid {plain:.1e}");
        // A tenth of the finest tolerance that is common, and many times better than nodes alone.
        assert!(weighted < 5e-4 && plain > 5.0 * weighted, "{weighted:e} against {plain:e}");
    }

    #[test]
    fn a_comb_gives_a_flat_response_the_white_of_the_light_and_grows() {
        let density = WavelengthDensity::new(&Illuminant::D65, 1e-2);
        let comb = density.wavelengths(20);
        let white: DVec3 = comb.weights.iter().sum();
        assert!((white - DVec3::new(0.9504, 1.0, 1.0889)).length() < 4e-4, "{white}");
        assert!(comb.wavenumbers.is_sorted() && comb.wavenumbers[0] >= 1.0 / LONGEST);
        assert!(comb.wavenumbers[19] <= 1.0 / SHORTEST + 1e-12);
    }

    #[test]
    fn the_rule_s_nodes_reach_its_tolerance_and_half_of_them_do_not() {
        let sigma = 16.25;
        const SEEDS: u64 = 24;
        let exact = Wavelengths::trapezoid(&Illuminant::D65, 4001);
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let sets = WavelengthSets::gaussian(&Illuminant::D65, sigma, tolerance);
            let density = WavelengthDensity::new(&Illuminant::D65, 2.0 * tolerance);
            for uv in [0.0, 0.05, 0.2, 0.4, 0.7, 1.0] {
                let full = density.wavelengths(sets.needed(uv));
                let half = density.wavelengths(sets.needed(uv) / 2);
                assert!(sets.sets[sets.number(uv)].len() >= full.len());
                let (mut squares, mut halved) = (0.0, 0.0);
                for seed in 0..SEEDS {
                    let f = speckle(seed, sigma, uv);
                    let truth = colour(&exact, &f);
                    let square =
                        |set: &Wavelengths| ((colour(set, &f) - truth).length() / truth.length()).powi(2);
                    squares += square(&full) / SEEDS as f64;
                    halved += square(&half) / SEEDS as f64;
                }
                let [rms, half] = [squares, halved].map(f64::sqrt);
                eprintln!(
                    "{tolerance:e} at |(u,v)| = {uv}: {} nodes, {rms:.1e}; half, {half:.1e}",
                    sets.needed(uv)
                );
                assert!(rms <= tolerance, "{tolerance} at {uv}: {rms}");
                if uv > 0.3 {
                    // Otherwise the count would be too high.
                    assert!(half > tolerance, "{tolerance} at {uv}: {half}");
                }
            }
        }
    }
}
