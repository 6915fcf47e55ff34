//! Compiled pipelines of a device, as its driver keeps them for the next start.

use super::device::Device;
use super::failure;
use crate::error::Result;
use ash::vk;

impl Device {
    /// Adds the pipelines in `data`, which [`Self::pipeline_data`] returned, to those of this device. The driver
    /// recognises data of another device or driver by its header and ignores it (Vulkan specification, "Pipeline Cache
    /// Header"). Nobody may be making pipelines meanwhile.
    ///
    /// # Errors
    /// Fails if the driver is out of memory.
    pub fn add_pipelines(&self, data: &[u8]) -> Result<()> {
        let failed = |c| failure("read compiled pipelines", c);
        let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
        // SAFETY: the device and its cache are live; the second cache is destroyed after it was merged.
        unsafe {
            let read = self.raw().create_pipeline_cache(&info, None).map_err(failed)?;
            let merged = self.raw().merge_pipeline_caches(self.pipelines(), &[read]);
            self.raw().destroy_pipeline_cache(read, None);
            merged.map_err(failed)
        }
    }

    /// Returns the pipelines that were compiled or added so far; empty if the driver keeps none.
    ///
    /// # Errors
    /// Fails if the driver is out of memory.
    pub fn pipeline_data(&self) -> Result<Vec<u8>> {
        // SAFETY: the device and its cache are live.
        let mut data = unsafe { self.raw().get_pipeline_cache_data(self.pipelines()) }
            .map_err(|c| failure("keep compiled pipelines", c))?;
        if data.len() <= size_of::<vk::PipelineCacheHeaderVersionOne>() {
            data.clear();
        }
        Ok(data)
    }
}
