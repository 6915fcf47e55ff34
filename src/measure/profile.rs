//! Frame times on the device and in total, with their spread as a measure of reliability.

use crate::error::Result;
use crate::render::frame::View;
use crate::render::renderer::Renderer;
use crate::render::renderer::timing::PassTimes;
use crate::task::Task;
use glam::DVec3;
use serde::Serialize;
use std::time::Instant;

/// Minimum number of frames drawn before the first one is counted. They compile shaders and touch memory for the first
/// time.
const WARM_UP: usize = 3;
/// Time for which frames of a GPU are drawn before the first one is counted \[s\]. An idle GPU has a low clock at
/// first: an NVIDIA H100 draws at a fifth of its speed for about half a second.
const RAISING_THE_CLOCK: f64 = 1.0;
/// Samples per pixel of the probe, enough to make its start-up time negligible.
const PROBE_SAMPLES: u32 = 64;
/// Minimum number of frames, whatever their duration.
const FEWEST: usize = 3;
/// Largest [`Times::spread`] of a quiet machine; a larger one means that other programs disturbed the measurement.
pub const NOISY: f64 = 1.15;

/// Order statistics of a series of times \[ms\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeSummary {
    /// Smallest.
    pub min: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

impl TimeSummary {
    /// Summarises a series; all zero for an empty one.
    pub fn of(series: &[f64]) -> Self {
        let mut sorted = series.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            sorted.get((share * (sorted.len().max(1) - 1) as f64).round() as usize).copied().unwrap_or(0.0)
        };
        Self { min: at(0.0), p50: at(0.5), p95: at(0.95), max: at(1.0) }
    }
}

/// Times of a series of frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Times {
    /// Drawing the mesh, on the device \[ms\].
    pub geometry: TimeSummary,
    /// Shading on the device \[ms\].
    pub shade: TimeSummary,
    /// Display on the device \[ms\].
    pub display: TimeSummary,
    /// All passes \[ms\].
    pub gpu: TimeSummary,
    /// Recording the commands, on the CPU \[ms\].
    pub record: TimeSummary,
    /// Elapsed time from the call to the finished frame \[ms\].
    pub frame: TimeSummary,
    /// Largest over smallest of the medians of three parts of the series: 1 on a quiet machine.
    pub spread: f64,
}

/// Bilinear texture samples per second of a device that does nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Rate if neighbouring pixels read neighbouring texels.
    pub coherent: f64,
    /// Rate if every pixel reads at a random place.
    pub scattered: f64,
}

/// Draws `view` `frames` times with `renderer`, after some warm-up frames, and measures the times. Stops after `seconds`
/// if there are at least three frames. Calls `progress(done, of)` before each frame; an error it returns ends the
/// measurement.
///
/// # Errors
/// Fails if the device is lost, or if the task is cancelled.
pub fn measure(
    renderer: &mut Renderer,
    view: &View,
    frames: usize,
    seconds: f64,
    task: &Task,
) -> Result<Times> {
    let watch = renderer.stopwatch()?;
    let mut series: Vec<PassTimes> = Vec::new();
    let warm_up = if renderer.device().candidate().is_software() { 0.0 } else { RAISING_THE_CLOCK };
    let begin = Instant::now();
    let elapsed = || begin.elapsed().as_secs_f64();
    let mut drawn = 0;
    while series.len() < frames && !(series.len() >= FEWEST && elapsed() > warm_up + seconds) {
        task.report("frames", series.len(), frames)?;
        let is_warm = drawn >= WARM_UP && elapsed() >= warm_up;
        let times = renderer.time(&watch, view, 0.0, DVec3::ZERO)?;
        drawn += 1;
        // A frame that takes a large part of the time is counted even if it is the first.
        if is_warm || times.wall * 1e-3 > seconds / 3.0 {
            series.push(times);
        }
    }
    let of = |part: &dyn Fn(&PassTimes) -> f64| TimeSummary::of(&series.iter().map(part).collect::<Vec<_>>());
    let medians: Vec<f64> = series
        .chunks(series.len().div_ceil(3).max(1))
        .map(|part| TimeSummary::of(&part.iter().map(|t| t.wall).collect::<Vec<_>>()).p50)
        .collect();
    let ends = TimeSummary::of(&medians);
    Ok(Times {
        geometry: of(&|t| t.geometry),
        shade: of(&|t| t.shade),
        display: of(&|t| t.display),
        gpu: of(&PassTimes::device),
        record: of(&|t| t.record),
        frame: of(&|t| t.wall),
        spread: ends.max / ends.min.max(f64::MIN_POSITIVE),
    })
}

/// Measures the rates at which the device samples `renderer`'s texture, for pictures of `pixels` pixels.
///
/// # Errors
/// Fails if the device is lost.
pub fn rates(renderer: &mut Renderer, pixels: usize) -> Result<Rates> {
    let mut rate = |scattered| {
        let milliseconds = renderer.probe(PROBE_SAMPLES, scattered)?;
        Ok(pixels as f64 * f64::from(PROBE_SAMPLES) / (milliseconds * 1e-3))
    };
    Ok(Rates { coherent: rate(false)?, scattered: rate(true)? })
}

/// Limiting factor of the frame rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Bound {
    /// Reading the layers.
    Samples,
    /// The arithmetic between the reads.
    Arithmetic,
    /// Drawing mesh and display, a few reads and writes per pixel.
    Fill,
    /// Recording, submitting and waiting.
    Cpu,
}

impl Bound {
    /// Returns the description for reports.
    pub fn description(self) -> &'static str {
        match self {
            Self::Samples => "reading the layers",
            Self::Arithmetic => "the arithmetic between the reads",
            Self::Fill => "drawing the mesh and the display, not the shading",
            Self::Cpu => "the CPU: recording, submitting, waiting",
        }
    }

    /// Returns the limiting factor of frames that take `times` for `samples` reads, on a device that reads at `rates`.
    pub fn of(times: &Times, samples: usize, rates: &Rates) -> Self {
        /// Smallest fraction of the shading time that the reads alone must take for the frame to be bound by them. The
        /// rate is the geometric mean of the probes, because the reads are neither as coherent nor as scattered.
        const READING: f64 = 0.5;
        let host = times.frame.p50 - times.gpu.p50;
        if host > times.gpu.p50 {
            return Self::Cpu;
        }
        if times.geometry.p50 + times.display.p50 > times.shade.p50 {
            return Self::Fill;
        }
        let between = (rates.coherent * rates.scattered).sqrt();
        if samples as f64 / between > READING * times.shade.p50 * 1e-3 {
            Self::Samples
        } else {
            Self::Arithmetic
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_has_the_order_statistics_of_its_series() {
        let s = TimeSummary::of(&[5.0, 1.0, 4.0, 2.0, 3.0]);
        assert_eq!((s.min, s.p50, s.max), (1.0, 3.0, 5.0));
        assert_eq!(TimeSummary::of(&[]).max, 0.0);
    }

    #[test]
    fn what_bounds_a_frame_follows_from_its_parts() {
        let flat = |x: f64| TimeSummary { min: x, p50: x, p95: x, max: x };
        let times = |geometry: f64, shade: f64, display: f64, frame: f64| Times {
            geometry: flat(geometry),
            shade: flat(shade),
            display: flat(display),
            gpu: flat(geometry + shade + display),
            record: flat(0.1),
            frame: flat(frame),
            spread: 1.0,
        };
        let rates = Rates { coherent: 4e8, scattered: 1e8 };
        // 100 ms of shading hold 20 M samples at the rate between the two.
        assert_eq!(Bound::of(&times(1.0, 100.0, 1.0, 103.0), 19_000_000, &rates), Bound::Samples);
        assert_eq!(Bound::of(&times(1.0, 100.0, 1.0, 103.0), 2_000_000, &rates), Bound::Arithmetic);
        assert_eq!(Bound::of(&times(3.0, 5.0, 4.0, 13.0), 19_000_000, &rates), Bound::Fill);
        assert_eq!(Bound::of(&times(0.1, 1.0, 0.1, 9.0), 19_000_000, &rates), Bound::Cpu);
    }
}
