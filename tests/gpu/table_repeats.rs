//! Colour tables through repeats of the patch against the direct f64 sum.

use crate::device::with_device;
use crate::evaluation::{patch, tabled};
use crate::measure::channel;
use crate::table::{by_reference, colours, errors, table};
use diffract::optics::coherence::Coherence;
use diffract::optics::reference::Reference;
use diffract::render::color_table::Filter;
use diffract::render::evaluator::{Evaluator, Query};
use diffract::render::frame::View;
use diffract::render::picture::Painter;
use diffract::render::pigment::Pigment;
use diffract::render::reference_picture::reference_picture;
use diffract::render::shading::Shading;
use diffract::scene::{Light, Scene};
use diffract::surface::HeightField;
use diffract::surface::synth::Kind;
use glam::DVec3;

fn shading(copies: [u32; 2], tolerance: f64) -> Shading {
    Shading { coherence: Coherence::Repeats(copies), tolerance, ..Shading::default() }
}

/// Colours of `field` through each of `copies` within each of `tolerances`, and a tenth more of height is seen.
fn meets_its_tolerance(field: &HeightField, seed: u64, copies: &[[u32; 2]], tolerances: &[f64]) {
    let queries = colours(seed, 200);
    with_device(|device| {
        for &copies in copies {
            let exact = by_reference(field, &shading(copies, 1.0), &queries);
            for &tolerance in tolerances {
                let shading = shading(copies, tolerance);
                let table = table(device, field, &shading);
                let mut evaluator = Evaluator::new(device, &tabled(&table, Filter::Point), &shading).unwrap();
                let found = evaluator.cosine_weighted(&queries).unwrap();
                let [whole, median, p99] = errors(&found, &exact);
                let grid = table.grid;
                eprintln!(
                    "{copies:?} at {tolerance:e}: {whole:.2e}, median {median:.2e}, p99 {p99:.2e}; {grid:?}"
                );
                assert!(whole <= tolerance, "{copies:?} at {tolerance}: {whole:e}");
                // Other copies of the same patch look different.
                let other = by_reference(field, &self::shading([copies[0] + 1, copies[1]], 1.0), &queries);
                assert!(errors(&found, &other)[1] > 2.0 * median, "one copy more makes no difference");
            }
        }
    });
}

#[test]
fn a_table_through_repeats_meets_its_tolerance_on_an_elaphe_skin() {
    meets_its_tolerance(&patch(Kind::Elaphe, 6.0), 51, &[[1, 1], [3, 3], [2, 5]], &[1e-1, 2e-2, 5e-3]);
}

#[test]
fn a_table_through_repeats_meets_its_tolerance_on_a_blaze() {
    meets_its_tolerance(&patch(Kind::Blaze, 7.5), 52, &[[1, 1], [3, 3], [2, 5]], &[1e-1, 2e-2]);
}

#[test]
fn a_table_through_repeats_meets_its_tolerance_on_bumps() {
    meets_its_tolerance(&patch(Kind::Bumps, 4.0), 53, &[[1, 1], [3, 3], [2, 5]], &[1e-1, 2e-2]);
}

#[test]
fn a_table_through_many_repeats_sums_its_orders() {
    // Along x orders alone, or orders and odd parts: the patterns that few copies never take.
    meets_its_tolerance(&patch(Kind::Blaze, 2.5), 54, &[[12, 2], [1, 20]], &[1e-1, 2e-2]);
}

#[test]
fn windows_of_repeats_are_averaged_as_the_reference_averages_them() {
    let field = patch(Kind::Elaphe, 6.0);
    let queries = colours(55, 100);
    let shading = Shading { windows: [3, 2], ..shading([2, 1], 2e-2) };
    let exact = |windows| -> Vec<DVec3> {
        let reference = Reference::new(&field, shading.coherence, windows, shading.ior);
        let colour = |q: &Query| reference.cosine_weighted_xyz(&q.pair, &shading.illuminant).unwrap();
        queries.iter().map(colour).collect()
    };
    with_device(|device| {
        let table = table(device, &field, &shading);
        let mut evaluator = Evaluator::new(device, &tabled(&table, Filter::Point), &shading).unwrap();
        let found = evaluator.cosine_weighted(&queries).unwrap();
        let [whole, median, p99] = errors(&found, &exact([3, 2]));
        eprintln!("windows of repeats: {whole:.2e}, median {median:.2e}, p99 {p99:.2e}");
        assert!(whole <= shading.tolerance, "{whole:e}");
        assert!(errors(&found, &exact([1, 1]))[1] > 2.0 * median, "one window looks the same");
    });
}

const SIZE: [u32; 2] = [96, 72];

#[test]
fn a_picture_by_a_table_of_repeats_is_the_reference_picture_within_its_tolerance() {
    let scene = Scene::open("sphere").unwrap();
    let lights = vec![
        Light { theta: 45.0, phi: -40.0, intensity: 2.0 },
        Light { theta: 70.0, phi: 60.0, intensity: 0.7 },
    ];
    let view = View::of(&scene, lights);
    with_device(|device| {
        for (kind, copies, tolerance) in
            [(Kind::Elaphe, [3, 3], 2e-2), (Kind::Blaze, [3, 3], 1e-1), (Kind::Bumps, [2, 5], 2e-2)]
        {
            let field = patch(kind, 6.0);
            let shading = shading(copies, tolerance).for_pictures();
            let table = table(device, &field, &shading);
            let source = tabled(&table, Filter::Point);
            let lights = view.lights.len();
            let mut painter =
                Painter::new(device, &source, &shading, &scene.mesh, &Pigment::white(), SIZE, lights)
                    .unwrap();
            let picture = painter.paint(&view, 0.0, DVec3::ZERO).unwrap().radiance;
            let directions: Vec<_> =
                (0..lights).map(|light| painter.directions(&view, light).unwrap()).collect();
            let exact = reference_picture(&field, &shading, &view, &directions, &|_, _| Ok(())).unwrap();
            let errors = [0, 1, 2].map(|c| channel(&picture, &exact, c));
            eprintln!("{kind:?} through {copies:?} at {tolerance:e}: {errors:.5?}");
            assert!(errors.iter().all(|&e| e <= tolerance), "{kind:?}: {errors:?}");
        }
    });
}
