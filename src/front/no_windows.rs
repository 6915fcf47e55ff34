//! Responses through single windows, without the renderer: there are none.

use crate::context::Context;
use crate::error::{Error, Result};
use crate::measure::sweep::SweepPlane;
use crate::settings::Optics;
use crate::surface::HeightField;
use crate::task::Task;

/// Fails, because single windows are summed on a device.
///
/// # Errors
/// Always.
pub fn responses(_: &SweepPlane, _: &Optics, _: &HeightField, _: &Context, _: &Task) -> Result<Vec<f64>> {
    Err(Error::device("single windows are summed on a Vulkan device", "build with the feature `vulkan`"))
}
