//! Colours of single directions with the settings of pictures, against f64 transforms, some of which the direct sum judges.

use crate::device::with_device;
use crate::evaluation::{FLOOR, colours, optics, patch, window};
use diffract::internals::optics::geometry::Pair;
use diffract::internals::optics::nufft::cosine_weighted_xyz;
use diffract::internals::optics::reference::Reference;
use diffract::internals::random::Random;
use diffract::internals::render::evaluator::{Evaluator, Query};
use diffract::internals::settings::Optics;
use diffract::internals::spectra::amplitude::expansion::Basis;
use diffract::internals::spectra::amplitude::{Layers, compute};
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use glam::{DVec2, DVec3};

/// The colours of `queries` by transforms in f64, XYZ of f cos θ_i; every thirtieth of them agrees with the direct sum.
fn by_reference(field: &HeightField, optics: &Optics, queries: &[Query]) -> Vec<DVec3> {
    const EACH: usize = 30;
    let reference = Reference::new(field, optics.coherence, [1, 1], optics.reflectance.clone());
    let pairs: Vec<Pair> = queries.iter().map(|q| q.pair).collect();
    let colours = cosine_weighted_xyz(&reference, &optics.illuminant, &pairs, &Task::silent()).unwrap();
    for (pair, colour) in pairs.iter().zip(&colours).step_by(EACH) {
        let direct = reference.cosine_weighted_xyz(pair, &optics.illuminant).unwrap();
        let apart = (*colour - direct).length();
        assert!(apart <= 1e-4 * direct.length() + 1e-9, "{colour} by transforms, {direct} by the sum");
    }
    colours
}

/// ‖found − exact‖/‖exact‖ over all directions, then median and 99th percentile of the errors of single directions that a
/// display does not show as black, each relative to its own value.
fn errors(found: &[DVec3], exact: &[DVec3]) -> [f64; 3] {
    assert!(found.iter().all(|f| f.is_finite()));
    let pairs = || found.iter().zip(exact);
    let mut single: Vec<f64> =
        pairs().filter(|(_, e)| e.length() > FLOOR).map(|(f, e)| (*f - *e).length() / e.length()).collect();
    single.sort_by(f64::total_cmp);
    let difference: f64 = pairs().map(|(f, e)| (*f - *e).length_squared()).sum();
    let size: f64 = exact.iter().map(|e| e.length_squared()).sum();
    [(difference / size).sqrt(), single[single.len() / 2], single[single.len() * 99 / 100]]
}

/// Layers of `field` for pictures.
fn layers(device: &Device, field: &HeightField, optics: &Optics) -> Layers {
    let sigma = optics.coherence.sigma().unwrap();
    let settings =
        diffract::internals::setup::layer_settings(optics, sigma, 0.38, device.candidate()).unwrap();
    compute(field, &settings, &Task::silent()).unwrap()
}

fn meet_their_tolerance(kind: SurfaceKind, side: f64, length: f64, seed: u64, bases: &[(Basis, f64)]) {
    let field = patch(kind, side);
    let queries = colours(seed, 300);
    let exact = by_reference(&field, &optics(length, 1.0), &queries);
    with_device(|device| {
        for &(basis, tolerance) in bases {
            let optics = Optics { basis, ..optics(length, tolerance) }.for_pictures();
            let layers = layers(device, &field, &optics);
            let found =
                Evaluator::new(device, &window(&layers), &optics).unwrap().cosine_weighted(&queries).unwrap();
            let [whole, median, p99] = errors(&found, &exact);
            eprintln!(
                "{} by {}, {} terms, {}-bit, at {tolerance:e}: {whole:.2e}, median {median:.2e}, p99 {p99:.2e}",
                kind.name(),
                basis.name(),
                layers.terms,
                if layers.texels.is_half() { 16 } else { 32 }
            );
            // Between a grating's orders there are but the tails of its lobes, of which a picture promises nothing.
            let single = if kind == SurfaceKind::Blaze { 0.0 } else { median };
            assert!(
                whole <= tolerance && single <= tolerance,
                "{basis:?} at {tolerance}: {whole:e}, {median:e}"
            );
            // The comparison sees a surface that is a tenth higher.
            let heights = field.heights().iter().map(|h| h * 1.1).collect();
            let higher =
                HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights).unwrap();
            let other = self::layers(device, &higher, &optics);
            let wrong =
                Evaluator::new(device, &window(&other), &optics).unwrap().cosine_weighted(&queries).unwrap();
            assert!(errors(&wrong, &exact)[1] > 2.0 * median.max(tolerance / 4.0));
        }
    });
}

#[test]
fn colours_of_pictures_meet_their_tolerance_on_an_elaphe_skin() {
    use Basis::{Optimal, Taylor};
    let bases = [(Optimal, 1e-1), (Optimal, 1e-2), (Optimal, 1e-3), (Taylor, 1e-2)];
    meet_their_tolerance(SurfaceKind::Elaphe, 24.0, 30.0, 41, &bases);
}

#[test]
fn colours_of_pictures_meet_their_tolerance_on_a_blaze() {
    meet_their_tolerance(
        SurfaceKind::Blaze,
        20.0,
        40.0,
        42,
        &[(Basis::Optimal, 1e-2), (Basis::Taylor, 1e-2)],
    );
}

#[test]
fn colours_of_pictures_meet_their_tolerance_where_samples_and_sides_are_not_square() {
    // Its samples are 1.3 times as far apart along y.
    let square = patch(SurfaceKind::Elaphe, 12.0);
    let [dx, _] = square.pixel_size();
    let heights = square.heights().to_vec();
    let field = HeightField::new(square.columns(), square.rows(), [dx, dx * 0.7], heights).unwrap();
    let queries = colours(43, 200);
    let light = optics(32.0, 1e-2);
    let exact = by_reference(&field, &light, &queries);
    with_device(|device| {
        for terms in [None, Some(14)] {
            let optics = Optics { terms, ..light.clone() }.for_pictures();
            let layers = layers(device, &field, &optics);
            let found =
                Evaluator::new(device, &window(&layers), &optics).unwrap().cosine_weighted(&queries).unwrap();
            let [whole, median, p99] = errors(&found, &exact);
            eprintln!("terms {terms:?}: {whole:.2e}, median {median:.2e}, p99 {p99:.2e}");
            assert!(
                whole <= light.tolerance && median <= light.tolerance,
                "{terms:?}: {whole:e}, {median:e}"
            );
        }
    });
}

#[test]
fn rays_toward_the_mirror_direction_meet_the_tolerance_octave_by_octave() {
    const OCTAVES: i32 = 17;
    const EACH: usize = 6;
    let mut random = Random::new(45);
    let light = DVec3::new(0.31, -0.17, 1.0).normalize();
    let mut toward = |uv: f64| {
        let angle = random.share() * std::f64::consts::TAU;
        let level = -light.truncate() + DVec2::from_angle(angle) * uv * (0.5 + 0.5 * random.share());
        let pair = Pair::new(light, level.extend((1.0 - level.length_squared()).sqrt()));
        Query { pair, wavelength: None }
    };
    // The last is the mirror direction to all digits that there are.
    let queries: Vec<Query> =
        (0..OCTAVES).flat_map(|k| vec![0.3 * f64::from(-k).exp2(); EACH]).map(&mut toward).collect();
    for (side, length) in [(24.0, 30.0), (12.0, 25.0)] {
        let field = patch(SurfaceKind::Elaphe, side);
        let light = optics(length, 1e-2);
        let exact = by_reference(&field, &light, &queries);
        with_device(|device| {
            for (basis, terms, tolerance) in
                [(Basis::Optimal, None, 1e-3), (Basis::Optimal, None, 1e-2), (Basis::Taylor, Some(16), 1e-2)]
            {
                let optics = Optics { basis, terms, tolerance, ..light.clone() }.for_pictures();
                let layers = layers(device, &field, &optics);
                let mut evaluator = Evaluator::new(device, &window(&layers), &optics).unwrap();
                let found = evaluator.cosine_weighted(&queries).unwrap();
                for (octave, (found, exact)) in found.chunks(EACH).zip(exact.chunks(EACH)).enumerate() {
                    let wrong: f64 = found.iter().zip(exact).map(|(f, e)| (*f - *e).length_squared()).sum();
                    let whole = (wrong / exact.iter().map(|e| e.length_squared()).sum::<f64>()).sqrt();
                    eprintln!(
                        "{length} um at {tolerance:e} by {} in octave {octave}: {whole:.1e}",
                        basis.name()
                    );
                    assert!(whole <= tolerance, "{basis:?}, octave {octave}: {whole:e}");
                }
            }
        });
    }
}
