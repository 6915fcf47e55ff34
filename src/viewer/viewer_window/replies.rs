//! Replies of the background threads.

use super::{PendingSave, PreparationRequest, ViewerWindow};
use crate::error::{Error, Result};
use crate::notes::Notes;
use crate::picture_file::{self, PictureFormat};
use crate::render::renderer::Picture;
use crate::viewer::controls::in_controls;
use crate::viewer::error_probe::{ErrorProbe, ProbeTask};
use crate::viewer::event::{Event, OpenedScene};
use crate::viewer::frame::RenderedFrame;
use crate::viewer::inspector::reading::Reading;
use crate::viewer::inspector::reference::DirectionReference;
use crate::viewer::job_queue::RenderReply;
use crate::viewer::model::{Concern, Preview, TaskProgress};
use crate::viewer::prepared::{Prepared, Role};
use crate::viewer::view_settings::ViewSettings;
use crate::viewer::worker::WorkerReply;
use std::sync::Arc;

impl ViewerWindow {
    /// Handles an event of a background thread.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn handle(&mut self, event: Event) -> Result<()> {
        match event {
            Event::Worker(WorkerReply::Failed(_, _, e)) if self.device.is_lost() => return Err(e),
            Event::Worker(reply) => self.handle_preparation(reply),
            Event::Render(reply) => self.handle_rendering(reply)?,
            Event::Probe(Ok(status)) => {
                self.model.notice = None;
                self.model.succeed(Concern::Picture);
                self.model.probe = Some(status);
            }
            Event::Probe(Err(e)) => self.model.report(Concern::Picture, &e),
            Event::Inspector(number, answer) => {
                if let Err(e) = self.model.inspector.take(number, answer) {
                    self.model.report(Concern::Picture, &e);
                }
            }
            Event::Scene(opened) => self.show_scene(*opened),
            Event::Analysis(Ok(analysis)) => self.model.surface_pane.take(analysis),
            Event::Analysis(Err(e)) => self.model.report(Concern::Setting, &e),
            Event::Neighbour(found) => self.show_neighbour(found),
        }
        self.window.request_redraw();
        Ok(())
    }

    fn handle_preparation(&mut self, reply: WorkerReply) {
        let model = &mut self.model;
        match reply {
            WorkerReply::Progress { role, done, of } => {
                model.sources.progress[role as usize] = Some(TaskProgress { done, of });
            }
            WorkerReply::Field(field) => model.surface_pane.take_field(field),
            WorkerReply::Ready(role, prepared, note) => {
                let newest = self.requested.preparations[role as usize].as_ref().map(|r| r.number);
                if newest != Some(prepared.number) {
                    return;
                }
                model.sources.progress[role as usize] = None;
                if let Some(note) = note {
                    model.say(in_controls(&note));
                }
                match role {
                    Role::Preview => self.preview(prepared),
                    Role::Own => self.apply(prepared),
                    Role::Other => model.comparison.prepared = Some(prepared),
                    Role::AsSeen => self.take_as_seen(prepared),
                }
            }
            WorkerReply::Failed(role, number, error) => self.refuse(role, number, &error),
        }
    }

    /// Handles the failure of request `number` for `role`. The user's settings return to those of the displayed
    /// picture.
    pub(super) fn refuse(&mut self, role: Role, number: u64, error: &Error) {
        let newest = self.requested.preparations[role as usize].as_ref().map(|r| r.number);
        if newest != Some(number) {
            return;
        }
        if role == Role::AsSeen {
            self.requested.preparations[role as usize] = None;
            self.stop_recording();
        }
        let model = &mut self.model;
        model.sources.progress[role as usize] = None;
        if matches!(role, Role::Own | Role::Other | Role::AsSeen) {
            model.report(Concern::Setting, error);
        }
        if role == Role::Own {
            model.sources.preview = None;
        }
        if role == Role::Own
            && let Some(full) = &model.sources.full
        {
            let number = full.number;
            model.revert();
            let settings = model.settings.clone();
            self.requested.preparations[role as usize] = Some(PreparationRequest { number, settings });
            self.set_title();
        }
    }

    /// Shows an opened scene, or its error.
    fn show_scene(&mut self, opened: OpenedScene) {
        match opened.loaded {
            Ok(loaded) => {
                self.remember_file(&opened.name);
                match opened.settings {
                    Some(settings) => self.model.go_on(opened.name, loaded, settings),
                    None => self.model.show_scene(opened.name, loaded),
                }
                if opened.resets {
                    self.model.return_to_start();
                }
            }
            Err(e) => {
                self.model.settings.scene.clone_from(&self.model.applied.scene);
                self.model.report(Concern::Setting, &e);
            }
        }
        self.set_title();
    }

    /// Shows the first colours of the main setting, unless that is ready.
    fn preview(&mut self, prepared: Arc<Prepared>) {
        let model = &mut self.model;
        let is_ready = model.sources.full.as_ref().is_some_and(|full| full.number > prepared.number);
        if let Some(full) = self.requested.preparations[Role::Own as usize].as_ref().filter(|_| !is_ready) {
            let scene = model.applied.scene.clone();
            let settings = ViewSettings { scene, ..full.settings.clone() };
            model.sources.preview = Some(Preview { prepared, settings });
            self.set_title();
        }
    }

    /// Shows the main setting, now that it is ready.
    fn apply(&mut self, prepared: Arc<Prepared>) {
        let model = &mut self.model;
        if let Some(request) = &self.requested.preparations[Role::Own as usize] {
            let scene = model.applied.scene.clone();
            model.applied = ViewSettings { scene, ..request.settings.clone() };
        }
        model.surface_pane.take_field(prepared.field.clone());
        model.sources.full = Some(prepared);
        model.sources.preview = None;
        model.sources.progress[Role::Preview as usize] = None;
        model.pacing.quality.invalidate();
        model.succeed(Concern::Setting);
        model.remember_surface();
        let name = model.settings.surface.name.to_string_lossy().into_owned();
        self.remember_file(&name);
        self.set_title();
    }

    /// Replaces the main source by the one for the present view, unless both share their data.
    fn take_as_seen(&mut self, prepared: Arc<Prepared>) {
        self.requested.preparations[Role::AsSeen as usize] = None;
        let full = self.model.sources.full.as_mut();
        if let Some(full) = full.filter(|full| !full.shares_data_with(&prepared)) {
            let number = prepared.number;
            *full = prepared;
            if let Some(request) = &mut self.requested.preparations[Role::Own as usize] {
                request.number = number;
            }
        }
        self.begin_recording();
    }

    fn handle_rendering(&mut self, reply: RenderReply) -> Result<()> {
        match reply {
            RenderReply::Frame(frame) => self.show_frame(*frame),
            RenderReply::Drawing(what, part) => {
                self.model.drawing = Some((what, part)).filter(|_| !self.model.pacing.moving);
            }
            RenderReply::Saving(part) => {
                self.model.saving.iter_mut().for_each(|saving| saving.part = part);
            }
            RenderReply::TooSlow(quality, milliseconds) => {
                // The full time is unknown; twice the elapsed time is a guess that the next frame corrects.
                self.model.pacing.quality.record(quality, 2.0 * milliseconds, true);
            }
            RenderReply::Picture(drawn) => self.save(drawn),
            RenderReply::Samples(probe) => self.measure(*probe)?,
            RenderReply::Pixel(reading) => self.show_pixel(reading.map(|reading| *reading))?,
            RenderReply::Failed(e) if self.device.is_lost() => return Err(e),
            RenderReply::Failed(e) => {
                self.model.drawing = None;
                self.model.report(Concern::Picture, &e);
            }
        }
        Ok(())
    }

    fn show_frame(&mut self, mut frame: RenderedFrame) {
        if let Some(stops) = frame.exposure {
            self.model.expose(stops);
        }
        // A change of the display alone takes no time on the device and gives no information about frame times. Neither
        // do previews.
        let full = self.model.sources.full.as_ref().is_some_and(|full| full.number == frame.number);
        if frame.gpu_ms > 0.0 && full {
            self.model.pacing.history.push(frame.wall_ms, frame.pace);
            self.model.pacing.quality.record(frame.quality, frame.wall_ms, frame.first);
        }
        let former = self.model.frame.take();
        if let Some(former) = former.filter(|f| f.number == frame.number) {
            frame.cost = frame.cost.or(former.cost);
            frame.inset = frame.inset.or(former.inset);
        }
        // A newly drawn frame shows another value at the inspected pixel.
        if frame.gpu_ms > 0.0 {
            self.requested.pixel = None;
        }
        self.model.frame = Some(frame);
        self.schedule.has_frame = true;
        self.model.drawing = None;
        if self.model.pacing.continuous {
            self.request_frame(true);
        }
    }

    /// Shows the inspected pixel, and requests the reference for it.
    fn show_pixel(&mut self, reading: Option<Reading>) -> Result<()> {
        if !self.model.inspector.open {
            return Ok(());
        }
        if let Some(reading) = &reading {
            let reference = match self.threads.inspector.take() {
                Some(reference) => reference,
                None => {
                    let send = self.proxy.clone();
                    DirectionReference::new(move |number, answer| {
                        drop(send.send_event(Event::Inspector(number, answer)));
                    })?
                }
            };
            self.threads.inspector.insert(reference).ask(reading.clone());
        }
        self.model.inspector.show(reading);
        Ok(())
    }

    /// Starts measuring the error of `probe`.
    fn measure(&mut self, probe: ProbeTask) -> Result<()> {
        if probe.samples.radiance.is_empty() {
            self.model.say("the mesh covers no pixel: there is nothing to measure");
            return Ok(());
        }
        let send = self.proxy.clone();
        let reply = move |status| drop(send.send_event(Event::Probe(status)));
        self.threads.probe = Some(ErrorProbe::new(probe, reply)?);
        Ok(())
    }

    /// Saves the picture for the oldest waiting file, with its notes and the command that draws it.
    fn save(&mut self, drawn: Result<(Box<Picture>, Notes)>) {
        if self.saves.is_empty() {
            return;
        }
        let PendingSave { stem, with_exr, command, is_recorded } = self.saves.remove(0);
        self.model.saving.take_if(|_| self.saves.is_empty());
        let (as_png, as_exr) = (stem.with_extension("png"), stem.with_extension("exr"));
        let is_opaque = self.model.loaded.scene.display.is_opaque;
        let saved = drawn.and_then(|(mut picture, notes)| {
            picture.is_opaque |= is_opaque;
            let notes = Notes { command, ..notes };
            picture_file::write(&as_png, PictureFormat::Png, &picture, &notes)?;
            if with_exr { picture_file::write(&as_exr, PictureFormat::Exr, &picture, &notes) } else { Ok(()) }
        });
        match saved {
            Ok(()) if is_recorded => self.recorded(),
            Ok(()) => {
                let more = if with_exr { " and .exr" } else { "" };
                let path = std::path::absolute(&as_png).unwrap_or(as_png);
                self.model.succeed(Concern::Picture);
                self.model.saved = Some(format!("saved {}{more}", path.display()));
            }
            Err(e) => {
                if is_recorded {
                    self.stop_recording();
                }
                self.model.report(Concern::Picture, &e);
            }
        }
    }
}
