//! What the surface reflects where that depends on the wavelength. Its twin is `shaders/reflectance.glsl`.

use crate::error::Result;
use crate::optics::reflectance::{COLUMNS, ROWS};
use crate::render::shading::Shading;
use crate::render::upload;
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::Constant;
use ash::vk;
use std::sync::Arc;

/// The specialisation constant of sources that sum over wavelengths.
pub(super) fn constant(shading: &Shading) -> Constant {
    const SPECTRAL_REFLECTANCE: u32 = 31;
    Constant::new(SPECTRAL_REFLECTANCE, shading.reflectance.is_spectral())
}

/// R of `shading`, or a single 1 where the factor of a pair holds it.
pub(super) fn texture(device: &Arc<Device>, shading: &Shading) -> Result<Image> {
    let reflectance = &shading.reflectance;
    let (size, values) = match reflectance.is_spectral() {
        true => ([COLUMNS, ROWS], reflectance.table()),
        false => ([1, 1], vec![1.0]),
    };
    let texels: Vec<[f32; 4]> = values.into_iter().map(|r| [r, 0.0, 0.0, 0.0]).collect();
    let format = vk::Format::R32G32B32A32_SFLOAT;
    upload::texture(device, "reflectances", format, size, None, bytemuck::cast_slice(&texels))
}
