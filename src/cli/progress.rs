//! Progress of long work: a bar on a terminal, and one line about work that takes many minutes.

use super::verbosity::{quiet, say};
use crate::error::Result;
use indicatif::{ProgressBar, ProgressStyle};
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Time after which a step tells how long it takes: its first parts are no longer exceptional.
const SETTLED: Duration = Duration::from_secs(5);
/// Duration of a step above which the user is told.
const LONG: Duration = Duration::from_secs(300);
/// Minutes from which hours are easier to read.
const MANY_MINUTES: f64 = 120.0;

/// Steps of some work, one after the other, with a bar on stderr that is drawn on a terminal only and removed on drop.
pub struct Progress {
    bar: ProgressBar,
    /// Name of the first step.
    name: &'static str,
    /// Words for a change of the command that takes less time, as in `a smaller --size`.
    shorter: &'static str,
    /// Step that is being done; `None` before its first parts are done, since these may include preparations.
    step: Cell<Option<Step>>,
}

/// Step that is being done.
#[derive(Clone, Copy, Debug)]
struct Step {
    name: &'static str,
    begun: Instant,
    /// Parts that were done when the step began.
    first: usize,
    done: usize,
    /// True if the user knows that the step is long.
    is_told: bool,
}

impl Step {
    fn new(name: &'static str, first: usize) -> Self {
        Self { name, begun: Instant::now(), first, done: first, is_told: false }
    }

    /// Returns the time that is left after `elapsed` when `done` of the parts `of` are done; `None` for a short step, and as long as it is unknown.
    fn long_rest(&self, elapsed: Duration, done: usize, of: usize) -> Option<Duration> {
        if elapsed < SETTLED || done <= self.first || done >= of {
            return None;
        }
        let left = elapsed.as_secs_f64() * (of - done) as f64 / (done - self.first) as f64;
        let left = Duration::try_from_secs_f64(left).unwrap_or(Duration::MAX);
        (elapsed.saturating_add(left) > LONG).then_some(left)
    }
}

impl Progress {
    /// Returns the progress of work whose first step is called `name`; `shorter` names what takes less time.
    pub fn new(name: &'static str, shorter: &'static str) -> Self {
        let bar = if quiet() { ProgressBar::hidden() } else { ProgressBar::new(1) };
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
            bar.set_style(style);
        }
        bar.set_message(name);
        Self { bar, shorter, name, step: Cell::new(None) }
    }

    /// Returns the progress of `count` parts that have bars of their own, so that this one has none.
    pub fn without_bar(name: &'static str, shorter: &'static str, count: usize) -> Self {
        let bar = ProgressBar::hidden();
        bar.set_length(count as u64);
        Self { bar, shorter, name, step: Cell::new(None) }
    }

    /// Returns the same progress over `count` parts.
    pub fn over(self, count: usize) -> Self {
        self.bar.set_length(count as u64);
        self
    }

    /// Shows that `done` of the parts `of` of the step `name` are done, under this `message`.
    pub fn show_as(&self, name: &'static str, message: impl Into<String>, done: usize, of: usize) {
        self.bar.set_message(message.into());
        self.bar.set_length(of as u64);
        self.bar.set_position(done as u64);
        let same = self.step.get().filter(|step| step.name == name && done >= step.done);
        let mut step = same.unwrap_or_else(|| Step::new(name, done));
        step.done = done;
        if let (false, Some(left)) = (step.is_told, step.long_rest(step.begun.elapsed(), done, of)) {
            step.is_told = true;
            let line =
                format!("{name}: this takes about {} more; {} is shorter", in_words(left), self.shorter);
            self.bar.suspend(|| say(&line));
        }
        self.step.set(Some(step));
    }

    /// Shows that `done` of the parts `of` of the step `name` are done.
    ///
    /// # Errors
    /// Never: a callback that tells progress may cancel the work, and this one does not.
    pub fn show(&self, name: &'static str, done: usize, of: usize) -> Result<()> {
        self.show_as(name, name, done, of);
        Ok(())
    }

    /// Shows that `count` further parts of the step are done.
    pub fn add(&self, count: usize) {
        let (name, done) = self.step.get().map_or((self.name, 0), |step| (step.name, step.done));
        self.show_as(name, name, done + count, self.bar.length().unwrap_or(0) as usize);
    }

    /// Removes the bar until further parts are shown.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Returns a duration as a number of minutes or hours.
fn in_words(duration: Duration) -> String {
    let minutes = duration.as_secs_f64() / 60.0;
    if minutes < MANY_MINUTES {
        format!("{minutes:.0} minutes")
    } else {
        format!("{:.0} hours", minutes / 60.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_of_more_than_five_minutes_is_told_once_its_pace_is_known() {
        let step = Step::new("directions", 10);
        let rest = |seconds, done, of| step.long_rest(Duration::from_secs(seconds), done, of);
        assert_eq!(rest(4, 11, 1000), None, "too early");
        assert_eq!(rest(6, 10, 1000), None, "nothing is done");
        assert_eq!(rest(6, 13, 100), None, "three minutes in all");
        assert_eq!(rest(6, 13, 313), Some(Duration::from_secs(600)));
        assert_eq!(rest(6, 313, 313), None, "done");
        assert_eq!(in_words(Duration::from_secs(600)), "10 minutes");
        assert_eq!(in_words(Duration::from_secs(3 * 3600)), "3 hours");
    }
}
