//! Pictures that are the mean of samples, one sample after the other.

use super::{Content, Finish, Painter, Picture, Written};
use crate::error::Result;
use crate::render::accumulate::Accumulation;
use crate::render::frame::{Shown, View};
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
    /// The sample that was added last.
    pub fn last(&self) -> Written {
        let sample = self.sampling.sample(self.samples.saturating_sub(1));
        Written { view: self.view.clone(), sample, size: self.size }
    }
}

/// What a picture has after a sample was added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Added {
    /// Samples that the picture is the mean of.
    pub samples: u32,
    /// Milliseconds that the device took for the sample: geometry and shading; addition and display.
    pub times: [f64; 2],
}

impl Painter {
    /// Draws all samples of `view`, shown as `shown` says, and reads the picture back. Tells `progress` after each how many are done; what it
    /// returns as an error ends the picture.
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
        for before in 0..sampling.count {
            let is_last = before + 1 == sampling.count;
            self.add(view, sampling, is_last.then_some(shown), size, &mut |_| true)?;
            progress(before + 1)?;
        }
        self.picture()
    }

    /// Adds the next sample of `view`, with `size` pixels in the corner of the pictures, to those that were drawn of the same view, sampling
    /// and size; where there are none, the first. The display shows the mean so far. Shades in tiles as [`Self::draw_while`] does;
    /// `None` where `go_on` said no: then the sample is not added, and the next call draws it anew. Once all samples are there, nothing
    /// is drawn but the display.
    ///
    /// # Errors
    /// Where the device is lost or has no room for the sum.
    pub fn add_sample(
        &mut self,
        view: &View,
        sampling: &Sampling,
        shown: Shown,
        size: [u32; 2],
        go_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Option<Added>> {
        let before = self.samples_of(view, sampling, size);
        if before >= sampling.count {
            self.shows = Content::Mean;
            self.display_again(size, shown)?;
            return Ok(Some(Added { samples: before, times: [0.0; 2] }));
        }
        self.add(view, sampling, Some(shown), size, go_on)
    }

    /// [`Self::add_sample`] where samples are left to add. The display keeps what it has unless the mean is to be `shown`.
    fn add(
        &mut self,
        view: &View,
        sampling: &Sampling,
        shown: Option<Shown>,
        size: [u32; 2],
        go_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Option<Added>> {
        if self.accumulation.is_none() {
            self.accumulation =
                Some(Accumulation::new(&self.device, &self.target, self.geometry.settings.depth_format())?);
            self.point_around();
        }
        let before = self.samples_of(view, sampling, size);
        if before == 0 {
            // Until its first sample is there, the sum is of nothing.
            self.forget();
        }
        self.write(view, size, &sampling.sample(before))?;
        let Some(times) = self.submit_tiles(size, Finish::Add { before, shown }, go_on)? else {
            return Ok(None);
        };
        let samples = before + 1;
        match &mut self.summed {
            Some(summed) => summed.samples = samples,
            none => *none = Some(Summed { view: view.clone(), sampling: *sampling, size, samples }),
        }
        Ok(Some(Added { samples, times }))
    }

    /// How many samples of `view` by `sampling` with `size` pixels are summed.
    pub fn samples_of(&self, view: &View, sampling: &Sampling, size: [u32; 2]) -> u32 {
        let same = |s: &&Summed| (&s.view, &s.sampling, s.size) == (view, sampling, size);
        self.summed.as_ref().filter(same).map_or(0, |summed| summed.samples)
    }
}
