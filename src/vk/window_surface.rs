//! Vulkan surface of a window, and instances and devices that can present to one.

use super::device::Device;
use super::failure;
use super::instance::Instance;
use super::mask::Mask;
use super::selection::{self, Candidate, DeviceChoice};
use crate::error::{Error, Result};
use ash::prelude::VkResult;
use ash::{khr, vk};
use std::any::Any;
use std::ffi::CStr;
use std::sync::Arc;
use winit::raw_window_handle::{HandleError, HasDisplayHandle, HasWindowHandle, RawDisplayHandle};

impl Instance {
    /// Loads Vulkan as [`Instance::new`], for windows on the display of `handle`.
    ///
    /// # Errors
    /// Same as [`Instance::new`]; also fails if Vulkan does not support the window system.
    pub fn for_windows(validation: bool, handle: RawDisplayHandle) -> Result<Self> {
        let names = ash_window::enumerate_required_extensions(handle)
            .map_err(|c| failure("name what windows of this kind need", c))?;
        Self::with_extensions(validation, names, Mask::from_environment()?)
    }
}

impl Device {
    /// Opens the device chosen by `wish` among those that can present to `surface`.
    ///
    /// # Errors
    /// Same as [`Device::open`].
    pub fn open_for(surface: &Surface, wish: &DeviceChoice) -> Result<Arc<Self>> {
        let instance = surface.instance().clone();
        let mut candidates = selection::candidates(&instance)?;
        for candidate in &mut candidates {
            if !surface.is_shown_by(candidate) {
                candidate.missing.push("a way to show windows on this display");
            }
        }
        Self::open_one_of(candidates, instance, wish, &[khr::swapchain::NAME.as_ptr()])
    }
}

/// Surface, with its window.
pub struct Surface {
    raw: vk::SurfaceKHR,
    functions: khr::surface::Instance,
    // After the surface, before the instance.
    _window: Arc<dyn Any + Send + Sync>,
    instance: Arc<Instance>,
}

impl Surface {
    /// Makes the surface of `window` and keeps the window alive.
    ///
    /// # Errors
    /// Fails if the window system or Vulkan reports an error.
    pub fn new<W>(instance: &Arc<Instance>, window: &Arc<W>) -> Result<Self>
    where
        W: HasDisplayHandle + HasWindowHandle + Any + Send + Sync,
    {
        let gone =
            |e: HandleError| Error::device(format!("the window is gone ({e})"), "start again").caused_by(e);
        let display = window.display_handle().map_err(gone)?.as_raw();
        let handle = window.window_handle().map_err(gone)?.as_raw();
        // SAFETY: both handles are of the live window, which this value keeps; the instance has the extensions of its
        // display.
        let raw =
            unsafe { ash_window::create_surface(instance.entry(), instance.raw(), display, handle, None) }
                .map_err(|c| failure("make a surface of the window", c))?;
        let functions = khr::surface::Instance::new(instance.entry(), instance.raw());
        Ok(Self { raw, functions, _window: window.clone(), instance: instance.clone() })
    }

    /// Returns true if a device can present to this surface.
    pub fn is_shown_by(&self, candidate: &Candidate) -> bool {
        let Some(family) = candidate.queue_family else { return false };
        // SAFETY: the device is of the surface's live instance.
        let (supported, extensions) = unsafe {
            (
                self.functions.get_physical_device_surface_support(candidate.raw, family, self.raw),
                self.instance.raw().enumerate_device_extension_properties(candidate.raw),
            )
        };
        let named = |name: &CStr| {
            let same = |e: &vk::ExtensionProperties| e.extension_name_as_c_str() == Ok(name);
            extensions.as_ref().is_ok_and(|list| list.iter().any(same))
        };
        supported == Ok(true) && named(khr::swapchain::NAME)
    }

    /// Returns the surface capabilities of `device`.
    ///
    /// # Errors
    /// Fails if the surface is lost.
    pub fn capabilities(&self, device: vk::PhysicalDevice) -> VkResult<vk::SurfaceCapabilitiesKHR> {
        // SAFETY: the device is of the surface's live instance.
        unsafe { self.functions.get_physical_device_surface_capabilities(device, self.raw) }
    }

    /// Returns the surface formats of `device`.
    ///
    /// # Errors
    /// Fails if the surface is lost.
    pub fn formats(&self, device: vk::PhysicalDevice) -> VkResult<Vec<vk::SurfaceFormatKHR>> {
        // SAFETY: as in `capabilities`.
        unsafe { self.functions.get_physical_device_surface_formats(device, self.raw) }
    }

    /// Returns the presentation modes of `device`.
    ///
    /// # Errors
    /// Fails if the surface is lost.
    pub fn present_modes(&self, device: vk::PhysicalDevice) -> VkResult<Vec<vk::PresentModeKHR>> {
        // SAFETY: as in `capabilities`.
        unsafe { self.functions.get_physical_device_surface_present_modes(device, self.raw) }
    }

    /// Returns the handle.
    pub fn raw(&self) -> vk::SurfaceKHR {
        self.raw
    }

    /// Returns the instance.
    pub fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: swapchains hold an `Arc` of their surface, so none is left.
        unsafe { self.functions.destroy_surface(self.raw, None) };
    }
}
