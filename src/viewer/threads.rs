//! Threads behind the window.

use crate::error::{self, Error, Result};
use std::process;
use std::thread::{Builder, JoinHandle, panicking};

/// Exit code of a process that has panicked, as Rust's own.
const PANICKED: i32 = 101;

/// Starts a thread called `name` that does `work`. A panic in it, which is a bug, ends the process: the window would wait for the thread for ever.
///
/// # Errors
/// Fails if the system refuses a thread.
pub fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>> {
    let guarded = || {
        let _guard = EndsProcess;
        work();
    };
    Builder::new().name(name.to_owned()).spawn(guarded).map_err(|e| {
        Error::memory(format!("the system refuses a thread: {}", error::cause(&e)), "close other programs")
            .caused_by(e)
    })
}

/// Guard that ends the process when it is dropped by a panic.
struct EndsProcess;

impl Drop for EndsProcess {
    fn drop(&mut self) {
        if panicking() {
            // Rust has printed the panic and its place.
            process::exit(PANICKED);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_does_its_work_under_its_name() {
        let (sender, receiver) = std::sync::mpsc::channel();
        let work = move || sender.send(std::thread::current().name().map(str::to_owned)).unwrap();
        spawn("layers", work).unwrap().join().unwrap();
        assert_eq!(receiver.recv().unwrap().as_deref(), Some("layers"));
    }

    #[test]
    fn a_panic_in_a_thread_ends_the_process() {
        const PANICS: &str = "DIFFRACT_TEST_PANICS";
        if std::env::var_os(PANICS).is_some() {
            let thread = spawn("layers", || panic!("as it is tested")).unwrap();
            let _ = thread.join(); // never returns
            std::thread::park();
        }
        let name = "internals::viewer::threads::tests::a_panic_in_a_thread_ends_the_process";
        let program = process::Command::new(std::env::current_exe().unwrap());
        let ended = { program }.args(["--exact", name]).env(PANICS, "1").output().unwrap();
        assert_eq!(ended.status.code(), Some(PANICKED));
    }
}
