//! What layers are made for.

use crate::budget::WindowBudget;
use crate::spectra::amplitude::expansion::Basis;
use serde::Serialize;

/// What the layers are made for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LayerSettings {
    /// Standard deviation of the Gaussian window over the endless surface \[µm\]; infinite: one period alone, without a
    /// window.
    pub sigma: f64,
    /// Shortest wavelength that will be asked for \[µm\].
    pub shortest_wavelength: f64,
    /// Relative intensity errors that are allowed.
    pub budget: WindowBudget,
    /// Which expansion.
    pub basis: Basis,
    /// Number of terms, where the user names it.
    pub terms: Option<usize>,
    /// Most bytes that the layers may take. Not part of their key: it decides whether they are made.
    #[serde(skip)]
    pub memory_limit: usize,
    /// Most texels along a side of a layer.
    pub side_limit: usize,
}
