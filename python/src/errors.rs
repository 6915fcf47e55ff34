//! Errors of the library as exceptions. The text of each tells what failed, and the remedy.

use diffract::{Error, ErrorKind};
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyMemoryError, PyOSError, PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    diffract,
    Cancelled,
    PyException,
    "Work that ended before it was done, because the program ends."
);
create_exception!(
    diffract,
    DeviceError,
    PyException,
    "No Vulkan device, or one that is unfit or lost. The text says what to install."
);

/// Returns the exception for `error`.
pub fn raised(error: Error) -> PyErr {
    let text = error.to_string();
    match error.kind() {
        ErrorKind::Usage | ErrorKind::Input | ErrorKind::Limit => PyValueError::new_err(text),
        ErrorKind::Files => PyOSError::new_err(text),
        ErrorKind::Memory => PyMemoryError::new_err(text),
        ErrorKind::Device => DeviceError::new_err(text),
        ErrorKind::Cancelled => Cancelled::new_err(text),
        _ => PyRuntimeError::new_err(text),
    }
}

/// Returns the exception for the argument called `name`: what is wrong with it, and the remedy.
pub fn argument(name: &str, what: impl std::fmt::Display, remedy: &str) -> PyErr {
    PyValueError::new_err(format!("{name} {what}; {remedy}"))
}

/// Returns the exception for an argument of another type than the one called `name` takes.
pub fn wrong_type(name: &str, what: impl std::fmt::Display) -> PyErr {
    PyTypeError::new_err(format!("{name} {what}"))
}
