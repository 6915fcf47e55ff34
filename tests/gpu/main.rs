//! The Vulkan side against the f64 side, on whatever device there is (lavapipe in `make test`), with validation and
//! synchronization checks on: a message is a failure, a missing device too.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on has failed")]

mod accumulate;
mod colours;
mod convergence;
mod device;
mod display;
mod evaluation;
mod export;
mod export_engines;
mod extremes;
mod faults;

mod hazards;
mod interface;
mod kept;
mod lamps;
mod light_passes;
mod light_spectra;
mod lights;
mod long_run;
mod mean;
mod measure;
mod objects;
#[cfg(feature = "viewer")]
mod panel;
mod picture;
mod pipelines;
mod promise;
mod rays;
mod repeats;
mod replay;
mod replay_tests;
mod shared;
mod single_samples;
mod tasks;
mod thesis;
#[cfg(feature = "viewer")]
mod viewer;

use diffract::internals::error::Result;
use diffract::internals::render::object::{ObjectData, ObjectSources};
use diffract::internals::render::pigment::Pigment;
use diffract::internals::render::renderer::{Renderer, RendererSettings};
use diffract::internals::render::source::Source;
use diffract::internals::scene::{Mesh, Scene};
use diffract::internals::settings::Optics;
use diffract::internals::vk::device::Device;
use std::sync::Arc;

/// Returns a renderer of one object with its patch along the mesh.
fn renderer(
    device: &Arc<Device>,
    source: &Source,
    optics: &Optics,
    mesh: &Mesh,
    pigment: &Pigment,
    size: [u32; 2],
) -> Result<Renderer> {
    renderer_with(device, source, optics, (mesh, pigment), size, RendererSettings::default())
}

/// Settings of a renderer whose objects cast shadows, if `shadows`.
fn shadows(shadows: bool) -> RendererSettings {
    RendererSettings { shadows, ..RendererSettings::default() }
}

/// Returns a renderer of one mesh with `settings`.
fn renderer_with(
    device: &Arc<Device>,
    source: &Source,
    optics: &Optics,
    (mesh, pigment): (&Mesh, &Pigment),
    size: [u32; 2],
    settings: RendererSettings,
) -> Result<Renderer> {
    let sources = ObjectSources::new(source.clone(), optics.clone());
    Renderer::new(device, &[ObjectData::new(mesh, pigment, &sources)], size, settings)
}

/// Returns a renderer of the main object of `scene`, without pigment.
fn renderer_of(
    device: &Arc<Device>,
    scene: &Scene,
    source: &Source,
    optics: &Optics,
    size: [u32; 2],
) -> Result<Renderer> {
    renderer(device, source, optics, &scene.main_object().mesh, &Pigment::white(), size)
}
