//! From a height field to the spectra that shading reads. All of it is on the CPU and knows no Vulkan.

pub mod amplitude;
pub mod power;
