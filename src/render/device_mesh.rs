//! Mesh on the device, and the vertex layout for shaders.

use super::upload;
use crate::error::{Error, Result};
use crate::scene::{Mesh, Vertex};
use crate::vk::buffer::Buffer;
use crate::vk::commands::Recorder;
use crate::vk::device::Device;
use ash::vk;
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
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, mesh: &Mesh) -> Result<Self> {
        let count = u32::try_from(mesh.indices().len())
            .map_err(|e| Error::limit("the mesh has too many triangles", "simplify it first").caused_by(e))?;
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

impl DeviceMesh {
    /// Draws all triangles with the bound pipeline, whose vertex input is [`attributes`], as instance number `instance`.
    pub(super) fn draw(&self, draw: &Recorder<'_>, instance: u32) {
        draw.draw_indexed(&self.vertices, &self.indices, self.count, instance);
    }
}

/// Attributes of [`Vertex`], in the order of `surface.vert`.
pub(super) fn attributes() -> [vk::VertexInputAttributeDescription; 4] {
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
