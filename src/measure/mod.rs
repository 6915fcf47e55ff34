//! What a setting costs: frame times, samples, the device's own limit.

pub mod cost;
pub mod peaks;
pub mod profile;
