//! Swapchain of a window.

use super::device::Device;
use super::failure;
use super::image::Image;
use super::semaphore::Semaphore;
use super::window_surface::Surface;
use crate::error::{Error, Remedy, Result};
use ash::{khr, vk};
use std::sync::Arc;

/// Result of acquiring or presenting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presented<T> {
    /// Success.
    Done(T),
    /// The window has changed: the swapchain must be recreated.
    Outdated,
    /// The surface is lost: surface and swapchain must be recreated.
    Lost,
}

/// Swapchain, with one semaphore per image that its presentation waits for.
pub struct Swapchain {
    // Views of the swapchain's images: dropped first.
    images: Vec<Image>,
    drawn: Vec<Semaphore>,
    raw: vk::SwapchainKHR,
    functions: khr::swapchain::Device,
    mode: vk::PresentModeKHR,
    _surface: Arc<Surface>,
    device: Arc<Device>,
}

impl Swapchain {
    /// Makes a swapchain of `surface` with `size` (if the window system leaves the choice) and presentation mode
    /// `mode`, or FIFO if the device does not support it. `None` for a window without area. `old` must not be in use.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(
        device: &Arc<Device>,
        surface: &Arc<Surface>,
        size: [u32; 2],
        mode: vk::PresentModeKHR,
        old: Option<Self>,
    ) -> Result<Presented<Option<Self>>> {
        let physical = device.candidate().raw;
        let asked = surface
            .capabilities(physical)
            .and_then(|c| Ok((c, surface.formats(physical)?, surface.present_modes(physical)?)));
        let (capabilities, formats, modes) = match asked {
            Ok(all) => all,
            Err(vk::Result::ERROR_SURFACE_LOST_KHR) => return Ok(Presented::Lost),
            Err(c) => return Err(failure("ask what the window can show", c)),
        };
        let extent = extent(&capabilities, size);
        if extent.width == 0 || extent.height == 0 {
            return Ok(Presented::Done(None));
        }
        let format = format(&formats)?;
        let mode = if modes.contains(&mode) { mode } else { vk::PresentModeKHR::FIFO };
        let wanted = capabilities.min_image_count + 1;
        let most = if capabilities.max_image_count == 0 { wanted } else { capabilities.max_image_count };
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw())
            .min_image_count(wanted.min(most))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::COLOR_ATTACHMENT)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(capabilities.current_transform)
            .composite_alpha(opaque(capabilities.supported_composite_alpha))
            .present_mode(mode)
            .clipped(true)
            .old_swapchain(old.as_ref().map_or(vk::SwapchainKHR::null(), |s| s.raw));
        let functions = khr::swapchain::Device::new(surface.instance().raw(), device.raw());
        // SAFETY: surface and old swapchain are live and no other thread uses them; `info` is within the capabilities.
        let raw = match unsafe { functions.create_swapchain(&info, None) } {
            Ok(raw) => raw,
            Err(vk::Result::ERROR_SURFACE_LOST_KHR) => return Ok(Presented::Lost),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => return Ok(Presented::Outdated),
            Err(c) => return Err(failure("make a swapchain", c)),
        };
        drop(old);
        let mut made = Self {
            images: Vec::new(),
            drawn: Vec::new(),
            raw,
            functions,
            mode,
            _surface: surface.clone(),
            device: device.clone(),
        };
        device.name(raw, "swapchain");
        // SAFETY: the swapchain was just made.
        let images = unsafe { made.functions.get_swapchain_images(raw) }
            .map_err(|c| failure("list the images of the swapchain", c))?;
        for image in images {
            let size = [extent.width, extent.height];
            made.images.push(Image::borrowed(device, "swapchain image", image, format.format, size)?);
            made.drawn.push(Semaphore::new(device, "image drawn")?);
        }
        Ok(Presented::Done(Some(made)))
    }

    /// Returns the format of every swapchain of `surface`.
    ///
    /// # Errors
    /// Fails if the surface is lost or supports no suitable format.
    pub fn format_of(device: &Device, surface: &Surface) -> Result<vk::Format> {
        let formats = surface
            .formats(device.candidate().raw)
            .map_err(|c| failure("ask what the window can show", c))?;
        format(&formats).map(|f| f.format)
    }

    /// Returns the index of the next image to draw; `acquired` is signalled when it is free.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn acquire(&self, acquired: &Semaphore) -> Result<Presented<usize>> {
        if self.device.loses_surface() {
            return Ok(Presented::Lost);
        }
        // SAFETY: the semaphore is unsignalled: the work that waited for it is done.
        let next = unsafe {
            self.functions.acquire_next_image(self.raw, u64::MAX, acquired.raw(), vk::Fence::null())
        };
        match next {
            // A suboptimal swapchain can still be presented; presenting reports it again.
            Ok((index, _)) => Ok(Presented::Done(index as usize)),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Presented::Outdated),
            Err(vk::Result::ERROR_SURFACE_LOST_KHR) => Ok(Presented::Lost),
            Err(c) => Err(failure("get an image of the window", c)),
        }
    }

    /// Presents image `index` when the work that signals [`Swapchain::drawn`] is done.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn present(&self, index: usize) -> Result<Presented<()>> {
        let (semaphores, swapchains, indices) = ([self.drawn[index].raw()], [self.raw], [index as u32]);
        let info = vk::PresentInfoKHR::default()
            .wait_semaphores(&semaphores)
            .swapchains(&swapchains)
            .image_indices(&indices);
        // SAFETY: the image was acquired, and submitted work signals its semaphore; the queue is locked.
        let shown = self.device.with_queue(|queue| unsafe { self.functions.queue_present(queue, &info) })?;
        match shown {
            Ok(false) => Ok(Presented::Done(())),
            Ok(true) | Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Presented::Outdated),
            Err(vk::Result::ERROR_SURFACE_LOST_KHR) => Ok(Presented::Lost),
            Err(c) => Err(failure("show an image in the window", c)),
        }
    }

    /// Returns image `index`.
    pub fn image(&self, index: usize) -> &Image {
        &self.images[index]
    }

    /// Returns the semaphore that drawing image `index` must signal.
    pub fn drawn(&self, index: usize) -> &Semaphore {
        &self.drawn[index]
    }

    /// Returns the presentation mode.
    pub fn mode(&self) -> vk::PresentModeKHR {
        self.mode
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        // Presentation has no fence; once the queue is idle, it has presented. This happens only when resizing and
        // closing.
        self.device.wait_idle();
        self.images.clear();
        // SAFETY: the images are no longer used, and their views are dropped.
        unsafe { self.functions.destroy_swapchain(self.raw, None) };
    }
}

/// Returns the size of the surface, or `wished` within its limits if the window system leaves the choice.
fn extent(capabilities: &vk::SurfaceCapabilitiesKHR, wished: [u32; 2]) -> vk::Extent2D {
    const CHOICE: u32 = u32::MAX;
    if capabilities.current_extent.width != CHOICE {
        return capabilities.current_extent;
    }
    if wished.contains(&0) {
        return vk::Extent2D::default();
    }
    let (least, most) = (capabilities.min_image_extent, capabilities.max_image_extent);
    vk::Extent2D {
        width: wished[0].clamp(least.width, most.width),
        height: wished[1].clamp(least.height, most.height),
    }
}

/// Returns a format of 8 bits per channel without sRGB conversion: the picture has its transfer function applied
/// already.
fn format(formats: &[vk::SurfaceFormatKHR]) -> Result<vk::SurfaceFormatKHR> {
    let wanted = [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM];
    let fits = |f: &&vk::SurfaceFormatKHR| {
        wanted.contains(&f.format) && f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR
    };
    formats.iter().find(fits).copied().ok_or_else(|| {
        Error::device("the window takes no 8-bit sRGB picture", [Remedy::PictureFile, Remedy::OtherDevice])
    })
}

/// Returns opaque composition if supported, otherwise the first supported one.
fn opaque(supported: vk::CompositeAlphaFlagsKHR) -> vk::CompositeAlphaFlagsKHR {
    use vk::CompositeAlphaFlagsKHR as A;
    [A::OPAQUE, A::INHERIT, A::PRE_MULTIPLIED, A::POST_MULTIPLIED]
        .into_iter()
        .find(|a| supported.contains(*a))
        .unwrap_or(A::OPAQUE)
}
