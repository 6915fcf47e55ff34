//! Binary semaphore, which orders work of the device and presentation.

use super::device::Device;
use super::failure;
use crate::error::Result;
use ash::vk;
use std::sync::Arc;

/// Binary semaphore.
pub struct Semaphore {
    raw: vk::Semaphore,
    device: Arc<Device>,
}

impl Semaphore {
    /// Makes an unsignalled semaphore with the debug name `name`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, name: &str) -> Result<Self> {
        // SAFETY: the device is live.
        let raw = unsafe { device.raw().create_semaphore(&vk::SemaphoreCreateInfo::default(), None) }
            .map_err(|c| failure("make a semaphore", c))?;
        device.name(raw, name);
        Ok(Self { raw, device: device.clone() })
    }

    /// Returns the handle.
    pub fn raw(&self) -> vk::Semaphore {
        self.raw
    }
}

impl Drop for Semaphore {
    fn drop(&mut self) {
        // SAFETY: owners drop semaphores only when no submitted work or presentation uses them.
        unsafe { self.device.raw().destroy_semaphore(self.raw, None) };
    }
}
