//! A frame: depth, shading, display. The same commands draw offscreen and to a window.

use super::interface::FrameBlock;
use super::target::{self, Target};
use super::{shader, upload};
use crate::error::{Error, Result};
use crate::scene::{Camera, Light, MAX_LIGHTS, Mesh, Vertex};
use crate::vk::access::Access;
use crate::vk::buffer::Buffer;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use crate::vk::pipeline::{Drawing, Pipeline};
use crate::vk::sampler::Sampler;
use ash::vk;
use glam::{DVec3, Vec3};
use std::mem::offset_of;
use std::sync::Arc;

/// A mesh in device memory.
pub struct DeviceMesh {
    vertices: Buffer,
    indices: Buffer,
    count: u32,
}

impl DeviceMesh {
    /// Uploads `mesh`.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(device: &Arc<Device>, mesh: &Mesh) -> Result<Self> {
        let count = u32::try_from(mesh.indices().len())
            .map_err(|_| Error::failed("the mesh has too many triangles", "simplify it first"))?;
        Ok(Self {
            vertices: upload::buffer(
                device,
                "vertices",
                vk::BufferUsageFlags::VERTEX_BUFFER,
                bytemuck::cast_slice(mesh.vertices()),
            )?,
            indices: upload::buffer(
                device,
                "indices",
                vk::BufferUsageFlags::INDEX_BUFFER,
                bytemuck::cast_slice(mesh.indices()),
            )?,
            count,
        })
    }
}

/// What a frame shows.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Centre and radius of what is looked at.
    pub centre: Vec3,
    /// Radius around `centre`.
    pub radius: f32,
    /// Lights; those beyond [`MAX_LIGHTS`] are not drawn.
    pub lights: Vec<Light>,
    /// Albedo of the pigment.
    pub base_color: Vec3,
    /// Whether the pigment texture counts.
    pub pigment: bool,
}

impl View {
    /// The `Frame` block for a picture of `size` pixels.
    pub fn block(&self, size: [u32; 2]) -> FrameBlock {
        let mut lights = [[0.0, 0.0, 1.0, 0.0]; MAX_LIGHTS];
        for (slot, light) in lights.iter_mut().zip(&self.lights) {
            *slot = light.direction().extend(light.intensity as f32).to_array();
        }
        FrameBlock {
            clip_from_world: self.camera.clip_from_world(size, self.centre, self.radius).to_cols_array_2d(),
            eye: self.camera.eye().extend(0.0).to_array(),
            lights,
            base_color: self.base_color.extend(if self.pigment { 1.0 } else { 0.0 }).to_array(),
            counts: [self.lights.len().min(MAX_LIGHTS) as i32, 0, 0, 0],
        }
    }
}

/// Attributes of [`Vertex`], in the order of `surface.vert`.
fn attributes() -> [vk::VertexInputAttributeDescription; 4] {
    let of = |location, format, offset: usize| {
        vk::VertexInputAttributeDescription::default().location(location).format(format).offset(offset as u32)
    };
    [
        of(0, vk::Format::R32G32B32_SFLOAT, offset_of!(Vertex, position)),
        of(1, vk::Format::R32G32B32_SFLOAT, offset_of!(Vertex, normal)),
        of(2, vk::Format::R32G32B32A32_SFLOAT, offset_of!(Vertex, tangent)),
        of(3, vk::Format::R32G32_SFLOAT, offset_of!(Vertex, uv)),
    ]
}

/// The passes that shade a mesh into radiance.
pub struct SurfacePass {
    depth: Pipeline,
    shade: Pipeline,
}

impl SurfacePass {
    /// Pipelines over the layout of `descriptors`.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn new(device: &Arc<Device>, descriptors: &Descriptors) -> Result<Self> {
        let attributes = attributes();
        let first = Drawing {
            vertex_stride: size_of::<Vertex>() as u32,
            attributes: &attributes,
            colors: &[target::RADIANCE],
            write_colors: false,
            depth: Some((vk::CompareOp::LESS, true)),
        };
        // Only what the depth pass left in front is shaded: the fragment stage costs a thousand times a depth test.
        let second = Drawing { write_colors: true, depth: Some((vk::CompareOp::EQUAL, false)), ..first };
        let vertex = shader!("surface.vert");
        let shade = Some(shader!("diffraction.frag"));
        Ok(Self {
            depth: Pipeline::graphics(device, vertex, None, &first, descriptors, 0)?,
            shade: Pipeline::graphics(device, vertex, shade, &second, descriptors, 0)?,
        })
    }

    /// Records the drawing of `mesh` into `target.radiance`, which it leaves as a colour attachment.
    pub fn record(
        &self,
        record: &Recorder<'_>,
        target: &Target,
        descriptors: &Descriptors,
        mesh: &DeviceMesh,
    ) {
        record.images(&[
            (&target.radiance, Access::Nothing, Access::ColorAttachment),
            (&target.depth, Access::Nothing, Access::DepthAttachment),
        ]);
        record.render(&[(&target.radiance, [0.0; 4])], Some(&target.depth), |draw| {
            for pipeline in [&self.depth, &self.shade] {
                draw.bind(pipeline, descriptors);
                draw.draw_indexed(&mesh.vertices, &mesh.indices, mesh.count);
            }
        });
    }
}

/// The pass that turns radiance into a displayed picture.
pub struct DisplayPass {
    pipeline: Pipeline,
    descriptors: Descriptors,
    _sampler: Sampler,
}

impl DisplayPass {
    /// A pass that draws into images of `format`.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn new(device: &Arc<Device>, format: vk::Format) -> Result<Self> {
        let binding = Binding {
            number: 0,
            kind: vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            stages: vk::ShaderStageFlags::FRAGMENT,
        };
        let descriptors = Descriptors::new(device, "display set", &[binding])?;
        let drawing =
            Drawing { vertex_stride: 0, attributes: &[], colors: &[format], write_colors: true, depth: None };
        let fragment = Some(shader!("display.frag"));
        let pipeline = Pipeline::graphics(
            device,
            shader!("display.vert"),
            fragment,
            &drawing,
            &descriptors,
            DISPLAY_BYTES,
        )?;
        let sampler = Sampler::linear(device, "display sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        Ok(Self { pipeline, descriptors, _sampler: sampler })
    }

    /// Points the pass at the radiance of `target`. The device must not be using the pass.
    pub fn read_from(&self, target: &Target) {
        self.descriptors.image(0, &target.radiance, &self._sampler);
    }

    /// Records the display of `target.radiance` (a colour attachment until now) into `into`, at `exposure` stops over
    /// `background`; leaves radiance readable by shaders and `into` a colour attachment.
    pub fn record(
        &self,
        record: &Recorder<'_>,
        target: &Target,
        into: &Image,
        exposure: f64,
        background: DVec3,
    ) {
        record.images(&[
            (&target.radiance, Access::ColorAttachment, Access::ShaderRead),
            (into, Access::Nothing, Access::ColorAttachment),
        ]);
        let push = background.as_vec3().extend(exposure as f32).to_array();
        record.render(&[(into, [0.0; 4])], None, |draw| {
            draw.bind(&self.pipeline, &self.descriptors);
            draw.push(&self.pipeline, bytemuck::bytes_of(&push));
            draw.draw(3);
        });
    }
}

/// Bytes of the display's push constants: background and exposure.
const DISPLAY_BYTES: u32 = 16;

/// The pass that writes the directions that a frame shades, for a reference to shade the very same ones.
pub struct DirectionsPass {
    pipeline: Pipeline,
    images: [Image; 2],
    depth: Image,
}

/// Format of a direction and its coverage.
const DIRECTION: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

impl DirectionsPass {
    /// A pass of `size` pixels over the layout of `descriptors`.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(device: &Arc<Device>, descriptors: &Descriptors, size: [u32; 2]) -> Result<Self> {
        let attributes = attributes();
        let drawing = Drawing {
            vertex_stride: size_of::<Vertex>() as u32,
            attributes: &attributes,
            colors: &[DIRECTION; 2],
            write_colors: true,
            depth: Some((vk::CompareOp::LESS, true)),
        };
        let fragment = Some(shader!("directions.frag"));
        let color = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let make = |name, format, usage| {
            Image::new(device, &Description { name, format, size, layers: 1, array: false, usage })
        };
        Ok(Self {
            pipeline: Pipeline::graphics(
                device,
                shader!("surface.vert"),
                fragment,
                &drawing,
                descriptors,
                4,
            )?,
            images: [make("light directions", DIRECTION, color)?, make("view directions", DIRECTION, color)?],
            depth: make("depth of directions", target::DEPTH, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT)?,
        })
    }

    /// ω_i of light `light`, and ω_r.
    pub fn images(&self) -> &[Image; 2] {
        &self.images
    }

    /// Records the directions of light number `light`.
    pub fn record(&self, record: &Recorder<'_>, descriptors: &Descriptors, mesh: &DeviceMesh, light: i32) {
        let [to_light, to_view] = &self.images;
        record.images(&[
            (to_light, Access::Nothing, Access::ColorAttachment),
            (to_view, Access::Nothing, Access::ColorAttachment),
            (&self.depth, Access::Nothing, Access::DepthAttachment),
        ]);
        record.render(&[(to_light, [0.0; 4]), (to_view, [0.0; 4])], Some(&self.depth), |draw| {
            draw.bind(&self.pipeline, descriptors);
            draw.push(&self.pipeline, &light.to_ne_bytes());
            draw.draw_indexed(&mesh.vertices, &mesh.indices, mesh.count);
        });
    }
}

/// The pass that finds out how fast the device reads the layers.
pub struct ProbePass {
    pipeline: Pipeline,
}

impl ProbePass {
    /// A pass over the layout of `descriptors`.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn new(device: &Arc<Device>, descriptors: &Descriptors) -> Result<Self> {
        let drawing = Drawing {
            vertex_stride: 0,
            attributes: &[],
            colors: &[target::RADIANCE],
            write_colors: true,
            depth: None,
        };
        let fragment = Some(shader!("probe.frag"));
        Ok(Self {
            pipeline: Pipeline::graphics(
                device,
                shader!("display.vert"),
                fragment,
                &drawing,
                descriptors,
                4,
            )?,
        })
    }

    /// Records `samples` reads per pixel of `target`.
    pub fn record(&self, record: &Recorder<'_>, target: &Target, descriptors: &Descriptors, samples: u32) {
        record.images(&[(&target.radiance, Access::Nothing, Access::ColorAttachment)]);
        record.render(&[(&target.radiance, [0.0; 4])], None, |draw| {
            draw.bind(&self.pipeline, descriptors);
            draw.push(&self.pipeline, &samples.to_ne_bytes());
            draw.draw(3);
        });
    }
}
