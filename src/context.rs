//! Cache, threads, device and receiver of notes, which a program chooses once for everything that it asks of this library.

#[cfg(feature = "vulkan")]
mod pipelines;
#[cfg(feature = "vulkan")]
mod vulkan;

use crate::cache::{DEFAULT_LIMIT, Store};
use crate::error::{Error, Result};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// Receiver of notes for the user.
type Listener = dyn Fn(&Error) + Send + Sync;

/// Stack of a thread of a context \[bytes\]: the usual one of a process.
const STACK: usize = 8 << 20;

/// Cache, threads, device and receiver of notes of a part of a program.
///
/// Clones share them. Several contexts work side by side in one process, each with a cache and threads of its own.
#[derive(Clone, Default)]
pub struct Context {
    store: Option<Store>,
    threads: Option<Arc<ThreadPool>>,
    listener: Option<Arc<Listener>>,
    #[cfg(feature = "vulkan")]
    vulkan: vulkan::Vulkan,
}

impl Context {
    /// Returns a context with the user's cache, the threads of the process, the best device of the machine, and nobody who receives notes.
    pub fn new() -> Self {
        Self::default().with_cache_limit(DEFAULT_LIMIT)
    }

    /// Returns the context with the cache in `folder`, which holds at most `limit` bytes; 0 turns it off. A folder that does not exist is made.
    #[must_use]
    pub fn with_cache(self, folder: impl Into<PathBuf>, limit: u64) -> Self {
        Self { store: (limit > 0).then(|| Store::at(folder, limit)), ..self }
    }

    /// Returns the context with a cache of at most `limit` bytes; 0 turns it off. The folder stays, or is the user's if there is none.
    #[must_use]
    pub fn with_cache_limit(self, limit: u64) -> Self {
        let store = match &self.store {
            Some(store) => (limit > 0).then(|| Store::at(store.folder(), limit)),
            None => Store::of_user(limit),
        };
        Self { store, ..self }
    }

    /// Returns the context without a cache: what is computed is lost with the program.
    #[must_use]
    pub fn without_cache(self) -> Self {
        Self { store: None, ..self }
    }

    /// Returns the context with `count` threads of its own.
    ///
    /// # Errors
    /// Fails for no thread, and if the system gives too few.
    pub fn with_threads(self, count: usize) -> Result<Self> {
        if count == 0 {
            return Err(Error::usage("a context without threads does nothing", "give 1 or more"));
        }
        let pool = ThreadPoolBuilder::new().num_threads(count).stack_size(STACK).build();
        let pool = pool.map_err(|e| {
            Error::limit(format!("the system does not give {count} threads ({e})"), "ask for fewer")
                .caused_by(e)
        })?;
        Ok(Self { threads: Some(Arc::new(pool)), ..self })
    }

    /// Returns the context whose notes `listener` receives: what does not end the work, but may surprise, such as a result that cannot be cached.
    #[must_use]
    pub fn with_notes(self, listener: impl Fn(&Error) + Send + Sync + 'static) -> Self {
        Self { listener: Some(Arc::new(listener)), ..self }
    }

    /// Returns the result of `work`, whose sums and transforms run on the threads of the context.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.threads {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Returns the store of what is computed; `None` without a cache.
    pub(crate) fn store(&self) -> Option<&Store> {
        self.store.as_ref()
    }

    /// Gives `note` to the listener.
    pub(crate) fn tell(&self, note: &Error) {
        if let Some(listener) = &self.listener {
            listener(note);
        }
    }
}

impl fmt::Debug for Context {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Context")
            .field("cache", &self.store)
            .field("threads", &self.threads.as_ref().map(|pool| pool.current_num_threads()))
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn contexts_have_caches_threads_and_notes_of_their_own() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let one = Context::default().with_cache("/nowhere/one", 5).with_threads(1).unwrap();
        let two = one.clone().with_cache_limit(7).with_threads(3).unwrap();
        let limit = |context: &Context| context.store().map(Store::limit);
        assert_eq!((limit(&one), limit(&two), limit(&two.clone().without_cache())), (Some(5), Some(7), None));
        assert_eq!(two.store().unwrap().folder(), one.store().unwrap().folder());
        assert_eq!([&one, &two].map(|context| context.run(rayon::current_num_threads)), [1, 3]);
        let told = one.with_notes({
            let heard = Arc::clone(&heard);
            move |note| heard.lock().unwrap().push(note.to_string())
        });
        two.tell(&Error::bug("nobody hears"));
        told.tell(&Error::files("lost", "again"));
        assert_eq!(*heard.lock().unwrap(), ["lost; again"]);
        assert!(two.with_threads(0).is_err());
    }
}
