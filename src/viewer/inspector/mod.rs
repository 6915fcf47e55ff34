//! Inspector: radiance and directions of one pixel of the picture, and the f64 reference for them.

pub mod reading;
pub mod reference;

use crate::error::Result;
use reading::{LightAt, Reading};
use reference::Answer;

/// State of the inspector.
#[derive(Default)]
pub struct Inspector {
    /// True while the pane is shown.
    pub open: bool,
    /// Pixel under the pointer, or the one that was clicked.
    pub at: Option<[u32; 2]>,
    /// True if a click has pinned the pixel, so that it does not follow the pointer.
    pub pinned: bool,
    /// Number of the light whose directions are shown, from 0.
    pub light: usize,
    /// Data of the pixel; `None` if no object covers it, and before the first reading.
    pub reading: Option<Reading>,
    /// Answer of the reference.
    pub answer: Option<Answer>,
}

impl Inspector {
    /// Closes the pane and forgets the pixel.
    pub fn close(&mut self) {
        *self = Self::default();
    }

    /// Moves to the pixel `at` under the pointer, unless a pixel is pinned.
    pub fn follow(&mut self, at: Option<[u32; 2]>) {
        if self.open && !self.pinned && at.is_some() {
            self.at = at;
        }
    }

    /// Pins pixel `at`, or releases the pinned pixel if it is at most `reach` pixels away.
    pub fn click(&mut self, at: [u32; 2], reach: u32) {
        let near = |held: [u32; 2]| held[0].abs_diff(at[0]).max(held[1].abs_diff(at[1])) <= reach;
        self.pinned = !(self.pinned && self.at.is_some_and(near));
        self.at = Some(at);
    }

    /// Returns the light whose directions are shown.
    pub fn light(&self) -> Option<&LightAt> {
        self.reading.as_ref()?.lights.get(self.light)
    }

    /// Shows the reading of the requested pixel.
    pub fn show(&mut self, reading: Option<Reading>) {
        self.answer = None;
        self.light =
            self.light.min(reading.as_ref().map_or(0, |reading| reading.lights.len().saturating_sub(1)));
        self.reading = reading;
    }

    /// Takes the answer of the reference to reading number `number`.
    ///
    /// # Errors
    /// Returns the error of the reference.
    pub fn take(&mut self, number: u64, answer: Result<Answer>) -> Result<()> {
        let Some(reading) = &self.reading else { return Ok(()) };
        let answer = answer?;
        // The reference is prepared once for all pixels.
        if reading.number == number || matches!(answer, Answer::Preparing(_)) {
            self.answer = Some(answer);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixel_follows_the_pointer_until_a_click_holds_it_and_another_lets_it_go() {
        let mut inspector = Inspector::default();
        inspector.follow(Some([3, 4]));
        assert_eq!(inspector.at, None, "closed");
        inspector.open = true;
        inspector.follow(Some([3, 4]));
        inspector.follow(None);
        assert_eq!(inspector.at, Some([3, 4]));
        inspector.click([10, 12], 2);
        inspector.follow(Some([50, 60]));
        assert!(inspector.pinned && inspector.at == Some([10, 12]));
        inspector.click([40, 12], 2);
        assert!(inspector.pinned && inspector.at == Some([40, 12]), "another pixel is held");
        inspector.click([41, 10], 2);
        assert!(!inspector.pinned);
        inspector.follow(Some([50, 60]));
        assert_eq!(inspector.at, Some([50, 60]));
    }
}
