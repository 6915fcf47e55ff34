//! Wavelengths that stand where a ray happens to cross the lines of a grid: evenly, but for every direction at other places.

use super::quadrature::{Density, Rule, SPAN, catmull_rom};
use super::spectrum::{Illuminant, LONGEST};
use glam::DVec3;
use rayon::prelude::*;

/// Weights of nodes that stand where a ray happens to cross a grid, evenly but for every direction at other places: the colour
/// functions seen through a Catmull–Rom kernel as wide as the nodes' distance, which a direction reads where its nodes stand.
#[derive(Clone, Debug, PartialEq)]
pub struct Sliding {
    /// The wavenumbers that the eye sees enough of \[µm⁻¹\]; nodes reach one distance beyond.
    pub range: [f64; 2],
    /// The wavenumbers that the rows cover \[µm⁻¹\].
    pub columns: [f64; 2],
    /// Distances of nodes, growing by a constant factor: the smallest, and log₂ of the factor.
    pub steps: (f64, f64),
    /// XYZ weights per distance of the nodes, at [`Sliding::COLUMNS`] places: `[step][place]`.
    pub rows: Vec<Vec<DVec3>>,
}

impl Sliding {
    /// Places of a row: as many as every Vulkan device holds in a row.
    pub const COLUMNS: usize = 4096;

    /// For nodes from `shortest` to `longest` \[µm⁻¹\] apart, without the ends of the visible range, where the eye sees nothing beside aliases of
    /// `level` (see [`super::quadrature::Comb`]).
    pub fn new(illuminant: &Illuminant, level: f64, shortest: f64, longest: f64) -> Self {
        /// Octaves between the rows: a kernel at most 4.5 % too wide or too narrow changes nothing that shows.
        const OCTAVES: f64 = 0.125;
        /// What of the colour functions ends the range, as the square root of their part of the peak and in units of the level: at a
        /// tolerance of 1e-2 a thousandth of the peak, of which both ends hold 1e-4 of a white.
        const LEAST_SEEN: f64 = 3.0;
        /// Points of a kernel's width 4.
        const POINTS: usize = 64;
        let density = Density::new(illuminant, level);
        let fine = SPAN / density.colour.len() as f64;
        let peak = density.colour.iter().map(|c| c.length()).fold(0.0, f64::max);
        let seen = |c: &DVec3| (c.length() / peak).sqrt() >= LEAST_SEEN * level;
        let first = density.colour.iter().position(seen).unwrap_or(0);
        let last = density.colour.iter().rposition(seen).map_or(density.colour.len(), |i| i + 1);
        let range = [first, last].map(|i| 1.0 / LONGEST + i as f64 * fine);
        let columns = [range[0] - longest, range[1] + longest];
        let mut sum = DVec3::ZERO;
        let integral: Vec<DVec3> = std::iter::once(DVec3::ZERO)
            .chain(density.colour.iter().map(|c| {
                sum += *c;
                sum
            }))
            .collect();
        // ∫ of the colour functions up to a wavenumber.
        let up_to = |q: f64| {
            let place = ((q - 1.0 / LONGEST) / fine).clamp(0.0, density.colour.len() as f64);
            let left = (place as usize).min(density.colour.len() - 1);
            integral[left].lerp(integral[left + 1], place - left as f64)
        };
        let count = ((longest / shortest).log2() / OCTAVES).ceil().max(0.0) as usize + 1;
        let row = |index: usize| -> Vec<DVec3> {
            let step = shortest * (index as f64 * OCTAVES).exp2();
            let width = 4.0 / POINTS as f64;
            let kernel: Vec<(f64, f64)> = (0..POINTS)
                .map(|i| {
                    let x = (i as f64 + 0.5) * width - 2.0;
                    // The weight of the node at −⌊x⌋ for a point at the fraction of x.
                    let node = (1.0 - x.floor()) as usize;
                    (x * step, catmull_rom(x - x.floor())[node])
                })
                .collect();
            (0..Self::COLUMNS)
                .map(|column| {
                    let q =
                        columns[0] + (columns[1] - columns[0]) * (column as f64 + 0.5) / Self::COLUMNS as f64;
                    let half = width * step / 2.0;
                    let mut before = up_to(q - 2.0 * step);
                    kernel
                        .iter()
                        .map(|(offset, weight)| {
                            let after = up_to(q + offset + half);
                            let part = (after - before) * *weight;
                            before = after;
                            part
                        })
                        .sum::<DVec3>()
                        / step
                })
                .collect()
        };
        Self {
            range,
            columns,
            steps: (shortest, OCTAVES),
            rows: (0..count).into_par_iter().map(row).collect(),
        }
    }

    /// Nodes over the visible range for the colour functions: half as many again as a comb takes, which begins and ends with the
    /// range.
    pub fn fewest(rule: &Rule) -> f64 {
        1.5 * rule.base
    }

    /// L/σ of lines 1/L apart for nodes of aliases of `level` through a Gaussian of standard deviation σ.
    ///
    /// A ray at the angle α to the lines' normal meets them 1/(L cos α) apart, and the response has the spectrum of the window's
    /// autocorrelation, exp(−x²/4σ²), so that L cos 45° decides. Evenly placed nodes have none beyond those that the response
    /// takes, as a comb has near the mirror direction, and reach a little further instead.
    pub fn across(level: f64) -> f64 {
        /// With it a test finds the tolerance kept over all angles, and broken by less than three times across the diagonal.
        const PART: f64 = 0.7;
        2f64.sqrt() * 2.0 * (1.0 / (PART * level)).ln().max(0.0).sqrt()
    }

    /// Numbers m of the nodes m/`per` that a direction sums over, up to the wavenumber `largest`.
    pub fn nodes(&self, per: f64, largest: f64) -> std::ops::RangeInclusive<i64> {
        let last = (self.range[1] * per + 1.0).min(largest * per);
        (self.range[0] * per - 1.0).ceil() as i64..=last.floor() as i64
    }

    /// Row and place of a node at `q` \[µm⁻¹\] among nodes `step` apart.
    pub fn place(&self, step: f64, q: f64) -> [usize; 2] {
        let row = ((step / self.steps.0).log2() / self.steps.1).round();
        let place = (q - self.columns[0]) / (self.columns[1] - self.columns[0]) * Self::COLUMNS as f64;
        [
            row.clamp(0.0, self.rows.len() as f64 - 1.0) as usize,
            place.clamp(0.0, Self::COLUMNS as f64 - 1.0) as usize,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::super::quadrature::tests::{colour, speckle};
    use super::super::quadrature::{Comb, Nodes};
    use super::*;

    #[test]
    fn sliding_nodes_reach_the_tolerance_over_all_angles_to_the_lines_and_half_of_them_do_not() {
        const SEEDS: u64 = 12;
        const ANGLES: u32 = 8;
        let sigma = 16.25;
        let exact: Comb = Nodes::trapezoid(&Illuminant::D65, 4001).into();
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let rule = Rule::gaussian(&Illuminant::D65, sigma, tolerance);
            let across = Sliding::across(rule.level) * sigma;
            let from = Sliding::fewest(&rule) / (SPAN * across);
            let sliding =
                Sliding::new(&Illuminant::D65, rule.level, 1.0 / (2.0 * across), 1.0 / (from * across));
            for uv in [from * 2f64.sqrt(), 2.0 * from, 1.0] {
                let square = |per: f64, seed: u64| {
                    let f = speckle(seed, sigma, uv);
                    let truth = colour(exact.clone(), &f);
                    let sum: DVec3 = sliding
                        .nodes(per, f64::INFINITY)
                        .map(|m| {
                            let q = m as f64 / per;
                            let [row, place] = sliding.place(1.0 / per, q);
                            sliding.rows[row][place] * (f(q) / per)
                        })
                        .sum();
                    ((sum - truth).length() / truth.length()).powi(2)
                };
                let rms = |part: f64| {
                    let each = (0..ANGLES).map(|k| {
                        let angle = (f64::from(k) + 0.5) / f64::from(ANGLES) * std::f64::consts::FRAC_PI_4;
                        let per = part * uv * angle.cos() * across;
                        (0..SEEDS).map(|seed| square(per, seed)).sum::<f64>() / SEEDS as f64
                    });
                    let each: Vec<f64> = each.collect();
                    let worst = each.iter().fold(0.0f64, |a, b| a.max(*b)).sqrt();
                    ((each.iter().sum::<f64>() / f64::from(ANGLES)).sqrt(), worst)
                };
                let ((full, worst), (half, _)) = (rms(1.0), rms(0.5));
                eprintln!(
                    "{tolerance:e} at |(u,v)| = {uv:.2}: {full:.1e}, worst angle {worst:.1e}; half, {half:.1e}"
                );
                assert!(full <= tolerance && half > tolerance, "{tolerance} at {uv}: {full}, half {half}");
                assert!(worst <= 3.0 * tolerance, "{tolerance} at {uv}: {worst} across the diagonal");
            }
        }
    }

    #[test]
    fn sliding_weights_give_a_flat_response_the_white_of_the_light() {
        let sliding = Sliding::new(&Illuminant::D65, 1e-2, 0.005, 0.1);
        for per in [10.0, 12.3, 40.7, 200.0] {
            let weight = |m: i64| {
                let [row, place] = sliding.place(1.0 / per, m as f64 / per);
                sliding.rows[row][place] / per
            };
            let white: DVec3 = sliding.nodes(per, f64::INFINITY).map(weight).sum();
            assert!((white - DVec3::new(0.9504, 1.0, 1.0889)).length() < 2e-3, "{per}: {white}");
        }
    }
}
