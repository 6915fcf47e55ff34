//! Work on a thread beside the interpreter: the caller waits, sees the progress and may be interrupted; the work goes on while other threads run Python.

use crate::context::CoreContext;
use crate::errors::{Cancelled, raised};
use diffract::{Context, Progress, Task};
use pyo3::exceptions::{PyRuntimeError, PyUserWarning};
use pyo3::prelude::*;
use std::any::Any;
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Time between two looks for signals and progress.
const TICK: Duration = Duration::from_millis(50);
/// Time that cancelled work has to end before its caller goes on without it.
const PATIENCE: Duration = Duration::from_millis(500);
/// Time that all work has to end before the interpreter does.
const LAST_PATIENCE: Duration = Duration::from_secs(10);
/// Stack of the thread \[bytes\]: the usual one of a process.
const STACK: usize = 8 << 20;
/// Distance of the user's line from this code: a function of this package stands between them.
const STACK_LEVEL: i32 = 2;

/// Work that runs now, and whether more may begin.
struct Running {
    /// Number of the process: work of the parent does not run in a child.
    process: u32,
    tasks: Vec<(u64, Task)>,
    next: u64,
    is_over: bool,
}

static RUNNING: Mutex<Running> =
    Mutex::new(Running { process: 0, tasks: Vec::new(), next: 0, is_over: false });
static ENDED: Condvar = Condvar::new();

fn running() -> MutexGuard<'static, Running> {
    let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner); // whole at any time
    if running.process != std::process::id() {
        running.process = std::process::id();
        running.tasks.clear();
    }
    running
}

/// Place of a task among those that run; gone with this value.
struct Place(u64);

impl Place {
    /// Enters `task`; `None` once the interpreter ends.
    fn of(task: &Task) -> Option<Self> {
        let mut running = running();
        if running.is_over {
            return None;
        }
        let number = running.next;
        running.next += 1;
        running.tasks.push((number, task.clone()));
        Some(Self(number))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        running().tasks.retain(|(number, _)| *number != self.0);
        ENDED.notify_all();
    }
}

/// Cancels all work and waits until it has ended: the interpreter is about to end, and the libraries below with it.
#[pyfunction]
pub fn end_all(py: Python<'_>) {
    py.detach(|| {
        let mut running = running();
        running.is_over = true;
        running.tasks.iter().for_each(|(_, task)| task.cancel());
        let deadline = Instant::now() + LAST_PATIENCE;
        while !running.tasks.is_empty() {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            running = ENDED.wait_timeout(running, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    });
}

/// Latest progress and notes of some work, which its caller shows.
#[derive(Clone, Default)]
struct Seen {
    /// Latest progress that was not shown yet.
    progress: Arc<Mutex<Option<Progress>>>,
    /// Notes for the user.
    notes: Arc<Mutex<Vec<String>>>,
}

impl Seen {
    fn task(&self) -> Task {
        let latest = Arc::clone(&self.progress);
        Task::reporting(move |progress| {
            *latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(progress);
        })
    }

    fn context(&self, context: Context) -> Context {
        let notes = Arc::clone(&self.notes);
        context.with_notes(move |note| {
            notes.lock().unwrap_or_else(PoisonError::into_inner).push(note.to_string());
        })
    }

    /// Calls `observer` with progress that is new, and lets handlers of signals run.
    fn tick(&self, py: Python<'_>, observer: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        py.check_signals()?;
        let latest = self.progress.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some((observer, Progress { done, of, stage, .. })) = observer.zip(latest) {
            observer.call1((done, of, stage))?;
        }
        Ok(())
    }

    /// Warns of what the user should know.
    fn warn(&self, py: Python<'_>) -> PyResult<()> {
        let notes = std::mem::take(&mut *self.notes.lock().unwrap_or_else(PoisonError::into_inner));
        notes.iter().try_for_each(|note| warn(py, note))
    }
}

/// Warns of `note`, at the line of the user.
pub fn warn(py: Python<'_>, note: &str) -> PyResult<()> {
    let text = CString::new(note.replace('\0', " ")).unwrap_or_default();
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, STACK_LEVEL)
}

/// Outcome of work: a result of the library, or a panic.
type Outcome<T> = thread::Result<diffract::Result<T>>;

/// Runs `work` in `context`, while `observer` is called with (done, of, stage) and signals are obeyed.
///
/// # Errors
/// Fails with the error of the work, with what the observer or a handler of a signal raises, or once the interpreter ends.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    context: &CoreContext,
    observer: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Context, &Task) -> diffract::Result<T> + Send + 'static,
) -> PyResult<T> {
    let seen = Seen::default();
    let (context, task) = (seen.context(context.of_process().map_err(raised)?), seen.task());
    let over = || Cancelled::new_err("cancelled, because the program ends");
    let place = Place::of(&task).ok_or_else(over)?;
    let (sender, receiver) = sync_channel(1);
    let started = thread::Builder::new().name("diffract".to_owned()).stack_size(STACK).spawn({
        let task = task.clone();
        move || {
            let outcome = catch_unwind(AssertUnwindSafe(|| context.run(|| work(&context, &task))));
            // Devices and caches are let go before the place among running work is.
            drop(context);
            let _ = sender.send(outcome); // a caller that went on has no ear
            drop(place);
        }
    });
    started.map_err(|e| {
        PyRuntimeError::new_err(format!("the system gives no thread ({e}); end other programs"))
    })?;
    let outcome = wait(py, receiver, &seen, observer, &task)?;
    seen.warn(py)?;
    outcome.unwrap_or_else(|panic: Box<dyn Any + Send>| resume_unwind(panic)).map_err(raised)
}

/// Waits for the outcome of the work of `task`.
fn wait<T: Send>(
    py: Python<'_>,
    receiver: Receiver<Outcome<T>>,
    seen: &Seen,
    observer: Option<&Bound<'_, PyAny>>,
    task: &Task,
) -> PyResult<Outcome<T>> {
    let receiver = Mutex::new(receiver);
    let within = |patience: Duration| {
        py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(patience))
    };
    loop {
        match within(TICK) {
            Ok(outcome) => {
                seen.tick(py, observer)?;
                return Ok(outcome);
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(stop) = seen.tick(py, observer) {
                    task.cancel();
                    let _ = within(PATIENCE); // work that takes longer to stop ends by itself
                    return Err(stop);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err(
                    "the work has ended without a result; report this as a bug of diffract",
                ));
            }
        }
    }
}
