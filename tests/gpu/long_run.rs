//! Frame after frame: what a program takes while it draws, and that it takes no more and more.

use crate::device::with_device;
use crate::evaluation::{layers, optics, patch, window};
use diffract::internals::figure::{Axis, Figure, FigureStyle, Mark, Panel, palette};
use diffract::internals::notes::Notes;
use diffract::internals::render::frame::View;
use diffract::internals::scene::{Light, Scene};
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::vk::device::Device;
use diffract::internals::vk::instance::Instance;
use diffract::internals::vk::selection::DeviceChoice;
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// What is taken after a number of frames.
#[derive(Clone, Copy, Debug)]
struct Sample {
    frames: usize,
    /// Of the process, as the system counts it \[bytes\].
    resident: u64,
    /// Of the device, by this program's resources \[bytes\].
    on_device: u64,
}

/// Memory of this process that is in RAM \[bytes\]; 0 where the system does not say.
fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages: u64 = text.split_whitespace().nth(1).and_then(|n| n.parse().ok()).unwrap_or(0);
    pages * 4096
}

/// Draws `frames` frames, the light a little further each time, and looks `looks` times.
fn run(device: &Arc<Device>, frames: usize, looks: usize) -> Vec<Sample> {
    let optics = optics(4.0, 1e-1);
    let layers = layers(&patch(SurfaceKind::Bumps, 2.0), &optics);
    let scene = Scene::open("plate").unwrap();
    let mut view = View::of(&scene, vec![Light::point(40.0, 0.0, 1.0)]);
    let mut renderer = crate::renderer_of(device, &scene, &window(&layers), &optics, [16, 12]).unwrap();
    let mut samples = Vec::with_capacity(looks + 1);
    for frame in 0..=frames {
        view.lights[0] = Light::point(40.0, (frame % 360) as f64, 1.0);
        renderer.draw_plain(&view, 0.0, DVec3::ZERO).unwrap();
        if frame % (frames / looks) == 0 {
            samples.push(Sample { frames: frame, resident: resident(), on_device: device.memory_in_use() });
        }
    }
    samples
}

#[test]
fn frame_after_frame_the_device_holds_the_same() {
    with_device(|device| {
        let samples = run(device, 400, 20);
        assert!(samples[0].on_device > 0);
        assert!(samples.iter().all(|s| s.on_device == samples[0].on_device), "{samples:?}");
    });
}

/// `tools/test.sh --test gpu long_run -- --ignored` measures anew and draws docs/images/long-run.svg.
#[test]
#[ignore = "takes some minutes"]
fn over_a_hundred_thousand_frames_memory_is_flat() {
    const FRAMES: usize = 100_000;
    const MIB: f64 = 1024.0 * 1024.0;
    let instance = Arc::new(Instance::new(false).unwrap()); // validation keeps notes of its own
    let device = Device::open(instance, &DeviceChoice::Any).unwrap();
    let begun = Instant::now();
    let samples = run(&device, FRAMES, 200);
    let seconds = begun.elapsed().as_secs_f64();
    let (warm, last) = (samples[samples.len() / 10], samples[samples.len() - 1]);
    let growth = last.resident as f64 / MIB - warm.resident as f64 / MIB;
    eprintln!(
        "{FRAMES} frames in {seconds:.0} s; resident {:.1} MiB after {} frames, {:.1} MiB at the end, on the device {:.3} MiB",
        warm.resident as f64 / MIB,
        warm.frames,
        last.resident as f64 / MIB,
        last.on_device as f64 / MIB
    );
    let line = |of: &dyn Fn(&Sample) -> f64| -> Vec<[f64; 2]> {
        samples.iter().map(|s| [s.frames as f64 / 1e3, of(s)]).collect()
    };
    let (host, ours) = (line(&|s| s.resident as f64 / MIB), line(&|s| s.on_device as f64 / 1024.0));
    let most = |points: &[[f64; 2]]| points.iter().map(|p| p[1]).fold(0.0, f64::max);
    let panel = |label: &str, points: Vec<[f64; 2]>, color| {
        let y = Axis::linear(label, 0.0, most(&points) * 1.25);
        Panel::new(Axis::linear("thousand frames", 0.0, FRAMES as f64 / 1e3), y)
            .mark(Mark::line(points, color))
    };
    let caption = format!(
        "{FRAMES} pictures of 16 × 12 pixels, one after the other, each with the light moved: resident memory of the \
         process (left; {growth:+.1} MiB after the first tenth) and what the program's resources take of the device \
         (right; the same in every sample). {}.",
        device.candidate().name
    );
    let figure = Figure::new("Memory over a hundred thousand frames")
        .row(vec![
            panel("resident memory [MiB]", host, palette::BLUE).titled("The process"),
            panel("device memory in use [KiB]", ours, palette::ORANGE).titled("The device"),
        ])
        .panel_size(460.0, 320.0)
        .caption(caption);
    figure
        .save(
            &Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/images/long-run.svg"),
            &FigureStyle::default(),
            &Notes::default(),
        )
        .unwrap();
    assert!(samples.iter().all(|s| s.on_device == samples[0].on_device));
    assert!(growth < 4.0, "{growth} MiB more after {FRAMES} frames");
}
