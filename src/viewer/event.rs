//! Events that the background threads send to the window.

use super::error_probe::ProbeStatus;
use super::folder::Neighbour;
use super::frame::LoadedScene;
use super::inspector::reference::Answer;
use super::job_queue::RenderReply;
use super::surface_pane::analysis::Analysis;
use super::view_settings::ViewSettings;
use super::worker::WorkerReply;
use crate::error::Result;
use std::sync::Arc;

/// Result of opening a scene.
pub struct OpenedScene {
    /// Name of the scene.
    pub name: String,
    /// True if it is opened to return to the settings at the start.
    pub resets: bool,
    /// Scene, or the error of reading it.
    pub loaded: Result<LoadedScene>,
    /// Settings to restore with it, if any.
    pub settings: Option<ViewSettings>,
}

/// Message from a background thread.
pub enum Event {
    /// Reply of the worker that prepares layers and colour tables.
    Worker(WorkerReply),
    /// Reply of the render thread.
    Render(RenderReply),
    /// Status of the error probe.
    Probe(Result<ProbeStatus>),
    /// Answer of the reference to the reading of this number.
    Inspector(u64, Result<Answer>),
    /// Scene that was read.
    Scene(Box<OpenedScene>),
    /// Analysis of a height field for the surface pane.
    Analysis(Result<Arc<Analysis>>),
    /// Next height file of the folder.
    Neighbour(Result<Neighbour>),
}
