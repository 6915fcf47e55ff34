//! Work that shows how far it is and is cancelled: `cargo run --example progress -- 2` cancels it after two seconds. Without Vulkan.

#![allow(clippy::print_stdout, reason = "printing is what an example does")]

use diffract::prelude::*;
use std::thread;
use std::time::Duration;

fn main() -> Result<()> {
    let seconds = std::env::args().nth(1).and_then(|text| text.parse().ok());
    let field = synth::generate(&Spec::new(SurfaceKind::Elaphe))?;
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
    let settings = PowerSettings::new(20.0 / 4.0, Beyond::Copies, 1e-3);
    match OrderSeries::new(&field, &settings, &task) {
        Ok(series) => println!("a series of {} terms", series.terms),
        Err(error) if error.is_cancelled() => println!("cancelled"),
        Err(error) => return Err(error),
    }
    Ok(())
}
