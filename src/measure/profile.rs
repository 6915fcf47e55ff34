//! Frame times: on the device's clock and on the wall, with the spread that tells whether to believe them.

use crate::error::Result;
use crate::render::frame::View;
use crate::render::picture::Painter;
use glam::DVec3;
use std::time::Instant;

/// Frames drawn before any is counted: the first compile shaders and fault memory in.
const WARM_UP: usize = 3;
/// Samples per pixel of the probe: long enough that its start does not count.
const PROBE_SAMPLES: u32 = 64;

/// Order statistics of a series of milliseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Smallest.
    pub min: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

impl Summary {
    /// Of a series; all zero for an empty one.
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
    /// Shading on the device \[ms\].
    pub shade: Summary,
    /// Display on the device \[ms\].
    pub display: Summary,
    /// Both \[ms\].
    pub gpu: Summary,
    /// From the call to the finished frame, on the wall \[ms\].
    pub frame: Summary,
    /// Largest over smallest of the medians of the series' thirds: 1 on a quiet machine.
    pub spread: f64,
    /// Bilinear samples of the layers a second that the device reaches with nothing else to do.
    pub sample_rate: f64,
}

/// Draws `view` `frames` times with `painter`, whose pictures have `pixels` pixels, and measures. `progress(done, of)` is
/// called before each frame; an error from it ends the work.
///
/// # Errors
/// Where the device is lost, and what `progress` returns.
pub fn measure(
    painter: &mut Painter,
    view: &View,
    frames: usize,
    pixels: usize,
    progress: &dyn Fn(usize, usize) -> Result<()>,
) -> Result<Times> {
    let (mut shade, mut display, mut gpu, mut wall) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for frame in 0..WARM_UP + frames {
        progress(frame, WARM_UP + frames)?;
        let start = Instant::now();
        let [shading, displaying] = painter.draw(view, 0.0, DVec3::ZERO)?;
        if frame >= WARM_UP {
            wall.push(start.elapsed().as_secs_f64() * 1e3);
            shade.push(shading);
            display.push(displaying);
            gpu.push(shading + displaying);
        }
    }
    let medians: Vec<f64> = wall.chunks(wall.len().div_ceil(3)).map(|part| Summary::of(part).p50).collect();
    let ends = Summary::of(&medians);
    let probe = painter.probe(PROBE_SAMPLES)?;
    Ok(Times {
        shade: Summary::of(&shade),
        display: Summary::of(&display),
        gpu: Summary::of(&gpu),
        frame: Summary::of(&wall),
        spread: ends.max / ends.min.max(f64::MIN_POSITIVE),
        sample_rate: pixels as f64 * f64::from(PROBE_SAMPLES) / (probe * 1e-3),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_has_the_order_statistics_of_its_series() {
        let s = Summary::of(&[5.0, 1.0, 4.0, 2.0, 3.0]);
        assert_eq!((s.min, s.p50, s.max), (1.0, 3.0, 5.0));
        assert_eq!(Summary::of(&[]).max, 0.0);
    }
}
