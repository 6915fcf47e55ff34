//! Image with its memory, a view of all of it, mip levels included, and views of layers to draw into.

use super::device::Device;
use super::event_log::{RecordedEvent, Resource};
use super::failure;
use crate::error::{Error, Remedy, Result};
use ash::vk::{self, Handle};
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;
use std::sync::Arc;

/// Parameters of an image.
#[derive(Clone, Copy, Debug)]
pub struct Description<'a> {
    /// Debug name.
    pub name: &'a str,
    /// Texel format.
    pub format: vk::Format,
    /// Width and height in texels.
    pub size: [u32; 2],
    /// Number of array layers.
    pub layers: u32,
    /// True if the view is a 2D array, even of one layer.
    pub array: bool,
    /// Usage flags.
    pub usage: vk::ImageUsageFlags,
}

/// Device-local 2D image or array of images, with a view.
pub struct Image {
    view: vk::ImageView,
    // One for each layer of an array of attachments.
    layer_views: Vec<vk::ImageView>,
    raw: vk::Image,
    allocation: Option<Allocation>,
    format: vk::Format,
    size: [u32; 2],
    layers: u32,
    levels: u32,
    // True if dropping this destroys the image; a swapchain owns its images.
    owned: bool,
    device: Arc<Device>,
}

impl Image {
    /// Wraps an image of one layer that is owned elsewhere and must outlive the result.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn borrowed(
        device: &Arc<Device>,
        name: &str,
        raw: vk::Image,
        format: vk::Format,
        size: [u32; 2],
    ) -> Result<Self> {
        let mut image = Self {
            view: vk::ImageView::null(),
            layer_views: Vec::new(),
            raw,
            allocation: None,
            format,
            size,
            layers: 1,
            levels: 1,
            owned: false,
            device: device.clone(),
        };
        image.look(name, vk::ImageViewType::TYPE_2D)?;
        Ok(image)
    }

    /// Makes a view of a part of the bound image.
    fn view_of(
        &self,
        name: &str,
        kind: vk::ImageViewType,
        range: vk::ImageSubresourceRange,
    ) -> Result<vk::ImageView> {
        let view = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(kind)
            .format(self.format)
            .subresource_range(range);
        // SAFETY: the image is bound, and the view covers layers that it has.
        let view = unsafe { self.device.raw().create_image_view(&view, None) }
            .map_err(|c| failure(&format!("make a view of the {name}"), c))?;
        self.device.name(view, &format!("{name} view"));
        Ok(view)
    }

    /// Makes the view of all layers, and sets debug names.
    fn look(&mut self, name: &str, kind: vk::ImageViewType) -> Result<()> {
        self.view = self.view_of(name, kind, self.range())?;
        self.device.name(self.raw, name);
        self.device.events().note(|| RecordedEvent::Made(self.resource(), name.to_owned()));
        Ok(())
    }

    /// Creates an image with one mip level.
    ///
    /// # Errors
    /// Fails if the image exceeds the device's limits or memory.
    pub fn new(device: &Arc<Device>, description: &Description<'_>) -> Result<Self> {
        Self::with_levels(device, description, 1)
    }

    /// Creates an image with `levels` mip levels.
    ///
    /// # Errors
    /// Fails if the image exceeds the device's limits or memory.
    pub fn with_levels(device: &Arc<Device>, description: &Description<'_>, levels: u32) -> Result<Self> {
        let Description { name, format, size, layers, array, usage } = *description;
        let limits = device.candidate();
        if size[0] > limits.max_side || size[1] > limits.max_side || layers > limits.max_layers {
            return Err(Error::limit(
                format!(
                    "the {name} of {} x {} texels in {layers} layers is larger than `{}` holds ({} x {} in {} layers)",
                    size[0], size[1], limits.name, limits.max_side, limits.max_side, limits.max_layers
                ),
                [Remedy::SmallerPicture, Remedy::LargerTolerance, Remedy::ShorterCoherence],
            ));
        }
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width: size[0], height: size[1], depth: 1 })
            .mip_levels(levels)
            .array_layers(layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(usage)
            .sharing_mode(vk::SharingMode::EXCLUSIVE)
            .initial_layout(vk::ImageLayout::UNDEFINED);
        // SAFETY: the device is live and `info` is within the limits checked above.
        let (raw, requirements) = unsafe {
            let raw = device
                .raw()
                .create_image(&info, None)
                .map_err(|c| failure(&format!("make the {name}"), c))?;
            (raw, device.raw().get_image_memory_requirements(raw))
        };
        let mut image = Self {
            view: vk::ImageView::null(),
            layer_views: Vec::new(),
            raw,
            allocation: None,
            format,
            size,
            layers,
            levels,
            owned: true,
            device: device.clone(),
        };
        let allocation = device.allocate(name, requirements, MemoryLocation::GpuOnly, false)?;
        // SAFETY: the allocation fulfils the image's requirements and is bound once.
        let bound = unsafe { device.raw().bind_image_memory(raw, allocation.memory(), allocation.offset()) };
        image.allocation = Some(allocation);
        bound.map_err(|c| failure(&format!("bind the {name}"), c))?;
        image
            .look(name, if array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D })?;
        use vk::ImageUsageFlags as Usage;
        if array && usage.intersects(Usage::COLOR_ATTACHMENT | Usage::DEPTH_STENCIL_ATTACHMENT) {
            for layer in 0..layers {
                let range = image.range().level_count(1).base_array_layer(layer).layer_count(1);
                let view = image.view_of(name, vk::ImageViewType::TYPE_2D, range)?;
                image.layer_views.push(view);
            }
        }
        Ok(image)
    }

    /// Returns the aspects of the format: colour, or depth and, if present, the stencil.
    pub fn aspect(&self) -> vk::ImageAspectFlags {
        use vk::ImageAspectFlags as Aspect;
        match self.format {
            vk::Format::D32_SFLOAT => Aspect::DEPTH,
            format if has_stencil(format) => Aspect::DEPTH | Aspect::STENCIL,
            _ => Aspect::COLOR,
        }
    }

    /// Returns true if the format has a stencil in addition to the depth.
    pub fn has_stencil(&self) -> bool {
        has_stencil(self.format)
    }

    /// Returns the range of all levels and layers.
    pub fn range(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange::default()
            .aspect_mask(self.aspect())
            .level_count(self.levels)
            .layer_count(self.layers)
    }

    /// Returns the handle.
    pub fn raw(&self) -> vk::Image {
        self.raw
    }

    /// Returns the identifier of this image in the event log of its device.
    pub(super) fn resource(&self) -> Resource {
        Resource::Image(self.raw.as_raw())
    }

    /// Returns the view of all layers.
    pub fn view(&self) -> vk::ImageView {
        self.view
    }

    /// Returns the view of a layer to draw into: of an array of attachments, or of an image of one layer.
    pub fn layer_view(&self, layer: u32) -> vk::ImageView {
        self.layer_views.get(layer as usize).copied().unwrap_or(self.view)
    }

    /// Returns the format.
    pub fn format(&self) -> vk::Format {
        self.format
    }

    /// Returns the number of mip levels.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Returns width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }
}

/// Returns true if a depth format has a stencil.
pub(super) fn has_stencil(format: vk::Format) -> bool {
    format == vk::Format::D32_SFLOAT_S8_UINT
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: owners drop images only when no submitted work uses them; views, image, memory in that order. A null
        // view is allowed.
        unsafe {
            self.layer_views.iter().for_each(|&view| self.device.raw().destroy_image_view(view, None));
            self.device.raw().destroy_image_view(self.view, None);
            if self.owned {
                self.device.raw().destroy_image(self.raw, None);
            }
        }
        if let Some(allocation) = self.allocation.take() {
            self.device.free(allocation);
        }
    }
}
