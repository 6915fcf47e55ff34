//! Pass that measures how fast the device reads the texture of a source. Its shader is `probe.frag`.

use crate::error::Result;
use crate::render::shader;
use crate::render::source::BoundSource;
use crate::render::target::{self, Target};
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::Descriptors;
use crate::vk::device::Device;
use crate::vk::pipeline::{Drawing, Pipeline};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Push constants of `probe.frag`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Probe {
    /// Texture samples per pixel.
    pub samples: u32,
    /// 1 if every pixel reads at a random place, 0 if neighbours read neighbours.
    pub scattered: u32,
}

/// Pass that reads texels of a source and does nothing else.
pub struct ProbePass {
    pipeline: Pipeline,
}

impl ProbePass {
    /// Makes the pass of `source`, with the set layout of `frame`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, frame: &Descriptors, source: &BoundSource) -> Result<Self> {
        let (vertex, code) = (shader!("display.vert"), source.probe().with(source.constants()));
        let drawing = Drawing { vertex_stride: 0, attributes: &[], colors: &[target::RADIANCE], depth: None };
        let (sets, push_bytes) = ([frame, &source.descriptors], size_of::<Probe>() as u32);
        Ok(Self { pipeline: Pipeline::graphics(device, vertex, Some(code), &drawing, &sets, push_bytes)? })
    }

    /// Records the pass over all of `target.radiance`.
    pub fn record(&self, record: &Recorder<'_>, target: &Target, sets: [&Descriptors; 2], probe: Probe) {
        record.images(&[(&target.radiance, Access::Nothing, Access::ColorAttachment)]);
        record.render(&[(&target.radiance, Some([0.0; 4]))], None, |draw| {
            draw.bind(&self.pipeline, &sets);
            draw.push(&self.pipeline, bytemuck::bytes_of(&probe));
            draw.draw(3);
        });
    }
}
