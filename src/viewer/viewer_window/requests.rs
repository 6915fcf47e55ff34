//! Requests to the background threads.

use super::{PreparationRequest, Seen, ViewerWindow};
use crate::optics::coherence::Windows;
use crate::render::frame::{Shown, View};
use crate::scene::Light;
use crate::setup::SourceSettings;
use crate::viewer::compare::{self, Compare};
use crate::viewer::event::Event;
use crate::viewer::frame::FrameRequest;
use crate::viewer::job_queue::PixelRequest;
use crate::viewer::model::{Stage, TaskProgress};
use crate::viewer::prepared::Role;
use crate::viewer::quality::Quality;
use crate::viewer::surface_pane::analysis::Analysis;
use crate::viewer::view_settings::{Needs, ViewSettings};
use crate::viewer::worker::{Request, RequestedPicture};
use std::sync::Arc;

impl ViewerWindow {
    /// Requests every setting that is needed and not requested yet.
    pub(super) fn request_preparations(&mut self) {
        let wanted = self.model.settings.clone();
        self.request_preview(&wanted);
        self.request_preparation(Role::Own, &wanted);
        if self.model.comparison.mode != Compare::Alone {
            let other = &self.model.comparison;
            let optics = wanted.optics.as_accurate_as(&other.optics);
            let surface = other.surface.clone().unwrap_or_else(|| wanted.surface.clone());
            self.request_preparation(Role::Other, &ViewSettings { optics, surface, ..wanted.clone() });
        }
        if self.is_own_ready() && !self.model.pacing.moving {
            self.request_as_seen(&wanted);
        }
    }

    /// Returns true if the user's last settings are ready to be drawn.
    fn is_own_ready(&self) -> bool {
        let requested = self.requested.preparations[Role::Own as usize].as_ref();
        self.model.sources.full.as_ref().map(|wanted| wanted.number)
            == requested.map(|request| request.number)
    }

    /// Returns true if the main picture is drawn from the source for the present view.
    pub(super) fn is_settled(&self) -> bool {
        let of_mean = self.model.settings.optics.settled().windows == Windows::All;
        let seen = Seen { view: self.view(), size: self.model.size };
        let is_requested = self.requested.seen.as_ref() == Some(&seen);
        !of_mean || is_requested && self.requested.preparations[Role::AsSeen as usize].is_none()
    }

    /// Requests the source of `wanted` for the present view if camera or lights have moved since the last request: a close
    /// view needs a finer source.
    fn request_as_seen(&mut self, wanted: &ViewSettings) {
        let seen = Seen { view: self.view(), size: self.model.size };
        if wanted.optics.settled().windows != Windows::All || self.requested.seen.as_ref() == Some(&seen) {
            return;
        }
        self.request_for_views(wanted, vec![seen.view]);
    }

    /// Requests a source of `wanted` that is fine enough for `views`.
    pub(super) fn request_for_views(&mut self, wanted: &ViewSettings, views: Vec<View>) {
        let Some(ready) = self.model.sources.full.clone() else { return };
        let Some(picture) = self.requested_picture(&wanted.lights) else { return };
        self.requested.seen = Some(Seen { view: self.view(), size: self.model.size });
        self.requested.number += 1;
        let (role, number) = (Role::AsSeen, self.requested.number);
        let settings = wanted.clone();
        self.requested.preparations[role as usize] = Some(PreparationRequest { number, settings });
        self.threads.worker.request(Request {
            role,
            number,
            surface: wanted.surface.clone(),
            settings: SourceSettings::new(ready.optics().clone()),
            picture: Some(RequestedPicture { views, ..picture }),
        });
    }

    /// Requests the first colours of `wanted`, unless they are requested already.
    fn request_preview(&mut self, wanted: &ViewSettings) {
        if self.is_requested(Role::Own, wanted) {
            return;
        }
        self.requested.preparations[Role::Preview as usize] = None;
        if let Some(optics) = compare::preview(&wanted.optics) {
            self.request_preparation(Role::Preview, &ViewSettings { optics, ..wanted.clone() });
        }
    }

    /// Returns true if the last request for `role` was for `settings`.
    fn is_requested(&self, role: Role, settings: &ViewSettings) -> bool {
        self.requested.preparations[role as usize].as_ref().is_some_and(|last| {
            let with_its_scene = ViewSettings { scene: last.settings.scene.clone(), ..settings.clone() };
            with_its_scene.needs(&last.settings) < Needs::Layers
        })
    }

    /// Requests `settings` for `role`, unless the last request for it was the same.
    fn request_preparation(&mut self, role: Role, settings: &ViewSettings) {
        if self.is_requested(role, settings) {
            return;
        }
        self.requested.number += 1;
        let number = self.requested.number;
        let request = PreparationRequest { number, settings: settings.clone() };
        self.requested.preparations[role as usize] = Some(request);
        let (surface, picture) = (settings.surface.clone(), self.requested_picture(&settings.lights));
        let request = Request { role, number, surface, settings: source_settings(role, settings), picture };
        if role == Role::Own {
            let view = self.view_under(&settings.lights);
            self.requested.seen = Some(Seen { view, size: self.model.size });
            self.requested.preparations[Role::AsSeen as usize] = None;
        }
        self.threads.worker.request(request);
        self.model.sources.progress[role as usize] = Some(TaskProgress { done: 0, of: 1 });
        self.window.request_redraw();
        // Data prepared for the former request shows another setting.
        match role {
            Role::Other => self.model.comparison.prepared = None,
            Role::Preview | Role::AsSeen => {}
            Role::Own => self.set_title(),
        }
    }

    /// Returns the present picture under `lights`.
    fn requested_picture(&self, lights: &[Light]) -> Option<RequestedPicture> {
        let model = &self.model;
        (!model.size.contains(&0)).then(|| RequestedPicture {
            loaded: model.loaded.clone(),
            views: vec![self.view_under(lights)],
            size: model.size,
            sampling: model.settings.sampling(),
        })
    }

    pub(super) fn view(&self) -> View {
        self.view_under(&self.model.shown().lights)
    }

    /// Returns the present view under `lights`.
    fn view_under(&self, lights: &[Light]) -> View {
        let (shown, scene) = (self.model.shown(), &self.model.loaded.scene);
        let mut view = View::under(scene, lights, &shown.optics.coherence);
        view.environment = scene.environment.as_ref().map(|e| e.placed(shown.surroundings));
        view.camera = shown.shown_camera(scene);
        // The window edits the first object.
        if let Some(color) = view.base_colors.first_mut() {
            *color = shown.base_color;
        }
        view
    }

    /// Returns the request for the present frame at full quality; `None` before anything is ready to be drawn.
    pub(super) fn whole_frame(&self) -> Option<FrameRequest> {
        let model = &self.model;
        let (wanted, stage) = model.sources.shown().filter(|_| !model.size.contains(&0))?;
        let is_own = stage == Stage::Own;
        let (shown, scene) = (model.shown(), &model.loaded.scene);
        let view = self.view();
        Some(FrameRequest {
            loaded: model.loaded.clone(),
            full: wanted.clone(),
            other: model.comparison.prepared.clone().filter(|_| is_own),
            quality: Quality::WHOLE,
            moving: false,
            again: false,
            view,
            shown: Shown {
                exposure: shown.exposure,
                tone: shown.tone,
                background: scene.display.background.color(),
            },
            measured: model.measures_exposure && is_own,
            size: model.size,
            compare: if is_own { model.comparison.mode } else { Compare::Alone },
            sampling: model.sampling(stage),
            inset: model.hemisphere().filter(|_| stage != Stage::Pigment),
        })
    }

    /// Returns that request once the user's settings are displayed.
    pub(super) fn own_frame(&self) -> Option<FrameRequest> {
        self.whole_frame().filter(|_| self.model.sources.stage() == Stage::Own)
    }

    /// Requests the analysis of the surface pane's height field.
    pub(super) fn analyse(&mut self) {
        let Some(field) = self.model.surface_pane.missing().cloned() else { return };
        if self.requested.analysis.as_ref().is_some_and(|asked| Arc::ptr_eq(asked, &field)) {
            return;
        }
        self.requested.analysis = Some(field.clone());
        self.aside("analysis", move || Event::Analysis(Analysis::of(&field).map(Arc::new)));
    }

    /// Requests the inspected pixel, once the frame of full quality is shown.
    pub(super) fn inspect(&mut self) {
        let model = &self.model;
        if !model.inspector.open {
            self.threads.inspector = None;
            self.requested.pixel = None;
            return;
        }
        let is_whole = |wanted: &FrameRequest| {
            let frame = model.frame.as_ref();
            frame.is_some_and(|f| f.quality == Quality::WHOLE && f.number == wanted.full.number)
        };
        let at =
            model.inspector.at.filter(|_| !model.pacing.moving && self.requested.pixel != model.inspector.at);
        let Some((at, frame)) = at.zip(self.own_frame().filter(is_whole)) else { return };
        self.requested.number += 1;
        self.requested.pixel = Some(at);
        self.threads.render.read_pixel(PixelRequest { number: self.requested.number, frame, at });
    }

    /// Requests a frame if it would differ from the last one requested, or in any case if `again`.
    pub(super) fn request_frame(&mut self, again: bool) {
        let Some(whole) = self.whole_frame() else { return };
        let is_seen = self.model.frame.as_ref().is_some_and(|frame| whole.is_seen_in(frame));
        let quality = self.model.quality(is_seen);
        let moving = self.model.pacing.moving || !is_seen;
        let request = FrameRequest { quality, moving, again, ..whole };
        let last = self.requested.frame.as_ref();
        if !again && last.is_some_and(|last| last.shows_the_same_as(&request)) {
            return;
        }
        if !last.is_some_and(|last| last.has_the_radiance_of(&request)) {
            self.threads.probe = None;
            self.model.probe = None;
        }
        self.threads.render.request(request.clone());
        self.requested.frame = Some(request);
    }
}

/// Returns the settings of the source that `role` asks for under `settings`.
fn source_settings(role: Role, settings: &ViewSettings) -> SourceSettings {
    let mut source = SourceSettings::new(settings.optics.settled());
    if role == Role::Preview {
        source.footprints = compare::PREVIEWED;
    }
    source
}
