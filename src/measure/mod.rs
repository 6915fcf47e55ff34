//! What a setting costs: frame times, samples, the device's own limit.

pub mod branches;
pub mod budget;
pub mod error;
pub mod peaks;
pub mod profile;
pub mod trade;
