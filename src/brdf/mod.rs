//! One interface to the BRDF, however it is computed.

mod direct;
pub mod mean;
mod mean_answers;
mod seen_part;
mod spread;
pub mod tabulated;
mod transforms;

pub use direct::DirectSum;
pub use mean_answers::{MeanFromOrders, MeanReference};
pub use transforms::Transforms;

use crate::error::Result;
use crate::optics::geometry::Pair;
use glam::DVec3;

/// A surface whose BRDF f can be asked for.
pub trait Brdf {
    /// f \[sr⁻¹\] of every pair of directions at `wavelength` \[µm\], in order; 0 below the horizon.
    ///
    /// # Errors
    /// Where the method has no single wavelengths or the device is lost.
    fn spectral(&mut self, pairs: &[Pair], wavelength: f64) -> Result<Vec<f64>>;

    /// XYZ of f \[sr⁻¹\] of every pair of directions, in order, normalised to 1/cos θ_i for a perfect mirror image of the light; 0 below
    /// the horizon.
    ///
    /// # Errors
    /// Where a colour takes too many wavelengths or the device is lost.
    fn xyz(&mut self, pairs: &[Pair]) -> Result<Vec<DVec3>>;

    /// Pairs that are worth one call: few enough for a progress bar to move.
    fn batch(&self) -> usize {
        1
    }
}

/// f from f·cos θ_i; 0 below the horizon.
pub fn without_cosine(pair: &Pair, weighted: DVec3) -> DVec3 {
    if pair.above_horizon() { weighted / pair.light.z } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::coherence::Coherence;
    use crate::optics::geometry::direction;
    use crate::optics::reference::Reference;
    use crate::optics::spectrum::Illuminant;
    use crate::surface::HeightField;

    #[test]
    fn the_transforms_and_the_direct_sum_give_the_same_numbers_through_one_interface() {
        let heights = (0..24 * 20).map(|i| 0.15 * (f64::from(i) * 0.618_034).fract()).collect();
        let field = HeightField::new(24, 20, [0.1, 0.12], heights).unwrap();
        let reference = Reference::new(&field, Coherence::Gaussian { length: 4.0 }, [2, 1], 1.5);
        let illuminant = &Illuminant::D65;
        let mut sum = DirectSum { reference: reference.clone(), illuminant };
        let mut transforms = Transforms { reference, illuminant };
        // Enough of them that transforms are worth making; the last is below the horizon.
        let pairs: Vec<Pair> = (0..4000)
            .map(|i| {
                Pair::new(direction(30.0, 0.0), direction(80.0 * f64::from(i) / 4000.0, 0.3 * f64::from(i)))
            })
            .chain([Pair::new(direction(30.0, 0.0), direction(100.0, 0.0))])
            .collect();
        let (a, b) = (sum.spectral(&pairs, 0.55).unwrap(), transforms.spectral(&pairs, 0.55).unwrap());
        let largest = a.iter().fold(0.0f64, |m, x| m.max(*x));
        assert!(largest > 0.1 && a.last() == Some(&0.0) && b.last() == Some(&0.0));
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-6 * largest, "{apart:e} of {largest:e}");
        let some = &pairs[..3];
        let (a, b) = (sum.xyz(some).unwrap(), transforms.xyz(some).unwrap());
        assert!(a.iter().zip(&b).all(|(a, b)| (*a - *b).length() < 1e-6 * a.length().max(1e-3)));
    }
}
