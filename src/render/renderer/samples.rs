//! Pictures that are the mean of samples, drawn one after the other.

use super::{Content, DrawRequest, FinalStep, PassInput, Picture, Renderer};
use crate::error::Result;
use crate::render::frame::{Shown, View};
use crate::render::light_passes::{LightPass, SampleGroup};
use crate::render::passes::accumulate::Accumulation;
use crate::render::sampling::Sampling;

/// Settings of the samples in a sum.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Summed {
    pub view: View,
    pub sampling: Sampling,
    pub size: [u32; 2],
    /// Number of samples in the sum, counted from the first.
    pub samples: u32,
}

impl Summed {
    /// Returns the first pass, whose `Frame` block suffices for displaying the mean.
    pub fn first(&self) -> PassInput {
        PassInput {
            view: self.view.clone(),
            pass: LightPass::of_all(0, self.sampling.sample(0)),
            size: self.size,
        }
    }
}

impl Renderer {
    /// Draws all samples of `view`, displays them with the settings `shown` and reads the picture back. Calls
    /// `progress` with the number of samples done; an error it returns ends the picture.
    ///
    /// # Errors
    /// Fails if the device is lost or out of memory for the sum, or with the error of `progress`.
    pub fn paint_samples(
        &mut self,
        view: &View,
        sampling: &Sampling,
        shown: Shown,
        progress: &mut dyn FnMut(u32) -> Result<()>,
    ) -> Result<Picture> {
        if sampling.count <= 1 {
            self.draw_sample(view, &sampling.sample(0), shown)?;
            return self.picture();
        }
        let size = self.target.size();
        self.summed = None;
        let schedule = view.schedule(sampling);
        let mut before = 0;
        for group in schedule.groups() {
            let shown = Some(shown).filter(|_| before + group.samples >= sampling.count);
            self.add(view, sampling, &group, shown, size, &mut |_| true)?;
            before += group.samples;
            progress(before)?;
        }
        self.picture()
    }

    /// Adds the next group of samples of `view`, with `size` pixels in the corner of the target, to the sum of the same
    /// view, sampling and size, or starts a new sum. Displays the mean so far. Shades in tiles as [`Self::draw_while`]
    /// does. Returns the number of samples in the mean, or `None` if `go_on` returned false: then nothing is added, and
    /// the next call draws the group again. Once all samples are summed, only the display is drawn.
    ///
    /// # Errors
    /// Fails if the device is lost or out of memory for the sum.
    pub fn add_samples(
        &mut self,
        view: &View,
        sampling: &Sampling,
        shown: Shown,
        size: [u32; 2],
        go_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Option<u32>> {
        let before = self.samples_of(view, sampling, size);
        if before >= sampling.count {
            self.shows = Content::Mean;
            self.display_again(size, shown)?;
            return Ok(Some(before));
        }
        let group = view.schedule(sampling).after(before);
        self.add(view, sampling, &group, Some(shown), size, go_on)
    }

    /// Adds the next `group` as [`Self::add_samples`] does. Displays the mean if `shown` is given.
    fn add(
        &mut self,
        view: &View,
        sampling: &Sampling,
        group: &SampleGroup,
        shown: Option<Shown>,
        size: [u32; 2],
        go_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Option<u32>> {
        if self.accumulation.is_none() {
            self.accumulation = Some(Accumulation::new(&self.device, &self.target)?);
            self.bind_background();
        }
        let passes = self.shadings.bounded(group.passes.clone());
        if let Some(accumulation) = &mut self.accumulation {
            accumulation.make_room(&self.device, passes.len())?;
        }
        let before = self.samples_of(view, sampling, size);
        if before == 0 {
            // The sum is invalid until its first group is added.
            self.invalidate();
        }
        let drawn = DrawRequest { view, size, passes: &passes };
        let finish = FinalStep::Add { before, samples: group.samples, shown };
        if self.draw_tiles(drawn, finish, go_on)?.is_none() {
            return Ok(None);
        }
        let samples = before + group.samples;
        match &mut self.summed {
            Some(summed) => summed.samples = samples,
            none => *none = Some(Summed { view: view.clone(), sampling: *sampling, size, samples }),
        }
        Ok(Some(samples))
    }

    /// Returns the number of samples of `view` by `sampling` with `size` pixels in the sum.
    pub fn samples_of(&self, view: &View, sampling: &Sampling, size: [u32; 2]) -> u32 {
        let same = |s: &&Summed| (&s.view, &s.sampling, s.size) == (view, sampling, size);
        self.summed.as_ref().filter(same).map_or(0, |summed| summed.samples)
    }
}
