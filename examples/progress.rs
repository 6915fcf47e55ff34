//! Work that shows how far it is and is cancelled: `cargo run --example progress -- 2` cancels it after two seconds. Without Vulkan.

#![allow(clippy::print_stdout, reason = "printing is what an example does")]

use diffract::{Context, HeightField, Optics, Result, Spec, SurfaceColours, SurfaceKind, Task};
use std::thread;
use std::time::Duration;

fn main() -> Result<()> {
    let seconds = std::env::args().nth(1).and_then(|text| text.parse().ok());
    let field = HeightField::generate(&Spec::new(SurfaceKind::Elaphe))?;
    let task =
        Task::reporting(|progress| println!("{}: {} of {}", progress.stage, progress.done, progress.of));
    // A task is cancelled from any thread: here by a clock, in a program by a button.
    if let Some(seconds) = seconds {
        let task = task.clone();
        thread::spawn(move || {
            thread::sleep(Duration::from_secs_f64(seconds));
            task.cancel();
        });
    }
    // Two threads of its own, and no cache: each run does the whole work.
    let context = Context::new().without_cache().with_threads(2)?;
    let optics = Optics::new().with_coherence_length(20.0).with_tolerance(5e-2);
    match SurfaceColours::new(&field, &optics, 0.0, &context, &task) {
        Ok(colours) => println!("a table of {} bytes", colours.bytes()),
        Err(error) if error.is_cancelled() => println!("cancelled"),
        Err(error) => return Err(error),
    }
    Ok(())
}
