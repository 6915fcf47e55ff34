//! A sampler.

use super::device::Device;
use super::failure;
use crate::error::Result;
use ash::vk;
use std::sync::Arc;

/// A linear sampler.
pub struct Sampler {
    raw: vk::Sampler,
    device: Arc<Device>,
}

impl Sampler {
    /// Linear in both directions, with `address` beyond the edges.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn linear(device: &Arc<Device>, name: &str, address: vk::SamplerAddressMode) -> Result<Self> {
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .address_mode_u(address)
            .address_mode_v(address)
            .address_mode_w(address);
        // SAFETY: the device is live and `info` complete.
        let raw =
            unsafe { device.raw().create_sampler(&info, None) }.map_err(|c| failure("make a sampler", c))?;
        device.name(raw, name);
        Ok(Self { raw, device: device.clone() })
    }

    /// The handle.
    pub fn raw(&self) -> vk::Sampler {
        self.raw
    }
}

impl Drop for Sampler {
    fn drop(&mut self) {
        // SAFETY: dropped when no submitted work uses it.
        unsafe { self.device.raw().destroy_sampler(self.raw, None) };
    }
}
