//! The command line.

use diffract::Context;
use diffract::program::{self, Streams};
use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the program on `words`, its name first, with the streams of the process; returns its exit code.
#[pyfunction]
pub fn run(py: Python<'_>, words: Vec<OsString>, validates: bool) -> u8 {
    py.detach(|| {
        let context = Context::new().with_validation(validates);
        program::run(words, Streams::of_process(), &context)
    })
}

/// Returns the version of this module.
#[pyfunction]
pub fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}
