//! Running work: what it reports, and whether it goes on.

use crate::error::{Error, Result};
use std::fmt;
use std::sync::Arc;
#[cfg(test)]
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::{AtomicBool, Ordering};

/// Progress of a stage of some work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Progress {
    /// Name of the stage, as in `orders`.
    pub stage: &'static str,
    /// Number of parts that are done.
    pub done: usize,
    /// Number of parts, as far as it is known.
    pub of: usize,
}

/// Stage of work that evaluates directions.
pub const DIRECTIONS: &str = "directions";
/// Stage of work that reads a file; its parts are MiB.
pub const READING: &str = "reading";
/// Stage of work that prepares a surface.
pub const PREPARATION: &str = "preparation";
/// Stage of work that measures a surface.
pub const STATISTICS: &str = "statistics";
/// Stage of work that computes orders.
pub const ORDERS: &str = "orders";
/// Stage of work that draws a picture in pieces; its parts are pixels of its passes.
pub const PIECES: &str = "pieces";

/// Receiver of the progress of some work.
type Observer = dyn Fn(Progress) + Send + Sync;

/// Handle of running work: the work reports its progress to it, and whoever holds it may cancel the work.
///
/// Clones are the same task: it is cancelled through any of them, from any thread. Work that is cancelled ends with an error,
/// [`Error::is_cancelled`], when it next reports.
#[derive(Clone, Default)]
pub struct Task {
    observer: Option<Arc<Observer>>,
    cancelled: Arc<AtomicBool>,
}

impl Task {
    /// Returns a task whose progress nobody sees. It may be cancelled.
    pub fn silent() -> Self {
        Self::default()
    }

    /// Returns a task that calls `observer` with the progress of the work, from the threads that do it.
    pub fn reporting(observer: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Self::silent().observed(observer)
    }
}

#[doc(hidden)]
impl Task {
    /// Returns a task that is cancelled with this one, and calls `observer` with the progress of its work.
    #[must_use]
    pub fn observed(&self, observer: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Self { observer: Some(Arc::new(observer)), cancelled: Arc::clone(&self.cancelled) }
    }

    /// Returns a task that is cancelled by the first report for which `goes_on` returns false.
    pub fn while_true(goes_on: impl Fn(Progress) -> bool + Send + Sync + 'static) -> Self {
        let task = Self::silent();
        let cancelled = task.clone();
        task.observed(move |progress| {
            if !goes_on(progress) {
                cancelled.cancel();
            }
        })
    }

    /// Returns the same task for work whose progress nobody sees.
    #[must_use]
    pub fn unseen(&self) -> Self {
        Self { observer: None, cancelled: Arc::clone(&self.cancelled) }
    }

    /// Returns the task of a part of this work, cancelled with it. `seen_as` turns the part's progress into that of the whole.
    #[must_use]
    pub fn part(&self, seen_as: impl Fn(Progress) -> Progress + Send + Sync + 'static) -> Self {
        match self.observer.clone() {
            Some(whole) => self.observed(move |progress| whole(seen_as(progress))),
            None => self.clone(),
        }
    }

    /// Returns the same task for work whose stages are all seen as `stage`.
    #[must_use]
    pub fn named(&self, stage: &'static str) -> Self {
        self.part(move |progress| Progress { stage, ..progress })
    }

    /// Returns the task of part number `number` of `parts` equal ones.
    #[must_use]
    pub fn share(&self, number: usize, parts: usize) -> Self {
        self.part(move |Progress { stage, done, of }| Progress {
            stage,
            done: number * of + done,
            of: parts * of,
        })
    }
}

impl Task {
    /// Cancels the work.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns true if the work is cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Reports that `done` of the parts `of` of the `stage` are done.
    ///
    /// # Errors
    /// Fails if the work is cancelled.
    pub fn report(&self, stage: &'static str, done: usize, of: usize) -> Result<()> {
        self.check()?;
        if let Some(observer) = &self.observer {
            observer(Progress { stage, done, of });
        }
        self.check()
    }

    /// Returns an error if the work is cancelled.
    ///
    /// # Errors
    /// Fails if the work is cancelled.
    pub fn check(&self) -> Result<()> {
        if self.is_cancelled() { Err(Error::cancelled()) } else { Ok(()) }
    }
}

impl fmt::Debug for Task {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Task")
            .field("reports", &self.observer.is_some())
            .field("is_cancelled", &self.is_cancelled())
            .finish()
    }
}

#[cfg(test)]
impl Task {
    /// Returns a task that is cancelled by its report number `last`, from 1, and the number of reports so far.
    pub fn cancelled_at(last: usize) -> (Self, Arc<AtomicUsize>) {
        let reports = Arc::new(AtomicUsize::new(0));
        let plain = Self::silent();
        let task = plain.observed({
            let (reports, plain) = (Arc::clone(&reports), plain.clone());
            move |_| {
                if reports.fetch_add(1, Ordering::Relaxed) + 1 == last {
                    plain.cancel();
                }
            }
        });
        (task, reports)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn progress_of_parts_is_seen_as_that_of_the_whole_and_all_are_cancelled_together() {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let task = Task::reporting({
            let seen = Arc::clone(&seen);
            move |Progress { stage, done, of }| seen.lock().unwrap().push((stage, done, of))
        });
        task.report("orders", 1, 4).unwrap();
        let part = task.named("settings").share(2, 3);
        part.report("orders", 1, 4).unwrap();
        assert_eq!(*seen.lock().unwrap(), [("orders", 1, 4), ("settings", 9, 12)]);
        part.cancel();
        assert!(task.is_cancelled() && task.clone().check().is_err_and(|e| e.is_cancelled()));
        assert!(!Task::silent().is_cancelled());
    }

    #[test]
    fn work_that_is_cancelled_in_a_report_ends_at_that_report() {
        let (task, reports) = Task::cancelled_at(3);
        let done = (0..9).take_while(|i| task.report("orders", *i, 9).is_ok()).count();
        assert_eq!((done, reports.load(Ordering::Relaxed)), (2, 3));
    }
}
