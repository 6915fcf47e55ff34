//! Pictures through repeats against the f64 reference picture, for few copies, whose factor is resolved, and for many, whose
//! orders are summed.

use crate::device::with_device;
use crate::evaluation::{grating, limited, patch, queries};
use crate::measure::channel;
use crate::shared::Pictured;
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::optics::nufft::cosine_weighted_xyz;
use diffract::internals::optics::reference::Reference;
use diffract::internals::optics::spectrum::Illuminant;
use diffract::internals::render::directions::Directions;
use diffract::internals::render::evaluator::Query;
use diffract::internals::render::frame::View;
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::renderer::Picture;
use diffract::internals::scene::{Light, Scene};
use diffract::internals::settings::Optics;
use diffract::internals::spectra::amplitude::{LayerSettings, Layers, compute};
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use glam::DVec3;
use std::sync::Arc;

const SIZE: [u32; 2] = [64, 48];

fn optics(copies: [u32; 2], tolerance: f64) -> Optics {
    let coherence = Coherence::Repeats(copies);
    Optics { coherence, windows: Windows::ONE, tolerance, ..Optics::default() }.for_pictures()
}

/// The layers of one period.
fn layers(field: &HeightField, optics: &Optics) -> Layers {
    let settings = LayerSettings {
        sigma: f64::INFINITY,
        shortest_wavelength: 0.38,
        budget: optics.budget().window,
        basis: optics.basis,
        terms: None,
        memory_limit: 1 << 30,
        side_limit: 16_384,
    };
    compute(field, &settings, &Task::silent()).unwrap()
}

/// A picture through the copies that `optics` names, with the directions that it shaded.
fn paint(
    device: &Arc<Device>,
    field: &HeightField,
    optics: &Optics,
    scene: &Scene,
    view: &View,
) -> (Picture, Vec<Directions>) {
    let Coherence::Repeats(copies) = optics.coherence else { panic!("{optics:?} has a window") };
    let layers = layers(field, optics);
    let source = limited(grating(&layers, copies, field), field, optics);
    let (mesh, lights) = (&scene.main_object().mesh, view.lights.len());
    let mut renderer = crate::renderer(device, &source, optics, mesh, &Pigment::white(), SIZE).unwrap();
    let picture = renderer.render_plain(view, 0.0, DVec3::ZERO).unwrap();
    let directions = (0..lights).map(|light| renderer.directions(view, light).unwrap()).collect();
    (picture, directions)
}

#[test]
fn answers_through_repeats_are_the_reference_within_their_tolerance() {
    let queries: Vec<Query> =
        queries(11, 400).into_iter().map(|query| Query { wavelength: None, ..query }).collect();
    with_device(|device| {
        let scene = Scene::open("plate").unwrap();
        let mesh = &scene.main_object().mesh;
        for (copies, other) in [([3, 3], [3, 4]), ([20, 2], [19, 2])] {
            let (field, tolerance) = (patch(SurfaceKind::Blaze, 7.0), 1e-2);
            let exact: Vec<DVec3> = {
                let reference = Reference::new(&field, Coherence::Repeats(copies), [1, 1], 1.5);
                let pairs: Vec<_> = queries.iter().map(|query| query.pair).collect();
                cosine_weighted_xyz(&reference, &Illuminant::D65, &pairs, &Task::silent()).unwrap()
            };
            let answers = |copies| {
                let optics = optics(copies, tolerance);
                let layers = layers(&field, &optics);
                let source = grating(&layers, copies, &field);
                let mut renderer =
                    crate::renderer(device, &source, &optics, mesh, &Pigment::white(), SIZE).unwrap();
                let single = Query { wavelength: Some(0.5), ..queries[0] };
                assert!(renderer.cosine_weighted(&[single]).is_err(), "wavelengths are chosen by the shader");
                renderer.cosine_weighted(&queries).unwrap()
            };
            let error = |copies| {
                let found = answers(copies);
                let sum = |of: &dyn Fn(DVec3, DVec3) -> f64| -> f64 {
                    exact.iter().zip(&found).map(|(exact, got)| of(*exact, *got)).sum()
                };
                (sum(&|exact, got| (got - exact).length_squared()) / sum(&|exact, _| exact.length_squared()))
                    .sqrt()
            };
            let (right, wrong) = (error(copies), error(other));
            eprintln!("{copies:?}: {right:.1e}, as {other:?}: {wrong:.1e}");
            assert!(right <= tolerance && wrong > 2.0 * tolerance, "{copies:?}: {right} {wrong}");
        }
    });
}

/// Pictures of a patch of `kind`, `side` \[µm\] long, through each of `copies` are the reference picture within each of `tolerances`,
/// and through the others beside them are not.
fn pictures_meet_their_tolerance(cases: &[(SurfaceKind, f64, [u32; 2], [u32; 2])], tolerances: &[f64]) {
    let scene = Scene::open("sphere").unwrap();
    let lights = vec![Light::point(45.0, -40.0, 2.0), Light::point(70.0, 60.0, 0.7)];
    let view = View::of(&scene, lights);
    let errors =
        |picture: &Picture, exact: &[[f32; 4]]| [0, 1, 2].map(|c| channel(&picture.radiance, exact, c));
    with_device(|device| {
        for &(kind, side, copies, other) in cases {
            let field = patch(kind, side);
            let mut exact: Option<Vec<[f32; 4]>> = None;
            for &tolerance in tolerances {
                let (picture, directions) = paint(device, &field, &optics(copies, tolerance), &scene, &view);
                let exact = exact.get_or_insert_with(|| {
                    let optics = optics(copies, tolerance);
                    let pictured = Pictured { field: &field, optics: &optics, view: &view, size: SIZE };
                    let name = format!("sphere-{}-repeated-{}x{}", kind.name(), copies[0], copies[1]);
                    pictured.kept_by(device, &name, &directions)
                });
                let errors = errors(&picture, exact);
                eprintln!("{kind:?} through {copies:?} at {tolerance:e}: {errors:.5?}");
                assert!(errors.iter().all(|&e| e <= tolerance), "{copies:?} at {tolerance}: {errors:?}");
            }
            let (wrong, _) = paint(device, &field, &optics(other, 1e-2), &scene, &view);
            let wrong = errors(&wrong, exact.as_deref().unwrap());
            assert!(wrong.iter().any(|&e| e > 2e-2), "{other:?} pass for {copies:?}: {wrong:?}");
        }
    });
}

#[test]
fn a_picture_through_repeats_is_the_reference_picture_within_its_tolerance() {
    let cases = [
        (SurfaceKind::Elaphe, 7.0, [1, 1], [2, 1]),
        (SurfaceKind::Blaze, 7.0, [3, 3], [4, 3]),
        (SurfaceKind::Elaphe, 7.0, [2, 5], [2, 6]),
        (SurfaceKind::Blaze, 7.0, [26, 1], [23, 1]),
        (SurfaceKind::Elaphe, 7.0, [1, 40], [2, 40]),
        (SurfaceKind::Blaze, 7.0, [60, 60], [50, 60]),
    ];
    pictures_meet_their_tolerance(&cases, &[1e-1, 1e-2, 1e-3]);
}

#[test]
fn a_picture_through_a_million_copies_is_the_reference_picture_within_its_tolerance() {
    pictures_meet_their_tolerance(&[(SurfaceKind::Bumps, 2.0, [1000, 1000], [1000, 100])], &[1e-1, 1e-2]);
}
