//! Progress of long work: a bar on a terminal, and one line about work that takes many minutes.

use super::console::Console;
use crate::task::{PREPARATION, Progress, Task};
use indicatif::ProgressStyle;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time after which a step tells how long it takes: its first parts are no longer exceptional.
const SETTLED: Duration = Duration::from_secs(5);
/// Duration of a step above which the user is told.
const LONG: Duration = Duration::from_secs(300);
/// Minutes from which hours are easier to read.
const MANY_MINUTES: f64 = 120.0;

/// Words for what makes the preparation of a surface shorter.
pub const LESS_WORK: &str = "a part of the surface (--crop), or a larger --tolerance,";

/// Returns the task of work on a surface itself: its preparation and statistics. It has a bar of its own.
pub fn surface_task(console: &Console) -> Task {
    ProgressBar::new(console, PREPARATION, LESS_WORK).task()
}

/// Bar on stderr that shows the steps of some work, one after the other. It is drawn on a terminal only, and removed with its last clone.
#[derive(Clone)]
pub struct ProgressBar {
    shared: Arc<SharedBar>,
}

/// Parts of a bar that its clones share.
struct SharedBar {
    console: Console,
    bar: indicatif::ProgressBar,
    /// Name of the main step.
    name: &'static str,
    /// Words for a change of the command with which the main step takes less time, as in `a smaller --size`.
    shorter: &'static str,
    /// Parts of the main step.
    count: usize,
    /// Parts of the main step that are done.
    counted: AtomicUsize,
    /// Step that is being done; `None` before its first parts are done, since these may include preparations.
    step: Mutex<Option<Step>>,
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

impl ProgressBar {
    /// Returns the bar of work whose main step is called `name`; `shorter` names what takes less time.
    pub fn new(console: &Console, name: &'static str, shorter: &'static str) -> Self {
        Self::over(console, name, shorter, 0)
    }

    /// Returns the bar of work whose main step, called `name`, has `count` parts.
    pub fn over(console: &Console, name: &'static str, shorter: &'static str, count: usize) -> Self {
        let bar = if console.has_bars() {
            indicatif::ProgressBar::new(1)
        } else {
            indicatif::ProgressBar::hidden()
        };
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
            bar.set_style(style);
        }
        bar.set_message(name);
        Self::shared(console, bar, name, shorter, count)
    }

    /// Returns the bar of `count` parts that have bars of their own, so that this one is not drawn.
    pub fn hidden(console: &Console, name: &'static str, shorter: &'static str, count: usize) -> Self {
        Self::shared(console, indicatif::ProgressBar::hidden(), name, shorter, count)
    }

    fn shared(
        console: &Console,
        bar: indicatif::ProgressBar,
        name: &'static str,
        shorter: &'static str,
        count: usize,
    ) -> Self {
        let (counted, step) = (AtomicUsize::new(0), Mutex::new(None));
        let console = console.clone();
        Self { shared: Arc::new(SharedBar { console, bar, name, shorter, count, counted, step }) }
    }

    /// Returns a task whose progress the bar shows.
    pub fn task(&self) -> Task {
        let bar = self.clone();
        Task::reporting(move |progress| bar.show(&progress))
    }

    /// Returns a task for a few parts of the main step, which [`Self::add`] counts. The bar shows its other steps.
    pub fn task_of_parts(&self) -> Task {
        let bar = self.clone();
        Task::reporting(move |progress| {
            if progress.stage != bar.shared.name {
                bar.show(&progress);
            }
        })
    }

    /// Shows `progress`.
    pub fn show(&self, progress: &Progress) {
        self.show_as(progress, progress.stage);
    }

    /// Shows `progress` under this `message`.
    pub fn show_as(&self, &Progress { stage, done, of, .. }: &Progress, message: impl Into<String>) {
        let SharedBar { bar, step, .. } = &*self.shared;
        bar.set_message(message.into());
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        let mut step = step.lock().unwrap_or_else(PoisonError::into_inner);
        let mut now =
            step.filter(|step| step.name == stage && done >= step.done).unwrap_or(Step::new(stage, done));
        now.done = done;
        if let (false, Some(left)) = (now.is_told, now.long_rest(now.begun.elapsed(), done, of)) {
            now.is_told = true;
            let shorter = if stage == self.shared.name { self.shared.shorter } else { LESS_WORK };
            let line = format!("{stage}: this takes about {} more; {shorter} is shorter", in_words(left));
            bar.suspend(|| self.shared.console.say(&line));
        }
        *step = Some(now);
    }

    /// Shows that `count` further parts of the main step are done.
    pub fn add(&self, count: usize) {
        let SharedBar { name, counted, count: of, .. } = &*self.shared;
        let done = counted.fetch_add(count, Ordering::Relaxed) + count;
        self.show(&Progress { stage: name, done, of: *of });
    }

    /// Removes the bar until further parts are shown.
    pub fn clear(&self) {
        self.shared.bar.finish_and_clear();
    }
}

impl Drop for SharedBar {
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
