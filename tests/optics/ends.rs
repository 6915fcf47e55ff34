//! Properties of the optics over the whole range of each number, three draws in four from its ends.

use diffract::internals::optics::coherence::{Coherence, WindowedAxis};
use diffract::internals::optics::color::{Tone, display};
use diffract::internals::optics::geometry::{Pair, direction};
use diffract::internals::optics::orders::Repeats;
use diffract::internals::optics::quadrature::Wavelengths;
use diffract::internals::optics::reference::Reference;
use diffract::internals::optics::spectrum::Illuminant;
use diffract::internals::random::Random;
use diffract::internals::spectra::amplitude::expansion::optimal::Optimal;
use diffract::internals::spectra::amplitude::expansion::taylor::Taylor;
use diffract::internals::spectra::amplitude::expansion::{Expansion, HeightScale};
use diffract::internals::spectra::amplitude::layers::largest_z;
use diffract::internals::spectra::amplitude::texels::{HALF_UNIT, Texels};
use diffract::internals::surface::HeightField;
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use rustfft::num_complex::Complex64;
use std::sync::LazyLock;

/// One of `ends` three times in four, else between the first and the last.
fn ended(ends: &'static [f64]) -> impl Strategy<Value = f64> {
    prop_oneof![3 => prop::sample::select(ends), 1 => ends[0]..ends[ends.len() - 1]]
}

/// A polar angle \[degrees\]: the normal, grazing, the horizon, below it.
fn polar() -> impl Strategy<Value = f64> {
    ended(&[0.0, 1e-9, 30.0, 89.0, 89.99, 89.9999, 89.999_999, 89.999_999_999, 90.0, 90.000_001, 91.0])
}

/// Light and view: across, in retro-reflection, at the mirror direction and hardly beside either.
fn pair() -> impl Strategy<Value = Pair> {
    let free = (polar(), polar(), ended(&[0.0, 1e-7, 90.0, 180.0 - 1e-7, 180.0, 360.0]));
    let equal = (polar(), ended(&[-1e-7, 0.0, 1e-7]), prop::sample::select(&[0.0, 180.0][..]));
    let equal = equal.prop_map(|(theta, off, turn)| (theta, theta + off, turn));
    prop_oneof![free, equal].prop_map(|(i, r, turn)| Pair::new(direction(i, 20.0), direction(r, 20.0 + turn)))
}

fn coherence() -> impl Strategy<Value = Coherence> {
    let copies = || prop::sample::select(&[1u32, 2, 3, 40, 1000][..]);
    prop_oneof![
        ended(&[0.1, 0.4, 2.0, 65.0, 1e4]).prop_map(|length| Coherence::Gaussian { length }),
        (copies(), copies()).prop_map(|(n, m)| Coherence::Repeats([n, m])),
    ]
}

/// A rough surface of 1 × 1 to 8 × 8 samples 1 nm to 10 µm apart, flat to 10 µm high.
fn field() -> impl Strategy<Value = HeightField> {
    let side = || prop::sample::select(&[1usize, 1, 2, 5, 8][..]);
    let spacing = || ended(&[1e-3, 0.095, 0.1, 1.0, 10.0]);
    let range = ended(&[0.0, 1e-4, 0.3, 10.0]);
    ((side(), side()), (spacing(), spacing()), range, any::<u64>()).prop_map(|(size, d, range, seed)| {
        let mut random = Random::new(seed);
        let heights = (0..size.0 * size.1).map(|_| range * random.share()).collect();
        HeightField::new(size.0, size.1, [d.0, d.1], heights).unwrap()
    })
}

/// What |P| is at most: every sample in phase.
fn most(field: &HeightField, coherence: &Coherence) -> f64 {
    let size = [field.columns(), field.rows()];
    let along = |i: usize| {
        let axis = WindowedAxis { samples: size[i], spacing: field.pixel_size()[i], shift: 0.0 };
        let weights = match coherence {
            Coherence::Gaussian { length } => axis.gaussian(length / 4.0).weights(0.0),
            Coherence::Repeats(copies) => axis.repeat_weights(copies[i], 0.0),
        };
        axis.spacing * weights.iter().map(|w| w.norm()).sum::<f64>()
    };
    along(0) * along(1)
}

/// Whether a sum over all copies takes no longer than a test may.
fn quick(field: &HeightField, coherence: &Coherence) -> bool {
    const COPIES: f64 = 3e4;
    coherence.sigma().is_none_or(|sigma| field.patch_size().iter().all(|t| 14.0 * sigma / t < COPIES))
}

const WAVELENGTHS: [f64; 5] = [0.38, 0.380_001, 0.55, 0.779_999, 0.78];

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn the_direct_sum_is_a_reciprocal_number_and_dark_below_the_horizon(
        field in field(), coherence in coherence(), pair in pair(), wavelength in prop::sample::select(&WAVELENGTHS[..]),
    ) {
        prop_assume!(quick(&field, &coherence));
        let reference = Reference::new(&field, coherence, [1, 1], 1.5);
        let there = reference.brdf(&pair, wavelength);
        let back = reference.brdf(&Pair::new(pair.view, pair.light), wavelength);
        prop_assert!(there.is_finite() && there >= 0.0, "{there}");
        prop_assert!((there - back).abs() <= 1e-12 * there, "{there} {back}");
        if !pair.above_horizon() {
            prop_assert_eq!(there, 0.0);
        }
        let power = reference.power(pair.uvw(), 1.0 / wavelength, 0.0, 1)[0];
        prop_assert!(power <= most(&field, &coherence).powi(2) * (1.0 + 1e-9), "{power}");
    }

    #[test]
    fn a_constant_on_all_heights_changes_nothing(
        field in field(), coherence in coherence(), pair in pair(), offset in ended(&[-10.0, -1e-4, 0.1, 10.0]),
    ) {
        prop_assume!(quick(&field, &coherence));
        let heights = field.heights().iter().map(|h| h + offset).collect();
        let lifted = HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights).unwrap();
        let power = |field| Reference::new(field, coherence, [1, 1], 1.5).power(pair.uvw(), 1.0 / 0.38, 0.0, 1)[0];
        // Phases of 660 rad are known to 1e-13.
        let allowed = 1e-11 * most(&field, &coherence).powi(2);
        prop_assert!((power(&field) - power(&lifted)).abs() <= allowed);
    }

    #[test]
    fn the_periodic_factor_is_one_at_every_order_and_never_more(
        copies in prop::sample::select(&[[1u32, 1], [1, 1000], [2, 3], [1000, 1000]][..]),
        orders in (-9999i32..10_000, -9i32..10), off in ended(&[-1e-10, 0.0, 1e-10]), free in (-50.0..50.0f64, -50.0..50.0f64),
    ) {
        let repeats = Repeats { copies, period: [2.5, 0.7] };
        // φ = 2π j + `off`.
        let cycles = [orders.0, orders.1].map(|j| f64::from(j) + off / std::f64::consts::TAU);
        let at = repeats.factor(DVec2::new(cycles[0] / 2.5, cycles[1] / 0.7));
        prop_assert!((at - 1.0).abs() < 1e-9, "{at}");
        let anywhere = repeats.factor(DVec2::new(free.0, free.1));
        prop_assert!((0.0..=1.0 + 1e-9).contains(&anywhere), "{anywhere}");
    }

    #[test]
    fn exposures_of_forty_stops_either_way_are_displayed(
        rgb in prop::array::uniform3(ended(&[-1e30, -1.0, -1e-30, 0.0, 1e-38, 1e-3, 1.0, 65_504.0, 1e30])),
        exposure in ended(&[-40.0, -39.5, 0.0, 39.5, 40.0]),
    ) {
        let rgb = DVec3::from(rgb);
        for tone in Tone::ALL {
            let mapped = tone.map(rgb * exposure.exp2());
            let within = mapped.min_element() >= 0.0 && mapped.max_element() <= 1.0;
            prop_assert!(mapped.is_finite() && within, "{mapped} by {tone:?}");
        }
        let grey = DVec3::splat(rgb.x);
        let codes = [exposure, exposure + 1.0].map(|ev| display(grey, ev));
        prop_assert!(codes.iter().all(|c| c[0] == c[1] && c[1] == c[2]), "{codes:?}");
        prop_assert!(codes[0][0] <= codes[1][0] || rgb.x < 0.0, "{codes:?}");
    }

    #[test]
    fn sixteen_bits_hold_what_they_say_they_hold(
        size in ended(&[0.0, 1e-45, 1e-12, 1.4e-11, 1.5e-8, 1e-4, 1.0, 15.99, 15.992_187_5, 16.0, 1e30]), negative in any::<bool>(),
    ) {
        let value = if negative { -size as f32 } else { size as f32 };
        let fits = Texels::fit_halves(&[value]);
        prop_assert_eq!(fits, value.abs() <= 65_504.0 * HALF_UNIT);
        let texels = Texels::of(true, vec![value]);
        if fits {
            // Half a unit in the last place: 2⁻¹¹ of what is normal, 2⁻²⁵ below.
            let allowed = (f64::from(value.abs()) * 0.5f64.powi(11)).max(0.5f64.powi(25) * f64::from(HALF_UNIT));
            prop_assert!(texels.are_finite());
            prop_assert!((f64::from(texels.at(0)) - f64::from(value)).abs() <= allowed, "{value} {}", texels.at(0));
        }
    }

}

/// Heights of a range, decomposed once.
static OPTIMAL: LazyLock<Vec<(f64, Optimal)>> = LazyLock::new(|| {
    let of = |range: f64| {
        let heights = (0..4096).map(|i| range * f64::from(i) / 4095.0).collect();
        let field = HeightField::new(64, 64, [0.1, 0.1], heights).unwrap();
        (HeightScale::of(&field).half_range, Optimal::new(&field, [0.0, largest_z(0.38)]))
    };
    [0.0, 1e-4, 0.3, 3.0].map(of).into()
});

/// |e^{izat} − Σ_{n<terms} c_n(z) b_n(t)|.
fn left(family: &dyn Expansion, half_range: f64, z: f64, t: f64, terms: usize) -> f64 {
    let mut c = vec![Complex64::ZERO; terms];
    family.coefficients(z, &mut c);
    let sum: Complex64 = c.iter().enumerate().map(|(n, c)| c * family.basis(n, t)).sum();
    (Complex64::cis(z * half_range * t) - sum).norm()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn the_taylor_series_keeps_its_bound_from_no_terms_to_128(
        half_range in ended(&[0.0, 5e-5, 0.05, 0.15, 0.5, 5.0]), z in ended(&[0.0, 1e-12, 1e-6, 0.1, 16.5, 33.069]),
        t in ended(&[-1.0, -1e-9, 0.0, 1.0]), terms in prop_oneof![prop::sample::select(&[0usize, 1, 2, 37, 127, 128][..]), 0usize..129],
    ) {
        /// Of f64, in sums of terms of any size.
        const ROUNDOFF: f64 = 1e-14;
        let family = Taylor { half_range };
        let (bound, rounding) = (family.truncation_bound(z, terms), family.rounding_bound(z, ROUNDOFF));
        let error = left(&family, half_range, z, t, terms);
        prop_assert!(bound >= 0.0 && rounding.is_finite() && error.is_finite(), "{bound} {rounding} {error}");
        prop_assert!(error <= bound * (1.0 + 1e-9) + rounding, "{error} > {bound} + {rounding}");
    }

    #[test]
    fn the_optimal_expansion_keeps_its_bound_and_is_exact_where_nothing_is_scattered(
        which in 0usize..4, z in ended(&[0.0, 1e-12, 1e-6, 0.1, 16.5, 33.069]), t in ended(&[-1.0, -1e-9, 0.0, 1.0]),
        terms in prop_oneof![prop::sample::select(&[1usize, 2, 3, 8][..]), 1usize..40],
    ) {
        let (half_range, optimal) = &OPTIMAL[which];
        let terms = terms.min(optimal.most_terms());
        let error = left(optimal, *half_range, z, t, terms);
        // The bound is measured at entries of the functions' table, which is linear between 16 384 of them.
        let between = (33.07 * half_range / 16_384.0).powi(2);
        prop_assert!(error <= 1.05 * optimal.truncation_bound(33.07, terms) + between + 1e-9, "{error}");
        // In proportion to what heights of that range do at all at that z, times what an end may be worse than the mean.
        prop_assert!(error <= 4.0 * z * half_range + 1e-15, "{error} at {z}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(32) })]

    #[test]
    fn colours_are_numbers(field in field(), length in ended(&[0.1, 2.0, 10.0]), pair in pair()) {
        let coherence = Coherence::Gaussian { length };
        prop_assume!(quick(&field, &coherence));
        let reference = Reference::new(&field, coherence, [1, 1], 1.5);
        for illuminant in [Illuminant::D65, Illuminant::A, Illuminant::E] {
            let xyz = reference.cosine_weighted_xyz(&pair, &illuminant).unwrap();
            prop_assert!(xyz.is_finite() && xyz.y >= -1e-6 * xyz.length(), "{xyz}");
        }
    }

    #[test]
    fn any_number_of_wavelengths_has_weights_that_make_white(
        count in prop_oneof![prop::sample::select(&[4usize, 5, 81, 400, 401][..]), 4usize..4097],
    ) {
        for illuminant in [Illuminant::D65, Illuminant::A, Illuminant::E] {
            let nodes = Wavelengths::catmull_rom(&illuminant, count);
            let white: DVec3 = nodes.weights.iter().sum();
            prop_assert!(nodes.weights.len() == count && nodes.weights.iter().all(|w| w.is_finite()));
            prop_assert!((white.y - 1.0).abs() < 1e-3, "{white}");
        }
    }
}
