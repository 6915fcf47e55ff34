//! Messages to and from the render thread: the newest frame request, the jobs in order, and the replies.

use super::compare::Side;
use super::error_probe::ProbeTask;
use super::frame::{FrameRequest, RenderedFrame};
use super::inspector::reading::Reading;
use super::quality::Quality;
use crate::error::{Error, Result};
use crate::notes::Notes;
use crate::render::renderer::Picture;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Work that is done once and never replaced by a newer request. It gives way to frames, and goes on after them.
pub enum Job {
    /// Draw the whole frame and return it as a picture.
    Picture(FrameRequest),
    /// Draw the whole frame and return random pixels with their directions.
    Samples(FrameRequest),
}

/// Pixel to read back from a frame on the device.
pub struct PixelRequest {
    /// Number, larger than that of any earlier request.
    pub number: u64,
    /// Frame.
    pub frame: FrameRequest,
    /// Column and row from the upper left.
    pub at: [u32; 2],
}

/// Reply of the render thread.
pub enum RenderReply {
    /// A frame is on the device.
    Frame(Box<RenderedFrame>),
    /// Fraction of a picture that is drawn.
    Drawing(Side, f32),
    /// Fraction of the picture of a [`Job::Picture`] that is drawn.
    Saving(f32),
    /// A frame of a moving scene was abandoned after this time \[ms\].
    TooSlow(Quality, f64),
    /// Picture of [`Job::Picture`] with a description of the errors of scalar theory for its surface, or an error.
    Picture(Result<(Box<Picture>, Notes)>),
    /// Pixels of [`Job::Samples`].
    Samples(Box<ProbeTask>),
    /// Data of a pixel; `None` if no object covers it.
    Pixel(Option<Box<Reading>>),
    /// A request or a job failed.
    Failed(Error),
}

/// Pending work of the render thread.
#[derive(Default)]
pub struct Pending {
    /// Newest frame request.
    pub frame: Option<FrameRequest>,
    /// Newest request for a pixel, handled after the frame.
    pub pixel: Option<PixelRequest>,
    /// Displayed frame to which samples are added when there is no other work.
    pub refined: Option<FrameRequest>,
    /// Jobs, oldest first.
    pub jobs: Vec<Job>,
    /// True if the thread is to end.
    pub stop: bool,
    /// True if the window has something to show, which goes before the next tile.
    pub window_first: bool,
}

/// Longest wait for the window, which may be hidden.
const LONGEST_WAIT: Duration = Duration::from_millis(100);

/// Next work of the render thread.
pub enum RenderWork {
    /// Draw a frame.
    Frame(FrameRequest),
    /// Read a pixel.
    Pixel(PixelRequest),
    /// Add samples to a displayed frame.
    Refine(FrameRequest),
    /// Do a job.
    Job(Job),
}

/// Pending work, shared between the window's thread and the render thread.
#[derive(Default)]
pub struct JobQueue {
    pending: Mutex<Pending>,
    changed: Condvar,
}

impl JobQueue {
    /// Locks and returns the pending work.
    pub fn pending(&self) -> MutexGuard<'_, Pending> {
        self.pending.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the pending work and wakes the render thread.
    pub fn update(&self, change: impl FnOnce(&mut Pending)) {
        change(&mut self.pending());
        self.changed.notify_one();
    }

    /// Returns true if the drawn frame is replaced by a newer request, or no longer wanted at all.
    pub fn has_newer_frame(&self) -> bool {
        let pending = self.pending();
        pending.stop || pending.frame.is_some()
    }

    /// Returns true if a job is to be interrupted.
    pub fn interrupts_jobs(&self) -> bool {
        let pending = self.pending();
        pending.stop || pending.frame.as_ref().is_some_and(|frame| !frame.again)
    }

    /// Puts back an interrupted job, before the others.
    pub fn put_back(&self, job: Job) {
        self.pending().jobs.insert(0, job);
    }

    /// Puts back `request` if it was abandoned for a job rather than for a newer request.
    pub fn resume(&self, request: FrameRequest) {
        let mut pending = self.pending();
        if !pending.jobs.is_empty() {
            pending.frame.get_or_insert(request);
        }
    }

    /// Adds samples to the displayed `request` when there is no other work.
    pub fn refine(&self, request: FrameRequest) {
        let mut pending = self.pending();
        if pending.frame.is_none() {
            pending.refined = Some(request);
        }
    }

    /// Waits until the window has shown its changes.
    pub fn give_way(&self) {
        let waits = |pending: &mut Pending| pending.window_first && !pending.stop;
        let (mut pending, waited) = self
            .changed
            .wait_timeout_while(self.pending(), LONGEST_WAIT, waits)
            .unwrap_or_else(PoisonError::into_inner);
        if waited.timed_out() {
            pending.window_first = false;
        }
    }

    /// Waits for the next task; `None` if the thread is to end. Frames come first, so that the window follows the hand while
    /// a job waits; frames of continuous drawing come after jobs, which would never be done otherwise.
    pub fn next(&self) -> Option<RenderWork> {
        let mut pending = self.pending();
        loop {
            if pending.stop {
                return None;
            }
            let waits = !pending.jobs.is_empty();
            if waits && pending.frame.as_ref().is_none_or(|frame| frame.again) {
                return Some(RenderWork::Job(pending.jobs.remove(0)));
            }
            if let Some(request) = pending.frame.take() {
                pending.refined = None;
                return Some(RenderWork::Frame(request));
            }
            if let Some(request) = pending.pixel.take() {
                return Some(RenderWork::Pixel(request));
            }
            if let Some(request) = pending.refined.take() {
                return Some(RenderWork::Refine(request));
            }
            pending = self.changed.wait(pending).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn frames_go_before_jobs_continuous_ones_after_them_and_samples_are_added_last() {
        let name = |task: RenderWork| match task {
            RenderWork::Job(_) => "job",
            RenderWork::Frame(_) => "frame",
            RenderWork::Pixel(_) => "pixel",
            RenderWork::Refine(_) => "refine",
        };
        let queue = JobQueue::default();
        let frame = || crate::viewer::frame::tests::request();
        queue.refine(frame());
        queue.update(|pending| pending.pixel = Some(PixelRequest { number: 1, frame: frame(), at: [0; 2] }));
        queue.update(|pending| pending.jobs.push(Job::Picture(frame())));
        assert_eq!([(); 3].map(|()| name(queue.next().unwrap())), ["job", "pixel", "refine"]);
        // A frame abandoned for a job is drawn later, one abandoned for a newer frame is not.
        queue.resume(frame());
        assert!(queue.pending().frame.is_none());
        queue.update(|pending| pending.jobs.push(Job::Picture(frame())));
        queue.resume(FrameRequest { again: true, ..frame() });
        assert!(!queue.interrupts_jobs());
        assert_eq!([(); 2].map(|()| name(queue.next().unwrap())), ["job", "frame"]);
        // A job gives way to the hand.
        queue.update(|pending| pending.frame = Some(frame()));
        assert!(queue.interrupts_jobs());
        queue.put_back(Job::Picture(frame()));
        assert_eq!([(); 2].map(|()| name(queue.next().unwrap())), ["frame", "job"]);
        // Another frame ends the refinement of the last one.
        queue.refine(frame());
        queue.update(|pending| pending.frame = Some(frame()));
        queue.refine(frame());
        assert_eq!(name(queue.next().unwrap()), "frame");
        assert!(queue.pending().refined.is_none());
    }

    #[test]
    fn drawing_waits_for_the_window_and_not_for_one_that_is_hidden() {
        let queue = JobQueue::default();
        let start = Instant::now();
        queue.give_way();
        assert!(start.elapsed() < LONGEST_WAIT);
        queue.update(|pending| pending.window_first = true);
        queue.give_way();
        assert!(start.elapsed() >= LONGEST_WAIT && !queue.pending().window_first);
    }
}
