//! The share of the light that each order of a grating takes, against closed forms, in and out of the grating's plane.
//!
//! docs/EFFICIENCY.md is written from here; a test compares it.

use crate::plain::{MIRROR, bessel, toward, view_at};
use diffract::internals::optics::coherence::Coherence;
use diffract::internals::optics::geometry::Pair;
use diffract::internals::optics::reference::Reference;
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::{Spec, SurfaceKind, generate};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::fmt::Write;

const GREEN: f64 = 0.55;
/// Sunlight's: its orders are 0.0054 wide in u, those of the gratings 0.22 and more apart.
const SIGMA: f64 = 65.0 / 4.0;
/// The light, from the normal to grazing, in the grating's plane (φ = 0, 180) and out of it \[degrees\].
const LIGHTS: [[f64; 2]; 6] =
    [[0.0, 0.0], [45.0, 0.0], [45.0, 180.0], [45.0, 90.0], [60.0, 30.0], [75.0, 120.0]];
/// Orders nearer to the horizon than this cosine are left out: their width in angle is no longer small.
const GRAZING: f64 = 0.25;

/// A grating along x and its |c_m|² at k|w|/2π = |w|/λ.
struct Grating {
    name: &'static str,
    period: f64,
    field: HeightField,
    power: fn(i32, f64) -> f64,
}

/// J_m²(2πqa) of h = a sin(2πx/d), a = 0.1 µm, at q = |w|/λ.
fn sinusoid_power(order: i32, q: f64) -> f64 {
    bessel(order, 2.0 * PI * q * 0.1).powi(2)
}

/// sinc²(m − qH) of h = Hx/d over one period, H = 0.24623 µm: (1/d) ∫ e^{ikwh + 2πimx/d} dx with w = −|w|.
fn blaze_power(order: i32, q: f64) -> f64 {
    let x = PI * (f64::from(order) - q * 0.246_23);
    if x == 0.0 { 1.0 } else { (x.sin() / x).powi(2) }
}

/// The built-in gratings, one period, sampled so finely that their steps do not count.
fn gratings() -> [Grating; 2] {
    let make = |kind, period: f64| {
        let spec = Spec::new(kind).with_patch([period, 0.4]).with_pixel_size([0.01, 0.1]);
        generate(&spec).unwrap()
    };
    [
        Grating {
            name: "sinusoid",
            period: 2.0,
            field: make(SurfaceKind::Sinusoid, 2.0),
            power: sinusoid_power,
        },
        Grating { name: "blaze", period: 2.5, field: make(SurfaceKind::Blaze, 2.5), power: blaze_power },
    ]
}

/// An order that propagates.
struct Order {
    m: i32,
    view: DVec3,
    measured: f64,
    expected: f64,
}

/// ∫ f cos θ_r dω_r over the order at (u, v), by the midpoint rule in direction cosines: the order is a Gaussian
/// e^(−(kσ)²(u² + v²)), which steps of 0.8/(kσ) sum to 2e-7.
fn measured(reference: &Reference, light: DVec3, uv: DVec2) -> f64 {
    const REACH: i32 = 6;
    let step = 0.8 * GREEN / (2.0 * PI * SIGMA);
    let grid: Vec<_> = (-REACH..=REACH).flat_map(|j| (-REACH..=REACH).map(move |i| [i, j])).collect();
    let at = |[i, j]: &[i32; 2]| {
        let view = view_at(light, uv + DVec2::new(f64::from(*i), f64::from(*j)) * step);
        view.map_or(0.0, |view| reference.brdf(&Pair::new(light, view), GREEN))
    };
    grid.par_iter().map(at).sum::<f64>() * step * step
}

/// All orders of `grating` under `light`: u = mλ/d, and v = 0 keeps the component of the directions along the lines.
fn orders(grating: &Grating, field: &HeightField, light: DVec3) -> Vec<Order> {
    let reference = Reference::new(field, Coherence::Gaussian { length: 4.0 * SIGMA }, [1, 1], MIRROR);
    let order = |m: i32| {
        let uv = DVec2::new(f64::from(m) * GREEN / grating.period, 0.0);
        let view = view_at(light, uv).filter(|view| view.z > GRAZING)?;
        let pair = Pair::new(light, view);
        let w = -pair.uvw().z;
        // P is a Gaussian around each order, of energy A |c_m|²: what is left of B.12 is G/w².
        let factor = pair.geometric_factor_times_cos_light() / (light.z * w * w);
        let expected = factor * (grating.power)(m, w / GREEN);
        Some(Order { m, view, measured: measured(&reference, light, uv), expected })
    };
    (-9..=9).filter_map(order).collect()
}

/// How far an order's share may be from its closed form, which takes G/w² for constant over the order. Its 1/cos θ_r bends
/// by (1 + 2 sin²)/cos⁴ θ_r ≤ 3/cos⁴ θ_r, and an order e^(−u²/a²), a = 1/(kσ), has a mean square of a²/2.
fn allowed(order: &Order) -> f64 {
    let a = GREEN / (2.0 * PI * SIGMA);
    2e-4 + 0.75 * (a / order.view.z.powi(2)).powi(2) * order.expected
}

/// Largest difference of an order's share from the closed form, over all lights, in units of what is allowed.
fn deviation(grating: &Grating, field: &HeightField, lights: &[[f64; 2]]) -> f64 {
    let all = lights.iter().flat_map(|[theta, phi]| orders(grating, field, toward(*theta, *phi)));
    all.map(|order| (order.measured - order.expected).abs() / allowed(&order)).fold(0.0, f64::max)
}

/// The page.
fn page() -> String {
    let mut page = String::from(
        "# Efficiency of the orders\n\n\
         The share of the light that each order takes, ∫ f cos θ_r dω_r over the order for a reflectance of 1, at 550 nm: the direct\n\
         sum through a 65 µm window against G/w² · |c_m|², where |c_m|² is J_m²(k|w|a) for the sinusoid (d = 2 µm, a = 0.1 µm) and\n\
         sinc²(m − |w|H/λ) for the blaze (d = 2.5 µm, H = 246.23 nm). An order stands where the grating equation has it: u = mλ/d and\n\
         v = 0, so that out of the grating's plane (φ_i other than 0° and 180°) the orders lie on a cone. Orders with cos θ_r below\n\
         0.25 are left out; at 75° the order is wide enough for 1/cos θ_r to bend over it, by a thousandth. The shares are those of scalar optics: they add up to about 1 near the normal and not at grazing angles.\n\n\
         `diffract orders SURFACE --light THETA,PHI --wavelength LENGTH` writes the orders of any periodic surface with these shares times the reflectance, as CSV.\n\n\
         `DIFFRACT_BLESS=1 cargo test --test optics efficiency` writes this page.\n",
    );
    let degrees = |x: f64| x.to_degrees().round() + 0.0;
    for grating in gratings() {
        let _ = write!(
            page,
            "\n## {}\n\n| θ_i, φ_i | m | θ_r, φ_r | measured | closed form |\n| --- | ---: | --- | ---: | ---: |\n",
            grating.name
        );
        for [theta, phi] in LIGHTS {
            for order in orders(&grating, &grating.field, toward(theta, phi)) {
                let azimuth = order.view.y.atan2(order.view.x).rem_euclid(2.0 * PI);
                let _ = writeln!(
                    page,
                    "| {theta}°, {phi}° | {} | {}°, {}° | {:.4} | {:.4} |",
                    order.m,
                    degrees(order.view.z.acos()),
                    if order.view.z > 1.0 - 1e-9 { 0.0 } else { degrees(azimuth) % 360.0 },
                    order.measured,
                    order.expected
                );
            }
        }
    }
    page
}

#[test]
fn every_order_takes_the_share_of_its_closed_form_also_out_of_the_plane() {
    for grating in gratings() {
        let worst = deviation(&grating, &grating.field, &LIGHTS);
        assert!(worst < 1.0, "{}: {worst:e}", grating.name);
    }
}

#[test]
fn the_shares_tell_a_surface_that_is_a_hundredth_too_high_and_one_that_leans_the_other_way() {
    let [sinusoid, blaze] = gratings();
    let higher = crate::plain::scaled(&sinusoid.field, 1.01);
    assert!(deviation(&sinusoid, &higher, &LIGHTS[..2]) > 5.0);
    let leaning = crate::plain::mirrored(&blaze.field);
    assert!(deviation(&blaze, &leaning, &LIGHTS[..2]) > 100.0);
}

#[test]
fn the_page_on_efficiency_says_what_is_measured() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/EFFICIENCY.md");
    let page = page();
    if std::env::var_os("DIFFRACT_BLESS").is_some_and(|v| v == "1") {
        std::fs::write(path, &page).unwrap();
    }
    let written = std::fs::read_to_string(path).unwrap();
    assert!(written == page, "docs/EFFICIENCY.md differs; DIFFRACT_BLESS=1 writes it anew");
}
