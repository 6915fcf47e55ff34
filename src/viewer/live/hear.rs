//! What the threads answer.

use super::{Live, Saving};
use crate::error::Result;
use crate::picture_file::{self, Format, Notes};
use crate::render::picture::Picture;
use crate::viewer::app::Event;
use crate::viewer::judge::Judge;
use crate::viewer::pace::Degree;
use crate::viewer::settings::Settings;
use crate::viewer::studio::Word;
use crate::viewer::worker::{Report, Role};

impl Live {
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

    pub(super) fn worked(&mut self, report: Report) {
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
                        model.lighter = [None, None];
                        for role in [Role::Coarse, Role::FewerWavelengths] {
                            self.asked[role as usize] = None;
                        }
                        model.pace.doubt();
                        model.message = model.message.take().filter(|m| !m.bad);
                    }
                    Role::Other => model.judge = Some(prepared),
                    Role::Coarse => model.lighter[0] = Some(prepared),
                    Role::FewerWavelengths => model.lighter[1] = Some(prepared),
                }
            }
            Report::Failed(role, error) => {
                model.progress[role as usize] = None;
                // Without lighter spectra a moving picture has its resolution to give.
                if matches!(role, Role::Own | Role::Other) {
                    model.complain(&error);
                }
            }
        }
    }

    pub(super) fn drawn(&mut self, word: Word) -> Result<()> {
        match word {
            Word::Drawn(mut exhibit) => {
                // A display that was changed alone says nothing of frames.
                if exhibit.gpu > 0.0 {
                    self.model.history.push(exhibit.wall);
                    self.model.pace.took(exhibit.rung, exhibit.wall, exhibit.first);
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
            Word::TooSlow(rung, milliseconds) => self.model.pace.took(rung, 2.0 * milliseconds, true),
            Word::NoRoom(degree) => {
                // Resolution is left to give.
                self.model.lighter[usize::from(degree == Degree::FewerWavelengths)] = None;
            }
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

    pub(super) fn save(&mut self, picture: &Picture) {
        if self.saving.is_empty() {
            return;
        }
        let Saving { stem, with_exr, command } = self.saving.remove(0);
        let (as_png, as_exr) = (stem.with_extension("png"), stem.with_extension("exr"));
        let notes = Notes { command, ..Notes::default() };
        let write = |path, format| picture_file::write(path, format, picture, &notes);
        let saved = write(&as_png, Format::Png)
            .and_then(|()| if with_exr { write(&as_exr, Format::Exr) } else { Ok(()) });
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
