//! Log of recorded events as plain data, for tests that replay it without a device.
//!
//! Commands recorded by raw handles (the panel of the window) are not logged.

use super::access::Access;
use ash::vk::{self, AccessFlags2 as A, ImageLayout, PipelineStageFlags2 as S};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Resource, by its raw handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Resource {
    /// Handle of a buffer.
    Buffer(u64),
    /// Handle of an image.
    Image(u64),
}

/// Range of texels: array layer, mip level, and the first and the end of columns and rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexelArea {
    /// Array layer and mip level.
    pub layer: [u32; 2],
    /// First column and row.
    pub from: [u32; 2],
    /// Column and row after the last.
    pub to: [u32; 2],
}

/// Scopes of a barrier.
#[derive(Clone, Copy, Debug)]
pub struct Scopes {
    /// First scope.
    pub source: (S, A),
    /// Second scope, which waits.
    pub destination: (S, A),
}

/// Event of a recording.
#[derive(Clone, Debug)]
pub enum RecordedEvent {
    /// Creation of a resource with this name; its handle may have belonged to another.
    Made(Resource, String),
    /// Binding of descriptor sets with these accesses.
    Bound(Vec<(Resource, Access)>),
    /// Draw or dispatch that uses the bound resources.
    Work,
    /// Use of a resource, as a whole or a part.
    Used(Resource, Access, Option<TexelArea>),
    /// End of the pass that drew into attachments.
    Ended,
    /// Barrier over all memory.
    Barrier(Scopes),
    /// Barrier on an image, between two layouts.
    ImageBarrier(Resource, Scopes, [ImageLayout; 2]),
    /// Submission of all work recorded so far, with this fence.
    Submitted(vk::Fence),
    /// Wait of the host for the last submission with this fence, and thus for all earlier ones.
    Waited(vk::Fence),
}

impl RecordedEvent {
    /// Returns the event of a barrier over all memory.
    pub fn barrier(barrier: &vk::MemoryBarrier2<'_>) -> Self {
        Self::Barrier(Scopes {
            source: (barrier.src_stage_mask, barrier.src_access_mask),
            destination: (barrier.dst_stage_mask, barrier.dst_access_mask),
        })
    }

    /// Returns the event of a barrier on `image`.
    pub fn image_barrier(image: Resource, barrier: &vk::ImageMemoryBarrier2<'_>) -> Self {
        let scopes = Scopes {
            source: (barrier.src_stage_mask, barrier.src_access_mask),
            destination: (barrier.dst_stage_mask, barrier.dst_access_mask),
        };
        Self::ImageBarrier(image, scopes, [barrier.old_layout, barrier.new_layout])
    }
}

/// Event log of a device, active after [`EventLog::start`]. Before that an event costs the test of a flag.
#[derive(Default)]
pub struct EventLog {
    on: AtomicBool,
    events: Mutex<Vec<RecordedEvent>>,
}

impl EventLog {
    /// Starts logging.
    pub fn start(&self) {
        self.on.store(true, Ordering::Relaxed);
    }

    /// Returns the logged events and continues with an empty log.
    pub fn take(&self) -> Vec<RecordedEvent> {
        std::mem::take(&mut *self.list())
    }

    /// Logs `event`.
    pub fn note(&self, event: impl FnOnce() -> RecordedEvent) {
        if self.on.load(Ordering::Relaxed) {
            let event = event();
            self.list().push(event);
        }
    }

    fn list(&self) -> MutexGuard<'_, Vec<RecordedEvent>> {
        self.events.lock().unwrap_or_else(PoisonError::into_inner) // a list that is only pushed to is always whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_keeps_nothing_before_it_is_started() {
        let log = EventLog::default();
        log.note(|| unreachable!("not even made"));
        log.start();
        log.note(|| RecordedEvent::Ended);
        assert_eq!(log.take().len(), 1);
        assert!(log.take().is_empty());
    }
}
