//! State shared by panel, input and background threads: the user's settings and the data to show.

use super::changes::{Changes, StepDirection};
use super::compare::{self, Compare, Side};
use super::controls::in_controls;
use super::error_probe::ProbeStatus;
use super::files::FileChoice;
use super::frame::{LoadedScene, RenderedFrame};
use super::framing;
use super::graph::History;
use super::guesses::Guesses;
use super::inset::InsetRequest;
use super::inspector::Inspector;
use super::prepared::{Prepared, ROLES, Role};
use super::quality::{Quality, QualityControl};
use super::surface_pane::SurfacePane;
use super::view_settings::{Needs, ViewSettings};
use crate::error::Error;
use crate::render::frame::View;
use crate::render::sampling::Sampling;
use crate::scene::environment::Environment;
use crate::scene::mesh_file;
use crate::scene::{Camera, FarLight};
use crate::settings::Optics;
use crate::surface::SurfaceSource;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// One-off actions requested by the user.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Actions {
    /// Save the picture.
    pub save: Option<SaveAs>,
    /// Measure the error.
    pub measure: bool,
    /// Reset all settings.
    pub reset: bool,
    /// Write the scene into this file.
    pub save_scene: Option<PathBuf>,
    /// Go to another surface of the same folder, or another generated one.
    pub step_surface: Option<StepDirection>,
    /// Record a turntable, or stop recording.
    pub record: bool,
    /// Copy the command that draws the picture.
    pub copy_command: bool,
    /// Close the window.
    pub close: bool,
    /// Open a dropped file, or a scene by name.
    pub open: Option<String>,
    /// Restore the window that was closed last.
    pub go_on: bool,
    /// Show the whole mesh.
    pub frame: bool,
    /// Turn the camera to the point under this pixel.
    pub focus: Option<[f32; 2]>,
}

/// File formats of a saved picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveAs {
    /// The displayed picture.
    Png,
    /// The displayed picture, and the radiance as EXR.
    PngAndExr,
}

/// The palette of commands.
#[derive(Default)]
pub struct Palette {
    /// True while it is shown.
    pub open: bool,
    /// Typed text.
    pub text: String,
    /// Index of the chosen entry among those that match the text.
    pub chosen: usize,
}

/// Subject of an error: the next success with the same subject makes the error outdated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Concern {
    /// Setting, surface or scene that was refused.
    Setting,
    /// Drawing, saving or measuring the picture.
    Picture,
}

/// Error that stays visible until the user dismisses it or it is outdated.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// Error and remedy.
    pub text: String,
    /// Subject of the error.
    pub concern: Concern,
}

/// Comparison with another setting.
pub struct Comparison {
    /// Mode of the comparison.
    pub mode: Compare,
    /// Position of the split as a fraction of the picture's width.
    pub split: f32,
    /// Side that is shown alone, without a split.
    pub whole: Option<Side>,
    /// Other setting.
    pub optics: Optics,
    /// Other surface; `None` for the same surface.
    pub surface: Option<SurfaceSource>,
    /// Other setting, ready to be drawn.
    pub prepared: Option<Arc<Prepared>>,
}

impl Comparison {
    /// Switches to the next mode, with a split.
    pub fn step(&mut self) {
        (self.mode, self.whole) = (self.mode.next(), None);
    }

    /// Shows the other side alone, and the main side at the next call.
    pub fn swap(&mut self) {
        if self.mode == Compare::Alone {
            (self.mode, self.whole) = (Compare::Beside, Some(Side::Other));
        } else {
            let is_other = self.whole == Some(Side::Other);
            self.whole = Some(if is_other { Side::Own } else { Side::Other });
        }
    }

    /// Returns the fraction of the picture's width that shows the main side.
    pub fn own_part(&self) -> f32 {
        match (self.mode, self.whole) {
            (Compare::Alone, _) | (_, Some(Side::Own)) => 1.0,
            (_, Some(Side::Other)) => 0.0,
            (_, None) => self.split,
        }
    }
}

/// First colours of settings in preparation.
#[derive(Clone)]
pub struct Preview {
    /// Prepared data.
    pub prepared: Arc<Prepared>,
    /// Settings requested by the user.
    pub settings: ViewSettings,
}

/// Quality of the displayed colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The pigment alone.
    Pigment,
    /// The first colours.
    Preview,
    /// Colours of the requested settings.
    Own,
}

/// Prepared settings, and the progress of those in preparation.
#[derive(Default)]
pub struct Sources {
    /// Surface that does not diffract, drawn before any other is ready.
    pub pigment: Option<Arc<Prepared>>,
    /// First colours, until `full` is ready.
    pub preview: Option<Preview>,
    /// Settings requested by the user.
    pub full: Option<Arc<Prepared>>,
    /// Progress by [`Role`].
    pub progress: [Option<TaskProgress>; ROLES],
}

/// Progress of a picture that is being saved.
#[derive(Clone, Debug, PartialEq)]
pub struct SavingProgress {
    /// Description.
    pub text: String,
    /// Fraction done.
    pub part: f32,
}

/// Progress of a setting in preparation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskProgress {
    /// Steps done.
    pub done: usize,
    /// Steps in total.
    pub of: usize,
}

impl Sources {
    /// Returns the data that still pictures are drawn from, and its stage.
    pub fn shown(&self) -> Option<(&Arc<Prepared>, Stage)> {
        let preview = self.preview.as_ref().map(|preview| (&preview.prepared, Stage::Preview));
        let full = self.full.as_ref().map(|full| (full, Stage::Own));
        let pigment = self.pigment.as_ref().map(|pigment| (pigment, Stage::Pigment));
        preview.or(full).or(pigment)
    }

    /// Returns the stage of the displayed colours.
    pub fn stage(&self) -> Stage {
        self.shown().map_or(Stage::Pigment, |(_, stage)| stage)
    }

    /// Returns a description of the running computation, and the fraction done.
    pub fn in_progress(&self) -> Option<(&'static str, f32)> {
        let full = match self.stage() {
            Stage::Pigment => "pigment alone, preparing colours",
            Stage::Preview => "preview of the colours, preparing finer ones",
            Stage::Own => "preparing new settings, shown as before",
        };
        let named = [
            (Role::Preview, full),
            (Role::Own, full),
            (Role::Other, "preparing the comparison"),
            (Role::AsSeen, "preparing colours for this view"),
        ];
        named.into_iter().find_map(|(role, name)| {
            let TaskProgress { done, of } = self.progress[role as usize]?;
            Some((name, done as f32 / of.max(1) as f32))
        })
    }
}

/// Timing of frames.
pub struct Pacing {
    /// Recent frame times.
    pub history: History,
    /// Resolution while moving.
    pub quality: QualityControl,
    /// Target frame rate while moving \[frames per second\].
    pub fps: f64,
    /// True if frames are drawn continuously, not only on changes.
    pub continuous: bool,
    /// True while camera or lights are moving.
    pub moving: bool,
}

/// Visibility of the parts of the user interface.
pub struct Visible {
    /// The panel.
    pub panel: bool,
    /// The list of keys.
    pub help: bool,
    /// The hemisphere.
    pub inset: bool,
    /// Handles of the lights in the picture.
    pub lights: bool,
    /// True if a text was being edited at the end of the last pass. Esc ends the edit before the keys are read.
    pub typing: bool,
}

/// Information about the device for the panel.
pub struct DeviceStatus {
    /// Name of the device, and the reason for choosing it.
    pub name: String,
    /// Memory used by the program's resources \[bytes\].
    pub memory: u64,
    /// Presentation mode.
    pub present_mode: &'static str,
}

impl DeviceStatus {
    /// Returns name and presentation mode in one line.
    pub fn line(&self) -> String {
        format!("{}; {} presentation", self.name, self.present_mode)
    }
}

/// Last settings of each kind of coherence, to return to.
pub struct LastCoherence {
    /// Coherence length \[µm\].
    pub length: f64,
    /// Copies along x and y.
    pub copies: [u32; 2],
}

impl Default for LastCoherence {
    fn default() -> Self {
        // The length of `Coherence::SUNLIGHT`.
        Self { length: 65.0, copies: [3, 3] }
    }
}

/// View of the scene fitted to the picture, until the user chooses another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DefaultView {
    /// Camera; a different one was chosen by the user.
    pub camera: Camera,
    /// Size of the picture it is fitted to \[pixels\].
    pub size: [u32; 2],
}

/// State of the window.
pub struct Model {
    /// Settings of the user.
    pub settings: ViewSettings,
    /// Changes that can be undone.
    pub changes: Changes,
    /// Settings at the start.
    pub original: ViewSettings,
    /// Settings of the displayed picture; those of the user may still be in preparation.
    pub applied: ViewSettings,
    /// Comparison with another setting.
    pub comparison: Comparison,
    /// Coherences to return to.
    pub last_coherence: LastCoherence,
    /// Mesh and pigment.
    pub loaded: Arc<LoadedScene>,
    /// Scene opened last; a mesh that was opened since has no settings of its own.
    pub brought: Arc<LoadedScene>,
    /// Default view, until the user chooses another.
    pub default_view: Option<DefaultView>,
    /// Prepared data.
    pub sources: Sources,
    /// Displayed frame.
    pub frame: Option<RenderedFrame>,
    /// Timing of frames.
    pub pacing: Pacing,
    /// Measured error of the displayed picture.
    pub probe: Option<ProbeStatus>,
    /// State of the inspector.
    pub inspector: Inspector,
    /// State of the surface pane.
    pub surface_pane: SurfacePane,
    /// Palette of commands.
    pub palette: Palette,
    /// Side of the hemisphere \[points of the window\].
    pub inset_side: f32,
    /// Number of pictures of a turntable.
    pub turntable: u32,
    /// Progress of the recording of a turntable, if one is running.
    pub recording: Option<TaskProgress>,
    /// Picture that is being saved, if one is.
    pub saving: Option<SavingProgress>,
    /// Message about the picture that was saved last, until the next one.
    pub saved: Option<String>,
    /// Side being drawn and the fraction done, if drawing takes long.
    pub drawing: Option<(Side, f32)>,
    /// Last notice for the user.
    pub notice: Option<String>,
    /// Last error.
    pub failure: Option<Failure>,
    /// Surfaces from files, to choose again.
    pub files: Vec<SurfaceSource>,
    /// Scales of height images that are assumed.
    pub guesses: Guesses,
    /// Files to open and to write.
    pub file_choice: FileChoice,
    /// Visibility of the parts of the user interface.
    pub visible: Visible,
    /// Size of the picture \[pixels\].
    pub size: [u32; 2],
    /// Information about the device.
    pub device: DeviceStatus,
    /// Actions requested by the user.
    pub actions: Actions,
    /// True if the exposure of the next picture is measured.
    pub measures_exposure: bool,
    /// Exposure \[stops\] that was measured last.
    pub measured_exposure: Option<f64>,
    /// True if a closed window can be restored.
    pub has_last: bool,
}

impl Model {
    /// Makes the state at the start, with a target of `fps` frames a second on `device`.
    pub fn new(settings: ViewSettings, loaded: Arc<LoadedScene>, fps: f64, device: String) -> Self {
        let mut model = Self {
            changes: Changes::new(settings.clone()),
            original: settings.clone(),
            applied: settings.clone(),
            comparison: Comparison {
                mode: Compare::Alone,
                split: 0.5,
                whole: None,
                optics: compare::strict(&settings.optics),
                surface: None,
                prepared: None,
            },
            last_coherence: LastCoherence::default(),
            brought: loaded.clone(),
            default_view: None,
            settings,
            notice: environment_note(&loaded),
            loaded,
            sources: Sources::default(),
            frame: None,
            pacing: Pacing {
                history: History::default(),
                quality: QualityControl::new(fps),
                fps,
                continuous: false,
                moving: false,
            },
            probe: None,
            inspector: Inspector::default(),
            surface_pane: SurfacePane::default(),
            palette: Palette::default(),
            inset_side: 132.0,
            turntable: 120,
            recording: None,
            saving: None,
            saved: None,
            drawing: None,
            failure: None,
            files: Vec::new(),
            guesses: Guesses::default(),
            file_choice: FileChoice::default(),
            visible: Visible { panel: true, help: false, inset: true, lights: true, typing: false },
            size: [0, 0],
            device: DeviceStatus { name: device, memory: 0, present_mode: "" },
            actions: Actions::default(),
            measures_exposure: false,
            measured_exposure: None,
            has_last: false,
        };
        model.remember_surface();
        model.choose_default_view();
        model
    }

    /// Lists the present surface if it is a file's, so that it can be chosen again with its units.
    pub fn remember_surface(&mut self) {
        const MOST: usize = 12;
        let surface = &self.settings.surface;
        if surface.kind().is_some() {
            return;
        }
        match self.files.iter_mut().find(|file| file.name == surface.name) {
            Some(file) => file.clone_from(surface),
            None => self.files.push(surface.clone()),
        }
        if self.files.len() > MOST {
            self.files.remove(0);
        }
    }

    /// Returns to the settings of the displayed picture after the user's settings were refused.
    pub fn revert(&mut self) {
        self.sources.preview = None;
        self.settings = self.shown();
    }

    /// Sets the exposure that was measured for a picture; a reset returns to it.
    pub fn expose(&mut self, stops: f64) {
        (self.settings.exposure, self.original.exposure) = (stops, stops);
        self.measures_exposure = false;
        self.measured_exposure = Some(stops);
    }

    /// Marks the view as default if it is the scene's, so that it is fitted to the picture.
    pub fn choose_default_view(&mut self) {
        let camera = self.loaded.scene.camera;
        let is_own = self.settings.camera == camera;
        self.default_view = is_own.then_some(DefaultView { camera, size: [0; 2] });
    }

    /// Fits the default view to a picture of another size. Returns true if the view has changed.
    pub fn fit_view(&mut self) -> bool {
        let (scene, before) = (&self.loaded.scene, self.settings.camera);
        match &mut self.default_view {
            Some(view) if view.camera != before => self.default_view = None,
            Some(view) if view.size != self.size && !self.size.contains(&0) => {
                let camera = framing::of_scene(scene.camera, &scene.standing(), self.size);
                *view = DefaultView { camera, size: self.size };
                self.settings.camera = camera;
            }
            _ => {}
        }
        self.settings.camera != before
    }

    /// Shows the whole mesh from the present direction.
    pub fn frame_view(&mut self) {
        let camera = self.settings.camera;
        self.settings.camera = framing::whole(camera, &self.loaded.scene.standing(), self.size);
    }

    /// Shows a scene that was opened as `name`. A mesh changes only the view; a scene also replaces the settings of the
    /// previous scene.
    pub fn show_scene(&mut self, name: String, loaded: LoadedScene) {
        let is_mesh = mesh_file::extension(Path::new(&name)).is_some();
        self.settings.camera = loaded.scene.camera;
        // A measured exposure belongs to its scene.
        self.measures_exposure |= self.measured_exposure == Some(self.settings.exposure);
        let loaded = Arc::new(loaded);
        if !is_mesh {
            self.measures_exposure |= loaded.scene.display.auto_exposure;
            self.settings.change_scene(&self.brought.scene, &loaded.scene);
            self.brought = loaded.clone();
        }
        self.settings.scene.clone_from(&name);
        self.applied.scene = name;
        self.loaded = loaded;
        self.choose_default_view();
        self.pacing.quality.invalidate();
        self.notice = environment_note(&self.loaded);
        self.succeed(Concern::Setting);
    }

    /// Returns the settings that a reset of a single setting returns to: those at the start, with those of the scene if
    /// it is another.
    pub fn start(&self) -> ViewSettings {
        let mut start = self.original.clone();
        if self.settings.scene != start.scene {
            start.bring(&self.brought.scene);
        }
        start
    }

    /// Returns to the settings at the start, whose scene is shown.
    pub fn return_to_start(&mut self) {
        self.settings = self.original.clone();
        (self.comparison.mode, self.comparison.surface) = (Compare::Alone, None);
        self.choose_default_view();
    }

    /// Returns true if restoring the closed window is offered: until something is set in this one.
    pub fn offers_last(&self) -> bool {
        self.has_last && self.is_untouched()
    }

    /// Returns true if only the window has changed settings. A view that follows the size of the window is not the
    /// user's choice.
    pub fn is_untouched(&self) -> bool {
        let camera = if self.default_view.is_some() { self.original.camera } else { self.settings.camera };
        ViewSettings { camera, ..self.settings.clone() }.needs(&self.original) == Needs::Nothing
    }

    /// Restores a closed window with its scene.
    pub fn go_on(&mut self, name: String, loaded: LoadedScene, settings: ViewSettings) {
        self.show_scene(name, loaded);
        self.settings = settings;
        self.default_view = None;
        self.has_last = false;
        self.remember_surface();
    }

    /// Returns the settings of the displayed picture: the optics as prepared, everything else as set now.
    pub fn shown(&self) -> ViewSettings {
        let now = &self.settings;
        let done = self.sources.preview.as_ref().map_or(&self.applied, |preview| &preview.settings);
        ViewSettings {
            scene: self.applied.scene.clone(),
            lights: now.lights.iter().map(|light| light.known_to(&done.lights)).collect(),
            surroundings: now.surroundings,
            exposure: now.exposure,
            tone: now.tone,
            base_color: now.base_color,
            camera: now.camera,
            samples: now.samples,
            ..done.clone()
        }
    }

    /// Returns the requested hemisphere, if any: that of the light of the inspected pixel in its tangent frame,
    /// otherwise of the first light of the scene.
    pub fn hemisphere(&self) -> Option<InsetRequest> {
        /// Side from which the fine inset is drawn \[points of the window\].
        const FINE: f32 = 200.0;
        let light = self.shown_light().filter(|_| self.visible.inset)?;
        Some(InsetRequest { light, fine: self.inset_side > FINE && !self.pacing.moving })
    }

    /// Returns the light that panes show: that of the inspected pixel in its tangent frame, otherwise the first of the
    /// scene.
    pub fn shown_light(&self) -> Option<FarLight> {
        let inspected = self.inspector.light().filter(|light| !light.is_dark()).map(|light| {
            let [[theta, phi], _] = light.angles();
            FarLight { theta, phi, intensity: 1.0, size: 0.0 }
        });
        let first = || {
            let room = View::of(&self.loaded.scene, Vec::new()).room();
            self.settings.lights.first().map(|light| light.emitter.from_afar(&room))
        };
        inspected.or_else(first)
    }

    /// Returns the samples of pictures of `stage`. A compared or inspected picture is a single sample.
    pub fn sampling(&self, stage: Stage) -> Sampling {
        let is_one = self.comparison.mode != Compare::Alone || self.inspector.open || stage != Stage::Own;
        if is_one { Sampling::ONE } else { self.settings.sampling() }
    }

    /// Returns the quality of the next frame. `is_seen`: the displayed frame shows the same view already. Any other view is
    /// shown at the resolution of moving pictures first.
    pub fn quality(&self, is_seen: bool) -> Quality {
        self.quality_after(self.frame.as_ref().map(|frame| frame.number), is_seen)
    }

    /// Returns the quality of the frame after one of the setting with this number.
    fn quality_after(&self, frame: Option<u64>, is_seen: bool) -> Quality {
        let stand_in = self.sources.shown().filter(|(_, stage)| *stage != Stage::Own);
        let moving = self.pacing.moving || !is_seen;
        match (frame, stand_in) {
            // The first frame appears at once, at low resolution, even while moving.
            (None, _) => Quality::FIRST,
            (_, Some(_)) if moving => self.pacing.quality.moving().max(Quality::FIRST),
            // A preview also appears at once and leaves the cores to the preparation of the requested setting.
            (Some(number), Some((shown, _))) if shown.number == number => Quality::PREVIEW,
            (_, Some(_)) => Quality::FIRST,
            (_, None) if moving => self.pacing.quality.moving(),
            (_, None) => Quality::WHOLE,
        }
    }

    /// Shows a line to the user.
    pub fn say(&mut self, text: impl Into<String>) {
        self.notice = Some(text.into());
    }

    /// Shows an error to the user and removes the notice before it, which may be wrong now.
    pub fn report(&mut self, concern: Concern, error: &Error) {
        self.notice = None;
        self.failure = Some(Failure { text: in_controls(error), concern });
    }

    /// Removes an error that a success has made outdated.
    pub fn succeed(&mut self, concern: Concern) {
        self.failure.take_if(|failure| failure.concern == concern);
    }
}

/// Returns the note about the environment map of a scene.
fn environment_note(loaded: &LoadedScene) -> Option<String> {
    loaded.scene.environment.as_ref().and_then(Environment::note)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::viewer::view_settings::tests::settings;

    fn model() -> Model {
        let (settings, scene) = settings();
        let mut model = Model::new(settings, Arc::new(LoadedScene::of(scene).unwrap()), 15.0, String::new());
        model.size = [640, 480];
        model
    }

    fn show(model: &mut Model, name: &str) {
        model.show_scene(name.to_owned(), LoadedScene::of(Scene::open(name).unwrap()).unwrap());
    }

    #[test]
    fn another_scene_leaves_what_the_user_has_set_and_brings_the_rest() {
        let mut model = model();
        model.settings.surface = SurfaceSource { name: "scan.png".into(), ..model.settings.surface.clone() };
        model.settings.exposure = 1.5;
        model.settings.base_color = glam::Vec3::splat(0.2);
        let set = model.settings.clone();
        show(&mut model, "cd");
        let now = &model.settings;
        assert_eq!((&now.surface, now.exposure, now.base_color), (&set.surface, 1.5, set.base_color));
        let scene = &model.loaded.scene;
        assert_eq!((&now.lights, now.tone, now.camera), (&scene.lights, scene.display.tone, scene.camera));
        assert_eq!(now.optics.reflectance, scene.main_object().reflectance.clone().unwrap());
        // All settings come from the scenes.
        show(&mut model, "plate");
        model.return_to_start();
        show(&mut model, "sphere");
        assert_eq!(model.settings.exposure, model.loaded.scene.display.exposure);
    }

    #[test]
    fn pixels_of_surroundings_that_are_no_light_are_told() {
        let mut model = model();
        assert_eq!(model.notice, None);
        let mut scene = Scene::open("plate").unwrap();
        let pixels =
            image::Rgb32FImage::from_fn(16, 8, |x, _| image::Rgb([if x == 3 { f32::NAN } else { 1.0 }; 3]));
        let mut bytes = std::io::Cursor::new(Vec::new());
        image::DynamicImage::from(pixels).write_to(&mut bytes, image::ImageFormat::OpenExr).unwrap();
        scene.environment = Some(Environment::from_bytes("holes.exr", bytes.get_ref()).unwrap());
        model.show_scene("plate".to_owned(), LoadedScene::of(scene).unwrap());
        assert!(model.notice.as_ref().unwrap().starts_with("holes.exr: 8 pixels"), "{:?}", model.notice);
        show(&mut model, "plate");
        assert_eq!(model.notice, None);
    }

    #[test]
    fn previews_are_drawn_at_low_resolution_first_and_the_users_own_picture_whole() {
        let mut model = model();
        let prepared = Arc::new(Prepared { number: 7, ..Prepared::pigment_alone().unwrap() });
        model.sources.pigment = Some(prepared.clone());
        assert_eq!(model.quality_after(None, false), Quality::FIRST);
        assert_eq!(model.quality_after(Some(6), true), Quality::FIRST, "another picture stands there");
        assert_eq!(model.quality_after(Some(7), true), Quality::PREVIEW);
        model.pacing.moving = true;
        assert_eq!(model.quality_after(Some(7), true), Quality::FIRST);
        model.pacing.moving = false;
        model.sources.full = Some(prepared);
        assert_eq!(model.quality_after(Some(6), true), Quality::WHOLE);
        model.pacing.quality.record(Quality::WHOLE, 500.0, false);
        assert_eq!(
            model.quality_after(Some(7), false),
            Quality { divisor: 3 },
            "another view is there first"
        );
        assert_eq!(model.quality_after(Some(7), true), Quality::WHOLE);
    }

    #[test]
    fn refused_settings_return_to_those_of_the_picture() {
        let mut model = model();
        model.settings.surface.name = "nothing.png".into();
        model.settings.optics.tolerance = 1e-4;
        model.settings.exposure += 1.0;
        let exposure = model.settings.exposure;
        model.revert();
        assert_eq!(model.settings.surface, model.applied.surface);
        assert_eq!(model.settings.optics, model.applied.optics);
        assert_eq!(model.settings.exposure, exposure, "what was not refused stays");
    }

    #[test]
    fn an_error_stays_until_its_own_kind_succeeds() {
        let mut model = model();
        model.report(Concern::Setting, &Error::files("no such file", "choose another"));
        model.say("saved a.png");
        model.succeed(Concern::Picture);
        assert_eq!(model.failure.as_ref().unwrap().text, "no such file; choose another");
        model.succeed(Concern::Setting);
        assert_eq!((model.failure, model.notice.as_deref()), (None, Some("saved a.png")));
    }

    #[test]
    fn the_view_follows_the_picture_until_the_user_has_chosen_one() {
        let mut model = model();
        show(&mut model, "sphere");
        let before = model.settings.camera;
        assert!(!model.fit_view());
        assert_eq!(model.settings.camera, before, "the scene's own where it fits");
        model.size = [200, 800];
        assert!(model.fit_view());
        assert!(model.settings.camera.distance > before.distance);
        model.size = [640, 480];
        assert!(model.fit_view());
        assert_eq!(model.settings.camera, before);
        model.settings.camera.phi += 0.5;
        let chosen = model.settings.camera;
        model.size = [200, 800];
        assert!(!model.fit_view());
        assert_eq!(model.settings.camera, chosen);
        model.frame_view();
        assert_eq!((model.settings.camera.phi, model.settings.camera.theta), (chosen.phi, chosen.theta));
    }
}
