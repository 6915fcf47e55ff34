//! What to leave out while something moves, so that frames keep to the time that the user gives them.

use std::fmt;

/// From which spectra a frame is summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Degree {
    /// The user's own.
    Own,
    /// As many layers at fewer wavelengths.
    FewerWavelengths,
    /// Fewer of both.
    Coarse,
}

impl Degree {
    const ALL: [Self; 3] = [Self::Own, Self::FewerWavelengths, Self::Coarse];
}

/// How much of the work a frame does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rung {
    /// From which spectra.
    pub degree: Degree,
    /// Pixels of the window along one side for each that is drawn, 1 … 4.
    pub divisor: u32,
}

/// The lowest resolution, as a divisor.
const LEAST: u32 = 4;

impl Rung {
    /// All of it.
    pub const WHOLE: Self = Self { degree: Degree::Own, divisor: 1 };
    /// The first picture of all, which shall come at once.
    pub const FIRST: Self = Self { degree: Degree::Own, divisor: LEAST };

    /// The size that is drawn for a picture of `size`.
    pub fn size(self, size: [u32; 2]) -> [u32; 2] {
        size.map(|n| n.div_ceil(self.divisor))
    }

    fn pixels(self) -> f64 {
        1.0 / f64::from(self.divisor.pow(2))
    }
}

impl fmt::Display for Rung {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let spectra = match self.degree {
            Degree::Own => None,
            Degree::FewerWavelengths => Some("fewer wavelengths"),
            Degree::Coarse => Some("fewer wavelengths and layers"),
        };
        match (spectra, self.divisor) {
            (None, 1) => f.write_str("everything"),
            (Some(spectra), 1) => f.write_str(spectra),
            (None, n) => write!(f, "1/{n} resolution"),
            (Some(spectra), n) => write!(f, "{spectra}, 1/{n} resolution"),
        }
    }
}

/// What a rung took \[ms\].
#[derive(Clone, Copy, Debug)]
struct Time {
    milliseconds: f64,
    // Of another setting, or of a first frame, for which the driver had work of its own: the next one counts alone.
    doubtful: bool,
}

/// Frame times of each rung, and which one to take.
#[derive(Clone, Debug)]
pub struct Pace {
    budget: f64,
    times: [[Option<Time>; LEAST as usize]; Degree::ALL.len()],
}

impl Pace {
    /// For `fps` frames a second.
    pub fn new(fps: f64) -> Self {
        Self { budget: 1e3 / fps, times: Default::default() }
    }

    /// Milliseconds that a frame may take.
    pub fn budget(&self) -> f64 {
        self.budget
    }

    /// Another number of frames a second.
    pub fn set_fps(&mut self, fps: f64) {
        self.budget = 1e3 / fps;
    }

    /// What is known is of another surface, size or setting from now on: better than nothing until there is something new.
    pub fn doubt(&mut self) {
        self.times.iter_mut().flatten().flatten().for_each(|time| time.doubtful = true);
    }

    /// A frame on `rung` took `milliseconds`; `first` if it was the first of its painter.
    pub fn took(&mut self, rung: Rung, milliseconds: f64, first: bool) {
        let slot = &mut self.times[rung.degree as usize][rung.divisor as usize - 1];
        let milliseconds = match slot {
            // The mean of the last few: one slow frame is no reason to change.
            Some(old) if !old.doubtful => 0.6 * old.milliseconds + 0.4 * milliseconds,
            _ => milliseconds,
        };
        *slot = Some(Time { milliseconds, doubtful: first });
    }

    /// Whether whole frames are known to take longer than the budget.
    pub fn is_slow(&self) -> bool {
        self.known(Rung::WHOLE).is_some_and(|time| time > self.budget)
    }

    /// The rung for a moving picture: the first one that keeps to the budget as far as is known, all that is left out
    /// leaving the less error the earlier it goes. `there` tells which spectra are ready beside the user's own.
    pub fn moving(&self, there: impl Fn(Degree) -> bool) -> Rung {
        let spectra = Degree::ALL.into_iter().filter(|&degree| degree == Degree::Own || there(degree));
        let lightest = spectra.clone().last().unwrap_or(Degree::Own);
        let full = spectra.map(|degree| Rung { degree, divisor: 1 });
        let smaller = (2..=LEAST).map(|divisor| Rung { degree: lightest, divisor });
        let mut rungs = full.chain(smaller);
        let fits = |rung: &Rung| self.expected(*rung).is_none_or(|time| time <= self.budget);
        rungs.find(fits).unwrap_or(Rung { degree: lightest, divisor: LEAST })
    }

    fn known(&self, rung: Rung) -> Option<f64> {
        self.times[rung.degree as usize][rung.divisor as usize - 1].map(|time| time.milliseconds)
    }

    /// What a rung takes. One that was never tried: the time of another one of the same spectra, by the number of pixels; of
    /// spectra that were never tried, a part of what the user's own take: trying what is too slow would cost more time.
    fn expected(&self, rung: Rung) -> Option<f64> {
        let part = match rung.degree {
            Degree::Own => None,
            Degree::FewerWavelengths => Some(0.65),
            Degree::Coarse => Some(1.0 / 3.0),
        };
        let alike = (1..=LEAST).map(|divisor| Rung { divisor, ..rung });
        let known = alike.filter_map(|rung| self.known(rung).map(|time| (rung, time)));
        let near = known.min_by_key(|(known, _)| known.divisor.abs_diff(rung.divisor));
        match (near, part) {
            (Some((known, time)), _) => Some(time * rung.pixels() / known.pixels()),
            (None, Some(part)) => self.expected(Rung { degree: Degree::Own, ..rung }).map(|time| time * part),
            (None, None) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WAVELENGTHS: Rung = Rung { degree: Degree::FewerWavelengths, divisor: 1 };
    const COARSE: Rung = Rung { degree: Degree::Coarse, divisor: 1 };

    fn all(_: Degree) -> bool {
        true
    }

    fn none(_: Degree) -> bool {
        false
    }

    #[test]
    fn a_picture_that_is_fast_enough_stays_whole() {
        let mut pace = Pace::new(15.0);
        pace.took(Rung::WHOLE, 60.0, false);
        assert_eq!(pace.moving(all), Rung::WHOLE);
        assert!(!pace.is_slow());
    }

    #[test]
    fn first_wavelengths_go_then_layers_then_resolution_and_no_more_than_needed() {
        let mut pace = Pace::new(15.0);
        pace.took(Rung::WHOLE, 80.0, false);
        assert!(pace.is_slow());
        assert_eq!(pace.moving(all), WAVELENGTHS, "two thirds of 80 ms fit");
        pace.took(WAVELENGTHS, 75.0, false);
        assert_eq!(pace.moving(all), COARSE, "a third of 80 ms fits");
        let no_wavelengths = |degree| degree == Degree::Coarse;
        assert_eq!(pace.moving(no_wavelengths), COARSE);
        assert_eq!(pace.moving(none), Rung { degree: Degree::Own, divisor: 2 }, "resolution alone is left");
        pace.took(COARSE, 200.0, false);
        assert_eq!(pace.moving(all), Rung { divisor: 2, ..COARSE }, "a quarter of 200 ms fits");
        for divisor in 2..=LEAST {
            pace.took(Rung { divisor, ..COARSE }, 90.0, false);
        }
        assert_eq!(pace.moving(all), Rung { divisor: LEAST, ..COARSE }, "there is nothing below");
        pace.set_fps(5.0);
        assert_eq!(pace.moving(all), Rung::WHOLE, "80 ms are 5 frames a second");
    }

    #[test]
    fn before_the_first_whole_frame_the_first_small_one_tells_what_to_expect() {
        let mut pace = Pace::new(15.0);
        pace.took(Rung::FIRST, 20.0, true);
        assert!(!pace.is_slow(), "whole frames were not timed yet");
        assert_eq!(
            pace.moving(none),
            Rung { divisor: 3, ..Rung::WHOLE },
            "36 ms, where 80 and 320 are too many"
        );
        // A first frame is no measure for longer than there is no other.
        pace.took(Rung::FIRST, 2.0, false);
        assert_eq!(pace.moving(none), Rung::WHOLE);
    }

    #[test]
    fn times_of_another_setting_count_until_there_are_new_ones() {
        let mut pace = Pace::new(15.0);
        pace.took(Rung::WHOLE, 500.0, false);
        pace.doubt();
        assert_ne!(pace.moving(none), Rung::WHOLE);
        pace.took(Rung::WHOLE, 30.0, false);
        assert_eq!(pace.moving(none), Rung::WHOLE);
    }

    #[test]
    fn what_is_done_is_said() {
        let said = |degree, divisor| Rung { degree, divisor }.to_string();
        assert_eq!(said(Degree::Own, 1), "everything");
        assert_eq!(said(Degree::Own, 3), "1/3 resolution");
        assert_eq!(said(Degree::FewerWavelengths, 1), "fewer wavelengths");
        assert_eq!(said(Degree::Coarse, 2), "fewer wavelengths and layers, 1/2 resolution");
    }

    #[test]
    fn sizes_round_up_so_that_no_picture_is_empty() {
        assert_eq!(Rung::FIRST.size([1, 1]), [1, 1]);
        assert_eq!(Rung { divisor: 2, ..Rung::WHOLE }.size([641, 480]), [321, 240]);
        assert_eq!(COARSE.size([641, 480]), [641, 480]);
    }
}
