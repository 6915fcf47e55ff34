//! Picture of a scene's surroundings on the device, which shading reads in the mirrored direction of each pixel,
//! and the background in the direction of its view. Mip levels are means over growing squares of pixels.

use super::upload;
use crate::error::Result;
use crate::scene::environment::{Environment, EnvironmentLevel};
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use ash::vk;
use half::f16;
use half::slice::HalfFloatSliceExt;
use std::sync::Arc;

/// Surroundings on the device.
pub struct Surroundings {
    /// Surroundings that the picture was made from.
    of: Environment,
    /// The picture, in 16-bit floats.
    pub image: Image,
    /// Radiance of a stored 1.
    pub unit: f32,
}

impl Surroundings {
    /// Uploads the picture of `environment`.
    ///
    /// # Errors
    /// Fails if the device is out of memory.
    pub fn new(device: &Arc<Device>, environment: &Environment) -> Result<Self> {
        /// Largest 16-bit float, with a margin for sums.
        const LARGEST: f32 = 6e4;
        let levels = environment.levels();
        let brightest = levels[0].radiance.iter().fold(0f32, |most, c| most.max(c.max_element()));
        let unit = if brightest > LARGEST { brightest / LARGEST } else { 1.0 };
        let texels: Vec<Vec<f16>> = levels.iter().map(|level| texels(level, unit)).collect();
        let description = Description {
            name: "surroundings",
            format: vk::Format::R16G16B16A16_SFLOAT,
            size: levels[0].size.map(|n| n as u32),
            layers: 1,
            array: false,
            usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
        };
        let image = Image::with_levels(device, &description, levels.len() as u32)?;
        let bytes: Vec<&[u8]> = texels.iter().map(|level| bytemuck::cast_slice(level)).collect();
        upload::levels(device, &image, 1, &bytes)?;
        Ok(Self { of: environment.clone(), image, unit })
    }

    /// Returns true if the picture is that of `environment`; its rotation and brightness may differ.
    pub fn show(&self, environment: &Environment) -> bool {
        self.of.shares_picture_with(environment)
    }
}

fn texels(level: &EnvironmentLevel, unit: f32) -> Vec<f16> {
    let colors: Vec<f32> = level.radiance.iter().flat_map(|c| (*c / unit).extend(0.0).to_array()).collect();
    let mut texels = vec![f16::ZERO; colors.len()];
    texels.convert_from_f32_slice(&colors);
    texels
}
