//! Timestamp queries.

use super::device::Device;
use super::failure;
use crate::error::Result;
use ash::vk;
use std::sync::Arc;

/// Pool of timestamps written by one command buffer.
pub struct Timestamps {
    pool: vk::QueryPool,
    count: u32,
    device: Arc<Device>,
}

impl Timestamps {
    /// Makes a pool of `count` timestamps.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, count: u32) -> Result<Self> {
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(count);
        // SAFETY: the device is live and `info` complete.
        let pool = unsafe { device.raw().create_query_pool(&info, None) }
            .map_err(|c| failure("make timestamps", c))?;
        device.name(pool, "timestamps");
        Ok(Self { pool, count, device: device.clone() })
    }

    /// Returns the pool.
    pub fn pool(&self) -> vk::QueryPool {
        self.pool
    }

    /// Returns the number of timestamps.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Returns the times between consecutive timestamps of finished work \[ms\].
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn intervals(&self) -> Result<Vec<f64>> {
        let mut ticks = vec![0u64; self.count as usize];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the pool is live, `ticks` has room for all of it, and the work that wrote it was waited for.
        unsafe { self.device.raw().get_query_pool_results(self.pool, 0, &mut ticks, flags) }
            .map_err(|c| failure("read timestamps", c))?;
        let nanoseconds = self.device.candidate().timestamp_period;
        Ok(ticks.windows(2).map(|t| t[1].saturating_sub(t[0]) as f64 * nanoseconds * 1e-6).collect())
    }
}

impl Drop for Timestamps {
    fn drop(&mut self) {
        // SAFETY: dropped when no submitted work uses it.
        unsafe { self.device.raw().destroy_query_pool(self.pool, None) };
    }
}
