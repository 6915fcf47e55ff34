//! Common interface to the BRDF, independent of the method.

pub mod albedo;
mod direct;
pub mod energy_map;
pub mod hemisphere;
pub mod mean;
mod mean_answers;
mod orders;
mod seen_part;
mod spread;
pub mod tabulated;

pub use direct::DirectSum;
pub use mean_answers::{MeanFromOrders, MeanReference};
pub use orders::DiffractionOrder;

use crate::error::Result;
use crate::optics::geometry::Pair;
use crate::task::Task;
use glam::DVec3;

/// Evaluation of the BRDF f of a surface, from any thread. What an answer needs beyond its directions is computed once, for the first one, while others wait: tasks of a
/// rayon pool that ask together may wait for each other.
pub trait Brdf: Send + Sync {
    /// Returns f \[sr⁻¹\] of every pair of directions at `wavelength` \[µm\], in order; 0 below the horizon.
    ///
    /// # Errors
    /// Fails if the method has no single wavelengths, if the device is lost, or if the task is cancelled.
    fn spectral(&self, pairs: &[Pair], wavelength: f64, task: &Task) -> Result<Vec<f64>>;

    /// Returns XYZ of f \[sr⁻¹\] of every pair of directions, in order, normalised to 1/cos θ_i for a perfect mirror
    /// image of the light; 0 below the horizon.
    ///
    /// # Errors
    /// Fails if a colour needs too many wavelengths, if the device is lost, or if the task is cancelled.
    fn xyz(&self, pairs: &[Pair], task: &Task) -> Result<Vec<DVec3>>;

    /// Averages all further answers over a round Gaussian of standard deviation `deviation` of (u, v), if the method can; returns whether it
    /// does.
    fn average_over(&mut self, deviation: f64) -> bool {
        let _ = deviation;
        false
    }

    /// Returns this BRDF averaged over a round Gaussian of standard deviation `deviation` of (u, v), if the method can; both share what is computed
    /// so far.
    fn averaged_over(&self, deviation: f64) -> Option<Box<dyn Brdf>> {
        let _ = deviation;
        None
    }

    /// Returns the share of the light from `light` that all orders together send into all directions: at `wavelength` \[µm\], or the luminance
    /// of the colour. `None` if the method does not sum orders.
    ///
    /// # Errors
    /// Those of [`Brdf::spectral`] and [`Brdf::xyz`].
    fn albedo(&self, light: DVec3, wavelength: Option<f64>, task: &Task) -> Result<Option<f64>> {
        let _ = (light, wavelength, task);
        Ok(None)
    }

    /// Returns the suitable number of pairs per call: few enough for a progress bar to move.
    fn batch(&self) -> usize {
        1
    }
}

/// Returns f from f·cos θ_i; 0 below the horizon.
pub fn without_cosine(pair: &Pair, weighted: DVec3) -> DVec3 {
    if pair.above_horizon() { weighted / pair.light.z } else { DVec3::ZERO }
}
