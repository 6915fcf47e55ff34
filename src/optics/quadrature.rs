//! Wavelengths to sum over: nodes uniform in the wavenumber q = 1/λ, because along a ray from the mirror direction the
//! response varies with q at a rate that the window fixes, and weights that hold the colour functions.
//!
//! In q the response |P(q·(u,v))|² has the spectrum of the window's autocorrelation, so a count of nodes is a formula:
//! as many as the ray crosses correlation lengths (plus what the colour functions need), see [`Rule`].

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

    /// S (x̄,ȳ,z̄)/∫Sȳdλ · |dλ/dq| at `q` \[µm⁻¹\].
    fn at(&self, q: f64) -> DVec3 {
        const NM_PER_UM: f64 = 1000.0;
        // Held inside the tables against the rounding of the last node.
        let wavelength = (1.0 / q).clamp(SHORTEST, LONGEST) * NM_PER_UM;
        self.illuminant.weight(wavelength, self.luminance) * (NM_PER_UM / (q * q))
    }
}

/// S (x̄,ȳ,z̄)/∫Sȳdλ · |dλ/dq| at the wavenumber `q` \[µm⁻¹\]: the XYZ of a response that stands at one wavenumber alone.
pub fn density(illuminant: &Illuminant, q: f64) -> DVec3 {
    ColourDensity::new(illuminant).at(q)
}

/// How many nodes a direction needs for an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Nodes for the colour functions alone, in the mirror direction.
    pub base: f64,
    /// Nodes per unit of |(u, v)|.
    pub per_uv: f64,
}

impl Rule {
    /// The rule for a relative colour error `tolerance` through a Gaussian window of standard deviation `sigma` \[µm\].
    ///
    /// The autocorrelation exp(−x²/4σ²) falls to the level ε at X = 2σ √ln(1/ε), and a comb of step δq along the ray
    /// aliases what lies beyond 1/(|(u,v)| δq): N = |(u,v)|·SPAN·X. The many
    /// correlation lengths of a direction average the alias down, which pays for the directions that speckle makes darker
    /// than their surroundings, hence ε = tolerance. The base count is where Catmull–Rom weights reach the
    /// tolerance on a smooth response (12 nodes: 1.1e-4, as the tests print; the ray's own nodes on top).
    pub fn gaussian(sigma: f64, tolerance: f64) -> Self {
        // Above one half the logarithm would ask for no nodes at all.
        let tolerance = tolerance.clamp(1e-8, 0.5);
        let extent = 2.0 * sigma * (1.0 / tolerance).ln().sqrt();
        Self { base: 6.0 + 4.0 * (1.0 / tolerance).log10(), per_uv: SPAN * extent }
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
    pub levels: Vec<Nodes>,
}

impl Ladder {
    /// Ratio of the counts of neighbouring combs: a direction takes 4 % more nodes than it needs on average.
    pub const RATIO: f64 = 1.08;

    /// Combs from `rule`'s base to its count at |(u,v)| = 2.
    pub fn new(illuminant: &Illuminant, rule: &Rule) -> Self {
        let most = rule.count(2.0);
        let mut levels = Vec::new();
        let mut count = rule.count(0.0).max(4);
        loop {
            levels.push(Nodes::catmull_rom(illuminant, count));
            if count >= most {
                return Self { levels };
            }
            count = ((count as f64 * Self::RATIO).ceil() as usize).min(most);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A speckled response along a ray: |Σ a_m e^{i2πq·uv·x_m}|², random phases, with the x_m spread as the energy g² of
    /// the Gaussian window, a normal distribution of standard deviation σ/√2.
    fn speckle(seed: u64, sigma: f64, uv: f64) -> impl Fn(f64) -> f64 {
        let mut state = seed;
        let mut uniform = move || {
            // splitmix64
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        };
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

    fn colour(nodes: &Nodes, f: &dyn Fn(f64) -> f64) -> DVec3 {
        nodes.weights.iter().enumerate().map(|(j, w)| *w * f(nodes.first + j as f64 * nodes.step)).sum()
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
        let truth = colour(&Nodes::trapezoid(&Illuminant::D65, 8001), &smooth);
        let error = |nodes: &Nodes| (colour(nodes, &smooth) - truth).length() / truth.length();
        let weighted = error(&Nodes::catmull_rom(&Illuminant::D65, 12));
        let plain = error(&Nodes::trapezoid(&Illuminant::D65, 12));
        eprintln!("12 nodes: Catmull-Rom {weighted:.1e}, trapezoid {plain:.1e}");
        // A tenth of the finest tolerance that is common, and many times better than nodes alone.
        assert!(weighted < 5e-4 && plain > 5.0 * weighted, "{weighted:e} against {plain:e}");
    }

    #[test]
    fn the_rule_s_nodes_reach_its_tolerance_and_half_of_them_do_not() {
        let sigma = 16.25;
        let exact = Nodes::trapezoid(&Illuminant::D65, 4001);
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let rule = Rule::gaussian(sigma, tolerance);
            for uv in [0.0, 0.05, 0.4, 1.0] {
                let (mut full, mut half) = (0.0, 0.0);
                for seed in 0..12 {
                    let f = speckle(seed, sigma, uv);
                    let truth = colour(&exact, &f);
                    let error = |count: usize| {
                        let nodes = Nodes::catmull_rom(&Illuminant::D65, count);
                        ((colour(&nodes, &f) - truth).length() / truth.length()).powi(2) / 12.0
                    };
                    full += error(rule.count(uv));
                    half += error(rule.count(uv) / 2);
                }
                assert!(full.sqrt() <= tolerance, "{tolerance} at {uv}: {}", full.sqrt());
                if uv > 0.3 {
                    // Else the count would be a waste.
                    assert!(half.sqrt() > tolerance, "{tolerance} at {uv}: {}", half.sqrt());
                }
            }
        }
    }
}
