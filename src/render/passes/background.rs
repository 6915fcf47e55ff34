//! The surroundings as the background of a picture. Its shaders are `background.vert` and `background.frag`.

use super::covered;
use super::display::DisplayBlock;
use crate::error::Result;
use crate::render::frame::Shown;
use crate::render::frame_set::FrameSet;
use crate::render::gbuffer::GBuffer;
use crate::render::shader;
use crate::render::target;
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::{Constant, Depth, Drawing, Pipeline};
use crate::vk::sampler::Sampler;
use ash::vk;
use std::sync::Arc;

/// Displays the surroundings behind the objects.
pub struct BackgroundPass {
    sample: Pipeline,
    mean: Pipeline,
    sum: Descriptors,
    sampler: Sampler,
}

impl BackgroundPass {
    /// Makes a pass over pictures that `frame` describes, with a depth buffer of `depth_format`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, frame: &FrameSet, depth_format: vk::Format) -> Result<Self> {
        let sum = Descriptors::new(device, "set of surroundings", &[Binding::texture(0)])?;
        let pipeline = |mean: bool| {
            // Depth still has its clear value where no object covers the pixel.
            let compare = vk::CompareOp::EQUAL;
            let depth = (!mean).then_some(Depth { compare, ..covered(depth_format) });
            let drawing = Drawing { vertex_stride: 0, attributes: &[], colors: &[target::DISPLAY], depth };
            /// `constant_id` of `background.frag`.
            const MEAN: u32 = 0;
            let constants = [Constant::new(MEAN, mean)];
            let fragment = Some(shader!("background.frag").with(&constants));
            let sets = [&frame.descriptors, &sum];
            let push_bytes = size_of::<DisplayBlock>() as u32;
            Pipeline::graphics(device, shader!("background.vert"), fragment, &drawing, &sets, push_bytes)
        };
        Ok(Self {
            sample: pipeline(false)?,
            mean: pipeline(true)?,
            sampler: Sampler::nearest(device, "sampler of sums")?,
            sum,
        })
    }

    /// Points the pass at the foreground: a sum of samples, or any readable image if there is none. The device must not
    /// be using the pass.
    pub fn read_from(&self, sum: &Image) {
        self.sum.image(0, sum, &self.sampler);
    }

    /// Records the surroundings into the pixels of `into` (a colour attachment before and after) that `gbuffer` leaves
    /// uncovered, behind the single sample displayed there.
    pub fn record(
        &self,
        record: &Recorder<'_>,
        gbuffer: &GBuffer,
        into: &Image,
        (frame, shown): (&Descriptors, Shown),
    ) {
        record.images(&[
            (into, Access::ColorAttachment, Access::ColorAttachment),
            (&gbuffer.depth, Access::DepthAttachment, Access::DepthAttachment),
        ]);
        record.render_over(&[(into, None)], &gbuffer.depth, |draw| {
            self.draw(draw, &self.sample, frame, (1, shown));
        });
    }

    /// Records the mean of `samples` samples over the surroundings into `into`, which becomes a colour attachment.
    pub fn record_mean(
        &self,
        record: &Recorder<'_>,
        into: &Image,
        frame: &Descriptors,
        (samples, shown): (u32, Shown),
    ) {
        record.images(&[(into, Access::Nothing, Access::ColorAttachment)]);
        record.render(&[(into, Some([0.0; 4]))], None, |draw| {
            self.draw(draw, &self.mean, frame, (samples, shown));
        });
    }

    fn draw(
        &self,
        draw: &Recorder<'_>,
        pipeline: &Pipeline,
        frame: &Descriptors,
        (samples, shown): (u32, Shown),
    ) {
        draw.bind(pipeline, &[frame, &self.sum]);
        draw.push(pipeline, bytemuck::bytes_of(&DisplayBlock::new(samples, shown)));
        draw.draw(3);
    }
}
