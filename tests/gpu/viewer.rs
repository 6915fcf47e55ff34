//! What the viewer adds to the frame: tiles, smaller pictures in the same images, errors in false colour.

use crate::device::with_device;
use crate::evaluation::{grating, layers, optics, patch, window};
use diffract::internals::filter::FootprintSizes;
use diffract::internals::optics::coherence::Windows;
use diffract::internals::optics::spectrum::Illuminant;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::reference_picture::reference_pixels;
use diffract::internals::render::renderer::{PictureRequest, Renderer};
use diffract::internals::render::source::Source;
use diffract::internals::scene::{Environment, Light, Scene};
use diffract::internals::settings::{Method, Optics};
use diffract::internals::spectra::amplitude::Layers;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use diffract::internals::viewer::error_probe::{ProbeSamples, samples};
use diffract::internals::vk::device::Device;
use glam::{DVec3, Vec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

const SIZE: [u32; 2] = [96, 72];

fn renderer(device: &Arc<Device>, scene: &Scene, size: [u32; 2]) -> Renderer {
    let (field, optics) = (patch(SurfaceKind::Elaphe, 6.0), optics(8.0, 1e-1));
    let layers = layers(&field, &optics);
    crate::renderer_of(device, scene, &window(&layers), &optics, size).unwrap()
}

fn view(scene: &Scene, intensity: f64) -> View {
    let view = View::of(scene, vec![Light::point(40.0, -30.0, intensity)]);
    View { base_colors: vec![Vec3::ZERO], ..view }
}

#[test]
fn other_settings_for_the_same_layers_take_no_new_layers_and_make_the_same_picture() {
    let scene = Scene::open("sphere").unwrap();
    let view = view(&scene, 2.0);
    let field = patch(SurfaceKind::Elaphe, 6.0);
    let before = optics(8.0, 1e-1).for_pictures();
    let layers = layers(&field, &before);
    let repeats = |layers: &Layers, n| grating(layers, [n, 2], &field);
    let lit = Optics { illuminant: Illuminant::A, ..before.clone() };
    let dense = Optics { reflectance: 2.4.into(), ..before.clone() };
    with_device(|device| {
        let new = |source: &Source, optics: &Optics| {
            crate::renderer_of(device, &scene, source, optics, SIZE).unwrap()
        };
        let cases = [
            (window(&layers), window(&layers), &lit),
            (window(&layers), window(&layers), &dense),
            (repeats(&layers, 3), repeats(&layers, 5), &dense),
            (repeats(&layers, 3), repeats(&layers, 3), &lit),
        ];
        for (first, then, optics) in cases {
            let expected = new(&then, optics).render_plain(&view, 0.0, DVec3::ZERO).unwrap();
            let mut renderer = new(&first, &before);
            let former = renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap();
            assert!(former != expected, "a change that changes something");
            let memory = device.memory_in_use();
            // With no room for anything as large as the layers: a few small tables are all that is taken.
            renderer.set_source(&then, optics).unwrap();
            assert!(device.memory_in_use().abs_diff(memory) < layers.bytes() as u64 / 2);
            assert!(renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap() == expected);
            // In tiles, too, each of which is a submission of its own.
            renderer
                .draw(
                    &PictureRequest::one_sample(&view, SIZE, Shown::plain(0.0, DVec3::ZERO)),
                    &Task::silent(),
                )
                .unwrap();
            assert!(renderer.read_back().unwrap() == expected);
        }
        // A change of settings takes fewer than ten allocations: reflectances, the limit of energy, coefficients and their blocks.
        let mut renderer = new(&window(&layers), &before);
        renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap();
        device.refuse_allocation(10);
        renderer.set_source(&window(&layers), &lit).unwrap();
        device.refuse_allocation(u64::MAX);
    });
}

#[test]
fn pixels_that_are_compared_with_the_reference_keep_their_light_and_their_footprints() {
    let scene = Scene::open("sphere").unwrap();
    let mut view = view(&scene, 2.0);
    view.base_colors = vec![Vec3::splat(0.2)];
    view.environment = Some(Environment::open("studio").unwrap());
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let optics = Optics { windows: Windows::All, ..optics(16.0, 2e-2) }.for_pictures();
    with_device(|device| {
        let source = crate::mean::source(device, &field, &optics, Method::Table, FootprintSizes::default());
        let mut renderer = crate::renderer_of(device, &scene, &source, &optics, SIZE).unwrap();
        renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap();
        let ProbeSamples { radiance, directions } = samples(&mut renderer, &view).unwrap();
        let pixels: Vec<usize> = (0..radiance.len()).collect();
        let exact = reference_pixels(&field, &optics, &view, &directions, &pixels, &Task::silent()).unwrap();
        let square = |v: DVec3| v.length_squared();
        let apart: f64 = radiance.iter().zip(&exact).map(|(a, b)| square(*a - *b)).sum();
        let error = (apart / exact.iter().map(|b| square(*b)).sum::<f64>()).sqrt();
        eprintln!("{} pixels differ from the reference by {error:.4}", radiance.len());
        assert!(radiance.len() >= 100 && error < 0.03, "{error}");
    });
}

#[test]
fn a_pixel_that_is_read_alone_is_that_of_the_whole_picture() {
    let scene = Scene::open("sphere").unwrap();
    let mut view = view(&scene, 2.0);
    view.environment = Some(Environment::open("studio").unwrap());
    let field = patch(SurfaceKind::Elaphe, 12.0);
    let optics = Optics { windows: Windows::All, ..optics(16.0, 1e-1) }.for_pictures();
    with_device(|device| {
        let source = crate::mean::source(device, &field, &optics, Method::Table, FootprintSizes::default());
        let mut renderer = crate::renderer_of(device, &scene, &source, &optics, SIZE).unwrap();
        assert!(renderer.pixel(&view, [48, 36]).unwrap().is_none(), "nothing is drawn yet");
        let picture = renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap();
        let lights: Vec<_> = (0..2).map(|light| renderer.directions(&view, light).unwrap()).collect();
        let mut covered = 0;
        for at in [[48, 36], [40, 20], [60, 50], [0, 0], [95, 71]] {
            let i = (at[1] * SIZE[0] + at[0]) as usize;
            let pixel = renderer.pixel(&view, at).unwrap();
            assert_eq!(pixel.is_some(), picture.radiance[i][3] > 0.0);
            let Some(pixel) = pixel else { continue };
            covered += 1;
            let shown = pixel.radiance.as_vec3().extend(1.0).to_array();
            assert_eq!((shown, pixel.directions.len()), (picture.radiance[i], 2));
            for (alone, all) in pixel.directions.iter().zip(&lights) {
                assert_eq!(format!("{alone:?}"), format!("{:?}", all.of_pixels(&[i])));
            }
        }
        assert!(covered >= 3);
        assert!(renderer.pixel(&view, SIZE).unwrap().is_none(), "beyond the picture");
        assert!(renderer.read_back().unwrap() == picture, "nothing was drawn again");
        // The exposure of what is there can change without drawing it.
        renderer.resize(SIZE).unwrap();
        assert!(renderer.display(SIZE, Shown::plain(1.0, DVec3::ZERO)).unwrap());
    });
}

#[test]
fn tiles_make_the_same_picture_and_one_that_is_given_up_leaves_the_former_display() {
    let scene = Scene::open("sphere").unwrap();
    let view = view(&scene, 2.0);
    let background = DVec3::splat(0.2);
    with_device(|device| {
        let mut whole = renderer(device, &scene, SIZE);
        // Measurements draw each pass in one submission.
        let watch = whole.stopwatch().unwrap();
        whole.time(&watch, &view, 1.0, background).unwrap();
        let expected = whole.read_back().unwrap();
        let mut renderer = renderer(device, &scene, SIZE);
        let asked = Arc::new(AtomicUsize::new(0));
        let count = Task::reporting({
            let asked = Arc::clone(&asked);
            move |progress| {
                assert!(progress.done < progress.of, "{progress:?}");
                asked.fetch_add(1, Ordering::Relaxed);
            }
        });
        renderer
            .draw(&PictureRequest::one_sample(&view, SIZE, Shown::plain(1.0, background)), &count)
            .unwrap();
        assert!(asked.load(Ordering::Relaxed) >= 2, "the picture has more than one tile at first");
        assert!(renderer.read_back().unwrap() == expected);
        // Another light, given up after the first tile.
        let tiles = AtomicUsize::new(0);
        let once = Task::while_true(move |_| tiles.fetch_add(1, Ordering::Relaxed) < 1);
        let other = View { lights: vec![Light::point(70.0, 100.0, 1.0)], ..view.clone() };
        let done =
            renderer.draw(&PictureRequest::one_sample(&other, SIZE, Shown::plain(1.0, background)), &once);
        if let Err(e) = done {
            assert!(e.is_cancelled(), "{e}");
            assert!(renderer.read_back().unwrap().display == expected.display);
            assert!(
                !renderer.display(SIZE, Shown::plain(0.0, background)).unwrap(),
                "half a picture is none"
            );
            assert!(!renderer.has_picture());
        }
        renderer
            .draw(&PictureRequest::one_sample(&view, SIZE, Shown::plain(1.0, background)), &Task::silent())
            .unwrap();
        assert!(renderer.display(SIZE, Shown::plain(2.0, background)).unwrap());
        let brighter = whole.render_plain(&view, 2.0, background).unwrap();
        assert!(renderer.read_back().unwrap() == brighter && brighter.display != expected.display);
    });
}

#[test]
fn a_smaller_picture_lies_in_the_corner_and_another_size_is_another_picture() {
    let scene = Scene::open("sphere").unwrap();
    let view = view(&scene, 2.0);
    let small = [48, 36];
    with_device(|device| {
        let expected = renderer(device, &scene, small).render_plain(&view, 0.0, DVec3::ZERO).unwrap();
        let mut renderer = renderer(device, &scene, SIZE);
        renderer
            .draw(&PictureRequest::one_sample(&view, small, Shown::plain(0.0, DVec3::ZERO)), &Task::silent())
            .unwrap();
        let shown = renderer.read_back().unwrap();
        for y in 0..small[1] as usize {
            let rows = [small[0], SIZE[0]].map(|width| y * width as usize);
            let row = |p: &[[u8; 4]], first: usize| p[first..first + small[0] as usize].to_vec();
            assert_eq!(row(&expected.display, rows[0]), row(&shown.display, rows[1]), "row {y}");
        }
        renderer.resize(small).unwrap();
        assert!(renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap() == expected);
    });
}
