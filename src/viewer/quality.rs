//! Adaptive quality: reduces the resolution of frames while camera or lights move, so that they keep to a time budget.

use std::fmt;

/// Quality of a frame. The larger, the coarser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Quality {
    /// Window pixels per rendered pixel along one side, one of [`DIVISORS`].
    pub divisor: u32,
}

/// All values of [`Quality::divisor`].
const DIVISORS: [u32; 5] = [1, 2, 3, 4, 8];

impl Quality {
    /// Full resolution.
    pub const WHOLE: Self = Self { divisor: 1 };
    /// Quality of previews, shown while the user's setting is prepared.
    pub const PREVIEW: Self = Self { divisor: 2 };
    /// Quality of the very first frame, which should appear at once.
    pub const FIRST: Self = Self { divisor: 4 };
    /// Lowest resolution. A moving frame of this quality is always finished and shown.
    pub const COARSEST: Self = Self { divisor: 8 };

    /// Returns the pixels to render for a picture of `size`.
    pub fn size(self, size: [u32; 2]) -> [u32; 2] {
        size.map(|n| n.div_ceil(self.divisor))
    }

    /// Returns the fraction of the pixels that is rendered.
    fn pixels(self) -> f64 {
        1.0 / f64::from(self.divisor.pow(2))
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.divisor {
            1 => f.write_str("full quality"),
            n => write!(f, "preview 1/{n}"),
        }
    }
}

/// Time of the last frame.
#[derive(Clone, Copy, Debug)]
struct FrameTiming {
    quality: Quality,
    milliseconds: f64,
    // True if measured with another setting, on an abandoned frame, or on the first frame of a renderer, which includes
    // one-off work of the driver. The next measurement replaces the time instead of being averaged with it.
    provisional: bool,
}

/// Chooses the quality of moving frames from the time of the last frames.
#[derive(Clone, Debug)]
pub struct QualityControl {
    // [ms]
    budget: f64,
    last: Option<FrameTiming>,
}

impl QualityControl {
    /// Makes a control for `fps` frames a second.
    pub fn new(fps: f64) -> Self {
        Self { budget: 1e3 / fps, last: None }
    }

    /// Returns the time that a frame may take \[ms\].
    pub fn budget(&self) -> f64 {
        self.budget
    }

    /// Sets the number of frames a second.
    pub fn set_fps(&mut self, fps: f64) {
        self.budget = 1e3 / fps;
    }

    /// Marks the time as provisional, because surface, size or setting changed.
    pub fn invalidate(&mut self) {
        self.last.iter_mut().for_each(|last| last.provisional = true);
    }

    /// Records a frame of `quality` that took `milliseconds`; `provisional` if later frames may take another time.
    pub fn record(&mut self, quality: Quality, milliseconds: f64, provisional: bool) {
        /// Weight of the newest frame in the exponential mean; limits the effect of a single slow frame.
        const NEWEST: f64 = 0.4;
        let milliseconds = match self.last {
            Some(last) if last.quality == quality && !last.provisional => {
                (1.0 - NEWEST) * last.milliseconds + NEWEST * milliseconds
            }
            _ => milliseconds,
        };
        self.last = Some(FrameTiming { quality, milliseconds, provisional });
    }

    /// Returns the quality of a moving frame: the best one that is expected to keep to the budget.
    pub fn moving(&self) -> Quality {
        let all = DIVISORS.map(|divisor| Quality { divisor });
        all.into_iter().find(|quality| self.expected(*quality) <= self.budget).unwrap_or(Quality::COARSEST)
    }

    /// Returns the expected frame time \[ms\]: that of the last frame, scaled by the number of pixels; 0 before the first
    /// frame.
    fn expected(&self, quality: Quality) -> f64 {
        self.last.map_or(0.0, |last| last.milliseconds * quality.pixels() / last.quality.pixels())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn preview(divisor: u32) -> Quality {
        Quality { divisor }
    }

    #[test]
    fn a_picture_that_is_fast_enough_stays_whole() {
        let mut control = QualityControl::new(15.0);
        assert_eq!(control.moving(), Quality::WHOLE);
        control.record(Quality::WHOLE, 60.0, false);
        assert_eq!(control.moving(), Quality::WHOLE);
    }

    #[test]
    fn the_resolution_is_lowered_as_far_as_needed_and_no_further() {
        let mut control = QualityControl::new(15.0);
        control.record(Quality::WHOLE, 80.0, false);
        assert_eq!(control.moving(), preview(2), "a quarter of 80 ms fits");
        control.record(preview(2), 90.0, false);
        assert_eq!(control.moving(), preview(3), "40 ms fit");
        control.record(Quality::WHOLE, 1200.0, true);
        assert_eq!(control.moving(), Quality::COARSEST, "75 ms are too many");
        control.record(Quality::COARSEST, 300.0, false);
        assert_eq!(control.moving(), Quality::COARSEST, "there is nothing below");
        control.set_fps(2.0);
        assert_eq!(control.moving(), Quality::COARSEST, "at a quarter it would take 1.2 s");
        // The machine is busy no more.
        (0..16).for_each(|_| control.record(Quality::COARSEST, 5.0, false));
        assert_eq!(control.moving(), preview(1), "about 0.4 s");
    }

    #[test]
    fn before_the_first_whole_frame_the_first_small_one_tells_what_to_expect() {
        let mut control = QualityControl::new(15.0);
        control.record(Quality::FIRST, 20.0, true);
        assert_eq!(control.moving(), preview(3), "36 ms, where 80 and 320 are too many");
        // The first frame is used only until another is measured.
        control.record(Quality::FIRST, 2.0, false);
        assert_eq!(control.moving(), Quality::WHOLE);
    }

    #[test]
    fn times_of_another_setting_count_until_there_are_new_ones() {
        let mut control = QualityControl::new(15.0);
        control.record(Quality::WHOLE, 500.0, false);
        control.invalidate();
        assert_ne!(control.moving(), Quality::WHOLE);
        control.record(Quality::WHOLE, 30.0, false);
        assert_eq!(control.moving(), Quality::WHOLE);
    }

    #[test]
    fn what_is_done_is_said() {
        assert_eq!([1, 3, 8].map(|n| preview(n).to_string()), ["full quality", "preview 1/3", "preview 1/8"]);
    }

    #[test]
    fn sizes_round_up_so_that_no_picture_is_empty() {
        assert_eq!(Quality::COARSEST.size([1, 1]), [1, 1]);
        assert_eq!(Quality::PREVIEW.size([641, 480]), [321, 240]);
        assert_eq!(Quality::WHOLE.size([641, 480]), [641, 480]);
    }
}
