//! `diffract`: light diffracted by a height field, as numbers and as pictures.
//!
//! Data flows one way: `surface` → `expansion` → `precompute` → `render` (with `scene` and `vk`) → picture, and
//! `optics::reference` judges it. `docs/ARCHITECTURE.md` has the floors.

#![deny(unsafe_code)]

pub mod brdf;
pub mod cache;
pub mod cli;
pub mod error;
pub mod expansion;
pub mod figure;
pub mod files;
pub mod input;
pub mod measure;
pub mod memory;
pub mod optics;
pub mod output;
pub mod picture_file;
pub mod precompute;
pub mod random;
pub mod render;
pub mod scene;
pub mod setup;
pub mod spectra;
pub mod surface;
pub mod table;
pub mod units;
pub mod viewer;
#[allow(unsafe_code, reason = "calls Vulkan; every block says why it is sound")]
pub mod vk;
