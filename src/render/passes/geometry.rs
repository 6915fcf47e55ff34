//! Geometry pass: draws the meshes into the G-buffer. Its shaders are `surface.vert` and `geometry.frag`.

use super::stencil_of;
use crate::error::Result;
use crate::render::device_mesh::attributes;
use crate::render::gbuffer::{GBuffer, UNCOVERED};
use crate::render::object::DeviceObject;
use crate::render::shader;
use crate::scene::Vertex;
use crate::vk::access::Access;
use crate::vk::commands::Recorder;
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::{Constant, Depth, Drawing, Pipeline, Stencil};
use ash::vk;
use std::sync::Arc;

/// Draws the surface that each pixel sees.
pub struct GeometryPass {
    // One per object.
    pipelines: Vec<Pipeline>,
}

impl GeometryPass {
    /// Makes a pass that draws `objects` into G-buffers like `gbuffer`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, objects: &[DeviceObject], gbuffer: &GBuffer) -> Result<Self> {
        // Specialisation constants of the fragment stage.
        const TEXTURED: u32 = 0;
        const GROOVES: u32 = 1;
        let settings = gbuffer.settings;
        let pipeline = |object: &DeviceObject| {
            let drawing = Drawing {
                vertex_stride: size_of::<Vertex>() as u32,
                attributes: &attributes(),
                colors: &gbuffer.images().map(Image::format).collect::<Vec<_>>(),
                depth: Some(Depth {
                    format: settings.depth_format(),
                    compare: vk::CompareOp::LESS,
                    write: true,
                    stencil: settings.several.then_some(Stencil::Write),
                }),
            };
            let constants =
                [Constant::new(TEXTURED, settings.textured), Constant::new(GROOVES, object.layout as u32)];
            let fragment = Some(shader!("geometry.frag").with(&constants));
            let sets = [&object.frame.descriptors];
            Pipeline::graphics(device, shader!("surface.vert"), fragment, &drawing, &sets, 0)
        };
        Ok(Self { pipelines: objects.iter().map(pipeline).collect::<Result<_>>()? })
    }

    /// Records the drawing of `objects` into `gbuffer`, whose images become readable by shaders.
    pub fn record(&self, record: &Recorder<'_>, gbuffer: &GBuffer, objects: &[DeviceObject]) {
        let change = |from: Access, to: Access| -> Vec<_> {
            gbuffer.images().map(|image| (image, from, to)).collect()
        };
        let mut before = change(Access::Nothing, Access::ColorAttachment);
        before.push((&gbuffer.depth, Access::Nothing, Access::DepthAttachment));
        record.images(&before);
        let colors: Vec<_> = gbuffer.images().map(|image| (image, Some([UNCOVERED; 4]))).collect();
        record.render(&colors, Some(&gbuffer.depth), |draw| {
            for (number, (object, pipeline)) in objects.iter().zip(&self.pipelines).enumerate() {
                draw.bind(pipeline, &[&object.frame.descriptors]);
                if gbuffer.settings.several {
                    draw.stencil(stencil_of(number));
                }
                object.mesh.draw(draw, 0);
            }
        });
        record.images(&change(Access::ColorAttachment, Access::ShaderRead));
    }
}
