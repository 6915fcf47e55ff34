//! Directions of a light at every pixel, exactly as shading computes them, for read-back. The shader is
//! `directions.frag`.

use super::light_run::{LightPipelines, LightRun};
use super::{over_objects, stencil_of};
use crate::error::Result;
use crate::render::gbuffer::GBuffer;
use crate::render::object::DeviceObject;
use crate::render::shader;
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::Pipeline;
use ash::vk;
use std::sync::Arc;

const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// Images of the directions of a light, of one picture size. Undefined at uncovered pixels.
pub struct LightDirections {
    /// ω_i in the frame of the patch, from below in shadow; w: falloff of the light, 1 for a distant one.
    pub light: Image,
    /// Jacobian of (u, v) = −(ω_i + ω_r).xy: du/dx, dv/dx, du/dy, dv/dy per pixel, x to the right and y downward.
    pub footprints: Image,
    /// Radiance of the surroundings in the mirrored direction.
    pub mirrored: Image,
    pipelines: LightPipelines,
}

impl LightDirections {
    /// Makes images of `size` pixels.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, size: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as Usage;
        let usage = Usage::COLOR_ATTACHMENT | Usage::TRANSFER_SRC | Usage::SAMPLED;
        let image = |name| {
            Image::new(device, &Description { name, format: FORMAT, size, layers: 1, array: false, usage })
        };
        Ok(Self {
            light: image("directions of the light")?,
            footprints: image("footprints")?,
            mirrored: image("mirrored radiance")?,
            pipelines: LightPipelines::default(),
        })
    }

    /// Makes the pipeline for `run`, a single light, unless it is there already.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn prepare(
        &mut self,
        device: &Arc<Device>,
        run: LightRun,
        object: &DeviceObject,
        gbuffer: &GBuffer,
    ) -> Result<()> {
        self.pipelines.prepare(anywhere(run), || {
            let constants = run.constants();
            let fragment = Some(shader!("directions.frag").with(&constants));
            let drawing = over_objects(&[FORMAT; 3], gbuffer.settings);
            let sets = [&object.frame.descriptors];
            let push_bytes = size_of::<u32>() as u32;
            Pipeline::graphics(device, shader!("display.vert"), fragment, &drawing, &sets, push_bytes)
        })
    }

    /// Records the directions of the light `run` at the pixels of `objects`, whose `Frame` blocks hold the light. The
    /// images become readable by shaders.
    pub fn record(&self, record: &Recorder<'_>, run: LightRun, gbuffer: &GBuffer, objects: &[DeviceObject]) {
        let Some(pipeline) = self.pipelines.of(anywhere(run)) else { return };
        let images = [&self.light, &self.footprints, &self.mirrored];
        let mut before = images.map(|image| (image, Access::Nothing, Access::ColorAttachment)).to_vec();
        before.push((&gbuffer.depth, Access::DepthAttachment, Access::DepthAttachment));
        record.images(&before);
        let cleared = images.map(|image| (image, Some([0.0; 4])));
        record.render_over(&cleared, &gbuffer.depth, |draw| {
            for (number, object) in objects.iter().enumerate() {
                draw.bind(pipeline, &[&object.frame.descriptors]);
                if gbuffer.settings.several {
                    draw.stencil(stencil_of(number));
                }
                draw.push(pipeline, bytemuck::bytes_of(&run.first));
                draw.draw(3);
            }
        });
        record.images(&images.map(|image| (image, Access::ColorAttachment, Access::ShaderRead)));
    }
}

/// Returns `run` at the first place: one pipeline serves lights at all places.
fn anywhere(run: LightRun) -> LightRun {
    LightRun { first: 0, ..run }
}
