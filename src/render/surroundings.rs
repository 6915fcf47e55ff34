//! The picture of a scene's surroundings on the device, where the geometry pass reads it in the mirrored direction of each pixel. Levels are
//! means over growing squares of pixels.

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
    /// Whose picture it is.
    of: Environment,
    /// The picture, in 16-bit floats.
    pub image: Image,
    /// What a stored 1 stands for.
    pub unit: f32,
}

impl Surroundings {
    /// Uploads the picture of `environment`.
    ///
    /// # Errors
    /// Where the device has no room.
    pub fn new(device: &Arc<Device>, environment: &Environment) -> Result<Self> {
        /// Of 16-bit floats, with room to spare for sums.
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

    /// Whether the picture is that of `environment`, however it is turned and however bright.
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
