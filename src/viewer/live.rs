//! The program while its window is open: what was asked of the threads, what they answered, what is drawn.

use super::Start;
use super::app::Event;
use super::compare::{self, Compare};
use super::gui::Painting;
use super::judge::Judge;
use super::model::{Model, Wants};
use super::screen::{Scenery, Screen};
use super::settings::{Needs, Optics, Settings};
use super::studio::{Errand, Stage, Studio, Wish, Word};
use super::worker::{Bake, Report, Request, Role, Worker};
use super::{hand, orbit, overlay, panel, save, style};
use crate::error::{Error, Result};
use crate::render::color_table;
use crate::render::frame::View;
use crate::render::picture::Picture;
use crate::render::resources::Reads;
use crate::render::window::Place;
use crate::scene::Scene;
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
    number: u64,
    // What was asked of the worker last, by role, with its number.
    asked: [Option<(u64, Settings)>; 3],
    // What was asked of the studio last.
    wished: Option<Wish>,
    // Settings and time of the last movement.
    before: Settings,
    moved: Option<Instant>,
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
            number: 0,
            asked: [None, None, None],
            wished: None,
            before: settings,
            moved: None,
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
        self.wish(false);
    }

    fn carry_out(&mut self, wants: Wants) {
        if wants.reset {
            let panel = self.model.settings.clone();
            self.model.settings = self.model.original.clone();
            self.model.compare = Compare::Alone;
            if panel.scene != self.model.original.scene {
                self.open_scene(self.model.original.scene.clone());
            }
        }
        if let Some(name) = wants.open {
            self.open(name);
        }
        if let Some([x, y]) = wants.focus {
            let camera = self.model.settings.shown_camera(&self.model.stage.scene);
            let at = glam::Vec2::new(x, y);
            if let Some(point) = orbit::hit(&camera, &self.model.stage.scene.mesh, at, self.model.size) {
                self.model.settings.camera.target = point;
            }
        }
        if let Some(with_exr) = wants.save {
            match self.wish_now() {
                Some(wish) => {
                    let stem = save::free_name(Path::new(""));
                    let name = stem.with_extension("png").to_string_lossy().into_owned();
                    let command = self.model.shown().command(&self.model.stage.scene, wish.size, &name);
                    self.saving.push(Saving { stem, with_exr, command });
                    self.studio.errand(Errand::Picture(wish));
                    self.model.say(format!("saving {name}"));
                }
                None => self.model.say("there is no picture yet that could be saved"),
            }
            self.window.request_redraw();
        }
        if wants.measure
            && let Some(wish) = self.wish_now()
        {
            self.judge = None;
            self.studio.errand(Errand::Samples(wish));
            self.model.say("measuring against the direct sum in f64");
            self.window.request_redraw();
        }
    }

    /// Opens a file that was dropped, or a scene by name: what is no scene and no mesh is a height field.
    fn open(&mut self, name: String) {
        let extension =
            Path::new(&name).extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
        if extension.is_empty() || extension == "obj" || extension == "toml" {
            return self.open_scene(name);
        }
        let surface = &mut self.model.settings.surface;
        let (pixel_size, height) = (surface.pixel_size, surface.height);
        if pixel_size.is_none() || height.is_none() {
            self.model.message = Some(super::model::Message {
                text: "a height image carries no units: set sample and full height in the panel".to_owned(),
                bad: false,
            });
        }
        surface.name = name;
        // A start for the hand: a scan of a skin.
        surface.pixel_size = Some(pixel_size.unwrap_or([0.1; 2]));
        surface.height = Some(height.unwrap_or(0.5));
        self.window.request_redraw();
    }

    /// Opens a scene or a mesh beside, since a large one takes a while.
    fn open_scene(&mut self, name: String) {
        let proxy = self.proxy.clone();
        let said = format!("opening {name}");
        let open = move || {
            let stage = Scene::open(&name).and_then(Stage::of);
            let _ = proxy.send_event(Event::Scene(name, Box::new(stage))); // fails after the end of the loop
        };
        match std::thread::Builder::new().name("scene".to_owned()).spawn(open) {
            Ok(_) => self.model.say(said),
            Err(e) => {
                self.model.complain(&Error::failed(format!("the system gives no thread ({e})"), "try again"))
            }
        }
        self.window.request_redraw();
    }

    fn staged(&mut self, name: String, stage: Stage) {
        let scene = &stage.scene;
        let settings = &mut self.model.settings;
        let of_mesh = name.to_lowercase().ends_with(".obj");
        settings.camera = scene.camera;
        if !of_mesh {
            settings.lights.clone_from(&scene.lights);
            settings.exposure = scene.exposure;
            settings.base_color = scene.base_color;
            settings.surface.name.clone_from(&scene.surface);
            (settings.surface.pixel_size, settings.surface.height) = (scene.pixel_size, scene.full_height);
        }
        settings.scene.clone_from(&name);
        self.model.applied.scene = name;
        self.model.stage = Arc::new(stage);
        self.model.pace.forget();
        self.model.message = None;
        self.title();
    }

    fn title(&self) {
        let s = &self.model.settings;
        let short = |name: &str| {
            Path::new(name).file_name().map_or(name.to_owned(), |n| n.to_string_lossy().into_owned())
        };
        self.window.set_title(&format!("diffract: {}, {}", short(&s.scene), short(&s.surface.name)));
    }

    /// Asks the worker for what is set and not asked for yet.
    fn prepare(&mut self) {
        let own = self.model.settings.clone();
        self.ask(Role::Own, &own);
        if self.model.compare != Compare::Alone {
            let optics = self.model.other.clone();
            self.ask(Role::Other, &Settings { optics, ..own.clone() });
        }
        let slow = self.model.pace.moving(false) != super::pace::Rung::Whole;
        let ready = self.model.own.as_ref().map(|p| p.number) == self.asked[0].as_ref().map(|a| a.0);
        // No layers are as fast as a table: its moving picture has its resolution to give.
        if slow && ready && own.optics.method == Reads::Layers {
            let optics = compare::coarse(&own.optics);
            self.ask(Role::Coarse, &Settings { optics, ..own });
        }
    }

    fn ask(&mut self, role: Role, settings: &Settings) {
        let asked = &mut self.asked[role as usize];
        if asked.as_ref().is_some_and(|(_, asked)| {
            let alike = Settings { scene: asked.scene.clone(), ..settings.clone() };
            alike.needs(asked) < Needs::Layers
        }) {
            return;
        }
        self.number += 1;
        *asked = Some((self.number, settings.clone()));
        match settings.shading(&settings.optics) {
            Ok(shading) => {
                let source = settings.surface.clone();
                let Optics { method, filter, .. } = settings.optics;
                self.worker.ask(Request { role, number: self.number, source, shading, method, filter });
                self.model.progress[role as usize] = Some((0, 1));
                self.window.request_redraw();
            }
            Err(e) => self.model.complain(&e),
        }
        match role {
            // What was made for the former setting shows another thing.
            Role::Other => self.model.judge = None,
            Role::Coarse => self.model.coarse = None,
            Role::Own => self.title(),
        }
    }

    /// What is to be seen now, drawn whole; `None` before the first layers are there.
    fn wish_now(&self) -> Option<Wish> {
        let model = &self.model;
        let own = model.own.clone().filter(|_| !model.size.contains(&0))?;
        let (shown, scene) = (model.shown(), &model.stage.scene);
        let view = View {
            camera: shown.shown_camera(scene),
            base_color: shown.base_color,
            pigment: scene.pigment.is_some(),
            ..View::of(scene, shown.lights)
        };
        Some(Wish {
            stage: model.stage.clone(),
            own,
            other: model.judge.clone(),
            coarse: None,
            rung: super::pace::Rung::Whole,
            moving: false,
            again: false,
            view,
            exposure: shown.exposure,
            background: scene.background,
            size: model.size,
            compare: model.compare,
            inset: model.inset,
        })
    }

    /// Asks the studio for what is to be seen, if that has changed.
    fn wish(&mut self, again: bool) {
        let Some(wish) = self.wish_now() else { return };
        let rung = self.model.rung();
        let coarse = self.model.coarse.clone().filter(|_| self.model.compare == Compare::Alone);
        let wish = Wish { rung, coarse, moving: self.model.moving, again, ..wish };
        if !again && self.wished.as_ref().is_some_and(|w| alike(w, &wish)) {
            return;
        }
        let same_picture =
            |w: &Wish| w.view == wish.view && w.own.number == wish.own.number && w.size == wish.size;
        if !self.wished.as_ref().is_some_and(same_picture) {
            // A measured error belongs to the picture that it was measured on.
            self.judge = None;
            self.model.verdict = None;
        }
        self.studio.wish(wish.clone());
        self.wished = Some(wish);
    }

    /// What a thread has to say.
    pub fn hear(&mut self, event: Event) -> Result<()> {
        match event {
            Event::Worker(report) => self.worked(report),
            Event::Studio(word) => self.drawn(word)?,
            Event::Judge(Ok(verdict)) => {
                self.model.message = None;
                self.model.verdict = Some(verdict);
            }
            Event::Judge(Err(e)) => self.model.complain(&e),
            Event::Scene(name, stage) => match *stage {
                Ok(stage) => self.staged(name, stage),
                Err(e) => {
                    self.model.settings.scene.clone_from(&self.model.applied.scene);
                    self.model.complain(&e);
                }
            },
        }
        self.window.request_redraw();
        Ok(())
    }

    fn worked(&mut self, report: Report) {
        let model = &mut self.model;
        match report {
            Report::Progress { role, done, of } => model.progress[role as usize] = Some((done, of)),
            Report::Ready(role, prepared, note) => {
                let newest = self.asked[role as usize].as_ref().map(|a| a.0);
                if newest != Some(prepared.number) {
                    return;
                }
                model.progress[role as usize] = None;
                if let Some(note) = note {
                    model.say(note);
                }
                match role {
                    Role::Own => {
                        if let Some((_, settings)) = &self.asked[0] {
                            let scene = model.applied.scene.clone();
                            model.applied = Settings { scene, ..settings.clone() };
                        }
                        model.own = Some(prepared);
                        (model.coarse, self.asked[Role::Coarse as usize]) = (None, None);
                        model.pace.forget();
                        model.message = model.message.take().filter(|m| !m.bad);
                    }
                    Role::Other => model.judge = Some(prepared),
                    Role::Coarse => model.coarse = Some(prepared),
                }
            }
            Report::Failed(role, error) => {
                model.progress[role as usize] = None;
                // Without coarse layers a moving picture has its resolution to give.
                if role != Role::Coarse {
                    model.complain(&error);
                }
            }
        }
    }

    fn drawn(&mut self, word: Word) -> Result<()> {
        match word {
            Word::Drawn(mut exhibit) => {
                // A display that was changed alone says nothing of frames.
                if exhibit.gpu > 0.0 {
                    self.model.history.push(exhibit.wall);
                    self.model.pace.took(exhibit.rung, exhibit.wall);
                }
                let former = self.model.exhibit.take();
                if let Some(former) = former.filter(|f| f.number == exhibit.number) {
                    exhibit.cost = exhibit.cost.or(former.cost);
                    exhibit.inset = exhibit.inset.or(former.inset);
                }
                self.model.exhibit = Some(*exhibit);
                if self.model.continuous {
                    self.wish(true);
                }
            }
            Word::TooSlow(rung, milliseconds) => self.model.pace.took(rung, 2.0 * milliseconds),
            Word::Picture(picture) => self.save(&picture),
            Word::Samples(prepared, shown, samples) => {
                if samples.radiance.is_empty() {
                    self.model.say("the mesh covers no pixel: there is nothing to measure");
                } else {
                    let send = self.proxy.clone();
                    let say = move |verdict| drop(send.send_event(Event::Judge(verdict)));
                    let (view, exposure) = *shown;
                    self.judge = Some(Judge::new(prepared, view, exposure, samples, say)?);
                }
            }
            Word::Failed(e) if self.device.is_lost() => return Err(e),
            Word::Failed(e) => self.model.complain(&e),
        }
        Ok(())
    }

    fn save(&mut self, picture: &Picture) {
        if self.saving.is_empty() {
            return;
        }
        let Saving { stem, with_exr, command } = self.saving.remove(0);
        let (as_png, as_exr) = (stem.with_extension("png"), stem.with_extension("exr"));
        let saved = save::png(&as_png, picture, &command)
            .and_then(|()| if with_exr { save::exr(&as_exr, picture, &command) } else { Ok(()) });
        match saved {
            Ok(()) => {
                let more = if with_exr { " and .exr" } else { "" };
                let place = std::path::absolute(&as_png).unwrap_or(as_png);
                self.model.say(format!("saved {}{more}", place.display()));
            }
            Err(e) => self.model.complain(&e),
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        // What was not uploaded is not needed any more.
        self.painting.textures.clear();
    }
}

/// Whether both show the same.
fn alike(a: &Wish, b: &Wish) -> bool {
    let number = |p: &Option<Arc<super::worker::Prepared>>| p.as_ref().map(|p| p.number);
    Arc::ptr_eq(&a.stage, &b.stage)
        && a.own.number == b.own.number
        && number(&a.other) == number(&b.other)
        && (a.compare, a.rung, a.moving, a.size, a.inset) == (b.compare, b.rung, b.moving, b.size, b.inset)
        && (a.exposure, a.background) == (b.exposure, b.background)
        && a.view == b.view
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
