//! Layers of one window for the shader: expansion × window → spectra, audited as they are made.

pub mod audit;
pub mod cache;
pub mod coefficients;
pub mod expansion;
pub mod kernel;
pub mod layers;
pub mod pairs;
mod plan;
mod settings;
pub mod texels;
pub mod thesis;
mod transform;

pub use layers::{Layers, compute, compute_at};
pub use settings::LayerSettings;
