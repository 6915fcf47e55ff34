//! Shading pass: the light of every covered pixel, from a source. Its shader is `shade.frag`.

use super::light_run::{LightPipelines, LightRun};
use super::{over_objects, stencil_of};
use crate::error::Result;
use crate::render::gbuffer::{GBuffer, GBufferSettings};
use crate::render::object::DeviceObject;
use crate::render::shader;
use crate::render::source::BoundSource;
use crate::render::source::part::Part;
use crate::render::target::{self, Target};
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::Descriptors;
use crate::vk::device::Device;
use crate::vk::pipeline::Pipeline;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::ops::Range;
use std::sync::Arc;

/// Pass that shades every covered pixel of a picture once. One triangle covers the picture, because the small triangles
/// of a mesh would leave most lanes of a device idle.
///
/// Adds to the picture: parts of a sum, lights and samples are drawn one after the other.
#[derive(Default)]
pub struct ShadePass {
    pipelines: LightPipelines,
}

impl ShadePass {
    /// Makes the pipeline for `lights`, unless it is there already. It shades the surfaces in G-buffers
    /// with these `settings`, from `source`, with the set layout of `frame`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn prepare(
        &mut self,
        device: &Arc<Device>,
        lights: LightRun,
        frame: &Descriptors,
        source: &BoundSource,
        settings: GBufferSettings,
    ) -> Result<()> {
        self.pipelines.prepare(lights, || {
            let constants = [source.shade_constants().as_slice(), &lights.constants()].concat();
            let (vertex, code) = (shader!("display.vert"), source.shade().with(&constants));
            let (sets, push_bytes) = ([frame, &source.descriptors], size_of::<ShadeBlock>() as u32);
            let drawing = over_objects(&[target::RADIANCE], settings);
            Pipeline::adding(device, vertex, code, &drawing, &sets, push_bytes)
        })
    }
}

/// Draw call of an object under lights of one kind.
#[derive(Clone, Copy)]
pub struct ShadedObject<'a> {
    /// Number of the object, from 0.
    pub number: usize,
    /// The object, with its frame.
    pub object: &'a DeviceObject,
    /// Source of the object.
    pub source: &'a BoundSource,
    /// Shading pass, prepared for the lights.
    pub pass: &'a ShadePass,
    /// Lights.
    pub lights: LightRun,
    /// White diffuse surface under the illuminant, linear sRGB.
    pub white: Vec3,
    /// True if this draw adds 1 to the coverage of its pixels.
    pub counts: bool,
}

impl ShadedObject<'_> {
    /// Adds these `parts` of the sum to the pixels of the object. `several`: the stencil tells them from those of others.
    fn draw(&self, draw: &Recorder<'_>, several: bool, parts: &Range<u32>) {
        let Self { number, object, source, lights, white, counts, .. } = *self;
        let Some(pipeline) = self.pass.pipelines.of(lights) else { return };
        let all = source.parts(lights.mirrored);
        for part in Part::each(all).filter(|part| parts.contains(&part.first)) {
            draw.bind(pipeline, &[&object.frame.descriptors, &source.descriptors]);
            if several {
                draw.stencil(stencil_of(number));
            }
            let coverage = if counts && part.first == 0 { 1.0 } else { 0.0 };
            let block = ShadeBlock { part, coverage, padding: 0.0, white: white.extend(0.0).to_array() };
            draw.push(pipeline, bytemuck::bytes_of(&block));
            draw.draw(3);
        }
    }
}

/// Push constants of `shade.frag`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ShadeBlock {
    part: Part,
    coverage: f32,
    padding: f32,
    white: [f32; 4],
}

/// Records the shading of `objects` in the pixels that `gbuffer` covers, by these `parts` of their sums, into
/// `target.radiance`, which stays a colour attachment. The `first` shading of a picture clears the radiance; the others
/// add to it. Alpha counts the samples that cover a pixel.
pub fn record(
    record: &Recorder<'_>,
    (gbuffer, target): (&GBuffer, &Target),
    objects: &[ShadedObject<'_>],
    parts: Range<u32>,
    first: bool,
) {
    record.images(&[
        (&target.radiance, Access::ColorAttachment, Access::ColorAttachment),
        (&gbuffer.depth, Access::DepthAttachment, Access::DepthAttachment),
    ]);
    let several = gbuffer.settings.several;
    let shade = |draw: &Recorder<'_>| {
        objects.iter().for_each(|shaded| shaded.draw(draw, several, &parts));
    };
    if first {
        record.render_over(&[(&target.radiance, Some([0.0; 4]))], &gbuffer.depth, shade);
    } else {
        record.render_onto(&target.radiance, Some(&gbuffer.depth), shade);
    }
}

/// Records the barrier that makes `target.radiance` a colour attachment for [`record`].
pub fn begin(record: &Recorder<'_>, target: &Target) {
    record.images(&[(&target.radiance, Access::Nothing, Access::ColorAttachment)]);
}
