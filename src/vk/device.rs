//! Logical device: one queue, one allocator, and debug names.

use super::event_log::EventLog;
use super::failure;
use super::idle_pipelines::{IdlePipelines, PipelineHandles};
use super::instance::Instance;
use super::selection::{self, Candidate, DeviceChoice};
use crate::error::{Error, Remedies, Result};
use crate::memory;
use ash::{ext, vk};
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{
    Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc,
};
use std::ffi::c_char;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Sizes of the first and the largest block of device memory, and of host memory \[bytes\]. Each block is twice the
/// previous one, so that small pictures take little memory and large ones few blocks.
const BLOCKS: [(u64, u64); 2] = [(16 << 20, 256 << 20), (8 << 20, 64 << 20)];

/// Vulkan device with its queue and its memory.
pub struct Device {
    // Before the device: frees its blocks.
    allocator: Mutex<Option<Allocator>>,
    // For tests: number of allocations that succeed before one fails.
    until_refusal: AtomicU64,
    // For tests: number of submissions, and of acquired images, that succeed before the device or the surface is lost.
    until_loss: AtomicU64,
    until_surface_loss: AtomicU64,
    events: EventLog,
    names: Option<ext::debug_utils::Device>,
    raw: ash::Device,
    pipelines: vk::PipelineCache,
    idle_pipelines: IdlePipelines,
    queue: Mutex<vk::Queue>,
    queue_family: u32,
    candidate: Candidate,
    reason: String,
    // Last: devices are destroyed before their instance.
    instance: Arc<Instance>,
}

impl Device {
    /// Opens the device chosen by `wish`.
    ///
    /// # Errors
    /// Same as [`selection::choose`]; also fails if the driver reports an error.
    pub fn open(instance: Arc<Instance>, wish: &DeviceChoice) -> Result<Arc<Self>> {
        let candidates = selection::candidates(&instance)?;
        Self::open_one_of(candidates, instance, wish, &[])
    }

    /// Opens the device of `candidates` chosen by `wish`, with the device extensions `extensions`.
    ///
    /// # Errors
    /// Same as [`Device::open`].
    pub(super) fn open_one_of(
        mut candidates: Vec<Candidate>,
        instance: Arc<Instance>,
        wish: &DeviceChoice,
        extensions: &[*const c_char],
    ) -> Result<Arc<Self>> {
        let (index, reason) = selection::choose(&candidates, wish)?;
        let candidate = candidates.swap_remove(index);
        if candidate.is_software() {
            /// Memory of lavapipe itself and of the shaders of a picture, 130 MiB, with a margin \[bytes\].
            const SOFTWARE_DEVICE: u64 = 144 << 20;
            memory::ensure_room(SOFTWARE_DEVICE, "a software device")?;
        }
        let queue_family = candidate.queue_family.unwrap_or(0); // `choose` rejects devices without one
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(queue_family)
            .queue_priorities(&priorities)];
        let mut v13 = vk::PhysicalDeviceVulkan13Features::default()
            .dynamic_rendering(true)
            .synchronization2(true)
            .maintenance4(true); // SPIR-V 1.6 work group sizes; fragment stages that leave a vertex output unread
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(extensions)
            .push_next(&mut v13);
        // SAFETY: `candidate.raw` belongs to the live instance; `info` and its pointers outlive the calls; queue 0 of
        // the family was requested above.
        let (raw, queue) = unsafe {
            let raw = instance
                .raw()
                .create_device(candidate.raw, &info, None)
                .map_err(|c| failure(&format!("open `{}`", candidate.name), c))?;
            let queue = raw.get_device_queue(queue_family, 0);
            (raw, queue)
        };
        let names = instance.validates().then(|| ext::debug_utils::Device::new(instance.raw(), &raw));
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw().clone(),
            device: raw.clone(),
            physical_device: candidate.raw,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: gpu_allocator::AllocationSizes::new(BLOCKS[0].0, BLOCKS[1].0)
                .with_max_device_memblock_size(BLOCKS[0].1)
                .with_max_host_memblock_size(BLOCKS[1].1),
        });
        let mut device = Self {
            allocator: Mutex::new(None),
            until_refusal: AtomicU64::new(instance.mask().allocation.map_or(u64::MAX, |n| n - 1)),
            until_loss: AtomicU64::new(instance.mask().submission.map_or(u64::MAX, |n| n - 1)),
            until_surface_loss: AtomicU64::new(instance.mask().acquisition.map_or(u64::MAX, |n| n - 1)),
            events: EventLog::default(),
            names,
            raw,
            pipelines: vk::PipelineCache::null(),
            idle_pipelines: IdlePipelines::default(),
            queue: Mutex::new(queue),
            queue_family,
            candidate,
            reason,
            instance,
        };
        device.allocator = Mutex::new(Some(allocator.map_err(|e| memory_failure("device", e))?));
        // SAFETY: the device is live; its drop destroys the cache.
        device.pipelines =
            unsafe { device.raw.create_pipeline_cache(&vk::PipelineCacheCreateInfo::default(), None) }
                .map_err(|c| failure("make a pipeline cache", c))?;
        device.name(queue, "queue");
        device.name(device.pipelines, "pipelines");
        Ok(Arc::new(device))
    }

    /// Returns the ash device.
    pub fn raw(&self) -> &ash::Device {
        &self.raw
    }

    /// Returns the cache that pipelines are made with.
    pub(super) fn pipelines(&self) -> vk::PipelineCache {
        self.pipelines
    }

    /// Returns the pipelines that nothing uses.
    pub(super) fn idle_pipelines(&self) -> &IdlePipelines {
        &self.idle_pipelines
    }

    /// Destroys a pipeline and its layout, of which either may be null.
    ///
    /// # Safety
    /// The handles are of this device, and no submitted work uses them.
    pub(super) unsafe fn destroy_pipeline(&self, PipelineHandles { raw, layout }: PipelineHandles) {
        // SAFETY: the caller's promise.
        unsafe {
            self.raw.destroy_pipeline(raw, None);
            self.raw.destroy_pipeline_layout(layout, None);
        }
    }

    /// Returns the log of recorded events, for tests.
    pub fn events(&self) -> &EventLog {
        &self.events
    }

    /// Returns the instance.
    pub fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    /// Returns the physical device.
    pub fn candidate(&self) -> &Candidate {
        &self.candidate
    }

    /// Returns the reason for choosing this device.
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// Returns the family of the queue.
    pub fn queue_family(&self) -> u32 {
        self.queue_family
    }

    /// Submits recorded work and signals `fence` when it has finished.
    ///
    /// # Errors
    /// Fails if the device is lost or out of memory.
    pub fn submit(&self, work: vk::SubmitInfo2<'_>, fence: vk::Fence) -> Result<()> {
        // A lost device stays lost.
        let take = |left: u64| if left == u64::MAX { None } else { left.checked_sub(1) };
        let left = self.until_loss.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take);
        if left == Err(0) {
            return Err(failure("submit work", vk::Result::ERROR_DEVICE_LOST));
        }
        // SAFETY: the queue is locked; the caller's command buffers and semaphores are live and of this device.
        self.with_queue(|queue| unsafe { self.raw.queue_submit2(queue, &[work], fence) })?
            .map_err(|c| failure("submit work", c))
    }

    /// Calls `use_it` with exclusive access to the queue.
    ///
    /// # Errors
    /// Fails if a thread failed while it used the queue.
    pub fn with_queue<T>(&self, use_it: impl FnOnce(vk::Queue) -> T) -> Result<T> {
        let queue = self.queue.lock().map_err(|_| poisoned())?;
        Ok(use_it(*queue))
    }

    /// Returns the memory used by the resources of this program \[bytes\].
    pub fn memory_in_use(&self) -> u64 {
        let report = |a: &Allocator| a.generate_report().total_allocated_bytes;
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map_or(0, report)
    }

    /// Waits until the queue is idle.
    pub fn wait_idle(&self) {
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner); // a handle, which is always whole
        // SAFETY: the lock gives the external synchronization that a queue needs. A lost device is idle, too.
        let _ = unsafe { self.raw.queue_wait_idle(*queue) };
    }

    /// Returns true if the device is lost for good.
    pub fn is_lost(&self) -> bool {
        if self.until_loss.load(Ordering::Relaxed) == 0 {
            return true;
        }
        // SAFETY: the queue is locked.
        let idle = self.with_queue(|queue| unsafe { self.raw.queue_wait_idle(queue) });
        matches!(idle, Ok(Err(vk::Result::ERROR_DEVICE_LOST)))
    }

    /// Allocates memory for a resource called `name`.
    ///
    /// # Errors
    /// Fails if there is not enough memory.
    pub fn allocate(
        &self,
        name: &str,
        requirements: vk::MemoryRequirements,
        location: MemoryLocation,
        linear: bool,
    ) -> Result<Allocation> {
        use gpu_allocator::AllocationError::OutOfMemory;
        let take = |left: u64| left.checked_sub(1).or(Some(u64::MAX));
        if self.until_refusal.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take) == Ok(0) {
            return Err(memory_failure(name, OutOfMemory));
        }
        let mut guard = self.allocator.lock().map_err(|_| poisoned())?;
        let allocator = guard.as_mut().ok_or_else(poisoned)?;
        let scheme = AllocationScheme::GpuAllocatorManaged;
        let request =
            AllocationCreateDesc { name, requirements, location, linear, allocation_scheme: scheme };
        let allocation = allocator.allocate(&request).map_err(|e| memory_failure(name, e))?;
        if self.instance.mask().memory.is_some_and(|most| allocator.capacity() > most) {
            let _ = allocator.free(allocation); // allocated above
            return Err(memory_failure(name, OutOfMemory));
        }
        Ok(allocation)
    }

    /// Makes the `n`-th allocation from now on (from 1) fail, for tests.
    pub fn refuse_allocation(&self, n: u64) {
        self.until_refusal.store(n.saturating_sub(1), Ordering::Relaxed);
    }

    /// Returns true if the mask simulates a lost surface now; at most once.
    pub fn loses_surface(&self) -> bool {
        let take = |left: u64| left.checked_sub(1).or(Some(u64::MAX));
        self.until_surface_loss.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take) == Ok(0)
    }

    /// Frees memory.
    pub fn free(&self, allocation: Allocation) {
        if let Ok(mut guard) = self.allocator.lock()
            && let Some(allocator) = guard.as_mut()
        {
            // The only error is a foreign allocation; all allocations come from `allocate` above.
            let _ = allocator.free(allocation);
        }
    }

    /// Sets the debug name of a handle.
    pub fn name(&self, handle: impl vk::Handle, name: &str) {
        let Some(functions) = &self.names else { return };
        let Ok(name) = std::ffi::CString::new(name) else { return }; // names are literals; one with a NUL is left out
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: the handle is a live child of this device. A failure to set the name is harmless.
        let _ = unsafe { functions.set_debug_utils_object_name(&info) };
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: children hold an `Arc` of this device, so none is left; waiting ends pending work of the queue, and
        // the allocator's blocks are freed before the device.
        unsafe {
            let _ = self.raw.device_wait_idle(); // a lost device is idle, too
            if let Ok(mut allocator) = self.allocator.lock() {
                allocator.take();
            }
            for handles in self.idle_pipelines.take_all() {
                self.destroy_pipeline(handles);
            }
            self.raw.destroy_pipeline_cache(self.pipelines, None);
            self.raw.destroy_device(None);
        }
    }
}

fn poisoned() -> Error {
    Error::device("a thread failed while it used the Vulkan device", "start the program again")
}

fn memory_failure(name: &str, error: gpu_allocator::AllocationError) -> Error {
    Error::memory(
        format!("the Vulkan device has no memory for the resource \"{name}\" ({error})"),
        if memory::is_limited() { Remedies::from(super::LIFT_LIMIT) } else { super::LESS_MEMORY.into() },
    )
    .caused_by(error)
}
