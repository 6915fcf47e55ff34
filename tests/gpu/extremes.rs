//! Numbers at the ends of their ranges: the device against the direct f64 sum where there is an answer, an error with a
//! remedy where there is none, and nowhere a value that is not a number. What the runs print stands in docs/EXTREMES.md.

use crate::device::with_device;
use crate::evaluation::{grating, limited, optics, patch, window};
use crate::measure::channel;
use crate::shared::Pictured;
use diffract::internals::error::Result;
use diffract::internals::optics::brdf::cosine_weighted;
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::optics::color::Tone;
use diffract::internals::optics::geometry::{Pair, direction};
use diffract::internals::optics::reference::Reference;
use diffract::internals::random::Random;
use diffract::internals::render::evaluator::{Evaluator, Query};
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::reference_picture::displayed;
use diffract::internals::scene::{Lens, Light, Scene};
use diffract::internals::settings::Optics;
use diffract::internals::spectra::amplitude::audit::FAINT;
use diffract::internals::spectra::amplitude::expansion::Basis;
use diffract::internals::spectra::amplitude::texels::{HALF_UNIT, Texels};
use diffract::internals::spectra::amplitude::{LayerSettings, Layers, compute};
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::cell::RefCell;
use std::f64::consts::PI;
use std::sync::Arc;

/// What a display shows as black under a light of intensity 1 at exposure 0, in f cos θ_i.
const FLOOR: f64 = diffract::internals::optics::color::DISPLAY_BLACK / PI;

/// A cosine below which the device takes a direction as below the horizon (`HORIZON` of diffraction.glsl), with room for
/// the rounding of its 32-bit directions.
const HORIZON: f64 = 2e-6;

/// Polar angles with the ends over-weighted \[degrees\]: the normal, grazing, the horizon, below it.
const POLAR: [f64; 14] =
    [0.0, 1e-9, 1e-4, 30.0, 60.0, 85.0, 89.0, 89.9, 89.99, 89.999, 89.9999, 89.999_999, 90.0, 90.1];

/// Views relative to the light: mirror side, retro side, across.
const TURNS: [f64; 6] = [180.0, 180.0 - 1e-7, 0.0, 1e-7, 90.0, 37.0];

fn layers_of(field: &HeightField, optics: &Optics) -> Result<Layers> {
    let settings = LayerSettings {
        sigma: optics.coherence.sigma().unwrap(),
        shortest_wavelength: 0.38,
        budget: optics.budget().window,
        basis: optics.basis,
        terms: optics.terms,
        memory_limit: 64 << 20,
        side_limit: 4096,
    };
    compute(field, &settings, &Task::silent())
}

/// Every polar angle against every other and every turn, at the ends and in the middle of the visible.
fn end_queries() -> Vec<Query> {
    let mut queries = Vec::new();
    for (i, theta_i) in POLAR.into_iter().enumerate() {
        for (j, theta_r) in POLAR.into_iter().enumerate() {
            for (k, turn) in TURNS.into_iter().enumerate() {
                let pair = Pair::new(direction(theta_i, 20.0), direction(theta_r, 20.0 + turn));
                queries.push(Query { pair, wavelength: Some([0.38, 0.55, 0.78][(i + j + k) % 3]) });
            }
        }
    }
    queries
}

fn exact(field: &HeightField, optics: &Optics, queries: &[Query]) -> Vec<f64> {
    let reference = Reference::new(field, optics.coherence, [1, 1], optics.reflectance.clone());
    let one = |q: &Query| {
        let q0 = 1.0 / q.wavelength.unwrap();
        reference.cosine_weighted_spectrum(&q.pair, q0, 0.0, 1)[0]
    };
    queries.iter().map(one).collect()
}

/// The device's answers; each is a number of at least 0, colours are numbers.
fn answers(device: &Arc<Device>, layers: &Layers, optics: &Optics, queries: &[Query]) -> Vec<f64> {
    let mut evaluator = Evaluator::new(device, &window(layers), optics).unwrap();
    let found = evaluator.cosine_weighted(queries).unwrap();
    for (query, value) in queries.iter().zip(&found) {
        assert!(value.x.is_finite() && value.x >= 0.0, "{query:?}: {value}");
    }
    let colours: Vec<Query> = queries.iter().map(|q| Query { wavelength: None, ..*q }).collect();
    for (query, value) in colours.iter().zip(evaluator.cosine_weighted(&colours).unwrap()) {
        assert!(value.is_finite(), "{query:?}: {value}");
    }
    found.iter().map(|v| v.x).collect()
}

/// Which queries the device promises to answer: both directions clear of the horizon.
fn clear(query: &Query) -> bool {
    query.pair.light.z > HORIZON && query.pair.view.z > HORIZON
}

/// The f cos θ_i that a tolerance is promised from: [`FAINT`] of the flat mirror's peak under this pair. 1/(w² cos θ_r) lifts
/// the peak, and with it what is too faint to be judged, without end toward the horizon.
fn promised(query: &Query, optics: &Optics) -> f64 {
    let sigma = optics.coherence.sigma().unwrap();
    let area = optics.coherence.area([0.0; 2]);
    let reflectance = optics.reflectance.at(0.55, query.pair.cos_half_angle());
    let peak = (2.0 * PI * sigma * sigma).powi(2);
    reflectance * cosine_weighted(&query.pair, query.wavelength.unwrap(), area, FAINT * peak)
}

/// Errors of answers, relative to each direction's own value.
#[derive(Debug, Default)]
struct Errors {
    /// RMS where a tolerance is promised.
    rms: f64,
    /// The worst there.
    worst: f64,
    /// The worst of all with both directions 1°, 0.1° and hardly above the horizon, what is too faint included, down to what
    /// a display shows as black.
    anywhere: [f64; 3],
}

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b, c] = self.anywhere;
        write!(f, "RMS {:.1e}, worst {:.1e}, faint ones too {a:.1e} {b:.1e} {c:.1e}", self.rms, self.worst)
    }
}

/// The errors; what is below the horizon is 0.
fn errors(queries: &[Query], found: &[f64], exact: &[f64], optics: &Optics) -> Errors {
    let mut errors = Errors::default();
    let mut squares = vec![];
    for ((query, &found), &exact) in queries.iter().zip(found).zip(exact) {
        assert!(exact.is_finite() && exact >= 0.0, "{query:?}: the direct sum is {exact}");
        if query.pair.light.z <= 0.0 || query.pair.view.z <= 0.0 {
            assert!(found == 0.0 && exact == 0.0, "{query:?}: {found} below the horizon");
        } else if clear(query) {
            let relative = (found - exact).abs() / exact.max(FLOOR).max(promised(query, optics));
            squares.push(relative * relative);
            errors.worst = errors.worst.max(relative);
            let lower = query.pair.light.z.min(query.pair.view.z);
            for (worst, least) in errors.anywhere.iter_mut().zip([1f64, 0.1, 0.0]) {
                if lower >= least.to_radians().sin() {
                    *worst = worst.max((found - exact).abs() / exact.max(FLOOR));
                }
            }
        }
    }
    errors.rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    errors
}

#[test]
fn directions_at_the_ends_keep_the_tolerance_and_are_numbers_everywhere() {
    let field = patch(SurfaceKind::Bumps, 2.0);
    let queries = end_queries();
    let reference = exact(&field, &optics(8.0, 1.0), &queries);
    with_device(|device| {
        for basis in Basis::ALL {
            for tolerance in [1e-1, 1e-3] {
                let optics = Optics { basis, ..optics(8.0, tolerance) };
                let layers = layers_of(&field, &optics).unwrap();
                let found = answers(device, &layers, &optics, &queries);
                let e = errors(&queries, &found, &reference, &optics);
                eprintln!("directions: {} {tolerance:e}: {e}", basis.name());
                assert!(e.rms <= tolerance, "{} at {tolerance:e}: {e:?}", basis.name());
                // No light where there is none, however close both directions are to the horizon.
                assert!(e.anywhere.iter().all(|e| *e <= 3.0 * tolerance), "{}: {e:?}", basis.name());
            }
        }
        // The check sees a surface that is a hundredth higher.
        let optics = optics(8.0, 1e-3);
        let heights = field.heights().iter().map(|h| h * 1.01).collect();
        let higher = HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights).unwrap();
        let found = answers(device, &layers_of(&higher, &optics).unwrap(), &optics, &queries);
        assert!(errors(&queries, &found, &reference, &optics).rms > 1e-3);
    });
}

/// A rough surface of `range` µm from peak to peak: every phase is in it.
fn rough(columns: usize, rows: usize, spacing: [f64; 2], range: f64, seed: u64) -> HeightField {
    let mut random = Random::new(seed);
    let mut heights: Vec<f64> = (0..columns * rows).map(|_| range * random.share()).collect();
    heights[0] = 0.0;
    if let Some(last) = heights.last_mut().filter(|_| columns * rows > 1) {
        *last = range;
    }
    HeightField::new(columns, rows, spacing, heights).unwrap()
}

#[test]
fn heights_from_flat_to_ten_micrometres_are_done_or_refused_by_every_basis() {
    let queries: Vec<Query> = end_queries().into_iter().step_by(3).collect();
    with_device(|device| {
        for basis in Basis::ALL {
            let mut line = String::new();
            for range in [0.0, 1e-4, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0] {
                let field = rough(12, 9, [0.12, 0.1], range, 7);
                let optics = Optics { basis, ..optics(3.0, 1e-2) };
                let layers = match layers_of(&field, &optics) {
                    Ok(layers) => layers,
                    Err(e) => {
                        let e = e.to_string();
                        assert!(range >= 0.3, "{} refuses {range} um: {e}", basis.name());
                        assert!(e.contains("; ") && e.contains("tolerance"), "{e}");
                        line += &format!(" {range}: refused");
                        continue;
                    }
                };
                let found = answers(device, &layers, &optics, &queries);
                let e = errors(&queries, &found, &exact(&field, &optics, &queries), &optics);
                line += &format!(" {range}: {} terms, {e};", layers.terms);
                assert!(e.rms <= 1e-2, "{} at {range} um: {e:?}", basis.name());
            }
            eprintln!("heights: {}:{line}", basis.name());
        }
    });
}

#[test]
fn terms_and_wavelengths_at_their_ends_give_numbers() {
    let queries: Vec<Query> = end_queries().into_iter().step_by(5).collect();
    with_device(|device| {
        for basis in Basis::ALL {
            for range in [0.0, 3.0] {
                let field = rough(8, 8, [0.1, 0.1], range, 3);
                for terms in [1, 37, 128] {
                    let optics = Optics { basis, terms: Some(terms), ..optics(2.0, 1e-2) };
                    match layers_of(&field, &optics) {
                        Ok(layers) => drop(answers(device, &layers, &optics, &queries)),
                        Err(e) => assert!(e.to_string().contains("; ask for"), "{e}"),
                    }
                }
            }
        }
        let field = rough(8, 8, [0.1, 0.1], 0.3, 3);
        for wavelengths in [4, 401] {
            let optics = Optics { wavelengths: Some(wavelengths), ..optics(2.0, 1e-2) };
            let layers = layers_of(&field, &optics).unwrap();
            drop(answers(device, &layers, &optics, &queries));
        }
    });
}

/// The layers with every number times `scale`, in 16 bits where `half`.
fn scaled(layers: &Layers, scale: f32, half: bool) -> Layers {
    let numbers = (0..layers.texels.len()).map(|i| layers.texels.at(i) * scale).collect();
    Layers { texels: Texels::of(half, numbers), ..layers.clone() }
}

#[test]
fn sixteen_bit_layers_are_read_right_at_their_overflow_and_in_their_subnormals() {
    let optics = Optics { basis: Basis::Optimal, ..optics(4.0, 1e-1) };
    let layers = layers_of(&patch(SurfaceKind::Bumps, 2.0), &optics).unwrap();
    let largest = (0..layers.texels.len()).map(|i| layers.texels.at(i).abs()).fold(0.0, f32::max);
    let queries: Vec<Query> = end_queries()
        .into_iter()
        .filter(|q| clear(q) && q.pair.view.z > 0.01 && q.pair.light.z > 0.01)
        .collect();
    /// The largest 16-bit float and the smallest normal one.
    const ENDS: (f32, f32) = (65_504.0 * HALF_UNIT, 6.103_515_6e-5 * HALF_UNIT);
    with_device(|device| {
        // The largest number at the overflow, in the middle, and itself a subnormal with six bits left.
        for (name, scale, allowed) in [
            ("overflow", ENDS.0 / largest, 2e-3),
            ("middle", 1e-2, 2e-3),
            ("subnormal", 0.99 * ENDS.1 / largest, 1e-2),
        ] {
            let of = |half: bool| {
                let own = scaled(&layers, scale, half);
                assert!(own.texels.are_finite() && own.texels.is_half() == half);
                answers(device, &own, &optics, &queries)
            };
            let (wide, narrow) = (of(false), of(true));
            // Amplitudes, relative to the mirror peak's: what a texel is rounded by, however faint it is itself.
            let error =
                queries.iter().zip(wide.iter().zip(&narrow)).fold(0.0f64, |worst, (q, (wide, narrow))| {
                    let peak = promised(q, &optics) / FAINT * f64::from(scale).powi(2);
                    worst.max((narrow.sqrt() - wide.sqrt()).abs() / peak.sqrt())
                });
            eprintln!("halves: {name}: {error:.1e} of the peak's amplitude");
            assert!(error <= allowed, "{name}: {error}");
            assert!(wide.iter().any(|x| *x > 0.0) && narrow != wide, "{name}");
        }
        // Beyond the end there is no number, and that is known beforehand.
        assert!(!Texels::fit_halves(&[ENDS.0 * 1.001]) && Texels::fit_halves(&[ENDS.0]));
    });
}

#[test]
fn repeats_from_one_to_a_thousand_give_the_reference_picture() {
    let field = patch(SurfaceKind::Bumps, 2.0);
    let scene = Scene::open("sphere").unwrap();
    let lights = vec![Light::point(50.0, -40.0, 2.0)];
    let view = View::of(&scene, lights);
    let size = [24, 18];
    with_device(|device| {
        for copies in [[1, 1], [1, 1000], [1000, 1], [1000, 1000]] {
            let optics =
                Optics { coherence: Coherence::Repeats(copies), windows: Windows::ONE, ..Optics::default() };
            let optics = optics.for_pictures();
            let settings = LayerSettings {
                sigma: f64::INFINITY,
                shortest_wavelength: 0.38,
                budget: optics.budget().window,
                basis: optics.basis,
                terms: None,
                memory_limit: 1 << 30,
                side_limit: 16_384,
            };
            let layers = compute(&field, &settings, &Task::silent()).unwrap();
            let source = limited(grating(&layers, copies, &field), &field, &optics);
            let mut renderer = crate::renderer_of(device, &scene, &source, &optics, size).unwrap();
            let picture = renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap();
            let directions = [renderer.directions(&view, 0).unwrap()];
            let pictured = Pictured { field: &field, optics: &optics, view: &view, size };
            let name = format!("small-sphere-bumps-repeated-{}x{}", copies[0], copies[1]);
            let exact = pictured.kept_by(device, &name, &directions);
            assert!(picture.radiance.iter().flatten().all(|x| x.is_finite()), "{copies:?}");
            let errors = [0, 1, 2].map(|c| channel(&picture.radiance, &exact, c));
            eprintln!("repeats: {copies:?}: {errors:.5?}");
            assert!(errors.iter().all(|e| *e <= 1e-2), "{copies:?}: {errors:?}");
        }
    });
}

/// A value out of `ends` three times in four, else between them on a logarithmic scale.
fn ended(ends: &'static [f64]) -> impl Strategy<Value = f64> {
    let (low, high) = (ends[0].max(1e-9), ends[ends.len() - 1]);
    prop_oneof![3 => prop::sample::select(ends), 1 => (low.ln()..high.ln()).prop_map(f64::exp)]
}

#[derive(Clone, Debug)]
struct Case {
    size: (usize, usize),
    spacing: (f64, f64),
    range: f64,
    length: f64,
    tolerance: f64,
    basis: Basis,
    seed: u64,
}

fn case() -> impl Strategy<Value = Case> {
    let side = prop_oneof![2 => Just(1usize), 1 => Just(2), 2 => 3usize..24, 1 => Just(97)];
    let spacing = || ended(&[1e-3, 0.01, 0.095, 0.1, 0.2, 1.0, 10.0]);
    (
        (side.clone(), side),
        (spacing(), spacing()),
        ended(&[0.0, 1e-4, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0]),
        ended(&[0.1, 0.4, 2.0, 6.0, 65.0, 1e4]),
        ended(&[1e-6, 1e-3, 1e-2, 1e-1, 1.0]),
        prop::sample::select(&Basis::ALL[..]),
        any::<u64>(),
    )
        .prop_map(|(size, spacing, range, length, tolerance, basis, seed)| Case {
            size,
            spacing,
            range,
            length,
            tolerance,
            basis,
            seed,
        })
}

#[test]
fn combinations_of_ends_are_done_within_their_tolerance_or_refused_with_a_remedy() {
    const CASES: u32 = 48;
    /// Directions that are compared with the direct sum, which takes long where samples are fine.
    const COMPARED: usize = 40;
    /// Of those that are done every so many is tried on the device, where making pipelines takes long.
    const EACH: u32 = 4;
    let queries = end_queries();
    let tally = RefCell::new((0, 0, (0.0, String::new())));
    with_device(|device| {
        let config = Config { cases: CASES, failure_persistence: None, ..Config::default() };
        let mut runner = TestRunner::new_with_rng(
            config,
            prop::test_runner::TestRng::deterministic_rng(prop::test_runner::RngAlgorithm::ChaCha),
        );
        let run = runner.run(&case(), |case| {
            let field =
                rough(case.size.0, case.size.1, [case.spacing.0, case.spacing.1], case.range, case.seed);
            let optics = Optics {
                basis: case.basis,
                tolerance: case.tolerance,
                coherence: Coherence::Gaussian { length: case.length },
                windows: Windows::ONE,
                ..Optics::default()
            };
            let layers = match layers_of(&field, &optics) {
                Ok(layers) => layers,
                Err(e) => {
                    let e = e.to_string();
                    prop_assert!(e.contains("; ") && !e.contains("NaN") && !e.contains("inf"), "{}", e);
                    tally.borrow_mut().1 += 1;
                    return Ok(());
                }
            };
            prop_assert!(layers.texels.are_finite());
            tally.borrow_mut().0 += 1;
            if tally.borrow().0 % EACH != 1 {
                return Ok(());
            }
            let start = case.seed as usize % 7;
            let some: Vec<Query> =
                queries.iter().skip(start).step_by(queries.len() / COMPARED).copied().collect();
            let found = answers(device, &layers, &optics, &some);
            let rms = errors(&some, &found, &exact(&field, &optics, &some), &optics).rms;
            let mut tally = tally.borrow_mut();
            if rms / case.tolerance > tally.2.0 {
                tally.2 = (rms / case.tolerance, format!("{rms:.1e} of {:.0e}: {case:?}", case.tolerance));
            }
            Ok(())
        });
        run.unwrap();
    });
    let (done, refused, worst) = tally.into_inner();
    eprintln!("combinations: {done} done, {refused} refused; worst {worst:?}");
    assert!(done >= CASES / 4 && refused > 0, "{done} done, {refused} refused");
    assert!(worst.0 <= 1.0, "{worst:?}");
}

/// A mesh file with frames that are hard to interpolate between.
fn meshes() -> [(&'static str, String); 6] {
    let corners = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\n";
    let two = |a: &str, b: &str| format!("f {a}\nf {b}\n");
    [
        (
            "opposite normals",
            format!(
                "{corners}vn 0 1 0\nvn 0 -1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n{}",
                two("3/3/2 2/2/1 1/1/1", "1/1/1 4/4/2 3/3/2")
            ),
        ),
        (
            "mirrored texture coordinates",
            format!("{corners}vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n{}", two("3/3 2/2 1/1", "1/1 4/4 3/1")),
        ),
        (
            "texture coordinates of no area",
            format!("{corners}vt 0 0\nvt 1 1\nvt 2 2\nvt 0 0\n{}", two("3/3 2/2 1/1", "1/1 4/4 3/3")),
        ),
        ("a needle", format!("{corners}v 0 0 1.00001\n{}", two("3 2 1", "4 5 3"))),
        (
            "tangents that turn over",
            format!("{corners}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n{}", two("3/1 2/2 1/3", "1/3 4/2 3/4")),
        ),
        (
            "a triangle seen from its edge",
            format!("{corners}v 0 5 0\nv 0 5 1\nv 0 -5 0\n{}f 5 6 7\n", two("3 2 1", "1 4 3")),
        ),
    ]
}

#[test]
fn interpolated_frames_and_exposures_at_the_ends_give_no_pixel_that_is_not_a_number() {
    let field = patch(SurfaceKind::Bumps, 2.0);
    let optics = optics(4.0, 1e-1);
    let layers = layers_of(&field, &optics).unwrap();
    with_device(|device| {
        for (name, text) in meshes() {
            let mesh = diffract::internals::scene::obj::from_bytes(text.as_bytes())
                .unwrap_or_else(|e| panic!("{name}: {e}"));
            let mesh = mesh.turned(|[x, y, z]| [x, -z, y]);
            let mut scene = Scene::open("plate").unwrap();
            scene.main_object_mut().mesh = mesh;
            let lights = [[0.0, 0.0], [89.9999, 10.0], [90.0, 200.0], [45.0, -90.0]]
                .map(|[theta, phi]| Light::point(theta, phi, 1.0));
            let mut view = View::of(&scene, lights.to_vec());
            let size = [65, 49]; // odd: a pixel's centre lies on the axes of symmetry
            let mut renderer = crate::renderer_of(device, &scene, &window(&layers), &optics, size).unwrap();
            for eye in [[0.0, 0.0, 3.0], [3.0, 0.0, 1e-4], [2.0, -2.0, 1.0], [0.0, 0.0, -3.0]] {
                view.camera = diffract::internals::scene::Camera::looking(
                    eye.into(),
                    glam::Vec3::ZERO,
                    Lens::perspective(0.9),
                )
                .unwrap();
                for exposure in [-40.0, 0.0, 40.0] {
                    let picture = renderer.render_plain(&view, exposure, DVec3::splat(0.01)).unwrap();
                    for (i, pixel) in picture.radiance.iter().enumerate() {
                        assert!(
                            pixel.iter().all(|x| x.is_finite()),
                            "{name} from {eye:?}: pixel {i} is {pixel:?}"
                        );
                    }
                    for tone in Tone::ALL {
                        let shown = Shown { exposure, tone, background: DVec3::splat(0.01) };
                        assert!(renderer.display(size, shown).unwrap());
                        let display = renderer.read_back().unwrap().display;
                        for (a, b) in display.iter().zip(&displayed(&picture.radiance, shown)) {
                            let far = (0..4).any(|c| a[c].abs_diff(b[c]) > 1);
                            assert!(
                                !far,
                                "{name} at {exposure} EV by {tone:?}: {a:?} is displayed for {b:?}"
                            );
                        }
                    }
                }
            }
        }
    });
}
