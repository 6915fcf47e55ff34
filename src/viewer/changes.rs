//! Undo and redo of the user's settings.

use super::view_settings::ViewSettings;

/// Settings before and after the present ones. A drag is one change.
pub struct Changes {
    present: ViewSettings,
    // Newest last.
    earlier: Vec<ViewSettings>,
    later: Vec<ViewSettings>,
    // True during a change such as a drag.
    unfinished: bool,
}

/// Direction in the list of changes, or among the files of a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepDirection {
    /// Undo; the previous file.
    Back,
    /// Redo; the next file.
    Forward,
}

impl Changes {
    /// Maximum number of settings that are kept for undo.
    const MOST: usize = 100;

    /// Makes an empty list of changes.
    pub fn new(present: ViewSettings) -> Self {
        Self { present, earlier: Vec::new(), later: Vec::new(), unfinished: false }
    }

    /// Takes over `settings` before the user acts. Changes by the window, such as a view that is fitted to another
    /// size, cannot be undone. Another scene clears the list.
    pub fn begin(&mut self, settings: &ViewSettings) {
        if self.unfinished || *settings == self.present {
            return;
        }
        if settings.scene != self.present.scene {
            self.earlier.clear();
            self.later.clear();
        }
        self.present.clone_from(settings);
    }

    /// Records the user's change of `settings` once it is `finished`.
    pub fn end(&mut self, settings: &ViewSettings, finished: bool) {
        self.unfinished = *settings != self.present && !finished;
        if !finished || *settings == self.present {
            return;
        }
        self.earlier.push(std::mem::replace(&mut self.present, settings.clone()));
        self.later.clear();
        if self.earlier.len() > Self::MOST {
            self.earlier.remove(0);
        }
    }

    /// Records the change by an action of the user between two passes of the panel.
    pub fn act(&mut self, settings: &ViewSettings) {
        if !self.unfinished {
            self.end(settings, true);
        }
    }

    /// Returns the settings one step away; `None` if there are none, or during a change.
    pub fn step(&mut self, step: StepDirection) -> Option<ViewSettings> {
        if self.unfinished {
            return None;
        }
        let (from, to) = match step {
            StepDirection::Back => (&mut self.earlier, &mut self.later),
            StepDirection::Forward => (&mut self.later, &mut self.earlier),
        };
        // A refused change has left the same settings twice.
        while from.last() == Some(&self.present) {
            from.pop();
        }
        let next = from.pop()?;
        to.push(std::mem::replace(&mut self.present, next.clone()));
        Some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::super::view_settings::tests::settings;
    use super::*;

    fn exposed(exposure: f64) -> ViewSettings {
        ViewSettings { exposure, ..settings().0 }
    }

    /// Changes the present settings to `exposure`.
    fn change(changes: &mut Changes, exposure: f64) {
        let before = changes.present.clone();
        changes.begin(&before);
        changes.end(&exposed(exposure), true);
    }

    #[test]
    fn changes_are_undone_in_turn_and_redone_until_another_one_is_made() {
        let mut changes = Changes::new(exposed(0.0));
        assert!(
            changes.step(StepDirection::Back).is_none() && changes.step(StepDirection::Forward).is_none()
        );
        [1.0, 2.0, 3.0].into_iter().for_each(|exposure| change(&mut changes, exposure));
        let mut step = |step| changes.step(step).map(|settings| settings.exposure);
        assert_eq!([step(StepDirection::Back), step(StepDirection::Back)], [Some(2.0), Some(1.0)]);
        assert_eq!([step(StepDirection::Forward), step(StepDirection::Back)], [Some(2.0), Some(1.0)]);
        change(&mut changes, 7.0);
        assert!(changes.step(StepDirection::Forward).is_none());
        assert_eq!(changes.step(StepDirection::Back).map(|s| s.exposure), Some(1.0));
    }

    #[test]
    fn a_drag_is_one_change_and_what_the_window_changes_is_none() {
        let mut changes = Changes::new(exposed(0.0));
        for exposure in [0.0, 0.1, 0.2] {
            changes.begin(&exposed(exposure));
            changes.end(&exposed(exposure + 0.1), false);
            assert!(changes.step(StepDirection::Back).is_none(), "in the middle of a drag");
        }
        changes.end(&exposed(0.4), true);
        changes.begin(&exposed(0.9));
        assert_eq!(changes.step(StepDirection::Back).map(|s| s.exposure), Some(0.0));
        assert_eq!(changes.step(StepDirection::Forward).map(|s| s.exposure), Some(0.9));
    }

    #[test]
    fn refused_settings_take_no_step_and_another_scene_begins_anew() {
        let mut changes = Changes::new(exposed(0.0));
        change(&mut changes, 1.0);
        change(&mut changes, 2.0);
        changes.begin(&exposed(1.0)); // the window returns to the displayed settings
        assert_eq!(changes.step(StepDirection::Back).map(|s| s.exposure), Some(0.0));
        change(&mut changes, 3.0);
        changes.begin(&ViewSettings { scene: "disc".to_owned(), ..exposed(3.0) });
        assert!(changes.step(StepDirection::Back).is_none());
        (0..300).for_each(|i| change(&mut changes, f64::from(i)));
        assert_eq!(changes.earlier.len(), Changes::MOST);
    }
}
