//! Adaptive quality: reduces the work of frames while camera or lights move, so that they keep to a time budget.

use std::fmt;

/// Level of detail of the spectra that a frame is summed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// Main setting.
    Full,
    /// Same number of terms at fewer wavelengths.
    FewerWavelengths,
    /// Fewer terms at fewer wavelengths.
    Coarse,
}

impl Detail {
    const ALL: [Self; 3] = [Self::Full, Self::FewerWavelengths, Self::Coarse];

    /// Returns the estimated frame time over that of [`Detail::Full`], used until a frame was timed.
    const fn estimated_cost(self) -> f64 {
        match self {
            Self::Full => 1.0,
            Self::FewerWavelengths => 0.65,
            Self::Coarse => 1.0 / 3.0,
        }
    }
}

/// Quality of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Level of detail of the spectra.
    pub detail: Detail,
    /// Window pixels per rendered pixel along one side, 1 … 4.
    pub divisor: u32,
}

/// Largest [`Quality::divisor`].
const LARGEST_DIVISOR: u32 = 4;

impl Quality {
    /// Full detail and resolution.
    pub const WHOLE: Self = Self { detail: Detail::Full, divisor: 1 };
    /// Quality of the very first frame, which should appear at once.
    pub const FIRST: Self = Self { detail: Detail::Full, divisor: LARGEST_DIVISOR };

    /// Quality of previews, shown while the user's setting is prepared.
    pub const PREVIEW: Self = Self { detail: Detail::Full, divisor: 2 };

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
        let spectra = match self.detail {
            Detail::Full => None,
            Detail::FewerWavelengths => Some("fewer wavelengths"),
            Detail::Coarse => Some("fewer wavelengths and terms"),
        };
        match (spectra, self.divisor) {
            (None, 1) => f.write_str("full quality"),
            (Some(spectra), 1) => write!(f, "preview, {spectra}"),
            (None, n) => write!(f, "preview 1/{n}"),
            (Some(spectra), n) => write!(f, "preview 1/{n}, {spectra}"),
        }
    }
}

/// Frame time of a quality \[ms\].
#[derive(Clone, Copy, Debug)]
struct Time {
    milliseconds: f64,
    // True if measured with another setting, or on the first frame of a renderer, which includes one-off work of the
    // driver. The next measurement replaces the time instead of being averaged with it.
    provisional: bool,
}

/// Chooses the quality of moving frames from measured frame times.
#[derive(Clone, Debug)]
pub struct QualityControl {
    // [ms]
    budget: f64,
    times: [[Option<Time>; LARGEST_DIVISOR as usize]; Detail::ALL.len()],
}

impl QualityControl {
    /// Makes a control for `fps` frames a second.
    pub fn new(fps: f64) -> Self {
        Self { budget: 1e3 / fps, times: Default::default() }
    }

    /// Returns the time that a frame may take \[ms\].
    pub fn budget(&self) -> f64 {
        self.budget
    }

    /// Sets the number of frames a second.
    pub fn set_fps(&mut self, fps: f64) {
        self.budget = 1e3 / fps;
    }

    /// Marks all times as provisional, because surface, size or setting changed. They are used until new ones are
    /// known.
    pub fn invalidate(&mut self) {
        self.times.iter_mut().flatten().flatten().for_each(|time| time.provisional = true);
    }

    /// Records a frame of `quality` that took `milliseconds`; `first` if it was the first of its renderer.
    pub fn record(&mut self, quality: Quality, milliseconds: f64, first: bool) {
        /// Weight of the newest frame in the exponential mean; limits the effect of a single slow frame.
        const NEWEST: f64 = 0.4;
        let slot = &mut self.times[quality.detail as usize][quality.divisor as usize - 1];
        let milliseconds = match slot {
            Some(old) if !old.provisional => (1.0 - NEWEST) * old.milliseconds + NEWEST * milliseconds,
            _ => milliseconds,
        };
        *slot = Some(Time { milliseconds, provisional: first });
    }

    /// Returns true if frames of full quality are known to exceed the budget.
    pub fn is_slow(&self) -> bool {
        self.measured(Quality::WHOLE).is_some_and(|time| time > self.budget)
    }

    /// Returns the quality of a moving frame: the best one that is expected to keep to the budget. Detail is reduced
    /// before resolution, because that costs less accuracy. `is_ready` returns true for the spectra that exist beside
    /// those of full detail.
    pub fn moving(&self, is_ready: impl Fn(Detail) -> bool) -> Quality {
        let details = Detail::ALL.into_iter().filter(|&detail| detail == Detail::Full || is_ready(detail));
        let lightest = details.clone().last().unwrap_or(Detail::Full);
        let full_size = details.map(|detail| Quality { detail, divisor: 1 });
        let smaller = (2..=LARGEST_DIVISOR).map(|divisor| Quality { detail: lightest, divisor });
        let fits = |quality: &Quality| self.expected(*quality).is_none_or(|time| time <= self.budget);
        let worst = Quality { detail: lightest, divisor: LARGEST_DIVISOR };
        full_size.chain(smaller).find(fits).unwrap_or(worst)
    }

    fn measured(&self, quality: Quality) -> Option<f64> {
        self.times[quality.detail as usize][quality.divisor as usize - 1].map(|time| time.milliseconds)
    }

    /// Returns the expected frame time \[ms\]. Without a measurement of this quality it is scaled by the number of
    /// pixels from the nearest measured resolution; without any measurement of this detail, from full detail.
    fn expected(&self, quality: Quality) -> Option<f64> {
        let all_sizes = (1..=LARGEST_DIVISOR).map(|divisor| Quality { divisor, ..quality });
        let measured = all_sizes.filter_map(|q| self.measured(q).map(|time| (q, time)));
        let nearest = measured.min_by_key(|(q, _)| q.divisor.abs_diff(quality.divisor));
        match nearest {
            Some((nearest, time)) => Some(time * quality.pixels() / nearest.pixels()),
            None if quality.detail == Detail::Full => None,
            None => {
                let full = self.expected(Quality { detail: Detail::Full, ..quality })?;
                Some(full * quality.detail.estimated_cost())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WAVELENGTHS: Quality = Quality { detail: Detail::FewerWavelengths, divisor: 1 };
    const COARSE: Quality = Quality { detail: Detail::Coarse, divisor: 1 };

    fn all(_: Detail) -> bool {
        true
    }

    fn none(_: Detail) -> bool {
        false
    }

    #[test]
    fn a_picture_that_is_fast_enough_stays_whole() {
        let mut control = QualityControl::new(15.0);
        control.record(Quality::WHOLE, 60.0, false);
        assert_eq!(control.moving(all), Quality::WHOLE);
        assert!(!control.is_slow());
    }

    #[test]
    fn first_wavelengths_go_then_terms_then_resolution_and_no_more_than_needed() {
        let mut control = QualityControl::new(15.0);
        control.record(Quality::WHOLE, 80.0, false);
        assert!(control.is_slow());
        assert_eq!(control.moving(all), WAVELENGTHS, "two thirds of 80 ms fit");
        control.record(WAVELENGTHS, 75.0, false);
        assert_eq!(control.moving(all), COARSE, "a third of 80 ms fits");
        let no_wavelengths = |detail| detail == Detail::Coarse;
        assert_eq!(control.moving(no_wavelengths), COARSE);
        assert_eq!(
            control.moving(none),
            Quality { detail: Detail::Full, divisor: 2 },
            "resolution alone is left"
        );
        control.record(COARSE, 200.0, false);
        assert_eq!(control.moving(all), Quality { divisor: 2, ..COARSE }, "a quarter of 200 ms fits");
        for divisor in 2..=LARGEST_DIVISOR {
            control.record(Quality { divisor, ..COARSE }, 90.0, false);
        }
        assert_eq!(
            control.moving(all),
            Quality { divisor: LARGEST_DIVISOR, ..COARSE },
            "there is nothing below"
        );
        control.set_fps(5.0);
        assert_eq!(control.moving(all), Quality::WHOLE, "80 ms are 5 frames a second");
    }

    #[test]
    fn before_the_first_whole_frame_the_first_small_one_tells_what_to_expect() {
        let mut control = QualityControl::new(15.0);
        control.record(Quality::FIRST, 20.0, true);
        assert!(!control.is_slow(), "whole frames were not timed yet");
        assert_eq!(
            control.moving(none),
            Quality { divisor: 3, ..Quality::WHOLE },
            "36 ms, where 80 and 320 are too many"
        );
        // The first frame is used only until another is measured.
        control.record(Quality::FIRST, 2.0, false);
        assert_eq!(control.moving(none), Quality::WHOLE);
    }

    #[test]
    fn times_of_another_setting_count_until_there_are_new_ones() {
        let mut control = QualityControl::new(15.0);
        control.record(Quality::WHOLE, 500.0, false);
        control.invalidate();
        assert_ne!(control.moving(none), Quality::WHOLE);
        control.record(Quality::WHOLE, 30.0, false);
        assert_eq!(control.moving(none), Quality::WHOLE);
    }

    #[test]
    fn what_is_done_is_said() {
        let said = |detail, divisor| Quality { detail, divisor }.to_string();
        assert_eq!(said(Detail::Full, 1), "full quality");
        assert_eq!(said(Detail::Full, 3), "preview 1/3");
        assert_eq!(said(Detail::FewerWavelengths, 1), "preview, fewer wavelengths");
        assert_eq!(said(Detail::Coarse, 2), "preview 1/2, fewer wavelengths and terms");
    }

    #[test]
    fn sizes_round_up_so_that_no_picture_is_empty() {
        assert_eq!(Quality::FIRST.size([1, 1]), [1, 1]);
        assert_eq!(Quality { divisor: 2, ..Quality::WHOLE }.size([641, 480]), [321, 240]);
        assert_eq!(COARSE.size([641, 480]), [641, 480]);
    }
}
