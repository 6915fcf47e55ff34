//! Descriptor set with its layout and pool.

use super::access::Access;
use super::buffer::Buffer;
use super::device::Device;
use super::event_log::Resource;
use super::failure;
use super::image::Image;
use super::sampler::Sampler;
use crate::error::Result;
use ash::vk;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Binding of a layout.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// Number in the shaders.
    pub number: u32,
    /// Type of resource.
    pub kind: vk::DescriptorType,
    /// Stages that use it.
    pub stages: vk::ShaderStageFlags,
}

impl Binding {
    /// Returns the binding of a texture for fragment shaders.
    pub const fn texture(number: u32) -> Self {
        let (kind, stages) = (vk::DescriptorType::COMBINED_IMAGE_SAMPLER, vk::ShaderStageFlags::FRAGMENT);
        Self { number, kind, stages }
    }
}

/// Descriptor set, its layout and its pool.
pub struct Descriptors {
    set: vk::DescriptorSet,
    layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    kinds: Vec<Binding>,
    // Resource and access of the shaders by binding number.
    accesses: Mutex<BTreeMap<u32, (Resource, Access)>>,
    device: Arc<Device>,
}

impl Descriptors {
    /// Makes a set of `bindings` with the debug name `name`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, name: &str, bindings: &[Binding]) -> Result<Self> {
        let rows: Vec<_> = bindings
            .iter()
            .map(|b| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(b.number)
                    .descriptor_type(b.kind)
                    .descriptor_count(1)
                    .stage_flags(b.stages)
            })
            .collect();
        let sizes: Vec<_> = bindings
            .iter()
            .map(|b| vk::DescriptorPoolSize::default().ty(b.kind).descriptor_count(1))
            .collect();
        let mut made = Self {
            set: vk::DescriptorSet::null(),
            layout: vk::DescriptorSetLayout::null(),
            pool: vk::DescriptorPool::null(),
            kinds: bindings.to_vec(),
            accesses: Mutex::default(),
            device: device.clone(),
        };
        let failed = |c| failure("make a descriptor set", c);
        // SAFETY: the device is live, the create structures complete and alive through each call; if a later call
        // fails, the drop of `made` frees the handles.
        unsafe {
            let raw = device.raw();
            let layout = vk::DescriptorSetLayoutCreateInfo::default().bindings(&rows);
            made.layout = raw.create_descriptor_set_layout(&layout, None).map_err(failed)?;
            let pool = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
            made.pool = raw.create_descriptor_pool(&pool, None).map_err(failed)?;
            let layouts = [made.layout];
            let request =
                vk::DescriptorSetAllocateInfo::default().descriptor_pool(made.pool).set_layouts(&layouts);
            made.set = raw.allocate_descriptor_sets(&request).map_err(failed)?[0];
        }
        device.name(made.layout, &format!("{name} layout"));
        device.name(made.pool, &format!("{name} pool"));
        device.name(made.set, name);
        Ok(made)
    }

    /// Binds a whole buffer that shaders read to `number`.
    pub fn buffer(&self, number: u32, buffer: &Buffer) {
        self.bind_buffer(number, buffer, Access::ShaderRead);
    }

    /// Binds a whole buffer that compute shaders write to `number`.
    pub fn written_buffer(&self, number: u32, buffer: &Buffer) {
        self.bind_buffer(number, buffer, Access::ComputeWrite);
    }

    /// Returns the bindings of the layout.
    pub(super) fn bindings(&self) -> &[Binding] {
        &self.kinds
    }

    /// Returns the bound resources with the accesses of the shaders.
    pub(super) fn accesses(&self) -> Vec<(Resource, Access)> {
        // A map that is only inserted into is always whole.
        self.accesses.lock().unwrap_or_else(PoisonError::into_inner).values().copied().collect()
    }

    fn declare(&self, number: u32, resource: Resource, access: Access) {
        let mut accesses = self.accesses.lock().unwrap_or_else(PoisonError::into_inner);
        accesses.insert(number, (resource, access));
    }

    fn bind_buffer(&self, number: u32, buffer: &Buffer, access: Access) {
        self.declare(number, buffer.resource(), access);
        let infos = [vk::DescriptorBufferInfo::default().buffer(buffer.raw()).range(vk::WHOLE_SIZE)];
        self.update(self.write(number).buffer_info(&infos));
    }

    /// Binds an image and its sampler to `number`.
    pub fn image(&self, number: u32, image: &Image, sampler: &Sampler) {
        self.declare(number, image.resource(), Access::ShaderRead);
        let infos = [vk::DescriptorImageInfo::default()
            .sampler(sampler.raw())
            .image_view(image.view())
            .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)];
        self.update(self.write(number).image_info(&infos));
    }

    fn write(&self, number: u32) -> vk::WriteDescriptorSet<'static> {
        let kind = self.kinds.iter().find(|b| b.number == number).map(|b| b.kind).unwrap_or_default();
        vk::WriteDescriptorSet::default().dst_set(self.set).dst_binding(number).descriptor_type(kind)
    }

    fn update(&self, write: vk::WriteDescriptorSet<'_>) {
        // SAFETY: the set is live and not in use by submitted work: owners update it before they record.
        unsafe { self.device.raw().update_descriptor_sets(&[write], &[]) };
    }

    /// Returns the set.
    pub fn set(&self) -> vk::DescriptorSet {
        self.set
    }

    /// Returns the layout.
    pub fn layout(&self) -> vk::DescriptorSetLayout {
        self.layout
    }
}

impl Drop for Descriptors {
    fn drop(&mut self) {
        // SAFETY: dropped when no submitted work uses the set; null handles are allowed.
        unsafe {
            self.device.raw().destroy_descriptor_pool(self.pool, None);
            self.device.raw().destroy_descriptor_set_layout(self.layout, None);
        }
    }
}
