//! Colours that are read along the lines of a grid, against the direct f64 sum.

use crate::device::with_device;
use crate::evaluation::{patch, shading, window};
use crate::table::{by_reference, colours, errors};
use diffract::expansion::Basis;
use diffract::optics::geometry::Pair;
use diffract::optics::quadrature::Rule;
use diffract::precompute::{Layers, Settings, compute};
use diffract::random::Random;
use diffract::render::evaluator::{Evaluator, Query};
use diffract::render::picture::Directions;
use diffract::render::shading::Shading;
use diffract::surface::HeightField;
use diffract::surface::synth::Kind;
use diffract::vk::device::Device;
use diffract::vk::instance::Instance;
use diffract::vk::mask::Mask;
use diffract::vk::selection::DeviceChoice;
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Layers of `field` for pictures, which have lines.
fn layers(device: &Device, field: &HeightField, shading: &Shading) -> Layers {
    let settings = shading.layer_settings(0.38, device.candidate()).unwrap();
    let layers = compute(field, &settings, &|_, _| Ok(())).unwrap();
    assert!(layers.lines.is_some());
    layers
}

fn meet_their_tolerance(kind: Kind, side: f64, length: f64, seed: u64, bases: &[(Basis, f64)]) {
    let field = patch(kind, side);
    let queries = colours(seed, 300);
    let exact = by_reference(&field, &shading(length, 1.0), &queries);
    with_device(|device| {
        for &(basis, tolerance) in bases {
            let shading = Shading { basis, ..shading(length, tolerance) }.for_pictures();
            let layers = layers(device, &field, &shading);
            let found = Evaluator::new(device, &window(&layers), &shading)
                .unwrap()
                .cosine_weighted(&queries)
                .unwrap();
            let [whole, median, p99] = errors(&found, &exact);
            eprintln!(
                "{} by {}, {} terms in {} bands, {}-bit, at {tolerance:e}: {whole:.2e}, median {median:.2e}, p99 {p99:.2e}",
                kind.name(),
                basis.name(),
                layers.terms,
                layers.z_bands,
                if layers.texels.is_half() { 16 } else { 32 }
            );
            // Between a grating's orders there are but the tails of its lobes, of which a picture promises nothing.
            let single = if kind == Kind::Blaze { 0.0 } else { median };
            assert!(
                whole <= tolerance && single <= tolerance,
                "{basis:?} at {tolerance}: {whole:e}, {median:e}"
            );
            // The comparison sees a surface that is a tenth higher.
            let heights = field.heights().iter().map(|h| h * 1.1).collect();
            let higher =
                HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights).unwrap();
            let other = self::layers(device, &higher, &shading);
            let wrong =
                Evaluator::new(device, &window(&other), &shading).unwrap().cosine_weighted(&queries).unwrap();
            assert!(errors(&wrong, &exact)[1] > 2.0 * median.max(tolerance / 4.0));
        }
    });
}

#[test]
fn colours_along_lines_meet_their_tolerance_on_an_elaphe_skin() {
    use Basis::{Chebyshev, Optimal, Taylor};
    let bases = [(Optimal, 1e-1), (Optimal, 1e-2), (Optimal, 1e-3), (Taylor, 1e-2), (Chebyshev, 1e-2)];
    meet_their_tolerance(Kind::Elaphe, 24.0, 30.0, 41, &bases);
}

#[test]
fn colours_along_lines_meet_their_tolerance_on_a_blaze() {
    meet_their_tolerance(Kind::Blaze, 20.0, 40.0, 42, &[(Basis::Optimal, 1e-2), (Basis::Taylor, 1e-2)]);
}

#[test]
fn colours_along_lines_meet_their_tolerance_where_samples_and_sides_are_not_square() {
    // Its samples are 1.3 times as far apart along y.
    let square = patch(Kind::Elaphe, 12.0);
    let [dx, _] = square.pixel_size();
    let heights = square.heights().to_vec();
    let field = HeightField::new(square.columns(), square.rows(), [dx, dx * 0.7], heights).unwrap();
    let queries = colours(43, 200);
    let light = shading(32.0, 1e-2);
    let exact = by_reference(&field, &light, &queries);
    with_device(|device| {
        for terms in [None, Some(14)] {
            let shading = Shading { terms, ..light.clone() }.for_pictures();
            let layers = layers(device, &field, &shading);
            assert_eq!(layers.half_plane, terms.is_some());
            let found = Evaluator::new(device, &window(&layers), &shading)
                .unwrap()
                .cosine_weighted(&queries)
                .unwrap();
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
    const EACH: usize = 12;
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
        let field = patch(Kind::Elaphe, side);
        let light = shading(length, 1e-2);
        let exact = by_reference(&field, &light, &queries);
        with_device(|device| {
            for (basis, terms, tolerance) in
                [(Basis::Optimal, None, 1e-3), (Basis::Optimal, None, 1e-2), (Basis::Taylor, Some(16), 1e-2)]
            {
                let shading = Shading { basis, terms, tolerance, ..light.clone() }.for_pictures();
                let layers = layers(device, &field, &shading);
                assert_eq!(layers.half_plane, terms.is_some());
                let mut evaluator = Evaluator::new(device, &window(&layers), &shading).unwrap();
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

#[test]
fn nodes_on_lines_are_counted_as_the_rule_has_them() {
    let field = patch(Kind::Elaphe, 12.0);
    let shading = Shading { basis: Basis::Optimal, ..shading(65.0, 1e-2) }.for_pictures();
    with_device(|device| {
        let layers = layers(device, &field, &shading);
        let source = window(&layers);
        let cost = |u: f32, v: f32| {
            let light = [u, v, (1.0 - u * u - v * v).sqrt(), 1.0];
            let seen =
                Directions { light: vec![light], view: vec![[0.0, 0.0, 1.0, 1.0]], ..Directions::default() };
            source.cost(&shading, &[seen], [1, 1])
        };
        // L is 2 sqrt(2 ln(1/(0.7 level))) sigma = 103 um, and the eye sees 1.2 per micron of wavenumbers; a node more at both ends.
        let along = cost(0.6, 0.1);
        assert!((75..=84).contains(&along.wavelengths), "{along:?}");
        assert_eq!(along.samples, along.wavelengths * layers.pairs());
        assert_eq!(cost(0.6, 0.5).wavelengths, along.wavelengths);
        // The patch is not quite square, and so are the lines.
        assert!(cost(0.1, 0.6).wavelengths.abs_diff(along.wavelengths) <= 1);
        // Toward the mirror direction octave by octave as many, down to those that stand for the colour functions alone.
        let rule = Rule::gaussian(&shading.illuminant, layers.sigma, shading.quadrature());
        for near in [cost(0.05, 0.03), cost(0.002, 0.001), cost(0.0, 0.0)] {
            let fewest = rule.count(0.0);
            assert!((fewest..=3 * fewest + 3).contains(&near.wavelengths), "{near:?} of {fewest}");
        }
    });
}

#[test]
fn tolerances_that_the_weights_of_lines_would_break_do_without_them() {
    with_device(|device| {
        for (tolerance, on_lines) in [(1e-3, true), (5e-4, false), (1e-4, false)] {
            let shading = shading(65.0, tolerance).for_pictures();
            let settings = shading.layer_settings(0.38, device.candidate()).unwrap();
            assert_eq!(settings.lines.is_some(), on_lines, "{tolerance}");
        }
    });
}

#[test]
fn a_device_that_has_room_for_the_plane_but_not_for_lines_shades_without_them() {
    let field = patch(Kind::Elaphe, 12.0);
    let light = shading(24.0, 3e-2);
    // Named terms keep the number of layers, whatever there is room for; these are more than enough.
    let shading = Shading { terms: Some(14), ..light.clone() }.for_pictures();
    let mut roomy = None;
    with_device(|device| roomy = shading.layer_settings(0.38, device.candidate()).ok());
    let roomy = roomy.unwrap();
    let bytes = |lines| {
        let layers = compute(&field, &Settings { lines, ..roomy }, &|_, _| Ok(())).unwrap();
        assert_eq!(layers.lines.is_some(), lines.is_some());
        layers.bytes()
    };
    let (with, without) = (bytes(roomy.lines), bytes(None));
    assert!(roomy.lines.is_some() && with as f64 > 1.2 * without as f64, "{with} {without}");
    let on_device_for = |layers: usize| {
        // Layers get three quarters of a device.
        let mask = Mask { memory: Some((layers as f64 / 0.75) as u64), ..Mask::default() };
        let instance = Arc::new(Instance::masked(true, mask).unwrap());
        let device = Device::open(instance.clone(), &DeviceChoice::Any).unwrap();
        let settings = shading.layer_settings(0.38, device.candidate()).unwrap();
        assert!(settings.lines.is_some() && settings.memory_limit.abs_diff(layers) < 8);
        (compute(&field, &settings, &|_, _| Ok(())), device, instance)
    };
    let (layers, device, instance) = on_device_for((with + without) / 2);
    let layers = layers.unwrap();
    assert!(layers.lines.is_none() && layers.bytes() == without);
    let queries = colours(44, 200);
    let exact = by_reference(&field, &light, &queries);
    let found =
        Evaluator::new(&device, &window(&layers), &shading).unwrap().cosine_weighted(&queries).unwrap();
    let [whole, median, _] = errors(&found, &exact);
    assert!(whole <= light.tolerance && median <= light.tolerance, "{whole:e}, {median:e}");
    drop(device);
    assert_eq!(instance.messages(), [""; 0]);
    // What holds neither is refused with what would fit.
    let line = on_device_for(without * 9 / 10).0.unwrap_err().to_string();
    assert!(line.contains("GiB") && line.contains("fewer --terms") && line.contains("--coherence"), "{line}");
}
