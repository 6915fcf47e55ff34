//! Drawing of pictures: single samples, and means of samples drawn one after the other.

use super::{Content, DrawRequest, FinalStep, PassInput, Picture, Renderer};
use crate::error::Result;
use crate::render::frame::{Shown, View};
use crate::render::light_passes::{LightPass, SampleGroup, all_lights};
use crate::render::passes::accumulate::Accumulation;
use crate::render::sampling::{Sample, Sampling};
use crate::task::Task;
use glam::DVec3;

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

/// Picture to draw.
#[derive(Clone, Copy)]
pub struct PictureRequest<'a> {
    /// View.
    pub view: &'a View,
    /// Samples whose mean is the picture.
    pub sampling: Sampling,
    /// Size in the corner of the target, at most that of the target \[pixels\].
    pub size: [u32; 2],
    /// Settings of the display.
    pub shown: Shown,
}

impl<'a> PictureRequest<'a> {
    /// Returns the request of one sample at the pixel centres.
    pub const fn one_sample(view: &'a View, size: [u32; 2], shown: Shown) -> Self {
        Self { view, sampling: Sampling::ONE, size, shown }
    }
}

/// Progress of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureProgress {
    /// Number of samples in the displayed mean.
    pub samples: u32,
    /// Time of the device for the last of them \[ms\].
    pub milliseconds: f64,
}

impl Renderer {
    /// Draws the next samples of `request` and displays the mean so far: the first ones of another picture than the
    /// last, or those after the samples that are summed already. Once all are summed, only the display is drawn.
    ///
    /// Draws in pieces of about 15 milliseconds, between which other work gets the device, and reports to `task` before
    /// each piece. If the task is cancelled, nothing is added, the former display stays, and the next call draws the same
    /// samples.
    ///
    /// # Errors
    /// Fails if the device is lost or out of memory for the sum, or if the task is cancelled.
    pub fn draw(&mut self, request: &PictureRequest<'_>, task: &Task) -> Result<PictureProgress> {
        let PictureRequest { view, sampling, size, shown } = *request;
        if sampling.count <= 1 {
            let passes = self.shadings.bounded(all_lights(view.light_count(), sampling.sample(0)));
            let drawn = DrawRequest { view, size, passes: &passes };
            let times = self.draw_tiles(drawn, FinalStep::Display(shown), task)?;
            return Ok(PictureProgress { samples: 1, milliseconds: times.total() });
        }
        let before = self.samples_of(view, &sampling, size);
        if before >= sampling.count {
            self.shows = Content::Mean;
            self.display(size, shown)?;
            return Ok(PictureProgress { samples: before, milliseconds: 0.0 });
        }
        let group = view.schedule(&sampling).after(before);
        self.add(request, &group, Some(shown), task)
    }

    /// Draws all samples of `view`, displays them with the settings `shown` and reads the picture back. Reports the number
    /// of samples done to `task`.
    ///
    /// # Errors
    /// Fails if the device is lost or out of memory for the sum, or if the task is cancelled.
    pub fn render(&mut self, view: &View, sampling: &Sampling, shown: Shown, task: &Task) -> Result<Picture> {
        if sampling.count <= 1 {
            self.draw_one(view, &sampling.sample(0), shown, &task.unseen())?;
            task.report("samples", 1, 1)?;
            return self.read_back();
        }
        let request = PictureRequest { view, sampling: *sampling, size: self.target.size(), shown };
        self.summed = None;
        let schedule = view.schedule(sampling);
        let mut before = 0;
        for group in schedule.groups() {
            let shown = Some(shown).filter(|_| before + group.samples >= sampling.count);
            self.add(&request, &group, shown, &task.unseen())?;
            before += group.samples;
            task.report("samples", before as usize, sampling.count as usize)?;
        }
        self.read_back()
    }

    /// Draws a single `sample` of `view` under all lights and displays it with the settings `shown`.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn draw_sample(&mut self, view: &View, sample: &Sample, shown: Shown) -> Result<()> {
        self.draw_one(view, sample, shown, &Task::silent())
    }

    /// Draws as [`Self::draw_sample`]; `task` may cancel it.
    fn draw_one(&mut self, view: &View, sample: &Sample, shown: Shown, task: &Task) -> Result<()> {
        let passes = self.shadings.bounded(all_lights(view.light_count(), *sample));
        let drawn = DrawRequest { view, size: self.target.size(), passes: &passes };
        self.draw_tiles(drawn, FinalStep::Display(shown), task)?;
        Ok(())
    }

    /// Draws one sample of `view` at the pixel centres and displays it without tone mapping.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn draw_plain(&mut self, view: &View, exposure: f64, background: DVec3) -> Result<()> {
        self.draw_sample(view, &Sampling::ONE.sample(0), Shown::plain(exposure, background))
    }

    /// Draws as [`Self::draw_plain`] and reads the picture back.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn render_plain(&mut self, view: &View, exposure: f64, background: DVec3) -> Result<Picture> {
        self.draw_plain(view, exposure, background)?;
        self.read_back()
    }

    /// Adds the next `group` of `request` to the sum. Displays the mean if `shown` is given.
    fn add(
        &mut self,
        request: &PictureRequest<'_>,
        group: &SampleGroup,
        shown: Option<Shown>,
        task: &Task,
    ) -> Result<PictureProgress> {
        let PictureRequest { view, sampling, size, .. } = *request;
        if self.accumulation.is_none() {
            self.accumulation = Some(Accumulation::new(&self.device, &self.target)?);
            self.bind_background();
        }
        let passes = self.shadings.bounded(group.passes.clone());
        if let Some(accumulation) = &mut self.accumulation {
            accumulation.make_room(&self.device, passes.len())?;
        }
        let before = self.samples_of(view, &sampling, size);
        if before == 0 {
            // The sum is invalid until its first group is added.
            self.invalidate();
        }
        let drawn = DrawRequest { view, size, passes: &passes };
        let finish = FinalStep::Add { before, samples: group.samples, shown };
        let times = self.draw_tiles(drawn, finish, task)?;
        let samples = before + group.samples;
        match &mut self.summed {
            Some(summed) => summed.samples = samples,
            none => *none = Some(Summed { view: view.clone(), sampling, size, samples }),
        }
        Ok(PictureProgress { samples, milliseconds: times.total() })
    }

    /// Returns the number of samples of `view` by `sampling` with `size` pixels in the sum.
    fn samples_of(&self, view: &View, sampling: &Sampling, size: [u32; 2]) -> u32 {
        let same = |s: &&Summed| (&s.view, &s.sampling, s.size) == (view, sampling, size);
        self.summed.as_ref().filter(same).map_or(0, |summed| summed.samples)
    }
}
