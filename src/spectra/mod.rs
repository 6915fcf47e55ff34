//! Spectra of a height field for shading. All of it is on the CPU and independent of Vulkan.

pub mod amplitude;
pub mod power;
