//! Colours through repeats: wavelengths at the orders instead of wavelengths that resolve them.
//!
//! Along the ray of a pair of directions the response of n copies is H(q) D²(q), with the response H of one period and
//! D² = |S|²/n², S = Σ_{m<n} e^{2πimc}, c = q|u|T. With many copies D² is a row of needles at the orders c = j, each of
//! area 1/n, and a comb that resolves them needs n|u|T nodes per unit of q. But |S|² = Σ_{|l|<n} (n − |l|) e^{2πilc}, so
//!
//!   ∫ H D² dc = Σ_l (n − |l|)/n² Ĥ(l),   and   (1/n) Σ_j H(j) = (1/n) Σ_l Ĥ(l)   (Poisson's sum formula),
//!
//! where Ĥ(l) is H's transform at a lag of l periods. The two differ by Σ |l|/n² Ĥ(l): as little as the lags of H are
//! short against n periods. One period holds no lag beyond 1, and nothing at 1; what has longer ones is the other axis'
//! factor, m|v|T_y in µm of lag, and the colour functions.

use super::coherence::periodic_factor;
use super::quadrature::{Nodes, SPAN, density};
use super::spectrum::{Illuminant, LONGEST, SHORTEST};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Lags of the colour functions \[µm\]: twelve nodes over the span resolve them, and the jagged daylight twice as many.
const COLOUR_LAG: f64 = 24.0 / SPAN;
/// Nodes of a comb beyond what the lags ask for: the colour functions' own.
const BASE: f64 = 24.0;

/// Exactly `copies` periods of a patch of sides `period` \[µm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeats {
    /// Copies along x and y.
    pub copies: [u32; 2],
    /// T_x, T_y \[µm\].
    pub period: [f64; 2],
}

/// Where along a ray to ask for the response of one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// A comb of this many nodes, which resolves every lag.
    Comb(usize),
    /// The orders of this axis.
    Orders(usize),
}

impl Repeats {
    /// |S_x|²|S_y|²/(n² m²) at the frequency f = (u,v)/λ \[µm⁻¹\]: 1 at the orders.
    pub fn factor(&self, frequency: DVec2) -> f64 {
        (0..2).map(|axis| self.factor_along(axis, frequency[axis])).product()
    }

    fn factor_along(&self, axis: usize, frequency: f64) -> f64 {
        // In periods, less the nearest whole number, which is exact: nothing cancels that was not lost before.
        let cycles = frequency * self.period[axis];
        let n = self.copies[axis];
        periodic_factor(n, 2.0 * PI * (cycles - cycles.round())).norm_sqr() / f64::from(n).powi(2)
    }

    /// How to integrate over the wavelengths along (u, v) for a relative error of about `tolerance`.
    pub fn sampling(&self, uv: DVec2, tolerance: f64) -> Sampling {
        let lag = [0, 1].map(|i| f64::from(self.copies[i]) * uv[i].abs() * self.period[i]);
        let sharp = usize::from(lag[1] > lag[0]);
        let others = lag[1 - sharp] + COLOUR_LAG;
        if others <= tolerance * lag[sharp] {
            return Sampling::Orders(sharp);
        }
        // A trapezoid rule of step δq is exact for lags below 1/δq.
        Sampling::Comb((BASE + SPAN * (lag[0] + lag[1] + COLOUR_LAG)).ceil() as usize)
    }

    /// Wavenumbers \[µm⁻¹\] of the orders of `axis` along (u, v), and the XYZ weight of the response of one period there,
    /// the other axis' factor included.
    pub fn orders(&self, axis: usize, uv: DVec2, illuminant: &Illuminant) -> Vec<(f64, DVec3)> {
        // Orders are 1/(|u| T) apart.
        let periods = uv[axis].abs() * self.period[axis];
        let (first, last) = ((periods / LONGEST).ceil() as u64, (periods / SHORTEST).floor() as u64);
        let area = 1.0 / (f64::from(self.copies[axis]) * periods);
        (first.max(1)..=last)
            .map(|j| {
                let q = j as f64 / periods;
                let other = self.factor_along(1 - axis, uv[1 - axis] * q);
                (q, density(illuminant, q) * (area * other))
            })
            .collect()
    }

    /// Wavenumbers of a comb of `nodes` along (u, v), and the XYZ weight of the response of one period there, both factors
    /// included.
    pub fn comb(&self, nodes: &Nodes, uv: DVec2) -> Vec<(f64, DVec3)> {
        let q = |j: usize| nodes.first + j as f64 * nodes.step;
        nodes.weights.iter().enumerate().map(|(j, w)| (q(j), *w * self.factor(uv * q(j)))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::coherence::Coherence;
    use crate::optics::geometry::{Pair, direction};
    use crate::optics::reference::Reference;
    use crate::surface::synth::{Kind, Spec, generate};

    #[test]
    fn the_factor_is_the_sum_over_the_copies_also_beside_an_order() {
        let repeats = Repeats { copies: [40, 1], period: [2.5, 1.0] };
        for order in [0.0, 1.0, 13.0] {
            for offset in [0.0, 1e-10, -1e-10, 1e-6, 3e-3, 0.3] {
                let f = (order + offset / (2.0 * PI)) / 2.5;
                // The sum around the order, where its terms are known exactly.
                let phase: f64 = offset;
                let (re, im) = (0..40).fold((0.0, 0.0), |(re, im), m| {
                    let (sin, cos) = (f64::from(m) * phase).sin_cos();
                    (re + cos, im + sin)
                });
                let expected = (re * re + im * im) / 1600.0;
                let factor = repeats.factor(DVec2::new(f, 0.7));
                assert!((factor - expected).abs() < 1e-10, "{order} {offset}: {factor} {expected}");
            }
        }
    }

    /// Relative deviation of the colour by the orders from the reference, which resolves every lag.
    fn deviation(copies: u32, spoil: f64) -> f64 {
        let spec =
            Spec { patch: Some([20.0, 1.0]), pixel_size: Some([0.095, 0.5]), ..Spec::new(Kind::Blaze) };
        let field = generate(&spec).unwrap();
        let pair = Pair::new(direction(70.0, 0.0), direction(10.0, 0.0));
        let repeats = Repeats { copies: [copies, 1], period: field.patch_size() };
        let uv = pair.uvw().truncate();
        let exact = Reference::new(&field, Coherence::Repeats([copies, 1]), [1, 1], 1.5);
        let truth = exact.cosine_weighted_xyz(&pair, &Illuminant::D65).unwrap();
        let one = Reference::new(&field, Coherence::Repeats([1, 1]), [1, 1], 1.5);
        // A of n copies is n times that of one, and |S|² is n² D².
        let sum: DVec3 = repeats
            .orders(0, uv, &Illuminant::D65)
            .into_iter()
            .map(|(q, w)| w * one.cosine_weighted_spectrum(&pair, q * spoil, 0.0, 1)[0])
            .sum::<DVec3>()
            * f64::from(copies);
        (sum - truth).length() / truth.length()
    }

    #[test]
    fn the_orders_carry_the_colour_and_the_better_the_more_copies() {
        let [few, many] = [30, 300].map(|n| deviation(n, 1.0));
        assert!(few < 2e-2 && many < 2e-3 && many < few, "{few:e} {many:e}");
        assert!(deviation(300, 1.01) > 1e-2, "wavelengths a hundredth off");
    }

    #[test]
    fn many_copies_along_one_axis_are_taken_at_their_orders_and_others_by_a_comb() {
        let uv = DVec2::new(0.8, 0.0);
        let by = |copies, uv| Repeats { copies, period: [20.0, 20.0] }.sampling(uv, 6e-3);
        assert_eq!(by([1000, 1], uv), Sampling::Orders(0));
        assert_eq!(by([1, 1000], DVec2::new(0.0, 0.8)), Sampling::Orders(1));
        assert!(matches!(by([3, 3], uv), Sampling::Comb(n) if n < 200));
        assert!(
            matches!(by([1000, 1], DVec2::new(1e-4, 0.0)), Sampling::Comb(_)),
            "near the mirror direction"
        );
        assert!(matches!(by([1000, 1000], DVec2::new(0.8, 0.5)), Sampling::Comb(_)), "two rows of needles");
    }
}
