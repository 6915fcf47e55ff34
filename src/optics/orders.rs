//! Colours through repeats: the wavelengths of the sum, and their weights.
//!
//! Along the ray of a pair of directions the response of n copies is H(q) D²(q), with the response H of one period and
//! D² = |S|²/n², S = Σ_{m<n} e^{2πimc}, c = q|u|T. With many copies D² is a row of needles at the orders c = j, each of
//! area 1/n, and a comb that resolves them would grow with n. But |S|² = Σ_{|l|<n} (n − |l|) e^{2πilc}, so
//!
//!   ∫ H D² dc = Σ_l (n − |l|)/n² Ĥ(l)
//!
//! needs H's transform Ĥ at whole lags l only, and H has none beyond L periods: one of the patch itself, m|v|T_y/(|u|T_x) from the
//! other axis' factor, a few from the colour functions. Where L ≤ n, weights that repeat every period do exactly that. At
//! c = j + r/M with an even M ≥ 2L they are the discrete transform of (n − |l|)/n² over |l| ≤ M/2:
//!
//!   1/n − M/4n² at the orders (r = 0),   1/(M n² sin²(πr/M)) at odd r,   0 at even r.
//!
//! So a period takes 1 + M/2 wavelengths however many copies there are. Where n is much larger than L, the orders alone do
//! (Poisson's sum formula); where it is smaller, every r/M under D² itself, with M ≥ n + L − 1.

use super::coherence::periodic_factor;
use super::color::xyz_to_linear_srgb;
use super::quadrature::{SPAN, Wavelengths, density_table};
use super::spectrum::{Illuminant, LONGEST, SHORTEST};
use crate::error::{Error, Remedy, Result};
use glam::{DVec2, DVec3};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use std::f64::consts::PI;

/// Entries of [`ColourFunctions`]: ten to each of the CIE tables', within the row length of every device.
const COLOUR_ENTRIES: usize = 4096;
/// Largest error in the cut-off of the colour functions.
const COLOUR_TOLERANCE: f64 = 1e-2;
/// Smallest lag of all copies together \[µm\]: a smaller one makes no phase at any visible wavelength.
const LEAST_LAG: f64 = 1e-3;

/// Colour functions as a density over wavenumbers, and their lag.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourFunctions {
    /// XYZ per unit of wavenumber \[µm\] at equal steps from 1/780 nm to 1/380 nm, ends included.
    pub densities: Vec<DVec3>,
    /// Lag beyond which the colour functions have little energy \[µm\].
    pub lag: f64,
}

impl ColourFunctions {
    /// Returns the colour functions of `illuminant`, for a relative error of the colour of `tolerance`.
    pub fn new(illuminant: &Illuminant, tolerance: f64) -> Self {
        let densities = density_table(illuminant, COLOUR_ENTRIES);
        // The faint lags contribute as much to a dark direction as the strong ones.
        let lag = lag_of(&densities, tolerance.min(COLOUR_TOLERANCE));
        Self { densities, lag }
    }

    /// Returns the density at `q` \[µm⁻¹\] \[µm\]; 0 outside the visible range.
    pub fn at(&self, q: f64) -> DVec3 {
        let last = self.densities.len() - 1;
        let place = (q - 1.0 / LONGEST) / SPAN * last as f64;
        if !(0.0..=last as f64).contains(&place) {
            return DVec3::ZERO;
        }
        let left = (place as usize).min(last - 1);
        self.densities[left].lerp(self.densities[left + 1], place - left as f64)
    }
}

/// Returns the lag \[µm\] beyond which the transform of `densities` has less than the part `tolerance` of its amplitude (root of energies).
/// The displayed linear sRGB of the transform must also be below half of that part of its value at 0 everywhere beyond: toward the specular
/// direction a sum in steps of 1/lag errs by the two aliases beside it, and red, green and blue are differences of X, Y and Z. Spikes of a
/// lamp vary faster than daylight.
fn lag_of(densities: &[DVec3], tolerance: f64) -> f64 {
    /// Zeros behind the colour functions: lags become finer than one period of the visible range.
    const PADDING: usize = 4;
    let size = PADDING * densities.len();
    let transform = FftPlanner::new().plan_fft_forward(size);
    let energies = |colour: &dyn Fn(DVec3) -> DVec3| {
        let mut energies = vec![0.0; size / 2];
        for component in 0..3 {
            let mut line: Vec<Complex64> =
                densities.iter().map(|d| Complex64::from(colour(*d)[component])).collect();
            line.resize(size, Complex64::ZERO);
            transform.process(&mut line);
            energies.iter_mut().zip(&line).for_each(|(e, c)| *e += c.norm_sqr());
        }
        energies
    };
    let (xyz, rgb) = (energies(&|d| d), energies(&xyz_to_linear_srgb));
    let allowed = xyz.iter().sum::<f64>() * tolerance.powi(2);
    let alias = rgb[0] * (0.5 * tolerance).powi(2);
    let mut beyond = 0.0;
    let kept = xyz.iter().zip(&rgb).rposition(|(xyz, rgb)| {
        beyond += xyz;
        beyond > allowed || *rgb > alias
    });
    let step = SPAN / (densities.len() - 1) as f64;
    (kept.unwrap_or(0) + 1) as f64 / (size as f64 * step)
}

/// Largest number of wavelengths of a colour.
const MAX_WAVELENGTHS: f64 = 20_000.0;

/// Finite grating of `copies` of a patch with sides `period` \[µm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeats {
    /// Copies along x and y.
    pub copies: [u32; 2],
    /// T_x, T_y \[µm\].
    pub period: [f64; 2],
}

/// Sample positions of the response of one patch within each period along a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pattern {
    /// Only the order itself.
    Orders,
    /// The order, and odd multiples of 1/n for this even number n of parts.
    Tails(u64),
    /// All multiples of 1/n for this number n of parts.
    Every(u64),
}

impl Pattern {
    /// Returns the number of wavelengths of a period.
    fn per_period(self) -> u64 {
        match self {
            Self::Orders => 1,
            Self::Tails(parts) => 1 + parts / 2,
            Self::Every(parts) => parts,
        }
    }

    /// Returns the position of sample `index` within a period, from 0 to 1.
    fn share(self, index: u64) -> f64 {
        match self {
            Self::Orders => 0.0,
            Self::Tails(_) if index == 0 => 0.0,
            Self::Tails(parts) => (2 * index - 1) as f64 / parts as f64,
            Self::Every(parts) => index as f64 / parts as f64,
        }
    }

    /// Returns the number of the first wavelength at `periods` or beyond.
    fn first_from(self, periods: f64) -> u64 {
        let rest = periods - periods.floor();
        let within = match self {
            Self::Orders => rest.ceil(),
            Self::Tails(_) if rest == 0.0 => 0.0,
            Self::Tails(parts) => ((rest * parts as f64 + 1.0) / 2.0).ceil(),
            Self::Every(parts) => (rest * parts as f64).ceil(),
        };
        periods as u64 * self.per_period() + within as u64
    }
}

/// Wavelengths along a ray, by their positions in each period.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PeriodSampling {
    /// Axis whose periods are counted.
    axis: usize,
    /// Periods that the ray crosses per wavenumber: |u| T_x or |v| T_y \[µm\].
    periods: f64,
    /// Sample positions in each period.
    pattern: Pattern,
}

impl PeriodSampling {
    /// Returns the number of wavelengths over the visible range, on average.
    fn count(&self) -> f64 {
        SPAN * self.periods * self.pattern.per_period() as f64
    }

    /// Returns each wavenumber with its index within the period.
    fn places(&self) -> impl Iterator<Item = (f64, u64)> {
        let Self { periods, pattern, .. } = *self;
        let per_period = pattern.per_period();
        (pattern.first_from(periods / LONGEST)..pattern.first_from(periods / SHORTEST)).map(move |step| {
            let index = step % per_period;
            (((step / per_period) as f64 + pattern.share(index)) / periods, index)
        })
    }
}

impl Repeats {
    /// Returns the σ of a Gaussian window with the same unit in the shader: 4πσ² = |peak|²/A = n m T_x T_y \[µm\].
    pub fn sigma(&self) -> f64 {
        let [n, m] = self.copies.map(f64::from);
        (n * m * self.period[0] * self.period[1] / (4.0 * PI)).sqrt()
    }

    /// Returns |S_x|²|S_y|²/(n² m²) at the frequency f = (u,v)/λ \[µm⁻¹\]: 1 at the orders.
    pub fn factor(&self, frequency: DVec2) -> f64 {
        (0..2).map(|axis| self.factor_along(axis, frequency[axis])).product()
    }

    fn factor_along(&self, axis: usize, frequency: f64) -> f64 {
        // Subtracting the nearest whole number of periods is exact, so that no more digits cancel.
        let cycles = frequency * self.period[axis];
        let n = self.copies[axis];
        periodic_factor(n, 2.0 * PI * (cycles - cycles.round())).norm_sqr() / f64::from(n).powi(2)
    }

    /// Returns the sampling along (u, v) against colour functions of lag `colour_lag` \[µm\], for a relative error of about `tolerance`.
    /// Twin of `sampling` in `shaders/repeats.glsl`.
    fn sampling(&self, uv: DVec2, colour_lag: f64, tolerance: f64) -> PeriodSampling {
        let n = self.copies.map(f64::from);
        let lag = [0, 1].map(|axis| n[axis] * uv[axis].abs() * self.period[axis]);
        let axis = usize::from(lag[1] > lag[0]); // the sharper one
        let periods = lag[axis].max(LEAST_LAG) / n[axis];
        let others = (lag[1 - axis] + colour_lag) / periods;
        let pattern = if others <= tolerance * n[axis] {
            Pattern::Orders
        } else if others + 1.0 <= n[axis] {
            // The patch itself has a lag of one period.
            Pattern::Tails(2 * (others + 1.0).ceil() as u64)
        } else {
            Pattern::Every((others + n[axis]).ceil() as u64)
        };
        PeriodSampling { axis, periods, pattern }
    }

    /// Returns an upper bound of the number of wavelengths of any direction, against colour functions of lag `colour_lag` \[µm\].
    pub fn most_wavelengths(&self, colour_lag: f64) -> f64 {
        // A period takes at most three wavelengths beside those for the other axis and the colours, or `n` more under [`Pattern::Every`];
        // |(u, v)| ≤ 2.
        let [x, y] = [0, 1].map(|axis| f64::from(self.copies[axis]) * self.period[axis]);
        SPAN * (6.0 * self.period[0].max(self.period[1]) + colour_lag + 2.0 * x.hypot(y))
    }

    /// Returns the largest number of wavelengths of a colour.
    pub fn limit(&self) -> f64 {
        MAX_WAVELENGTHS
    }

    /// Returns the number of wavelengths of a colour along (u, v), for a relative error of about `tolerance`.
    pub fn count(&self, uv: DVec2, colours: &ColourFunctions, tolerance: f64) -> f64 {
        self.sampling(uv, colours.lag, tolerance).count()
    }

    /// Fails for more wavelengths than a colour may take.
    ///
    /// # Errors
    /// Too many wavelengths; names both numbers.
    pub fn check(&self, count: f64) -> Result<()> {
        if count <= MAX_WAVELENGTHS {
            return Ok(());
        }
        let [n, m] = self.copies;
        Err(Error::limit(
            format!(
                "the colour of one direction would take {count:.0} wavelengths through {n} × {m} repeats, the limit is \
                 {MAX_WAVELENGTHS}; single wavelengths have none"
            ),
            Remedy::FewerRepeats,
        ))
    }

    /// Returns the wavelengths of a colour along (u, v), for a relative error of about `tolerance`. Their weights contain the factors of
    /// both axes, so that the response of one period gives that of all.
    pub fn wavelengths(&self, uv: DVec2, colours: &ColourFunctions, tolerance: f64) -> Wavelengths {
        let sampling = self.sampling(uv, colours.lag, tolerance);
        let other = 1 - sampling.axis;
        let (wavenumbers, weights) = sampling
            .places()
            .map(|(q, index)| {
                let weight = self.weight(sampling.axis, sampling.pattern, index) / sampling.periods;
                (q, colours.at(q) * (weight * self.factor_along(other, uv[other] * q)))
            })
            .unzip();
        Wavelengths { wavenumbers, weights }
    }

    /// Returns the weight of number `index` of `pattern` along `axis`, in periods.
    fn weight(&self, axis: usize, pattern: Pattern, index: u64) -> f64 {
        let n = f64::from(self.copies[axis]);
        let share = pattern.share(index);
        match pattern {
            Pattern::Orders => 1.0 / n,
            Pattern::Tails(parts) if index == 0 => 1.0 / n - parts as f64 / (4.0 * n * n),
            Pattern::Tails(parts) => 1.0 / (parts as f64 * (n * (PI * share).sin()).powi(2)),
            Pattern::Every(parts) => self.factor_along(axis, share / self.period[axis]) / parts as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::coherence::Coherence;
    use crate::optics::geometry::{Pair, direction};
    use crate::optics::reference::Reference;
    use crate::surface::synth::{Spec, SurfaceKind, generate};

    #[test]
    fn the_factor_is_the_sum_over_the_copies_also_beside_an_order() {
        let repeats = Repeats { copies: [40, 1], period: [2.5, 1.0] };
        for order in [0.0, 1.0, 13.0] {
            for offset in [0.0, 1e-10, -1e-10, 1e-6, 3e-3, 0.3] {
                let f = (order + offset / (2.0 * PI)) / 2.5;
                // Sum around the order, in terms that are known exactly.
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

    /// A direction through copies of a blaze, whose colour is known.
    struct Lit {
        pair: Pair,
        repeats: Repeats,
        /// Reference of one copy.
        one: Reference,
        /// Colour by the reference of all copies, which resolves every lag.
        truth: DVec3,
    }

    impl Lit {
        fn new(copies: [u32; 2], phi: f64) -> Self {
            let spec = Spec {
                patch: Some([20.0, 2.0]),
                pixel_size: Some([0.095, 0.095]),
                ..Spec::new(SurfaceKind::Blaze)
            };
            let field = generate(&spec).unwrap();
            let pair = Pair::new(direction(70.0, 0.0), direction(10.0, phi));
            let [exact, one] = [copies, [1, 1]]
                .map(|copies| Reference::new(&field, Coherence::Repeats(copies), [1, 1], 1.5));
            let truth = exact.cosine_weighted_xyz(&pair, &Illuminant::D65).unwrap();
            Self { pair, repeats: Repeats { copies, period: field.patch_size() }, one, truth }
        }

        /// Returns the relative deviation of the colour from the reference, and the wavelengths that it takes and their pattern; each is `spoil` times the right one.
        fn deviation(&self, tolerance: f64, spoil: f64) -> (f64, usize, Pattern) {
            let Self { pair, repeats, one, truth } = self;
            let uv = pair.uvw().truncate();
            let colours = ColourFunctions::new(&Illuminant::D65, tolerance);
            let wavelengths = repeats.wavelengths(uv, &colours, tolerance);
            // A of n copies is n times that of one, and |S|² is n² D².
            let sum = wavelengths
                .integral(|wavelength| one.cosine_weighted_spectrum(pair, spoil / wavelength, 0.0, 1)[0])
                * f64::from(repeats.copies[0] * repeats.copies[1]);
            let pattern = repeats.sampling(uv, colours.lag, tolerance).pattern;
            ((sum - *truth).length() / truth.length(), wavelengths.len(), pattern)
        }
    }

    #[test]
    fn every_pattern_gives_the_colour_of_the_reference() {
        let mut seen = [0; 3];
        for copies in [[1, 1], [3, 3], [30, 1], [30, 4], [300, 1], [3000, 1], [40, 40], [2, 300]] {
            for phi in [0.0, 35.0, 178.0] {
                let lit = Lit::new(copies, phi);
                for tolerance in [1e-2, 1e-3] {
                    let (error, count, pattern) = lit.deviation(tolerance, 1.0);
                    eprintln!("{copies:?} at {phi}, {tolerance:e}: {error:.1e} with {count} as {pattern:?}");
                    assert!(error <= tolerance, "{copies:?} at {phi}: {error:e} as {pattern:?}");
                    assert!(count < 200, "{copies:?} at {phi}: {count} wavelengths");
                    seen[match pattern {
                        Pattern::Orders => 0,
                        Pattern::Tails(_) => 1,
                        Pattern::Every(_) => 2,
                    }] += 1;
                }
            }
        }
        let lit = Lit::new([30, 4], 35.0);
        for tolerance in [1e-2, 1e-3] {
            assert!(lit.deviation(tolerance, 1.01).0 > tolerance, "wavelengths a hundredth off");
        }
        assert!(seen.iter().all(|&n| n > 3), "{seen:?}");
    }

    #[test]
    fn wavelengths_follow_the_blunter_axis_and_the_lamp_and_not_the_number_of_copies() {
        let needed = |copies, uv: [f64; 2], lag| {
            Repeats { copies, period: [20.0, 20.0] }.sampling(DVec2::from_array(uv), lag, 1e-4).count()
        };
        assert_eq!(needed([100, 1], [0.8, 0.1], 15.0), needed([9000, 1], [0.8, 0.1], 15.0));
        assert!(needed([100, 50], [0.8, 0.1], 15.0) > 2.0 * needed([100, 1], [0.8, 0.1], 15.0));
        assert!(needed([100, 1], [0.8, 0.1], 150.0) > 2.5 * needed([100, 1], [0.8, 0.1], 15.0));
        // In the specular direction only the colour functions vary.
        assert!((needed([9000, 9000], [0.0, 0.0], 15.0) - SPAN * 15.0).abs() < 1.0);
    }

    #[test]
    fn no_direction_takes_more_wavelengths_than_the_most() {
        for (copies, period) in
            [([1, 1], [5.0, 5.0]), ([3, 7], [20.0, 2.0]), ([40, 40], [65.0, 3.0]), ([1, 900], [2.0, 2.0])]
        {
            let repeats = Repeats { copies, period };
            let most = repeats.most_wavelengths(15.0);
            let mut largest: f64 = 0.0;
            for step in 0..4000 {
                let (r, phi) = (2.0 * f64::from(step % 40) / 39.0, f64::from(step / 40) * PI / 50.0);
                let uv = DVec2::from_angle(phi) * r;
                largest = largest.max(repeats.sampling(uv, 15.0, 1e-2).count());
            }
            assert!(largest <= most, "{copies:?}: {largest} {most}");
            // With one long row of copies, orders alone are summed, which the bound does not know; nor does it know that the
            // sharper axis leaves little to the other.
            assert!(copies == [1, 900] || largest > most / 16.0, "{copies:?}: {largest} {most}");
        }
    }

    #[test]
    fn a_lamp_of_spikes_asks_for_longer_lags_than_daylight() {
        let lag = |illuminant: &Illuminant| ColourFunctions::new(illuminant, 5e-3).lag;
        let row = |nm: u32| {
            let spike = (f64::from(nm) - 546.0) / 2.0;
            format!("{nm},{}\n", 0.1 + 5.0 * (-0.5 * spike * spike).exp())
        };
        let text = format!("wavelength,power\n{}", (380..=780).map(row).collect::<String>());
        let spiky = Illuminant::Table(crate::optics::spectrum::SpectralTable::parse(&text).unwrap().into());
        assert!((5.0..15.0).contains(&lag(&Illuminant::E)), "{}", lag(&Illuminant::E));
        assert!((15.0..30.0).contains(&lag(&Illuminant::D65)), "{}", lag(&Illuminant::D65));
        assert!(lag(&spiky) > 50.0, "{}", lag(&spiky));
    }
}
