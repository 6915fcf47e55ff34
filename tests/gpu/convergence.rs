//! Pictures of many samples against pictures of many more pixels, which need neither jitter nor large footprints.

use crate::device::with_device;
use crate::evaluation::patch;
use crate::mean::{optics, source};
use crate::measure::colours;
use diffract::internals::render::footprints;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::sampling::Sampling;
use diffract::internals::scene::{Light, Scene};
use diffract::internals::settings::Method;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use glam::{DVec3, DVec4};

const SIZE: [u32; 2] = [96, 54];
/// Pixels of the larger picture along a side of one of the smaller one.
const FINER: u32 = 32;
const SHOWN: Shown = Shown::plain(0.0, DVec3::ZERO);

/// `row` of the larger picture, as pixels of the smaller one see it: a quadratic B-spline, clamped at the edges.
fn filtered(row: &[DVec4]) -> Vec<DVec4> {
    let finer = FINER as i64;
    let spline = |x: f64| if x.abs() <= 0.5 { 0.75 - x * x } else { 0.5 * (1.5 - x.abs()).powi(2) };
    let seen = |pixel: i64| -> DVec4 {
        // From 1½ pixels before the middle of the pixel to 1½ behind it.
        let places = (pixel - 1) * finer..(pixel + 2) * finer;
        let weight =
            |i: i64| spline((i as f64 + 0.5) / f64::from(FINER) - pixel as f64 - 0.5) / f64::from(FINER);
        places.map(|i| row[i.clamp(0, row.len() as i64 - 1) as usize] * weight(i)).sum()
    };
    (0..row.len() as i64 / finer).map(seen).collect()
}

/// The larger picture, as pixels of the smaller one see it.
fn supersampled(fine: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let width = (SIZE[0] * FINER) as usize;
    let pixels: Vec<_> = fine.iter().map(|p| DVec4::from_array(p.map(f64::from))).collect();
    let rows: Vec<_> = pixels.chunks_exact(width).map(filtered).collect();
    let columns: Vec<_> =
        (0..SIZE[0] as usize).map(|x| filtered(&rows.iter().map(|row| row[x]).collect::<Vec<_>>())).collect();
    (0..SIZE[1] as usize)
        .flat_map(|y| columns.iter().map(move |column| column[y].as_vec4().to_array()))
        .collect()
}

#[test]
fn many_samples_show_what_many_more_pixels_show() {
    let scene = Scene::open("snake").unwrap();
    let view = View::of(&scene, vec![Light::point(40.0, -97.0, 1.0)]);
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let optics = optics(16.0, 2e-2).for_pictures();
    with_device(|device| {
        let fine = SIZE.map(|n| n * FINER);
        let views = std::slice::from_ref(&view);
        let sizes =
            footprints::sizes(device, &scene.main_object().mesh, views, fine, &Sampling::ONE).unwrap();
        let source = source(device, &field, &optics, Method::Table, sizes);
        let renderer = |size| crate::renderer_of(device, &scene, &source, &optics, size).unwrap();
        let exact = renderer(fine).render_plain(&view, SHOWN.exposure, SHOWN.background).unwrap();
        let exact = supersampled(&exact.radiance);
        let mut small = renderer(SIZE);
        let mut former = f64::INFINITY;
        // Of so many samples: what is measured, and a quarter on top. If samples counted for their own pixels alone, 64 would err by 0.109.
        for (count, allowed) in [(1, 0.67), (16, 0.145), (64, 0.066), (256, 0.028), (1024, 0.014)] {
            let sampling = Sampling { count, seed: 1 };
            let picture = small.render(&view, &sampling, SHOWN, &Task::silent()).unwrap();
            let found = colours(&picture.radiance, &exact);
            eprintln!("{count} samples against {FINER} x {FINER} pixels each: {found:.4}");
            assert!(found <= allowed, "{count} samples: {found}");
            assert!(found < 0.7 * former, "{count} samples are no better than fewer: {found}");
            former = found;
        }
    });
}

#[test]
fn more_samples_have_smaller_footprints_and_average_over_as_much() {
    let scene = Scene::open("snake").unwrap();
    let view = View::of(&scene, vec![Light::point(40.0, -97.0, 1.0)]);
    with_device(|device| {
        let of = |count| {
            let (views, sampling) = (std::slice::from_ref(&view), Sampling { count, seed: 1 });
            footprints::sizes(device, &scene.main_object().mesh, views, SIZE, &sampling).unwrap()
        };
        let [few, many] = [of(16), of(64)];
        assert_eq!(few.longer, many.longer);
        // 2/65 of the filter's variance instead of 2/17; the jitter moves which pixels are seen.
        let expected = (17f64 / 65.0).sqrt();
        assert!((many.shorter / few.shorter / expected - 1.0).abs() < 0.1, "{few:?}, {many:?}");
    });
}
