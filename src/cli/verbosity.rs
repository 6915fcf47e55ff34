//! How much the program tells on stderr beside its results and its errors.

use super::print;
use clap::Args;
use std::fmt::Display;
use std::sync::atomic::{AtomicU8, Ordering};

const QUIET: u8 = 0;
const NORMAL: u8 = 1;
const VERBOSE: u8 = 2;

/// What the process was asked for.
static LEVEL: AtomicU8 = AtomicU8::new(NORMAL);

/// Options of every command.
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Program")]
pub struct Verbosity {
    /// Tell more on stderr: what a picture's pixels cover
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Tell nothing on stderr but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
}

impl Verbosity {
    /// Makes it what the process goes by.
    pub fn apply(self) {
        let level = match (self.quiet, self.verbose) {
            (true, _) => QUIET,
            (_, true) => VERBOSE,
            _ => NORMAL,
        };
        LEVEL.store(level, Ordering::Relaxed);
    }
}

/// Whether nothing but errors is wanted.
pub fn quiet() -> bool {
    LEVEL.load(Ordering::Relaxed) == QUIET
}

/// One line on stderr that a user should know.
pub fn say(line: &dyn Display) {
    if !quiet() {
        print(line);
    }
}

/// One line on stderr for who asks for more.
pub fn detail(line: &dyn Display) {
    if LEVEL.load(Ordering::Relaxed) == VERBOSE {
        print(line);
    }
}
