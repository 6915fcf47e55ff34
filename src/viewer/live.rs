//! The program while its window is open: what was asked of the threads, what they answered, what is drawn.

mod ask;
mod carry_out;
mod hear;

use super::Start;
use super::app::Event;
use super::compare::Compare;
use super::gui::Painting;
use super::judge::Judge;
use super::model::Model;
use super::screen::{Scenery, Screen};
use super::settings::Settings;
use super::studio::{Stage, Studio, Wish};
use super::words::Words;
use super::worker::{Bake, ROLES, Worker};
use super::{hand, overlay, panel, style};
use crate::error::{Error, Result};
use crate::render::color_table;
use crate::render::window::Place;
use crate::vk::device::Device;
use crate::vk::instance::Instance;
use crate::vk::surface::Surface;
use ash::vk;
use egui::{Rect, TexturesDelta, ViewportId};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::event::WindowEvent;
use winit::event_loop::EventLoopProxy;
use winit::raw_window_handle::HasDisplayHandle;
use winit::window::Window;

/// How long nothing has to move until it stands still.
const STILL: Duration = Duration::from_millis(160);

/// After a frame, the driver's own thread may read the display's connection and with it take events that the loop then does
/// not see coming: for so long it looks every `LOOK`.
const WATCHFUL: Duration = Duration::from_millis(500);
const LOOK: Duration = Duration::from_millis(8);

/// Where a picture goes that was asked for.
struct Saving {
    stem: PathBuf,
    with_exr: bool,
    command: String,
}

/// Everything behind an open window. The order of the fields is the order of destruction: threads first.
pub struct Live {
    judge: Option<Judge>,
    studio: Studio,
    worker: Worker,
    model: Model,
    screen: Screen,
    egui: egui_winit::State,
    // What the last look at the panel left to draw.
    painting: Painting,
    context: egui::Context,
    words: Option<Words>,
    number: u64,
    // What was asked of the worker last, by role, with its number.
    asked: [Option<(u64, Settings)>; ROLES],
    // What was asked of the studio last.
    wished: Option<Wish>,
    // Settings and time of the last movement.
    before: Settings,
    moved: Option<Instant>,
    // Whether frames were drawn without end at the last look.
    continuous: bool,
    saving: Vec<Saving>,
    wake: Option<Instant>,
    // When the last frame was handed to the window.
    presented: Instant,
    proxy: EventLoopProxy<Event>,
    device: Arc<Device>,
    window: Arc<Window>,
}

impl Live {
    /// Opens device and screen, starts the threads. `instance` gets the instance, also where the rest fails.
    pub fn new(
        start: &Start,
        window: Arc<Window>,
        proxy: EventLoopProxy<Event>,
        instance: &mut Option<Arc<Instance>>,
    ) -> Result<Self> {
        let display = window
            .display_handle()
            .map_err(|e| Error::failed(format!("the display is gone ({e})"), super::RENDER))?
            .as_raw();
        let opened = Arc::new(Instance::for_windows(start.validation, display)?);
        *instance = Some(opened.clone());
        let surface = Arc::new(Surface::new(&opened, &window)?);
        let device = Device::open_for(&surface, &start.wish)?;
        let screen = Screen::new(&device, &surface, &window, start.present)?;
        let send = proxy.clone();
        // An event that cannot be sent comes after the end of the loop.
        let of = device.clone();
        let bake: Bake = Box::new(move |field, shading, go_on| {
            color_table::obtain(&of, field, shading, &|_, done, of| go_on(done, of))
        });
        let worker = Worker::new(device.candidate(), bake, move |r| drop(send.send_event(Event::Worker(r))))?;
        let send = proxy.clone();
        let studio = Studio::new(&device, move |w| drop(send.send_event(Event::Studio(w))))?;
        let context = egui::Context::default();
        style::apply(&context);
        let egui = egui_winit::State::new(
            context.clone(),
            ViewportId::ROOT,
            &*window,
            Some(window.scale_factor() as f32),
            None,
            Some(device.candidate().max_side as usize),
        );
        let stage = Arc::new(Stage::of(start.plain.clone())?);
        let settings = start.settings();
        let candidate = device.candidate();
        let model = Model::new(
            settings.clone(),
            stage,
            start.fps,
            format!("{}, {}", candidate.name, device.reason()),
        );
        let mut live = Self {
            judge: None,
            studio,
            worker,
            model,
            screen,
            egui,
            painting: Painting { primitives: Vec::new(), textures: TexturesDelta::default(), scale: 1.0 },
            context,
            words: Words::from_environment(),
            number: 0,
            asked: Default::default(),
            wished: None,
            before: settings,
            moved: None,
            continuous: false,
            saving: Vec::new(),
            wake: None,
            presented: Instant::now(),
            proxy,
            device,
            window,
        };
        live.title();
        live.prepare();
        live.window.request_redraw();
        Ok(live)
    }

    /// An event of the window.
    pub fn event(&mut self, event: &WindowEvent) {
        match event {
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                self.screen.resized();
                self.window.request_redraw();
            }
            WindowEvent::DroppedFile(path) => {
                self.model.wants.open = Some(path.to_string_lossy().into_owned());
                self.window.request_redraw();
            }
            _ => {}
        }
        // Each press and each release is looked at for itself: where frames take longer than a click, all of it, and the
        // drag before a release, would be over when the panel looks.
        let button = matches!(event, WindowEvent::MouseInput { .. });
        if button {
            self.pass();
        }
        if self.egui.on_window_event(&self.window, event).repaint {
            self.window.request_redraw();
        }
        if button {
            self.pass();
        }
    }

    /// Whether the user has closed the window.
    pub fn closes(&self) -> bool {
        self.model.wants.close
    }

    /// The `diffract render` of what is shown.
    pub fn command(&self) -> String {
        let size = self.model.size.map(|n| n.max(1));
        self.model.shown().command(&self.model.stage.scene, size, "picture.png")
    }

    /// When a frame has to be drawn without an event.
    pub fn wake(&self) -> Option<Instant> {
        self.wake
    }

    /// When to look for events that did not announce themselves.
    pub fn look(&self) -> Option<Instant> {
        let now = Instant::now();
        (now < self.presented + WATCHFUL).then(|| now + LOOK)
    }

    /// Asks for a frame.
    pub fn request_redraw(&mut self) {
        self.wake = None;
        self.window.request_redraw();
    }

    /// Runs the panel and draws a frame of the window.
    pub fn redraw(&mut self) -> Result<()> {
        self.wake = None;
        self.pass();
        let scenery = scenery(&self.model);
        let drawn = self.screen.draw(scenery.as_ref(), &mut self.painting);
        self.presented = Instant::now();
        let area: [u32; 2] = self.window.inner_size().into();
        if !drawn? && !area.contains(&0) {
            self.window.request_redraw();
        }
        Ok(())
    }

    /// Runs the panel on the events so far, and does what follows from it.
    fn pass(&mut self) {
        let input = self.egui.take_egui_input(&self.window);
        let context = self.context.clone();
        let mut picture = Rect::NOTHING;
        self.model.memory = self.device.memory_in_use();
        self.model.present = match self.screen.mode() {
            vk::PresentModeKHR::IMMEDIATE => "immediate",
            vk::PresentModeKHR::MAILBOX => "mailbox",
            _ => "FIFO",
        };
        let model = &mut self.model;
        let output = context.run_ui(input, |ui| {
            hand::keys(ui, model);
            if model.panel {
                let frame =
                    egui::Frame::new().fill(style::PANEL).inner_margin(egui::Margin::symmetric(12, 4));
                egui::Panel::right("panel")
                    .exact_size(panel::WIDTH)
                    .resizable(false)
                    .frame(frame)
                    .show(ui, |ui| panel::show(ui, model));
            }
            picture = ui.available_rect_before_wrap();
            picture.min = egui::Pos2::ZERO;
            hand::pointer(ui, picture, model);
            overlay::show(ui, picture, model);
        });
        let scale = output.pixels_per_point;
        if let Some(words) = &mut self.words {
            words.tell(&output.shapes, scale);
        }
        self.model.size = [picture.width(), picture.height()].map(|n| (n.max(0.0) * scale).round() as u32);
        self.egui.handle_platform_output(&self.window, output.platform_output);
        self.painting.primitives = context.tessellate(output.shapes, scale);
        self.painting.textures.append(output.textures_delta);
        self.painting.scale = scale;
        if let Some(root) = output.viewport_output.get(&ViewportId::ROOT) {
            match root.repaint_delay {
                Duration::ZERO => self.window.request_redraw(),
                delay => self.sooner(Instant::now().checked_add(delay)),
            }
        }
        self.act();
    }

    fn sooner(&mut self, at: Option<Instant>) {
        self.wake = match (self.wake, at) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
    }

    /// Does what the user wants, and asks the threads for what has changed.
    fn act(&mut self) {
        let wants = std::mem::take(&mut self.model.wants);
        self.model.wants.close = wants.close;
        self.carry_out(wants);
        self.model.pace.set_fps(self.model.fps);
        self.prepare();
        let now = Instant::now();
        let (new, old) = (&self.model.settings, &self.before);
        if (new.camera, &new.lights) != (old.camera, &old.lights) {
            self.moved = Some(now);
            self.before = self.model.settings.clone();
        }
        let still = self.moved.map(|at| at + STILL);
        let moving = still.is_some_and(|at| now < at);
        if moving != self.model.moving {
            self.model.moving = moving;
            self.window.request_redraw();
        }
        if self.model.moving {
            self.sooner(still);
        }
        // Each frame that is drawn asks for the next one; this is the first.
        let begins = self.model.continuous && !self.continuous;
        self.continuous = self.model.continuous;
        self.wish(begins);
    }

    fn title(&self) {
        let s = &self.model.settings;
        let short = |name: &str| {
            Path::new(name).file_name().map_or(name.to_owned(), |n| n.to_string_lossy().into_owned())
        };
        self.window.set_title(&format!(
            "diffract: {}, {}",
            short(&s.scene),
            short(&s.surface.name.to_string_lossy())
        ));
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        // What was not uploaded is not needed any more.
        self.painting.textures.clear();
    }
}

/// Where the pictures lie in the window.
fn scenery(model: &Model) -> Option<Scenery<'_>> {
    let exhibit = model.exhibit.as_ref()?;
    let pair = |n: [u32; 2]| n.map(|n| n as f32);
    let area = pair(model.size);
    let split = if model.compare == Compare::Alone { 1.0 } else { model.split };
    let place = Place {
        area,
        left: pair(exhibit.sizes[0]),
        right: pair(exhibit.sizes[1]),
        split: (area[0] * split).round(),
    };
    Some(Scenery { images: [&exhibit.images[0], &exhibit.images[1]], place })
}
