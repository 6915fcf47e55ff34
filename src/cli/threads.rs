//! Threads for sums and transforms. They exist before the pool that uses them is built: a pool that gets fewer threads than it asks for cannot be built again.

use super::console::Console;
use crate::memory;
use rayon::{ThreadBuilder, ThreadPoolBuilder};
use std::io;
use std::num::NonZero;
use std::sync::mpsc::{Sender, channel};

/// Variable with the number of threads that a user wants, as every program that computes with rayon has.
const VARIABLE: &str = "RAYON_NUM_THREADS";

/// Starts as many threads as the machine runs at once, or fewer where memory or the system allows no more. Without any, the calling thread does everything.
pub fn start(console: &Console) {
    let wanted = wanted();
    let affordable = memory::affordable_threads(wanted);
    let idle = idle_threads(affordable);
    let started = idle.len();
    if started < affordable {
        console.say(&format_args!(
            "the system gives {started} of {wanted} threads: sums and transforms take longer"
        ));
    } else if started < wanted {
        console.detail(&format_args!(
            "memory suffices for {started} of {wanted} threads: sums and transforms take longer"
        ));
    }
    let mut idle = idle.into_iter();
    let built = match started {
        0 => ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global(),
        _ => ThreadPoolBuilder::new()
            .num_threads(started)
            .spawn_handler(|thread| {
                let ended = || io::Error::other("a thread has ended");
                idle.next().ok_or_else(ended)?.send(thread).map_err(|_| ended())
            })
            .build_global(),
    };
    if let Err(e) = built {
        console.detail(&format_args!("the threads are not those of this program: {e}"));
    }
}

/// Returns the number of threads that the user asks for, or that the machine runs at once.
fn wanted() -> usize {
    let asked = std::env::var(VARIABLE).ok().and_then(|text| text.parse().ok()).filter(|count| *count > 0);
    asked.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, NonZero::get))
}

/// Returns the ends of `count` threads, or of as many as the system gives, each of which waits for its part in a pool.
fn idle_threads(count: usize) -> Vec<Sender<ThreadBuilder>> {
    let thread = |number: usize| {
        let (sender, receiver) = channel::<ThreadBuilder>();
        let work = move || {
            if let Ok(part) = receiver.recv() {
                part.run();
            }
        };
        let started = std::thread::Builder::new().name(format!("sums {number}")).spawn(work);
        started.is_ok().then_some(sender)
    };
    (0..count).map_while(thread).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_that_wait_take_part_in_a_pool_and_end_without_one() {
        let mut idle = idle_threads(2).into_iter();
        assert_eq!(idle.len(), 2);
        let pool = ThreadPoolBuilder::new().num_threads(2).spawn_handler(|thread| {
            idle.next().map(|sender| sender.send(thread).unwrap()).ok_or_else(|| io::Error::other("none"))
        });
        assert_eq!(pool.build().unwrap().install(rayon::current_num_threads), 2);
        drop(idle_threads(1));
    }
}
