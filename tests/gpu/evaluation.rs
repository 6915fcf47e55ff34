//! `spectral` on the device against the direct f64 sum, for single directions.

use crate::device::with_device;
use crate::measure::per_direction;
use crate::shared;
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::optics::geometry::{Pair, direction};
use diffract::internals::optics::orders::Repeats;
use diffract::internals::optics::reference::Reference;
use diffract::internals::random::Random;
use diffract::internals::render::evaluator::{Evaluator, Query};
use diffract::internals::render::source::{Grating, Source};
use diffract::internals::settings::Optics;
use diffract::internals::setup::SourceSettings;
use diffract::internals::spectra::amplitude::expansion::Basis;
use diffract::internals::spectra::amplitude::{LayerSettings, Layers, compute};
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::{Spec, SurfaceKind, generate};
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Directions per surface.
const DIRECTIONS: usize = 2000;

/// What a display shows as black under a light of intensity 1 at exposure 0: DISPLAY_BLACK/π in f cos θ_i.
pub const FLOOR: f64 = diffract::internals::optics::color::DISPLAY_BLACK / std::f64::consts::PI;

/// Directions over both hemispheres and wavelengths over the visible, a third of them near the mirror direction, some
/// below the horizon.
pub fn queries(seed: u64, count: usize) -> Vec<Query> {
    let mut random = Random::new(seed);
    let mut uniform = || random.share();
    (0..count)
        .map(|i| {
            let (theta_i, phi_i) = (uniform().acos().to_degrees(), 360.0 * uniform());
            let (theta_r, phi_r) = match i % 3 {
                0 => (theta_i + 12.0 * (uniform() - 0.5), phi_i + 180.0 + 12.0 * (uniform() - 0.5)),
                _ => (uniform().acos().to_degrees(), 360.0 * uniform()),
            };
            Query {
                pair: Pair::new(direction(theta_i, phi_i), direction(theta_r, phi_r)),
                wavelength: Some(0.38 + 0.4 * uniform()),
            }
        })
        .collect()
}

/// Directions of colours over both hemispheres.
pub fn colours(seed: u64, count: usize) -> Vec<Query> {
    queries(seed, count).into_iter().map(|q| Query { wavelength: None, ..q }).collect()
}

/// A small patch of a kind, under a window that sees several copies of it.
pub fn patch(kind: SurfaceKind, side: f64) -> HeightField {
    generate(&Spec::new(kind).with_patch([side, side])).unwrap()
}

/// Through one window.
pub fn optics(length: f64, tolerance: f64) -> Optics {
    Optics {
        coherence: Coherence::Gaussian { length },
        windows: Windows::ONE,
        tolerance,
        ..Optics::default()
    }
}

/// What is shaded from `layers` of a window.
pub fn window(layers: &Layers) -> Source {
    Source::window(layers.clone())
}

/// What is shaded from `layers` of one period of `field`, repeated.
pub fn grating(layers: &Layers, copies: [u32; 2], field: &HeightField) -> Source {
    let repeats = Repeats { copies, period: field.patch_size() };
    Source::Grating(Grating { layers: Arc::new(layers.clone()), repeats, energy: None })
}

/// `source` within the limit of energy of `field` under `optics`, as the program draws it.
pub fn limited(source: Source, field: &HeightField, optics: &Optics) -> Source {
    let settings = SourceSettings::new(optics.clone());
    source.limited(shared::limit(field, &settings))
}

pub fn layers(field: &HeightField, optics: &Optics) -> Layers {
    let settings = LayerSettings {
        sigma: optics.coherence.sigma().unwrap(),
        shortest_wavelength: 0.38,
        budget: optics.budget().window,
        basis: optics.basis,
        terms: optics.terms,
        memory_limit: 1 << 30,
        side_limit: 16_384,
    };
    compute(field, &settings, &Task::silent()).unwrap()
}

/// f cos θ_i of every query on the device.
fn on_device(device: &Arc<Device>, field: &HeightField, optics: &Optics, queries: &[Query]) -> Vec<f64> {
    let mut evaluator = Evaluator::new(device, &Source::window(layers(field, optics)), optics).unwrap();
    evaluator.cosine_weighted(queries).unwrap().iter().map(|v| v.x).collect()
}

/// f cos θ_i of every query by the direct sum.
fn by_reference(field: &HeightField, optics: &Optics, queries: &[Query]) -> Vec<f64> {
    let reference = Reference::new(field, optics.coherence, [1, 1], optics.reflectance.clone());
    queries.iter().map(|q| reference.brdf(&q.pair, q.wavelength.unwrap()) * q.pair.light.z.max(0.0)).collect()
}

fn spectral_meets_its_tolerance(kind: SurfaceKind, side: f64, length: f64, seed: u64) {
    let field = patch(kind, side);
    let queries = queries(seed, DIRECTIONS);
    let exact = by_reference(&field, &optics(length, 1.0), &queries);
    with_device(|device| {
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let found = on_device(device, &field, &optics(length, tolerance), &queries);
            let error = per_direction(&found, &exact, FLOOR);
            eprintln!("{} at {tolerance:e}: {error:.2e}", kind.name());
            assert!(error <= tolerance, "{} at {tolerance}: {error:e}", kind.name());
            // The same check has to fail for a surface one per cent higher at the finest tolerance.
            if tolerance == 1e-3 {
                let heights = field.heights().iter().map(|h| h * 1.01).collect();
                let higher =
                    HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights).unwrap();
                let wrong = on_device(device, &higher, &optics(length, tolerance), &queries);
                assert!(per_direction(&wrong, &exact, FLOOR) > tolerance, "a height error of 1 % passes");
            }
        }
    });
}

#[test]
fn spectral_meets_its_tolerance_on_an_elaphe_skin() {
    spectral_meets_its_tolerance(SurfaceKind::Elaphe, 24.0, 24.0, 1);
}

#[test]
fn spectral_meets_its_tolerance_on_a_blaze() {
    spectral_meets_its_tolerance(SurfaceKind::Blaze, 20.0, 30.0, 2);
}

#[test]
fn spectral_meets_its_tolerance_on_bumps_smaller_than_the_window() {
    spectral_meets_its_tolerance(SurfaceKind::Bumps, 4.0, 20.0, 3);
}

#[test]
fn every_basis_meets_the_tolerance_where_it_is_not_refused() {
    for (kind, side, bases) in
        [(SurfaceKind::Elaphe, 16.0, &Basis::ALL[..]), (SurfaceKind::Xenopeltis, 16.0, &[Basis::Optimal])]
    {
        let field = patch(kind, side);
        let queries = queries(11, 600);
        let exact = by_reference(&field, &optics(20.0, 1.0), &queries);
        let mut terms = Vec::new();
        for &basis in bases {
            let optics = Optics { basis, ..optics(20.0, 1e-2) };
            terms.push(layers(&field, &optics).terms);
            with_device(|device| {
                let found = on_device(device, &field, &optics, &queries);
                let error = per_direction(&found, &exact, FLOOR);
                eprintln!("{} by {}: {error:.2e}, {terms:?} terms", kind.name(), basis.name());
                assert!(error <= 1e-2, "{} by {}: {error:e}", kind.name(), basis.name());
            });
        }
        assert!(terms.is_sorted_by(|a, b| a > b), "a better basis takes fewer terms: {terms:?}");
    }
}

#[test]
fn every_basis_meets_what_a_picture_asks_of_single_wavelengths_grazing_directions_too() {
    let field = patch(SurfaceKind::Elaphe, 16.0);
    let mut queries = queries(12, 600);
    // As many again that graze the surface: k|w| is small.
    let grazing = |d: glam::DVec3| glam::DVec3::new(d.x, d.y, 0.05 * d.z).normalize();
    queries.extend_from_within(..);
    for query in &mut queries[600..] {
        query.pair = Pair::new(grazing(query.pair.light), grazing(query.pair.view));
    }
    for basis in Basis::ALL {
        let optics = Optics { basis, ..optics(20.0, 1e-2) }.for_pictures();
        let exact = by_reference(&field, &optics, &queries);
        let layers = layers(&field, &optics);
        let allowed = optics.budget().window.gain * optics.tolerance;
        with_device(|device| {
            let found = on_device(device, &field, &optics, &queries);
            for (name, part) in [("all around", 0..600), ("grazing", 600..1200)] {
                let error = per_direction(&found[part.clone()], &exact[part], FLOOR);
                eprintln!("{} {name}: {error:.2e} of {allowed:.2e}, {} pairs", basis.name(), layers.pairs());
                assert!(error <= allowed, "{} {name}: {error:e}", basis.name());
            }
        });
    }
}

#[test]
fn every_quarter_of_the_frequency_plane_is_the_right_way_round() {
    // A surface without any symmetry: one tilted facet per quarter, of different slopes.
    let side = 64;
    let heights = (0..side * side)
        .map(|i| {
            let (x, y) = ((i % side) as f64 / side as f64, (i / side) as f64 / side as f64);
            0.05 * (TAU * (3.0 * x + y)).sin()
                + 0.04 * (TAU * (2.0 * y - x) + 0.5).cos()
                + 0.03 * x * (1.0 - x) * y
        })
        .collect();
    let field = HeightField::new(side, side, [0.09, 0.08], heights).unwrap();
    let queries = queries(5, 400);
    let optics = optics(10.0, 1e-3);
    let exact = by_reference(&field, &optics, &queries);
    let turned: Vec<Query> = queries
        .iter()
        .map(|q| {
            let half_turn = glam::DVec3::new(-1.0, -1.0, 1.0);
            Query { pair: Pair::new(q.pair.light * half_turn, q.pair.view * half_turn), ..*q }
        })
        .collect();
    with_device(|device| {
        assert!(per_direction(&on_device(device, &field, &optics, &queries), &exact, FLOOR) < 1e-3);
        assert!(per_direction(&on_device(device, &field, &optics, &turned), &exact, FLOOR) > 0.1);
    });
}

#[test]
fn colours_of_single_directions_meet_the_tolerance() {
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let queries: Vec<Query> = queries(7, 60).into_iter().map(|q| Query { wavelength: None, ..q }).collect();
    with_device(|device| {
        for tolerance in [1e-1, 1e-2, 1e-3] {
            let optics = optics(24.0, tolerance);
            let reference = Reference::new(&field, optics.coherence, [1, 1], optics.reflectance.clone());
            let mut evaluator =
                Evaluator::new(device, &Source::window(layers(&field, &optics)), &optics).unwrap();
            let found = evaluator.cosine_weighted(&queries).unwrap();
            let relative: Vec<f64> = queries
                .iter()
                .zip(found)
                .map(|(q, found)| {
                    let exact = reference.cosine_weighted_xyz(&q.pair, &optics.illuminant).unwrap();
                    (found - exact).length() / exact.length().max(FLOOR)
                })
                .collect();
            let error = per_direction(&relative, &vec![0.0; relative.len()], 1.0);
            eprintln!("colours at {tolerance:e}: {error:.2e}");
            assert!(error <= tolerance, "{tolerance}: {error:e}");
        }
    });
}

#[test]
fn nothing_is_reflected_below_the_horizon_or_beyond_the_band() {
    let field = HeightField::new(32, 32, [0.2, 0.2], vec![0.0; 1024]).unwrap();
    let optics = optics(8.0, 1e-2);
    let ask = |theta_i: f64, theta_r: f64, wavelength| Query {
        pair: Pair::new(direction(theta_i, 0.0), direction(theta_r, 0.0)),
        wavelength: Some(wavelength),
    };
    // |u|/λ = 3.46/µm is beyond 1/(2·0.2 µm) = 2.5/µm, where the periodic copy of the mirror peak would stand at 5/µm.
    let dark = [
        ask(91.0, 0.0, 0.5),
        ask(0.0, 95.0, 0.5),
        ask(90.0, 90.0, 0.5),
        ask(60.0, 60.0, 0.5),
        ask(0.0, 80.0, 0.39),
    ];
    with_device(|device| {
        assert_eq!(on_device(device, &field, &optics, &dark), [0.0; 5]);
        let mirror = on_device(device, &field, &optics, &[ask(30.0, -30.0, 0.55)]);
        assert!(mirror[0] > 0.1, "{mirror:?}");
    });
}
