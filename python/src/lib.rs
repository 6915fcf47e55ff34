//! The part of the Python module `diffract` that is written in Rust: numbers and arrays in, numbers and arrays out. The classes that users see, with their documentation, stand in
//! `diffract/*.py`.
//!
//! Everything is asked of the front of the library, in micrometres. `inside` has what the front lacks.

mod arrays;
mod brdf;
mod context;
mod errors;
mod field;
mod inside;
mod optics;
mod orders;
mod program;
mod scene;
mod table;
mod units;
mod work;

use pyo3::prelude::*;

/// Everything that the Python files of this module import.
#[pymodule]
mod _diffract {
    #[pymodule_export]
    use crate::arrays::{direction, linear_srgb, srgb};
    #[pymodule_export]
    use crate::brdf::CoreBrdf;
    #[pymodule_export]
    use crate::context::CoreContext;
    #[pymodule_export]
    use crate::errors::{Cancelled, DeviceError};
    #[pymodule_export]
    use crate::field::CoreField;
    #[pymodule_export]
    use crate::optics::CoreOptics;
    #[pymodule_export]
    use crate::orders::{orders, peaks};
    #[pymodule_export]
    use crate::program::{run, version};
    #[pymodule_export]
    use crate::scene::{CoreLight, CoreMesh, CoreObject, CoreScene, render};
    #[pymodule_export]
    use crate::table::CoreTable;
    #[pymodule_export]
    use crate::units::{metres_of, micrometres_of};
    #[pymodule_export]
    use crate::work::end_all;

    /// Notes which process imports the module.
    #[pymodule_init]
    fn note_process() {
        crate::context::is_fork();
    }
}
