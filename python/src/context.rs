//! Cache, threads and device of calls.

use crate::errors::raised;
use diffract::Context;
use pyo3::prelude::*;
use std::num::NonZero;
use std::path::PathBuf;
use std::sync::{LazyLock, Mutex, PoisonError};

/// Number of the process that imported the module.
static IMPORTER: LazyLock<u32> = LazyLock::new(std::process::id);

/// Returns true in a process that was forked off the one that imported the module: it has none of its threads. The import asks first.
pub fn is_fork() -> bool {
    *IMPORTER != std::process::id()
}

/// Settings of a context, and the context of this process.
#[pyclass(frozen, module = "diffract._diffract")]
pub struct CoreContext {
    folder: Option<PathBuf>,
    limit: u64,
    threads: Option<usize>,
    device: Option<String>,
    /// Number of the process that made the context, and the context: threads and devices do not survive a fork.
    made: Mutex<(u32, Context)>,
}

#[pymethods]
impl CoreContext {
    /// Makes a context with the cache in `folder`, or the user's, which holds at most `limit` bytes; with so many threads, or those of the process; on the `device` of this
    /// name.
    #[new]
    fn new(
        folder: Option<PathBuf>,
        limit: u64,
        threads: Option<usize>,
        device: Option<String>,
    ) -> PyResult<Self> {
        let made = Self::make(folder.as_ref(), limit, threads, device.as_deref()).map_err(raised)?;
        Ok(Self { folder, limit, threads, device, made: Mutex::new((std::process::id(), made)) })
    }
}

impl CoreContext {
    fn make(
        folder: Option<&PathBuf>,
        limit: u64,
        threads: Option<usize>,
        device: Option<&str>,
    ) -> diffract::Result<Context> {
        let context = match folder {
            Some(folder) => Context::default().with_cache(folder, limit),
            None => Context::default().with_cache_limit(limit),
        };
        let context = threads.map_or(Ok(context.clone()), |count| context.with_threads(count))?;
        match device {
            Some(name) => context.with_device(name),
            None => Ok(context),
        }
    }

    /// Returns the context in this process: after a fork, one with threads of its own.
    pub fn of_process(&self) -> diffract::Result<Context> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner); // whole at any time
        if made.0 != std::process::id() {
            let all = || std::thread::available_parallelism().map_or(1, NonZero::get);
            let threads = Some(self.threads.unwrap_or_else(all));
            let context = Self::make(self.folder.as_ref(), self.limit, threads, self.device.as_deref())?;
            // The context of the parent is left alone: its threads do not exist here.
            std::mem::forget(std::mem::replace(&mut *made, (std::process::id(), context)));
        }
        Ok(made.1.clone())
    }
}
