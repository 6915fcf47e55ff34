//! Amount of text on stderr beside results and errors.

use super::print;
use clap::Args;
use std::fmt::Display;
use std::sync::atomic::{AtomicU8, Ordering};

const QUIET: u8 = 0;
const NORMAL: u8 = 1;
const VERBOSE: u8 = 2;

/// Level that the user asked for.
static LEVEL: AtomicU8 = AtomicU8::new(NORMAL);

/// Options of every command.
#[derive(Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Program")]
pub struct Verbosity {
    /// Print more on stderr
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Print nothing on stderr but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
}

impl Verbosity {
    /// Sets the level of the process.
    pub fn apply(self) {
        let level = match (self.quiet, self.verbose) {
            (true, _) => QUIET,
            (_, true) => VERBOSE,
            _ => NORMAL,
        };
        LEVEL.store(level, Ordering::Relaxed);
    }
}

/// Returns true if only errors are wanted.
pub fn quiet() -> bool {
    LEVEL.load(Ordering::Relaxed) == QUIET
}

/// Prints one line that a user should know on stderr.
pub fn say(line: &dyn Display) {
    if !quiet() {
        print(line);
    }
}

/// Prints one line on stderr if the user asked for more.
pub fn detail(line: &dyn Display) {
    if LEVEL.load(Ordering::Relaxed) == VERBOSE {
        print(line);
    }
}
