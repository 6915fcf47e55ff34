//! Settings of layers.

use crate::budget::WindowBudget;
use crate::spectra::amplitude::expansion::Basis;
use serde::Serialize;

/// Settings of layers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LayerSettings {
    /// Standard deviation of the Gaussian window over the periodic surface \[µm\]; infinite: one period alone, without a window.
    pub sigma: f64,
    /// Shortest wavelength of the layers \[µm\].
    pub shortest_wavelength: f64,
    /// Relative intensity errors that are allowed.
    pub budget: WindowBudget,
    /// Basis of the expansion.
    pub basis: Basis,
    /// Number of terms, if the user names it.
    pub terms: Option<usize>,
    /// Largest size of the layers \[bytes\]. Not part of their key: the limit does not change the layers.
    #[serde(skip)]
    pub memory_limit: usize,
    /// Largest number of texels along a side of a layer.
    pub side_limit: usize,
}
