//! Display of one sample, or of the mean of several, over a colour. Its shaders are `display.vert` and `display.frag`.

use super::covered;
use crate::error::Result;
use crate::optics::color::{self, Tone};
use crate::render::frame::Shown;
use crate::render::gbuffer::GBuffer;
use crate::render::shader;
use crate::render::target::Target;
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::{Constant, Depth, Drawing, Pipeline};
use crate::vk::sampler::Sampler;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use std::sync::Arc;

/// Pass that turns radiance into a displayed picture.
pub struct DisplayPass {
    pipeline: Pipeline,
    descriptors: Descriptors,
    _sampler: Sampler,
}

impl DisplayPass {
    /// Makes a pass that draws one sample into images of `format`, limited to the pixels covered in a depth of
    /// `depth_format`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, format: vk::Format, depth_format: vk::Format) -> Result<Self> {
        Self::with(device, format, Some(covered(depth_format)))
    }

    /// Makes a pass that draws the mean of samples into images of `format`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn of_mean(device: &Arc<Device>, format: vk::Format) -> Result<Self> {
        Self::with(device, format, None)
    }

    /// Makes the pass; without a `depth` test it displays a mean.
    fn with(device: &Arc<Device>, format: vk::Format, depth: Option<Depth>) -> Result<Self> {
        let descriptors = Descriptors::new(device, "display set", &[Binding::texture(0)])?;
        let drawing = Drawing { vertex_stride: 0, attributes: &[], colors: &[format], depth };
        /// `constant_id` of `display.frag`.
        const MEAN: u32 = 0;
        let constants = [Constant::new(MEAN, depth.is_none())];
        let fragment = Some(shader!("display.frag").with(&constants));
        let pipeline = Pipeline::graphics(
            device,
            shader!("display.vert"),
            fragment,
            &drawing,
            &[&descriptors],
            size_of::<DisplayBlock>() as u32,
        )?;
        let sampler = Sampler::linear(device, "display sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        Ok(Self { pipeline, descriptors, _sampler: sampler })
    }

    /// Points the pass at `radiance`, of one sample or summed. The device must not be using the pass.
    pub fn read_from(&self, radiance: &Image) {
        self.descriptors.image(0, radiance, &self._sampler);
    }

    /// Records the display of `target.radiance` (a colour attachment before) into the pixels of `into` that `gbuffer`
    /// covers, over the background. Afterwards the radiance is readable by shaders and `into` a colour attachment.
    pub fn record(
        &self,
        record: &Recorder<'_>,
        (gbuffer, target): (&GBuffer, &Target),
        into: &Image,
        shown: Shown,
    ) {
        record.images(&[
            (&target.radiance, Access::ColorAttachment, Access::ShaderRead),
            (into, Access::Nothing, Access::ColorAttachment),
            // The previous pass wrote the depth.
            (&gbuffer.depth, Access::DepthAttachment, Access::DepthAttachment),
        ]);
        let background = Some(displayed(shown.background));
        record.render_over(&[(into, background)], &gbuffer.depth, |draw| self.draw(draw, 1, shown));
    }

    /// Records the display of the mean of the `samples` summed samples into `into`, which becomes a colour attachment.
    pub fn record_mean(&self, record: &Recorder<'_>, into: &Image, samples: u32, shown: Shown) {
        record.images(&[(into, Access::Nothing, Access::ColorAttachment)]);
        let background = Some(displayed(shown.background));
        record.render(&[(into, background)], None, |draw| self.draw(draw, samples, shown));
    }

    fn draw(&self, draw: &Recorder<'_>, samples: u32, shown: Shown) {
        draw.bind(&self.pipeline, &[&self.descriptors]);
        draw.push(&self.pipeline, bytemuck::bytes_of(&DisplayBlock::new(samples, shown)));
        draw.draw(3);
    }
}

/// Push constants of `displayed.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(in crate::internals::render) struct DisplayBlock {
    background: [f32; 3],
    exposure: f32,
    samples: f32,
    neutral: u32,
}

impl DisplayBlock {
    /// Makes the block for the mean of `samples` samples.
    pub(in crate::internals::render) fn new(samples: u32, shown: Shown) -> Self {
        Self {
            background: color::map_to_gamut(shown.background).as_vec3().to_array(),
            exposure: shown.exposure as f32,
            samples: samples as f32,
            neutral: (shown.tone == Tone::Neutral).into(),
        }
    }
}

/// Returns the clear colour of a display pass: the sRGB code of `background`, without exposure.
pub(super) fn displayed(background: DVec3) -> [f32; 4] {
    let [r, g, b] = color::display(background, 0.0).map(|code| f32::from(code) / 255.0);
    [r, g, b, 1.0]
}
