//! The display of what was drawn: one sample, or the mean of several, before a colour or before the surroundings.

use super::Written;
use crate::render::accumulate::Accumulation;
use crate::render::around::AroundPass;
use crate::render::frame::{DisplayPass, Shown};
use crate::render::target::{Geometry, Target};
use crate::vk::commands::Recorder;
use crate::vk::descriptors::Descriptors;

/// What the display of a picture takes.
pub(super) struct Display<'a> {
    geometry: &'a Geometry,
    target: &'a Target,
    pass: &'a DisplayPass,
    /// Where the picture shows its surroundings.
    around: Option<&'a AroundPass>,
    frame: &'a Descriptors,
}

impl<'a> Display<'a> {
    /// Of what was `written`: `around` displays its surroundings, where it shows them.
    pub fn new(
        (geometry, target): (&'a Geometry, &'a Target),
        pass: &'a DisplayPass,
        around: Option<&'a AroundPass>,
        frame: &'a Descriptors,
        written: Option<&Written>,
    ) -> Self {
        let around = around.filter(|_| written.is_some_and(|written| written.view.background().is_some()));
        Self { geometry, target, pass, around, frame }
    }

    /// Records the display of the one sample that the target holds.
    pub fn sample(&self, record: &Recorder<'_>, shown: Shown) {
        let (geometry, into) = (self.geometry, &self.target.display);
        self.pass.record(record, (geometry, self.target), into, shown);
        if let Some(around) = self.around {
            around.record(record, geometry, into, (self.frame, shown));
        }
    }

    /// Records the display of the mean of the `samples` samples that are summed.
    pub fn mean(&self, record: &Recorder<'_>, sum: &Accumulation, samples: u32, shown: Shown) {
        let into = &self.target.display;
        match self.around {
            Some(around) => around.record_mean(record, into, self.frame, (samples, shown)),
            None => sum.record_display(record, into, samples, shown),
        }
    }
}
