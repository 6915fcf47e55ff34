//! Devices that run out of memory: each allocation in turn fails, nothing is left behind, the next try succeeds.

use crate::device::with_device;
use crate::evaluation::{grating, layers, optics, patch, queries, window};
use crate::mean::source;
use diffract::internals::error::{ErrorKind, Remedy, Result};
use diffract::internals::filter::FootprintSizes;
use diffract::internals::measure::profile;
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::render::evaluator::Evaluator;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::renderer::{Picture, PictureRequest};
use diffract::internals::render::source::Source;
use diffract::internals::render::{target, upload};
use diffract::internals::scene::{Light, Scene};
use diffract::internals::settings::{Method, Optics};
use diffract::internals::spectra::amplitude::{LayerSettings, compute};
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use diffract::internals::vk::instance::Instance;
use diffract::internals::vk::mask::Mask;
use diffract::internals::vk::selection::DeviceChoice;
use glam::DVec3;
use std::sync::Arc;

/// Runs `work` with its first allocation failing, then its second, and so on, until none fails; the number that there are.
fn with_each_allocation_failing<T>(device: &Arc<Device>, mut work: impl FnMut() -> Result<T>) -> (u64, T) {
    for n in 1.. {
        device.refuse_allocation(n);
        match work() {
            Ok(value) => {
                device.refuse_allocation(u64::MAX);
                return (n - 1, value);
            }
            Err(error) => {
                let line = error.to_string();
                assert_eq!(error.kind(), ErrorKind::Memory, "{line}");
                assert!(line.contains("no memory for the"), "{line}");
                assert!(error.remedies().contains(&Remedy::SmallerPicture), "{line}");
                assert_eq!(device.memory_in_use(), 0, "allocation {n} left memory behind: {line}");
            }
        }
    }
    unreachable!("a picture takes a number of allocations")
}

fn view(scene: &Scene) -> View {
    View::of(scene, vec![Light::point(40.0, 20.0, 1.0)])
}

fn paint(device: &Arc<Device>, source: &Source, optics: &Optics, scene: &Scene) -> Result<Picture> {
    let mut renderer = crate::renderer_of(device, scene, source, optics, [16, 12])?;
    renderer.render_plain(&view(scene), 0.0, DVec3::ZERO)
}

#[test]
fn a_picture_fails_cleanly_at_each_of_its_allocations_and_succeeds_afterwards() {
    let optics = optics(4.0, 1e-1);
    let layers = layers(&patch(SurfaceKind::Bumps, 2.0), &optics);
    let scene = Scene::open("plate").unwrap();
    with_device(|device| {
        let undisturbed = paint(device, &window(&layers), &optics, &scene).unwrap();
        let (allocations, picture) =
            with_each_allocation_failing(device, || paint(device, &window(&layers), &optics, &scene));
        eprintln!("{allocations} allocations make a picture");
        assert!(allocations > 10, "{allocations}");
        assert_eq!(picture, undisturbed);
        assert_eq!(device.memory_in_use(), 0);
    });
}

#[test]
fn a_picture_of_the_mean_fails_cleanly_at_each_of_its_allocations_and_succeeds_afterwards() {
    let optics = Optics { windows: Windows::All, ..optics(4.0, 2e-1) }.for_pictures();
    let field = patch(SurfaceKind::Bumps, 2.0);
    let scene = Scene::open("plate").unwrap();
    with_device(|device| {
        let sizes = FootprintSizes { shorter: 1e-2, longer: 1e-2 };
        let source = source(device, &field, &optics, Method::Table, sizes);
        let paint = || paint(device, &source, &optics, &scene);
        let expected = paint().unwrap();
        let (allocations, picture) = with_each_allocation_failing(device, paint);
        assert!(allocations > 10 && picture == expected, "{allocations}");
    });
}

#[test]
fn a_picture_through_repeats_fails_cleanly_at_each_of_its_allocations_and_succeeds_afterwards() {
    let copies = [3, 2];
    let coherence = Coherence::Repeats(copies);
    let optics = Optics { coherence, windows: Windows::ONE, tolerance: 1e-1, ..Optics::default() };
    let optics = optics.for_pictures();
    let field = patch(SurfaceKind::Bumps, 2.0);
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
    let scene = Scene::open("plate").unwrap();
    with_device(|device| {
        let source = grating(&layers, copies, &field);
        let expected = paint(device, &source, &optics, &scene).unwrap();
        let (allocations, picture) =
            with_each_allocation_failing(device, || paint(device, &source, &optics, &scene));
        assert!(allocations > 10 && picture == expected, "{allocations}");
    });
}

#[test]
fn a_profile_and_what_a_window_adds_fail_cleanly_at_each_of_their_allocations() {
    let optics = optics(4.0, 1e-1);
    let layers = layers(&patch(SurfaceKind::Bumps, 2.0), &optics);
    let scene = Scene::open("plate").unwrap();
    let view = view(&scene);
    with_device(|device| {
        let (allocations, samples) = with_each_allocation_failing(device, || {
            let mesh = &scene.main_object().mesh;
            let mut renderer =
                crate::renderer(device, &window(&layers), &optics, mesh, &Pigment::white(), [16, 12])?;
            let times = profile::measure(&mut renderer, &view, 3, 1.0, &Task::silent())?;
            let rates = profile::rates(&mut renderer, 16 * 12)?;
            renderer.directions(&view, 0)?;
            renderer.cosine_weighted(&queries(3, 5))?;
            renderer.draw(
                &PictureRequest::one_sample(&view, [16, 12], Shown::plain(0.0, DVec3::ZERO)),
                &Task::silent(),
            )?;
            let picture = renderer.read_back()?;
            let size = picture.size.map(|n| n as usize);
            let data = bytemuck::cast_slice(&picture.display);
            upload::texture(device, "picture", target::DISPLAY, size, None, data)?;
            Ok(times.frame.min.min(rates.coherent))
        });
        eprintln!("{allocations} allocations make a profile and a picture that goes back to the device");
        assert!(allocations > 15 && samples > 0.0, "{allocations}");
    });
}

#[test]
fn answers_fail_cleanly_at_each_of_their_allocations_and_succeed_afterwards() {
    let optics = optics(4.0, 1e-1);
    let layers = layers(&patch(SurfaceKind::Bumps, 2.0), &optics);
    let queries = queries(5, 20);
    with_device(|device| {
        let ask = || Evaluator::new(device, &window(&layers), &optics)?.cosine_weighted(&queries);
        let undisturbed = ask().unwrap();
        let (allocations, answers) = with_each_allocation_failing(device, ask);
        assert!(allocations > 5, "{allocations}");
        assert_eq!(answers, undisturbed);
    });
}

#[test]
fn a_painter_that_could_not_grow_still_paints() {
    let optics = optics(4.0, 1e-1);
    let layers = layers(&patch(SurfaceKind::Bumps, 2.0), &optics);
    let scene = Scene::open("plate").unwrap();
    let view = view(&scene);
    with_device(|device| {
        let mut renderer = crate::renderer_of(device, &scene, &window(&layers), &optics, [16, 12]).unwrap();
        let before = renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap();
        for n in 1.. {
            device.refuse_allocation(n);
            let grown = renderer.resize([64, 48]);
            device.refuse_allocation(u64::MAX);
            if grown.is_ok() {
                // Directions, depth, radiance and display.
                assert!(n > 4, "growing takes allocations");
                break;
            }
            renderer.resize([16, 12]).unwrap();
            assert_eq!(renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap(), before, "after failure {n}");
        }
    });
}

#[test]
fn a_budget_of_memory_holds() {
    const BUDGET: u64 = 48 << 20;
    let mask = Mask { memory: Some(BUDGET), ..Mask::default() };
    let instance = Arc::new(Instance::masked(true, mask).unwrap());
    let device = Device::open(instance.clone(), &DeviceChoice::Any).unwrap();
    assert_eq!(device.candidate().memory, BUDGET);
    let optics = optics(4.0, 1e-1);
    let layers = layers(&patch(SurfaceKind::Bumps, 2.0), &optics);
    let scene = Scene::open("plate").unwrap();
    paint(&device, &window(&layers), &optics, &scene).unwrap();
    // 4096² pixels of geometry alone take four times as much.
    let large = crate::renderer_of(&device, &scene, &window(&layers), &optics, [4096, 4096]);
    let error = large.err().expect("more than the budget");
    assert!(error.to_string().contains("no memory for the"), "{error}");
    assert!(error.remedies().contains(&Remedy::SmallerPicture), "{error}");
    paint(&device, &window(&layers), &optics, &scene).unwrap();
    drop(device);
    assert_eq!(instance.messages(), [""; 0]);
}

#[test]
fn a_device_that_is_lost_at_any_submission_is_told_and_stays_lost() {
    let optics = optics(4.0, 1e-1);
    let layers = layers(&patch(SurfaceKind::Bumps, 2.0), &optics);
    let scene = Scene::open("plate").unwrap();
    for n in (1..).step_by(7) {
        let mask = Mask { submission: Some(n), ..Mask::default() };
        let instance = Arc::new(Instance::masked(true, mask).unwrap());
        let device = Device::open(instance.clone(), &DeviceChoice::Any).unwrap();
        let painted = paint(&device, &window(&layers), &optics, &scene);
        let done = painted.is_ok();
        if let Err(error) = painted {
            assert!(error.kind() == ErrorKind::Device && device.is_lost(), "{error}");
            assert!(error.to_string().contains("lost"), "{error}");
            assert!(
                paint(&device, &window(&layers), &optics, &scene).is_err(),
                "a lost device does nothing any more"
            );
            assert_eq!(device.memory_in_use(), 0);
        }
        drop(device);
        assert_eq!(instance.messages(), [""; 0], "lost at submission {n}");
        if done {
            assert!(n > 20, "{n}");
            break;
        }
    }
}
