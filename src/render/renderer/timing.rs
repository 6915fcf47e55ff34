//! Times of the parts of a frame, measured separately.

use super::Renderer;
use crate::error::Result;
use crate::render::frame::{Shown, View};
use crate::render::light_passes::{LightPass, all_lights};
use crate::render::passes::shade;
use crate::render::sampling::Sampling;
use crate::vk::queries::Timestamps;
use glam::DVec3;
use std::time::Instant;

/// Times of the parts of one frame \[ms\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTimes {
    /// Geometry pass, on the device.
    pub geometry: f64,
    /// Shading pass, on the device.
    pub shade: f64,
    /// Display pass, on the device.
    pub display: f64,
    /// Recording the commands, on the CPU.
    pub record: f64,
    /// Wall time from the call to the finished frame.
    pub wall: f64,
}

impl PassTimes {
    /// Returns the device time of all passes.
    pub fn device(&self) -> f64 {
        self.geometry + self.shade + self.display
    }
}

/// Device times of a picture or of a part of it \[ms\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawTimes {
    /// Shadow map and G-buffer.
    pub geometry: f64,
    /// Shading pass.
    pub shading: f64,
    /// Addition to other samples, and display.
    pub finish: f64,
}

impl DrawTimes {
    /// Returns the sum of all times.
    pub fn total(&self) -> f64 {
        self.geometry + self.shading + self.finish
    }

    pub(super) fn add(&mut self, other: Self) {
        self.geometry += other.geometry;
        self.shading += other.shading;
        self.finish += other.finish;
    }
}

/// Timestamp queries of timed frames.
pub struct Stopwatch {
    timestamps: Timestamps,
}

impl Renderer {
    /// Makes the queries that [`Self::time`] needs.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn stopwatch(&self) -> Result<Stopwatch> {
        Ok(Stopwatch { timestamps: Timestamps::new(&self.device, 4)? })
    }

    /// Draws `view` as [`Self::draw`] does, its G-buffer anew, and measures its parts.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn time(
        &mut self,
        watch: &Stopwatch,
        view: &View,
        exposure: f64,
        background: DVec3,
    ) -> Result<PassTimes> {
        let start = Instant::now();
        let mut times = PassTimes::default();
        self.invalidate();
        let passes = self.shadings.bounded(all_lights(view.light_count(), Sampling::ONE.sample(0)));
        for (number, pass) in passes.iter().enumerate() {
            self.write(view, self.target.size(), pass)?;
            let is_last = number + 1 == passes.len();
            let shown = is_last.then(|| Shown::plain(exposure, background));
            self.time_pass(&watch.timestamps, (view, pass), shown, &mut times)?;
        }
        times.wall = milliseconds(start);
        Ok(times)
    }

    /// Draws a `pass` of `view`, whose `Frame` block is written, displays it if `shown` is given, and adds the times of
    /// its parts to `times`.
    fn time_pass(
        &mut self,
        stamps: &Timestamps,
        (view, pass): (&View, &LightPass),
        shown: Option<Shown>,
        times: &mut PassTimes,
    ) -> Result<()> {
        let parts = self.shadings.parts(view, pass);
        let (target, geometry_pass, gbuffer, objects) =
            (&self.target, &self.geometry_pass, &self.gbuffer, &self.objects);
        let shaded = self.shadings.draws(objects, view, pass);
        self.commands.run(|record| {
            let begin = Instant::now();
            record.reset(stamps);
            record.timestamp(stamps, 0);
            if let Some(shadow_pass) = &self.shadow_pass {
                shadow_pass.record(record, objects);
            }
            if pass.is_first {
                geometry_pass.record(record, gbuffer, objects);
            }
            record.timestamp(stamps, 1);
            if pass.is_first {
                shade::begin(record, target);
            }
            shade::record(record, (gbuffer, target), &shaded, 0..parts, pass.is_first);
            record.timestamp(stamps, 2);
            if let Some(shown) = shown {
                super::record_display(record, target, |record| {
                    self.display.record(record, (gbuffer, target), &target.display, shown);
                });
            }
            record.timestamp(stamps, 3);
            times.record += milliseconds(begin);
            Ok(())
        })?;
        let passes = stamps.intervals()?;
        times.geometry += passes[0];
        times.shade += passes[1];
        times.display += passes[2];
        Ok(())
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
