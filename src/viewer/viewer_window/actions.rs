//! One-off actions of the user: reset, open, save, measure.

use super::{PendingSave, Tried, ViewerWindow};
use crate::error::Result;
use crate::scene::Scene;
use crate::scene::mesh_file;
use crate::surface::SurfaceSource;
use crate::surface::synth::SurfaceKind;
use crate::viewer::changes::StepDirection;
use crate::viewer::controls::in_controls;
use crate::viewer::event::{Event, OpenedScene};
use crate::viewer::folder::{self, Neighbour};
use crate::viewer::frame::LoadedScene;
use crate::viewer::guesses::Scale;
use crate::viewer::job_queue::Job;
use crate::viewer::model::{Actions, Concern, SaveAs, SavingProgress};
use crate::viewer::start::Output;
use crate::viewer::threads;
use crate::viewer::view_settings::ViewSettings;
use crate::viewer::{orbit, save};
use std::path::{Path, PathBuf};

/// Sample spacing \[µm\] and full height \[µm\] of a typical scan of a snake's skin, as initial values for a file
/// without units.
const TYPICAL_PIXEL: [f64; 2] = [0.1; 2];
const TYPICAL_HEIGHT: f64 = 0.5;

impl ViewerWindow {
    pub(super) fn carry_out(&mut self, actions: Actions) {
        self.model.changes.begin(&self.model.settings);
        if actions.frame {
            self.model.frame_view();
        }
        if actions.reset {
            self.reset();
        }
        if let Some(name) = actions.open {
            self.open(name);
        }
        if actions.go_on {
            self.go_on();
        }
        if let Some(path) = actions.save_scene {
            self.save_scene(path);
        }
        if let Some(step) = actions.step_surface {
            self.step_surface(step);
        }
        if let Some(at) = actions.focus {
            self.focus(at.into());
        }
        self.model.changes.act(&self.model.settings);
        if let Some(format) = actions.save {
            self.request_save(format);
        }
        if actions.copy_command {
            self.gui.context.copy_text(self.command());
            self.model.say("copied the command that draws this picture");
            self.window.request_redraw();
        }
        if actions.record {
            self.record();
        }
        if actions.measure
            && let Some(request) = self.own_frame()
        {
            self.threads.probe = None;
            self.threads.render.submit(Job::Samples(request));
            self.model.say("measuring against the direct sum in f64");
            self.window.request_redraw();
        }
    }

    fn reset(&mut self) {
        let start = &self.model.original.scene;
        if self.model.settings.scene == *start {
            self.model.return_to_start();
        } else {
            self.open_scene(start.clone(), true);
        }
    }

    /// Turns the camera to the point under pixel `at`.
    fn focus(&mut self, at: glam::Vec2) {
        let scene = &self.model.loaded.scene;
        let camera = self.model.settings.shown_camera(scene);
        if let Some(point) = orbit::hit(&camera, &scene.standing(), at, self.model.size) {
            self.model.settings.camera.target = point;
        }
    }

    /// Requests the picture for a file with an unused name.
    fn request_save(&mut self, format: SaveAs) {
        match self.own_frame().filter(|_| self.is_settled()) {
            Some(request) => {
                let stem = save::free_name(Path::new(""));
                let name = stem.with_extension("png").to_string_lossy().into_owned();
                let output = Output { size: request.size, file: &name, turntable: None };
                let command = self.command_line(&output);
                let with_exr = format == SaveAs::PngAndExr;
                self.saves.push(PendingSave { stem, with_exr, command, is_recorded: false });
                self.threads.render.submit(Job::Picture(request));
                self.model.saved = None;
                self.model.saving = Some(SavingProgress { text: format!("saving {name}"), part: 0.0 });
            }
            None => {
                self.model.actions.save = Some(format);
                let text = "the picture is saved as soon as it has its colours".to_owned();
                self.model.saving = Some(SavingProgress { text, part: 0.0 });
            }
        }
        self.window.request_redraw();
    }

    /// Opens a dropped file, or a scene by name. Files of unknown type are read as height fields.
    fn open(&mut self, name: String) {
        let extension =
            Path::new(&name).extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
        if extension.is_empty() || extension == "toml" || mesh_file::extension(Path::new(&name)).is_some() {
            return self.open_scene(name, false);
        }
        // Files of microscopes have units. Images have none and start with those of a scan of a skin.
        let image = matches!(extension.as_str(), "png" | "tif" | "tiff");
        let model = &mut self.model;
        let SurfaceSource { pixel_size, height, name: ref before, .. } = model.settings.surface;
        // A scale that is assumed for the former file is no better known for this one.
        let is_guess = [(Scale::Spacing, pixel_size.is_none()), (Scale::Height, height.is_none())]
            .map(|(scale, is_missing)| (scale, is_missing || model.guesses.has(before, scale)));
        let surface = &mut model.settings.surface;
        if let Some(known) = model.files.iter().find(|file| file.name == *name) {
            surface.clone_from(known);
            return self.window.request_redraw();
        }
        for (scale, _) in is_guess.into_iter().filter(|(_, is_guess)| image && *is_guess) {
            model.guesses.assume(name.as_ref(), scale);
            model.visible.panel = true;
            model.notice = Some(
                "a height image carries no units: set sample spacing and full height in the panel".to_owned(),
            );
        }
        surface.name = name.into();
        surface.channel = None;
        surface.pixel_size = image.then(|| pixel_size.unwrap_or(TYPICAL_PIXEL));
        surface.height = image.then(|| height.unwrap_or(TYPICAL_HEIGHT));
        self.window.request_redraw();
    }

    /// Opens a scene or a mesh on a separate thread, because a large one takes long. If `resets`, the settings at the
    /// start are restored too.
    fn open_scene(&mut self, name: String, resets: bool) {
        let message = format!("opening {name}");
        let open = self.scenes.open.clone();
        self.open_aside(message, move || {
            let failed = |e| OpenedScene { name: name.clone(), resets, loaded: Err(e), settings: None };
            let scene = match Scene::open(&name) {
                Ok(scene) => scene,
                Err(e) => return failed(e),
            };
            // A scene file with options replaces all settings.
            let settings = if scene.options.is_empty() || resets {
                None
            } else {
                match open(&name) {
                    Ok(start) => Some(start.settings),
                    Err(e) => return failed(e),
                }
            };
            OpenedScene { loaded: LoadedScene::of(scene), name, resets, settings }
        });
    }

    /// Writes the displayed settings as a scene file.
    fn save_scene(&mut self, path: PathBuf) {
        let settings =
            ViewSettings { scene: self.model.applied.scene.clone(), ..self.model.settings.clone() };
        match (self.scenes.write)(&settings, &self.model.loaded.scene, &path) {
            Ok(()) => {
                self.model.succeed(Concern::Picture);
                self.model.say(format!("saved {}", path.display()));
                self.remember_file(&path.to_string_lossy());
            }
            Err(e) => self.model.report(Concern::Picture, &e),
        }
        self.window.request_redraw();
    }

    /// Puts a file in front of the recently opened ones.
    pub(super) fn remember_file(&mut self, name: &str) {
        if let Some(recent) = self.model.file_choice.remember(name)
            && let Err(e) = (self.last.keep_recent)(recent)
        {
            self.model.say(in_controls(&e));
        }
    }

    /// Goes to another surface: of the same folder, or another generated one.
    fn step_surface(&mut self, step: StepDirection) {
        let surface = &self.model.settings.surface;
        if let Some(kind) = surface.kind() {
            let all = SurfaceKind::ALL;
            let place = all.iter().position(|other| *other == kind).unwrap_or(0);
            let next = match step {
                StepDirection::Forward => (place + 1) % all.len(),
                StepDirection::Back => (place + all.len() - 1) % all.len(),
            };
            self.model.settings.surface = SurfaceSource::built_in(all[next]);
            self.model.say(format!("{} of {}: {}", next + 1, all.len(), all[next].name()));
            return self.window.request_redraw();
        }
        // After a refused file, steps continue from that file, although the surface is the previous one again.
        let from = match &self.tried {
            Some(tried) if tried.from == surface.name => tried.path.clone(),
            _ => PathBuf::from(&surface.name),
        };
        self.aside("folder", move || Event::Neighbour(folder::neighbour(&from, step)));
    }

    /// Shows the file of a step in a folder.
    pub(super) fn show_neighbour(&mut self, found: Result<Neighbour>) {
        match found {
            Ok(Neighbour { path, number, of }) => {
                let from = self.model.settings.surface.name.clone();
                self.tried = Some(Tried { path: path.clone(), from });
                self.open(path.to_string_lossy().into_owned());
                self.model.say(format!("{number} of {of}: {}", path.display()));
            }
            Err(e) => self.model.report(Concern::Setting, &e),
        }
    }

    /// Restores the window that was closed last.
    fn go_on(&mut self) {
        let open = self.last.open.clone();
        self.open_aside("opening what the last window showed".to_owned(), move || match open() {
            Ok(start) => {
                let settings = start.settings;
                let loaded = LoadedScene::of(start.plain);
                OpenedScene { name: settings.scene.clone(), resets: false, loaded, settings: Some(settings) }
            }
            Err(e) => OpenedScene { name: String::new(), resets: false, loaded: Err(e), settings: None },
        });
    }

    /// Runs `open` on a separate thread and shows `message`.
    fn open_aside(&mut self, message: String, open: impl FnOnce() -> OpenedScene + Send + 'static) {
        self.model.say(message);
        self.aside("scene", move || Event::Scene(Box::new(open())));
    }

    /// Runs `work` on a separate thread.
    pub(super) fn aside(&mut self, name: &str, work: impl FnOnce() -> Event + Send + 'static) {
        let proxy = self.proxy.clone();
        let work = move || {
            let _ = proxy.send_event(work()); // fails after the end of the event loop
        };
        if let Err(error) = threads::spawn(name, work) {
            self.model.report(Concern::Setting, &error);
        }
        self.window.request_redraw();
    }
}
