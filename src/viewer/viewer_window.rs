//! Open window: runs the panel, sends requests to the background threads, and presents their results.

mod actions;
mod recording;
mod replies;
mod requests;

use super::error_probe::ErrorProbe;
use super::event::Event;
use super::files::FileChoice;
use super::frame::{FrameRequest, LoadedScene};
use super::gui::PaintJobs;
use super::inspector::reference::DirectionReference;
use super::model::{Model, Stage};
use super::prepared::{Prepared, ROLES};
use super::presenter::{Presenter, ShownPictures};
use super::render_thread::RenderThread;
use super::start::{CommandLine, LastView, Output, SceneFiles, Start};
use super::text_dump::TextDump;
use super::view_settings::ViewSettings;
use super::worker::Worker;
use super::{layout, style};
use crate::context::Context;
use crate::error::{Error, Remedy, Result};
use crate::render::frame::View;
use crate::render::window_pass::PicturePlace;
use crate::setup::InUse;
use crate::surface::HeightField;
use crate::vk::device::Device;
use crate::vk::instance::Instance;
use crate::vk::window_surface::Surface;
use ash::vk;
use egui::{Pos2, RawInput, Rect, TexturesDelta, ViewportId, vec2};
use recording::Recording;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::event::WindowEvent;
use winit::event_loop::EventLoopProxy;
use winit::raw_window_handle::HasDisplayHandle;
use winit::window::Window;

/// Camera and lights count as moving until they have not changed for this long.
const MOTION_TIMEOUT: Duration = Duration::from_millis(160);

/// After a frame the driver's thread may read from the display's connection and swallow the wake-up of the event loop.
/// For [`POLL_PERIOD`] after each frame the loop therefore polls every [`POLL_INTERVAL`].
const POLL_PERIOD: Duration = Duration::from_millis(500);
const POLL_INTERVAL: Duration = Duration::from_millis(8);

/// Longest time for which a moving window waits for the next frame before it shows its panel without. Each presentation
/// holds the queue of the device, so that one for every step of the pointer would hold up the frames.
const LONGEST_WAIT: Duration = Duration::from_millis(100);

/// Picture that the render thread draws for a file.
struct PendingSave {
    // Path without its extension.
    stem: PathBuf,
    with_exr: bool,
    command: String,
    // True if it belongs to a turntable.
    is_recorded: bool,
}

/// Background threads. The order of the fields is the order in which they end.
struct Threads {
    probe: Option<ErrorProbe>,
    // Running while the inspector is open.
    inspector: Option<DirectionReference>,
    render: RenderThread,
    worker: Worker,
}

/// State of egui, and its output to draw.
struct WindowGui {
    state: egui_winit::State,
    context: egui::Context,
    paint_jobs: PaintJobs,
    start: Instant,
    // Used by tests.
    text_dump: Option<TextDump>,
}

impl WindowGui {
    fn new(window: &Window, device: &Device) -> Self {
        let context = egui::Context::default();
        style::apply(&context);
        let (scale, largest) = (window.scale_factor() as f32, device.candidate().max_side as usize);
        let state = egui_winit::State::new(
            context.clone(),
            ViewportId::ROOT,
            window,
            Some(scale),
            None,
            Some(largest),
        );
        let paint_jobs = PaintJobs { primitives: Vec::new(), textures: TexturesDelta::default(), scale: 1.0 };
        Self { state, context, paint_jobs, start: Instant::now(), text_dump: TextDump::from_environment() }
    }

    /// Returns the events since the last call, for a window of `size` pixels. The toolkit's own function asks the window for
    /// its size, which panics if another program has destroyed the window.
    fn input(&mut self, size: [u32; 2], scale: f32) -> RawInput {
        let points = vec2(size[0] as f32, size[1] as f32) / (scale * self.context.zoom_factor());
        let input = self.state.egui_input_mut();
        input.time = Some(self.start.elapsed().as_secs_f64());
        input.screen_rect = (!size.contains(&0)).then(|| Rect::from_min_size(Pos2::ZERO, points));
        input.viewport_id = ViewportId::ROOT;
        input.viewports.entry(ViewportId::ROOT).or_default().native_pixels_per_point = Some(scale);
        input.take()
    }
}

impl Drop for WindowGui {
    fn drop(&mut self) {
        // egui complains about texture changes that are dropped.
        self.paint_jobs.textures.clear();
    }
}

/// Last request for a role of the worker.
struct PreparationRequest {
    number: u64,
    settings: ViewSettings,
}

/// Last requests to the background threads.
#[derive(Default)]
struct Requested {
    // Number of the newest preparation request.
    number: u64,
    // By role.
    preparations: [Option<PreparationRequest>; ROLES],
    frame: Option<FrameRequest>,
    // Inspected pixel of the displayed frame.
    pixel: Option<[u32; 2]>,
    // View that the main source is fine enough for, as soon as it is ready.
    seen: Option<Seen>,
    // Height field that is analysed for the surface pane.
    analysis: Option<Arc<HeightField>>,
}

/// View and size of a picture.
#[derive(PartialEq)]
struct Seen {
    view: View,
    size: [u32; 2],
}

/// Recent motion of camera and lights.
struct RecentMotion {
    // Settings after the last change, and its time.
    last: ViewSettings,
    changed: Option<Instant>,
    // `Pacing::continuous` at the last pass.
    continuous: bool,
}

/// Surface opened by a step in a folder.
struct Tried {
    path: PathBuf,
    // Previous surface.
    from: OsString,
}

/// Times of the next wake-up and of the last frame.
struct Schedule {
    wake: Option<Instant>,
    // Time at which the last frame was presented.
    presented: Instant,
    // True if a frame of the scene has come that was not presented yet.
    has_frame: bool,
}

/// State of an open window. The order of the fields is the order of destruction: threads first.
pub struct ViewerWindow {
    threads: Threads,
    model: Model,
    presenter: Presenter,
    gui: WindowGui,
    requested: Requested,
    motion: RecentMotion,
    schedule: Schedule,
    saves: Vec<PendingSave>,
    recording: Option<Recording>,
    tried: Option<Tried>,
    scenes: SceneFiles,
    context: Context,
    write_command: CommandLine,
    last: LastView,
    proxy: EventLoopProxy<Event>,
    device: Arc<Device>,
    // Size of the window [pixels].
    size: [u32; 2],
    window: Arc<Window>,
}

impl ViewerWindow {
    /// Opens the device and starts the threads. `instance` receives the instance even if the rest fails.
    pub fn new(
        start: &Start,
        window: Arc<Window>,
        proxy: EventLoopProxy<Event>,
        instance: &mut Option<Arc<Instance>>,
    ) -> Result<Self> {
        let display = window
            .display_handle()
            .map_err(|e| {
                Error::device(format!("the display is gone ({e})"), Remedy::PictureFile).caused_by(e)
            })?
            .as_raw();
        let opened = Arc::new(Instance::for_windows(start.context.validates(), display)?);
        *instance = Some(opened.clone());
        let surface = Arc::new(Surface::new(&opened, &window)?);
        let device = Device::open_for(&surface, start.context.device_choice())?;
        start.context.load_pipelines(&device);
        let presenter = Presenter::new(&device, &surface, &window, start.present)?;
        let threads = Threads::start(&device, &start.context, &proxy)?;
        let loaded = Arc::new(LoadedScene::of(start.plain.clone())?);
        let settings = start.settings.clone();
        let name = format!("{}, {}", device.candidate().name, device.reason());
        let mut opened = Self {
            threads,
            model: Model::new(settings.clone(), loaded, start.fps, name),
            presenter,
            gui: WindowGui::new(&window, &device),
            requested: Requested::default(),
            motion: RecentMotion { last: settings, changed: None, continuous: false },
            schedule: Schedule { wake: None, presented: Instant::now(), has_frame: false },
            saves: Vec::new(),
            recording: None,
            tried: None,
            scenes: start.scenes.clone(),
            context: start.context.clone(),
            write_command: start.command_line,
            last: start.last.clone(),
            proxy,
            device,
            size: window.inner_size().into(),
            window,
        };
        opened.model.measures_exposure = start.measures_exposure;
        opened.model.has_last = start.last.is_kept;
        opened.model.file_choice = FileChoice::with_recent((start.last.recent)());
        opened.model.sources.pigment = Some(Arc::new(Prepared::pigment_alone()?));
        opened.set_title();
        // The first pass requests the source, because it knows the size of the picture, which sets the resolution of
        // the source.
        opened.window.request_redraw();
        Ok(opened)
    }

    /// Handles an event of the window.
    pub fn event(&mut self, event: &WindowEvent) {
        match event {
            WindowEvent::Resized(size) => {
                self.size = (*size).into();
                self.presenter.resized(self.size);
                self.window.request_redraw();
            }
            WindowEvent::ScaleFactorChanged { .. } => {
                self.presenter.resized(self.size);
                self.window.request_redraw();
            }
            WindowEvent::DroppedFile(path) => {
                self.model.actions.open = Some(path.to_string_lossy().into_owned());
                self.window.request_redraw();
            }
            _ => {}
        }
        // The panel runs before and after each press and release. Run once per frame, it would miss clicks and drags
        // shorter than a frame.
        let button = matches!(event, WindowEvent::MouseInput { .. });
        if button {
            self.pass();
        }
        if self.gui.state.on_window_event(&self.window, event).repaint {
            self.threads.render.give_way(true);
            self.window.request_redraw();
        }
        if button {
            self.pass();
        }
    }

    /// Returns true if the user has closed the window.
    pub fn closes(&self) -> bool {
        self.model.actions.close
    }

    /// Keeps the compiled pipelines, and the displayed settings for the next window if anything was set in this one.
    ///
    /// # Errors
    /// Fails if the settings cannot be written.
    pub fn keep(&self) -> Result<()> {
        self.context.keep_pipelines(self.presenter.device());
        if self.model.is_untouched() {
            return Ok(());
        }
        // The options belong to the displayed scene, not to one that is still being opened.
        let scene = self.model.applied.scene.clone();
        let settings = ViewSettings { scene, ..self.model.settings.clone() };
        (self.last.keep)(&settings, &self.model.loaded.scene)
    }

    /// Returns the command that draws the displayed picture.
    pub fn command(&self) -> String {
        let size = self.model.size.map(|n| n.max(1));
        self.command_line(&Output { size, file: "picture.png", turntable: None })
    }

    /// Returns the command that draws the displayed picture into `output`.
    fn command_line(&self, output: &Output<'_>) -> String {
        (self.write_command)(&self.model.shown(), &self.model.loaded.scene, output)
    }

    /// Returns the time at which a frame has to be drawn even without an event.
    pub fn wake(&self) -> Option<Instant> {
        self.schedule.wake
    }

    /// Returns the time of the next poll for events; see [`POLL_PERIOD`].
    pub fn poll(&self) -> Option<Instant> {
        let now = Instant::now();
        (now < self.schedule.presented + POLL_PERIOD).then(|| now + POLL_INTERVAL)
    }

    /// Requests a redraw.
    pub fn request_redraw(&mut self) {
        self.schedule.wake = None;
        self.window.request_redraw();
    }

    /// Runs the panel and draws a frame of the window.
    pub fn redraw(&mut self) -> Result<()> {
        self.schedule.wake = None;
        self.pass();
        if self.awaits_frame() {
            self.threads.render.give_way(false);
            self.wake_by(Some(self.schedule.presented + LONGEST_WAIT));
            return Ok(());
        }
        let pictures = pictures(&self.model);
        let drawn = self.presenter.draw(pictures.as_ref(), &mut self.gui.paint_jobs);
        self.threads.render.give_way(false);
        (self.schedule.presented, self.schedule.has_frame) = (Instant::now(), false);
        if !drawn? && !self.size.contains(&0) {
            self.window.request_redraw();
        }
        Ok(())
    }

    /// Returns true if the next frame of a moving scene is to be presented before the panel.
    fn awaits_frame(&self) -> bool {
        let shows =
            |request: &FrameRequest| self.model.frame.as_ref().is_some_and(|frame| request.is_seen_in(frame));
        self.model.pacing.moving
            && !self.schedule.has_frame
            && self.requested.frame.as_ref().is_some_and(|request| !shows(request))
            && Instant::now() < self.schedule.presented + LONGEST_WAIT
    }

    /// Runs the panel on the events since the last pass, and handles changes.
    fn pass(&mut self) {
        let input = self.gui.input(self.size, self.window.scale_factor() as f32);
        self.model.device.memory = self.device.memory_in_use();
        self.model.device.present_mode = match self.presenter.mode() {
            vk::PresentModeKHR::IMMEDIATE => "immediate",
            vk::PresentModeKHR::MAILBOX => "mailbox",
            _ => "FIFO",
        };
        let context = self.gui.context.clone();
        let mut picture = Rect::NOTHING;
        let output = context.run_ui(input, |ui| picture = layout::show(ui, &mut self.model));
        let scale = output.pixels_per_point;
        if let Some(dump) = &mut self.gui.text_dump {
            dump.write(&output.shapes, scale);
        }
        self.model.size = [picture.width(), picture.height()].map(|n| (n.max(0.0) * scale).round() as u32);
        if self.model.fit_view() {
            // A view that follows the window does not count as motion.
            self.motion.last.camera = self.model.settings.camera;
            self.window.request_redraw();
        }
        self.gui.state.handle_platform_output(&self.window, output.platform_output);
        let jobs = &mut self.gui.paint_jobs;
        jobs.primitives = context.tessellate(output.shapes, scale);
        jobs.textures.append(output.textures_delta);
        jobs.scale = scale;
        if let Some(root) = output.viewport_output.get(&ViewportId::ROOT) {
            match root.repaint_delay {
                Duration::ZERO => self.window.request_redraw(),
                delay => self.wake_by(Instant::now().checked_add(delay)),
            }
        }
        self.act();
    }

    /// Wakes the event loop at `at` or earlier.
    fn wake_by(&mut self, at: Option<Instant>) {
        self.schedule.wake = match (self.schedule.wake, at) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
    }

    /// Executes the user's actions and sends requests for changes.
    fn act(&mut self) {
        let actions = std::mem::take(&mut self.model.actions);
        self.model.actions.close = actions.close;
        self.carry_out(actions);
        self.model.pacing.quality.set_fps(self.model.pacing.fps);
        self.track_motion();
        self.request_preparations();
        // Each frame of continuous drawing requests the next one; this requests the first.
        let begins = self.model.pacing.continuous && !self.motion.continuous;
        self.motion.continuous = self.model.pacing.continuous;
        self.request_frame(begins);
        self.inspect();
        self.analyse();
    }

    /// Decides if camera or lights are moving.
    fn track_motion(&mut self) {
        let now = Instant::now();
        let (new, old) = (&self.model.settings, &self.motion.last);
        if (new.camera, &new.lights, new.surroundings) != (old.camera, &old.lights, old.surroundings) {
            self.motion.changed = Some(now);
            self.motion.last = new.clone();
        }
        let ends = self.motion.changed.map(|at| at + MOTION_TIMEOUT);
        let moving = ends.is_some_and(|at| now < at);
        if moving != self.model.pacing.moving {
            self.model.pacing.moving = moving;
            self.window.request_redraw();
        }
        if moving {
            self.wake_by(ends);
        }
    }

    fn set_title(&self) {
        self.window.set_title(&title(&self.model));
    }
}

impl Threads {
    /// Starts the render thread and the worker, which answer by events.
    fn start(device: &Arc<Device>, context: &Context, proxy: &EventLoopProxy<Event>) -> Result<Self> {
        // Events that are sent after the end of the event loop are dropped.
        let send = proxy.clone();
        let worker = Worker::new(device.candidate(), Some(device.clone()), InUse::new(context), move |r| {
            drop(send.send_event(Event::Worker(r)));
        })?;
        let send = proxy.clone();
        let render = RenderThread::new(device, move |r| drop(send.send_event(Event::Render(r))))?;
        Ok(Self { probe: None, inspector: None, render, worker })
    }
}

/// Returns the title: the displayed scene and surface, and those in preparation.
fn title(model: &Model) -> String {
    let short = |name: &Path| name.file_name().unwrap_or(name.as_os_str()).to_string_lossy().into_owned();
    let [shown, wanted] =
        [&model.shown(), &model.settings].map(|settings| short(Path::new(&settings.surface.name)));
    let scene = short(Path::new(&model.applied.scene));
    match model.sources.stage() {
        Stage::Pigment => format!("diffract: {scene}, preparing {wanted}"),
        _ if shown != wanted => format!("diffract: {scene}, {shown}, preparing {wanted}"),
        Stage::Preview => format!("diffract: {scene}, {shown} (preview)"),
        Stage::Own => format!("diffract: {scene}, {shown}"),
    }
}

/// Returns the pictures to present and their positions in the window.
fn pictures(model: &Model) -> Option<ShownPictures<'_>> {
    let frame = model.frame.as_ref()?;
    let pair = |n: [u32; 2]| n.map(|n| n as f32);
    let area = pair(model.size);
    let place = PicturePlace {
        area,
        left: pair(frame.sizes[0]),
        right: pair(frame.sizes[1]),
        split: (area[0] * model.comparison.own_part()).round(),
    };
    Some(ShownPictures { images: [&frame.images[0], &frame.images[1]], place })
}
