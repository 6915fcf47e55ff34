//! Raw Vulkan through ash: one object a file, each owning its handle and freeing it when dropped. Nothing here knows
//! what is drawn.
//!
//! Lifetimes nest: instance → device → resources, pipelines, command buffers. Children hold an `Arc` of their parent, so
//! the order of destruction follows from ownership; inside a struct it is the order of the fields.

pub mod access;
pub mod buffer;
pub mod commands;
pub mod descriptors;
pub mod device;
pub mod hazards;
pub mod image;
pub mod instance;
pub mod mask;
pub mod pipeline;
pub mod queries;
pub mod sampler;
pub mod selection;
pub mod semaphore;
#[cfg(feature = "viewer")]
pub mod surface;
#[cfg(feature = "viewer")]
pub mod swapchain;

use crate::error::{Error, Remedies, Remedy};
use crate::memory;
use ash::vk;
use std::borrow::Cow;

/// What to do where a device has no memory.
const LESS_MEMORY: [Remedy; 4] =
    [Remedy::SmallerPicture, Remedy::LargerTolerance, Remedy::ShorterCoherence, Remedy::OtherDevice];
/// What to do where a driver fails and this process may not have all of the machine's memory.
const LIFT_LIMIT: [Remedy; 3] = [
    Remedy::Words(Cow::Borrowed("raise this process' limit of memory (ulimit -v)")),
    Remedy::SmallerPicture,
    Remedy::LargerTolerance,
];

/// Turns a Vulkan result code into an error: what was being done, and what helps.
pub fn failure(doing: &str, code: vk::Result) -> Error {
    let remedy: Remedies = match code {
        // Drivers fail in many ways where they get no memory.
        _ if memory::is_limited() => LIFT_LIMIT.into(),
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => LESS_MEMORY.into(),
        vk::Result::ERROR_DEVICE_LOST => {
            [Remedy::Words("try again; if it recurs, update the driver".into()), Remedy::SoftwareDevice]
                .into()
        }
        _ => [Remedy::Words("update the driver".into()), Remedy::OtherDevice, Remedy::SoftwareDevice].into(),
    };
    Error::failed(format!("Vulkan could not {doing} ({code})"), remedy)
}
