//! Where two settings differ: the relative difference of two radiances, pixel by pixel, in false colour.

use super::frame::{COVERED, displayed};
use super::target::{self, Geometry, Target};
use super::{shader, window};
use crate::error::Result;
use crate::optics::color::DISPLAY_BLACK;
use crate::vk::access::Access;
use crate::vk::commands::Commands;
use crate::vk::descriptors::Descriptors;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::{Drawing, Pipeline};
use crate::vk::sampler::Sampler;
use ash::vk;
use glam::DVec3;
use std::sync::Arc;

/// Viridis at nine errors, half a decade apart from 1e-4 to 1, sRGB-encoded; twin of `STOPS` in `difference.frag`.
pub const STOPS: [[f32; 3]; 9] = [
    [0.267, 0.005, 0.329],
    [0.278, 0.173, 0.478],
    [0.231, 0.319, 0.545],
    [0.172, 0.443, 0.557],
    [0.129, 0.565, 0.553],
    [0.153, 0.678, 0.506],
    [0.361, 0.784, 0.388],
    [0.667, 0.863, 0.196],
    [0.993, 0.906, 0.144],
];

/// The colour of a relative error, sRGB-encoded, from 1e-4 and less to 1 and more.
pub fn color(error: f32) -> [f32; 3] {
    let place = (error.max(1e-20).log10() + 4.0).clamp(0.0, 4.0) * 2.0;
    let stop = (place as usize).min(STOPS.len() - 2);
    let part = place - stop as f32;
    std::array::from_fn(|i| STOPS[stop][i] + (STOPS[stop + 1][i] - STOPS[stop][i]) * part)
}

/// Draws differences.
pub struct DifferencePass {
    commands: Commands,
    pipeline: Pipeline,
    descriptors: Descriptors,
    sampler: Sampler,
    image: Arc<Image>,
    device: Arc<Device>,
}

impl DifferencePass {
    /// For pictures of `size` pixels.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(device: &Arc<Device>, size: [u32; 2]) -> Result<Self> {
        let descriptors = window::bindings(device)?;
        let drawing =
            Drawing { vertex_stride: 0, attributes: &[], colors: &[target::DISPLAY], depth: COVERED };
        let (vertex, fragment) = (shader!("display.vert"), Some(shader!("difference.frag")));
        Ok(Self {
            commands: Commands::new(device, "difference")?,
            pipeline: Pipeline::graphics(
                device,
                vertex,
                fragment,
                &drawing,
                &[&descriptors],
                size_of::<f32>() as u32,
            )?,
            descriptors,
            sampler: Sampler::linear(device, "difference sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?,
            image: Arc::new(picture(device, size)?),
            device: device.clone(),
        })
    }

    /// The difference of `judged` from `judge`, two whole pictures of what `geometry` has that are displayed at `exposure`, over
    /// `background`. Waits until it is drawn and readable by shaders.
    ///
    /// # Errors
    /// Where the device is lost or has no room.
    pub fn draw(
        &mut self,
        geometry: &Geometry,
        [judged, judge]: [&Target; 2],
        exposure: f64,
        background: DVec3,
    ) -> Result<&Arc<Image>> {
        if self.image.size() != judge.size() {
            self.image = Arc::new(picture(&self.device, judge.size())?);
        }
        self.descriptors.image(0, &judged.radiance, &self.sampler);
        self.descriptors.image(1, &judge.radiance, &self.sampler);
        // What a display shows as black is not wrong.
        let floor = (DISPLAY_BLACK / exposure.exp2()) as f32;
        let image = &self.image;
        self.commands.run(|record| {
            record.memory(Access::ShaderRead, Access::ColorAttachment);
            record.images(&[
                (image, Access::Nothing, Access::ColorAttachment),
                (&geometry.depth, Access::DepthAttachment, Access::DepthAttachment),
            ]);
            record.render_over(&[(image, Some(displayed(background)))], &geometry.depth, |draw| {
                draw.bind(&self.pipeline, &[&self.descriptors]);
                draw.push(&self.pipeline, bytemuck::bytes_of(&floor));
                draw.draw(3);
            });
            record.images(&[(image, Access::ColorAttachment, Access::ShaderRead)]);
            Ok(())
        })?;
        Ok(&self.image)
    }
}

fn picture(device: &Arc<Device>, size: [u32; 2]) -> Result<Image> {
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
        | vk::ImageUsageFlags::SAMPLED
        | vk::ImageUsageFlags::TRANSFER_SRC;
    let (format, name) = (target::DISPLAY, "difference");
    Image::new(device, &Description { name, format, size, layers: 1, array: false, usage })
}
