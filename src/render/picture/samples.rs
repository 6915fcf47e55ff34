//! Pictures that are the mean of samples, one sample after the other.

use super::{Content, Drawn, Finish, Painter, Picture, Written};
use crate::error::Result;
use crate::render::accumulate::Accumulation;
use crate::render::frame::{Shown, View};
use crate::render::light_passes::{LightPass, SampleGroup};
use crate::render::sampling::Sampling;

/// What the samples in a sum are of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Summed {
    pub view: View,
    pub sampling: Sampling,
    pub size: [u32; 2],
    /// Samples in the sum, from the first on.
    pub samples: u32,
}

impl Summed {
    /// Its first pass, the `Frame` block of which has all that the display of the mean asks for.
    pub fn first(&self) -> Written {
        Written {
            view: self.view.clone(),
            pass: LightPass::of_all(0, self.sampling.sample(0)),
            size: self.size,
        }
    }
}

impl Painter {
    /// Draws all samples of `view`, shown as `shown` says, and reads the picture back. Tells `progress` how many are done; what it returns
    /// as an error ends the picture.
    ///
    /// # Errors
    /// Where the device is lost or has no room for the sum, and what `progress` returns.
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

    /// Adds the next group of samples of `view`, with `size` pixels in the corner of the pictures, to those that were drawn of the same view, sampling
    /// and size; where there are none, the first. The display shows the mean so far. Shades in tiles as [`Self::draw_while`] does. Returns
    /// the number of samples in the mean, or `None` where `go_on` said no: then nothing is added, and the next call draws it anew. Once all samples are there, nothing
    /// is drawn but the display.
    ///
    /// # Errors
    /// Where the device is lost or has no room for the sum.
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

    /// Adds the next `group` as [`Self::add_samples`] does. The display keeps what it has unless the mean is to be `shown`.
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
            self.point_around();
        }
        if let Some(accumulation) = &mut self.accumulation {
            accumulation.make_room(&self.device, group.passes.len())?;
        }
        let before = self.samples_of(view, sampling, size);
        if before == 0 {
            // Until its first samples are there, the sum is of nothing.
            self.forget();
        }
        let drawn = Drawn { view, size, passes: &group.passes };
        let finish = Finish::Add { before, samples: group.samples, shown };
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

    /// How many samples of `view` by `sampling` with `size` pixels are summed.
    pub fn samples_of(&self, view: &View, sampling: &Sampling, size: [u32; 2]) -> u32 {
        let same = |s: &&Summed| (&s.view, &s.sampling, s.size) == (view, sampling, size);
        self.summed.as_ref().filter(same).map_or(0, |summed| summed.samples)
    }
}
