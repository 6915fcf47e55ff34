//! Uploads from host to device memory through staging buffers; that of an image has a bounded size.

use crate::error::Result;
use crate::vk::access::Access;
use crate::vk::buffer::Buffer;
use crate::vk::commands::Commands;
use crate::vk::device::Device;
use crate::vk::image::{Description, Image};
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::sync::Arc;

/// Size of an image's staging buffer \[bytes\]: holds many rows of the largest texture and is small compared with it.
const STAGING: usize = 32 << 20;

/// Makes a device-local buffer with the contents `data`.
pub fn buffer(device: &Arc<Device>, name: &str, usage: vk::BufferUsageFlags, data: &[u8]) -> Result<Buffer> {
    let usage = usage | vk::BufferUsageFlags::TRANSFER_DST;
    let target = Buffer::new(device, name, data.len() as u64, usage, MemoryLocation::GpuOnly)?;
    if !data.is_empty() {
        into(device, &target, data)?;
    }
    Ok(target)
}

/// Writes `data` to the start of `target`, which the device must not be using.
pub fn into(device: &Arc<Device>, target: &Buffer, data: &[u8]) -> Result<()> {
    let staging = Buffer::with_data(device, "staging", vk::BufferUsageFlags::TRANSFER_SRC, data)?;
    Commands::new(device, "upload")?.run(|record| {
        record.memory(Access::ShaderRead, Access::TransferWrite);
        record.copy_buffer(&staging, target, data.len() as u64);
        record.memory(Access::TransferWrite, Access::ShaderRead);
        record.memory(Access::TransferWrite, Access::VertexRead);
        Ok(())
    })
}

/// Makes a texture of tightly packed `data`, ready for shaders; an array if `layers` is given.
pub fn texture(
    device: &Arc<Device>,
    name: &str,
    format: vk::Format,
    size: [usize; 2],
    layers: Option<u32>,
    data: &[u8],
) -> Result<Image> {
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let size = size.map(|n| n as u32);
    let (array, layers) = (layers.is_some(), layers.unwrap_or(1));
    let image = Image::new(device, &Description { name, format, size, layers, array, usage })?;
    self::image(device, &image, layers, data)?;
    Ok(image)
}

/// Fills every layer of `image` with tightly packed `data`, layer by layer, and leaves it ready for shaders.
pub fn image(device: &Arc<Device>, image: &Image, layers: u32, data: &[u8]) -> Result<()> {
    levels(device, image, layers, &[data])
}

/// Fills an image with mip levels like [`image()`], each level with its data, the finest first.
pub fn levels(device: &Arc<Device>, image: &Image, layers: u32, data: &[&[u8]]) -> Result<()> {
    let row_bytes = |level: usize| {
        let height = (image.size()[1] >> level).max(1) as usize;
        (data[level].len() / (layers as usize * height), height)
    };
    let (widest, _) = row_bytes(0);
    let rows_at_once = (STAGING / widest).clamp(1, image.size()[1] as usize);
    let usage = vk::BufferUsageFlags::TRANSFER_SRC;
    let size = (rows_at_once * widest) as u64;
    let mut staging = Buffer::new(device, "staging", size, usage, MemoryLocation::CpuToGpu)?;
    let mut commands = Commands::new(device, "upload")?;
    commands.run(|record| {
        record.images(&[(image, Access::Nothing, Access::TransferWrite)]);
        Ok(())
    })?;
    for (level, data) in data.iter().enumerate() {
        let (row_bytes, height) = row_bytes(level);
        for (layer, texels) in data.chunks(row_bytes * height).enumerate() {
            for (part, rows) in texels.chunks(rows_at_once * row_bytes).enumerate() {
                staging.write(rows)?;
                let first_row = (part * rows_at_once) as u32;
                let rows = (rows.len() / row_bytes) as u32;
                commands.run(|record| {
                    record.copy_to_level(&staging, image, [layer as u32, level as u32], first_row, rows);
                    Ok(())
                })?;
            }
        }
    }
    commands.run(|record| {
        record.images(&[(image, Access::TransferWrite, Access::ShaderRead)]);
        Ok(())
    })
}
