//! The `diffract` program; everything is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    diffract::cli::main()
}
