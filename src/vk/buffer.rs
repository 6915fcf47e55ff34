//! Buffer with its memory.

use super::access::Access;
use super::device::Device;
use super::event_log::{RecordedEvent, Resource};
use super::failure;
use crate::error::{Error, Result};
use ash::vk::{self, Handle};
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;
use std::sync::Arc;

/// Buffer and its memory.
pub struct Buffer {
    raw: vk::Buffer,
    allocation: Option<Allocation>,
    size: u64,
    device: Arc<Device>,
}

impl Buffer {
    /// Makes a buffer of `size` bytes (at least one) with the debug name `name`.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(
        device: &Arc<Device>,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Self> {
        let info = vk::BufferCreateInfo::default()
            .size(size.max(1))
            .usage(usage)
            .sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: the device is live and `info` is complete; the requirements are of the buffer just made.
        let (raw, requirements) = unsafe {
            let raw = device
                .raw()
                .create_buffer(&info, None)
                .map_err(|c| failure(&format!("make the {name}"), c))?;
            (raw, device.raw().get_buffer_memory_requirements(raw))
        };
        let mut buffer = Self { raw, allocation: None, size: info.size, device: device.clone() };
        let allocation = device.allocate(name, requirements, location, true)?;
        // SAFETY: the allocation fulfils the buffer's requirements and is bound once.
        let bound = unsafe { device.raw().bind_buffer_memory(raw, allocation.memory(), allocation.offset()) };
        buffer.allocation = Some(allocation);
        bound.map_err(|c| failure(&format!("bind the {name}"), c))?;
        device.name(raw, name);
        device.events().note(|| RecordedEvent::Made(buffer.resource(), name.to_owned()));
        Ok(buffer)
    }

    /// Makes a host-visible buffer with the contents `data`.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn with_data(
        device: &Arc<Device>,
        name: &str,
        usage: vk::BufferUsageFlags,
        data: &[u8],
    ) -> Result<Self> {
        let mut buffer = Self::new(device, name, data.len() as u64, usage, MemoryLocation::CpuToGpu)?;
        buffer.write(data)?;
        Ok(buffer)
    }

    /// Writes `data` at the start. The device must not be using the buffer.
    ///
    /// # Errors
    /// Fails if the buffer is not host-visible or too small, which is a bug in the caller.
    pub fn write(&mut self, data: &[u8]) -> Result<()> {
        let mapped = self.allocation.as_mut().and_then(Allocation::mapped_slice_mut);
        match mapped.and_then(|slice| slice.get_mut(..data.len())) {
            Some(slice) => {
                slice.copy_from_slice(data);
                Ok(())
            }
            None => Err(not_mapped()),
        }
    }

    /// Returns the contents of a host-visible buffer. The device must have finished writing.
    ///
    /// # Errors
    /// Fails if the buffer is not host-visible, which is a bug in the caller.
    pub fn bytes(&self) -> Result<&[u8]> {
        self.device.events().note(|| RecordedEvent::Used(self.resource(), Access::HostRead, None));
        let mapped = self.allocation.as_ref().and_then(Allocation::mapped_slice);
        mapped.and_then(|slice| slice.get(..self.size as usize)).ok_or_else(not_mapped)
    }

    /// Returns the handle.
    pub fn raw(&self) -> vk::Buffer {
        self.raw
    }

    /// Returns the identifier of this buffer in the event log of its device.
    pub(super) fn resource(&self) -> Resource {
        Resource::Buffer(self.raw.as_raw())
    }

    /// Returns the size in bytes.
    pub fn size(&self) -> u64 {
        self.size
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: owners drop buffers only when no submitted work uses them; the memory is freed after its buffer.
        unsafe { self.device.raw().destroy_buffer(self.raw, None) };
        if let Some(allocation) = self.allocation.take() {
            self.device.free(allocation);
        }
    }
}

fn not_mapped() -> Error {
    Error::bug("a Vulkan buffer cannot be reached from the host")
}
