//! The mirror and the sinusoidal grating, whose response is known.

use crate::plain::{MIRROR, bessel, flat, scaled, surface, swapped, toward, view_at};
use diffract::internals::optics::coherence::Coherence;
use diffract::internals::optics::geometry::Pair;
use diffract::internals::optics::grating;
use diffract::internals::optics::reference::Reference;
use diffract::internals::optics::reflectance::Reflectance;
use diffract::internals::surface::HeightField;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The window of the energy check: σ = 2 µm.
const SMALL: Coherence = Coherence::Gaussian { length: 8.0 };
const SIGMA: f64 = 2.0;
const GREEN: f64 = 0.55;

/// ∫ f cos θ_r dω_r over the view directions near the mirror direction, by the midpoint rule in direction cosines, where
/// cos θ_r dω_r = ds_x ds_y; `weight` of a view is 1 for that, and anything else for another integral.
fn albedo(reference: &Reference, light: DVec3, weight: impl Fn(DVec3) -> f64) -> f64 {
    // The peak is a Gaussian e^(−(kσ)²(u² + v²)), 1/(kσ) = 0.044 wide: a step of a quarter of it is exact to the last
    // digits, and at 0.3 it has fallen to e^(−46).
    const STEP: f64 = 0.01;
    const REACH: i32 = 30;
    let grid = (-REACH..=REACH).flat_map(|j| (-REACH..=REACH).map(move |i| (i, j)));
    let views = grid.filter_map(|(i, j)| view_at(light, DVec2::new(f64::from(i), f64::from(j)) * STEP));
    let f = |view| reference.brdf(&Pair::new(light, view), GREEN) * weight(view);
    views.map(f).sum::<f64>() * STEP * STEP
}

/// How far the albedo of a flat surface of refractive index `ior` is from 1 at the worst of three angles.
fn energy_deviation(ior: impl Into<Reflectance>) -> f64 {
    let mirror = flat([4, 4], [0.1, 0.1]); // 0.1 µm holds |u| ≤ 2 at 0.55 µm
    let reference = Reference::new(&mirror, SMALL, [1, 1], ior);
    let lost = [0.0, 30.0, 45.0].map(|theta| (albedo(&reference, toward(theta, 20.0), |_| 1.0) - 1.0).abs());
    lost.into_iter().fold(0.0, f64::max)
}

#[test]
fn a_perfect_flat_mirror_keeps_all_light() {
    let deviation = energy_deviation(MIRROR);
    // G/w² = 1 holds in the mirror direction only: over a peak of width 0.044 it is off by some 0.044²/cos² θ.
    assert!(deviation < 0.005, "{deviation}");
}

#[test]
fn a_flat_mirror_has_an_albedo_of_1_001_at_30_degrees() {
    let mirror = flat([4, 4], [0.1, 0.1]);
    let reference = Reference::new(&mirror, SMALL, [1, 1], MIRROR);
    // Three digits are stated.
    let kept = albedo(&reference, toward(30.0, 0.0), |_| 1.0);
    assert!((kept - 1.001).abs() < 5e-4, "{kept}");
}

#[test]
fn the_power_of_a_flat_mirror_is_the_window_s() {
    let mirror = flat([4, 4], [0.1, 0.1]);
    let reference = Reference::new(&mirror, SMALL, [1, 1], MIRROR);
    // At θ_i = 0 the prefactor k²G/(4π²Aw²) is 1/(λ² A cos θ_r), and Parseval's theorem makes ∬ |P|²/(λ² A) du dv
    // exactly 1; what is left is the window's cut at 7σ, 2e-11.
    let whole = albedo(&reference, DVec3::Z, |view| view.z);
    assert!((whole - 1.0).abs() < 1e-9, "{whole}");
}

#[test]
fn the_energy_check_fails_for_a_surface_that_takes_4_percent() {
    assert!(energy_deviation(100.0) > 0.005); // R₀ = (99/101)² = 0.961
}

/// f of the flat mirror: P = 2πσ² e^(−(kσ)²(u² + v²)/2), A = πσ², B.12 with R = 1.
fn mirror_brdf(pair: &Pair, wavelength: f64) -> f64 {
    let k = 2.0 * PI / wavelength;
    let uvw = -(pair.light + pair.view);
    let amplitude =
        2.0 * PI * SIGMA.powi(2) * (-(k * SIGMA).powi(2) * uvw.truncate().length_squared() / 2.0).exp();
    let g = (1.0 + pair.light.dot(pair.view)).powi(2) / (pair.light.z * pair.view.z);
    k * k * g / (4.0 * PI * PI * PI * SIGMA.powi(2) * uvw.z * uvw.z) * amplitude * amplitude
}

/// The largest error of f of `field` against the flat mirror's, relative to the peak of each light.
fn mirror_deviation(field: &HeightField) -> f64 {
    let reference = Reference::new(field, SMALL, [1, 1], MIRROR);
    let mut worst = 0.0f64;
    for (light, wavelength) in
        [(toward(0.0, 0.0), 0.4), (toward(50.0, 70.0), 0.55), (toward(75.0, -130.0), 0.7)]
    {
        let peak = mirror_brdf(&Pair::new(light, light * DVec3::new(-1.0, -1.0, 1.0)), wavelength);
        for uv in [[0.0, 0.0], [0.02, 0.0], [0.0, -0.03], [-0.05, 0.01], [0.3, 0.2], [-0.9, 0.4]] {
            let Some(view) = view_at(light, DVec2::from_array(uv)) else { continue };
            let pair = Pair::new(light, view);
            let apart = reference.brdf(&pair, wavelength) - mirror_brdf(&pair, wavelength);
            worst = worst.max(apart.abs() / peak);
        }
    }
    worst
}

#[test]
fn the_brdf_of_a_flat_mirror_is_its_closed_form() {
    let deviation = mirror_deviation(&flat([5, 4], [0.09, 0.08]));
    // The window is cut at 7σ, where g = 2e-11.
    assert!(deviation < 1e-9, "{deviation}");
}

#[test]
fn the_mirror_check_fails_on_a_surface_one_nanometre_rough() {
    assert!(mirror_deviation(&surface([4, 4], [0.08, 0.08], |x, y| 0.001 * (x * y).signum())) > 1e-5);
}

/// A sinusoid of this amplitude and period \[µm\]. k|w|a stays below 3.4, so that the samples, 32 a period, see
/// no order beyond 29 (J₂₉ = 1e-24).
const AMPLITUDE: f64 = 0.1;
const PERIOD: f64 = 2.0;
const PER_PERIOD: usize = 32;

/// `periods` periods of h = a sin(2πx/d), for `axis` = 1 of h = a sin(2πy/d), on pixels that are not square.
fn sinusoid(axis: usize, periods: usize) -> HeightField {
    let fine = PERIOD / PER_PERIOD as f64;
    let (mut samples, mut pixel) = ([4, 4], [0.08, 0.08]);
    samples[axis] = periods * PER_PERIOD;
    pixel[axis] = fine;
    surface(samples, pixel, |x, y| AMPLITUDE * (2.0 * PI * [x, y][axis] / PERIOD).sin())
}

/// The flat mirror's |P|² at its peak, (∬ g)².
fn flat_peak(coherence: &Coherence, patch: [f64; 2]) -> f64 {
    match *coherence {
        Coherence::Gaussian { length } => (2.0 * PI * (length / 4.0).powi(2)).powi(2),
        Coherence::Repeats([n, m]) => (f64::from(n) * f64::from(m) * patch[0] * patch[1]).powi(2),
    }
}

/// The largest error of |P|² at the orders −3 … 3 of a sinusoid along `axis`, relative to the flat mirror's peak:
/// J_m²(k w_m a) at u = m λ/d, v = 0 (along y: v = m λ/d, u = 0), w_m that of each order's own direction.
fn order_deviation(field: &HeightField, axis: usize, coherence: Coherence) -> f64 {
    let reference = Reference::new(field, coherence, [1, 1], MIRROR);
    let peak = flat_peak(&coherence, field.patch_size());
    let (mut worst, mut seen) = (0.0f64, 0);
    // In the plane of the x axis, in that of the y axis, and out of both: conical.
    let lights = [(0.0, 0.0), (30.0, 0.0), (30.0, 180.0), (30.0, 90.0), (45.0, 35.0), (70.0, -100.0)];
    for (theta, phi) in lights {
        let light = toward(theta, phi);
        for wavelength in [0.38, 0.55, 0.78] {
            for order in -3..=3 {
                let mut uv = DVec2::ZERO;
                uv[axis] = f64::from(order) * wavelength / PERIOD;
                let Some(view) = view_at(light, uv) else { continue };
                let w = -(light.z + view.z);
                let share = reference.power(uv.extend(w), 1.0 / wavelength, 0.0, 1)[0] / peak;
                let expected = bessel(order, 2.0 * PI / wavelength * w * AMPLITUDE).powi(2);
                worst = worst.max((share - expected).abs());
                seen += 1;
            }
        }
    }
    assert!(seen > 90, "only {seen} orders leave the surface");
    worst
}

/// Whole periods, and a window of σ = 2d: the next order's amplitude is e^(−(2π·2)²/2) = 5e-35 there.
const GRATING_WINDOWS: [Coherence; 3] =
    [Coherence::Repeats([1, 1]), Coherence::Repeats([5, 4]), Coherence::Gaussian { length: 16.0 }];

#[test]
fn a_sinusoid_sends_the_square_of_a_bessel_function_into_each_order() {
    for axis in [0, 1] {
        for coherence in GRATING_WINDOWS {
            let deviation = order_deviation(&sinusoid(axis, 3), axis, coherence);
            // Rounding alone is left for whole periods, the window's cut at 7σ (2e-11) for the Gaussian.
            assert!(deviation < 1e-9, "along {axis} through {coherence:?}: {deviation}");
        }
    }
}

#[test]
fn the_bessel_check_fails_for_one_percent_more_height_and_for_swapped_axes() {
    for axis in [0, 1] {
        let grating = sinusoid(axis, 3);
        for coherence in GRATING_WINDOWS {
            assert!(order_deviation(&scaled(&grating, 1.01), axis, coherence) > 1e-3);
            assert!(order_deviation(&swapped(&grating), axis, coherence) > 0.1);
        }
    }
}

/// |P|² half way between two orders and at the first order, both relative to the flat mirror's peak, with the order's
/// direction taken from the grating equation.
fn first_order(theta: f64) -> (f64, f64) {
    let field = sinusoid(0, 3);
    let coherence = Coherence::Gaussian { length: 16.0 };
    let reference = Reference::new(&field, coherence, [1, 1], MIRROR);
    let light = toward(theta, 0.0);
    let share = |sin_view: f64| {
        let view = DVec3::new(sin_view, 0.0, (1.0 - sin_view * sin_view).sqrt());
        let power = reference.power(-light - view, 1.0 / GREEN, 0.0, 1)[0];
        power / flat_peak(&coherence, field.patch_size())
    };
    let sines = [0, 1].map(|m| grating::sin_view(GREEN, light.x, PERIOD, m).unwrap());
    (share((sines[0] + sines[1]) / 2.0), share(sines[1]))
}

#[test]
fn the_grating_equation_names_the_directions_that_the_sum_finds_bright() {
    for theta in [-40.0, 0.0, 25.0] {
        let (between, at_order) = first_order(theta);
        // Half an order away the window's transform has fallen to e^(−(π σ/d)²) = e^(−39).
        assert!(at_order > 0.1 && between < 1e-15, "{theta}: {between} between, {at_order} at the order");
    }
}
