//! Events that the background threads send to the window.

use super::error_probe::ProbeStatus;
use super::folder::Neighbour;
use super::frame::LoadedScene;
use super::inspector::reference::Answer;
use super::job_queue::RenderReply;
use super::settings::ViewSettings;
use super::surface_pane::analysis::Analysis;
use super::worker::WorkerReply;
use crate::error::Result;
use std::sync::Arc;

/// What came of opening a scene.
pub struct OpenedScene {
    /// Its name.
    pub name: String,
    /// Whether it is opened to return to the settings at the start.
    pub resets: bool,
    /// The scene.
    pub loaded: Result<LoadedScene>,
    /// The settings of a window to go on with.
    pub settings: Option<ViewSettings>,
}

/// A message from a background thread.
pub enum Event {
    /// From the worker that prepares layers and colour tables.
    Worker(WorkerReply),
    /// From the render thread.
    Render(RenderReply),
    /// From the error probe.
    Probe(Result<ProbeStatus>),
    /// What the reference says of the reading of this number.
    Inspector(u64, Result<Answer>),
    /// A scene was read.
    Scene(Box<OpenedScene>),
    /// What the surface pane shows of a height field.
    Analysis(Result<Arc<Analysis>>),
    /// Another height file of the folder.
    Neighbour(Result<Neighbour>),
}
