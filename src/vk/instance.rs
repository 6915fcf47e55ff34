//! Vulkan instance, with a messenger that collects validation messages.

use super::failure;
use super::mask::Mask;
use crate::error::{Error, Remedy, Result};
use crate::memory;
use ash::{ext, vk};
use std::ffi::{CStr, c_char, c_void};
use std::sync::{Mutex, MutexGuard, PoisonError};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Required Vulkan version.
pub const API_VERSION: u32 = vk::API_VERSION_1_3;

/// Remedy if Vulkan is missing.
pub const INSTALL: &str = "install a Vulkan driver (on Debian and Ubuntu without a GPU: apt-get install libvulkan1 \
                           mesa-vulkan-drivers)";

/// Messages of the validation layer, oldest first.
#[derive(Debug, Default)]
pub struct Messages(Mutex<Vec<String>>);

impl Messages {
    /// Returns all messages so far.
    pub fn all(&self) -> Vec<String> {
        self.list().clone()
    }

    fn list(&self) -> MutexGuard<'_, Vec<String>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner) // a list that is cloned or pushed to is always whole
    }

    fn push(&self, message: String) {
        self.list().push(message);
    }
}

/// Vulkan instance, optionally with validation.
pub struct Instance {
    debug: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    raw: ash::Instance,
    // Boxed: the messenger holds its address.
    messages: Box<Messages>,
    // Capabilities hidden from its devices.
    mask: Mask,
    // Last: unloads the library.
    entry: ash::Entry,
}

impl Instance {
    /// Loads Vulkan and creates an instance. `validation` enables the Khronos layer with synchronization checks.
    ///
    /// # Errors
    /// Fails if there is no Vulkan library or no version 1.3, or if validation is requested but not installed.
    pub fn new(validation: bool) -> Result<Self> {
        Self::with_extensions(validation, &[], Mask::from_environment()?)
    }

    /// Loads Vulkan as [`Instance::new`], with the capabilities of `mask` hidden.
    ///
    /// # Errors
    /// Same as [`Instance::new`].
    pub fn masked(validation: bool, mask: Mask) -> Result<Self> {
        Self::with_extensions(validation, &[], mask)
    }

    /// Loads Vulkan as [`Instance::new`], with the instance extensions `more`.
    ///
    /// # Errors
    /// Same as [`Instance::new`]; also fails if an extension is missing.
    pub(super) fn with_extensions(validation: bool, more: &[*const c_char], mask: Mask) -> Result<Self> {
        // SAFETY: loading runs the system's Vulkan loader, as the user requested; the entry outlives all use.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| {
            Error::device(format!("there is no Vulkan on this machine ({e})"), INSTALL).caused_by(e)
        })?;
        let application =
            vk::ApplicationInfo::default().application_name(c"diffract").api_version(API_VERSION);
        let layers = [VALIDATION_LAYER.as_ptr()];
        let mut extensions = more.to_vec();
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if validation {
            require_validation(&entry)?;
            extensions.push(ext::debug_utils::NAME.as_ptr());
            info = info.enabled_layer_names(&layers).push_next(&mut features);
        }
        info = info.enabled_extension_names(&extensions);
        // SAFETY: `info` and all it points to live until the call returns.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|code| match code {
            // A loader also reports this if it gets no memory for a driver.
            vk::Result::ERROR_INCOMPATIBLE_DRIVER if !memory::is_limited() => {
                Error::device("there is no Vulkan driver of version 1.3 on this machine", INSTALL)
            }
            vk::Result::ERROR_EXTENSION_NOT_PRESENT => Error::device(
                "this machine's Vulkan cannot show windows on this display",
                Remedy::PictureFile,
            ),
            code => failure("start", code),
        })?;
        let messages = Box::<Messages>::default();
        let mut instance = Self { debug: None, raw, messages, mask, entry };
        if validation {
            instance.debug = Some(instance.listen()?);
        }
        Ok(instance)
    }

    fn listen(&self) -> Result<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)> {
        let functions = ext::debug_utils::Instance::new(&self.entry, &self.raw);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(
                vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                    | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
            )
            .pfn_user_callback(Some(on_message))
            .user_data(std::ptr::from_ref::<Messages>(&self.messages).cast_mut().cast());
        // SAFETY: the instance is live; `messages` is boxed and freed only after the messenger is destroyed.
        let messenger = unsafe { functions.create_debug_utils_messenger(&info, None) }
            .map_err(|code| failure("listen to validation", code))?;
        Ok((functions, messenger))
    }

    /// Returns the ash instance.
    pub fn raw(&self) -> &ash::Instance {
        &self.raw
    }

    /// Returns the loaded Vulkan library.
    pub fn entry(&self) -> &ash::Entry {
        &self.entry
    }

    /// Returns the validation messages so far; empty without validation.
    pub fn messages(&self) -> Vec<String> {
        self.messages.all()
    }

    /// Returns the capabilities hidden from its devices.
    pub fn mask(&self) -> &Mask {
        &self.mask
    }

    /// Returns true if validation is enabled.
    pub fn validates(&self) -> bool {
        self.debug.is_some()
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: every child holds an `Arc` of this instance, so none is left; the messenger goes before its instance.
        unsafe {
            if let Some((functions, messenger)) = &self.debug {
                functions.destroy_debug_utils_messenger(*messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn require_validation(entry: &ash::Entry) -> Result<()> {
    // SAFETY: the entry is loaded.
    let layers =
        unsafe { entry.enumerate_instance_layer_properties() }.map_err(|c| failure("list its layers", c))?;
    if layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER)) {
        return Ok(());
    }
    Err(Error::device(
        "Vulkan validation is asked for and not installed",
        "install it (apt-get install vulkan-validationlayers) or unset DIFFRACT_VALIDATION",
    ))
}

/// Stores a message; it fails the test or the program later.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes valid callback data, and the pointer set in `listen`, to a `Messages` that outlives the
    // messenger and is only read.
    unsafe {
        let text = (*data).message_as_c_str().unwrap_or(c"a message without text");
        (*user.cast::<Messages>()).push(text.to_string_lossy().into_owned());
    }
    vk::FALSE
}
