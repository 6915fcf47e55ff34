//! `diffract`: light diffracted by a height field, as numbers and as pictures.

pub mod cli;
pub mod error;
pub mod expansion;
pub mod memory;
pub mod optics;
pub mod output;
pub mod precompute;
pub mod render;
pub mod scene;
pub mod surface;
pub mod vk;
