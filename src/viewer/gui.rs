//! egui on this program's device: its memory, its font atlas, its drawing.

use crate::error::{Error, Result};
use crate::vk::buffer::Buffer;
use crate::vk::commands::Recorder;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use ash::vk;
use egui::epaint::ImageDelta;
use egui::{ClippedPrimitive, ColorImage, ImageData, TextureId, TexturesDelta};
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
    // Textures are replaced whole: a part of one cannot be replaced without the layout that the rest needs.
    atlases: HashMap<TextureId, ColorImage>,
    unused: Vec<TextureId>,
    pool: vk::CommandPool,
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
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(device.queue_family());
        // SAFETY: the device is live.
        let pool = unsafe { device.raw().create_command_pool(&info, None) }
            .map_err(|c| crate::vk::failure("make a command pool", c))?;
        device.name(pool, "panel textures");
        Ok(Self { renderer, atlases: HashMap::new(), unused: Vec::new(), pool, device: device.clone() })
    }

    /// Whether [`Gui::upload`] has something to do; then the device must be done with all frames.
    pub fn has_textures(&self, textures: &TexturesDelta) -> bool {
        !textures.set.is_empty() || !self.unused.is_empty()
    }

    /// Takes over new textures and gives up old ones.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn upload(&mut self, textures: &mut TexturesDelta) -> Result<()> {
        for id in self.unused.drain(..) {
            self.atlases.remove(&id);
            self.renderer.free_texture(id).map_err(failed)?;
        }
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                merge(&mut self.atlases, id, &delta);
            }
            let Some(atlas) = self.atlases.get(&id) else { continue };
            let whole = ImageDelta::full(atlas.clone(), egui::TextureOptions::LINEAR);
            let (renderer, pool) = (&mut self.renderer, self.pool);
            self.device.with_queue(|queue| renderer.set_texture(queue, pool, id, &whole))?.map_err(failed)?;
        }
        self.unused.extend(textures.free.drain());
        Ok(())
    }

    /// Draws while rendering to a window of `size` is open.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn draw(&mut self, draw: &Recorder<'_>, size: [u32; 2], painting: &Painting) -> Result<()> {
        let extent = vk::Extent2D { width: size[0], height: size[1] };
        self.renderer.cmd_draw(draw.raw(), extent, painting.scale, &painting.primitives).map_err(failed)
    }
}

impl Drop for Gui {
    fn drop(&mut self) {
        // SAFETY: every upload was waited for.
        unsafe { self.device.raw().destroy_command_pool(self.pool, None) };
    }
}

/// Puts what `delta` changes into the copy of its texture.
fn merge(atlases: &mut HashMap<TextureId, ColorImage>, id: TextureId, delta: &ImageDelta) {
    let ImageData::Color(new) = &delta.image;
    match (delta.pos, atlases.get_mut(&id)) {
        (Some([left, top]), Some(atlas)) => {
            for (row, texels) in new.pixels.chunks(new.size[0].max(1)).enumerate() {
                let begin = (top + row) * atlas.size[0] + left;
                if let Some(slot) = atlas.pixels.get_mut(begin..begin + texels.len()) {
                    slot.copy_from_slice(texels);
                }
            }
        }
        _ => {
            atlases.insert(id, ColorImage::clone(new));
        }
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

/// A resource, which frees itself.
enum Piece {
    Buffer(Buffer),
    Image(#[allow(dead_code, reason = "held until it is dropped")] Image),
}

fn no_room(e: Error) -> RendererError {
    RendererError::Allocator(e.to_string())
}

impl Allocator for Memory {
    type Allocation = Piece;

    fn create_buffer(
        &mut self,
        _: &ash::Device,
        size: usize,
        usage: vk::BufferUsageFlags,
    ) -> std::result::Result<(vk::Buffer, Piece), RendererError> {
        let buffer = Buffer::new(&self.0, "panel", size as u64, usage, MemoryLocation::CpuToGpu);
        let buffer = buffer.map_err(no_room)?;
        Ok((buffer.raw(), Piece::Buffer(buffer)))
    }

    fn create_image(
        &mut self,
        _: &ash::Device,
        width: u32,
        height: u32,
    ) -> std::result::Result<(vk::Image, Piece), RendererError> {
        let description = Description {
            name: "panel texture",
            format: vk::Format::R8G8B8A8_SRGB,
            size: [width, height],
            layers: 1,
            array: false,
            usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
        };
        let image = Image::new(&self.0, &description).map_err(no_room)?;
        Ok((image.raw(), Piece::Image(image)))
    }

    fn destroy_buffer(
        &mut self,
        _: &ash::Device,
        _: vk::Buffer,
        piece: Piece,
    ) -> std::result::Result<(), RendererError> {
        drop(piece);
        Ok(())
    }

    fn destroy_image(
        &mut self,
        _: &ash::Device,
        _: vk::Image,
        piece: Piece,
    ) -> std::result::Result<(), RendererError> {
        drop(piece);
        Ok(())
    }

    fn update_buffer<T: Copy>(
        &mut self,
        _: &ash::Device,
        piece: &mut Piece,
        data: &[T],
    ) -> std::result::Result<(), RendererError> {
        let Piece::Buffer(buffer) = piece else { return Ok(()) };
        // SAFETY: vertices, indices and texels are plain numbers without padding; the slice is read for this call only.
        let bytes = unsafe { std::slice::from_raw_parts(data.as_ptr().cast(), size_of_val(data)) };
        buffer.write(bytes).map_err(no_room)
    }
}
