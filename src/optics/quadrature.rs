//! Wavelengths to sum over: nodes uniform in the wavenumber q = 1/λ, because along a ray from the mirror direction the
//! response varies with q at a rate that the window fixes, and weights that hold the colour functions.
//!
//! In q the response |P(q·(u,v))|² has the spectrum of the window's autocorrelation, so a count of nodes is a formula:
//! as many as the ray crosses correlation lengths (plus what the colour functions need), see [`Rule`]. Where the eye sees
//! little, fewer do, see [`Comb`].

use super::spectrum::{Illuminant, LONGEST, SHORTEST};
use glam::DVec3;

/// Span of wavenumbers of the colour integral, 1/λ_min − 1/λ_max \[µm⁻¹\].
pub const SPAN: f64 = 1.0 / SHORTEST - 1.0 / LONGEST;

/// Nodes q_j = `first` + j·`step` \[µm⁻¹\] with the XYZ weight of each: Σ f(q_j) weight_j ≈ ∫ f S (x̄,ȳ,z̄) dλ / ∫ S ȳ dλ.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes {
    /// First wavenumber \[µm⁻¹\].
    pub first: f64,
    /// Distance between nodes \[µm⁻¹\].
    pub step: f64,
    /// XYZ weights.
    pub weights: Vec<DVec3>,
}

impl Nodes {
    /// The trapezoid rule with `count` ≥ 2 nodes over 380–780 nm.
    pub fn trapezoid(illuminant: &Illuminant, count: usize) -> Self {
        let colour = ColourDensity::new(illuminant);
        let (first, step) = comb(count);
        let weights = (0..count)
            .map(|j| {
                let end = if j == 0 || j == count - 1 { 0.5 } else { 1.0 };
                colour.at(first + j as f64 * step) * (step * end)
            })
            .collect();
        Self { first, step, weights }
    }

    /// Product integration with `count` ≥ 4 nodes: each weight is the colour function's integral against a
    /// Catmull–Rom kernel, so the jagged daylight spectrum costs no nodes and only the response has to be resolved.
    pub fn catmull_rom(illuminant: &Illuminant, count: usize) -> Self {
        // 0.02 nm at the short end, 0.1 nm at the long one: the tables are linear over 1 nm.
        const FINE: usize = 8192;
        /// Steps per node, so that each sees its whole kernel.
        const PER_NODE: usize = 16;
        let fine = FINE.max(PER_NODE * count);
        let colour = ColourDensity::new(illuminant);
        let (first, step) = comb(count);
        let fine_step = SPAN / fine as f64;
        let mut weights = vec![DVec3::ZERO; count];
        for i in 0..fine {
            let q = first + (i as f64 + 0.5) * fine_step;
            let density = colour.at(q) * fine_step;
            let place = (q - first) / step;
            let left = place.floor().min(count as f64 - 2.0);
            for (offset, share) in (-1..=2).zip(catmull_rom(place - left)) {
                // Beyond the ends the response is extended by its end value.
                let j = (left as i64 + offset).clamp(0, count as i64 - 1) as usize;
                weights[j] += density * share;
            }
        }
        Self { first, step, weights }
    }
}

/// First node and distance of `count` nodes over the whole span, ends included.
fn comb(count: usize) -> (f64, f64) {
    (1.0 / LONGEST, SPAN / (count as f64 - 1.0))
}

/// Weights of the four neighbours at −1, 0, 1, 2 of a point at `t` ∈ \[0, 1\] (Catmull & Rom 1974).
pub(super) fn catmull_rom(t: f64) -> [f64; 4] {
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

    /// S (x̄,ȳ,z̄)/∫Sȳdλ · |dλ/dq| at `q` \[µm⁻¹\].
    fn at(&self, q: f64) -> DVec3 {
        const NM_PER_UM: f64 = 1000.0;
        // Held inside the tables against the rounding of the last node.
        let wavelength = (1.0 / q).clamp(SHORTEST, LONGEST) * NM_PER_UM;
        self.illuminant.weight(wavelength, self.luminance) * (NM_PER_UM / (q * q))
    }
}

/// S (x̄,ȳ,z̄)/∫Sȳdλ · |dλ/dq| \[µm\] at `count` ≥ 2 equal steps of wavenumber over 380–780 nm, ends included: the XYZ per unit
/// of wavenumber of a response of 1.
pub fn density_table(illuminant: &Illuminant, count: usize) -> Vec<DVec3> {
    let colour = ColourDensity::new(illuminant);
    let (first, step) = comb(count);
    (0..count).map(|i| colour.at(first + i as f64 * step)).collect()
}

/// Nodes that stand closer where the eye sees more, with the XYZ weight of each.
///
/// A comb of local step δq along a ray at |(u,v)| aliases what the window's autocorrelation exp(−x²/4σ²) has beyond
/// x = 1/(|(u,v)| δq). An alias of level ε/√s does where the colour functions are s times as large as at their peak, which
/// gives the density of nodes √ln(√s/ε)·2σ|(u,v)|, and none where √s < ε: the ends of the visible range. The square root
/// keeps directions right whose light lies at one end.
#[derive(Clone, Debug, PartialEq)]
pub struct Comb {
    /// Wavenumbers, growing \[µm⁻¹\].
    pub wavenumbers: Vec<f64>,
    /// XYZ weights.
    pub weights: Vec<DVec3>,
}

impl Comb {
    /// The trapezoid rule with `count` ≥ 2 nodes at equal steps of the wavelength over 380–780 nm, as renderers usually sum.
    pub fn even_wavelengths(illuminant: &Illuminant, count: usize) -> Self {
        const NM_PER_UM: f64 = 1000.0;
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
}

impl From<Nodes> for Comb {
    fn from(nodes: Nodes) -> Self {
        let wavenumbers = (0..nodes.weights.len()).map(|j| nodes.first + j as f64 * nodes.step).collect();
        Self { wavenumbers, weights: nodes.weights }
    }
}

/// The density of a [`Comb`]'s nodes over the visible range, on fine steps.
pub(super) struct Density {
    /// Colour functions times the step, at each step's middle.
    pub(super) colour: Vec<DVec3>,
    /// Part of the nodes before the end of each step, growing from 0 to 1; one entry more than steps.
    part: Vec<f64>,
    /// ∫ √ln(√s/ε) dq \[µm⁻¹\].
    integral: f64,
}

impl Density {
    /// For aliases of level `level` at the peak of the colour functions.
    pub(super) fn new(illuminant: &Illuminant, level: f64) -> Self {
        /// 0.02 nm at the short end, 0.1 nm at the long one: the tables are linear over 1 nm.
        const FINE: usize = 8192;
        let functions = ColourDensity::new(illuminant);
        let step = SPAN / FINE as f64;
        let colour: Vec<DVec3> =
            (0..FINE).map(|i| functions.at(1.0 / LONGEST + (i as f64 + 0.5) * step) * step).collect();
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

    /// The comb of `count` ≥ 4 nodes: each weight is the colour functions' integral against a Catmull–Rom kernel in the
    /// nodes' own coordinate.
    fn comb(&self, count: usize) -> Comb {
        let step = SPAN / self.colour.len() as f64;
        let last = (count - 1) as f64;
        let wavenumber = |j: usize| {
            let target = j as f64 / last;
            let right = self.part.partition_point(|p| *p < target).clamp(1, self.part.len() - 1);
            let (before, after) = (self.part[right - 1], self.part[right]);
            let share = if after > before { (target - before) / (after - before) } else { 0.0 };
            1.0 / LONGEST + (right as f64 - 1.0 + share) * step
        };
        let mut weights = vec![DVec3::ZERO; count];
        for (colour, ends) in self.colour.iter().zip(self.part.windows(2)) {
            let place = (ends[0] + ends[1]) / 2.0 * last;
            let left = place.floor().min(last - 1.0);
            for (offset, share) in (-1..=2).zip(catmull_rom(place - left)) {
                // Beyond the ends the response is extended by its end value.
                let j = (left as i64 + offset).clamp(0, count as i64 - 1) as usize;
                weights[j] += *colour * share;
            }
        }
        Comb { wavenumbers: (0..count).map(wavenumber).collect(), weights }
    }
}

/// How many nodes of a [`Comb`] a direction needs for an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Level of aliases at the peak of the colour functions.
    pub level: f64,
    /// Nodes for the colour functions alone, in the mirror direction.
    pub base: f64,
    /// Nodes per unit of |(u, v)|.
    pub per_uv: f64,
}

impl Rule {
    /// The rule for a relative colour error `tolerance` under `illuminant` through a Gaussian window of standard deviation
    /// `sigma` \[µm\].
    ///
    /// The many correlation lengths of a direction average an alias down by two, measured on speckle, the
    /// directions that speckle makes darker than their surroundings included. The base count is where Catmull–Rom weights
    /// reach the tolerance on a smooth response.
    pub fn gaussian(illuminant: &Illuminant, sigma: f64, tolerance: f64) -> Self {
        /// How many times larger than the error of the colour the level of its aliases may be.
        const AVERAGED: f64 = 2.0;
        // Above one half the logarithm would ask for no nodes at all.
        let level = (AVERAGED * tolerance).clamp(1e-8, 0.5);
        let per_uv = 2.0 * sigma * Density::new(illuminant, level).integral;
        Self { level, base: 5.0 + 4.0 * (1.0 / level).log10(), per_uv }
    }

    /// Nodes for a direction at |(u, v)| = `uv`.
    pub fn count(&self, uv: f64) -> usize {
        (self.base + self.per_uv * uv).ceil() as usize
    }
}

/// Combs of growing counts, so that each direction takes the smallest that suffices.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder {
    /// Combs in order of count.
    pub levels: Vec<Comb>,
}

impl Ladder {
    /// Ratio of the counts of neighbouring combs: a direction takes 2 % more nodes than it needs on average.
    pub const RATIO: f64 = 1.04;

    /// Combs from `rule`'s base to its count at |(u,v)| = 2.
    pub fn new(illuminant: &Illuminant, rule: &Rule) -> Self {
        let most = rule.count(2.0);
        let density = Density::new(illuminant, rule.level);
        let mut levels = Vec::new();
        let mut count = rule.count(0.0).max(4);
        loop {
            levels.push(density.comb(count));
            if count >= most {
                return Self { levels };
            }
            count = ((count as f64 * Self::RATIO).ceil() as usize).min(most);
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::random::Random;

    /// A speckled response along a ray: |Σ a_m e^{i2πq·uv·x_m}|², random phases, with the x_m spread as the energy g² of
    /// the Gaussian window, a normal distribution of standard deviation σ/√2.
    pub fn speckle(seed: u64, sigma: f64, uv: f64) -> impl Fn(f64) -> f64 {
        let mut random = Random::new(seed);
        let mut uniform = || random.share();
        let spots: Vec<(f64, f64)> = (0..200)
            .map(|_| {
                let r = (-2.0 * (1.0 - uniform()).ln()).sqrt();
                (
                    sigma / 2f64.sqrt() * r * (2.0 * std::f64::consts::PI * uniform()).cos(),
                    uniform() * std::f64::consts::TAU,
                )
            })
            .collect();
        move |q| {
            let (re, im) = spots.iter().fold((0.0, 0.0), |(re, im), (x, a)| {
                let (s, c) = (2.0 * std::f64::consts::PI * q * uv * x + a).sin_cos();
                (re + c, im + s)
            });
            (re * re + im * im) / 200.0
        }
    }

    pub fn colour(nodes: impl Into<Comb>, f: &dyn Fn(f64) -> f64) -> DVec3 {
        let comb: Comb = nodes.into();
        comb.weights.iter().zip(&comb.wavenumbers).map(|(w, q)| *w * f(*q)).sum()
    }

    #[test]
    fn both_rules_give_a_flat_response_the_white_of_the_light() {
        let illuminant = Illuminant::D65;
        for nodes in [Nodes::trapezoid(&illuminant, 801), Nodes::catmull_rom(&illuminant, 12)] {
            let white: DVec3 = nodes.weights.iter().sum();
            assert!((white - DVec3::new(0.9504, 1.0, 1.0889)).length() < 4e-4, "{white}");
        }
    }

    #[test]
    fn near_the_mirror_the_weights_stand_in_for_nodes() {
        // A response that varies with the wavelength as slowly as a mirror's: what is left is the jagged daylight.
        let smooth = |q: f64| (q / 2.0).powi(2) * (1.0 + 0.5 * (3.0 * q).sin());
        let truth = colour(Nodes::trapezoid(&Illuminant::D65, 8001), &smooth);
        let error = |nodes: Nodes| (colour(nodes, &smooth) - truth).length() / truth.length();
        let weighted = error(Nodes::catmull_rom(&Illuminant::D65, 12));
        let plain = error(Nodes::trapezoid(&Illuminant::D65, 12));
        eprintln!("12 nodes: Catmull-Rom {weighted:.1e}, trapezoid {plain:.1e}");
        // A tenth of the finest tolerance that is common, and many times better than nodes alone.
        assert!(weighted < 5e-4 && plain > 5.0 * weighted, "{weighted:e} against {plain:e}");
    }

    #[test]
    fn a_comb_gives_a_flat_response_the_white_of_the_light_and_grows() {
        let density = Density::new(&Illuminant::D65, 1e-2);
        let comb = density.comb(20);
        let white: DVec3 = comb.weights.iter().sum();
        assert!((white - DVec3::new(0.9504, 1.0, 1.0889)).length() < 4e-4, "{white}");
        assert!(comb.wavenumbers.is_sorted() && comb.wavenumbers[0] >= 1.0 / LONGEST);
        assert!(comb.wavenumbers[19] <= 1.0 / SHORTEST + 1e-12);
    }

    #[test]
    fn the_rule_s_nodes_reach_its_tolerance_and_half_of_them_do_not() {
        let sigma = 16.25;
        const SEEDS: u64 = 24;
        let exact: Comb = Nodes::trapezoid(&Illuminant::D65, 4001).into();
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let rule = Rule::gaussian(&Illuminant::D65, sigma, tolerance);
            let density = Density::new(&Illuminant::D65, rule.level);
            for uv in [0.0, 0.05, 0.2, 0.4, 0.7, 1.0] {
                let (full, half) = (density.comb(rule.count(uv)), density.comb(rule.count(uv) / 2));
                let (mut squares, mut halved) = (0.0, 0.0);
                for seed in 0..SEEDS {
                    let f = speckle(seed, sigma, uv);
                    let truth = colour(exact.clone(), &f);
                    let square =
                        |comb: &Comb| ((colour(comb.clone(), &f) - truth).length() / truth.length()).powi(2);
                    squares += square(&full) / SEEDS as f64;
                    halved += square(&half) / SEEDS as f64;
                }
                let [rms, half] = [squares, halved].map(f64::sqrt);
                eprintln!(
                    "{tolerance:e} at |(u,v)| = {uv}: {} nodes, {rms:.1e}; half, {half:.1e}",
                    rule.count(uv)
                );
                assert!(rms <= tolerance, "{tolerance} at {uv}: {rms}");
                if uv > 0.3 {
                    // Else the count would be a waste.
                    assert!(half > tolerance, "{tolerance} at {uv}: {half}");
                }
            }
        }
    }
}
