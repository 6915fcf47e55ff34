//! Colour tables against the direct f64 sum.

use crate::device::with_device;
use crate::evaluation::{FLOOR, patch, queries, shading, tabled};
use crate::measure::channel;
use diffract::optics::reference::Reference;
use diffract::precompute::{Settings, compute};
use diffract::random::Random;
use diffract::render::color_table::bake::layer_settings;
use diffract::render::color_table::{self, ColorTable, Filter, cache};
use diffract::render::evaluator::{Evaluator, Query};
use diffract::render::frame::View;
use diffract::render::picture::Painter;
use diffract::render::pigment::Pigment;
use diffract::render::reference_picture::reference_picture;
use diffract::render::shading::Shading;
use diffract::scene::{Light, Scene};
use diffract::surface::HeightField;
use diffract::surface::synth::Kind;
use diffract::vk::device::Device;
use glam::{DVec3, Vec3};
use std::sync::Arc;

fn settings(device: &Device, shading: &Shading) -> Settings {
    layer_settings(shading, device.candidate()).unwrap()
}

pub fn table(device: &Arc<Device>, field: &HeightField, shading: &Shading) -> ColorTable {
    let settings = settings(device, shading);
    let layers = compute(field, &settings, &|_, _| Ok(())).unwrap();
    color_table::make(device, (field, layers, &settings), shading, &|_, _, _| Ok(())).unwrap()
}

/// Directions of colours over both hemispheres.
pub fn colours(seed: u64, count: usize) -> Vec<Query> {
    queries(seed, count).into_iter().map(|q| Query { wavelength: None, ..q }).collect()
}

/// The colours of `queries` by the direct sum, XYZ of f cos θ_i.
pub fn by_reference(field: &HeightField, shading: &Shading, queries: &[Query]) -> Vec<DVec3> {
    let reference = Reference::new(field, shading.coherence, [1, 1], shading.ior);
    queries.iter().map(|q| reference.cosine_weighted_xyz(&q.pair, &shading.illuminant).unwrap()).collect()
}

/// ‖found − exact‖/‖exact‖ over all directions, then median and 99th percentile of the errors of single directions that a
/// display does not show as black, each relative to its own value.
pub fn errors(found: &[DVec3], exact: &[DVec3]) -> [f64; 3] {
    assert!(found.iter().all(|f| f.is_finite()));
    let pairs = || found.iter().zip(exact);
    let mut single: Vec<f64> =
        pairs().filter(|(_, e)| e.length() > FLOOR).map(|(f, e)| (*f - *e).length() / e.length()).collect();
    single.sort_by(f64::total_cmp);
    let difference: f64 = pairs().map(|(f, e)| (*f - *e).length_squared()).sum();
    let size: f64 = exact.iter().map(|e| e.length_squared()).sum();
    [(difference / size).sqrt(), single[single.len() / 2], single[single.len() * 99 / 100]]
}

fn meets_its_tolerance(kind: Kind, side: f64, length: f64, seed: u64, tolerances: &[f64]) {
    let field = patch(kind, side);
    let queries = colours(seed, 200);
    let exact = by_reference(&field, &shading(length, 1.0), &queries);
    with_device(|device| {
        for &tolerance in tolerances {
            let shading = shading(length, tolerance);
            let table = table(device, &field, &shading);
            let grid = table.grid;
            let mut evaluator = Evaluator::new(device, &tabled(&table, Filter::Point), &shading).unwrap();
            let found = evaluator.cosine_weighted(&queries).unwrap();
            let [whole, median, p99] = errors(&found, &exact);
            eprintln!(
                "{} at {tolerance:e}: {whole:.2e}, median {median:.2e}, p99 {p99:.2e}; {grid:?}",
                kind.name()
            );
            assert!(whole <= tolerance, "{} at {tolerance}: {whole:e}", kind.name());
            if Some(&tolerance) != tolerances.last() {
                continue;
            }
            // The comparison sees a surface that is a tenth higher.
            let heights = field.heights().iter().map(|h| h * 1.1).collect();
            let higher =
                HeightField::new(field.columns(), field.rows(), field.pixel_size(), heights).unwrap();
            let other = self::table(device, &higher, &shading);
            let mut evaluator = Evaluator::new(device, &tabled(&other, Filter::Point), &shading).unwrap();
            let wrong = errors(&evaluator.cosine_weighted(&queries).unwrap(), &exact);
            assert!(wrong[1] > 2.0 * median, "{wrong:?}");
        }
    });
}

#[test]
fn a_table_meets_its_tolerance_on_an_elaphe_skin() {
    meets_its_tolerance(Kind::Elaphe, 12.0, 16.0, 21, &[1e-1, 2e-2, 5e-3]);
}

#[test]
fn a_table_meets_its_tolerance_on_a_blaze() {
    meets_its_tolerance(Kind::Blaze, 10.0, 16.0, 22, &[1e-1, 2e-2]);
}

#[test]
fn a_table_meets_its_tolerance_on_bumps() {
    meets_its_tolerance(Kind::Bumps, 4.0, 12.0, 23, &[1e-1, 2e-2]);
}

#[test]
fn windows_are_averaged_as_the_reference_averages_them() {
    let field = patch(Kind::Elaphe, 8.0);
    let queries = colours(31, 100);
    let shading = Shading { windows: [3, 2], ..shading(8.0, 2e-2) };
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
        eprintln!("windows: {whole:.2e}, median {median:.2e}, p99 {p99:.2e}");
        assert!(whole <= shading.tolerance, "{whole:e}");
        assert!(errors(&found, &exact([1, 1]))[1] > 5.0 * shading.tolerance, "one window looks the same");
    });
}

const SIZE: [u32; 2] = [96, 72];

fn paint(
    device: &Arc<Device>,
    table: &ColorTable,
    filter: Filter,
    shading: &Shading,
    scene: &Scene,
    view: &View,
    size: [u32; 2],
) -> Vec<[f32; 4]> {
    let (source, lights) = (tabled(table, filter), view.lights.len());
    let mut painter =
        Painter::new(device, &source, shading, &scene.mesh, &Pigment::white(), size, lights).unwrap();
    painter.paint(view, 0.0, DVec3::ZERO).unwrap().radiance
}

#[test]
fn a_picture_of_points_is_the_reference_picture_within_its_tolerance() {
    let field = patch(Kind::Elaphe, 6.0);
    let scene = Scene::open("sphere").unwrap();
    let view = View::of(&scene, vec![Light { theta: 45.0, phi: -40.0, intensity: 2.0 }]);
    let shading = shading(8.0, 2e-2);
    with_device(|device| {
        let table = table(device, &field, &shading);
        let mut painter = Painter::new(
            device,
            &tabled(&table, Filter::Point),
            &shading,
            &scene.mesh,
            &Pigment::white(),
            SIZE,
            1,
        )
        .unwrap();
        let picture = painter.paint(&view, 0.0, DVec3::ZERO).unwrap().radiance;
        let directions = vec![painter.directions(&view, 0).unwrap()];
        // Three samples a pixel, and as many for every light.
        let cost = tabled(&table, Filter::Point).cost(&shading, &directions, SIZE);
        assert_eq!(cost.samples_per_pixel(), 3.0);
        let filtered = tabled(&table, Filter::Pixel).cost(&shading, &directions, SIZE).samples_per_pixel();
        assert!(filtered > 3.0 && filtered <= 3.0 * f64::from(Filter::Pixel.taps()), "{filtered}");
        let exact = reference_picture(&field, &shading, &view, &directions, &|_, _| Ok(())).unwrap();
        let errors = [0, 1, 2].map(|c| channel(&picture, &exact, c));
        eprintln!("points: {errors:.2?}");
        assert!(errors.iter().all(|&e| e <= shading.tolerance), "{errors:?}");
    });
}

/// Averages of `n` × `n` pixels over those that are covered; alpha 1 only where all are.
fn averaged(picture: &[[f32; 4]], size: [u32; 2], n: usize) -> Vec<[f32; 4]> {
    let [width, height] = size.map(|s| s as usize);
    let mut small = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut whole) = ([0f64; 4], true);
            for i in 0..n * n {
                let pixel = picture[(y * n + i / n) * width * n + x * n + i % n];
                whole &= pixel[3] == 1.0;
                sum.iter_mut().zip(pixel).for_each(|(s, p)| *s += f64::from(p) / (n * n) as f64);
            }
            let [r, g, b, _] = sum.map(|s| s as f32);
            small.push(if whole { [r, g, b, 1.0] } else { [0.0; 4] });
        }
    }
    small
}

/// A distant sphere whose light moves by a small step from picture to picture.
fn sequence() -> (Scene, Vec<View>) {
    let scene = Scene::open("sphere").unwrap();
    let views = (0..6)
        .map(|step| {
            let light = Light { theta: 40.0 + 0.4 * f64::from(step), phi: -50.0, intensity: 2.0 };
            let mut view = View::of(&scene, vec![light]);
            view.base_color = Vec3::ZERO;
            view
        })
        .collect();
    (scene, views)
}

#[test]
fn filtered_highlights_neither_alias_nor_shimmer() {
    let field = patch(Kind::Elaphe, 12.0);
    let shading = shading(16.0, 5e-2);
    let (scene, views) = sequence();
    let size = [64, 48];
    const SAMPLES: usize = 12;
    with_device(|device| {
        let table = table(device, &field, &shading);
        // [filter: error against the average over the pixel; flicker from picture to picture]
        let mut error = [0f64; 2];
        let mut flicker = [0f64; 3];
        let mut scale = 0f64;
        let mut before: Option<[Vec<[f32; 4]>; 3]> = None;
        for view in &views {
            let large = size.map(|s| s * SAMPLES as u32);
            let exact = paint(device, &table, Filter::Point, &shading, &scene, view, large);
            let exact = averaged(&exact, size, SAMPLES);
            let found = [Filter::Pixel, Filter::Point]
                .map(|filter| paint(device, &table, filter, &shading, &scene, view, size));
            for (i, e) in exact.iter().enumerate().filter(|(_, e)| e[3] == 1.0) {
                for c in 0..3 {
                    scale += f64::from(e[c]).powi(2);
                    for (slot, found) in error.iter_mut().zip(&found) {
                        *slot += f64::from(found[i][c] - e[c]).powi(2);
                    }
                }
            }
            let [pixel, point] = found;
            let now = [pixel, point, exact];
            if let Some(before) = &before {
                for (slot, (now, before)) in flicker.iter_mut().zip(now.iter().zip(before)) {
                    for (i, _) in
                        now.iter().enumerate().filter(|(i, _)| before[*i][3] == 1.0 && now[*i][3] == 1.0)
                    {
                        *slot += f64::from(now[i][1] - before[i][1]).powi(2);
                    }
                }
            }
            before = Some(now);
        }
        let error = error.map(|e| (e / scale).sqrt());
        let flicker = flicker.map(f64::sqrt);
        eprintln!(
            "against {SAMPLES}x{SAMPLES} samples: pixel {:.3}, point {:.3}; flicker: pixel {:.3}, point {:.3}, \
             reference {:.3}",
            error[0], error[1], flicker[0], flicker[1], flicker[2]
        );
        // Points see a highlight or miss it; the average sees a part of it, and changes as the reference does.
        assert!(error[0] < 0.2 && error[0] < 0.4 * error[1], "{error:?}");
        assert!((flicker[0] / flicker[2] - 1.0).abs() < 0.2, "{flicker:?}");
        assert!(flicker[1] > 1.5 * flicker[2], "{flicker:?}");
    });
}

#[test]
fn a_table_comes_back_from_the_disk_as_it_went_and_is_refused_where_it_does_not_fit() {
    let field = patch(Kind::Bumps, 4.0);
    let shading = shading(4.0, 1e-1);
    with_device(|device| {
        let settings = settings(device, &shading);
        let first = table(device, &field, &shading);
        let folder = tempfile::tempdir().unwrap();
        let key = cache::key(&field, &settings, &shading);
        cache::store(folder.path(), &key, &first).unwrap();
        assert!(cache::load(folder.path(), &key, 1 << 32) == Some(first));
        let layers = compute(&field, &settings, &|_, _| Ok(())).unwrap();
        let made = |memory, progress: &dyn Fn(&'static str, usize, usize) -> diffract::error::Result<()>| {
            let settings = Settings { memory_limit: memory, ..settings };
            color_table::make(device, (&field, layers.clone(), &settings), &shading, progress)
        };
        let refused = made(1 << 16, &|_, _, _| Ok(())).unwrap_err().to_string();
        assert!(refused.contains("GiB") && refused.contains("--method spectral"), "{refused}");
        // Work ends between tiles where the progress says so.
        let stopped = made(1 << 32, &|_, done, of| {
            if done > of / 2 { Err(diffract::error::Error::failed("stopped", "start again")) } else { Ok(()) }
        });
        assert!(stopped.unwrap_err().to_string().contains("stopped"));
    });
}

#[test]
fn every_level_on_the_device_is_a_mean_of_the_finest() {
    // A random direction's neighbourhood: the mean of level 0 over a texel of level 5 is what level 5 holds there.
    let field = patch(Kind::Elaphe, 6.0);
    let shading = shading(8.0, 1e-1);
    with_device(|device| {
        let table = table(device, &field, &shading);
        let number = |level: usize, x: usize, y: usize| {
            let side = table.grid.side >> level;
            // The finest level has X, Y and Z beside each other.
            let beside = if level == 0 { 3 } else { 1 };
            half::f16::from_bits(table.levels[level][(y * side + x) * beside * 4]).to_f64()
        };
        let mut random = Random::new(3);
        for _ in 0..20 {
            let side = table.grid.side >> 4;
            let [x, y] = [random.share(), random.share()].map(|r| (r * side as f64) as usize);
            if x.max(y) * 16 < table.grid.near().side + 16 {
                continue; // the finer part
            }
            let cells = (0..256).map(|i| number(0, x * 16 + i % 16, y * 16 + i / 16));
            let (sum, size) = cells.fold((0.0, 0.0), |(s, a), v| (s + v / 256.0, a + v.abs() / 256.0));
            // The finest level is rounded to 11 bits; below 6e-5 to steps of 6e-8.
            assert!((number(4, x, y) - sum).abs() <= 1e-3 * size + 1e-7, "{x}, {y}");
        }
    });
}
