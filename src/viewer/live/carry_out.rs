//! What the user wants done once: reset, open, save, measure.

use super::{Live, Saving};
use crate::error::Error;
use crate::scene::Scene;
use crate::viewer::app::Event;
use crate::viewer::compare::Compare;
use crate::viewer::model::{Message, Wants};
use crate::viewer::studio::{Errand, Stage};
use crate::viewer::{orbit, save};
use std::path::Path;
use std::sync::Arc;

impl Live {
    pub(super) fn carry_out(&mut self, wants: Wants) {
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
    pub(super) fn open(&mut self, name: String) {
        let extension =
            Path::new(&name).extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
        if extension.is_empty() || extension == "obj" || extension == "toml" {
            return self.open_scene(name);
        }
        let surface = &mut self.model.settings.surface;
        surface.name = name.into();
        surface.channel = None;
        // Microscopes' files have units; a start for the hand where images have none: a scan of a skin.
        let image = matches!(extension.as_str(), "png" | "tif" | "tiff");
        let (pixel_size, height) = (surface.pixel_size, surface.height);
        if image && (pixel_size.is_none() || height.is_none()) {
            self.model.message = Some(Message {
                text: "a height image carries no units: set sample and full height in the panel".to_owned(),
                bad: false,
            });
        }
        surface.pixel_size = image.then(|| pixel_size.unwrap_or([0.1; 2]));
        surface.height = image.then(|| height.unwrap_or(0.5));
        self.window.request_redraw();
    }

    /// Opens a scene or a mesh beside, since a large one takes a while.
    pub(super) fn open_scene(&mut self, name: String) {
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

    pub(super) fn staged(&mut self, name: String, stage: Stage) {
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
        self.model.pace.doubt();
        self.model.message = None;
        self.title();
    }
}
