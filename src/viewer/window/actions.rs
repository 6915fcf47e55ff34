//! One-off actions of the user: reset, open, save, measure.

use super::{PendingSave, ViewerWindow};
use crate::error::Error;
use crate::scene::Scene;
use crate::surface::Source;
use crate::viewer::compare::Compare;
use crate::viewer::event::Event;
use crate::viewer::frame::LoadedScene;
use crate::viewer::job_queue::Job;
use crate::viewer::model::{Actions, SaveAs};
use crate::viewer::{orbit, save};
use std::path::Path;
use std::sync::Arc;

/// Sample spacing \[µm\] and full height \[µm\] of a typical scan of a snake's skin, to start from where a file has no units.
const TYPICAL_PIXEL: [f64; 2] = [0.1; 2];
const TYPICAL_HEIGHT: f64 = 0.5;

impl ViewerWindow {
    pub(super) fn carry_out(&mut self, actions: Actions) {
        if actions.reset {
            self.reset();
        }
        if let Some(name) = actions.open {
            self.open(name);
        }
        if let Some(at) = actions.focus {
            self.focus(at.into());
        }
        if let Some(format) = actions.save {
            self.request_save(format);
        }
        if actions.measure
            && let Some(request) = self.whole_frame()
        {
            self.threads.probe = None;
            self.threads.render.submit(Job::Samples(request));
            self.model.say("measuring against the direct sum in f64");
            self.window.request_redraw();
        }
    }

    fn reset(&mut self) {
        let scene = std::mem::replace(&mut self.model.settings, self.model.original.clone()).scene;
        self.model.comparison.mode = Compare::Alone;
        if scene != self.model.original.scene {
            self.open_scene(self.model.original.scene.clone());
        }
    }

    /// Turns the camera to the point under pixel `at`.
    fn focus(&mut self, at: glam::Vec2) {
        let scene = &self.model.loaded.scene;
        let camera = self.model.settings.shown_camera(scene);
        if let Some(point) = orbit::hit(&camera, &scene.mesh, at, self.model.size) {
            self.model.settings.camera.target = point;
        }
    }

    /// Has the picture drawn for a file of a free name.
    fn request_save(&mut self, format: SaveAs) {
        match self.whole_frame() {
            Some(request) => {
                let stem = save::free_name(Path::new(""));
                let name = stem.with_extension("png").to_string_lossy().into_owned();
                let command = self.command_line(request.size, &name);
                self.saves.push(PendingSave { stem, with_exr: format == SaveAs::PngAndExr, command });
                self.threads.render.submit(Job::Picture(request));
                self.model.say(format!("saving {name}"));
            }
            None => self.model.say("there is no picture to save yet"),
        }
        self.window.request_redraw();
    }

    /// Opens a dropped file, or a scene by name. Any other kind of file is taken for a height field.
    fn open(&mut self, name: String) {
        let extension =
            Path::new(&name).extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
        if extension.is_empty() || extension == "obj" || extension == "toml" {
            return self.open_scene(name);
        }
        // Microscopes' files have units. Images have none: they start with those of a scan of a skin.
        let image = matches!(extension.as_str(), "png" | "tif" | "tiff");
        let Source { pixel_size, height, .. } = self.model.settings.surface;
        if image && (pixel_size.is_none() || height.is_none()) {
            self.model.say("a height image carries no units: set sample and full height in the panel");
        }
        let surface = &mut self.model.settings.surface;
        surface.name = name.into();
        surface.channel = None;
        surface.pixel_size = image.then(|| pixel_size.unwrap_or(TYPICAL_PIXEL));
        surface.height = image.then(|| height.unwrap_or(TYPICAL_HEIGHT));
        self.window.request_redraw();
    }

    /// Opens a scene or a mesh on a thread of its own, because a large one takes a while.
    fn open_scene(&mut self, name: String) {
        let proxy = self.proxy.clone();
        let message = format!("opening {name}");
        let open = move || {
            let loaded = Scene::open(&name).and_then(LoadedScene::of);
            let _ = proxy.send_event(Event::Scene(name, Box::new(loaded))); // fails after the end of the event loop
        };
        match std::thread::Builder::new().name("scene".to_owned()).spawn(open) {
            Ok(_) => self.model.say(message),
            Err(e) => {
                self.model.report(&Error::failed(format!("the system refuses a thread ({e})"), "try again"));
            }
        }
        self.window.request_redraw();
    }

    /// Shows a scene that was opened as `name`. A mesh changes the camera alone; a scene brings its own settings.
    pub(super) fn show_scene(&mut self, name: String, loaded: LoadedScene) {
        let scene = &loaded.scene;
        let settings = &mut self.model.settings;
        let is_mesh = name.to_lowercase().ends_with(".obj");
        settings.camera = scene.camera;
        if !is_mesh {
            settings.lights.clone_from(&scene.lights);
            settings.exposure = scene.exposure;
            settings.tone = scene.tone;
            settings.base_color = scene.base_color;
            settings.surface.name.clone_from(&scene.surface);
            (settings.surface.pixel_size, settings.surface.height) = (scene.pixel_size, scene.full_height);
            settings.surface.channel = None;
            settings.surface.prepare.clone_from(&scene.prepare);
        }
        settings.scene.clone_from(&name);
        self.model.applied.scene = name;
        self.model.loaded = Arc::new(loaded);
        self.model.pacing.quality.invalidate();
        self.model.message = None;
        self.set_title();
    }
}
