//! Texture samplers.

use super::device::Device;
use super::failure;
use crate::error::Result;
use ash::vk;
use std::sync::Arc;

/// Texture sampler.
pub struct Sampler {
    raw: vk::Sampler,
    device: Arc<Device>,
}

impl Sampler {
    /// Makes a sampler that is linear in both directions, with `address` beyond the edges.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn linear(device: &Arc<Device>, name: &str, address: vk::SamplerAddressMode) -> Result<Self> {
        Self::new(device, name, &filtering(address))
    }

    /// Makes a sampler that is linear within the nearest level and clamps coordinates to the edge.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn levels(device: &Arc<Device>, name: &str) -> Result<Self> {
        Self::of_levels(device, name, vk::SamplerAddressMode::CLAMP_TO_EDGE)
    }

    /// Makes a sampler that is linear within the nearest level and returns 0 beyond the edges.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn levels_that_end(device: &Arc<Device>, name: &str) -> Result<Self> {
        Self::of_levels(device, name, vk::SamplerAddressMode::CLAMP_TO_BORDER)
    }

    fn of_levels(device: &Arc<Device>, name: &str, address: vk::SamplerAddressMode) -> Result<Self> {
        let info = filtering(address)
            .border_color(vk::BorderColor::FLOAT_TRANSPARENT_BLACK)
            .mipmap_mode(vk::SamplerMipmapMode::NEAREST)
            .max_lod(vk::LOD_CLAMP_NONE);
        Self::new(device, name, &info)
    }

    /// Makes a trilinear sampler for equirectangular pictures: u repeats, v is clamped.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn equirectangular(device: &Arc<Device>, name: &str) -> Result<Self> {
        let info = filtering(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_u(vk::SamplerAddressMode::REPEAT)
            .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
            .max_lod(vk::LOD_CLAMP_NONE);
        Self::new(device, name, &info)
    }

    /// Makes a sampler of the nearest texel, as integer images require, that clamps coordinates to the edge.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn nearest(device: &Arc<Device>, name: &str) -> Result<Self> {
        let edge = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let info =
            vk::SamplerCreateInfo::default().address_mode_u(edge).address_mode_v(edge).address_mode_w(edge);
        Self::new(device, name, &info)
    }

    fn new(device: &Arc<Device>, name: &str, info: &vk::SamplerCreateInfo<'_>) -> Result<Self> {
        // SAFETY: the device is live and `info` complete.
        let raw =
            unsafe { device.raw().create_sampler(info, None) }.map_err(|c| failure("make a sampler", c))?;
        device.name(raw, name);
        Ok(Self { raw, device: device.clone() })
    }

    /// Returns the handle.
    pub fn raw(&self) -> vk::Sampler {
        self.raw
    }
}

/// Returns the parameters of a bilinear sampler with `address` beyond the edges.
fn filtering(address: vk::SamplerAddressMode) -> vk::SamplerCreateInfo<'static> {
    vk::SamplerCreateInfo::default()
        .mag_filter(vk::Filter::LINEAR)
        .min_filter(vk::Filter::LINEAR)
        .address_mode_u(address)
        .address_mode_v(address)
        .address_mode_w(address)
}

impl Drop for Sampler {
    fn drop(&mut self) {
        // SAFETY: dropped when no submitted work uses it.
        unsafe { self.device.raw().destroy_sampler(self.raw, None) };
    }
}
