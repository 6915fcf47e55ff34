//! What must hold for every surface: zeros below the horizon and out of band, reciprocity, offsets, scale.

use crate::plain::{MIRROR, amplitude, flat, rough, scaled, toward, view_at, with_heights};
use diffract::internals::optics::coherence::Coherence;
use diffract::internals::optics::geometry::{Pair, direction};
use diffract::internals::optics::reference::Reference;
use diffract::internals::surface::HeightField;
use glam::{DVec2, DVec3};

const WINDOW: Coherence = Coherence::Gaussian { length: 4.0 };
const WINDOWS: [Coherence; 2] = [WINDOW, Coherence::Repeats([3, 2])];
const GLASS: f64 = 1.5;

fn surface() -> HeightField {
    rough([20, 17], [0.09, 0.08], 0.4)
}

/// A few pairs on all sides of the normal, with their wavelengths \[µm\].
fn pairs() -> Vec<(Pair, f64)> {
    let angles = [
        [0.0, 0.0, 10.0, 30.0],
        [35.0, 20.0, 50.0, 170.0],
        [80.0, 0.0, 80.0, 180.0],
        [60.0, 300.0, 5.0, 90.0],
    ];
    let pairs = angles.map(|[t, p, s, q]| Pair::new(toward(t, p), toward(s, q)));
    pairs.into_iter().flat_map(|pair| [0.38, 0.55, 0.78].map(|wavelength| (pair, wavelength))).collect()
}

/// The largest relative difference between f of one surface at some pair and f of another, `change` saying at which pair
/// and wavelength and under which window the other one is asked.
fn difference(
    one: &HeightField,
    other: &HeightField,
    change: impl Fn(Pair, f64, Coherence) -> (Pair, f64, Coherence),
) -> f64 {
    let mut worst = 0.0f64;
    for coherence in WINDOWS {
        for (pair, wavelength) in pairs() {
            let before = Reference::new(one, coherence, [1, 1], GLASS).brdf(&pair, wavelength);
            let (pair, wavelength, coherence) = change(pair, wavelength, coherence);
            let after = Reference::new(other, coherence, [1, 1], GLASS).brdf(&pair, wavelength);
            worst = worst.max((after / before - 1.0).abs());
        }
    }
    worst
}

#[test]
fn a_constant_offset_of_the_heights_changes_nothing() {
    let one = surface();
    for offset in [-3.0, 0.1, 50.0] {
        let other = with_heights(&one, |c, r| one.row(r)[c] + offset);
        let deviation = difference(&one, &other, |pair, wavelength, coherence| (pair, wavelength, coherence));
        // The offset rounds each height by up to 4e-15 µm, a phase of 1e-13.
        assert!(deviation < 1e-10, "{offset}: {deviation}");
    }
    let deviation =
        difference(&one, &scaled(&one, 1.01), |pair, wavelength, coherence| (pair, wavelength, coherence));
    assert!(deviation > 1e-3, "one percent more height must show: {deviation}");
}

#[test]
fn light_and_viewer_may_change_places() {
    let one = surface();
    let exchange =
        |pair: Pair, wavelength, coherence| (Pair::new(pair.view, pair.light), wavelength, coherence);
    let deviation = difference(&one, &one, exchange);
    assert!(deviation < 1e-12, "{deviation}");
    // f·cos θ_i, which the renderer shades with, is not symmetric.
    let pair = Pair::new(toward(35.0, 20.0), toward(50.0, 170.0));
    let reference = Reference::new(&one, WINDOW, [1, 1], GLASS);
    let shaded = |pair: &Pair| reference.cosine_weighted_spectrum(pair, 2.0, 0.0, 1)[0];
    let ratio = shaded(&pair) / shaded(&Pair::new(pair.view, pair.light));
    assert!((ratio - pair.light.z / pair.view.z).abs() < 1e-12);
}

#[test]
fn scaling_every_length_together_leaves_the_brdf_as_it_is() {
    let one = surface();
    for scale in [0.1, 7.0] {
        let [dx, dy] = one.pixel_size();
        let heights = one.heights().iter().map(|h| h * scale).collect();
        let other = HeightField::new(one.columns(), one.rows(), [dx * scale, dy * scale], heights).unwrap();
        let larger = |coherence| match coherence {
            Coherence::Gaussian { length } => Coherence::Gaussian { length: length * scale },
            repeats => repeats,
        };
        let deviation = difference(&one, &other, |pair, wavelength, coherence| {
            (pair, wavelength * scale, larger(coherence))
        });
        // Rounding alone, in directions down to 1e-4 of the brightest amplitude.
        assert!(deviation < 1e-10, "{scale}: {deviation}");
        let forgotten =
            difference(&one, &other, |pair, wavelength, coherence| (pair, wavelength, larger(coherence)));
        assert!(forgotten > 0.1, "the wavelength must matter: {forgotten}");
    }
}

/// The largest difference between `count` wavenumbers at once and one call each at wavenumbers `stretch` times as far
/// apart, relative to the largest of them.
fn spectrum_deviation(coherence: Coherence, windows: [u32; 2], count: usize, stretch: f64) -> f64 {
    let field = rough([11, 18], [0.09, 0.08], 0.4);
    let reference = Reference::new(&field, coherence, windows, GLASS);
    let pair = Pair::new(toward(30.0, 10.0), toward(40.0, 150.0));
    let (first, step) = (1.0 / 0.78, 1.35 / count as f64);
    let together = reference.cosine_weighted_spectrum(&pair, first, step, count);
    assert_eq!(together.len(), count);
    let largest = together.iter().copied().fold(0.0, f64::max);
    let errors = together.iter().enumerate().map(|(j, value)| {
        let wavelength = 1.0 / (first + j as f64 * step * stretch);
        (value - reference.brdf(&pair, wavelength) * pair.light.z).abs() / largest
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn many_wavelengths_at_once_are_the_single_ones() {
    for coherence in WINDOWS {
        for (windows, count) in [([1, 1], 5), ([1, 1], 513), ([1, 1], 1300), ([2, 3], 600)] {
            let deviation = spectrum_deviation(coherence, windows, count, 1.0);
            // A phase that is turned on 511 times rounds 511 times.
            assert!(deviation < 1e-12, "{coherence:?}, {count}: {deviation}");
        }
        assert!(spectrum_deviation(coherence, [1, 1], 600, 1.001) > 1e-6);
    }
}

#[test]
fn nothing_is_reflected_below_the_horizon_or_in_it() {
    let field = surface();
    for coherence in WINDOWS {
        let reference = Reference::new(&field, coherence, [1, 1], GLASS);
        for (light, view) in [
            (90.0, 0.0),
            (0.0, 90.0),
            (90.0, 90.0),
            (91.0, 10.0),
            (10.0, 91.0),
            (180.0, 180.0),
            (-90.0, 20.0),
        ] {
            for phi in [0.0, 90.0, 123.0, 180.0] {
                let pair = Pair::new(direction(light, 0.0), direction(view, phi));
                assert_eq!(reference.brdf(&pair, 0.5), 0.0, "{light}, {view}, {phi}");
                assert_eq!(reference.cosine_weighted_spectrum(&pair, 1.3, 0.1, 3), [0.0; 3]);
            }
        }
        // Just above it, even with the light opposite, where 1 + ω_i·ω_r and w both vanish.
        for delta in [1e-3, 1e-6, 1e-9, 1e-12] {
            for phi in [0.0, 90.0, 180.0] {
                let pair = Pair::new(direction(90.0 - delta, 0.0), direction(90.0 - delta, phi));
                let value = reference.brdf(&pair, 0.5);
                assert!(pair.above_horizon() && value.is_finite() && value >= 0.0, "{delta}, {phi}: {value}");
            }
        }
    }
}

#[test]
fn beyond_the_samples_the_response_is_zero_and_not_the_periodic_copy() {
    // 0.4 µm apart at 0.5 µm: |u| ≤ 0.625 is in band, and the copy of the mirror's peak lies at u = 1.25.
    let mirror = flat([8, 8], [0.4, 0.4]);
    let light = toward(50.0, 0.0);
    for coherence in [Coherence::Repeats([2, 2]), Coherence::Gaussian { length: 4.0 }] {
        let reference = Reference::new(&mirror, coherence, [1, 1], GLASS);
        for axis in [DVec2::X, DVec2::Y] {
            let light = if axis.x > 0.0 { light } else { toward(50.0, 90.0) };
            let at = |u: f64| Pair::new(light, view_at(light, -u * axis).unwrap());
            assert_eq!(reference.brdf(&at(1.25), 0.5), 0.0);
            assert_eq!(reference.brdf(&at(0.6251), 0.5), 0.0);
            assert_ne!(reference.brdf(&at(0.6249), 0.5), 0.0);
            assert_ne!(reference.brdf(&at(0.0), 0.5), 0.0);
        }
    }
    // A sum that knows no band sees the mirror's peak there.
    let sum = |u: f64| amplitude(&mirror, DVec3::new(u, 0.0, -1.2), 0.5, [0..8, 0..8], |_, _| 1.0).norm_sqr();
    assert!((sum(1.25) / sum(0.0) - 1.0).abs() < 1e-9);
}

#[test]
fn in_one_spectrum_only_the_long_wavelengths_may_be_in_band() {
    let field = rough([8, 8], [0.25, 0.25], 0.3);
    let reference = Reference::new(&field, WINDOW, [1, 1], MIRROR);
    // u = −1.2: in band up to q = 2/1.2 = 1.667 /µm.
    let light = toward(50.0, 0.0);
    let pair = Pair::new(light, view_at(light, DVec2::new(-1.2, 0.0)).unwrap());
    let spectrum = reference.cosine_weighted_spectrum(&pair, 1.3, 0.1, 10);
    let lit: Vec<bool> = spectrum.iter().map(|f| *f != 0.0).collect();
    assert_eq!(lit, (0..10).map(|j| 1.3 + 0.1 * f64::from(j) <= 2.0 / 1.2).collect::<Vec<_>>());
}
