//! egui on this program's device: its memory, its textures, its drawing.

use super::atlas::{Atlas, Kept, misplaced};
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

/// What egui is to draw.
pub struct Painting {
    /// Triangles.
    pub primitives: Vec<ClippedPrimitive>,
    /// Changed textures.
    pub textures: TexturesDelta,
    /// Pixels of a point.
    pub scale: f32,
}

/// Draws egui into images of one format.
pub struct Gui {
    renderer: Renderer<Memory>,
    // By egui's names, each with the name that the renderer has for its descriptor set.
    atlases: HashMap<TextureId, (TextureId, Atlas)>,
    sampler: Sampler,
    device: Arc<Device>,
}

impl Gui {
    /// For images of `format` and `frames` frames in flight.
    ///
    /// # Errors
    /// Where the device refuses.
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

    /// Records, before rendering begins, what changes in textures. `kept` belongs to the frame.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn upload(
        &mut self,
        record: &Recorder<'_>,
        textures: &mut TexturesDelta,
        kept: &mut Kept,
    ) -> Result<()> {
        let device = self.device.clone();
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.atlas(id, &delta, kept)?.write(&device, record, &delta, kept)?;
            }
        }
        Ok(())
    }

    /// What `delta` goes into: a new atlas where it is a whole one of a size that is not there yet.
    fn atlas(&mut self, id: TextureId, delta: &ImageDelta, kept: &mut Kept) -> Result<&mut Atlas> {
        let size = delta.image.size().map(|n| n as u32);
        let there = self.atlases.get(&id).map(|(_, atlas)| atlas.size());
        if delta.pos.is_none() && there != Some(size) {
            let atlas = Atlas::new(&self.device, &self.sampler, size)?;
            self.give_up(id, kept);
            let name = self.renderer.add_user_texture(atlas.set());
            self.atlases.insert(id, (name, atlas));
        }
        self.atlases.get_mut(&id).map(|(_, atlas)| atlas).ok_or_else(misplaced)
    }

    /// Forgets a texture, which the device may still be reading.
    fn give_up(&mut self, id: TextureId, kept: &mut Kept) {
        if let Some((name, atlas)) = self.atlases.remove(&id) {
            self.renderer.remove_user_texture(name);
            kept.keep(atlas);
        }
    }

    /// Draws while rendering to a window of `size` is open, and gives up the textures that nothing later shows.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn draw(
        &mut self,
        draw: &Recorder<'_>,
        size: [u32; 2],
        painting: &mut Painting,
        kept: &mut Kept,
    ) -> Result<()> {
        for primitive in &mut painting.primitives {
            if let Primitive::Mesh(mesh) = &mut primitive.primitive
                && let Some((name, _)) = self.atlases.get(&mesh.texture_id)
            {
                mesh.texture_id = *name;
            }
        }
        let extent = vk::Extent2D { width: size[0], height: size[1] };
        let drawn = self.renderer.cmd_draw(draw.raw(), extent, painting.scale, &painting.primitives);
        drawn.map_err(failed)?;
        for id in painting.textures.free.drain() {
            self.give_up(id, kept);
        }
        Ok(())
    }
}

fn failed(e: RendererError) -> Error {
    match e {
        RendererError::Vulkan(code) => crate::vk::failure("draw the panel", code),
        other => {
            Error::failed(format!("the panel cannot be drawn ({other})"), "report this as a bug of diffract")
        }
    }
}

/// Memory for egui from the program's own allocator.
struct Memory(Arc<Device>);

fn no_room(e: Error) -> RendererError {
    RendererError::Allocator(e.to_string())
}

impl Allocator for Memory {
    // Frees itself.
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
