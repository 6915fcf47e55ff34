//! Thread that draws the scene, with the same renderers as `diffract render`.

use super::frame::FrameRequest;
use super::frame_renderer::{FrameRenderer, Receiver};
use super::job_queue::{Job, JobQueue, PixelRequest, RenderReply};
use super::threads;
use crate::error::Result;
use crate::vk::device::Device;
use std::sync::Arc;
use std::thread::JoinHandle;

/// Handle of the render thread. Dropping it ends the thread and waits for it.
pub struct RenderThread {
    queue: Arc<JobQueue>,
    thread: Option<JoinHandle<()>>,
}

impl RenderThread {
    /// Starts a thread that draws on `device` and sends its replies to `reply`.
    ///
    /// # Errors
    /// Fails if the system refuses a thread.
    pub fn new(device: &Arc<Device>, reply: impl Fn(RenderReply) + Send + Sync + 'static) -> Result<Self> {
        let queue = Arc::<JobQueue>::default();
        let (tasks, device) = (queue.clone(), device.clone());
        let reply: Arc<Receiver> = Arc::new(reply);
        let work = move || FrameRenderer::new(device).run(&tasks, &reply);
        let thread = threads::spawn("pictures", work)?;
        Ok(Self { queue, thread: Some(thread) })
    }

    /// Requests a frame; it replaces the previous request.
    pub fn request(&self, request: FrameRequest) {
        self.queue.update(|pending| pending.frame = Some(request));
    }

    /// Gives the window priority over the next tile, or takes it back.
    pub fn give_way(&self, window_first: bool) {
        self.queue.update(|pending| pending.window_first = window_first);
    }

    /// Requests a pixel of the last frame drawn; it replaces the previous request.
    pub fn read_pixel(&self, request: PixelRequest) {
        self.queue.update(|pending| pending.pixel = Some(request));
    }

    /// Adds a job.
    pub fn submit(&self, job: Job) {
        self.queue.update(|pending| pending.jobs.push(job));
    }
}

impl Drop for RenderThread {
    fn drop(&mut self) {
        self.queue.update(|pending| pending.stop = true);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // the thread reports its errors itself
        }
    }
}
