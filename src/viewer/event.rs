//! Events that the background threads send to the window.

use super::error_probe::ProbeStatus;
use super::frame::LoadedScene;
use super::job_queue::RenderReply;
use super::worker::WorkerReply;
use crate::error::Result;

/// A message from a background thread.
pub enum Event {
    /// From the worker that prepares layers and colour tables.
    Worker(WorkerReply),
    /// From the render thread.
    Render(RenderReply),
    /// From the error probe.
    Probe(Result<ProbeStatus>),
    /// The scene of this name was read.
    Scene(String, Box<Result<LoadedScene>>),
}
