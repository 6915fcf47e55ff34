//! Display of one sample or of the mean of several, over a colour or over the surroundings.

use super::PassInput;
use crate::render::frame::Shown;
use crate::render::gbuffer::GBuffer;
use crate::render::passes::accumulate::Accumulation;
use crate::render::passes::background::BackgroundPass;
use crate::render::passes::display::DisplayPass;
use crate::render::target::Target;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::Descriptors;

/// Inputs of the display of a picture.
pub(super) struct Display<'a> {
    gbuffer: &'a GBuffer,
    target: &'a Target,
    pass: &'a DisplayPass,
    /// Present if the picture shows its surroundings.
    background: Option<&'a BackgroundPass>,
    frame: &'a Descriptors,
}

impl<'a> Display<'a> {
    /// Makes the display of the picture in `input`; `background` is used if the picture shows its surroundings.
    pub fn new(
        (gbuffer, target): (&'a GBuffer, &'a Target),
        pass: &'a DisplayPass,
        background: Option<&'a BackgroundPass>,
        frame: &'a Descriptors,
        input: Option<&PassInput>,
    ) -> Self {
        let background = background.filter(|_| input.is_some_and(|input| input.view.background().is_some()));
        Self { gbuffer, target, pass, background, frame }
    }

    /// Records the display of the sample in the target.
    pub fn sample(&self, record: &Recorder<'_>, shown: Shown) {
        let (gbuffer, into) = (self.gbuffer, &self.target.display);
        self.pass.record(record, (gbuffer, self.target), into, shown);
        if let Some(background) = self.background {
            background.record(record, gbuffer, into, (self.frame, shown));
        }
    }

    /// Records the display of the mean of the `samples` summed samples.
    pub fn mean(&self, record: &Recorder<'_>, sum: &Accumulation, samples: u32, shown: Shown) {
        let into = &self.target.display;
        match self.background {
            Some(background) => background.record_mean(record, into, self.frame, (samples, shown)),
            None => sum.record_display(record, into, samples, shown),
        }
    }
}
