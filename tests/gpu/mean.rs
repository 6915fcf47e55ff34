//! The mean over all windows on the device, by a colour table, against the f64 mean.

use crate::device::with_device;
use crate::evaluation::{colours, patch, queries};
use crate::measure::channel;
use crate::shared::{self, Pictured};
use diffract::internals::brdf::albedo::Decimation;
use diffract::internals::brdf::mean::MeanBrdf;
use diffract::internals::brdf::tabulated::{SummedOrders, TabulatedMean};
use diffract::internals::filter::{Covariance, FootprintSizes, MOST_OF_ROW};
use diffract::internals::measure::error;
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::optics::energy::EnergyLimit;
use diffract::internals::optics::material::Material;
use diffract::internals::optics::polarisation::Polarisation;
use diffract::internals::optics::reference::Reference;
use diffract::internals::optics::reflectance::{Film, Reflectance};
use diffract::internals::optics::spectrum::{Illuminant, SHORTEST};
use diffract::internals::render::directions::Directions;
use diffract::internals::render::evaluator::Evaluator;
use diffract::internals::render::footprints::sizes_of;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::light_passes::LightPass;
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::reference_picture::covered;
use diffract::internals::render::sampling::Sampling;
use diffract::internals::render::source::{ClassicalGrating, Source};
use diffract::internals::scene::{Camera, Light, Scene};
use diffract::internals::settings::{Method, Optics};
use diffract::internals::setup::SourceSettings;
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use glam::{DVec3, Vec3, Vec4};
use std::sync::Arc;

/// Of the mean over all windows.
pub fn optics(length: f64, tolerance: f64) -> Optics {
    let coherence = Coherence::Gaussian { length };
    Optics { coherence, windows: Windows::All, tolerance, ..Optics::default() }
}

/// What is shaded from, for pixels with these `footprints`.
pub fn source(
    device: &Arc<Device>,
    field: &HeightField,
    optics: &Optics,
    method: Method,
    footprints: FootprintSizes,
) -> Source {
    let settings = SourceSettings::new(Optics { method, ..optics.clone() });
    let settings = SourceSettings { footprints, ..settings };
    shared::source(device, field, &settings)
}

fn mean(field: &HeightField, optics: &Optics) -> MeanBrdf {
    let sigma = optics.coherence.sigma().unwrap();
    MeanBrdf { field: field.clone(), sigma, beyond: optics.beyond, reflectance: optics.reflectance.clone() }
}

/// Twice as high.
fn higher(field: &HeightField) -> HeightField {
    let heights = field.heights().iter().map(|h| h * 2.0).collect();
    HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights).unwrap()
}

/// ‖found − exact‖/‖exact‖ over all directions.
fn relative(found: &[DVec3], exact: &[DVec3]) -> f64 {
    assert!(found.len() == exact.len() && found.iter().all(|f| f.is_finite()));
    let difference: f64 = found.iter().zip(exact).map(|(f, e)| (*f - *e).length_squared()).sum();
    (difference / exact.iter().map(|e| e.length_squared()).sum::<f64>()).sqrt()
}

#[test]
fn colours_by_a_table_meet_their_tolerance() {
    let tolerances = [1e-1, 2e-2];
    let queries = colours(21, 300);
    let asked: Vec<_> = queries.iter().map(|q| (q.pair, Covariance::default())).collect();
    with_device(|device| {
        for (kind, side, length) in [
            (SurfaceKind::Elaphe, 12.0, 16.0),
            (SurfaceKind::Blaze, 10.0, 16.0),
            (SurfaceKind::Bumps, 4.0, 12.0),
        ] {
            let field = patch(kind, side);
            let any = optics(length, 1.0);
            let table = TabulatedMean::new(mean(&field, &any), SHORTEST, &Task::silent()).unwrap();
            let exact = table.xyz(&any.illuminant, &asked, SummedOrders::All, &Task::silent()).unwrap();
            for tolerance in tolerances {
                let optics = optics(length, tolerance);
                let answers = |field: &HeightField| {
                    let source = source(device, field, &optics, Method::Table, FootprintSizes::default());
                    let mut evaluator = Evaluator::new(device, &source, &optics).unwrap();
                    evaluator.cosine_weighted(&queries).unwrap()
                };
                let error = relative(&answers(&field), &exact);
                eprintln!("{} at {tolerance:e}: {error:.2e}", kind.name());
                assert!(error <= tolerance, "{} at {tolerance}: {error:e}", kind.name());
                if tolerances.last() == Some(&tolerance) {
                    let wrong = relative(&answers(&higher(&field)), &exact);
                    assert!(wrong > 1.5 * tolerance, "{}: twice the height makes {wrong:e}", kind.name());
                }
            }
        }
    });
}

#[test]
fn materials_and_films_keep_the_tolerance_by_every_source() {
    let material = |name: &str| Material::from_name_or_file(name).unwrap();
    let film = |thickness, index| Some(Film { thickness, index });
    let queries = colours(22, 60);
    let asked: Vec<_> = queries.iter().map(|q| (q.pair, Covariance::default())).collect();
    let field = patch(SurfaceKind::Elaphe, 8.0);
    let tolerance = 2e-2;
    with_device(|device| {
        for (name, film, light) in [
            ("gold", None, Polarisation::None),
            ("glass", film(1.9, 1.33), Polarisation::None),
            ("glass", None, Polarisation::Te),
            ("glass", None, Polarisation::Tm),
        ] {
            let reflectance = Reflectance::of_material(material(name), film).polarised(light);
            let of = |windows| Optics { windows, reflectance: reflectance.clone(), ..optics(8.0, tolerance) };
            let whole = || mean(&field, &of(Windows::All));
            let table = TabulatedMean::new(whole(), SHORTEST, &Task::silent()).unwrap();
            let table = table.limited(Decimation::Coarse);
            let limit = TabulatedMean::limit_of(whole(), SHORTEST, &Task::silent()).unwrap();
            let exact = table.xyz(&Illuminant::D65, &asked, SummedOrders::All, &Task::silent()).unwrap();
            let one = Reference::new(&field, of(Windows::ONE).coherence, [1, 1], reflectance.clone())
                .limited(limit.map(|limit| limit as Arc<dyn EnergyLimit>));
            let of_window: Vec<DVec3> =
                queries.iter().map(|q| one.cosine_weighted_xyz(&q.pair, &Illuminant::D65).unwrap()).collect();
            for (windows, method, exact) in
                [(Windows::All, Method::Table, &exact), (Windows::ONE, Method::Spectral, &of_window)]
            {
                let answers = |optics: &Optics| {
                    let source = source(device, &field, optics, method, FootprintSizes::default());
                    Evaluator::new(device, &source, optics).unwrap().cosine_weighted(&queries).unwrap()
                };
                let error = relative(&answers(&of(windows)), exact);
                eprintln!("{name}, {film:?}, {light:?}, {windows:?} by {}: {error:.2e}", method.name());
                assert!(error <= tolerance, "{name}, {windows:?} by {}: {error:e}", method.name());
                // Schlick's dielectric is far from it.
                let plain = relative(&answers(&Optics { windows, ..optics(8.0, tolerance) }), exact);
                assert!(plain > 2.0 * tolerance, "{name} by {}: {plain:e}", method.name());
            }
        }
    });
}

#[test]
fn a_table_refuses_single_wavelengths() {
    let (field, optics) = (patch(SurfaceKind::Elaphe, 4.0), optics(16.0, 1e-1));
    with_device(|device| {
        let table = source(device, &field, &optics, Method::Table, FootprintSizes::default());
        let mut evaluator = Evaluator::new(device, &table, &optics).unwrap();
        assert!(evaluator.cosine_weighted(&queries(22, 1)).is_err(), "a table holds colours");
    });
}

const SIZE: [u32; 2] = [64, 48];

/// The directions of each light of `view`, with footprints.
fn directions(device: &Arc<Device>, scene: &Scene, view: &View) -> Vec<Directions> {
    let source = Source::ClassicalGrating(ClassicalGrating::default());
    let (optics, pigment, lights) = (Optics::default(), Pigment::white(), view.lights.len());
    let mut renderer =
        crate::renderer(device, &source, &optics, &scene.main_object().mesh, &pigment, SIZE).unwrap();
    (0..lights).map(|light| renderer.directions(view, light).unwrap()).collect()
}

#[test]
fn a_picture_by_a_table_is_near_the_reference_picture_over_the_same_footprints() {
    let allowed = TABLE_OVER_FOOTPRINTS;
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let scene = Scene::open("sphere").unwrap();
    let lights = vec![Light::point(45.0, -40.0, 2.0), Light::point(70.0, 60.0, 0.7)];
    let view = View::of(&scene, lights);
    let optics = optics(16.0, 2e-2).for_pictures();
    with_device(|device| {
        let seen = directions(device, &scene, &view);
        let source = source(device, &field, &optics, Method::Table, sizes_of(&seen));
        let mesh = &scene.main_object().mesh;
        let mut renderer = crate::renderer(device, &source, &optics, mesh, &Pigment::white(), SIZE).unwrap();
        let mut paint = |view: &View| renderer.render_plain(view, 0.0, DVec3::ZERO).unwrap().radiance;
        let pictured = Pictured { field: &field, optics: &optics, view: &view, size: SIZE };
        let exact = pictured.kept_by(device, "sphere-elaphe", &seen);
        let errors = |found: &[[f32; 4]]| [0, 1, 2].map(|c| channel(found, &exact, c));
        let found = errors(&paint(&view));
        eprintln!("pictures by a table: {found:.4?}");
        // Without footprints the reference is another picture.
        let points: Vec<Directions> =
            seen.iter().map(|seen| Directions { footprints: Vec::new(), ..seen.clone() }).collect();
        let sharp = pictured.kept_by(device, "sphere-elaphe-points", &points);
        let without = [0, 1, 2].map(|c| channel(&sharp, &exact, c));
        let mut moved = view.clone();
        moved.lights[0] = Light::point(50.0, -40.0, 2.0);
        let wrong = errors(&paint(&moved));
        eprintln!("without footprints {without:.4?}, under a moved light {wrong:.4?}");
        assert!(wrong.iter().zip(&found).all(|(wrong, found)| *wrong > 1.3 * found), "{wrong:?}");
        assert!(without.iter().all(|&e| e > allowed), "{without:?}");
        assert!(found.iter().all(|&e| e <= allowed), "{found:?}");
    });
}

/// Relative L2 error that is measured for one sample of this sphere, whose footprints are up to a hundred times as wide as an order.
const TABLE_OVER_FOOTPRINTS: f64 = 0.0225;

/// The same for 16 samples under one light, which is seen at a narrower highlight.
const TABLE_OF_SAMPLES: f64 = 0.006;

/// The same for single samples of a light that moves.
const TABLE_OF_FRAMES: f64 = 0.039;

#[test]
fn a_material_reflects_at_the_angle_of_the_pixel_where_its_footprint_reaches_far() {
    // The scales are smaller than these pixels, whose footprints reach over half of all directions.
    let scene = Scene::open("skin").unwrap();
    let light = Light::point(41.0, 61.0, 1.0);
    let mut view = View::of(&scene, vec![light]);
    let eye = Vec3::new(-2.42, 1.7, 1.74);
    view.camera = Camera::looking(eye, scene.camera.target, scene.camera.lens).unwrap();
    let reflectance = scene.main_object().reflectance.clone().unwrap();
    assert!(reflectance.is_spectral(), "the scene has a material");
    // A mirror is in closed form. Of a patch of few orders a Gaussian so wide is read from the coarsest level, by cubics that hold colours over |w|
    // at one place of (u, v).
    for (kind, allowed) in [(SurfaceKind::Flat, 0.02), (SurfaceKind::Elaphe, 0.07)] {
        let field = patch(kind, 4.0);
        let optics = Optics { reflectance: reflectance.clone(), ..optics(8.0, 2e-2) }.for_pictures();
        with_device(|device| {
            let seen = directions(device, &scene, &view);
            let exact = Pictured { field: &field, optics: &optics, view: &view, size: SIZE }.by(&seen);
            let source = source(device, &field, &optics, Method::Table, sizes_of(&seen));
            let mut renderer = crate::renderer_of(device, &scene, &source, &optics, SIZE).unwrap();
            let found = renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap().radiance;
            let errors = [0, 1, 2].map(|c| channel(&found, &exact, c));
            eprintln!("{} under large pixels: {errors:.4?}", kind.name());
            assert!(errors.iter().all(|&e| e <= allowed), "{errors:?}");
        });
    }
}

#[test]
fn sixteen_samples_are_near_the_reference_of_the_same_samples() {
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let scene = Scene::open("sphere").unwrap();
    let view = View::of(&scene, vec![Light::point(45.0, -40.0, 2.0)]);
    let optics = optics(16.0, 2e-2).for_pictures();
    let sampling = Sampling { count: 16, seed: 7 };
    let shown = Shown::plain(0.0, DVec3::ZERO);
    with_device(|device| {
        let probe = Source::ClassicalGrating(ClassicalGrating::default());
        let new = |source: &Source| crate::renderer_of(device, &scene, source, &optics, SIZE).unwrap();
        let mut directions = new(&probe);
        let least = sizes_of(&[directions.directions_of(&view, 0, &sampling.sample(0)).unwrap()]);
        let mut seen = |pass: &LightPass| directions.directions_in(&view, pass);
        let pictured = Pictured { field: &field, optics: &optics, view: &view, size: SIZE };
        let exact = pictured.kept_mean(device, "sphere-elaphe-16", &sampling, &mut seen);
        let source = source(device, &field, &optics, Method::Table, least);
        let found = new(&source).render(&view, &sampling, shown, &Task::silent()).unwrap().radiance;
        let errors = [0, 1, 2].map(|c| channel(&found, &exact, c));
        eprintln!("16 samples: {errors:.4?}");
        assert!(errors.iter().all(|&e| e <= TABLE_OF_SAMPLES), "{errors:?}");
    });
}

/// Over a turntable the pictures change from frame to frame as the reference does: taps that find and miss orders in turn would shimmer.
#[test]
fn a_turntable_does_not_shimmer() {
    const FRAMES: usize = 24;
    const STEP: f64 = 1.5; // degrees, an order and more from frame to frame
    const COMPARED: usize = 60;
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let scene = Scene::open("sphere").unwrap();
    let optics = optics(16.0, 2e-2).for_pictures();
    let view_of = |frame: usize| {
        let phi = -40.0 + STEP * frame as f64;
        View::of(&scene, vec![Light::point(45.0, phi, 2.0)])
    };
    with_device(|device| {
        let first = directions(device, &scene, &view_of(0));
        let pixels = error::sample(&covered(&first), COMPARED);
        let source = source(device, &field, &optics, Method::Table, sizes_of(&first));
        let mesh = &scene.main_object().mesh;
        let mut renderer = crate::renderer(device, &source, &optics, mesh, &Pigment::white(), SIZE).unwrap();
        let reference = shared::reference(&field, &optics);
        let mut colors_of = |frame: usize| -> [Vec<DVec3>; 2] {
            let view = view_of(frame);
            let picture = renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap().radiance;
            let found = pixels.iter().map(|&i| Vec4::from(picture[i]).truncate().as_dvec3()).collect();
            let seen = directions(device, &scene, &view);
            [found, reference.colors(&view, 0, &seen, &pixels, &Task::silent()).unwrap()]
        };
        let all: Vec<[Vec<DVec3>; 2]> = (0..FRAMES).map(&mut colors_of).collect();
        // RMS change of all pixels from each frame to the next, relative to the mean brightness of both.
        let change = |which: usize| -> f64 {
            let changes = all.windows(2).flat_map(|two| two[0][which].iter().zip(&two[1][which]));
            let parts = changes.map(|(a, b)| ((*a - *b).length_squared(), 0.5 * (*a + *b).length_squared()));
            let (change, size) = parts.fold((0.0, 0.0), |(c, s), (x, y)| (c + x, s + y));
            (change / size).sqrt()
        };
        let (found, exact) = (change(0), change(1));
        eprintln!("change from frame to frame: {found:.4}, of the reference {exact:.4}");
        assert!(exact > 0.01, "the frames are the same: {exact}");
        assert!((exact / 1.2..=exact * 1.2).contains(&found), "{found} instead of {exact}");
        let error = relative(
            &all.iter().flat_map(|frame| frame[0].clone()).collect::<Vec<_>>(),
            &all.iter().flat_map(|frame| frame[1].clone()).collect::<Vec<_>>(),
        );
        eprintln!("{error:.4} of the reference");
        assert!(error <= TABLE_OF_FRAMES, "{error}");
    });
}

#[test]
fn the_work_of_a_table_is_the_texels_of_a_place_for_each_tap() {
    let field = patch(SurfaceKind::Bumps, 4.0);
    let scene = Scene::open("sphere").unwrap();
    let view = View::of(&scene, vec![Light::point(45.0, -40.0, 2.0)]);
    let optics = optics(8.0, 1e-1).for_pictures();
    with_device(|device| {
        let seen = directions(device, &scene, &view);
        let source = source(device, &field, &optics, Method::Table, sizes_of(&seen));
        let Source::Table(table) = &source else { panic!("not a table") };
        let texels = table.table.header.basis.texels();
        let points = [Directions { footprints: Vec::new(), ..seen[0].clone() }];
        // Light that does not reach a pixel costs nothing.
        let is_lit =
            |(light, view): (&[f32; 4], &[f32; 4])| view[3] != 0.0 && light[2] > 0.0 && view[2] > 0.0;
        let lit = seen[0].light.iter().zip(&seen[0].view).filter(|&pixel| is_lit(pixel)).count();
        let cost = source.cost(&optics, &points);
        assert!(lit > cost.covered / 2 && lit < cost.covered, "{lit} of {}", cost.covered);
        assert_eq!(cost.samples, texels * lit);
        // Three rows at the most, of which the one of the coarser level has fewer taps.
        let most = texels as f64 * 3.0 * MOST_OF_ROW as f64;
        let along = source.cost(&optics, &seen).samples_per_pixel();
        assert!(along > cost.samples_per_pixel() && along <= most, "{along}");
        // As many for every light.
        let both = [seen[0].clone(), seen[0].clone()];
        assert_eq!(source.cost(&optics, &both).samples_per_pixel(), 2.0 * along);
    });
}
