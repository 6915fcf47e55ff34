//! Measurements of a setting: frame times, samples, device limits, errors.

pub mod branches;
pub mod budget;
pub mod error;
pub mod peaks;
pub mod profile;
pub mod trade;
