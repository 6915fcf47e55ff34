//! `diffract`: light diffracted by a height field, as numbers and as pictures.
//!
//! Start with the [`prelude`] and the programs in `examples/`. The feature `vulkan` (on by default) has the renderer, `viewer` (on by
//! default) the window; without them the library has height fields, optics, spectra, colour tables and 64-bit references.
//!
//! Data flows one way: `surface` → `spectra` → `table` → `render` (with `scene` and `vk`) → picture, and `optics::reference` checks the
//! result. `docs/ARCHITECTURE.md` lists the imports allowed to each module.

#![deny(unsafe_code)]

pub mod brdf;
pub mod budget;
pub mod cache;
#[cfg(feature = "vulkan")]
pub mod cli;
pub mod context;
pub mod error;
pub mod export;
pub mod fft_size;
pub mod figure;
pub mod files;
pub mod filter;
pub mod input;
#[cfg(feature = "vulkan")]
pub mod measure;
pub mod memory;
pub mod notes;
pub mod optics;
pub mod output;
#[cfg(feature = "vulkan")]
pub mod picture_file;
pub mod prelude;
pub mod random;
#[cfg(feature = "vulkan")]
pub mod render;
pub mod scene;
pub mod settings;
#[cfg(feature = "vulkan")]
pub mod setup;
pub mod spectra;
pub mod surface;
pub mod table;
pub mod task;
pub mod tolerance;
pub mod units;
#[cfg(feature = "viewer")]
pub mod viewer;
#[allow(unsafe_code, reason = "calls Vulkan; every block says why it is sound")]
#[cfg(feature = "vulkan")]
pub mod vk;
