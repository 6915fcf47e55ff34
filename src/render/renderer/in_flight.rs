//! Submissions of a picture: while the device works on one, the next is recorded.

use super::timing::DrawTimes;
use crate::error::Result;
use crate::vk::commands::{Commands, Recorder};
use crate::vk::device::Device;
use crate::vk::queries::Timestamps;
use std::sync::Arc;

/// Submissions that the device has at a time: one that it works on, and one that waits.
const IN_FLIGHT: usize = 2;
/// Timestamps of a submission, between its steps.
const STAMPS: u32 = 4;

/// Command buffers of a picture.
pub(super) struct InFlight {
    submissions: Vec<Submission>,
    /// Number of the next submission, the oldest.
    next: usize,
}

/// Command buffer with its timestamps.
struct Submission {
    commands: Commands,
    timestamps: Timestamps,
    /// Pixels of the submission, until its times are read.
    pixels: Option<f64>,
}

/// Finished submission.
#[derive(Clone, Copy, Debug)]
pub(super) struct Finished {
    /// Pixels that it shaded; a part of a sum counts as its fraction.
    pub pixels: f64,
    /// Times of its steps.
    pub times: DrawTimes,
}

impl Submission {
    /// Waits for the submission, if there is one, and returns it.
    fn wait(&mut self) -> Result<Option<Finished>> {
        self.commands.wait()?;
        let Some(pixels) = self.pixels.take() else { return Ok(None) };
        let times = self.timestamps.intervals()?;
        Ok(Some(Finished {
            pixels,
            times: DrawTimes { geometry: times[0], shading: times[1], finish: times[2] },
        }))
    }
}

impl InFlight {
    /// Makes the command buffers.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>) -> Result<Self> {
        let submission = |_| {
            let (commands, timestamps) = (Commands::new(device, "frame")?, Timestamps::new(device, STAMPS)?);
            Ok(Submission { commands, timestamps, pixels: None })
        };
        Ok(Self { submissions: (0..IN_FLIGHT).map(submission).collect::<Result<_>>()?, next: 0 })
    }

    /// Records with `record` and submits work that shades so many `pixels`. Returns the submission before the last one,
    /// which has finished, if it belongs to the same picture. The resources used must live, and stay as they are, until
    /// [`Self::finish`].
    ///
    /// `record` writes the timestamps 0 to 3: before the geometry, after it, after the shading and at the end.
    ///
    /// # Errors
    /// Fails with the error of `record`, or if the device is lost.
    pub fn submit(
        &mut self,
        pixels: f64,
        record: impl FnOnce(&Recorder<'_>, &Timestamps),
    ) -> Result<Option<Finished>> {
        let submission = &mut self.submissions[self.next];
        let finished = submission.wait()?;
        let timestamps = &submission.timestamps;
        let recorded = |recorder: &Recorder<'_>| {
            recorder.reset(timestamps);
            record(recorder, timestamps);
            Ok(())
        };
        submission.commands.start(recorded, None, None)?;
        submission.pixels = Some(pixels);
        self.next = (self.next + 1) % IN_FLIGHT;
        Ok(finished)
    }

    /// Waits for all submissions, even if one fails. Returns those that [`Self::submit`] has not returned, in their order.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn finish(&mut self) -> Result<Vec<Finished>> {
        let (earlier, later) = self.submissions.split_at_mut(self.next);
        let waited: Vec<_> = later.iter_mut().chain(earlier).map(Submission::wait).collect();
        waited.into_iter().filter_map(Result::transpose).collect()
    }
}
