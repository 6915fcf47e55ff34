//! The parts of a frame, each on its own clock.

use super::Painter;
use crate::error::Result;
use crate::render::frame::{Shown, View, begin_shading, record_shading};
use crate::render::sampling::Sampling;
use crate::vk::queries::Timestamps;
use glam::DVec3;
use std::time::Instant;

/// Milliseconds of the parts of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTimes {
    /// Drawing the mesh, on the device.
    pub geometry: f64,
    /// Shading, on the device.
    pub shade: f64,
    /// Display, on the device.
    pub display: f64,
    /// Recording the commands, on the CPU.
    pub record: f64,
    /// From the call to the finished frame, on the wall.
    pub wall: f64,
}

impl PassTimes {
    /// All passes on the device.
    pub fn device(&self) -> f64 {
        self.geometry + self.shade + self.display
    }
}

/// The timestamps of frames that are timed.
pub struct Stopwatch {
    timestamps: Timestamps,
}

impl Painter {
    /// What [`Self::time`] needs.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn stopwatch(&self) -> Result<Stopwatch> {
        Ok(Stopwatch { timestamps: Timestamps::new(&self.device, 4)? })
    }

    /// Draws `view` as [`Self::draw`] does, and times its parts.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn time(
        &mut self,
        watch: &Stopwatch,
        view: &View,
        exposure: f64,
        background: DVec3,
    ) -> Result<PassTimes> {
        let start = Instant::now();
        let milliseconds = |since: Instant| since.elapsed().as_secs_f64() * 1e3;
        self.write(view, self.target.size(), &Sampling::ONE.sample(0))?;
        let parts = self.parts();
        let (target, stamps) = (&self.target, &watch.timestamps);
        let (find, objects, geometry) = (&self.find, &self.objects, &self.geometry);
        let shaded: Vec<_> =
            self.shadings.iter().map(|own| own.of(objects, self.lights_of(own, view))).collect();
        let mut times = PassTimes::default();
        self.commands.run(|record| {
            let begin = Instant::now();
            record.reset(stamps);
            record.timestamp(stamps, 0);
            find.record(record, geometry, objects);
            record.timestamp(stamps, 1);
            begin_shading(record, (geometry, target));
            record_shading(record, (geometry, target), &shaded, 0..parts);
            record.timestamp(stamps, 2);
            super::record_display(record, target, |record| {
                let shown = Shown::plain(exposure, background);
                self.display.record(record, (&self.geometry, target), &target.display, shown);
            });
            record.timestamp(stamps, 3);
            times.record = milliseconds(begin);
            Ok(())
        })?;
        times.wall = milliseconds(start);
        let passes = stamps.intervals()?;
        (times.geometry, times.shade, times.display) = (passes[0], passes[1], passes[2]);
        Ok(times)
    }
}
