//! Recording of a turntable: pictures of a whole turn of the camera, one file each.

use super::{PendingSave, ViewerWindow};
use crate::optics::coherence::Windows;
use crate::output;
use crate::render::sequence::{Motion, Sequence};
use crate::viewer::frame::FrameRequest;
use crate::viewer::job_queue::Job;
use crate::viewer::model::{Concern, TaskProgress};
use crate::viewer::save;
use crate::viewer::start::Output;
use std::path::{Path, PathBuf};

/// Turntable that is being recorded.
pub(super) struct Recording {
    sequence: Sequence,
    // Path of the numbered files, without the number.
    file: PathBuf,
    command: String,
    // Picture number 0, once there is a source that is fine enough for all pictures.
    first: Option<FrameRequest>,
    // Number of finished pictures.
    done: u32,
}

impl ViewerWindow {
    /// Records a turntable, or stops the recording.
    pub(super) fn record(&mut self) {
        if self.recording.is_some() {
            return self.stop_recording();
        }
        let Some(frame) = self.own_frame() else {
            return self.model.say("a turntable is recorded once the picture has its colours");
        };
        let folder = save::free_folder(Path::new(""));
        if let Err(e) = std::fs::create_dir(&folder) {
            return self.model.report(Concern::Picture, &output::write_failed(&folder, e));
        }
        let count = self.model.turntable.max(1);
        let sequence = Sequence { motion: Motion::Turntable, count, frames: 0..count };
        let views = sequence.typical_views(&frame.view);
        let file = folder.join("turn.png");
        let name = file.to_string_lossy().into_owned();
        let output = Output { size: frame.size, file: &name, turntable: Some(count) };
        let command = self.command_line(&output);
        self.model.say(format!("recording into {}", folder.display()));
        self.model.recording = Some(TaskProgress { done: 0, of: count as usize });
        self.recording = Some(Recording { sequence, file, command, first: None, done: 0 });
        let wanted = self.model.settings.clone();
        if wanted.optics.settled().windows == Windows::All {
            self.request_for_views(&wanted, views);
        } else {
            self.begin_recording();
        }
    }

    /// Draws the first picture of a recording that waits for its source.
    pub(super) fn begin_recording(&mut self) {
        let frame = self.own_frame();
        let waiting = self.recording.as_mut().filter(|recording| recording.first.is_none());
        if let Some((recording, frame)) = waiting.zip(frame) {
            recording.first = Some(frame);
            self.record_next();
        }
    }

    /// Requests the next picture.
    fn record_next(&mut self) {
        let Some(recording) = &self.recording else { return };
        let Some(first) = &recording.first else { return };
        let Recording { sequence, file, command, done, .. } = recording;
        let request = FrameRequest { view: sequence.view(&first.view, *done), ..first.clone() };
        let stem = sequence.file(file, *done).with_extension("");
        let save = PendingSave { stem, with_exr: false, command: command.clone(), is_recorded: true };
        self.saves.push(save);
        self.threads.render.submit(Job::Picture(request));
        self.window.request_redraw();
    }

    /// Requests the next picture after one is saved.
    pub(super) fn recorded(&mut self) {
        let Some(recording) = &mut self.recording else { return };
        recording.done += 1;
        let (done, count) = (recording.done, recording.sequence.count);
        self.model.recording = Some(TaskProgress { done: done as usize, of: count as usize });
        if done == count {
            self.stop_recording();
        } else {
            self.record_next();
        }
    }

    /// Ends a recording and keeps the finished pictures.
    pub(super) fn stop_recording(&mut self) {
        self.model.recording = None;
        let Some(Recording { sequence, file, done, .. }) = self.recording.take() else { return };
        // The source may be finer than the present view needs.
        self.requested.seen = None;
        let folder = file.parent().unwrap_or(&file);
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        self.model.say(format!("recorded {done} of {} pictures in {}", sequence.count, folder.display()));
        self.window.request_redraw();
    }
}
