//! cli.

pub mod units;
