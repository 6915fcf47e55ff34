//! What the program records, replayed without the device: no barrier is missing.

use crate::device::with_device;
use crate::evaluation::{colours, grating, layers, optics, patch, window};
use crate::mean::source;
use crate::replay::check;
use diffract::internals::filter::FootprintSizes;
use diffract::internals::optics::coherence::Windows;
use diffract::internals::render::evaluator::Evaluator;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::renderer::Renderer;
use diffract::internals::render::sampling::Sampling;
use diffract::internals::scene::{Environment, Light, Scene};
use diffract::internals::settings::{Method, Optics};
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use diffract::internals::vk::access::Access;
use diffract::internals::vk::device::Device;
use diffract::internals::vk::event_log::{RecordedEvent, Resource};
use glam::DVec3;
use std::sync::Arc;

const SIZE: [u32; 2] = [24, 18];
const SHOWN: Shown = Shown::plain(0.5, DVec3::new(0.1, 0.2, 0.3));

/// What `work` records.
fn recorded(device: &Arc<Device>, work: impl FnOnce()) -> Vec<RecordedEvent> {
    device.events().start();
    device.events().take();
    work();
    device.events().take()
}

/// Fails unless `events` have each of `accesses` and no finding.
#[track_caller]
fn assert_clean(events: &[RecordedEvent], accesses: &[Access]) {
    for access in accesses {
        let has = |event: &RecordedEvent| match event {
            RecordedEvent::Used(_, used, _) => used == access,
            RecordedEvent::Bound(bound) => bound.iter().any(|(_, used)| used == access),
            _ => false,
        };
        assert!(events.iter().any(has), "{access:?} is not in {} events", events.len());
    }
    assert_eq!(check(events), [""; 0], "{} events", events.len());
}

/// Fails unless `events` without all barriers that `is` names have a finding.
#[track_caller]
fn assert_missed(events: &[RecordedEvent], is: impl Fn(&Access, &Access) -> bool) {
    use Access::{
        ColorAttachment, ComputeWrite, HostRead, ShaderRead, TransferRead, TransferWrite, VertexRead,
    };
    let all = [ColorAttachment, ComputeWrite, HostRead, ShaderRead, TransferRead, TransferWrite, VertexRead];
    let pairs = || all.iter().flat_map(|from| all.iter().map(move |to| (from, to))).filter(|(a, b)| is(a, b));
    let named = |event: &RecordedEvent| match event {
        RecordedEvent::Barrier(scopes) => pairs().any(|(from, to)| {
            let barrier = from.memory_barrier(*to);
            scopes.source == (barrier.src_stage_mask, barrier.src_access_mask)
                && scopes.destination == (barrier.dst_stage_mask, barrier.dst_access_mask)
        }),
        _ => false,
    };
    let lacking: Vec<RecordedEvent> = events.iter().filter(|event| !named(event)).cloned().collect();
    assert!(lacking.len() < events.len(), "there is no such barrier");
    assert!(!check(&lacking).is_empty(), "nothing is missed");
}

fn view(scene: &Scene, lights: usize) -> View {
    let light = |i| Light::point(40.0, 30.0 * i as f64, 1.0);
    View::of(scene, (0..lights).map(light).collect())
}

fn mean() -> Optics {
    Optics { windows: Windows::All, ..optics(4.0, 2e-1) }.for_pictures()
}

#[test]
fn an_evaluation_has_all_its_barriers() {
    let optics = optics(4.0, 1e-1);
    let field = patch(SurfaceKind::Bumps, 2.0);
    let layers = layers(&field, &optics);
    with_device(|device| {
        for source in [window(&layers), grating(&layers, [3, 2], &field)] {
            let events = recorded(device, || {
                let mut evaluator = Evaluator::new(device, &source, &optics).unwrap();
                for seed in 1..3 {
                    evaluator.cosine_weighted(&colours(seed, 100)).unwrap();
                }
            });
            use Access::{ComputeWrite, HostRead, ShaderRead, TransferWrite};
            assert_clean(&events, &[ComputeWrite, HostRead, ShaderRead, TransferWrite]);
            assert_missed(&events, |from, to| (*from, *to) == (ComputeWrite, HostRead));
        }
    });
}

#[test]
fn pictures_from_spectra_tables_and_windows_have_all_their_barriers() {
    let field = patch(SurfaceKind::Bumps, 2.0);
    let scene = Scene::open("sphere").unwrap();
    let one = optics(4.0, 1e-1);
    let layers = layers(&field, &one);
    with_device(|device| {
        for lights in [1, 4] {
            let view = view(&scene, lights);
            let draw = |source: &_, optics: &Optics| {
                let white = Pigment::white();
                let mesh = &scene.main_object().mesh;
                let mut renderer = crate::renderer(device, source, optics, mesh, &white, SIZE).unwrap();
                // A frame and its read-back, the accumulation of several, and another size.
                renderer.render_plain(&view, SHOWN.exposure, SHOWN.background).unwrap();
                let sampling = Sampling { count: 3, seed: 1 };
                renderer.render(&view, &sampling, SHOWN, &Task::silent()).unwrap();
                renderer.display(SIZE, Shown { exposure: 1.0, ..SHOWN }).unwrap();
                renderer.read_back().unwrap();
                renderer.directions(&view, lights - 1).unwrap();
                renderer.resize([12, 8]).unwrap();
                renderer.render_plain(&view, SHOWN.exposure, SHOWN.background).unwrap();
            };
            let mut recordings = vec![recorded(device, || draw(&window(&layers), &one))];
            recordings.push(recorded(device, || {
                let sizes = FootprintSizes { shorter: 1e-2, longer: 1e-2 };
                draw(&source(device, &field, &mean(), Method::Table, sizes), &mean());
            }));
            for events in &recordings {
                use Access::{
                    ColorAttachment, DepthAttachment, HostRead, ShaderRead, TransferRead, TransferWrite,
                    VertexRead,
                };
                let drawing = [ColorAttachment, DepthAttachment, ShaderRead, VertexRead];
                assert_clean(events, &[&drawing[..], &[TransferWrite, TransferRead, HostRead]].concat());
                assert_missed(events, |from, to| (*from, *to) == (TransferWrite, VertexRead));
                assert_missed(events, |from, to| (*from, *to) == (TransferWrite, HostRead));
                let without_source: Vec<RecordedEvent> =
                    events.iter().cloned().map(without_color_source).collect();
                assert!(!check(&without_source).is_empty(), "barriers from attachments are not looked at");
            }
        }
    });
}

/// A barrier from a colour attachment without the scope that waits for it.
fn without_color_source(mut event: RecordedEvent) -> RecordedEvent {
    use ash::vk::{AccessFlags2, PipelineStageFlags2};
    if let RecordedEvent::ImageBarrier(_, scopes, _) = &mut event
        && scopes.source.0 == PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT
    {
        scopes.source = (PipelineStageFlags2::NONE, AccessFlags2::NONE);
    }
    event
}

/// The events of `draw` with a renderer of `scene` that casts shadows and reads a colour table.
fn recorded_pictures(
    device: &Arc<Device>,
    scene: &Scene,
    draw: impl FnOnce(&mut Renderer),
) -> Vec<RecordedEvent> {
    let (field, sizes) = (patch(SurfaceKind::Bumps, 2.0), FootprintSizes { shorter: 1e-2, longer: 1e-2 });
    let source = source(device, &field, &mean(), Method::Table, sizes);
    recorded(device, || {
        let mesh = (&scene.main_object().mesh, &Pigment::white());
        let mut renderer =
            crate::renderer_with(device, &source, &mean(), mesh, SIZE, crate::shadows(true)).unwrap();
        draw(&mut renderer);
    })
}

#[test]
fn a_picture_before_its_surroundings_and_under_a_lamp_has_all_its_barriers() {
    let scene = Scene::open("sphere").unwrap();
    let lamp = Light::parse("sphere:0.3:2,-1,2").unwrap();
    let mut view = View::of(&scene, vec![lamp]);
    view.environment = Some(Environment::open("studio").unwrap());
    view.shows_surroundings = true;
    with_device(|device| {
        let events = recorded_pictures(device, &scene, |renderer| {
            renderer.render_plain(&view, SHOWN.exposure, SHOWN.background).unwrap();
            renderer.render(&view, &Sampling { count: 3, seed: 1 }, SHOWN, &Task::silent()).unwrap();
            renderer.display(SIZE, Shown { exposure: 1.0, ..SHOWN }).unwrap();
            renderer.read_back().unwrap();
        });
        use Access::{
            ColorAttachment, DepthAttachment, HostRead, ShaderRead, TransferRead, TransferWrite, VertexRead,
        };
        let drawing = [ColorAttachment, DepthAttachment, ShaderRead, VertexRead];
        assert_clean(&events, &[&drawing[..], &[TransferWrite, TransferRead, HostRead]].concat());
        let without_source: Vec<RecordedEvent> = events.iter().cloned().map(without_color_source).collect();
        assert!(!check(&without_source).is_empty(), "barriers from attachments are not looked at");
    });
}

#[test]
fn a_depth_map_is_drawn_where_its_light_has_moved() {
    let scene = Scene::open("sphere").unwrap();
    let mut view = view(&scene, 1);
    view.environment = Some(Environment::open("sky").unwrap());
    with_device(|device| {
        let events = recorded_pictures(device, &scene, |renderer| {
            renderer.render(&view, &Sampling { count: 16, seed: 1 }, SHOWN, &Task::silent()).unwrap();
        });
        let maps: Vec<Resource> = events
            .iter()
            .filter_map(|event| match event {
                RecordedEvent::Made(resource, name) if name == "shadow maps" => Some(*resource),
                _ => None,
            })
            .collect();
        let drawn = |layer: u32| {
            let is = |event: &&RecordedEvent| match event {
                RecordedEvent::Used(resource, Access::DepthAttachment, Some(area)) => {
                    maps.contains(resource) && area.layer == [layer, 0]
                }
                _ => false,
            };
            events.iter().filter(is).count()
        };
        // One map of the point, and one of each direction of the sky, whatever the number of samples.
        assert_eq!([drawn(0), drawn(1), drawn(31), drawn(32)], [2, 1, 1, 0]);
    });
}
