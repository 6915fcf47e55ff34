//! Command buffer with its fence, to record, submit and wait for.

use super::access::Access;
use super::buffer::Buffer;
use super::descriptors::Descriptors;
use super::device::Device;
use super::event_log::{EventLog, RecordedEvent, Resource, TexelArea};
use super::failure;
use super::image::Image;
use super::pipeline::Pipeline;
use super::queries::Timestamps;
use super::semaphore::Semaphore;
use crate::error::{Error, Remedy, Result};
use ash::vk;
use std::ops::Range;
use std::sync::Arc;

/// Timeout of a submission, after which the device counts as lost \[ns\]. A software device may take minutes for a
/// large picture.
const PATIENCE: u64 = 600 * 1_000_000_000;

/// Clear value of depth: the far plane.
pub const FAR: f32 = 1.0;

/// Command buffer, its pool and its fence.
pub struct Commands {
    raw: vk::CommandBuffer,
    pool: vk::CommandPool,
    fence: vk::Fence,
    // True while a submission has not been waited for.
    pending: bool,
    device: Arc<Device>,
}

impl Commands {
    /// Makes a command buffer with the debug name `name`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, name: &str) -> Result<Self> {
        let mut made = Self {
            raw: vk::CommandBuffer::null(),
            pool: vk::CommandPool::null(),
            fence: vk::Fence::null(),
            pending: false,
            device: device.clone(),
        };
        let failed = |c| failure("make a command buffer", c);
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(device.queue_family());
        // SAFETY: the device is live; if a later call fails, the drop of `made` frees the handles.
        unsafe {
            made.pool = device.raw().create_command_pool(&pool, None).map_err(failed)?;
            let request = vk::CommandBufferAllocateInfo::default()
                .command_pool(made.pool)
                .level(vk::CommandBufferLevel::PRIMARY)
                .command_buffer_count(1);
            made.raw = device.raw().allocate_command_buffers(&request).map_err(failed)?[0];
            made.fence = device.raw().create_fence(&vk::FenceCreateInfo::default(), None).map_err(failed)?;
        }
        device.name(made.raw, name);
        device.name(made.pool, &format!("{name} pool"));
        device.name(made.fence, &format!("{name} fence"));
        Ok(made)
    }

    /// Records with `record`, submits, and waits until the device has finished.
    ///
    /// # Errors
    /// Fails with the error of `record`, or if the device is lost.
    pub fn run(&mut self, record: impl FnOnce(&Recorder<'_>) -> Result<()>) -> Result<()> {
        self.start(record, None, None)?;
        self.wait()
    }

    /// Waits for the last submission, records with `record` and submits. Drawing into attachments waits for `after`,
    /// and `done` is signalled at the end. The resources used must live until [`Commands::wait`].
    ///
    /// # Errors
    /// Fails with the error of `record`, or if the device is lost.
    pub fn start(
        &mut self,
        record: impl FnOnce(&Recorder<'_>) -> Result<()>,
        after: Option<&Semaphore>,
        done: Option<&Semaphore>,
    ) -> Result<()> {
        self.wait()?;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let device = self.device.raw();
        // SAFETY: the last submission was waited for, so the pool's buffer is idle and may be reset and recorded anew.
        unsafe {
            device
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .and_then(|()| device.begin_command_buffer(self.raw, &begin))
                .map_err(|c| failure("record commands", c))?;
        }
        record(&Recorder { raw: self.raw, device, events: self.device.events(), part: None })?;
        // SAFETY: recording was begun above on this thread.
        unsafe { device.end_command_buffer(self.raw) }.map_err(|c| failure("record commands", c))?;
        let at = |semaphore: &Semaphore, stage| {
            vk::SemaphoreSubmitInfo::default().semaphore(semaphore.raw()).stage_mask(stage)
        };
        let attachments = vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT;
        let waits: Vec<_> = after.map(|s| at(s, attachments)).into_iter().collect();
        let signals: Vec<_> =
            done.map(|s| at(s, vk::PipelineStageFlags2::ALL_COMMANDS)).into_iter().collect();
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(self.raw)];
        let work = vk::SubmitInfo2::default()
            .command_buffer_infos(&buffers)
            .wait_semaphore_infos(&waits)
            .signal_semaphore_infos(&signals);
        self.device.submit(work, self.fence)?;
        self.device.events().note(|| RecordedEvent::Submitted(self.fence));
        self.pending = true;
        Ok(())
    }

    /// Waits until the last submission is done.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn wait(&mut self) -> Result<()> {
        if !self.pending {
            return Ok(());
        }
        let device = self.device.raw();
        // SAFETY: the fence was submitted; it is reset only after it was waited for.
        unsafe {
            match device.wait_for_fences(&[self.fence], true, PATIENCE) {
                Ok(()) => {
                    self.pending = false;
                    self.device.events().note(|| RecordedEvent::Waited(self.fence));
                    device.reset_fences(&[self.fence]).map_err(|c| failure("reset a fence", c))
                }
                Err(vk::Result::TIMEOUT) => Err(Error::limit(
                    "the Vulkan device did not finish within ten minutes",
                    [Remedy::SmallerPicture, Remedy::LargerTolerance],
                )),
                Err(c) => Err(failure("finish the work", c)),
            }
        }
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        // A lost device never finishes.
        let _ = self.wait();
        // SAFETY: the last submission is done. Null handles are allowed, and the pool frees its buffer.
        unsafe {
            self.device.raw().destroy_fence(self.fence, None);
            self.device.raw().destroy_command_pool(self.pool, None);
        }
    }
}

/// Recorder of commands into an open command buffer. The resources used must live until the device has finished.
pub struct Recorder<'a> {
    raw: vk::CommandBuffer,
    device: &'a ash::Device,
    events: &'a EventLog,
    part: Option<([u32; 2], [Range<u32>; 2])>,
}

impl Recorder<'_> {
    /// Returns the same recorder with rendering limited to a picture of `size` in the corner of its attachments, and
    /// within it to `rows`; nothing else is cleared.
    pub fn within(&self, size: [u32; 2], rows: Range<u32>) -> Self {
        self.tile(size, [0..size[0], rows])
    }

    /// Returns the same recorder limited to a rectangle, as [`Recorder::within`].
    pub fn tile(&self, size: [u32; 2], tile: [Range<u32>; 2]) -> Self {
        Self { part: Some((size, tile)), ..*self }
    }

    /// Returns the command buffer.
    pub fn raw(&self) -> vk::CommandBuffer {
        self.raw
    }

    /// Records barriers that prepare `images` for their next use.
    pub fn images(&self, changes: &[(&Image, Access, Access)]) {
        let barriers: Vec<_> = changes
            .iter()
            .map(|(image, from, to)| from.image_barrier(*to, image.raw(), image.range()))
            .collect();
        for ((image, ..), barrier) in changes.iter().zip(&barriers) {
            self.events.note(|| RecordedEvent::image_barrier(image.resource(), barrier));
        }
        let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: recording is open; the images are live and in the layouts of `from`.
        unsafe { self.device.cmd_pipeline_barrier2(self.raw, &info) };
    }

    /// Records a barrier that makes the writes of `from` to buffers visible to `to`.
    pub fn memory(&self, from: Access, to: Access) {
        let barriers = [from.memory_barrier(to)];
        self.events.note(|| RecordedEvent::barrier(&barriers[0]));
        let info = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: recording is open.
        unsafe { self.device.cmd_pipeline_barrier2(self.raw, &info) };
    }

    /// Resets `timestamps`, which is required before they are written.
    pub fn reset(&self, timestamps: &Timestamps) {
        // SAFETY: recording is open outside of rendering; the last work that wrote the pool was waited for.
        unsafe { self.device.cmd_reset_query_pool(self.raw, timestamps.pool(), 0, timestamps.count()) };
    }

    /// Writes timestamp `index` when all work recorded so far is done.
    pub fn timestamp(&self, timestamps: &Timestamps, index: u32) {
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        // SAFETY: recording is open and the query was reset.
        unsafe { self.device.cmd_write_timestamp2(self.raw, all, timestamps.pool(), index) };
    }

    fn note_use(&self, resource: Resource, access: Access, part: Option<TexelArea>) {
        self.events.note(|| RecordedEvent::Used(resource, access, part));
    }

    /// Copies `bytes` from the start of one buffer into another.
    pub fn copy_buffer(&self, from: &Buffer, to: &Buffer, bytes: u64) {
        self.note_use(from.resource(), Access::TransferRead, None);
        self.note_use(to.resource(), Access::TransferWrite, None);
        let regions = [vk::BufferCopy::default().size(bytes)];
        // SAFETY: recording is open, both buffers are live and hold `bytes`.
        unsafe { self.device.cmd_copy_buffer(self.raw, from.raw(), to.raw(), &regions) };
    }

    /// Copies tightly packed texels from the start of `from` into rows `first_row` … of mip level `level` of a layer of
    /// `to`.
    pub fn copy_to_level(
        &self,
        from: &Buffer,
        to: &Image,
        [layer, level]: [u32; 2],
        first_row: u32,
        rows: u32,
    ) {
        let mut region = region(to, layer, first_row, rows);
        region.image_subresource.mip_level = level;
        region.image_extent.width = (to.size()[0] >> level).max(1);
        self.copy_to(from, to, region);
    }

    /// Copies tightly packed texels from the start of `from` into the rectangle of `size` texels at `corner` of layer 0 of
    /// `to`.
    pub fn copy_to_part(&self, from: &Buffer, to: &Image, corner: [u32; 2], size: [u32; 2]) {
        let mut region = region(to, 0, corner[1], size[1]);
        region.image_offset.x = corner[0] as i32;
        region.image_extent.width = size[0];
        self.copy_to(from, to, region);
    }

    fn copy_to(&self, from: &Buffer, to: &Image, region: vk::BufferImageCopy) {
        self.note_use(from.resource(), Access::TransferRead, None);
        self.note_use(to.resource(), Access::TransferWrite, Some(part(&region)));
        let layout = Access::TransferWrite.row().2;
        // SAFETY: recording is open, the image is in the transfer layout, the buffer holds the texels.
        unsafe { self.device.cmd_copy_buffer_to_image(self.raw, from.raw(), to.raw(), layout, &[region]) };
    }

    /// Copies the `aspect` of the rectangle of `size` texels at `corner` of layer 0 of `from`, tightly packed, to the
    /// start of `to`.
    pub fn copy_from_image(
        &self,
        (from, aspect): (&Image, vk::ImageAspectFlags),
        corner: [u32; 2],
        size: [u32; 2],
        to: &Buffer,
    ) {
        self.note_use(from.resource(), Access::TransferRead, None);
        self.note_use(to.resource(), Access::TransferWrite, None);
        let mut region = region(from, 0, corner[1], size[1]);
        region.image_offset.x = corner[0] as i32;
        region.image_extent.width = size[0];
        region.image_subresource.aspect_mask = aspect;
        let (layout, regions) = (Access::TransferRead.row().2, [region]);
        // SAFETY: recording is open, the image is in the transfer layout, the buffer is large enough.
        unsafe { self.device.cmd_copy_image_to_buffer(self.raw, from.raw(), layout, to.raw(), &regions) };
    }

    /// Binds a pipeline and its descriptor sets, set 0 first, or a pipeline without sets.
    pub fn bind(&self, pipeline: &Pipeline, sets: &[&Descriptors]) {
        self.events.note(|| RecordedEvent::Bound(sets.iter().flat_map(|set| set.accesses()).collect()));
        let sets: Vec<_> = sets.iter().map(|set| set.set()).collect();
        // SAFETY: recording is open.
        unsafe { self.device.cmd_bind_pipeline(self.raw, pipeline.bind_point(), pipeline.raw()) };
        if sets.is_empty() {
            return;
        }
        // SAFETY: recording is open; the sets were made for this pipeline's layout and all they point to is live.
        unsafe {
            self.device.cmd_bind_descriptor_sets(
                self.raw,
                pipeline.bind_point(),
                pipeline.layout(),
                0,
                &sets,
                &[],
            );
        }
    }

    /// Sets push constants of the bound pipeline.
    pub fn push(&self, pipeline: &Pipeline, data: &[u8]) {
        // SAFETY: the pipeline's layout declares a range of this size for this stage.
        unsafe {
            self.device.cmd_push_constants(self.raw, pipeline.layout(), pipeline.push_stages(), 0, data)
        };
    }

    /// Dispatches `groups` work groups of the bound compute pipeline.
    pub fn dispatch(&self, groups: u32) {
        self.events.note(|| RecordedEvent::Work);
        // SAFETY: recording is open and a compute pipeline with its set is bound.
        unsafe { self.device.cmd_dispatch(self.raw, groups, 1, 1) };
    }

    /// Sets the number that the pipelines bound from now on write to the stencil or compare with it.
    pub fn stencil(&self, number: u8) {
        let faces = vk::StencilFaceFlags::FRONT_AND_BACK;
        // SAFETY: recording is open.
        unsafe { self.device.cmd_set_stencil_reference(self.raw, faces, number.into()) };
    }

    /// Draws into `colors` and a `depth` that is cleared to [`FAR`], with the stencil cleared to 0, all of one size. A
    /// colour with a value is cleared to it; without a value, which is much faster on software devices, undrawn pixels
    /// are undefined.
    pub fn render(
        &self,
        colors: &[(&Image, Option<[f32; 4]>)],
        depth: Option<&Image>,
        draw: impl FnOnce(&Self),
    ) {
        self.rendering(&cleared(colors), depth.map(|image| (image, 0, vk::AttachmentLoadOp::CLEAR)), draw);
    }

    /// Draws into layer number `layer` of the array `depth`, which is cleared first.
    pub fn render_layer(&self, depth: &Image, layer: u32, draw: impl FnOnce(&Self)) {
        self.rendering(&[], Some((depth, layer, vk::AttachmentLoadOp::CLEAR)), draw);
    }

    /// Draws as [`Recorder::render`], with a `depth` that was drawn before.
    pub fn render_over(
        &self,
        colors: &[(&Image, Option<[f32; 4]>)],
        depth: &Image,
        draw: impl FnOnce(&Self),
    ) {
        self.rendering(&cleared(colors), Some((depth, 0, vk::AttachmentLoadOp::LOAD)), draw);
    }

    /// Draws into `color`, whose other pixels keep their contents, with a `depth` that was drawn before, or without
    /// depth.
    pub fn render_onto(&self, color: &Image, depth: Option<&Image>, draw: impl FnOnce(&Self)) {
        let load = vk::AttachmentLoadOp::LOAD;
        self.rendering(&[(color, load, [0.0; 4])], depth.map(|image| (image, 0, load)), draw);
    }

    fn rendering(
        &self,
        colors: &[(&Image, vk::AttachmentLoadOp, [f32; 4])],
        depth: Option<(&Image, u32, vk::AttachmentLoadOp)>,
        draw: impl FnOnce(&Self),
    ) {
        let Some(size) = colors.first().map(|c| c.0).or(depth.map(|d| d.0)).map(Image::size) else { return };
        let (size, [columns, rows]) = self.part.clone().unwrap_or((size, size.map(|n| 0..n)));
        let (from, to) = ([columns.start, rows.start], [columns.end, rows.end]);
        let drawn = TexelArea { layer: [0; 2], from, to };
        for (image, ..) in colors {
            self.note_use(image.resource(), Access::ColorAttachment, Some(drawn));
        }
        if let Some((image, layer, _)) = depth {
            let drawn = TexelArea { layer: [layer, 0], from, to };
            self.note_use(image.resource(), Access::DepthAttachment, Some(drawn));
        }
        let attachment = |view: vk::ImageView, access: Access, load, clear: vk::ClearValue| {
            vk::RenderingAttachmentInfo::default()
                .image_view(view)
                .image_layout(access.row().2)
                .load_op(load)
                .store_op(vk::AttachmentStoreOp::STORE)
                .clear_value(clear)
        };
        let attachments: Vec<_> = colors
            .iter()
            .map(|&(image, load, float32)| {
                let clear = vk::ClearValue { color: vk::ClearColorValue { float32 } };
                attachment(image.view(), Access::ColorAttachment, load, clear)
            })
            .collect();
        let far = vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: FAR, stencil: 0 } };
        let with_stencil = depth.is_some_and(|(image, ..)| image.has_stencil());
        let depth = depth.map(|(image, layer, load)| {
            attachment(image.layer_view(layer), Access::DepthAttachment, load, far)
        });
        let area = vk::Rect2D {
            offset: vk::Offset2D { x: columns.start as i32, y: rows.start as i32 },
            extent: vk::Extent2D { width: columns.end - columns.start, height: rows.end - rows.start },
        };
        let mut info =
            vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&attachments);
        if let Some(depth) = &depth {
            info = info.depth_attachment(depth);
            if with_stencil {
                info = info.stencil_attachment(depth);
            }
        }
        let viewport = vk::Viewport {
            width: size[0] as f32,
            height: size[1] as f32,
            max_depth: 1.0,
            ..vk::Viewport::default()
        };
        // SAFETY: recording is open outside of rendering; the attachments are live and in attachment layouts.
        unsafe {
            self.device.cmd_begin_rendering(self.raw, &info);
            self.device.cmd_set_viewport(self.raw, 0, &[viewport]);
            self.device.cmd_set_scissor(self.raw, 0, &[area]);
        }
        draw(self);
        // SAFETY: rendering was begun above.
        unsafe { self.device.cmd_end_rendering(self.raw) };
        self.events.note(|| RecordedEvent::Ended);
    }

    /// Draws indexed triangles as instance number `instance`.
    pub fn draw_indexed(&self, vertices: &Buffer, indices: &Buffer, count: u32, instance: u32) {
        self.events.note(|| RecordedEvent::Work);
        self.note_use(vertices.resource(), Access::VertexRead, None);
        self.note_use(indices.resource(), Access::VertexRead, None);
        // SAFETY: rendering is open with a bound pipeline; every index is below the number of vertices.
        unsafe {
            self.device.cmd_bind_vertex_buffers(self.raw, 0, &[vertices.raw()], &[0]);
            self.device.cmd_bind_index_buffer(self.raw, indices.raw(), 0, vk::IndexType::UINT32);
            self.device.cmd_draw_indexed(self.raw, count, 1, 0, 0, instance);
        }
    }

    /// Draws `count` vertices without a vertex buffer.
    pub fn draw(&self, count: u32) {
        self.events.note(|| RecordedEvent::Work);
        // SAFETY: rendering is open with a bound pipeline that takes no vertex buffer.
        unsafe { self.device.cmd_draw(self.raw, count, 1, 0, 0) };
    }
}

/// Returns colour attachments with their load operation: cleared if they have a value, otherwise undefined.
fn cleared<'a>(colors: &[(&'a Image, Option<[f32; 4]>)]) -> Vec<(&'a Image, vk::AttachmentLoadOp, [f32; 4])> {
    let load = |clear: &Option<[f32; 4]>| match clear {
        Some(_) => vk::AttachmentLoadOp::CLEAR,
        None => vk::AttachmentLoadOp::DONT_CARE,
    };
    colors.iter().map(|(image, clear)| (*image, load(clear), clear.unwrap_or_default())).collect()
}

/// Returns the texels of a copy.
fn part(region: &vk::BufferImageCopy) -> TexelArea {
    let (of, at, size) = (region.image_subresource, region.image_offset, region.image_extent);
    let from = [at.x as u32, at.y as u32];
    let to = [from[0] + size.width, from[1] + size.height];
    TexelArea { layer: [of.base_array_layer, of.mip_level], from, to }
}

/// Returns the copy region of rows of one layer of an image and tightly packed texels in a buffer.
fn region(image: &Image, layer: u32, first_row: u32, rows: u32) -> vk::BufferImageCopy {
    let subresource = vk::ImageSubresourceLayers::default()
        .aspect_mask(image.aspect())
        .base_array_layer(layer)
        .layer_count(1);
    vk::BufferImageCopy::default()
        .image_subresource(subresource)
        .image_offset(vk::Offset3D { x: 0, y: first_row as i32, z: 0 })
        .image_extent(vk::Extent3D { width: image.size()[0], height: rows, depth: 1 })
}
