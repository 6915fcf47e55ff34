//! Vulkan through ash: one object per file, each owning its handle and freeing it when dropped. Nothing here depends on
//! the scene.
//!
//! Lifetimes nest: instance → device → resources, pipelines, command buffers. Children hold an `Arc` of their parent,
//! so that ownership gives the order of destruction; inside a struct it is the order of the fields.

pub mod access;
pub mod buffer;
pub mod commands;
pub mod descriptors;
pub mod device;
pub mod event_log;
mod idle_pipelines;
pub mod image;
pub mod instance;
pub mod mask;
pub mod pipeline;
pub mod pipeline_cache;
pub mod queries;
pub mod sampler;
pub mod selection;
pub mod semaphore;
#[cfg(feature = "viewer")]
pub mod swapchain;
#[cfg(feature = "viewer")]
pub mod window_surface;

use crate::error::{Error, Remedies, Remedy};
use crate::memory;
use ash::vk;
use std::borrow::Cow;

/// Remedies if the device is out of memory.
const LESS_MEMORY: [Remedy; 4] =
    [Remedy::SmallerPicture, Remedy::LargerTolerance, Remedy::ShorterCoherence, Remedy::OtherDevice];
/// Remedies if a driver fails while this process is limited to a part of the machine's memory.
const LIFT_LIMIT: [Remedy; 3] = [
    Remedy::Words(Cow::Borrowed("raise this process' limit of memory (ulimit -v)")),
    Remedy::SmallerPicture,
    Remedy::LargerTolerance,
];

/// Turns a Vulkan result code into an error that names the failed action and a remedy.
pub fn failure(doing: &str, code: vk::Result) -> Error {
    let what = format!("Vulkan could not {doing} ({code})");
    let remedy: Remedies = match code {
        // Drivers fail in many ways if they get no memory.
        _ if memory::is_limited() => return Error::memory(what, LIFT_LIMIT).caused_by(code),
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
            return Error::memory(what, LESS_MEMORY).caused_by(code);
        }
        vk::Result::ERROR_DEVICE_LOST => {
            [Remedy::Words("try again; if it recurs, update the driver".into()), Remedy::SoftwareDevice]
                .into()
        }
        _ => [Remedy::Words("update the driver".into()), Remedy::OtherDevice, Remedy::SoftwareDevice].into(),
    };
    Error::device(what, remedy).caused_by(code)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorKind;

    #[test]
    fn a_lost_device_and_one_without_memory_are_told_apart() {
        if memory::is_limited() {
            return; // everything that fails is told as too little memory
        }
        let kinds = [
            (vk::Result::ERROR_DEVICE_LOST, ErrorKind::Device),
            (vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, ErrorKind::Memory),
        ];
        for (code, kind) in kinds {
            let error = failure("finish the work", code);
            assert_eq!(error.kind(), kind, "{error}");
            let source = std::error::Error::source(&error).and_then(|e| e.downcast_ref::<vk::Result>());
            assert_eq!(source, Some(&code));
        }
    }
}
