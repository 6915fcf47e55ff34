//! The colour integral against an own sum over the CIE's tables, half a nanometre at a time.

use crate::plain::{MIRROR, flat, rough, scaled, toward, view_at};
use diffract::internals::optics::coherence::Coherence;
use diffract::internals::optics::geometry::Pair;
use diffract::internals::optics::reference::Reference;
use diffract::internals::optics::reflectance::Reflectance;
use diffract::internals::optics::spectrum::Illuminant;
use diffract::internals::surface::HeightField;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

const SIGMA: f64 = 2.0;
const WINDOW: Coherence = Coherence::Gaussian { length: 4.0 * SIGMA };

/// The rows of one of the CIE's tables: wavelength \[nm\] and values.
fn table(text: &str) -> Vec<Vec<f64>> {
    text.lines().skip(1).map(|l| l.split(',').map(|cell| cell.trim().parse().unwrap()).collect()).collect()
}

/// The values at `wavelength` \[nm\], linear between rows.
fn at(rows: &[Vec<f64>], wavelength: f64) -> Vec<f64> {
    let above = rows.iter().position(|row| row[0] >= wavelength).unwrap();
    let (low, high) = (&rows[above.saturating_sub(1)], &rows[above]);
    let t = if above == 0 { 1.0 } else { (wavelength - low[0]) / (high[0] - low[0]) };
    low.iter().zip(high).skip(1).map(|(a, b)| (1.0 - t) * a + t * b).collect()
}

/// Wavelengths of the own sum \[nm\] with S (x̄, ȳ, z̄) dλ/∫ S ȳ dλ for D65: the trapezoid rule over `step` nm.
fn weights(step: f64) -> Vec<(f64, DVec3)> {
    let observer = table(include_str!("../../assets/spectra/cie-1931-2deg.csv"));
    let daylight = table(include_str!("../../assets/spectra/d65.csv"));
    let count = (400.0 / step).round() as usize;
    let mut all: Vec<(f64, DVec3)> = (0..=count)
        .map(|i| {
            let wavelength = 380.0 + i as f64 * step;
            let end = if i == 0 || i == count { 0.5 } else { 1.0 };
            (wavelength, DVec3::from_slice(&at(&observer, wavelength)) * (at(&daylight, wavelength)[0] * end))
        })
        .collect();
    let luminance: f64 = all.iter().map(|(_, w)| w.y).sum();
    all.iter_mut().for_each(|(_, w)| *w /= luminance);
    all
}

/// The colour of a spectrum f(λ \[µm\]).
fn colour(weights: &[(f64, DVec3)], f: impl Fn(f64) -> f64) -> DVec3 {
    weights.iter().map(|(nm, weight)| *weight * f(nm / 1000.0)).sum()
}

/// How far the colour of the flat mirror's f·cos θ_i in its mirror direction is from that of 4πσ² cos θ_i/λ^`power`,
/// relative. B.12 with u = v = 0 and P = 2πσ² leaves λ⁻².
fn mirror_deviation(theta: f64, power: i32) -> f64 {
    let mirror = flat([4, 4], [0.09, 0.09]);
    let reference = Reference::new(&mirror, WINDOW, [1, 1], MIRROR);
    let pair = Pair::new(toward(theta, 30.0), toward(theta, 210.0));
    let xyz = reference.cosine_weighted_xyz(&pair, &Illuminant::D65).unwrap();
    let closed = |wavelength: f64| 4.0 * PI * SIGMA * SIGMA * pair.light.z / wavelength.powi(power);
    let own = colour(&weights(0.5), closed);
    (xyz - own).length() / own.length()
}

#[test]
fn the_colour_of_a_flat_mirror_is_that_of_the_light_over_the_wavelength_squared() {
    for theta in [0.0, 30.0, 60.0] {
        let deviation = mirror_deviation(theta, 2);
        // 401 wavenumbers against tables with corners every nanometre.
        assert!(deviation < 2e-4, "{theta}: {deviation}");
        assert!(mirror_deviation(theta, 1) > 0.1 && mirror_deviation(theta, 3) > 0.1);
    }
}

/// ∫ XYZ(f) cos θ_r dω_r at normal incidence: the colour of all the light that leaves a surface of refractive index
/// `ior`.
fn albedo_colour(ior: impl Into<Reflectance>) -> DVec3 {
    let mirror = flat([4, 4], [0.09, 0.09]);
    let reference = Reference::new(&mirror, WINDOW, [1, 1], ior);
    // Rings around the normal: cos θ_r dω_r = 2π s ds. The peak is 1/(kσ) = 0.06 wide at 0.78 µm.
    const STEP: f64 = 0.005;
    let rings = (0..80).map(|i| (f64::from(i) + 0.5) * STEP);
    rings
        .map(|s| {
            let pair = Pair::new(DVec3::Z, view_at(DVec3::Z, DVec2::new(s, 0.0)).unwrap());
            reference.cosine_weighted_xyz(&pair, &Illuminant::D65).unwrap() * (2.0 * PI * s * STEP)
        })
        .sum()
}

#[test]
fn all_the_light_of_a_perfect_mirror_together_is_white() {
    let white = colour(&weights(0.5), |_| 1.0);
    // CIE 15: D65 has x = 0.3127, y = 0.3290.
    let sum = white.element_sum();
    assert!((white.x / sum - 0.3127).abs() < 1e-4 && (white.y / sum - 0.3290).abs() < 1e-4, "{white}");
    let deviation = |reflectance: Reflectance| (albedo_colour(reflectance) - white).length();
    // The midpoint rule over rings gains (step/width)²/12 = 2e-3 at the narrowest peak (0.03 at 0.38 µm), and 1/cos θ_r
    // over the widest one (0.06) another 2e-3.
    assert!(deviation(MIRROR) < 5e-3, "{}", deviation(MIRROR));
    assert!(deviation(100.0.into()) > 2e-2);
}

/// How far the colour of `field` at `pair` is from the own sum over the spectrum of `truth` in steps of `step` nm.
fn spectrum_deviation(
    field: &HeightField,
    truth: &HeightField,
    coherence: Coherence,
    pair: &Pair,
    step: f64,
) -> f64 {
    let xyz =
        Reference::new(field, coherence, [1, 1], 1.5).cosine_weighted_xyz(pair, &Illuminant::D65).unwrap();
    let reference = Reference::new(truth, coherence, [1, 1], 1.5);
    let own = colour(&weights(step), |wavelength| reference.brdf(pair, wavelength) * pair.light.z);
    (xyz - own).length() / own.length()
}

#[test]
fn the_colour_resolves_the_spectrum_of_a_wide_window_in_every_direction() {
    let field = rough([12, 10], [0.09, 0.1], 0.4);
    // Beside the mirror direction, far from it along x, and on the diagonal, where both axes spread the spectrum.
    let pairs = [
        Pair::new(toward(20.0, 0.0), toward(23.0, 180.0)),
        Pair::new(toward(40.0, 0.0), toward(50.0, 0.0)),
        Pair::new(toward(45.0, 45.0), toward(55.0, 45.0)),
    ];
    for coherence in [Coherence::SUNLIGHT, Coherence::Repeats([60, 65])] {
        for pair in &pairs {
            let deviation = spectrum_deviation(&field, &field, coherence, pair, 0.05);
            assert!(deviation < 1e-3, "{coherence:?} {pair:?}: {deviation}");
        }
    }
    let spoilt = spectrum_deviation(&scaled(&field, 1.01), &field, Coherence::SUNLIGHT, &pairs[1], 0.05);
    assert!(spoilt > 2e-3, "{spoilt}");
}
