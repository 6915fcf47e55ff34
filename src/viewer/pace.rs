//! What to leave out while something moves, so that frames keep to the time that the user gives them.

use std::fmt;

/// How much of the work a frame does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rung {
    /// All of it.
    Whole,
    /// Layers and wavelengths of a coarser tolerance.
    Coarse,
    /// The same at a half of the resolution.
    Half,
    /// At a third.
    Third,
    /// At a quarter.
    Quarter,
}

impl Rung {
    const ALL: [Self; 5] = [Self::Whole, Self::Coarse, Self::Half, Self::Third, Self::Quarter];

    /// Pixels of the window along one side for each that is drawn.
    pub fn divisor(self) -> u32 {
        match self {
            Self::Whole | Self::Coarse => 1,
            Self::Half => 2,
            Self::Third => 3,
            Self::Quarter => 4,
        }
    }

    /// Whether the coarse layers are used.
    pub fn coarse(self) -> bool {
        self != Self::Whole
    }

    /// The size that is drawn for a picture of `size`.
    pub fn size(self, size: [u32; 2]) -> [u32; 2] {
        size.map(|n| n.div_ceil(self.divisor()))
    }
}

impl fmt::Display for Rung {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Whole => "everything",
            Self::Coarse => "fewer wavelengths and layers",
            Self::Half => "fewer wavelengths and layers, 1/2 resolution",
            Self::Third => "fewer wavelengths and layers, 1/3 resolution",
            Self::Quarter => "fewer wavelengths and layers, 1/4 resolution",
        })
    }
}

/// Frame times of each rung, and which one to take.
#[derive(Clone, Debug)]
pub struct Pace {
    budget: f64,
    times: [Option<f64>; Rung::ALL.len()],
}

impl Pace {
    /// For `fps` frames a second.
    pub fn new(fps: f64) -> Self {
        Self { budget: 1e3 / fps, times: [None; Rung::ALL.len()] }
    }

    /// Milliseconds that a frame may take.
    pub fn budget(&self) -> f64 {
        self.budget
    }

    /// Another number of frames a second.
    pub fn set_fps(&mut self, fps: f64) {
        self.budget = 1e3 / fps;
    }

    /// What is known no longer counts: another surface, size or setting.
    pub fn forget(&mut self) {
        self.times = [None; Rung::ALL.len()];
    }

    /// A frame on `rung` took `milliseconds`.
    pub fn took(&mut self, rung: Rung, milliseconds: f64) {
        let slot = &mut self.times[rung as usize];
        // The mean of the last few: one slow frame is no reason to change.
        *slot = Some(slot.map_or(milliseconds, |old| 0.6 * old + 0.4 * milliseconds));
    }

    /// The rung for a moving picture: the first one that keeps to the budget as far as is known, all that is left out
    /// leaving the less error the earlier it goes. `coarse` tells whether coarse layers are there.
    pub fn moving(&self, coarse: bool) -> Rung {
        let usable = |rung: &Rung| coarse || *rung != Rung::Coarse;
        let mut last = Rung::Whole;
        for rung in Rung::ALL.into_iter().filter(usable) {
            let expected = self.times[rung as usize].or_else(|| self.guess(rung));
            if expected.is_none_or(|time| time <= self.budget) {
                return rung;
            }
            last = rung;
        }
        last
    }

    /// What a rung that was never tried takes: the time of another one of the same layers, by the number of pixels. Before
    /// the first with coarse layers, a third of what the user's own take: trying what is too slow would cost more time.
    fn guess(&self, rung: Rung) -> Option<f64> {
        const COARSE: f64 = 1.0 / 3.0;
        let pixels = |r: Rung| 1.0 / f64::from(r.divisor().pow(2));
        let alike = |r: &&Rung| r.coarse() == rung.coarse() && self.times[**r as usize].is_some();
        let known = Rung::ALL.iter().filter(alike).min_by_key(|r| r.divisor().abs_diff(rung.divisor()));
        match known {
            Some(known) => self.times[*known as usize].map(|time| time * pixels(rung) / pixels(*known)),
            None => self.times[Rung::Whole as usize].map(|time| time * COARSE * pixels(rung)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_is_fast_enough_stays_whole() {
        let mut pace = Pace::new(15.0);
        assert_eq!(pace.moving(true), Rung::Whole, "nothing is known yet");
        pace.took(Rung::Whole, 60.0);
        assert_eq!(pace.moving(true), Rung::Whole);
    }

    #[test]
    fn what_is_too_slow_goes_down_one_rung_after_another_and_no_farther_than_needed() {
        let mut pace = Pace::new(15.0);
        pace.took(Rung::Whole, 190.0);
        assert_eq!(pace.moving(true), Rung::Coarse, "a third of 190 ms fits");
        assert_eq!(pace.moving(false), Rung::Half, "without coarse layers only resolution is left");
        pace.took(Rung::Coarse, 200.0);
        assert_eq!(pace.moving(true), Rung::Half, "a quarter of 200 ms fits");
        pace.took(Rung::Half, 90.0);
        assert_eq!(pace.moving(true), Rung::Third);
        pace.took(Rung::Third, 80.0);
        pace.took(Rung::Quarter, 75.0);
        assert_eq!(pace.moving(true), Rung::Quarter, "there is nothing below");
        pace.set_fps(5.0);
        assert_eq!(pace.moving(true), Rung::Whole, "190 ms are 5 frames a second");
        pace.forget();
        assert_eq!(pace.moving(true), Rung::Whole);
    }

    #[test]
    fn sizes_round_up_so_that_no_picture_is_empty() {
        assert_eq!(Rung::Quarter.size([1, 1]), [1, 1]);
        assert_eq!(Rung::Half.size([641, 480]), [321, 240]);
        assert_eq!(Rung::Coarse.size([641, 480]), [641, 480]);
    }
}
