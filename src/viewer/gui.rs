//! Draws egui on this program's device, with this program's allocator and textures.

use super::atlas::{Atlas, FrameResources, misplaced};
use crate::error::{Error, Result};
use crate::vk::buffer::Buffer;
use crate::vk::commands::Recorder;
use crate::vk::device::Device;
use crate::vk::sampler::Sampler;
use ash::vk;
use egui::epaint::{ImageDelta, Primitive};
use egui::{ClippedPrimitive, TextureId, TexturesDelta};
use egui_ash_renderer::allocator::Allocator;
use egui_ash_renderer::{DynamicRendering, Options, RenderMode, Renderer, RendererError};
use gpu_allocator::MemoryLocation;
use std::collections::HashMap;
use std::sync::Arc;

/// Output of egui for one frame.
pub struct PaintJobs {
    /// Triangles.
    pub primitives: Vec<ClippedPrimitive>,
    /// Textures to change or free.
    pub textures: TexturesDelta,
    /// Pixels per point.
    pub scale: f32,
}

/// Draws egui to images of one format.
pub struct Gui {
    renderer: Renderer<Memory>,
    // By egui's id: the renderer's id of the descriptor set, and the atlas.
    atlases: HashMap<TextureId, (TextureId, Atlas)>,
    sampler: Sampler,
    device: Arc<Device>,
}

impl Gui {
    /// Makes a renderer for images of `format` and `frames` frames in flight.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, format: vk::Format, frames: usize) -> Result<Self> {
        let mode = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: format,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        let options = Options { in_flight_frames: frames, ..Options::default() };
        let memory = Memory(device.clone());
        let renderer =
            Renderer::with_allocator(memory, device.raw().clone(), mode, options).map_err(failed)?;
        let sampler = Sampler::linear(device, "panel sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        Ok(Self { renderer, atlases: HashMap::new(), sampler, device: device.clone() })
    }

    /// Records the texture changes; must come before rendering begins. `resources` belongs to the frame.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn upload(
        &mut self,
        record: &Recorder<'_>,
        textures: &mut TexturesDelta,
        resources: &mut FrameResources,
    ) -> Result<()> {
        let device = self.device.clone();
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.atlas(id, &delta, resources)?.write(&device, record, &delta, resources)?;
            }
        }
        Ok(())
    }

    /// Returns the atlas that `delta` changes, or a new one if `delta` is a whole texture of another size.
    fn atlas(
        &mut self,
        id: TextureId,
        delta: &ImageDelta,
        resources: &mut FrameResources,
    ) -> Result<&mut Atlas> {
        let size = delta.image.size().map(|n| n as u32);
        let there = self.atlases.get(&id).map(|(_, atlas)| atlas.size());
        if delta.pos.is_none() && there != Some(size) {
            let atlas = Atlas::new(&self.device, &self.sampler, size)?;
            self.remove(id, resources);
            let name = self.renderer.add_user_texture(atlas.set());
            self.atlases.insert(id, (name, atlas));
        }
        self.atlases.get_mut(&id).map(|(_, atlas)| atlas).ok_or_else(misplaced)
    }

    /// Removes a texture that the device may still read.
    fn remove(&mut self, id: TextureId, resources: &mut FrameResources) {
        if let Some((name, atlas)) = self.atlases.remove(&id) {
            self.renderer.remove_user_texture(name);
            resources.keep(atlas);
        }
    }

    /// Records the drawing within rendering to an image of `size`, and frees the textures that are no longer needed.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn draw(
        &mut self,
        draw: &Recorder<'_>,
        size: [u32; 2],
        jobs: &mut PaintJobs,
        resources: &mut FrameResources,
    ) -> Result<()> {
        for primitive in &mut jobs.primitives {
            if let Primitive::Mesh(mesh) = &mut primitive.primitive
                && let Some((name, _)) = self.atlases.get(&mesh.texture_id)
            {
                mesh.texture_id = *name;
            }
        }
        let extent = vk::Extent2D { width: size[0], height: size[1] };
        let drawn = self.renderer.cmd_draw(draw.raw(), extent, jobs.scale, &jobs.primitives);
        drawn.map_err(failed)?;
        for id in jobs.textures.free.drain() {
            self.remove(id, resources);
        }
        Ok(())
    }
}

fn failed(e: RendererError) -> Error {
    match e {
        RendererError::Vulkan(code) => crate::vk::failure("draw the panel", code),
        other => Error::bug(format!("the panel cannot be drawn ({other})")),
    }
}

/// Gives egui's renderer memory from this program's allocator.
struct Memory(Arc<Device>);

fn no_room(e: Error) -> RendererError {
    RendererError::Allocator(e.to_string())
}

impl Allocator for Memory {
    // Freed on drop.
    type Allocation = Buffer;

    fn create_buffer(
        &mut self,
        _: &ash::Device,
        size: usize,
        usage: vk::BufferUsageFlags,
    ) -> std::result::Result<(vk::Buffer, Buffer), RendererError> {
        let buffer = Buffer::new(&self.0, "panel", size as u64, usage, MemoryLocation::CpuToGpu);
        let buffer = buffer.map_err(no_room)?;
        Ok((buffer.raw(), buffer))
    }

    fn create_image(
        &mut self,
        _: &ash::Device,
        _: u32,
        _: u32,
    ) -> std::result::Result<(vk::Image, Buffer), RendererError> {
        Err(RendererError::Allocator("every texture is an `Atlas`".to_owned()))
    }

    fn destroy_buffer(
        &mut self,
        _: &ash::Device,
        _: vk::Buffer,
        buffer: Buffer,
    ) -> std::result::Result<(), RendererError> {
        drop(buffer);
        Ok(())
    }

    fn destroy_image(
        &mut self,
        _: &ash::Device,
        _: vk::Image,
        _: Buffer,
    ) -> std::result::Result<(), RendererError> {
        Ok(())
    }

    fn update_buffer<T: Copy>(
        &mut self,
        _: &ash::Device,
        buffer: &mut Buffer,
        data: &[T],
    ) -> std::result::Result<(), RendererError> {
        // SAFETY: vertices and indices are plain numbers without padding; the slice is read for this call only.
        let bytes = unsafe { std::slice::from_raw_parts(data.as_ptr().cast(), size_of_val(data)) };
        buffer.write(bytes).map_err(no_room)
    }
}
