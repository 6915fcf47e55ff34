//! Measurements of a setting: frame times, samples, device limits, errors.

pub mod branches;
#[cfg(feature = "vulkan")]
pub mod budget;
#[cfg(feature = "vulkan")]
pub mod error;
pub mod order_peaks;
pub mod peaks;
#[cfg(feature = "vulkan")]
pub mod profile;
pub mod sweep;
#[cfg(feature = "vulkan")]
pub mod trade;
