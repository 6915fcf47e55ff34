//! Single samples of pictures in which nothing hides the errors of taps, levels, texels and sums: few orders, faint directions; and sums of many wavelengths.

use crate::device::with_device;
use crate::evaluation::{layers, optics, patch, window};
use crate::mean::source;
use crate::measure::colours;
use crate::shared::Pictured;
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::optics::color::Tone;
use diffract::internals::optics::material::Material;
use diffract::internals::optics::reflectance::Reflectance;
use diffract::internals::render::footprints::sizes_of;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::light_passes::LightPass;
use diffract::internals::render::renderer::PictureRequest;
use diffract::internals::render::sampling::Sampling;
use diffract::internals::render::source::{ClassicalGrating, Source};
use diffract::internals::scene::{Light, Scene};
use diffract::internals::settings::{Method, Optics};
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use glam::{DVec3, Vec3};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

const SHOWN: Shown = Shown { exposure: 0.0, tone: Tone::None, background: DVec3::ZERO };

/// A picture.
struct Case {
    scene: &'static str,
    kind: SurfaceKind,
    size: [u32; 2],
    tolerance: f64,
    /// Instead of those of the scene.
    light: Option<Light>,
    /// Instead of a dielectric.
    material: Option<&'static str>,
}

impl Case {
    /// Returns the name of the reference of `samples` samples.
    fn name(&self, samples: u32) -> String {
        let Self { scene, kind, size: [width, height], .. } = self;
        let light = if self.light.is_some() { "-lit" } else { "" };
        format!("{scene}{light}-{}-{width}x{height}-{samples}", kind.name())
    }
}

/// Returns the relative L2 error of all colours of the mean of samples, against that of the same samples in f64.
fn error_of(case: &Case, sampling: Sampling) -> f64 {
    let &Case { kind, size, tolerance, .. } = case;
    let field = patch(kind, 10.0);
    let scene = Scene::open(case.scene).unwrap();
    let lights = case.light.as_ref().map_or(scene.lights.clone(), |light| vec![light.clone()]);
    let view = View { base_colors: vec![Vec3::ZERO], ..View::of(&scene, lights) };
    let reflectance = case.material.map_or(Reflectance::default(), |name| {
        Reflectance::of_material(Material::from_name_or_file(name).unwrap(), None)
    });
    let optics = Optics {
        coherence: Coherence::Gaussian { length: 16.0 },
        windows: Windows::All,
        tolerance,
        reflectance,
        ..Optics::default()
    }
    .for_pictures();
    let mut error = 0.0;
    with_device(|device| {
        let new = |source: &Source| crate::renderer_of(device, &scene, source, &optics, size).unwrap();
        let mut found = new(&Source::ClassicalGrating(ClassicalGrating::default()));
        let sample = sampling.sample(0);
        let seen: Vec<_> = (0..view.light_count())
            .map(|light| found.directions_of(&view, light, &sample).unwrap())
            .collect();
        // Whatever the wavelengths of the device.
        let pictured = Pictured { field: &field, optics: &optics, view: &view, size };
        let mut of_pass = |pass: &LightPass| found.directions_in(&view, pass);
        let exact = pictured.kept_mean(device, &case.name(sampling.count), &sampling, &mut of_pass);
        let source = source(device, &field, &optics, Method::Table, sizes_of(&seen));
        let picture = new(&source).render(&view, &sampling, SHOWN, &Task::silent()).unwrap();
        error = colours(&picture.radiance, &exact);
    });
    error
}

/// One sample of each picture is near the reference of that sample, and the mean of many within the tolerance.
fn samples_average_to_the_reference(pictures: &[(&'static str, SurfaceKind)]) {
    let many = Sampling { count: 16, seed: 3 };
    for &(scene, kind) in pictures {
        let case = Case { scene, kind, size: [64, 48], tolerance: 1e-2, light: None, material: None };
        let (one, mean) = (error_of(&case, Sampling::ONE), error_of(&case, many));
        eprintln!("| {scene}, {kind:?} | {one:.4} | {mean:.4} |");
        assert!(one < 5e-2 && mean < 1e-2, "{scene}, {kind:?}: {one}, {mean}");
    }
}

#[test]
fn samples_of_a_sphere_of_every_surface_average_to_the_reference() {
    samples_average_to_the_reference(&[
        ("sphere", SurfaceKind::Elaphe),
        ("sphere", SurfaceKind::Blaze),
        ("sphere", SurfaceKind::Sinusoid),
        ("sphere", SurfaceKind::Bumps),
        ("sphere", SurfaceKind::Tulip),
        ("sphere", SurfaceKind::Brushed),
    ]);
}

#[test]
fn samples_of_other_scenes_average_to_the_reference() {
    samples_average_to_the_reference(&[
        ("skin", SurfaceKind::Xenopeltis),
        ("snake", SurfaceKind::Elaphe),
        ("cd", SurfaceKind::Cd),
        ("cd", SurfaceKind::Dvd),
        ("disc", SurfaceKind::Sinusoid),
        ("plate", SurfaceKind::Xenopeltis),
    ]);
}

#[test]
fn pictures_of_few_orders_keep_their_colours() {
    // Measured errors and a quarter on top, or what one sample may err by; nothing averages the errors of taps where orders are few.
    let (left, above) = (Light::point(40.0, 180.0, 2.0), Light::point(30.0, 60.0, 1.0));
    for (scene, kind, light, size, tolerance, most) in [
        ("sphere", SurfaceKind::Sinusoid, None, [60, 45], 1e-2, 0.024),
        ("sphere", SurfaceKind::Sinusoid, None, [120, 90], 2e-2, 0.035),
        ("sphere", SurfaceKind::Blaze, None, [120, 90], 1e-2, 0.05),
        ("disc", SurfaceKind::Sinusoid, Some(above), [60, 45], 1e-2, 0.0125),
        ("plate", SurfaceKind::Sinusoid, Some(left), [60, 45], 1e-2, 0.02),
        ("cd", SurfaceKind::Sinusoid, None, [64, 48], 2e-2, 0.021),
        // The footprint of one sample of a disc of light is as wide as the disc.
        ("plate", SurfaceKind::Blaze, None, [60, 45], 1e-2, 0.0125),
    ] {
        let case = Case { scene, kind, size, tolerance, light, material: None };
        let table = error_of(&case, Sampling::ONE);
        eprintln!("| {scene}, {kind:?}, {size:?}, {tolerance} | {table:.4} |");
        assert!(table < most, "{scene}, {kind:?}: {table}");
    }
}

#[test]
fn a_plate_that_is_lit_across_its_grooves_keeps_its_faint_colours() {
    // All of it is thousands of times fainter than the brightest orders.
    let light = Some(Light::point(40.0, 90.0, 1.0));
    let case = Case {
        scene: "plate",
        kind: SurfaceKind::Elaphe,
        size: [64, 48],
        tolerance: 1e-2,
        light,
        material: None,
    };
    let table = error_of(&case, Sampling::ONE);
    eprintln!("faint: {table:.4}");
    assert!(table < 0.01, "{table}");
}

#[test]
fn a_plate_that_shows_two_orders_keeps_the_series_of_each() {
    // Nothing averages the errors of two series in z.
    let light = Some(Light::point(24.6, 155.8, 1.0));
    let case = Case {
        scene: "plate",
        kind: SurfaceKind::Xenopeltis,
        size: [64, 48],
        tolerance: 2e-2,
        light,
        material: None,
    };
    let table = error_of(&case, Sampling::ONE);
    eprintln!("two orders: {table:.4}");
    assert!(table < 0.036, "{table}");
}

#[test]
fn parts_of_a_sum_that_are_drawn_one_by_one_make_the_same_picture() {
    let field = patch(SurfaceKind::Elaphe, 10.0);
    let scene = Scene::open("sphere").unwrap();
    let view = View::of(&scene, vec![Light::point(70.0, 60.0, 1.0)]);
    // More iterations than a device does in an invocation.
    let optics = Optics { wavelengths: Some(12_000), ..optics(16.0, 1e-1) }.for_pictures();
    let source = window(&layers(&field, &optics));
    let size = [24, 18];
    with_device(|device| {
        let new = |source: &Source| crate::renderer_of(device, &scene, source, &optics, size).unwrap();
        // Measurements draw all parts of all pixels in one submission.
        let mut timed = new(&source);
        let watch = timed.stopwatch().unwrap();
        timed.time(&watch, &view, SHOWN.exposure, SHOWN.background).unwrap();
        let whole = timed.read_back().unwrap();
        let mut renderer = new(&source);
        let pieces = Arc::new(Mutex::new(Vec::new()));
        let next = Task::reporting({
            let pieces = Arc::clone(&pieces);
            move |progress| pieces.lock().unwrap().push(progress.done)
        });
        renderer.draw(&PictureRequest::one_sample(&view, size, SHOWN), &next).unwrap();
        assert!(renderer.read_back().unwrap() == whole);
        // The first tile is 4 x 4 pixels.
        let of_first_tile = pieces.lock().unwrap().iter().filter(|&&drawn| drawn < 16).count();
        assert!(of_first_tile > 1, "the parts of a tile are drawn together");
        // Given up in the middle of a tile, and drawn anew.
        let drawn = AtomicUsize::new(0);
        let give_up = Task::while_true(move |_| drawn.fetch_add(1, Ordering::Relaxed) + 1 < of_first_tile);
        let given_up = renderer.draw(&PictureRequest::one_sample(&view, size, SHOWN), &give_up);
        assert!(given_up.is_err_and(|e| e.is_cancelled()));
        renderer.draw(&PictureRequest::one_sample(&view, size, SHOWN), &Task::silent()).unwrap();
        assert!(renderer.read_back().unwrap() == whole);
    });
}

#[test]
fn glass_reflects_as_fresnel_says_where_footprints_reach_far() {
    // Beside silhouettes a footprint reads R at other angles than the pixel's. Over Schlick's form it erred by 0.016, over its own mean by nothing.
    let case = Case {
        scene: "snake",
        kind: SurfaceKind::Flat,
        size: [64, 48],
        tolerance: 1e-2,
        light: Some(Light::point(16.8, 51.8, 1.0)),
        material: Some("glass"),
    };
    let table = error_of(&case, Sampling::ONE);
    eprintln!("glass: {table:.4}");
    assert!(table < 0.003, "{table}");
}
