//! The Vulkan device of a context.

use super::{Context, pipelines};
use crate::error::Result;
use crate::vk::device::Device;
use crate::vk::instance::Instance;
use crate::vk::selection::DeviceChoice;
use std::sync::{Arc, Mutex, PoisonError};

/// Choice of the device, and the device once it is open.
#[derive(Clone, Default)]
pub(super) struct Vulkan {
    choice: DeviceChoice,
    validates: bool,
    opened: Arc<Mutex<Option<Arc<Device>>>>,
}

impl Context {
    /// Returns the context with the device that `name` is a part of the name of, or the number of, or `cpu` for a software one.
    ///
    /// # Errors
    /// Fails for an empty name. Whether there is such a device shows when it is needed first.
    pub fn with_device(self, name: &str) -> Result<Self> {
        Ok(self.choosing(DeviceChoice::parse(name)?))
    }

    /// Returns the context with the device that `choice` names.
    pub(crate) fn choosing(self, choice: DeviceChoice) -> Self {
        if choice == self.vulkan.choice {
            return self;
        }
        Self { vulkan: Vulkan { choice, opened: Arc::default(), ..self.vulkan }, ..self }
    }

    /// Returns the context with a device that the validation layer watches: each of its messages is an error.
    #[must_use]
    pub fn with_validation(self, validates: bool) -> Self {
        let vulkan = Vulkan { validates, opened: Arc::default(), ..self.vulkan };
        Self { vulkan, ..self }
    }

    /// Returns the choice of the device.
    pub(crate) fn device_choice(&self) -> &DeviceChoice {
        &self.vulkan.choice
    }

    /// Returns true if the validation layer watches the device.
    pub(crate) fn validates(&self) -> bool {
        self.vulkan.validates
    }

    /// Returns the device, which the first call opens, with the pipelines that the cache keeps for it.
    ///
    /// # Errors
    /// Fails if there is no such device, or if it cannot be opened.
    pub(crate) fn device(&self) -> Result<Arc<Device>> {
        let mut opened = self.vulkan.opened.lock().unwrap_or_else(PoisonError::into_inner); // whole at any time
        if let Some(device) = &*opened {
            return Ok(device.clone());
        }
        let instance = Arc::new(Instance::new(self.vulkan.validates)?);
        let device = Device::open(instance, &self.vulkan.choice)?;
        self.load_pipelines(&device);
        Ok(opened.insert(device).clone())
    }

    /// Returns the device if it is open.
    pub(crate) fn opened_device(&self) -> Option<Arc<Device>> {
        self.vulkan.opened.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Adds the pipelines that the cache keeps for `device` to it.
    pub(crate) fn load_pipelines(&self, device: &Device) {
        if let Some(store) = self.store() {
            pipelines::load(device, store);
        }
    }

    /// Keeps the pipelines of `device` in the cache, for the next program that opens it.
    pub(crate) fn keep_pipelines(&self, device: &Device) {
        if let Some(store) = self.store() {
            pipelines::save(device, store);
        }
    }
}
